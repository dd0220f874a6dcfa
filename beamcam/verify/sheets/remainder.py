"""The rest of a sheet's program, compared with the whole program that was stopped.

    whole   head | 1 | 2 | 3 | 4 | 5 | foot        read back by itself, against the parts
    rest                  head | 4 | 5 | foot      by itself it makes the last strokes of the whole

Contours are counted in what the whole program makes: strokes with bridges between them are one, and
so are passes one on the other.
"""

from collections.abc import Collection, Sequence

import numpy as np
from msgspec.structs import replace

from beamcam.controllers import table_events, table_run
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.asked_layout import as_asked
from beamcam.verify.sheets.chains import unchained
from beamcam.verify.sheets.controller_state import as_one
from beamcam.verify.sheets.need import need_of, rows_of, shift_of
from beamcam.verify.sheets.order import passes_folded
from beamcam.verify.sheets.paths import follow
from beamcam.verify.sheets.strokes import HeadStroke, Strokes, strokes_of
from beamcam.verify.sheets.work import work_of

SAID = "REST FROM CONTOUR {first} OF {count}."  #: in a comment of the rest


def rest_faults(
    whole: str,
    rest: str,
    first: int,
    parts: Sequence[Part],
    machine: Machine,
    skips: Collection[str] = (),
    name: str = "program",
    whole_name: str = "whole program",
) -> tuple[Diagnostic, ...]:
    """All faults of the rest from contour `first` on of a whole program, which is sound itself."""
    laid, said = as_asked(parts, machine.torch)
    if said:
        return tuple(said)
    part, machine, said = as_one(laid, machine, skips)
    begun, more = _strokes(whole, part, machine, whole_name)
    left, wrong = _strokes(rest, part, machine, name)
    said = [*said, *more, *wrong]
    if errors_in(said):
        return tuple(said)
    lines = _contour_lines(begun, part, machine, skips, whole_name)
    if not 2 <= first <= len(lines):
        return (rules.NO_CONTOUR.at(Source(whole_name), found=first, expected=len(lines)),)
    expected = [s for s in begun.each if s.line >= lines[first - 1]]
    if len(left.each) != len(expected):
        found, wanted = f"{len(left.each)} strokes", f"the last {len(expected)} of the whole"
        said.append(rules.REST.at(Source(name), found=found, expected=wanted))
        return tuple(said)
    for one, other in zip(left.each, expected, strict=True):
        what = _difference(one, left, other, begun)
        if what:
            wanted = f"that of line {other.line} of the whole program"
            said.append(rules.REST.at(Source(name, one.line), found=what, expected=wanted))
            return tuple(said)
    words = SAID.format(first=first, count=len(lines))
    if words not in rest:
        found = "no comment that says from where it goes on"
        said.append(rules.REST.at(Source(name), found=found, expected=words))
    return tuple(said)


def _strokes(
    text: str, part: Part, machine: Machine, name: str
) -> tuple[Strokes, list[Diagnostic]]:
    torch = machine.needed(machine.torch, "torch")
    done, said = table_run(text, machine, name)
    if errors_in(said):
        return Strokes([], done.moves), list(said)
    telling = replace(machine, torch=replace(torch, laser_mode=False))
    found, more = strokes_of(
        done, machine, torch, rows_of(part, torch),
        lambda blocks: table_events(blocks, telling)[0], name,
    )  # fmt: skip
    return found, [*said, *more]


def _contour_lines(
    strokes: Strokes, part: Part, machine: Machine, skips: Collection[str], name: str
) -> list[int]:
    """The line at which the tool is started for each contour, ascending."""
    torch = machine.needed(machine.torch, "torch")
    folded = passes_folded(strokes, rows_of(part, torch))
    folded, _ = unchained(folded, torch, machine.format.resolution)
    need = need_of(part, machine, torch, skips)
    lines: list[int] = []
    for process in dict.fromkeys(s.process for s in folded.each):
        shift = shift_of(need, torch)
        work = work_of(process, folded, need, machine.format.resolution, torch, shift, name)
        if not work.need.count or not torch.tabs:
            lines += [s.line for s in work.strokes]
            continue
        traced, _ = follow(work)
        lines += [t.stroke.line for t in traced if t.members or not t.joined]
    return sorted(lines)


def _difference(one: HeadStroke, left: Strokes, other: HeadStroke, begun: Strokes) -> str:
    """What is not the same in two strokes; empty if they are."""
    if one.row != other.row:
        return "a stroke by another row of the cut chart"
    if (one.side, one.radius) != (other.side, other.radius):
        return "a stroke with another compensation"
    a, b = (
        part.moves.take(np.arange(stroke.first, stroke.last))
        for stroke, part in ((one, left), (other, begun))
    )
    if len(a) != len(b):
        return f"a stroke of {len(a)} moves"
    for column in ("start", "end", "is_arc", "arcs", "feed_mm_min"):
        same = np.isclose(getattr(a, column), getattr(b, column), rtol=0.0, atol=1e-9)
        if not same.all():
            return "a stroke that runs elsewhere, or with another feed"
    return "" if a.curves == b.curves else "a stroke along another curve"
