"""Cut-outs of a plate that lie with a side on its outline, which are notches.

 ______    ______        What both have in common is no edge of the part: it is taken from both, and
|      |__|      |       what stays of them is one contour. Such a cut-out lies within the outline
|________________|       and has one run of sides on it, or it would part the plate.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import dist

from msgspec import Struct

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point
from beamcam.model.description import description
from beamcam.model.part import PLATE_FACES, Contour, Part
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import outlines

TOUCH = 0.02  #: mm between a side and the outline that it lies on
CHORD = 0.01  #: mm


class Notches(Struct, frozen=True):
    """Contours that are one with others: the curves that stay of each, by its index."""

    curves: Mapping[int, tuple[Curve, ...]] = {}
    notes: tuple[Diagnostic, ...] = ()


def notches_in(
    part: Part, outline: Sequence[Curve], header: int, out: Collection[int] = ()
) -> Notches:
    """The notches of a plate but for those `out`; `header` stands for its `outline` where it has no
    contour of it."""
    inner = {
        k: one for k, one in enumerate(part.features)
        if isinstance(one, Contour) and one.kind == "inner" and _is_plain(one)
        and k not in out
    }  # fmt: skip
    if not inner:
        return Notches()
    outer: dict[int, tuple[Curve, ...]] = {
        k: one.curves for k, one in enumerate(part.features)
        if isinstance(one, Contour) and one.kind == "outer" and _is_plain(one)
    }  # fmt: skip
    sources = {k: part.features[k].source for k in outer} | {header: part.source}
    outer |= {header: tuple(outline)} if outline else {}
    whole, left, notes = dict(outer), dict[int, tuple[Curve, ...]](), list[Diagnostic]()
    for k, one in inner.items():
        for o, curves in outer.items():
            pairs = [*_touching(one.curves, curves)]
            if not pairs or not _is_notch(one, {c for c, _ in pairs}, whole[o]):
                continue
            sides = [one.curves[c] for c, _ in pairs]
            left[k] = tuple(c for n, c in enumerate(one.curves) if n not in {c for c, _ in pairs})
            outer[o] = left[o] = tuple(_without(curves, pairs, one.curves))
            notes.append(rules.NOTCH.at(
                one.source, what=description(one), first=sources[o],
                found=f"{sum(side.length for side in sides):.2f}",
            ))  # fmt: skip
            break
    return Notches(left, tuple(notes))


def _is_plain(one: Contour) -> bool:
    """Whether it is a contour of a plate, and not of a drawing."""
    plain = one.process == "cut" and one.closed and one.face in PLATE_FACES
    return plain and one.layer is None and one.colour is None


def _touching(inner: Sequence[Curve], outer: Sequence[Curve]) -> Iterator[tuple[int, int]]:
    """The sides of a cut-out that lie on lines of an outline, with those."""
    for c, side in enumerate(inner):
        if isinstance(side, Line):
            for o, line in enumerate(outer):
                if isinstance(line, Line) and _lies_on(side.start, line) and (
                    _lies_on(side.end, line)
                ):  # fmt: skip
                    yield c, o
                    break


def _lies_on(at: Point, line: Line) -> bool:
    length = line.length
    if not length:
        return False
    (x0, y0), (x1, y1) = line.start, line.end
    along = ((at[0] - x0) * (x1 - x0) + (at[1] - y0) * (y1 - y0)) / length
    across = ((at[1] - y0) * (x1 - x0) - (at[0] - x0) * (y1 - y0)) / length
    return abs(across) <= TOUCH and -TOUCH <= along <= length + TOUCH


def _is_notch(one: Contour, on_edge: set[int], outline: Sequence[Curve]) -> bool:
    """Whether the sides on the edge follow each other, and all of a cut-out is in the outline."""
    count = len(one.curves)
    begins = sum(c in on_edge and (c - 1) % count not in on_edge for c in range(count))
    inside, around = outlines([one.curves, outline], CHORD)
    return begins == 1 and bool(around.buffer(2 * TOUCH).covers(inside))


def _without(
    outer: Sequence[Curve], pairs: Sequence[tuple[int, int]], inner: Sequence[Curve]
) -> Iterator[Curve]:
    """An outline without what sides of a cut-out lie on."""
    for o, line in enumerate(outer):
        gone = [inner[c] for c, on in pairs if on == o]
        if not gone:
            yield line
            continue
        ends = [p for side in gone for p in (side.start, side.end)]
        first, last = (f(ends, key=lambda p: dist(p, line.start)) for f in (min, max))
        stays = (line.start, first), (last, line.end)
        yield from (Line(a, b) for a, b in stays if dist(a, b) > TOUCH)
