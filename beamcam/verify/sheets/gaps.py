"""Gap between ends that should meet."""

import numpy as np

from beamcam.geometry.array_types import Floats


def widest_gap(points: Floats, reach: float) -> float:
    """The greatest distance of two points (n, 2) that are no farther than `reach` from each other.

    0 if there are none. Points are sorted into square cells as wide as the reach, column by column,
    so that those which may be near one stand together:

        . n n      a point looks at those behind it in its own cell and in the one above,
        . a n      and at three cells of the next column
        . . n
    """
    if reach <= 0.0:
        return 0.0
    places = np.sort(np.ascontiguousarray(points).view(np.complex128).ravel())
    places = places[np.diff(places, prepend=np.nan) != 0.0]
    # No finer than the last digits of the places, which a tiny reach would be divided by.
    width = max(reach, float(np.abs(points).max(initial=0.0)) * 1e-12)
    cells = np.floor(places.real / width) + 1j * np.floor(places.imag / width)
    order = np.argsort(cells, kind="stable")
    places, cells = places[order], cells[order]
    behind = np.arange(1, len(places) + 1)
    above = np.searchsorted(cells, cells + 1j, "right")
    next_low = np.searchsorted(cells, cells + (1 - 1j))
    next_high = np.searchsorted(cells, cells + (1 + 1j), "right")
    widest = 0.0
    for first, last in ((behind, above), (next_low, next_high)):
        # The first neighbour of every point, then the second, until none has any left.
        while len(left := np.flatnonzero(first < last)):
            apart = np.abs(places[first[left]] - places[left])
            widest = max(widest, float(apart[apart <= reach].max(initial=0.0)))
            first[left] += 1
    return widest
