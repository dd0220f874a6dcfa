"""Contours of a sheet: assigned to processes, joined, nested, compensated, with leads, ordered."""
