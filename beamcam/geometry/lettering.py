"""Letters as strokes: a single-line font, and how a text is spelled in it.

The font is frozen: Hershey's Roman simplex of 95 characters, in `hershey.json` with its notice.
Letters with accents are put together of their base and their accents, as Unicode takes them apart.
Glyphs are fixed truth, which planning and the read-back share; each lays them out by itself.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from unicodedata import combining, name, normalize

import msgspec
from msgspec import Struct, field

from beamcam.caches import cached
from beamcam.geometry.plane import Point

Strokes = tuple[tuple[Point, ...], ...]

STACKED = 5.0  #: between two accents on one letter, in units of the font's file
GAP = 2.0  #: between a letter and its accent


class Glyph(Struct, frozen=True):
    """A character: its strokes and its advance width.

    Coordinates are in heights of a capital: x from where the character begins, y from the baseline.
    """

    advance: float
    strokes: Strokes

    @property
    def segments(self) -> Iterator[tuple[Point, Point]]:
        """The straight pieces of all strokes."""
        for stroke in self.strokes:
            yield from pairwise(stroke)


class Spelling(Struct, frozen=True):
    """A text in characters that the font has."""

    text: str
    replaced: tuple[tuple[str, str], ...] = ()  #: missing characters and replacements


class _Font(Struct, frozen=True):
    """The font's file, in its own units."""

    source: str
    capital: float  #: height of a capital
    body: float  #: of a line: accents, capital and descender
    small: float  #: of a small letter
    glyphs: Mapping[str, tuple[float, Strokes]]
    own: Mapping[str, tuple[float, Strokes]]
    above: Mapping[str, Strokes] = field(default_factory=dict)  #: accents, their feet at y 0
    below: Mapping[str, Strokes] = field(default_factory=dict)
    same: Mapping[str, str] = field(default_factory=dict)  #: characters written as others


@cached("geometry.font")
def _font(name: str) -> _Font:
    data = Path(__file__).with_name(f"{name}.json").read_bytes()
    return msgspec.json.decode(data, type=_Font)


def body_share() -> float:
    """Height of a capital as a share of the body height."""
    font = _font("hershey")
    return font.capital / font.body


@cached("geometry.glyph")
def glyph_of(sign: str) -> Glyph | None:
    """The glyph of one character; None where the font has none, and it cannot be put together."""
    font = _font("hershey")
    known = font.own.get(sign) or font.glyphs.get(sign)
    marks = ""
    if known is None:
        apart = normalize("NFD", sign)
        base, marks = apart[0], apart[1:]
        if not marks or any(mark not in font.above and mark not in font.below for mark in marks):
            return None
        if base in "ij" and any(mark in font.above for mark in marks):
            base = {"i": "ı", "j": "ȷ"}[base]  # the accent takes the place of the dot
        known = font.own.get(base) or font.glyphs.get(base)
    if known is None:
        return None
    advance, strokes = known
    if marks:  # the accents, over its middle and under it
        xs = [x for stroke in strokes for x, _ in stroke]
        top = max(y for stroke in strokes for _, y in stroke)
        middle = (min(xs) + max(xs)) / 2
        foot = (font.small if top <= font.small else max(top, font.capital)) + GAP
        for mark in marks:
            above = mark in font.above
            accent, y = (font.above[mark], foot) if above else (font.below[mark], 0.0)
            foot += STACKED if above else 0.0
            strokes = (*strokes, *(tuple((middle + a, y + b) for a, b in one) for one in accent))
    scale = 1.0 / font.capital
    scaled = tuple(tuple((x * scale, y * scale) for x, y in stroke) for stroke in strokes)
    return Glyph(advance * scale, scaled)


def spelled(text: str, replace: Mapping[str, str]) -> Spelling:
    """A text in characters of the font.

    A character that it has not is written as `replace` says, else by those that it stands for, else
    by its name in brackets; the result says which. Signs that look the same, such as dashes, are
    written as the one that there is.
    """
    font = _font("hershey")
    words: list[str] = []
    replaced: dict[str, str] = {}
    for sign in normalize("NFC", text):
        plain = font.same.get(sign, sign)
        other = replace.get(sign, "")
        if not other or not _has(other):
            # By those that it stands for, as a ligature does, or by its name in brackets.
            others = "".join(font.same.get(each, each) for each in normalize("NFKC", sign))
            shown = f"[{name(sign, f'U+{ord(sign):04X}')}]"
            other = plain if _has(plain) else others if _has(others) else shown
        if other != plain:
            replaced[sign] = other
        words.append(other)
    return Spelling("".join(words), tuple(replaced.items()))


def spelled_with(text: str, replace: Mapping[str, str], characters: str) -> Spelling | None:
    """A text in the characters of a stamp or printer; None where they do not do.

    A character that it has not is written as `replace` says, else as a capital, without accents, by
    those that it stands for, or by its name; all that is reported.
    """
    has = set(characters).issuperset
    words: list[str] = []
    replaced: dict[str, str] = {}
    for sign in normalize("NFC", text):
        other = next((o for o in _ways_to_write(sign, replace) if o and has(o)), None)
        if other is None:
            return None
        if other != sign:
            replaced[sign] = other
        words.append(other)
    return Spelling("".join(words), tuple(replaced.items()))


def _ways_to_write(sign: str, replace: Mapping[str, str]) -> Iterator[str]:
    """What may be written for a character, the best first."""
    font = _font("hershey")
    yield replace.get(sign, "")
    named = name(sign, f"U+{ord(sign):04X}")
    bare = "".join(s for s in normalize("NFD", sign) if not combining(s))
    others = "".join(font.same.get(each, each) for each in normalize("NFKC", sign))
    for other in (sign, font.same.get(sign, ""), bare, others):
        yield from (other, other.upper())
    yield from (f"[{named}]", f"({named})", named, named.replace(" ", "-"), named.replace(" ", ""))


def _has(text: str) -> bool:
    return all(glyph_of(sign) is not None for sign in text)
