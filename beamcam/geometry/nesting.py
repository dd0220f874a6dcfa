"""Which closed chain lies in which: sheets, holes in them, islands in the holes."""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.geometry.curves import Curve, Line, join_boxes, signed_area
from beamcam.geometry.sampling import points_at

Floats = NDArray[np.float64]

#: Points of a curve that stand for it where insides are told from outsides.
POINTS_A_CURVE = 256


class Nested(Struct, frozen=True):
    """The place of one chain."""

    depth: int  #: 0 outside of all; odd depths are holes
    parent: int | None  #: the smallest chain around it


def nest_chains(chains: Sequence[tuple[Curve, ...]]) -> tuple[Nested, ...]:
    """The containment tree of closed chains that do not cross, one `Nested` for each.

    A chain lies in another if that has the larger area and holds most of nine of its points.
    """
    boxes = [join_boxes([c.bbox for c in chain]) for chain in chains]
    areas = [abs(signed_area(chain)) for chain in chains]
    polygons: dict[int, Floats] = {}
    found: list[Nested] = [Nested(0, None)] * len(chains)
    # Larger ones first: a parent's depth is known before its children's.
    order = sorted(range(len(chains)), key=lambda k: (-areas[k], k))
    for rank, k in enumerate(order):
        probes: Floats | None = None
        for outer in reversed(order[:rank]):
            if not _box_inside(boxes[k], boxes[outer]):
                continue
            if probes is None:
                probes = _probes(chains[k])
            if outer not in polygons:
                polygons[outer] = polygon_of(chains[outer])
            if np.count_nonzero(points_inside(probes, polygons[outer])) * 2 > len(probes):
                found[k] = Nested(found[outer].depth + 1, outer)
                break
    return tuple(found)


def _box_inside(
    a: tuple[float, float, float, float] | None, b: tuple[float, float, float, float] | None
) -> bool:
    if a is None or b is None:
        return False
    slack = 1e-9 * (abs(b[2] - b[0]) + abs(b[3] - b[1]))
    return (
        b[0] - slack <= a[0]
        and b[1] - slack <= a[1]
        and a[2] <= b[2] + slack
        and a[3] <= b[3] + slack
    )


def _probes(chain: tuple[Curve, ...]) -> Floats:
    at = np.linspace(0.05, 0.95, 9)
    parts = [points_at(curve, at) for curve in chain]
    points = np.concatenate(parts)
    chosen: Floats = points[np.linspace(0, len(points) - 1, 9).astype(int)]
    return chosen


def polygon_of(chain: tuple[Curve, ...], points_a_curve: int = POINTS_A_CURVE) -> Floats:
    """Corners of a polygon through points of the curves, array (n, 2), not closed."""
    share = np.linspace(0.0, 1.0, points_a_curve + 1)[:-1]
    parts = [
        np.array([c.start], dtype=np.float64) if isinstance(c, Line) else points_at(c, share)
        for c in chain
    ]
    return np.concatenate(parts)


def points_inside(points: Floats, polygon: Floats) -> NDArray[np.bool_]:
    """Which of `points` (n, 2) lie in a polygon (m, 2): a ray to the right meets its sides an
    odd number of times."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    meets = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / rise
    return np.asarray(np.count_nonzero(spans & (x < meets), axis=1) % 2 == 1)
