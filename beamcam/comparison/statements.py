"""Statements of programs for cutting tables and copers, compared whatever their writing is.

G-code is compared by what its interpreter makes of it, so that block numbers, spacing, comments
and modal words that are left out count for nothing. Trigger programs and step tables are compared
line by line, without comments and spacing.
"""

import re
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from math import dist, isnan
from typing import NamedTuple

from beamcam.checks.coping.strokes import TorchStroke
from beamcam.comparison.bars import diff_programs
from beamcam.comparison.pairing import Difference, ThingPair, moved, paired
from beamcam.controllers import cell_events, table_events
from beamcam.controllers.events import (
    Acceleration,
    BarEvent,
    Blending,
    Compensation,
    FeedShare,
    Lift,
    Material,
    Move,
    Output,
    Pause,
    Switch,
    TableEvent,
    ToolOffset,
    Touch,
    Zero,
)
from beamcam.errors import Diagnostic, errors_in
from beamcam.geometry.curves import Arc, EllipseArc
from beamcam.machine.machine import Machine
from beamcam.machine.tables import DIALECTS

_ST_COMMENT = re.compile(r"\(\*.*?\*\)|//[^\n]*", re.DOTALL)


def diff_statements(
    first: Sequence[str], second: Sequence[str], decimals: int
) -> tuple[Difference, ...]:
    """Differences of the statements of program B from those of A."""
    from difflib import SequenceMatcher

    differences = []
    pairs: list[tuple[str, str]] = []
    for how, i0, i1, j0, j1 in SequenceMatcher(None, first, second, False).get_opcodes():
        if how == "equal":
            continue
        for old, new in zip_longest(first[i0:i1], second[j0:j1]):
            if old is None:
                differences.append(Difference("feature", "only in B", f"{new}, only in B"))
            elif new is None:
                differences.append(Difference("feature", "only in A", f"{old}, only in A"))
            else:
                differences.append(Difference("feature", "changed", f"{old} became {new}"))
                pairs.append((old, new))
    changes = {_changed_words(old, new, decimals) for old, new in pairs}
    if len(pairs) == len(differences) > 1 == len(changes):
        common = ", ".join(changes.pop())  # "X +1.440, at 1000 to 1200"
        if common:
            text = f"{len(pairs)} of {len(first)} statements: {common}"
            differences = [Difference("feature", "changed", text, common)]
    return tuple(differences)


def _changed_words(old: str, new: str, decimals: int) -> tuple[str, ...]:
    """The words that a statement has changed, each with the word before it; () if it is another."""
    before, after = old.split(), new.split()
    if len(before) != len(after):
        return ()
    changed: list[str] = []
    for k, (a, b) in enumerate(zip(before, after, strict=True)):
        if a != b:
            word = before[k - 1] if k else ""
            if word in ("X", "Y"):
                far = float(b.rstrip(",")) - float(a.rstrip(","))
                changed.append(f"{word} {far:+.{decimals}f}")
            else:
                changed.append(f"{word} {a} to {b}".strip())
    return tuple(dict.fromkeys(changed))


def statements(name: str, text: str, machine: Machine) -> tuple[list[str], tuple[Diagnostic, ...]]:
    """The statements of a program in words, and the errors in its blocks."""
    if machine.controller in DIALECTS:
        lines = _ST_COMMENT.sub("", text).splitlines()
        return [" ".join(line.split()) for line in lines if line.strip()], ()
    if machine.controller == "stepper":
        return [line.strip() for line in text.splitlines() if line.strip()[:1] not in ("", "#")], ()
    if machine.stock == "profile":
        around, diagnostics = cell_events(text, machine, name)
        return list(_turned(around, machine.format.length_decimals)), errors_in(diagnostics)
    events, diagnostics = table_events(text, machine, name)
    return list(_sentences(events, machine.format.length_decimals)), errors_in(diagnostics)


def _sentences(events: list[TableEvent], decimals: int) -> Iterator[str]:
    for event in events:
        match event:
            case Move(rapid=rapid, end=(x, y), curve=curve):
                to = f"X {_number(x, decimals)} Y {_number(y, decimals)}"
                feed = "" if rapid else f" at {event.feed_mm_min:g} mm/min"
                match curve:
                    case None:
                        yield f"{'rapid' if rapid else 'line'} to {to}{feed}"
                    case Arc(centre=(cx, cy)) | EllipseArc(centre=(cx, cy)):
                        about = f"X {_number(cx, decimals)} Y {_number(cy, decimals)}"
                        shape = "arc" if isinstance(curve, Arc) else "ellipse"
                        yield f"{shape} to {to} about {about}, {curve.sweep_deg:.2f} deg{feed}"
                    case _:
                        yield f"curve to {to}{feed}"
            case Switch():
                yield str(event)
            case Pause(seconds=seconds):
                yield f"pause of {seconds:g} s"
            case Compensation(side=side, radius=radius):
                yield f"keep {side} of the path by {radius:g}"
            case Blending(distance=distance):
                yield f"pass corners at {distance:g} mm"
            case Acceleration(braking=braking, mm_s2=mm_s2):
                yield f"{'brake' if braking else 'run up'} at {mm_s2:g} mm/s2"
            case Lift(rapid=rapid, end=height):
                feed = "" if rapid else f" at {event.feed_mm_min:g} mm/min"
                yield f"{'rapid' if rapid else 'feed'} to {height:g} mm over the sheet{feed}"
            case Touch():
                yield f"touch the sheet at {event.feed_mm_min:g} mm/min"
            case Zero(shifted=shifted):
                yield "Z counts from another place" if shifted else "Z counts from its own place"
            case Output(name=name, on=on, with_move=with_move):
                yield f"{name} {'on' if on else 'off'}{' with the next move' if with_move else ''}"
            case FeedShare(share=share):
                yield f"feed at {100 * share:g} %"
            case ToolOffset(number=number):
                yield f"places of tool {number}"
            case Material(values=values):
                yield " ".join(["material", *(f"{k} {v:g}" for k, v in values.items())])


def _turned(events: Sequence[BarEvent], decimals: int) -> Iterator[str]:
    """The statements of a program that goes round a profile."""
    for event in events:
        if isinstance(event, Move):
            to = [f"{n} {_number(v, decimals)}" for n, v in zip("XYZ", event.end, strict=True)]
            turned = (("A", event.a_deg[1]), ("B", event.b_deg[1]))
            to += [f"{axis} {angle:.3f}" for axis, angle in turned if not isnan(angle)]
            by = f" at {event.feed_mm_min:g} mm/min"
            by = f" in {60 * event.minutes:.3f} s" if event.minutes else by
            way, by = ("rapid", "") if event.rapid else ("line", by)
            yield f"{way} to {' '.join(to)}{by}"
        elif isinstance(event, Switch | Pause):
            yield from _sentences([event], decimals)


def _number(value: float, decimals: int) -> str:
    return f"{round(value, decimals) + 0.0:.{decimals}f}"


CLOSED = 0.02  #: mm between the ends of a closed cut
MOST_OPEN = 2  #: places that no closed cut has


def stroke_pairs(
    a: Sequence[TorchStroke], b: Sequence[TorchStroke], resolution: float
) -> Iterator[ThingPair]:
    """The cuts of two programs face by face, those that are closed and the others.

    Places nearer than `resolution` are one.
    """
    step = resolution / 2 + 1e-9
    for face, closed in sorted({_sort(stroke) for stroke in (*a, *b)}):
        old, new = ([s for s in strokes if _sort(s) == (face, closed)] for strokes in (a, b))
        yield from paired(old, new, stroke_place, lambda x, y: _changes(x, y, step))


def _sort(stroke: TorchStroke) -> tuple[str, bool]:
    return stroke.face, is_closed(stroke)


def is_closed(stroke: TorchStroke) -> bool:
    """Whether a cut behind its lead comes back to where it began."""
    ring = stroke.points[1:]
    return len(ring) > MOST_OPEN and dist(ring[0], ring[-1]) <= CLOSED


def stroke_place(stroke: TorchStroke) -> tuple[float, float]:
    """The middle of a cut without its lead."""
    xs, ys = zip(*(stroke.points[1:] or stroke.points), strict=True)
    return (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2


def _changes(a: TorchStroke, b: TorchStroke, step: float) -> list[str]:
    (ax, ay), (bx, by) = stroke_place(a), stroke_place(b)
    changes = moved(bx - ax, by - ay, step)
    if len(a.points) != len(b.points) or any(
        abs((p - ax) - (r - bx)) > 2 * step or abs((q - ay) - (t - by)) > 2 * step
        for (p, q), (r, t) in zip(a.points, b.points, strict=True)
    ):
        changes.append("another course")
    if a.b_deg != b.b_deg:
        changes.append(f"tilt {a.b_deg:.6g} to {b.b_deg:.6g} degrees")
    if a.row.feed_mm_min != b.row.feed_mm_min:
        changes.append(f"feed {a.row.feed_mm_min:.6g} to {b.row.feed_mm_min:.6g} mm/min")
    return changes


class ProgramText(NamedTuple):
    """A program, and the machine that reads it."""

    name: str  #: in messages
    text: str
    machine: Machine


def diff_texts(
    a: ProgramText, b: ProgramText
) -> tuple[tuple[Difference, ...], tuple[Diagnostic, ...]]:
    """What program B makes otherwise than A, both for bars, sheets or profiles; and what is wrong
    with the blocks of either, at its own file and line."""
    if a.machine.stock in ("sheet", "profile"):
        (first, diagnostics), (second, more) = (statements(*one) for one in (a, b))
        return diff_statements(first, second, a.machine.format.length_decimals), (
            *diagnostics,
            *more,
        )
    from beamcam.checks.bars import run

    old, new = (run(one.text, one.machine, None, one.name) for one in (a, b))
    step = max(a.machine.format.resolution, b.machine.format.resolution)
    return diff_programs(old.made, new.made, step), (*old.diagnostics, *new.diagnostics)
