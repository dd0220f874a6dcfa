"""Emitters: programs and tables as text."""
