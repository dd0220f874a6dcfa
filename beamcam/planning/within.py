"""What takes no steel: openings within a larger one of their face, and planes beyond an end.

 _________________     A drill in the larger opening would run in air, and a torch would fire into
|    _________    |    what falls out of it. Nothing is missing from the part without the smaller
|   |  o      |   |    one; but a number of the file is most often wrong: it gets a warning, and it
|   |_________|   |    has a row on the list of manual work.
|_________________|
"""

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Sequence
from math import cos, hypot, pi, radians, sin
from operator import attrgetter
from typing import Any

from msgspec import Struct

from beamcam.errors import Diagnostic, note, warning
from beamcam.geometry.curves import signed_area
from beamcam.geometry.plane import Box, join_boxes
from beamcam.model.description import description
from beamcam.model.part import Contour, EndPlane, Face, Hole, Part, Slot

WITHIN = warning("plan-within",
    "found {what}, which lies wholly within the {other} of {first} and takes no steel; it is not "
    "made",
    "A hole in a hole is most often a wrong place or diameter. The larger opening is made, the "
    "other one has a row on the list of manual work.")  # fmt: skip
OVERLAP = note("plan-opening-overlap",
    "found {what} that overlaps the {other} of {first}; they are cut as one opening",
    "So a keyhole is drawn, or one of the places is wrong.")  # fmt: skip
KINDS = ("through", "blind", "countersink")  #: of holes and slots; all but marks and threads
OVER = 0.05  #: mm that one opening may reach over the other; so much an outline may be off
SMALLER = 1.0  #: mm2 that it is smaller by; two that are as large are one, drawn twice
CHORD = 0.01  #: mm between an outline and its chords
CELL = 100.0  #: mm, in which openings are looked up by their places
MOST_CELLS = 200  #: along a side; a larger opening is in no sheet


class _Opening(Struct, frozen=True, gc=False):
    """A hole, slot or cut-out with its box; a disc goes round the rectangle of a slot."""

    feature: Hole | Slot | Contour
    box: Box
    area: float
    index: int  #: of the feature; -1 of one that is there
    reaches_through: bool


_area = attrgetter("area")


def within_larger(part: Part) -> dict[int, Diagnostic]:
    """By their indices the openings that lie in larger ones that go through, and a warning each."""
    warnings: dict[int, Diagnostic] = {}
    for small, large in _pairs([*_openings(part)]):
        if small.index in warnings or not _lies_in(small, large):
            continue
        one, other = small.feature, large.feature
        warnings[small.index] = WITHIN.at(
            one.source, what=description(one), other=description(other), first=other.source
        )
    return warnings


def overlapping(part: Part, within: Collection[int]) -> Iterator[Diagnostic]:
    """A note for each opening that overlaps an earlier one and lies in none, as `within` do."""
    import shapely

    own = [one for one in _openings(part) if one.index >= 0 and one.index not in within]
    for face in {one.feature.face: 0 for one in own}:
        here = [one for one in own if one.feature.face == face]
        shapes = [_polygon(one.feature) for one in here]
        first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
        for a, b in zip(first.tolist(), second.tolist(), strict=True):
            if a < b and shapes[a].intersection(shapes[b]).area > SMALLER:
                yield OVERLAP.at(
                    here[b].feature.source, what=description(here[b].feature),
                    other=description(here[a].feature), first=here[a].feature.source,
                )  # fmt: skip


def _openings(part: Part) -> Iterator[_Opening]:
    """The openings of a part, those too that are there. One round another part is none here."""
    own = [(k, one) for k, one in enumerate(part.features)]
    every = [*own, *((-1, one) for one in part.made or ())]
    contours = [one for _, one in every if isinstance(one, Contour)]
    boxes: list[tuple[Face, Box]] = []
    if any(one.kind == "inner" for one in contours):
        outer = (one for one in contours if one.kind == "outer")
        boxes = [(one.face, box) for one in outer if (box := _box(one))]
    for index, one in every:
        if isinstance(one, Hole) and one.kind in KINDS:
            x, y, r = one.x, one.y, one.diameter / 2
            through = one.kind == "through" and one.depth is None
            yield _Opening(one, (x - r, y - r, x + r, y + r), pi * r * r, index, through)
        elif isinstance(one, Slot) and one.kind in KINDS:
            u, v, r = _sizes(one)
            c, s = abs(cos(radians(one.angle))), abs(sin(radians(one.angle)))
            wide, high = c * u + s * v + r, s * u + c * v + r
            area = 4 * (u * v + r * (u + v)) + pi * r * r
            box = (one.x - wide, one.y - high, one.x + wide, one.y + high)
            through = one.kind == "through" and one.depth is None
            yield _Opening(one, box, area, index, through)
        elif isinstance(one, Contour) and one.kind == "inner" and one.closed:
            around = _box(one)
            if one.process != "cut" or around is None:
                continue
            if not any(face == one.face and _holds(around, box) for face, box in boxes):
                yield _Opening(one, around, abs(signed_area(one.curves)), index, True)


def _pairs(openings: Sequence[_Opening]) -> Iterator[tuple[_Opening, _Opening]]:
    """An opening and a larger one through the wall whose box holds it, the largest first."""
    least = min([one.area for one in openings], default=0.0) + SMALLER
    large = [one for one in openings if one.area >= least and one.reaches_through]
    large.sort(key=_area, reverse=True)
    cells: defaultdict[tuple[str, float, float], list[_Opening]] = defaultdict(list)
    for one in large:
        x0, y0, x1, y1 = one.box
        columns = range(int(x0 // CELL), int(x1 // CELL) + 1)
        rows = range(int(y0 // CELL), int(y1 // CELL) + 1)
        if max(len(columns), len(rows)) > MOST_CELLS + 1:
            continue  # a damaged file may have one as large as a planet
        for x in columns:
            for y in rows:
                cells[one.feature.face, x, y].append(one)
    largest = large[0].area if cells else 0.0
    for small in openings:
        if small.index < 0 or largest < small.area + SMALLER:
            continue
        x0, y0, x1, y1 = small.box
        middle = small.feature.face, (x0 + x1) / 2 // CELL, (y0 + y1) / 2 // CELL
        for other in cells.get(middle, ()):
            if other.area < small.area + SMALLER:
                break
            if _holds(other.box, small.box):
                yield small, other


def _box(contour: Contour) -> Box | None:
    return join_boxes([curve.bbox for curve in contour.curves])


def _holds(box: Box, other: Box) -> bool:
    return (
        box[0] - OVER <= other[0] and box[1] - OVER <= other[1]
        and other[2] <= box[2] + OVER and other[3] <= box[3] + OVER
    )  # fmt: skip


def _turn(one: Hole | Slot) -> float:
    return one.angle if isinstance(one, Slot) else 0.0


def _sizes(one: Hole | Slot) -> tuple[float, float, float]:
    """Half the sides of the rectangle that its disc goes round, and the radius of that."""
    if isinstance(one, Hole):
        return 0.0, 0.0, one.diameter / 2
    return one.length / 2, one.height / 2, one.diameter / 2


def _lies_in(small: _Opening, large: _Opening) -> bool:
    """Whether all of an opening lies in another one."""
    one, other = small.feature, large.feature
    if isinstance(one, Contour) or isinstance(other, Contour):
        return bool(_polygon(other).buffer(OVER).covers(_polygon(one)))
    along, across, radius = _sizes(other)
    c, s = cos(radians(_turn(other))), sin(radians(_turn(other)))
    for x, y in one.centres:
        dx, dy = x - other.x, y - other.y
        u, v = abs(c * dx + s * dy) - along, abs(c * dy - s * dx) - across
        off = hypot(max(u, 0.0), max(v, 0.0)) + min(max(u, v), 0.0)
        if off + one.diameter / 2 > radius + OVER:
            return False
    return True


def _polygon(one: Hole | Slot | Contour) -> Any:
    from shapely import MultiPoint, make_valid

    from beamcam.planning.contours.outline import outlines

    if isinstance(one, Contour):
        return make_valid(outlines([one.curves], CHORD)[0])
    return MultiPoint(one.centres).convex_hull.buffer(one.diameter / 2, quad_segs=64)


# --- end planes (SC) ------------------------------------------------------------------------------


NOTHING_TAKEN = note("plan-plane-nothing",
    "found an end plane that takes nothing of the part; it is no cut of its own",
    "It states an end once more that length, header or outline give, or it lies beyond "
    "it.")  # fmt: skip
INSIDE = 0.1  #: mm that a plane may lie inside of the end that it states once more

Place = tuple[float, float, float]


def takes_nothing(plane: EndPlane, outermost: Iterable[Place]) -> bool:
    """Whether the outermost places of a part, x, y and z of its section, all lie behind a plane."""
    (px, py, pz), (a, b, c) = plane.point, plane.normal
    most = INSIDE * hypot(a, b, c)
    return all(a * (x - px) + b * (y - py) + c * (z - pz) <= most for x, y, z in outermost)


def idle_planes(part: Part, outermost: Iterable[Place]) -> Iterator[tuple[int, Diagnostic]]:
    """The planes of a part that take nothing, by their indices, and a note on each."""
    places = tuple(outermost)
    for index, feature in enumerate(part.features):
        if isinstance(feature, EndPlane) and takes_nothing(feature, places):
            yield index, NOTHING_TAKEN.at(feature.source)
