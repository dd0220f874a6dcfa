"""Arcs of a section as the solid has them, not as a circle laid through its facets.

The corners of a solid's facets lie on its surfaces, so that a chord both of whose ends are on a
cylinder is that cylinder's arc.
"""

from collections.abc import Sequence
from math import atan2, degrees, hypot, pi

from beamcam.geometry.curves import Arc, Curve, Line, Point
from beamcam.readers.ifc.brep import Cylinder
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.outline import joined
from beamcam.readers.ifc.space import Vec, dot

SAME = 1e-6  #: mm between equal circles, and between a circle and a corner that is on it
UPRIGHT = 1e-9  #: by which the axis of a circle's cylinder may be off the plane's normal, squared
FACET_RAD = 0.5  #: that a facet spans at most, twice the angle that the kernel is asked for

Circle = tuple[Point, float]


def circles_in(cylinders: Sequence[Cylinder], normal: Vec, u: Vec, v: Vec) -> tuple[Circle, ...]:
    """Centre (in u and v) and radius of the cylinders that run along a normal, each once."""
    found: list[Circle] = []
    for one in cylinders:
        if 1.0 - dot(one.axis, normal) ** 2 > UPRIGHT:
            continue
        x, y = dot(one.frame.o, u), dot(one.frame.o, v)
        if not any(
            abs(r - one.radius) < SAME and hypot(x - p, y - q) < SAME for (p, q), r in found
        ):
            found.append(((x, y), one.radius))
    return tuple(found)


def with_exact_arcs(chain: Chain, circles: Sequence[Circle]) -> Chain:
    """The chain with each facet of a known circle as the circle's arc, its corners kept."""
    return joined(tuple(_exact(curve, circles) for curve in chain)) if circles else chain


def _exact(curve: Curve, circles: Sequence[Circle]) -> Curve:
    if not isinstance(curve, Line):
        return curve
    for centre, radius in circles:
        start, end = _angle(centre, radius, curve.start), _angle(centre, radius, curve.end)
        if start is None or end is None:
            continue
        turn = (end - start + pi) % (2 * pi) - pi
        if 0.0 < abs(turn) < FACET_RAD:
            return Arc(centre, radius, degrees(start), degrees(turn))
    return curve


def _angle(centre: Point, radius: float, p: Point) -> float | None:
    """The angle in radians at which a point is on a circle; None where it is not."""
    x, y = p[0] - centre[0], p[1] - centre[1]
    return atan2(y, x) if abs(hypot(x, y) - radius) < SAME else None
