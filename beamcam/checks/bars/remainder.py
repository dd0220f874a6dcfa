"""The remainder of a program after a stop in mid bar, read back behind what was done before it.

    whole program   head | 1 | 2 | 3 | 4 | 5 | foot
    done            head | 1 | 2 | 3 |                the events up to the stop
    remainder                      head | 4 | 5 | foot

The operations of the whole program are counted in what it makes: cuts, strokes and paths, where
two spindles that drill at once are one.
"""

from collections.abc import Collection, Sequence
from math import isnan

from msgspec.structs import replace

from beamcam.checks.bars import BarRun, compared, lying_section, run, run_of_events
from beamcam.checks.bars.magazine import comment_faults, stop_comments
from beamcam.checks.rules import NO_OPERATION, STOP_COMMENT, TOOL_CHANGE, WORK_ORDER
from beamcam.controllers import cell_events
from beamcam.controllers.dialect import Dialect
from beamcam.controllers.events import BarEvent, Lettering, Move, Switch
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.model.part import Part

#: M words that begin another operation, or end the program.
_BEGINS = ("choose", "saw", "change", "end")


def verify_remainder(
    whole: str, rest: str, first: int, parts: Sequence[Part], machine: Machine,
    skips: Collection[str] = (), name: str = "program", whole_name: str = "whole program",
    order: str = "given", turn: bool = False, bar: float | None = None,
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """All faults of the remainder from operation `first` on of a whole program.

    It is read by itself, as nothing in it may count on what came before, and behind the
    operations that were done, which together have to make the parts.
    """
    grades = tuple(dict.fromkeys(part.grade for part in parts))
    profile = parts[0].profile
    if turn:
        profile = lying_section(run(whole, machine, profile).made, parts[0])
    begun = run(whole, machine, profile, whole_name, grades)
    lines = [*dict.fromkeys(one.line for one in begun.made.order)]  #: of each operation
    if not 2 <= first <= len(lines):
        return (NO_OPERATION.at(Source(whole_name), found=first, expected=len(lines)),)
    alone = run(rest, machine, profile, name, grades)
    # Which tools are in their stations, and what was drilled, it cannot know by itself.
    behind = TOOL_CHANGE.code, WORK_ORDER.code, STOP_COMMENT.code
    diagnostics = [one for one in alone.diagnostics if one.code not in behind]
    done = _done(begun, lines[first - 2])
    after = whole.count("\n") + 1
    moved = [replace(e, line=e.line + after) for e in cell_events(rest, machine, name)[0]]
    both = run_of_events([*done, *moved], machine, profile, name, grades)
    comments = [c for c in stop_comments(whole) if c.line <= done[-1].line]
    comments += (replace(c, line=c.line + after) for c in stop_comments(rest))
    keys = {(one.code, one.source.line, one.values) for one in diagnostics}
    for one in (
        *both.diagnostics, *comment_faults(comments, both.tools, machine, name),
        *compared(both, parts, machine, profile, skips, name, order, turn, bar),
    ):  # fmt: skip
        line, placed = one.source.line, one
        if one.source.file == name and line is not None:  # of the whole program, or the remainder
            at = Source(whole_name, line) if line <= after else Source(name, line - after)
            placed = replace(one, source=at)
        if (placed.code, placed.source.line, placed.values) not in keys:
            diagnostics.append(placed)
    return tuple(diagnostics)


def _done(whole: BarRun, last: int) -> Sequence[BarEvent]:
    """The events up to the end of the operation that works on a line.

    It ends where another begins: with the choice of a spindle or a stop, before a cut or a text
    with the bar's move to it.
    """
    events, dialect = whole.events, whole.dialect
    at = next(k for k, event in enumerate(events) if event.line == last)
    end = next(
        k for k in range(at + 1, len(events)) if events[k].line > last
        and (isinstance(events[k], Lettering) or _role(events[k], dialect) in _BEGINS)
    )  # fmt: skip
    if isinstance(events[end], Lettering) or _role(events[end], dialect) == "saw":
        while end > at + 1 and _leads_to_it(events[end - 1], last, dialect):
            end -= 1
    return events[:end]


def _leads_to_it(event: BarEvent, last: int, dialect: Dialect) -> bool:
    """Whether an event before a cut or a text belongs to it: a move of the bar alone, or a word
    without a meaning of its own. A move across draws a tool back from the work before."""
    if event.line <= last:
        return False
    if isinstance(event, Move):
        before, behind = event.start[1:], event.end[1:]
        return all(a == b or isnan(b) for a, b in zip(before, behind, strict=True))
    return isinstance(event, Switch) and _role(event, dialect) in ("", "other")


def _role(event: BarEvent, dialect: Dialect) -> str:
    if not isinstance(event, Switch):
        return ""
    word = dialect.m_words.get(event.number)
    return word.role if word else ""
