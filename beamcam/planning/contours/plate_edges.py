r"""Edges of plates: cut-outs that are open to the edge, and ends skew through the thickness.

 ______    ______        What a cut-out and the outline have in common is no edge of the part: it is
|      |__|      |       taken from both, and what stays of them is one contour. Such a cut-out lies
|________________|       within the outline and has one run of sides on it, or it would part the
                         plate.

      v ________          A torch cuts square, by the policy of its file for bevels. The outline is
       |        \         as long as the plate at its longest, so that no steel is missing; what is
       |_________\        too much is a bevel of that edge: from face v (an angle above 0) where v
      h                   is the shorter side, else from the far side.

At an end x = c - y tan(web) - z tan(flange), z from face h to v: square to its edge the bevel has
the angle atan(tan(flange) cos(web)), above 0 at the end and below 0 at the start for a flange cut
above 0.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import atan, cos, degrees, dist, radians, tan

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Curve, Line
from beamcam.machine.torch import Torch
from beamcam.model.description import description
from beamcam.model.part import Bevel, Contour, EndCuts, Part
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import is_plate_contour, outer_contours, outline_of, outlines

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
    plain = {
        k: one for k, one in enumerate(part.features)
        if isinstance(one, Contour) and is_plate_contour(one)
    }  # fmt: skip
    inner = {k: one for k, one in plain.items() if one.kind == "inner" and k not in out}
    if not inner:
        return Notches()
    outer = {k: one.curves for k, one in plain.items() if one.kind == "outer"}
    sources = {k: plain[k].source for k in outer} | {header: part.source}
    outer |= {header: tuple(outline)} if outline else {}
    whole, left, notes = dict(outer), dict[int, tuple[Curve, ...]](), list[Diagnostic]()
    for k, one in inner.items():
        for o, curves in outer.items():
            # Sides of the cut-out by the line of the outline that each lies on.
            lines = [(n, line) for n, line in enumerate(curves) if isinstance(line, Line)]
            pairs = [
                (c, on[0]) for c, side in enumerate(one.curves) if isinstance(side, Line)
                and (on := [n for n, line in lines if _lies_on(side, line)])
            ]  # fmt: skip
            on_edge, count = {c for c, _ in pairs}, len(one.curves)
            begins = sum(c in on_edge and (c - 1) % count not in on_edge for c in range(count))
            if begins != 1:
                continue
            inside, around = outlines([one.curves, whole[o]], CHORD)
            if not around.buffer(2 * TOUCH).covers(inside):
                continue
            left[k] = tuple(c for n, c in enumerate(one.curves) if n not in on_edge)
            outer[o] = left[o] = tuple(_without(curves, pairs, one.curves))
            length = sum(one.curves[c].length for c, _ in pairs)
            what, shown = description(one), f"{length:.2f}"
            notes.append(rules.NOTCH.at(one.source, what=what, first=sources[o], found=shown))
            break
    return Notches(left, tuple(notes))


def _lies_on(side: Line, line: Line) -> bool:
    """Whether both ends of a side lie on a line."""
    (x0, y0), (x1, y1), length = line.start, line.end, line.length
    for x, y in (side.start, side.end) if length else ():
        along = ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / length
        across = ((y - y0) * (x1 - x0) - (x - x0) * (y1 - y0)) / length
        if abs(across) > TOUCH or not -TOUCH <= along <= length + TOUCH:
            return False
    return bool(length)


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


# --- skew ends ------------------------------------------------------------------------------------

NOISE_DEG = 1.0  #: of an angle in a header; less is noise of its writer
ON_END = 1.0  #: mm between the end of a header and the edge of an outline that is it


def with_bevels(parts: Sequence[Part], torch: Torch | None) -> tuple[Part, ...]:
    """The parts with bevels for their skew ends; those of one object stay one.

    A part stays as it is whose rows have bevels, or whose outline has no edge at such an end.
    """
    if torch is None:
        return tuple(parts)
    known: dict[int, Part] = {}
    for part in parts:
        if id(part) not in known:
            known[id(part)] = _with_bevels(part, torch)
    return tuple([known[id(part)] for part in parts])


def _with_bevels(part: Part, torch: Torch) -> Part:
    cuts, least = part.cuts, max(torch.min_bevel, NOISE_DEG)
    ends = [
        (at_end, web, -flange if at_end == 0 else flange)
        for at_end, web, flange in ((0, cuts.web_start, cuts.flange_start),
                                    (1, cuts.web_end, cuts.flange_end))
        if abs(flange) >= least
    ]  # fmt: skip
    has_bevels = any(contour.bevels for contour in part.contours)
    is_plate = part.profile.code == "B" and part.measures is None and part.profile.height > 0.0
    if not ends or has_bevels or not is_plate:
        return part
    # By the corners of both faces a plate is as long as one without the flange cut.
    longest = outline_of(replace(part, cuts=EndCuts(cuts.web_start, cuts.web_end), features=()))
    bevels: dict[int, list[Bevel]] = {}
    drawn = outer_contours(part)
    own = drawn or {len(part.features): Contour("v", "outer", longest, part.source)}
    for at_end, web, angle in ends:
        lean = degrees(atan(tan(radians(angle)) * cos(radians(web))))
        edge = longest[1 if at_end else 3]
        sides = [
            (k, c) for k, one in own.items() for c, curve in enumerate(one.curves)
            if isinstance(curve, Line) and _is_end(curve, edge)
        ]  # fmt: skip
        if not sides:
            return part
        for k, c in sides:
            bevels.setdefault(k, []).append(Bevel(c, lean, 0.0))
    features = [*part.features, *(() if drawn else own.values())]
    for k, some in bevels.items():
        some.sort(key=lambda bevel: bevel.curve)
        features[k] = replace(own[k], bevels=tuple(some))
    return replace(part, features=tuple(features))


def _is_end(curve: Line, edge: Line) -> bool:
    """Whether a side of an outline lies along an end of the plate."""
    (x0, y0), (x1, y1) = edge.start, edge.end
    return all(
        abs(x - x0 - (y - y0) * (x1 - x0) / (y1 - y0)) <= ON_END
        for x, y in (curve.start, curve.end)
    )
