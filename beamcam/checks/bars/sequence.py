"""The order of work, place by place and part by part.

    drill -> tap         a tap cuts its thread into a hole
    drill -> countersink a countersink widens a hole, be it drilled or milled
    entry -> mill        where slots are drilled first the mill goes down into a hole
    work  -> cut         where the drills come first a part is lost to them once it is cut off

An arrow is asked about wherever its right side stands in the program. That what stands on its left
is there at all, in its size and place, is asked elsewhere.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from math import dist

from msgspec import Struct

from beamcam.checks import rules
from beamcam.checks.bars.pieces import CutPlane, LaidPart
from beamcam.checks.bars.stations import (
    Bore,
    Cut,
    MachinedFeatures,
    MachinedPath,
    StampedText,
    Thing,
)
from beamcam.checks.bars.targets import RequiredPocket
from beamcam.checks.bars.tools import Changed, Chosen, Tool, ToolCatalogue
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Spindle
from beamcam.model.part import Profile, Slot

NOUNS = {"drill": "hole", "tap": "thread", "punch": "punch mark", "mill": "slot", "scribe": "line"}


class Done(Struct, frozen=True, gc=False):
    """Work that was found to be of a part on the bar."""

    part: int
    work: Bore | MachinedPath | StampedText


def place_faults(made: MachinedFeatures, machine: Machine, name: str) -> Iterator[Diagnostic]:
    """Threads and sinks of a program that come before the hole that they need."""
    if all(bore.kind not in ("tap", "countersink") for bore in made.bores):
        return
    near = machine.format.resolution + (machine.drill.merge_tolerance if machine.drill else 0.0)
    for index, work in enumerate(made.order):
        if not isinstance(work, Bore) or work.kind not in ("tap", "countersink"):
            continue
        if not any(_is_hole_of(work, other, near) for other in made.order[:index]):
            hole = "the drill" if work.kind == "tap" else "its hole"
            yield _too_early(work, f"before {hole}", f"{hole} first", name)


def entry_faults(
    made: MachinedFeatures,
    milled: Iterable[tuple[MachinedPath, RequiredPocket]],
    catalogue: ToolCatalogue,
    name: str,
) -> Iterator[Diagnostic]:
    """Slots whose mill goes down into the full steel, where the machine drills their ends."""
    slack = 2 * catalogue.machine.format.resolution + 1e-6
    for path, target in milled:
        if not _is_drilled_first(target, catalogue):
            continue
        before = made.order[: made.order.index(path)]
        free = path.diameter / 2 - slack
        if not any(
            isinstance(bore, Bore) and bore.kind == "drill" and bore.face == path.face
            and dist(path.points[0], (bore.x, bore.y)) + free <= bore.diameter / 2
            for bore in before
        ):  # fmt: skip
            yield _too_early(path, "into the full steel", "the hole at its end first", name)


def parting_faults(
    made: MachinedFeatures, laid: Sequence[LaidPart], done: Iterable[Done],
    cuts: Sequence[CutPlane], machine: Machine, profile: Profile, name: str,
) -> Iterator[Diagnostic]:  # fmt: skip
    """Work on a part that is cut off already, where the bar comes to the drills before the saw."""
    if machine.layout is None or machine.layout.order != "drill-saw":
        return
    place: dict[int, int] = {}  #: line of some work -> its place in the order of work
    for index, work in enumerate(made.order):
        place.setdefault(work.line, index)
    freed = [None if one.piece is None else one.piece.end.cut.line for one in laid]
    for one in sorted(done, key=lambda one: one.work.line):
        cut = freed[one.part]
        if cut and place[one.work.line] > place[cut]:
            yield _cut_off(one.work, cut, name)
    rise = (-1.0 if machine.saw is not None and machine.saw.pivot == "o" else 1.0) * profile.height
    spans = {cut.cut.line: _span(cut, rise, profile.width) for cut in cuts}
    reached: tuple[float, int] | None = None  #: how far the bar is cut off, and by which line
    for line, (least, greatest) in sorted(spans.items(), key=lambda span: place[span[0]]):
        if reached is not None and greatest < reached[0]:
            cut_off = next(cut.cut for cut in cuts if cut.cut.line == line)
            yield _cut_off(cut_off, reached[1], name)
        elif reached is None or least > reached[0]:
            reached = least, line


def _span(cut: CutPlane, rise: float, width: float) -> tuple[float, float]:
    """Between which bar x a cut lies."""
    xs = [cut.along(y, z) for y in (0.0, rise) for z in (0.0, width)]
    return min(xs), max(xs)


def _is_hole_of(work: Bore, other: Thing, near: float) -> bool:
    """Whether a tap or countersink goes into what was made before."""
    if isinstance(other, Bore):
        return (
            other.kind in ("drill", "tap")
            and other.kind != work.kind
            and other.face == work.face
            and abs(other.x - work.x) <= near
            and abs(other.y - work.y) <= near
        )
    if work.kind == "tap" or not isinstance(other, MachinedPath) or other.face != work.face:
        return False
    xs, ys = [x for x, _ in other.points], [y for _, y in other.points]
    return other.kind == "mill" and (
        min(xs) - near <= work.x <= max(xs) + near and min(ys) - near <= work.y <= max(ys) + near
    )


def _is_drilled_first(target: RequiredPocket, catalogue: ToolCatalogue) -> bool:
    """Whether the machine's file has the ends of a slot drilled before it is milled."""
    slot = target.source
    return (
        isinstance(slot, Slot)
        and not slot.height
        and catalogue.drill.slots == "drill-mill"
        and bool(catalogue.fits("drill", slot.diameter, target.face))
    )


def _too_early(work: Bore | MachinedPath, found: str, expected: str, name: str) -> Diagnostic:
    x, y = work.points[0] if isinstance(work, MachinedPath) else (work.x, work.y)
    return rules.WORK_ORDER.at(
        Source(name, work.line), what=f"a {work.kind} {work.diameter:g}", face=work.face,
        x=f"{x:g}", y=f"{y:g}", found=found, expected=expected,
    )  # fmt: skip


def _cut_off(work: Thing, cut: int, name: str) -> Diagnostic:
    what = "a cut" if isinstance(work, Cut) else "a text"
    if isinstance(work, Bore | MachinedPath):
        what = f"a {NOUNS.get(work.kind, work.kind)}"
    x = work.points[0][0] if isinstance(work, MachinedPath) else work.x
    return rules.CUT_OFF.at(Source(name, work.line), what=what, found=f"{x:g}", cut=cut)


# --- stop comments --------------------------------------------------------------------------------

# What a program tells the operator at a stop for a tool, held against what it then does.
#
#     (web station 3: mill 16 for drill 18)        station 3 of that spindle holds the drill 18, and
#     N113 M06 K2 L16                              from here on the mill 16
#
# The comment is what the operator goes by: where it names another tool than the program works with
# next, another spindle, a station that holds something else, or sends away a tool that is still
# needed, the work goes on with the wrong tool. What stands in a station before its first stop no
# program says.


_TOOL = r"([a-z]+)\s+m?([0-9.]+)\b[^()]*?"
_STOP = re.compile(
    rf"(\S[^():]*?)\s+station\s+([0-9]+)\s*:\s*{_TOOL}(?:\s+for\s+{_TOOL})?\s*(?:[)\]]|$)"
)


class StopComment(Struct, frozen=True):
    """What the operator is told to do."""

    line: int
    spindle: str  #: its name
    station: int
    new: Tool
    old: Tool | None

    def __str__(self) -> str:
        out = f" for {_shown(self.old)}" if self.old else ""
        return f"{self.spindle} station {self.station}: {_shown(self.new)}{out}"


def stop_comments(text: str) -> tuple[StopComment, ...]:
    """What a program tells the operator about tools, in its order."""
    comments = []
    for number, line in enumerate(text.splitlines(), 1):
        match = _STOP.search(line.lower()) if "station" in line.lower() else None
        if match is not None:
            spindle, station, kind, size, old_kind, old_size = match.groups()
            old = (old_kind, float(old_size)) if old_kind else None
            name = " ".join(spindle.split()).lstrip("([;")
            comments.append(StopComment(number, name, int(station), (kind, float(size)), old))
    return tuple(comments)


def comment_faults(
    comments: Sequence[StopComment], tools: Sequence[Chosen | Changed], machine: Machine, name: str
) -> Iterator[Diagnostic]:
    """What of the comments is not so. `tools` are the choices and the stops of the program."""
    stated: dict[int, StopComment] = {}  #: by the line of their stop
    stops = [one.line for one in tools if isinstance(one, Changed)]
    for comment in comments:
        line = next((line for line in stops if line >= comment.line), None)
        if line is None or line in stated:
            yield _wrong(comment, "no stop behind it", "a stop of its own", name)
        else:
            stated[line] = comment
    for line in stops if stated else ():
        if line not in stated:
            expected = "a comment that says which tool goes where, as others have"
            yield rules.STOP_COMMENT.at(Source(name, line), found="a stop", expected=expected)
    for spindle in machine.spindles:
        yield from _of_spindle(spindle, stated, tools, machine, name)


def _of_spindle(
    spindle: Spindle, comments: dict[int, StopComment], tools: Sequence[Chosen | Changed],
    machine: Machine, name: str,
) -> Iterator[Diagnostic]:  # fmt: skip
    """Faults of what is said of the stations of one spindle."""
    numbers = {p.number for p in machine.pairs if spindle.face in p.faces} | {spindle.number}
    stations: dict[int, Tool] = {}
    held: set[Tool] = set()  #: that the program worked with, or that were put in
    gone: dict[Tool, StopComment] = {}
    for index, one in enumerate(tools):
        if isinstance(one, Chosen):
            if one.spindle in numbers:
                if one.tool in gone:
                    said_before = gone[one.tool]
                    yield rules.STOP_COMMENT.at(
                        Source(name, one.line), found=f"a {_shown(one.tool)} chosen",
                        expected=f"another tool, line {said_before.line} says '{said_before}'",
                    )  # fmt: skip
                held.add(one.tool)
            continue
        comment = comments.get(one.line)
        is_of = one.spindle == spindle.number
        if one.spindle is None:
            is_of = comment is not None and comment.spindle == spindle.name.lower()
        if comment is None or not is_of:
            continue
        new, old = comment.new, comment.old
        later = [t.tool for t in tools[index:] if isinstance(t, Chosen) and t.spindle in numbers]
        if comment.spindle != spindle.name.lower():
            yield _wrong(comment, f"a stop for spindle {spindle.number}", spindle.name, name)
        if one.diameter is not None and abs(one.diameter - new[1]) > 0.0006:
            yield _wrong(comment, f"a stop for a tool of {one.diameter:g}", _shown(new), name)
        if new not in later:
            yield _wrong(comment, f"no work with {_shown(new)} behind it", "some", name)
        if not 1 <= comment.station <= spindle.stations:
            expected = f"a station from 1 to {spindle.stations}"
            yield _wrong(comment, f"station {comment.station}", expected, name)
        there = stations.get(comment.station)
        if old is not None and (old != there if there else old not in held):
            found = f"{_shown(there)} in the station" if there else f"no {_shown(old)} before"
            yield _wrong(comment, found, _shown(old), name)
        if old is not None:
            gone[old] = comment
            held.discard(old)
        gone.pop(new, None)
        held.add(new)
        stations[comment.station] = new


def _shown(tool: Tool) -> str:
    return f"{tool[0]} {tool[1]:g}"


def _wrong(comment: StopComment, found: str, expected: str, name: str) -> Diagnostic:
    return rules.STOP_COMMENT.at(
        Source(name, comment.line), found=f"'{comment}' and {found}", expected=expected
    )
