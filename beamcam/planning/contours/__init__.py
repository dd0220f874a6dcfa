"""Contours of a sheet: what each is for, joined, nested, compensated, led into and ordered."""
