"""Holes and contours as polygons: of many chords, or of those that a mesh has.

A mesh stands on the arcs of what it was made of, so that a polygon through its own corners is what
it has of a hole, to the last chord.
"""

import itertools
from collections.abc import Sequence
from math import atan2, ceil, cos, degrees, hypot, pi, radians, sin

from beamcam.geometry.curves import Arc, Curve, Point
from beamcam.model.part import Hole, Slot
from beamcam.readers.ifc.curves2d import Chain, with_sides
from beamcam.readers.ifc.region import Circles, Shape, points_of

ON_ARC = 0.02  #: mm that a corner of a mesh may lie off the arc that it stands for
WIDEST_FACET_RAD = 0.6  #: of a polygon that stands for a circle
ARC_STEP_RAD = 0.05


def polygon(chain: Chain, corners: Sequence[Point] | None) -> Shape:
    """The region inside a chain, its arcs made of many chords or of those between `corners`."""
    from shapely import Polygon

    if corners is None:
        points = points_of(chain, Circles())
    else:
        points = [p for curve in chain for p in _chords(curve, corners)]
    found = Polygon(points)
    return found if found.is_valid else found.buffer(0)


def _chords(curve: Curve, corners: Sequence[Point]) -> list[Point]:
    """The start of a curve, and the corners of a mesh on it in their order.

    Where corners are further apart than facets are, as behind a fillet, the arc itself stands.
    """
    if not isinstance(curve, Arc):
        return points_of((curve,), Circles())
    (cx, cy), r = curve.centre, curve.radius
    whole = abs(curve.sweep_deg) > 359.0
    on: dict[float, Point] = {} if whole else {0.0: curve.start, 1.0: curve.end}
    for x, y in corners:
        if abs(hypot(x - cx, y - cy) - r) < ON_ARC:
            turn = degrees(atan2(y - cy, x - cx)) - curve.start_deg
            share = (turn % 360.0 if curve.sweep_deg > 0 else -(-turn % 360.0)) / curve.sweep_deg
            if whole or 1e-6 < share < 1 - 1e-6:
                on[round(share, 6) % (1.0 if whole else 2.0)] = (x, y)
    shares = sorted(on)
    if len(shares) < 3 and whole:
        return points_of((curve,), Circles())
    out: list[Point] = []
    for here, there in itertools.pairwise([*shares, shares[0] + 1.0] if whole else shares):
        out.append(on[here])
        gap = radians(abs(curve.sweep_deg)) * (there - here)
        if gap > WIDEST_FACET_RAD:
            steps = ceil(gap / ARC_STEP_RAD)
            out += [curve.point((here + (there - here) * i / steps) % 1.0) for i in range(1, steps)]
    return out


def outline_of(f: Hole | Slot) -> Chain:
    """The closed outline of a hole or a slot."""
    r = f.diameter / 2
    if isinstance(f, Hole):
        return (Arc((f.x, f.y), r, 0.0, 360.0),)
    turn = radians(f.angle)
    ux, uy = cos(turn), sin(turn)
    a, b = f.length / 2, f.height / 2
    arcs = [
        Arc(
            (f.x + s * a * ux - t * b * uy, f.y + s * a * uy + t * b * ux), r, f.angle + start, 90.0
        )
        for s, t, start in ((1, -1, -90.0), (1, 1, 0.0), (-1, 1, 90.0), (-1, -1, 180.0))
    ]
    return with_sides(arcs)


def area_of(f: Hole | Slot) -> float:
    area = pi * f.diameter * f.diameter / 4
    if isinstance(f, Slot):
        area += f.diameter * (f.length + f.height) + f.length * f.height
    return area
