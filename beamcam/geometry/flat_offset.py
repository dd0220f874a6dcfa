"""Closed chains moved outwards or inwards as polygons, and their arcs found again.

It replaces the exact form where parts of a moved chain run into each other.
"""

from math import degrees, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamcam.geometry.curves import Curve, Line, signed_area
from beamcam.geometry.refit import refit_ring
from beamcam.geometry.sampling import points_at


def flat_offset(
    curves: tuple[Curve, ...], amount: float, tolerance: float
) -> tuple[tuple[Curve, ...], ...]:
    """The rings of a chain moved by `amount` mm, outwards if above 0; none if it vanishes.

    They are lines and arcs within `tolerance`, and run as the chain does, holes the other way.
    Corners that open are rounded: a mitre would close places where there is room.
    """

    ring = np.concatenate([_flat(curve, tolerance / 8) for curve in curves])
    quarter = max(8, int(90 / max(1.0, degrees(2 * sqrt(tolerance / 4 / abs(amount))))))
    moved = _moved(ring, amount, quarter, tolerance)
    parts = [p for p in getattr(moved, "geoms", [moved]) if p.area > tolerance * tolerance]
    turned = signed_area(curves) < 0
    chains = []
    for part in parts:
        for place, loop in enumerate((part.exterior, *part.interiors)):
            points = [(float(x), float(y)) for x, y in loop.coords[:-1]]
            fitted = refit_ring(points, tolerance / 4)
            backwards = (signed_area(fitted) < 0) != (turned != (place > 0))
            chains.append(tuple(c.reversed() for c in reversed(fitted)) if backwards else fitted)
    return tuple(chains)


def _moved(ring: NDArray[np.float64], amount: float, quarter: int, tolerance: float) -> Any:
    """The inside of a ring moved by `amount` mm, with so many chords to a quarter of a circle.

    In a corner that closes, made of sides much shorter than the amount, GEOS leaves out where the
    long sides beside them meet, and may be off by a sixth of the amount. Then every side is moved
    by itself.
    """
    import shapely

    inside = shapely.make_valid(shapely.Polygon(ring))
    moved = inside.buffer(amount, quad_segs=quarter)
    edge = shapely.linearrings(ring)
    shapely.prepare(edge)
    places = shapely.get_coordinates(shapely.segmentize(moved.boundary, abs(amount) / 4))
    if shapely.dwithin(edge, shapely.points(places), abs(amount) + tolerance).all():
        return moved
    corners = shapely.get_coordinates(edge)
    sides = shapely.linestrings(np.stack((corners[:-1], corners[1:]), axis=1))
    band = shapely.union_all(shapely.buffer(sides, abs(amount), quad_segs=quarter))
    whole = inside.buffer(0.0)  # without lines
    return whole.union(band) if amount > 0.0 else whole.difference(band)


def _flat(curve: Curve, tolerance: float) -> NDArray[np.float64]:
    """Points of a curve without its end; chords within `tolerance`, measured by doubling."""
    count = 1
    if not isinstance(curve, Line):
        count = 8
        while count < 4096:
            fine = points_at(curve, np.linspace(0.0, 1.0, 2 * count + 1))
            sag = fine[1::2] - (fine[:-1:2] + fine[2::2]) / 2
            if np.max(np.hypot(sag[:, 0], sag[:, 1])) <= tolerance:
                break
            count *= 2
    return points_at(curve, np.linspace(0.0, 1.0, count + 1))[:-1]
