"""Position and strokes of a text.

A text stands where the part wants it, if it is clear of holes, edges and other texts there. Else it
is moved by the least way to where it is clear; where no such place is left it is made smaller, down
to the machine's least height. One whose values are all binding (DSTV's z) is neither.

The search goes by squares over the face, the nearest to the wanted place first: a square is given
up where the text at its middle is nearer to an obstacle than its corners are away.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from heapq import heappop, heappush
from itertools import pairwise
from math import ceil, cos, dist, hypot, inf, radians, sin

from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.lettering import Glyph, body_share, glyph_of, spelled, spelled_with
from beamcam.geometry.plane import Box, Point, box_around
from beamcam.machine.marking import Marks
from beamcam.model.part import MIRRORED_FACES, TextMark
from beamcam.planning.by_hand import (
    ANGLE,
    BLANK,
    CHARACTERS,
    HEIGHT,
    NO_ROOM,
    TEXT_HEIGHT,
    TEXT_MOVED,
    TEXT_SIGN,
    TOO_SMALL,
)

SHRINK = 0.8  #: from one height that is tried to the next
STEP = 0.1  #: mm that places and heights of moved texts are rounded to
FINEST = 0.25  #: mm, half the side of the smallest square that is looked at
MOST_SQUARES = 10_000  #: of a face, until no text is moved any more
RUN = 16  #: chords that are looked at together
CHORD = 1.0  #: mm of the chords that obstacles are taken as

NO_BOX = (0.0, 0.0, 0.0, 0.0)

Segment = tuple[Point, Point]


class Run(Struct, frozen=True):
    """Chords that follow one another along an edge, and a circle around them."""

    centre: Point
    radius: float
    chords: tuple[Segment, ...]


class Room(Struct):
    """Obstacles on a face, in its coordinates: where a text may be placed."""

    box: Box  #: that holds every place
    edges: list[Run] = field(default_factory=list)  #: of the steel, which lies on one side
    holes: list[tuple[Point, float]] = field(default_factory=list)  #: centres and radii
    texts: list[Segment] = field(default_factory=list)  #: round those that are placed
    squares: int = MOST_SQUARES  #: that may still be looked at

    def add(self, curves: Sequence[Curve]) -> None:
        """Take the curves of an edge or a hole; they close."""
        if len(curves) == 1 and isinstance(curves[0], Arc) and abs(curves[0].sweep_deg) >= 360.0:
            self.holes.append((curves[0].centre, curves[0].radius))
            return
        for curve in curves:
            self.edges += _runs(tuple(_chords(curve)))

    def bound(self, corners: Sequence[Point]) -> None:
        """Take an edge from corner to corner; the last is the first."""
        self.edges += _runs(tuple(pairwise(corners)))

    def is_steel(self, x: float, y: float) -> bool:
        """Whether there is steel at a place, by the edges that a ray from it crosses."""
        crossed = 0
        for run in self.edges:
            if abs(y - run.centre[1]) <= run.radius and x <= run.centre[0] + run.radius:
                for (ax, ay), (bx, by) in run.chords:
                    if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
                        crossed += 1
        return not self.edges or crossed % 2 == 1

    def nearest(self, place: Point, reach: float, away: Callable[[Point, Point], float]) -> float:
        """The least of `away` over all chords of edges; inf without any.

        `away` is at least the distance of a chord from `place`, less `reach`, so that runs which
        lie farther off than the best are not looked at.
        """
        best = inf
        bounds = sorted(
            (dist(place, run.centre) - run.radius, k) for k, run in enumerate(self.edges)
        )
        for bound, k in bounds:
            if bound - reach >= best:
                break
            best = min(best, *(away(p, q) for p, q in self.edges[k].chords))
        return best


class Lettered(Struct, frozen=True):
    """A text at its place."""

    text: str  #: as it is spelled
    x: float
    y: float
    height: float  #: of a capital
    angle: float
    mirrored: bool
    spacing: float
    extent: Box  #: around its strokes, from where it begins, in heights

    @property
    def strokes(self) -> Iterator[tuple[Point, ...]]:
        """Its strokes in the numbers of the face."""
        u, v = _axes(self.angle, self.mirrored)
        for at, glyph in _glyphs(self.text, self.spacing):
            for stroke in glyph.strokes:
                yield tuple(
                    (
                        self.x + self.height * ((at + a) * u[0] + b * v[0]),
                        self.y + self.height * ((at + a) * u[1] + b * v[1]),
                    )
                    for a, b in stroke
                )


def _axes(angle_deg: float, mirrored: bool) -> tuple[Point, Point]:
    """Along a line of text and up, so that it reads right seen from outside."""
    c, s = cos(radians(angle_deg)), sin(radians(angle_deg))
    return (c, s), ((s, -c) if mirrored else (-s, c))


def _glyphs(text: str, spacing: float) -> Iterator[tuple[float, Glyph]]:
    """The glyphs of a text and where each begins, in heights of a capital."""
    at = 0.0
    for sign in text:
        glyph = glyph_of(sign)
        if glyph is None:
            raise AssertionError(f"the font has no {sign!r}")
        yield at, glyph
        at += glyph.advance * spacing


def place_text(feature: TextMark, marks: Marks, room: Room) -> Lettered | str:
    """The placed text, or why there is no place; it is an obstacle for later texts."""
    if marks.is_told:
        return _place_told(feature, marks, room)
    height = feature.height * (body_share() if marks.height_of == "body" else 1.0)
    text = spelled(feature.text, marks.replace).text
    flat = Lettered(text, 0.0, 0.0, 1.0, 0.0, False, marks.spacing, NO_BOX)
    extent = _extent(flat.strokes)
    if extent is None:
        return BLANK
    lettered = Lettered(
        text, feature.x, feature.y, height, feature.angle, feature.face in MIRRORED_FACES,
        marks.spacing, extent,
    )  # fmt: skip
    if height < marks.min_height:
        return TOO_SMALL
    return _put(lettered, feature, _smaller(lettered, marks, room), marks, room)


def _place_told(feature: TextMark, marks: Marks, room: Room) -> Lettered | str:
    """The text as a stamp or printer sets it: a row of characters, each as high as the row."""
    spelling = spelled_with(feature.text, marks.replace, marks.characters)
    if spelling is None:
        return CHARACTERS
    if not spelling.text.strip():
        return BLANK
    angle = next((a for a in marks.angles if (a - feature.angle) % 360.0 in (0.0, 360.0)), None)
    if angle is None:
        return ANGLE
    if not marks.heights and feature.height < marks.min_height:
        return TOO_SMALL
    heights = [own_height(feature.height, marks)]
    if feature.option == "z" and heights[0] != feature.height:
        return HEIGHT
    if marks.heights:
        heights += sorted((h for h in marks.heights if h < heights[0]), reverse=True)
    lettered = Lettered(
        spelling.text, feature.x, feature.y, heights[0], angle, feature.face in MIRRORED_FACES,
        marks.pitch, (0.0, 0.0, marks.pitch * len(spelling.text), 1.0),
    )  # fmt: skip
    smaller = heights if marks.heights else _smaller(lettered, marks, room)
    return _put(lettered, feature, smaller, marks, room)


def own_height(wanted: float, marks: Marks) -> float:
    """The height that a stamp has nearest to a wanted one, of two the smaller."""
    return min(marks.heights, key=lambda h: (abs(h - wanted), h), default=wanted)


def _put(
    lettered: Lettered, feature: TextMark, heights: Iterable[float], marks: Marks, room: Room
) -> Lettered | str:
    """The text where it is clear; it is an obstacle from then on."""
    found = _placed(lettered, feature.option == "z", heights, marks, room)
    if found is None:
        return NO_ROOM
    corners = _corners(found)
    room.texts += zip(corners, (*corners[1:], corners[0]), strict=True)
    return found


def remarks(feature: TextMark, found: Lettered, marks: Marks) -> Iterator[Diagnostic]:
    """Remarks on texts that differ from the part's."""
    if marks.is_told:
        spelling = spelled_with(feature.text, marks.replace, marks.characters)
        has = f"the {marks.unit}"
    else:
        spelling, has = spelled(feature.text, marks.replace), "the font"
    for sign, other in spelling.replaced if spelling else ():
        yield TEXT_SIGN.at(feature.source, sign=sign, text=feature.text, other=other, has=has)
    share = body_share() if marks.height_of == "body" and not marks.is_told else 1.0
    height = feature.height * share
    if marks.is_told and height != (own := own_height(height, marks)):
        said = {"text": found.text, "found": f"{height:g}", "height": f"{own:g}"}
        yield TEXT_HEIGHT.at(feature.source, **said)
        height = own
    if (found.x, found.y, found.height) != (feature.x, feature.y, height):
        yield TEXT_MOVED.at(
            feature.source, text=found.text, x=f"{found.x:.1f}", y=f"{found.y:.1f}",
            height=f"{found.height:.1f}", distance=f"{marks.min_distance:g}",
            wanted_x=f"{feature.x:g}", wanted_y=f"{feature.y:g}", wanted_height=f"{height:g}",
        )  # fmt: skip


def _placed(
    lettered: Lettered, is_bound: bool, heights: Iterable[float], marks: Marks, room: Room
) -> Lettered | None:
    """The text where it is clear, in the first of some heights that it is; None if in none."""
    if _clearance(lettered, room) >= marks.min_distance:
        return lettered
    if is_bound:
        return None
    each = (_nearest(replace(lettered, height=h), marks.min_distance, room) for h in heights)
    return next((found for found in each if found is not None), None)


def _smaller(lettered: Lettered, marks: Marks, room: Room) -> Iterator[float]:
    """Heights of a text that may be of any, down to the machine's least."""
    height = lettered.height
    widest = max(room.box[2] - room.box[0], room.box[3] - room.box[1])
    length = lettered.extent[2] - lettered.extent[0]
    if height * length > 1.5 * widest:  # longer than the diagonal
        height = max(marks.min_height, _rounded(1.5 * widest / length))
    yield height
    while height > marks.min_height:
        height = max(marks.min_height, _rounded(height * SHRINK))
        yield height


def _rounded(value: float) -> float:
    return round(round(value / STEP) * STEP, 6)


def _nearest(wanted: Lettered, distance: float, room: Room) -> Lettered | None:
    """The text moved to the nearest place where it is clear."""
    middle = _middle(wanted)
    away = wanted.x - middle[0], wanted.y - middle[1]

    def at(x: float, y: float) -> Lettered:
        return replace(wanted, x=_rounded(x + away[0]), y=_rounded(y + away[1]))

    place = _search(middle, room, distance, lambda x, y: _clearance(at(x, y), room))
    if place is None:
        return None
    found = at(*place)
    # Along or across alone is as near, as far as the squares tell, and looks meant.
    straight = (replace(found, y=wanted.y), replace(found, x=wanted.x))
    return next((one for one in straight if _clearance(one, room) >= distance), found)


def _search(
    start: Point, room: Room, distance: float, clearance: Callable[[float, float], float]
) -> Point | None:
    """The place in a room nearest to `start` at which `clearance` is at least `distance`.

    None too where all squares of the room that may be looked at have been.
    """
    box = room.box
    half = max(box[2] - box[0], box[3] - box[1]) / 2
    squares = [(0.0, (box[0] + box[2]) / 2, (box[1] + box[3]) / 2, half)]
    best, place = inf, None
    while room.squares > 0 and squares and squares[0][0] < best:
        room.squares -= 1
        _, x, y, half = heappop(squares)
        clear = clearance(x, y)
        if clear >= distance and (way := dist((x, y), start)) < best:
            best, place = way, (x, y)
        if half <= FINEST or clear + half * hypot(1.0, 1.0) + STEP < distance:
            continue
        half /= 2
        for dx in (-half, half):
            for dy in (-half, half):
                apart = (max(abs(c + d - s) - half, 0.0)
                         for c, d, s in ((x, dx, start[0]), (y, dy, start[1])))  # fmt: skip
                heappush(squares, (hypot(*apart), x + dx, y + dy, half))
    return place


def _corners(one: Lettered) -> tuple[Point, ...]:
    """The corners of the box around a text, along its line."""
    u, v = _axes(one.angle, one.mirrored)
    low_x, low_y, high_x, high_y = (one.height * side for side in one.extent)
    return tuple(
        (one.x + a * u[0] + b * v[0], one.y + a * u[1] + b * v[1])
        for a, b in ((low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y))
    )


def _extent(strokes: Iterable[tuple[Point, ...]]) -> Box | None:
    """The box around strokes; None round none."""
    points = [point for stroke in strokes for point in stroke]
    return box_around(points) if points else None


def _middle(one: Lettered) -> Point:
    corners = _corners(one)
    return (corners[0][0] + corners[2][0]) / 2, (corners[0][1] + corners[2][1]) / 2


def _clearance(one: Lettered, room: Room) -> float:
    """Clearance of a text's box from obstacles; negative where they overlap.

    It changes by no more than a text is moved, so that it bounds the places around.
    """
    u, v = _axes(one.angle, one.mirrored)
    x, y = _middle(one)
    low_x, low_y, high_x, high_y = (one.height * side for side in one.extent)
    half_x, half_y = (high_x - low_x) / 2, (high_y - low_y) / 2

    def local(p: Point) -> Point:
        a, b = p[0] - x, p[1] - y
        return a * u[0] + b * u[1], a * v[0] + b * v[1]

    inner = min(half_x, half_y)  # of the circle inside the box
    clear = inf
    for centre, radius in room.holes:
        a, b = local(centre)
        away = hypot(max(abs(a) - half_x, 0.0), max(abs(b) - half_y, 0.0))
        clear = min(clear, (away or min(0.0, hypot(a, b) - inner)) - radius)
    edge = room.nearest(
        (x, y), hypot(half_x, half_y),
        lambda p, q: _box_distance(half_x, half_y, local(p), local(q)),
    )  # fmt: skip
    if edge <= 0.0:
        deep = room.nearest((x, y), 0.0, lambda p, q: _to_segment((x, y), p, q)) - inner
        return min(0.0, deep, clear)
    if not room.is_steel(x, y):
        return -edge
    for p, q in room.texts:
        if _box_distance(half_x, half_y, local(p), local(q)) <= 0.0:
            return 0.0
    return min(clear, edge)


def _box_distance(half_x: float, half_y: float, a: Point, b: Point) -> float:
    """Between a segment and a box around the origin; 0 where they meet."""
    if _meets(half_x, half_y, a, b):
        return 0.0
    ends = (hypot(max(abs(p[0]) - half_x, 0.0), max(abs(p[1]) - half_y, 0.0)) for p in (a, b))
    corners = ((sx * half_x, sy * half_y) for sx in (-1, 1) for sy in (-1, 1))
    return min(*ends, *(_to_segment(c, a, b) for c in corners))


def _meets(half_x: float, half_y: float, a: Point, b: Point) -> bool:
    """Whether a segment passes a box around the origin (Liang and Barsky's clipping)."""
    first, last = 0.0, 1.0
    for start, way, half in ((a[0], b[0] - a[0], half_x), (a[1], b[1] - a[1], half_y)):
        if abs(way) < 1e-12:
            if abs(start) > half:
                return False
            continue
        one, other = sorted(((-half - start) / way, (half - start) / way))
        first, last = max(first, one), min(last, other)
    return first <= last


def _to_segment(p: Point, a: Point, b: Point) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    length2 = dx * dx + dy * dy
    t = 0.0 if length2 == 0.0 else ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length2
    t = min(1.0, max(0.0, t))
    return hypot(p[0] - a[0] - t * dx, p[1] - a[1] - t * dy)


def _runs(chords: Sequence[Segment]) -> Iterator[Run]:
    """Chords of a curve, some at a time."""
    for k in range(0, len(chords), RUN):
        some = tuple(chords[k : k + RUN])
        points = [some[0][0], *(end for _, end in some)]
        low_x, low_y, high_x, high_y = box_around(points)
        centre = (low_x + high_x) / 2, (low_y + high_y) / 2
        yield Run(centre, max(dist(centre, point) for point in points), some)


def _chords(curve: Curve) -> Iterator[Segment]:
    count = 1 if isinstance(curve, Line) else min(256, max(8, ceil(curve.length / CHORD)))
    points = [curve.point(k / count) for k in range(count + 1)]
    yield from pairwise(points)
