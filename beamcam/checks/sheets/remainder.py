"""The rest of a sheet's program, compared with the whole program that was stopped.

    whole   head | 1 | 2 | 3 | 4 | 5 | foot        read back by itself, against the parts
    rest                  head | 4 | 5 | foot      by itself it makes the last strokes of the whole

Contours are counted in what the whole program makes: strokes with bridges between them are one, and
so are passes one on the other.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.asked_sheet import rows_of
from beamcam.checks.sheets.need import Need, need_of, shift_of
from beamcam.checks.sheets.paths import follow
from beamcam.checks.sheets.required_layout import as_one, laid_out
from beamcam.checks.sheets.strokes import HeadStroke, Strokes, strokes_of
from beamcam.checks.sheets.toolpaths import Toolpaths
from beamcam.checks.sheets.work import work_of
from beamcam.controllers import table_run
from beamcam.controllers.events import Switch
from beamcam.controllers.moves import Moves
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.geometry.array_types import Floats
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchRow
from beamcam.model.part import Part

COMMENT = "REST FROM CONTOUR {first} OF {count}."  #: in a comment of the rest


def rest_faults(
    whole: str, rest: str, first: int, parts: Sequence[Part], machine: Machine,
    skips: Collection[str] = (), name: str = "program", whole_name: str = "whole program",
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """All faults of the rest from contour `first` on of a whole program, which is sound itself."""
    laid, diagnostics = laid_out(parts, machine.torch)
    if diagnostics:
        return tuple(diagnostics)
    sheet = as_one(laid, machine, skips)
    part, machine = sheet.part, sheet.machine
    begun, more = _strokes(whole, part, machine, whole_name)
    left, wrong = _strokes(rest, part, machine, name)
    diagnostics = [*sheet.diagnostics, *more, *wrong]
    if errors_in(diagnostics):
        return tuple(diagnostics)
    lines = _contour_lines(begun, part, machine, skips, whole_name)
    if not 2 <= first <= len(lines):
        return (rules.NO_CONTOUR.at(Source(whole_name), found=first, expected=len(lines)),)
    required = [s for s in begun.each if s.line >= lines[first - 1]]
    words, line = COMMENT.format(first=first, count=len(lines)), None
    pairs = zip(left.each, required, strict=False)
    other = next((pair for pair in pairs if _difference(*pair, left, begun)), None)
    found = expected = ""
    if len(left.each) != len(required):
        found, expected = f"{len(left.each)} strokes", f"the last {len(required)} of the whole"
    elif other is not None:
        found, line = _difference(*other, left, begun), other[0].line
        expected = f"that of line {other[1].line} of the whole program"
    elif words not in rest:
        found, expected = "no comment that says from where it goes on", words
    if found:
        diagnostics.append(rules.REST.at(Source(name, line), found=found, expected=expected))
    return tuple(diagnostics)


def _strokes(
    text: str, part: Part, machine: Machine, name: str
) -> tuple[Strokes, list[Diagnostic]]:
    torch = machine.needed(machine.torch, "torch")
    done, diagnostics = table_run(text, machine, name)
    if errors_in(diagnostics):
        return Strokes([], done.moves), list(diagnostics)
    strokes, more = strokes_of(done, machine, torch, rows_of(part, torch), name)
    return strokes, [*diagnostics, *more]


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


def _difference(one: HeadStroke, other: HeadStroke, left: Strokes, begun: Strokes) -> str:
    """What is not the same in two strokes, of some each; empty if they are."""
    if one.row != other.row:
        return "a stroke by another row of the cut chart"
    if (one.side, one.radius) != (other.side, other.radius):
        return "a stroke with another compensation"
    own, others = range(one.first, one.last), range(other.first, other.last)
    if len(own) != len(others):
        return f"a stroke of {len(own)} moves"
    for column in ("start", "end", "is_arc", "arcs", "feed_mm_min"):
        a, b = getattr(left.moves, column), getattr(begun.moves, column)
        if not np.array_equal(a[one.first : one.last], b[other.first : other.last]):
            return "a stroke that runs elsewhere, or with another feed"
    a, b = left.moves.curves, begun.moves.curves
    same = all(a.get(i) == b.get(k) for i, k in zip(own, others, strict=True))
    return "" if same else "a stroke along another curve"


# --- frame ----------------------------------------------------------------------------------------

# The frame of a job, compared with the program of the job: round all of its work, the tool off.
#
# A laser in laser mode may be on, at the power of frames and no other.


FRAMED, FRAMED_LOW = "FRAME OF THE JOB, THE TOOL OFF", "FRAME OF THE JOB, AT LOW POWER"
#: M words of a frame: the end, the tool off, coolant and overrides.
HARMLESS = frozenset({2, 30, 5, 9, 48, 49, 52, 53})
FASTEST = 1.001  #: by the feed of frames
FINE = 1e-4  #: mm that chords of curves which are no arcs may be off


def frame_comment(torch: Torch) -> str:
    """What a frame says of itself."""
    return FRAMED_LOW if torch.frame_power else FRAMED


def frame_faults(
    text: str, whole: str, machine: Machine, name: str = "program"
) -> tuple[Diagnostic, ...]:
    """All faults of the frame of a whole program."""
    torch = machine.needed(machine.torch, "torch")
    done, diagnostics = table_run(text, machine, name)
    job, _ = table_run(whole, machine, name)
    diagnostics = list(diagnostics)

    def fault(found: str, expected: str, line: int | None = None) -> None:
        diagnostics.append(rules.FRAME.at(Source(name, line), found=found, expected=expected))

    switches = [event for _, event in done.others if isinstance(event, Switch)]
    for event in switches:
        # Harmless is what starts no tool, or a laser at the power of frames.
        is_on = torch.frame_power and event.number in (3, 4)
        is_low = is_on and event.words.get("S") == torch.frame_power
        if not (event.number in HARMLESS or event.does == "none" or is_low):
            low = f", or the tool at {torch.frame_power:g}" if torch.frame_power else ""
            fault(f"the word {event}", f"no tool switched on{low}", event.line)
    if torch.frame_power and not any(event.number in (3, 4) for event in switches):
        fault("the laser off", f"it at a power of {torch.frame_power:g}")
    if errors_in(diagnostics):
        return tuple(diagnostics)
    around, frame = _box(job.moves), _box(done.moves)
    slow = done.moves.take(np.flatnonzero(~done.moves.rapid))
    if not len(slow) or np.abs(frame - around).max() > torch.tolerance:
        found, expected = (
            " to ".join(f"X {x:.3f} Y {y:.3f}" for x, y in (box[:2], box[2:]))
            for box in (frame, around)
        )
        fault(f"a frame from {found}", expected)
        return tuple(diagnostics)
    x0, y0, x1, y1 = around.tolist()
    corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)])
    passed = np.concatenate((slow.start[:1], slow.end))
    feed = float(slow.feed_mm_min.max())
    if slow.is_arc.any() or len(passed) != 5 or np.abs(passed - corners).max() > torch.tolerance:
        fault("another way", "the four corners of the work, one after the other")
    elif feed > FASTEST * torch.frame_mm_min:
        fault(f"a feed of {feed:g} mm/min", f"{torch.frame_mm_min:g}")
    if (comment := frame_comment(torch)) not in text:
        fault("no word of what it is", comment)
    return tuple(diagnostics)


def _box(moves: Moves) -> Floats:
    """The box around the moves that are no traverses: least X and Y, greatest X and Y."""
    slow = moves.take(np.flatnonzero(~moves.rapid))
    if not len(slow):
        return np.full(4, np.nan)
    low, high = Toolpaths.of_moves(slow, FINE).boxes
    return np.concatenate((low.min(axis=0), high.max(axis=0)))


# --- chains ---------------------------------------------------------------------------------------

# Strokes that go round several parts, taken apart at the links between them.
#
# pierce, lead    outline     link      outline     lead-out
#     . . . . .==============- - - - -==============. . . .
#              first stroke            second stroke
#
# Found in the path alone: a stroke that has come back to a corner which it passed, and goes on by
# one straight move to a place from which it comes back again. A link lies in waste: nearer to no
# contour than half a kerf, and to nothing that is cut before or later than by a whole one, but for
# the two contours at its ends.


LONGER = 1.001  #: by which a link may be longer than asked, as its ends are rounded
CLOSED = 0.25  #: share of a link behind each of its ends where the cut there is still open


class Link(Struct, frozen=True):
    """The way from one part to the next, with the tool on."""

    line: int  #: of the program
    ends: tuple[Point, Point]
    before: int  #: the stroke that it leaves; the next is the one that it leads to


def unchained(strokes: Strokes, torch: Torch, step: float) -> tuple[Strokes, list[Link]]:
    """The strokes of single parts, and the links between them, where the machine's file has any."""
    if not torch.chain_cuts:
        return strokes, []
    each: list[HeadStroke] = []
    links: list[Link] = []
    kept = np.ones(len(strokes.moves), dtype=bool)
    for one in strokes.each:
        ends = _links(strokes.moves, one, step) if one.process == "cut" else []
        bounds = [one.first, *(k for at in ends for k in (at, at + 1)), one.last]
        for number, (first, last) in enumerate(zip(bounds[::2], bounds[1::2], strict=True)):
            line = one.line if not number else int(strokes.moves.line[first])
            each.append(
                replace(
                    one, line=line, first=first, last=last, is_linked=number > 0,
                    goes_on=number < len(ends), dark=0 if number < len(ends) else one.dark,
                )
            )  # fmt: skip
            if number < len(ends):
                kept[last] = False
                line, own = int(strokes.moves.line[last]), (strokes.moves.start, strokes.moves.end)
                (x0, y0), (x1, y1) = (places[last].tolist() for places in own)
                links.append(Link(line, ((x0, y0), (x1, y1)), len(each) - 1))
    return (strokes.kept(each, kept), links) if links else (strokes, [])


def _links(moves: Moves, stroke: HeadStroke, step: float) -> list[int]:
    """The moves of a stroke that lead from a ring which has closed to the next one."""
    own = range(stroke.first, stroke.last)
    corners = [moves.start[own.start].tolist(), *moves.end[own.start : own.stop].tolist()]
    cells = [(round(x / (2 * step)), round(y / (2 * step))) for x, y in corners]
    again = {cell: k for k, cell in enumerate(cells)}  # the last time that each is passed
    links: list[int] = []
    passed: dict[tuple[int, int], int] = {}
    for k, cell in enumerate(cells[:-1]):
        is_back = cell in passed
        passed[cell] = k
        begins = cells[k + 1]
        leads_on = begins not in passed and again[begins] > k + 1 and not moves.is_arc[own[k]]
        if is_back and leads_on:
            links.append(own[k])
    return links


def link_faults(
    links: Sequence[Link], strokes: Strokes, need: Need, torch: Torch, shift: tuple[float, float],
    name: str,
) -> Iterator[Diagnostic]:  # fmt: skip
    """Links that are too long, touch a part, or run into what is cut."""
    if not links:
        return
    fine = torch.tolerance / 8
    kerf = max((one.row.kerf for one in strokes.each if one.process == "cut"), default=0.0)
    parts = shapely.STRtree(need.toolpaths("cut", fine).moved(shift).lines(fine))
    owner = np.repeat(np.arange(len(strokes.each)), [s.last - s.first for s in strokes.each])
    paths = Toolpaths.of_moves(strokes.moves, fine).lines(fine, owner)
    tree = shapely.STRtree(paths)
    slack = torch.tolerance + 2 * fine
    for link in links:
        line = shapely.LineString(link.ends)
        ends = (link.before, link.before + 1)
        inner = shapely.LineString(
            [line.interpolate(at, normalized=True) for at in (CLOSED, 1 - CLOSED)]
        )
        others = {*tree.query(line, "dwithin", distance=kerf - slack).tolist()} - {*ends}
        crossed = [k for k in ends if inner.intersects(paths[k])]
        found = expected = ""
        if line.length > torch.chain_cuts * LONGER:
            found, expected = f"{line.length:.3f} mm long", f"at most {torch.chain_cuts:g} mm"
        elif len(parts.query(line, "dwithin", distance=kerf / 2 - slack)):
            found, expected = f"nearer to a contour than {kerf / 2:g} mm", "it in waste"
        elif others or crossed:
            other = strokes.each[min(others or crossed)].line
            found, expected = f"across the cut of line {other}", "metal all along it"
        if found:
            (x0, y0), (x1, y1) = ((f"{x:.3f}", f"{y:.3f}") for x, y in link.ends)
            places = {"x0": x0, "y0": y0, "x1": x1, "y1": y1}
            yield rules.LINK.at(Source(name, link.line), found=found, expected=expected, **places)


# --- passes ---------------------------------------------------------------------------------------

# Contours that are followed several times: passes one after the other, taken for one stroke.


def passes_folded(strokes: Strokes, rows: Iterable[TorchRow]) -> Strokes:
    """Strokes of which each counts its passes; equal ones count as such only behind one another.

    Where no row has more than one pass the strokes come back as they are.
    """
    if all(row.passes == 1 for row in rows):
        return strokes
    each: list[HeadStroke] = []
    kept = np.ones(len(strokes.moves), dtype=bool)
    for stroke in strokes.each:
        if each and not _difference(each[-1], stroke, strokes, strokes):
            each[-1] = replace(each[-1], passes=each[-1].passes + 1)
            kept[stroke.first : stroke.last] = False
        else:
            each.append(stroke)
    return strokes.kept(each, kept)
