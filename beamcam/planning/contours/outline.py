"""Contours as polygons and polylines, for questions that need no exact curve."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from beamcam.geometry.curves import Curve

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from beamcam.geometry.array_types import Floats


#: Points of chains, and the chain of each.
Drawn = tuple["Floats", "NDArray[np.int64]"]


def outlines(chains: Sequence[Sequence[Curve]], tolerance: float) -> "NDArray[Any]":
    """The polygon of each closed chain, an array of shapely polygons."""
    return rings_of(*points_of(chains, tolerance), len(chains))


def rings_of(points: "Floats", owner: "NDArray[np.int64]", count: int) -> "NDArray[Any]":
    """Polygons by their points, of which each has the number of its polygon, below `count`."""
    import numpy as np
    import shapely

    # A ring needs four points: chains of two curves that flatten to chords get their ends again.
    counts = np.bincount(owner, minlength=count)
    short = np.flatnonzero(counts < 4)
    if len(short):
        more = np.repeat(short, 4 - counts[short])
        last = np.cumsum(counts) - 1
        owner = np.concatenate((owner, more))
        points = np.concatenate((points, points[last[more]]))
        order = np.argsort(owner, kind="stable")
        points, owner = points[order], owner[order]
    found: NDArray[Any] = shapely.polygons(shapely.linearrings(points, indices=owner))
    return found


def ways(chains: Sequence[Sequence[Curve]], tolerance: float) -> "NDArray[Any]":
    """The polyline of each chain, an array of shapely lines."""
    import shapely

    points, owner = points_of(chains, tolerance)
    found: NDArray[Any] = shapely.linestrings(points, indices=owner)
    return found


def signed_areas(rings: "NDArray[Any]") -> "Floats":
    """The areas of polygons, above 0 for those that run counter-clockwise.

    By the corners about the first one of each: asked which way a ring runs, GEOS looks at its
    highest corner only, and is wrong where that is double but for the last digit.
    """
    import numpy as np
    import shapely

    points, owner = shapely.get_coordinates(rings, return_index=True)
    counts = np.bincount(owner, minlength=len(rings))
    points -= points[np.repeat(np.cumsum(counts) - counts, counts)]
    (x0, y0), (x1, y1) = points[:-1].T, points[1:].T
    # From the last corner of a ring to the first of the next one, which is its own 0, 0.
    return np.bincount(owner[:-1], (x0 * y1 - x1 * y0) / 2, len(rings)).astype(np.float64)


def invalid(rings: "NDArray[Any]") -> list[int]:
    """The numbers of the rings that meet themselves, ascending."""
    import numpy as np
    import shapely

    return np.flatnonzero(~shapely.is_valid(rings)).tolist()


def valid(rings: "NDArray[Any]", bad: Sequence[int]) -> "NDArray[Any]":
    """The rings, those that are `bad` taken apart."""
    import shapely

    if not bad:
        return rings
    found = rings.copy()
    found[bad] = shapely.make_valid(rings[bad])
    return found


def points_of(chains: Sequence[Sequence[Curve]], tolerance: float) -> Drawn:
    """Points of all chains, and the chain of each."""
    import numpy as np

    from beamcam.geometry.polylines import polylines

    drawn = polylines([curve for chain in chains for curve in chain], tolerance)
    chain_of = np.repeat(np.arange(len(chains)), [len(chain) for chain in chains])
    return drawn.points, np.repeat(chain_of, np.diff(drawn.begins))
