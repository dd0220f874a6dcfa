"""Texts that a part wants: the strokes of their letters, or the box of their characters."""

from collections.abc import Iterator
from itertools import islice, pairwise
from math import cos, radians, sin

from msgspec import Struct

from beamcam.geometry.lettering import body_share, glyph_of, spelled, spelled_with
from beamcam.geometry.plane import Point
from beamcam.machine.marking import Marks
from beamcam.model.part import MIRRORED_FACES, TextMark

Segment = tuple[Point, Point]


class Wanted(Struct, frozen=True):
    """A required text."""

    feature: TextMark
    text: str  #: as the font spells it
    height: float  #: of a capital
    pieces: tuple[Segment, ...]  #: of height 1, from where it begins, turned as it stands
    counts: tuple[int, ...] = ()  #: pieces of each stroke, one stroke behind the other

    def at(self, x: float, y: float, height: float) -> tuple[Segment, ...]:
        """Its pieces at a place."""
        return tuple(placed(piece, x, y, height) for piece in self.pieces)

    def strokes(self, x: float, y: float, height: float) -> Iterator[tuple[Segment, ...]]:
        """The pieces of each of its strokes at a place."""
        pieces = iter(self.at(x, y, height))
        for count in self.counts:
            yield tuple(islice(pieces, count))


def wanted(feature: TextMark, marks: Marks) -> Wanted:
    """The strokes that a text requires."""
    text = spelled(feature.text, marks.replace).text
    share = body_share() if marks.height_of == "body" else 1.0
    pieces = tuple(_turned(_in_a_row(text, marks.spacing), feature))
    glyphs = (glyph_of(sign) for sign in text)
    counts = tuple(len(s) - 1 for glyph in glyphs if glyph is not None for s in glyph.strokes)
    return Wanted(feature, text, feature.height * share, pieces, counts)


def told(feature: TextMark, marks: Marks) -> Wanted | None:
    """What a stamp or printer has to be told of a text, in the box of its characters.

    None where it has no characters, no angle or no height for it.
    """
    spelling = spelled_with(feature.text, marks.replace, marks.characters)
    turns = [abs(angle - feature.angle) % 360.0 for angle in marks.angles]
    if spelling is None or not spelling.text.strip() or not any(t in (0.0, 360.0) for t in turns):
        return None
    height = feature.height
    if marks.heights:
        apart = [(abs(own - height), own) for own in marks.heights]
        if feature.option == "z" and min(apart)[0] > 0.0:
            return None
        height = min(apart)[1]
    elif height < marks.min_height:
        return None
    wide = len(spelling.text) * marks.pitch
    corners = ((0.0, 0.0), (wide, 0.0), (wide, 1.0), (0.0, 1.0), (0.0, 0.0))
    pieces = tuple(_turned(iter([*pairwise(corners)]), feature))
    return Wanted(feature, spelling.text, height, pieces)


def _in_a_row(text: str, spacing: float) -> Iterator[Segment]:
    """The pieces of a text along a line, letter behind letter."""
    begin = 0.0
    for sign in text:
        glyph = glyph_of(sign)
        if glyph is None:
            raise AssertionError(f"the font has no {sign!r}")
        for (a, b), (c, d) in glyph.segments:
            yield (begin + a, b), (begin + c, d)
        begin += spacing * glyph.advance


def _turned(pieces: Iterator[Segment], feature: TextMark) -> Iterator[Segment]:
    """Pieces turned to the angle of a text; on faces that are seen mirrored they are mirrored."""
    up = -1.0 if feature.face in MIRRORED_FACES else 1.0
    c, s = cos(radians(feature.angle)), sin(radians(feature.angle))

    def turn(p: Point) -> Point:
        return p[0] * c - up * p[1] * s, p[0] * s + up * p[1] * c

    for a, b in pieces:
        yield turn(a), turn(b)


def placed(piece: Segment, x: float, y: float, height: float) -> Segment:
    """A piece of height 1 at a place."""
    (a, b), (c, d) = piece
    return (x + height * a, y + height * b), (x + height * c, y + height * d)
