"""Readers: a file's bytes in, parts and diagnostics out. One module a format.

A reader is `read(data, name) -> Reading`; it opens no file, prints nothing and never raises for
bad input. `looks_like(data)` tells by the content whether the bytes are of its format.
"""
