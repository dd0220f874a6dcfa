"""Parts of a drawing that touch, moved apart by the kerf so that one cut goes between them.

 _______ _______          _______   _______      Across each upright edge that two parts share
|       |       |        |       | |       |     the one at its right lies a kerf farther to
|   1   |   2   |   ->   |   1   | |   2   |     the right of the other than it was drawn, across
|_______|_______|        |_______| |_______|     each level edge the upper one a kerf higher.

Where parts share a slanting edge too, all of those that touch are moved square to their edges: the
first stays, the others go as little as that takes, by the sum of squares.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from math import hypot
from typing import TYPE_CHECKING, NamedTuple

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Line, signed_area
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch
from beamcam.model.colour import key_of
from beamcam.model.part import Contour, Hole, Part, Slot, moved_feature
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import outlines

if TYPE_CHECKING:
    from shapely import Polygon

AGREES = 1e-6  #: of a kerf, by which the moves of parts may differ
SAME = 1e-4  #: mm that edges of two parts may be apart to be one
UPRIGHT = 1e-6  #: of a direction, by which an edge is upright or level
FINE = 0.01  #: mm that chords may be off, to tell what lies in a part


def spread(part: Part, torch: Torch, kerf: float) -> tuple[Part, list[Diagnostic]]:
    """The drawing with the parts that share edges moved apart by the kerf, and a note on it.

    As it is drawn where they share curves, or where the moves of some contradict one another.
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
    places = [(0.0, 0.0)] * len(outer)
    for group in _groups(len(outer), shared):
        moves = _moves(group, [one for one in shared if one.before in group])
        if moves is None:
            return part, []
        for number, (x, y) in moves.items():
            places[number] = kerf * x, kerf * y
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


class _Shared(NamedTuple):
    """An edge that two contours share."""

    before: int  #: the contour at its left, or below it
    behind: int
    across: Point | None  #: direction from the one to the other; None of a curve

    @property
    def axis(self) -> int:
        """0 of an upright edge, 1 of a level one, -1 of any other."""
        return {(1.0, 0.0): 0, (0.0, 1.0): 1}.get(self.across or (0.0, 0.0), -1)


def _groups(count: int, shared: Sequence[_Shared]) -> list[list[int]]:
    """The contours that touch one another, directly or by others."""
    of = list(range(count))
    for one in shared:
        a, b = of[one.before], of[one.behind]
        of = [min(a, b) if k in (a, b) else k for k in of]
    return [[n for n in range(count) if of[n] == k] for k in sorted(set(of))]


def _moves(group: Sequence[int], shared: Sequence[_Shared]) -> dict[int, Point] | None:
    """How many kerfs each part of a group is moved; None where edges contradict one another."""
    if any(one.axis < 0 for one in shared):
        return _least_moves(group, shared)
    number = {n: k for k, n in enumerate(group)}
    x, y = (
        _steps(
            len(group),
            [(number[e.before], number[e.behind]) for e in shared if e.axis == axis],
        )
        for axis in (0, 1)
    )
    if x is None or y is None:
        return None
    return {n: (float(x[k]), float(y[k])) for n, k in number.items()}


def _least_moves(group: Sequence[int], shared: Sequence[_Shared]) -> dict[int, Point] | None:
    """The moves of least squares, the first part resting, that part all edges by one kerf."""
    import numpy as np

    columns = {n: 2 * k for k, n in enumerate(group[1:])}
    rows = np.zeros((len(shared), 2 * len(columns)))
    for row, one in zip(rows, shared, strict=True):
        if one.across is None:
            return None
        for number, sign in ((one.before, -1.0), (one.behind, 1.0)):
            if number in columns:
                row[columns[number] : columns[number] + 2] += sign * np.array(one.across)
    found = np.linalg.lstsq(rows, np.ones(len(shared)), rcond=None)[0]
    if np.abs(rows @ found - 1.0).max() > AGREES:
        return None
    moves = {n: (float(found[k]), float(found[k + 1])) for n, k in columns.items()}
    return {group[0]: (0.0, 0.0), **moves}


def _contour(part: Part, number: int) -> Contour:
    contour = part.features[number]
    assert isinstance(contour, Contour)
    return contour


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


def _shared(contours: Sequence[Contour]) -> Iterator[_Shared]:
    """The edges that two contours share, one on each side of them."""
    from beamcam.geometry.arrays import CurveTable, overlapping

    curves = [curve for contour in contours for curve in contour.curves]
    owners = [k for k, contour in enumerate(contours) for _ in contour.curves]
    outwards = [1.0 if signed_area(contour.curves) > 0.0 else -1.0 for contour in contours]
    for a, b in overlapping(CurveTable(curves), ["cut"] * len(curves)):
        one, other = curves[a], curves[b]
        if owners[a] == owners[b]:
            continue
        if not (isinstance(one, Line) and isinstance(other, Line)):
            yield _Shared(owners[a], owners[b], None)
            continue
        x, y = _out(one, outwards[owners[a]])
        u, v = _out(other, outwards[owners[b]])
        (px, py), (qx, qy) = one.start, other.start
        if x * u + y * v > 0.0 or abs((qx - px) * x + (qy - py) * y) > SAME:
            continue
        before, behind = owners[a], owners[b]
        if x < -UPRIGHT or (abs(x) <= UPRIGHT and y < 0.0):
            before, behind, x, y = behind, before, -x, -y
        if min(abs(x), abs(y)) <= UPRIGHT:
            x, y = (1.0, 0.0) if x > 0.5 else (0.0, 1.0)
        yield _Shared(before, behind, (x, y))


def _out(line: Line, side: float) -> Point:
    """The direction in which a part ends at an edge; `side` is 1 if it runs counter-clockwise."""
    (x0, y0), (x1, y1) = line.start, line.end
    size = hypot(x1 - x0, y1 - y0) or 1.0
    return side * (y1 - y0) / size, side * (x0 - x1) / size


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
