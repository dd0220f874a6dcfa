"""Closed chains moved outwards or inwards as polygons, and their arcs found again.

It replaces the exact form where parts of a moved chain run into each other.
"""

from math import degrees, sqrt

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
    import shapely

    ring = np.concatenate([_flat(curve, tolerance / 8) for curve in curves])
    polygon = shapely.make_valid(shapely.Polygon(ring))
    quarter = max(8, int(90 / max(1.0, degrees(2 * sqrt(tolerance / 4 / abs(amount))))))
    moved = polygon.buffer(amount, quad_segs=quarter)
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
