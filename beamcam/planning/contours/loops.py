"""Contours that pass a place again, taken apart where waste hangs together by that point only.

 _________
|   ___   |   The window touches the edge of the plate at o, and both are drawn as one contour:
|  |   |  |   two regions of waste, each cut by itself. Where it is the part that hangs together
|  |   |  |   by a point, the contour stays whole, as nothing says that it is two parts.
|__o___|__|
"""

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.arrays import near_pairs
from beamcam.geometry.curves import Curve, Line, signed_area
from beamcam.geometry.plane import distance
from beamcam.model.lengths import total_length
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import Shape, outlines
from beamcam.planning.contours.running_back import FINE, runs_back

SAME_PLACE = 1e-4  #: mm, of a place that is passed again: what is nearer is written alike
SAME_POINT = 1e-9  #: of ends that need no joining


def taken_apart(
    shapes: Sequence[Shape], which: Sequence[int], tolerance: float
) -> tuple[list[Shape], list[Diagnostic]]:
    """The shapes, some of them as the contours of the waste that hangs together there by points.

    And an error for each of these that is followed there and back: it goes round nothing that is
    wider than half the machine's tolerance.
    """
    apart: list[Shape] = []
    flat: list[Diagnostic] = []
    numbers = set(which)
    for k, shape in enumerate(shapes):
        rings = list(_rings(shape, tolerance)) if k in numbers else [shape.curves]
        apart += [replace(shape, curves=ring) for ring in rings] if len(rings) > 1 else [shape]
        for ring in rings if len(rings) > 1 else ():
            if _is_flat(ring, tolerance):
                start = ring[0].start
                end = max((curve.end for curve in ring), key=lambda at: distance(at, start))
                length = total_length(ring) / 2
                flat.append(runs_back(rules.RUNS_BACK_KERF, shape.source, length, end))
    return apart, flat


def _rings(shape: Shape, tolerance: float) -> Iterator[tuple[Curve, ...]]:
    """The contours that one falls into."""
    # For each curve the first one that begins where it does.
    places = list(range(len(shape.curves)))
    pairs = near_pairs(np.array([curve.start for curve in shape.curves]), SAME_PLACE)
    for a, b in sorted(zip(*(some.tolist() for some in pairs), strict=True)):
        places[max(a, b)] = places[min(a, b)]
    again = {place for place, count in Counter(places).items() if count > 1}
    if not again:
        yield shape.curves
        return
    begin = next(k for k, place in enumerate(places) if place in again)
    order = [*range(begin, len(places)), *range(begin)]
    around = [shape.curves[k] for k in order]
    passed = [places[k] for k in order]
    kept: list[int] = []
    for k, place in enumerate((*passed, passed[0])):
        while place in again:
            # Where the contour ends, what begins there is all that is left of it.
            first = 0 if k < len(around) else 1
            at = max((n for n in range(first, len(kept)) if passed[kept[n]] == place), default=None)
            if at is None:
                break
            loop = _closed([around[n] for n in kept[at:]])
            if not _is_flat(loop, tolerance):
                # It stays where it goes round no waste by itself.
                rest = [around[n] for n in (*kept[:at], *range(k, len(around)))]
                inner, outer = shapely.make_valid(outlines([loop, rest], FINE))
                if bool(shapely.point_on_surface(inner).within(outer)) == shape.is_hole:
                    break
            yield loop
            del kept[at:]
        if k < len(around):
            kept.append(k)
    yield _closed([around[n] for n in kept])


def _closed(ring: Sequence[Curve]) -> tuple[Curve, ...]:
    """A chain whose ends are written alike, closed."""
    a, b = ring[-1].end, ring[0].start
    return tuple(ring) if distance(a, b) <= SAME_POINT else (*ring, Line(a, b))


def _is_flat(loop: tuple[Curve, ...], tolerance: float) -> bool:
    return abs(signed_area(loop)) <= tolerance / 4 * total_length(loop)
