"""The trace of a coper's program: a torch round a profile, or over a tube that turns.

Each move takes what `post` says of it: in rapid as long as the axis that needs longest, at its feed
or in its inverse time else. Neither says how axes get up to speed: LinuxCNC runs one move into the
next.
"""

import re
from collections.abc import Sequence
from math import dist, isfinite

from beamcam.controllers.events import BarEvent, Move, Pause, Place, Switch
from beamcam.errors import MachineError, Source
from beamcam.machine.machine import Machine
from beamcam.machine.words import MISSING_KEY
from beamcam.simulation.trace import UNIFORM, State, Trace, TraceAxis, TraceBuilder

Positions = tuple[float, ...]  #: of X, Y unless it is fixed, Z, A and, where the torch tilts, B
LETTERS = "XYZA"
_M_WORD = re.compile(r"M(\d+)")


def coper_trace(events: Sequence[BarEvent], machine: Machine) -> Trace:
    """The axes over time, from the first place that the program names.

    Raises MachineError without `[[axes]]` of X, Y unless it is fixed, Z and A, and of B where the
    torch tilts.
    """
    axes = {axis.moves: axis for axis in machine.axes}
    coper = machine.needed(machine.coper, "coper")
    letters = LETTERS.replace("Y", "") if coper.y == "fixed" else LETTERS
    letters += "B" if coper.tilt else ""
    if not {*letters} <= axes.keys():
        raise MachineError(MISSING_KEY.at(Source(machine.name), expected="axes"))
    used = [axes[letter] for letter in letters]  # type: ignore[index]
    units = {"A": coper.a_unit, "B": "deg"}
    rows = tuple(
        TraceAxis(axis.name, units.get(letter, "mm"), axis.min, axis.max)
        for letter, axis in zip(letters, used, strict=True)
    )
    on, off = (
        {int(number) for line in lines for number in _M_WORD.findall(line)}
        for lines in (machine.words.cut_on, machine.words.cut_off)
    )
    moves = [event for event in events if isinstance(event, Move)]
    here = tuple(_first(moves, letter) for letter in letters)
    builder, state = TraceBuilder(rows, here), State()
    for event in events:
        match event:
            case Move():
                to = tuple(
                    b if isfinite(b) else a
                    for a, b in zip(here, map(_places(event).__getitem__, letters), strict=True)
                )
                seconds = _seconds(event, here, to, [axis.speed for axis in used])
                if seconds > 0.0:  # the first one only says where everything is
                    builder.add([seconds], [to], UNIFORM, event.line, state)
                here = to
            case Pause():
                builder.wait(event.seconds, event.line, state)
            case Switch(number=number) if number in on:
                state = State(process="cut")
            case Switch(number=number) if number in off:
                state = State()
            case _:
                pass
    return builder.trace()


def _first(moves: Sequence[Move[Place]], letter: str) -> float:
    """The first place that a program names of an axis; 0 where it names none."""
    ends = (_places(move)[letter] for move in moves)
    return next((end for end in ends if isfinite(end)), 0.0)


def _places(move: Move[Place]) -> dict[str, float]:
    return dict(zip("XYZAB", (*move.end, move.a_deg[1], move.b_deg[1]), strict=True))


def _seconds(
    move: Move[Place], here: Positions, to: Positions, speeds: Sequence[float]
) -> float:  # fmt: skip
    if move.minutes > 0.0:
        return 60.0 * move.minutes
    if not move.rapid and move.feed_mm_min > 0.0:
        return 60.0 * dist(here[:3], to[:3]) / move.feed_mm_min  # of a torch with Y: else by time
    return max(abs(b - a) / speed for a, b, speed in zip(here, to, speeds, strict=True))
