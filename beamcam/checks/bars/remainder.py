"""The remainder of a program after a stop in mid bar, read back behind what was done before it.

    whole program   head | 1 | 2 | 3 | 4 | 5 | foot
    done            head | 1 | 2 | 3 |                the events up to the stop
    remainder                      head | 4 | 5 | foot

The operations of the whole program are counted in what it makes: cuts, strokes and paths, where
two spindles that drill at once are one.
"""

from collections.abc import Collection, Iterator, Sequence
from math import isnan

from msgspec.structs import replace

from beamcam.checks.bars import BarRun, compared, run, run_of_events, section_of
from beamcam.checks.bars.magazine import comment_faults, stop_comments
from beamcam.checks.bars.stations import MachinedFeatures
from beamcam.checks.rules import NO_OPERATION, STOP_COMMENT, TOOL_CHANGE, WORK_ORDER
from beamcam.controllers import cell_events
from beamcam.controllers.dialect import Dialect
from beamcam.controllers.events import BarEvent, Lettering, Move, Switch
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.model.part import Part

#: M words that begin another operation, or end the program.
_BEGINS = ("choose", "saw", "change", "end")


def operation_lines(made: MachinedFeatures) -> tuple[int, ...]:
    """The line of each operation of a program, in its order."""
    return tuple(dict.fromkeys(one.line for one in made.order))


def verify_remainder(
    whole: str, rest: str, first: int, parts: Sequence[Part], machine: Machine,
    skips: Collection[str] = (), name: str = "program", whole_name: str = "whole program",
    order: str = "given", turn: bool = False, bar: float | None = None,
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """All faults of the remainder from operation `first` on of a whole program.

    It is read by itself, as nothing in it may count on what was said before, and behind the
    operations that were done, which together have to make the parts.
    """
    grades = tuple(dict.fromkeys(part.grade for part in parts))
    profile = section_of(whole, machine, parts[0], turn)
    begun = run(whole, machine, profile, whole_name, grades)
    lines = operation_lines(begun.made)
    if not 2 <= first <= len(lines):
        return (NO_OPERATION.at(Source(whole_name), found=first, expected=len(lines)),)
    alone = run(rest, machine, profile, name, grades)
    # Which tools are in their stations, and what was drilled, it cannot know by itself.
    behind = TOOL_CHANGE.code, WORK_ORDER.code, STOP_COMMENT.code
    said = [one for one in alone.diagnostics if one.code not in behind]
    done = tuple(_done(begun, lines[first - 2]))
    after = whole.count("\n") + 1
    moved = [replace(e, line=e.line + after) for e in cell_events(rest, machine, name)[0]]
    both = run_of_events([*done, *moved], machine, profile, name, grades)
    told_stops = [c for c in stop_comments(whole) if c.line <= done[-1].line]
    told_stops += (replace(c, line=c.line + after) for c in stop_comments(rest))
    diagnostics = (
        *both.diagnostics, *comment_faults(told_stops, both.tools, machine, name),
        *compared(both, parts, machine, profile, skips, name, order, turn, bar),
    )  # fmt: skip
    keys = {(one.code, one.source.line, one.values) for one in said}
    placed = (_placed(one, after, name, whole_name) for one in diagnostics)
    said += [one for one in placed if (one.code, one.source.line, one.values) not in keys]
    return tuple(said)


def _done(whole: BarRun, last: int) -> Iterator[BarEvent]:
    """The events up to the end of the operation that works on a line.

    It ends where another begins: with the choice of a spindle or a stop, before a cut or a text
    with the bar's move to it.
    """
    events, dialect = whole.events, whole.dialect
    at = next(k for k, event in enumerate(events) if event.line == last)
    end = next(k for k in range(at + 1, len(events)) if _begins(events[k], last, dialect))
    if isinstance(events[end], Lettering) or _role(events[end], dialect) == "saw":
        while end > at + 1 and _leads_to_it(events[end - 1], last, dialect):
            end -= 1
    yield from events[:end]


def _leads_to_it(event: BarEvent, last: int, dialect: Dialect) -> bool:
    """Whether an event before a cut or a text belongs to it: a move of the bar alone, or a word
    without a meaning of its own. A move across draws a tool back from the work before."""
    if event.line <= last:
        return False
    if isinstance(event, Move):
        before, behind = event.start[1:], event.end[1:]
        return all(a == b or isnan(b) for a, b in zip(before, behind, strict=True))
    return isinstance(event, Switch) and _role(event, dialect) in ("", "other")


def _begins(event: BarEvent, last: int, dialect: Dialect) -> bool:
    begins = isinstance(event, Lettering) or _role(event, dialect) in _BEGINS
    return begins and event.line > last


def _role(event: BarEvent, dialect: Dialect) -> str:
    if not isinstance(event, Switch):
        return ""
    word = dialect.m_words.get(event.number)
    return word.role if word else ""


def _placed(diagnostic: Diagnostic, after: int, name: str, whole_name: str) -> Diagnostic:
    """A message at its line of the remainder, or of the whole program."""
    line = diagnostic.source.line
    if diagnostic.source.file != name or line is None:
        return diagnostic
    source = Source(whole_name, line) if line <= after else Source(name, line - after)
    return replace(diagnostic, source=source)
