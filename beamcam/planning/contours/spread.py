"""Parts of a drawing that touch, moved apart by the kerf so that one cut goes between them.

 _______ _______          _______   _______      Across each upright edge that two parts share
|       |       |        |       | |       |     the one at its right lies a kerf farther to
|   1   |   2   |   ->   |   1   | |   2   |     the right of the other than it was drawn, across
|_______|_______|        |_______| |_______|     each level edge the upper one a kerf higher.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Line, signed_area
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch
from beamcam.model.colour import key_of
from beamcam.model.moved import moved_feature
from beamcam.model.part import Contour, Hole, Part, Slot
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import outlines

if TYPE_CHECKING:
    from shapely import Polygon

SAME = 1e-4  #: mm that edges of two parts may be apart, and turned, to be one
FINE = 0.01  #: mm that chords may be off, to tell what lies in a part


def spread(part: Part, torch: Torch, kerf: float) -> tuple[Part, list[Diagnostic]]:
    """The drawing with the parts that share edges moved apart by the kerf, and a note on it.

    As it is drawn where they share edges that are neither upright nor level, or where the moves
    of some of them contradict one another.
    """
    if not torch.common_cuts or not kerf or part.measures is None:
        return part, []
    rings = [k for k, f in enumerate(part.features) if _is_ring(f, torch)]
    whole = [_contour(part, k).curves for k in rings]
    polygons = list(outlines(whole, FINE)) if whole else []
    outer = [
        n for n, ring in enumerate(polygons)
        if not any(_lies_in(ring, other) for m, other in enumerate(polygons) if m != n)
    ]  # fmt: skip
    shared = list(_shared([_contour(part, rings[n]) for n in outer]))
    if not shared:
        return part, []
    steps = [_steps(len(outer), [one[1:] for one in shared if one[0] == axis]) for axis in (0, 1)]
    if any(one[0] < 0 for one in shared) or None in steps:
        return part, []
    places = [(kerf * x, kerf * y) for x, y in zip(*steps, strict=True)]
    features = list(part.features)
    for k, feature in enumerate(features):
        own = [n for n, o in enumerate(outer) if k == rings[o]]
        at = _place_of(feature)
        home = own or [n for n, o in enumerate(outer) if _holds(polygons[o], at)]
        if home and places[home[0]] != (0.0, 0.0):
            features[k] = moved_feature(feature, places[home[0]])
    count = sum(place != (0.0, 0.0) for place in places)
    note = rules.APART.at(part.source, count=count, kerf=f"{kerf:g}")
    return replace(part, features=tuple(features)), [note]


def _contour(part: Part, number: int) -> Contour:
    found = part.features[number]
    assert isinstance(found, Contour)
    return found


def _is_ring(feature: object, torch: Torch) -> bool:
    """Whether a feature is a closed contour to cut."""
    if not isinstance(feature, Contour) or feature.curves[0].start != feature.curves[-1].end:
        return False
    key = key_of(feature, torch.colours)
    return key is not None and torch.colours[key] == "cut"


def _lies_in(ring: "Polygon", other: "Polygon") -> bool:
    return ring.area < other.area and bool(other.covers(ring.representative_point()))


def _place_of(feature: object) -> Point | None:
    if isinstance(feature, Contour):
        return feature.curves[0].point(0.5)
    if isinstance(feature, Hole | Slot):
        return feature.x, feature.y
    return None


def _holds(polygon: "Polygon", place: Point | None) -> bool:
    import shapely

    return place is not None and bool(shapely.covers(polygon, shapely.Point(place)))


def _shared(contours: Sequence[Contour]) -> Iterator[tuple[int, int, int]]:
    """The edges that two contours share: which axis they lie across, and the contours.

    Axis 0 is that of upright edges, the contour at their left first; 1 of level ones, that below
    them first; -1 says that an edge is neither.
    """
    lines: dict[tuple[int, float], list[tuple[float, float, int, bool]]] = defaultdict(list)
    slanting: dict[frozenset[Point], int] = {}
    for number, contour in enumerate(contours):
        turned = (
            signed_area(contour.curves) > 0.0
        )  # counter-clockwise: the part lies at the left of its edges
        for curve in contour.curves:
            (x0, y0), (x1, y1) = curve.start, curve.end
            if isinstance(curve, Line) and abs(x1 - x0) <= SAME:
                above = (y1 > y0) == turned  # the part lies at the left of the edge
                lines[0, round(x0 / SAME)].append((min(y0, y1), max(y0, y1), number, above))
            elif isinstance(curve, Line) and abs(y1 - y0) <= SAME:
                below = (x1 < x0) == turned
                lines[1, round(y0 / SAME)].append((min(x0, x1), max(x0, x1), number, below))
            else:
                places = (curve.start, curve.end)
                ends = frozenset((round(x / SAME), round(y / SAME)) for x, y in places)
                other = slanting.setdefault(ends, number)
                if other != number:
                    yield -1, other, number
    for (axis, _), some in lines.items():
        for low, high, number, is_before in some:
            for a, b, other, other_before in some:
                if is_before and not other_before and min(high, b) - max(low, a) > SAME:
                    yield axis, number, other


def _steps(count: int, edges: Sequence[tuple[int, int]]) -> list[int] | None:
    """How many kerfs each part is moved along an axis; None where edges contradict one another.

    Of parts that touch, directly or by others, the first is not moved back: the least of them is 0.
    """
    beside: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for before, behind in edges:
        beside[before].append((behind, 1))
        beside[behind].append((before, -1))
    found: dict[int, int] = {}
    for first in range(count):
        if first in found:
            continue
        group, waiting = {first: 0}, [first]
        while waiting:
            here = waiting.pop()
            for there, step in beside[here]:
                if there not in group:
                    group[there] = group[here] + step
                    waiting.append(there)
                elif group[there] != group[here] + step:
                    return None
        least = min(group.values())
        found |= {k: step - least for k, step in group.items()}
    return [found[k] for k in range(count)]
