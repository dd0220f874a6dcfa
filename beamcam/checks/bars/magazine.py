"""The tools in the stations of spindles: changed at stops, and the comments for the operator.

What is put in before the program starts is not written down; it is taken to be the tools that the
program needs first. At each stop a tool comes in, for one that is needed last of all: if even so
a tool is chosen that cannot be there, the program has forgotten to stop for it.
"""

import re
from collections.abc import Iterator, Sequence

from msgspec import Struct

from beamcam.checks import rules
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Spindle

Tool = tuple[str, float]  #: kind and diameter


class Chosen(Struct, frozen=True, gc=False):
    """A tool selected for a spindle."""

    line: int
    spindle: int  #: or the number of a pair of them
    tool: Tool


class Changed(Struct, frozen=True, gc=False):
    """A stop for a manual tool change; None where the word does not name the tool."""

    line: int
    spindle: int | None
    diameter: float | None


def change_faults(
    tools: Sequence[Chosen | Changed], machine: Machine, name: str
) -> Iterator[Diagnostic]:
    """Tools that are chosen though no station can hold them by then, and idle stops."""
    chosen = [one.tool for one in tools if isinstance(one, Chosen)]
    fewest = min((s.stations for s in machine.spindles), default=0)
    if len(chosen) == len(tools) and len(set(chosen)) <= fewest:
        return
    for spindle in machine.spindles:
        for one in _wrong_changes(_own(tools, spindle, machine), spindle.stations):
            if isinstance(one, Chosen):
                found, stations = f"a {_shown(one.tool)} chosen", spindle.stations
                expected = f"a stop before that puts it into one of the {stations} stations"
            else:
                found = f"a stop for a tool of {one.diameter or 0.0:g}"
                expected = "a stroke behind it with such a tool that was not there before"
            yield rules.TOOL_CHANGE.at(
                Source(name, one.line), found=found, spindle=spindle.number, expected=expected
            )


def _own(
    tools: Sequence[Chosen | Changed], spindle: Spindle, machine: Machine
) -> list[Chosen | Changed]:
    """The tool selections of a spindle, alone or paired, and the stops for it or for any."""
    numbers = {p.number for p in machine.pairs if spindle.face in p.faces} | {spindle.number}
    stops = (spindle.number, None)
    return [one for one in tools if one.spindle in (numbers if isinstance(one, Chosen) else stops)]


def _wrong_changes(own: Sequence[Chosen | Changed], stations: int) -> Iterator[Chosen | Changed]:
    """Selections of tools that cannot be in a spindle's stations yet, and stops without need.

    `own` are the tools that the spindle is commanded to take and the stops for them,
    in their order.
    """
    loaded: set[Tool] = set()
    started = False  #: whether all stations have had their first tool
    for at, one in enumerate(own):
        is_full = started or len(loaded) >= stations
        if isinstance(one, Chosen):
            if one.tool in loaded:
                continue
            new: Tool | None = one.tool
            if is_full:
                yield one
        else:  # it brings the next tool that is needed and not there
            later = (o.tool for o in own[at:] if isinstance(o, Chosen) and o.tool not in loaded)
            size = one.diameter
            new = next((t for t in later if size is None or abs(t[1] - size) < 0.001), None)
        if new is None:
            if one.spindle is not None:
                yield one
            continue
        started = is_full
        if len(loaded) >= stations:  # what is needed last of all goes out
            uses = [o.tool for o in own[at:] if isinstance(o, Chosen)]
            last = len(uses)
            loaded.discard(max(sorted(loaded), key=lambda t: uses.index(t) if t in uses else last))
        loaded.add(new)


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
    """What the operator has to do at a stop."""

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
    """Faults of the comments about the stations of one spindle."""
    own = _own(tools, spindle, machine)
    stations: dict[int, Tool] = {}
    held: set[Tool] = set()  #: that the program worked with, or that were put in
    gone: dict[Tool, StopComment] = {}
    for index, one in enumerate(own):
        if isinstance(one, Chosen):
            if (before := gone.get(one.tool)) is not None:
                found = f"a {_shown(one.tool)} chosen"
                expected = f"another tool, line {before.line} says '{before}'"
                source = Source(name, one.line)
                yield rules.STOP_COMMENT.at(source, found=found, expected=expected)
            held.add(one.tool)
            continue
        comment = comments.get(one.line)
        if comment is None or (one.spindle is None and comment.spindle != spindle.name.lower()):
            continue
        new, old = comment.new, comment.old
        later = [t.tool for t in own[index:] if isinstance(t, Chosen)]
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
