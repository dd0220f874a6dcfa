"""Position and strokes of a text.

A text stands where the part wants it, if it is clear of holes, edges and other texts there. Else it
is moved by the least way to where it is clear; where no such place is left it is made smaller, down
to the machine's least height. One whose values are all binding (DSTV's z) is neither.
"""

from collections.abc import Iterable, Iterator
from math import cos, inf, radians, sin

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.lettering import body_share, glyph_of, spelled, spelled_with
from beamcam.geometry.plane import Box, Point, box_around
from beamcam.machine.stations import Marks
from beamcam.model.part import MIRRORED_FACES, TextMark
from beamcam.planning import left_out
from beamcam.planning.lettering_room import BESIDE, MOST_SQUARES, STEP, Exhausted, Placed, Room

SHRINK = 0.8  #: from one height that is tried to the next
LEAST_DISTANCE = 0.05  #: mm from edges, so that a text that is read back is clear of them as well

NO_BOX = (0.0, 0.0, 0.0, 0.0)


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
        at = 0.0  # where a glyph begins, in heights of a capital
        for sign in self.text:
            glyph = glyph_of(sign)
            if glyph is None:
                raise AssertionError(f"the font has no {sign!r}")
            for stroke in glyph.strokes:
                yield tuple(
                    (
                        self.x + self.height * ((at + a) * u[0] + b * v[0]),
                        self.y + self.height * ((at + a) * u[1] + b * v[1]),
                    )
                    for a, b in stroke
                )
            at += glyph.advance * self.spacing


def _axes(angle_deg: float, mirrored: bool) -> tuple[Point, Point]:
    """Along a line of text and up, so that it reads right seen from outside."""
    c, s = cos(radians(angle_deg)), sin(radians(angle_deg))
    return (c, s), ((s, -c) if mirrored else (-s, c))


def place_text(feature: TextMark, marks: Marks, room: Room) -> Lettered | str | Diagnostic:
    """The placed text, or why there is no place; it is an obstacle for later texts.

    An error where the search for a place would take too long.
    """
    if marks.is_told:
        return _place_told(feature, marks, room)
    height = feature.height * (body_share() if marks.height_of == "body" else 1.0)
    text = spelled(feature.text, marks.replace).text
    flat = Lettered(text, 0.0, 0.0, 1.0, 0.0, False, marks.spacing, NO_BOX)
    points = [point for stroke in flat.strokes for point in stroke]
    if not points:
        return left_out.BLANK
    lettered = Lettered(
        text, feature.x, feature.y, height, feature.angle, feature.face in MIRRORED_FACES,
        marks.spacing, box_around(points),
    )  # fmt: skip
    if height < marks.min_height:
        return left_out.TOO_SMALL
    return _put(lettered, feature, _smaller(lettered, marks, room), marks, room)


def _place_told(feature: TextMark, marks: Marks, room: Room) -> Lettered | str | Diagnostic:
    """The text as a stamp or printer sets it: a row of characters, each as high as the row."""
    spelling = spelled_with(feature.text, marks.replace, marks.characters)
    if spelling is None:
        return left_out.CHARACTERS
    if not spelling.text.strip():
        return left_out.BLANK
    angle = next((a for a in marks.angles if (a - feature.angle) % 360.0 in (0.0, 360.0)), None)
    if angle is None:
        return left_out.ANGLE
    if not marks.heights and feature.height < marks.min_height:
        return left_out.TOO_SMALL
    heights = [own_height(feature.height, marks)]
    if feature.option == "z" and heights[0] != feature.height:
        return left_out.HEIGHT
    if marks.heights:
        heights += sorted((h for h in marks.heights if h < heights[0]), reverse=True)
    lettered = Lettered(
        spelling.text, feature.x, feature.y, heights[0], angle, feature.face in MIRRORED_FACES,
        marks.pitch, (0.0, 0.0, marks.pitch * len(spelling.text), 1.0),
    )  # fmt: skip
    smaller = heights if marks.heights else _smaller(lettered, marks, room)
    return _put(lettered, feature, smaller, marks, room)


def own_height(height: float, marks: Marks) -> float:
    """The height that a stamp has nearest to a lettered one, of two the smaller."""
    return min(marks.heights, key=lambda h: (abs(h - height), h), default=height)


def _put(
    lettered: Lettered, feature: TextMark, heights: Iterable[float], marks: Marks, room: Room
) -> Lettered | str | Diagnostic:
    """The text where it is clear, in the first of some heights; it is an obstacle from then on."""
    distance = max(marks.min_distance, LEAST_DISTANCE)
    placed: Lettered | None = lettered
    if room.clearance(_box(lettered), distance) < distance:
        each = (_nearest(replace(lettered, height=h), distance, room) for h in heights)
        try:
            placed = None if feature.option == "z" else next(filter(None, each), None)
        except Exhausted:
            return left_out.TEXT_SEARCH.at(
                feature.source, text=lettered.text, face=feature.face, most=MOST_SQUARES
            )
    if placed is None:
        return left_out.NO_ROOM
    room.take(_box(placed))
    return placed


def remarks(feature: TextMark, lettered: Lettered, marks: Marks) -> Iterator[Diagnostic]:
    """Remarks on texts that differ from the part's."""
    if marks.is_told:
        spelling = spelled_with(feature.text, marks.replace, marks.characters)
        has = f"the {marks.unit}"
    else:
        spelling, has = spelled(feature.text, marks.replace), "the font"
    for sign, other in spelling.replaced if spelling else ():
        yield left_out.TEXT_SIGN.at(
            feature.source, sign=sign, text=feature.text, other=other, has=has
        )
    share = body_share() if marks.height_of == "body" and not marks.is_told else 1.0
    height = feature.height * share
    if marks.is_told and height != (own := own_height(height, marks)):
        values = {"text": lettered.text, "found": f"{height:g}", "height": f"{own:g}"}
        yield left_out.TEXT_HEIGHT.at(feature.source, **values)
        height = own
    if (lettered.x, lettered.y, lettered.height) != (feature.x, feature.y, height):
        yield left_out.TEXT_MOVED.at(
            feature.source, text=lettered.text, x=f"{lettered.x:.1f}", y=f"{lettered.y:.1f}",
            height=f"{lettered.height:.1f}", distance=f"{marks.min_distance:g}",
            wanted_x=f"{feature.x:g}", wanted_y=f"{feature.y:g}", wanted_height=f"{height:g}",
        )  # fmt: skip


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


def _nearest(lettered: Lettered, distance: float, room: Room) -> Lettered | None:
    """The text moved to the nearest place where it is clear. Raises Exhausted."""
    shape = lettered.extent, lettered.angle, lettered.mirrored
    if lettered.height >= room.without_place.get(shape, inf):
        return None
    middle = _box(lettered).middle
    away = lettered.x - middle[0], lettered.y - middle[1]

    def at(x: float, y: float) -> Lettered:
        return replace(lettered, x=_rounded(x + away[0]), y=_rounded(y + away[1]))

    place = room.nearest(middle, distance, (*shape, lettered.height), lambda x, y: _box(at(x, y)))
    if place is None:
        room.without_place[shape] = lettered.height
        return None
    moved = at(*place)
    # Along or across alone is as near, as far as the squares tell, and looks meant.
    straight = (replace(moved, y=lettered.y), replace(moved, x=lettered.x))
    gap = min(BESIDE, distance)
    clear = (one for one in straight if room.clearance(_box(one), distance, gap) >= distance)
    return next(clear, moved)


def _box(one: Lettered) -> Placed:
    """The box around a text, along its line."""
    u, v = _axes(one.angle, one.mirrored)
    low_x, low_y, high_x, high_y = (one.height * side for side in one.extent)
    a, b = (low_x + high_x) / 2, (low_y + high_y) / 2
    middle = one.x + a * u[0] + b * v[0], one.y + a * u[1] + b * v[1]
    return Placed(middle, u, v, (high_x - low_x) / 2, (high_y - low_y) / 2)
