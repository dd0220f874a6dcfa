"""The arcs that controllers make of start, end and centre."""

from math import atan2, degrees, dist

from beamcam.geometry.curves import Arc
from beamcam.geometry.plane import Point


def sweep_of(start: Point, end: Point, centre: Point, clockwise: bool) -> float:
    """The angle that an arc turns through, negative if clockwise; 360 where start is end."""
    if start == end:
        return -360.0 if clockwise else 360.0
    (x0, y0), (x1, y1), (cx, cy) = start, end, centre
    turn = degrees(atan2(y1 - cy, x1 - cx) - atan2(y0 - cy, x0 - cx)) % 360.0
    return turn - 360.0 if clockwise else turn or 360.0


def arc_of(start: Point, end: Point, centre: Point, clockwise: bool) -> Arc:
    """The arc that a controller makes of its numbers; from a point to itself it is a circle."""
    x, y = start[0] - centre[0], start[1] - centre[1]
    sweep = sweep_of(start, end, centre, clockwise)
    return Arc(centre, dist(start, centre), degrees(atan2(y, x)), sweep)
