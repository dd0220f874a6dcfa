"""Parts and programs as solids: a third opinion beside the planner and the read-back.

A part's solid comes from its section and its features; a piece's from the events of a program.
Coordinates are DSTV's section axes: X along the part, Y up its height from the u edge, Z across
from the h side, right-handed, in mm. A mirrored part is another solid.
"""
