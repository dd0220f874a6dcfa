"""Texts read from lines by somebody who knows the letters and nothing of how they were laid out."""

from collections.abc import Iterable
from math import cos, radians, sin

from beamcam.geometry.lettering import glyph_of

Point = tuple[float, float]
Lines = list[tuple[Point, Point]]

#: Of letters that look alike the first is read.
SIGNS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghjkmnopqrstuvwxyz0123456789-/_.,+ÄÖÜäé"
NEAR = 0.03  #: of a capital's height
GLYPHS = {sign: [*glyph.segments] for sign in SIGNS if (glyph := glyph_of(sign))}


def read(lines: Iterable[tuple[Point, Point]], height: float, angle: float = 0.0) -> str:
    """The text that lines of letters of a height show, read along an angle; ? for what is none.

    The baseline is where most can be read. A letter begins where what is left begins; of those
    that are all there the one with the most lines is read.
    """
    c, s = cos(radians(-angle)), sin(radians(-angle))
    level = [
        tuple(((x * c - y * s) / height, (x * s + y * c) / height) for x, y in line)
        for line in lines
    ]
    bases = sorted({round(y, 2): y for line in level for _, y in line}.values())
    texts = (_on(base, level) for base in bases)
    return min(texts, key=lambda text: (text.endswith("?"), -len(text)), default="")


def _on(base: float, level: list[tuple[Point, ...]]) -> str:
    """What stands on a baseline, up to what cannot be read."""
    left = {k: (line[0], line[1]) for k, line in enumerate(level)}
    text = ""
    while left:
        first = min(x for line in left.values() for x, _ in line)
        fits = [
            (len(pieces), sign, taken)
            for sign, pieces in GLYPHS.items()
            if (taken := _taken(pieces, first, base, left)) is not None
        ]
        if not fits:
            return text + "?"
        _, sign, taken = max(fits)
        text += sign
        for k in taken:
            del left[k]
    return text


def _taken(
    pieces: Lines, first: float, base: float, left: dict[int, tuple[Point, Point]]
) -> list[int] | None:
    """The lines that a letter from `first` is made of; None if one is not there."""
    begin = first - min(x for piece in pieces for x, _ in piece)
    taken: list[int] = []
    for a, b in pieces:
        k = _find((begin + a[0], base + a[1]), (begin + b[0], base + b[1]), left)
        if k is None:
            return None
        taken.append(k)
    return taken


def _find(a: Point, b: Point, left: dict[int, tuple[Point, Point]]) -> int | None:
    for k, (p, q) in left.items():
        if (_near(p, a) and _near(q, b)) or (_near(p, b) and _near(q, a)):
            return k
    return None


def _near(a: Point, b: Point) -> bool:
    return abs(a[0] - b[0]) <= NEAR and abs(a[1] - b[1]) <= NEAR
