"""The axes of a machine over time, whatever kind of program moves them.

A trace is a chain of intervals between knots. Within an interval all axes go straight from knot to
knot, in step with each other; how much of the way is done is a cubic of the time, given by its
slopes at both ends (Hermite). That is exact for each phase of constant jerk, so that nothing
has to be sampled:

    share of the way  1 |        _.   slope b     h(u) = a (u^3 - 2u^2 + u) + b (u^3 - u^2)
                        |     .'                         + 3u^2 - 2u^3,   u = t / duration
                      0 |__.'         slope a     a = b = 1 is a uniform motion
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Literal

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike

from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.machine import Machine
from beamcam.motion.lookahead import cut_phases
from beamcam.motion.speeds import SpeedSection

# --- phases: chords that are passed at planned speeds, as intervals of a trace --------------------

MIN_SECONDS = 1e-9  #: what rounding leaves of a phase is dropped


class Chords(Struct, frozen=True):
    """The chords of paths, each beginning where the one before it ends or where a path does."""

    begins: Floats  #: (n, 2)
    ends: Floats  #: (n, 2)
    lengths: Floats  #: (n,) of the curve above each chord
    lines: Counts  #: (n,) of the program


class Phases(Struct, frozen=True):
    """Intervals of a trace, each within one chord."""

    chord: Counts  #: (m,)
    seconds: Floats  #: (m,)
    ends: Floats  #: (m, 2)
    slopes: Floats  #: (m, 2)


def phases_of(chords: Chords, sections: Sequence[SpeedSection], joints: Sequence[float]) -> Phases:
    """The phases of constant jerk of paths that begin and end at rest, one after the other.

    `sections` are the segments of the paths by their chords, `joints` the speeds between them.
    """
    begins, ends, lengths = chords.begins, chords.ends, chords.lengths
    points = np.concatenate((begins[:1], ends))
    along = (ends - begins) / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    path = cut_phases(points, lengths, along, list(sections), np.array(joints))
    kept = path.phase_duration_s > MIN_SECONDS
    chord, lasts = path.phase_segment[kept], path.phase_duration_s[kept]
    share = np.clip(path.phase_position[kept] / lengths[chord], 0.0, 1.0)
    is_last = np.append(chord[1:] != chord[:-1], True)
    until = np.where(is_last, 1.0, np.append(share[1:], 1.0))
    v, a, j = path.phase_velocity[kept], path.phase_acceleration[kept], path.phase_jerk[kept]
    way = (until - share) * lengths[chord]
    scale = np.divide(lasts, way, out=np.zeros_like(way), where=way > 0.0)
    later = np.maximum(0.0, v + lasts * (a + lasts * j / 2))
    at = begins[chord] + until[:, None] * (ends - begins)[chord]
    at[is_last] = ends[chord[is_last]]
    return Phases(chord, lasts, at, np.column_stack((v * scale, later * scale)))


# --- axes and their switching state ---------------------------------------------------------------


class State(Struct, frozen=True):
    """Switching state, of bars and of sheets."""

    spindle: int = 0  #: number that the program chose, 0 before
    diameter: float = 0.0
    turning: int = 0  #: 1 clockwise, -1 counter-clockwise, 0 at rest
    coolant: bool = False
    sawing: bool = False
    process: str = ""  #: of the torch, laser or marker that is on


UNIFORM = (1.0, 1.0)


def runs(values: Counts) -> list[tuple[int, int]]:
    """First and behind the last of each run of equal values."""
    edges = [0, *(np.flatnonzero(np.diff(values)) + 1).tolist(), len(values)]
    return [(a, b) for a, b in pairwise(edges) if b > a]


class TraceAxis(Struct, frozen=True):
    """An axis of the machine."""

    name: str
    unit: Literal["mm", "deg", "rev"] = "mm"
    min: float | None = None  #: None has no limit
    max: float | None = None
    has_encoder: bool = True  #: whether the encoder of a study is one of this axis too

    @property
    def is_read(self) -> bool:
        """Whether the encoder of a study reads it."""
        return self.unit == "mm" and self.has_encoder


class Trace(Struct, frozen=True):
    """n intervals between n + 1 knots; each has its block and what is switched on."""

    axes: tuple[TraceAxis, ...]
    time_s: Floats  #: (n + 1,) of the knots, never falling
    positions: Floats  #: (n + 1, axes) at the knots
    slopes: Floats  #: (n, 2) of the share of the way at both ends of an interval
    line: Counts  #: (n,) of the program, from 1
    state: Counts  #: (n,) index into `states`
    states: tuple[State, ...]

    @property
    def duration_s(self) -> float:
        """End of the trace, in s."""
        return float(self.time_s[-1])

    def interval(self, times: ArrayLike) -> Counts:
        """The intervals at times, the later one where two meet; the last one behind the end."""
        at = np.searchsorted(self.time_s, np.asarray(times, dtype=np.float64), side="right") - 1
        return np.clip(at, 0, max(len(self.line) - 1, 0))

    def at(self, times: ArrayLike) -> Floats:
        """Positions of the axes at times, array (times, axes)."""
        t = np.asarray(times, dtype=np.float64).reshape(-1)
        if not len(self.line):
            return np.repeat(self.positions[:1], len(t), axis=0)
        k = self.interval(t)
        lasts = self.time_s[k + 1] - self.time_s[k]
        u = np.divide(t - self.time_s[k], lasts, out=np.ones_like(t), where=lasts > 0.0)
        share = share_of(np.clip(u, 0.0, 1.0), self.slopes[k, 0], self.slopes[k, 1])
        start = self.positions[k]
        return start + share[:, None] * (self.positions[k + 1] - start)


def share_of(u: Floats, first: Floats, last: Floats) -> Floats:
    """Share of the distance at the share `u` of the time, by the slopes at both ends."""
    return u * (first + u * (3.0 - 2.0 * first - last + u * (first + last - 2.0)))


class TraceBuilder:
    """A trace that grows interval by interval."""

    def __init__(self, axes: Sequence[TraceAxis], start: Sequence[float]) -> None:
        self._axes = tuple(axes)
        self._start = np.array([start], dtype=np.float64)
        self._chunks: list[tuple[Floats, Floats, Floats, Counts, Counts]] = []
        self._states: dict[State, int] = {}

    @property
    def here(self) -> Floats:
        """Axis positions."""
        place: Floats = self._chunks[-1][1][-1] if self._chunks else self._start[0]
        return place

    def add(
        self, seconds: ArrayLike, ends: ArrayLike, slopes: ArrayLike, line: ArrayLike, state: State
    ) -> None:
        """Intervals one after the other: their durations, ends, slopes and lines."""
        lasts = np.asarray(seconds, dtype=np.float64).reshape(-1)
        count = len(lasts)
        if not count:
            return
        at = np.asarray(ends, dtype=np.float64).reshape(count, len(self._axes))
        bends = np.broadcast_to(np.asarray(slopes, dtype=np.float64), (count, 2))
        lines = np.broadcast_to(np.asarray(line, dtype=np.int64), (count,))
        number = self._states.setdefault(state, len(self._states))
        self._chunks.append((lasts, at, bends, lines, np.full(count, number, dtype=np.int64)))

    def wait(self, seconds: float, line: int, state: State) -> None:
        """Nothing moves."""
        if seconds > 0.0:
            self.add([seconds], [self.here], UNIFORM, line, state)

    def trace(self) -> Trace:
        """All of it."""
        none = np.zeros(0, dtype=np.int64)
        seconds = np.concatenate([np.zeros(0), *(c[0] for c in self._chunks)])
        return Trace(
            self._axes,
            np.concatenate(([0.0], np.cumsum(seconds))),
            np.concatenate([self._start, *(c[1] for c in self._chunks)]),
            np.concatenate([np.zeros((0, 2)), *(c[2] for c in self._chunks)]),
            np.concatenate([none, *(c[3] for c in self._chunks)]),
            np.concatenate([none, *(c[4] for c in self._chunks)]),
            tuple(self._states) or (State(),),
        )


class TraceRow(Struct, frozen=True):
    """The machine at one moment."""

    time_s: float
    line: int  #: of the program; 0 before it begins
    positions: tuple[float, ...]
    state: State


def trace_rows(trace: Trace, every_s: float | None = None) -> Iterator[TraceRow]:
    """A row for each knot, or one every `every_s` seconds, the last one when all is over.

    Raises ValueError for a step that is not above 0.
    """
    if every_s is None:
        yield TraceRow(0.0, 0, tuple(trace.positions[0].tolist()), State())
        rows = zip(
            trace.time_s[1:].tolist(), trace.line.tolist(), trace.positions[1:].tolist(),
            trace.state.tolist(), strict=True,
        )  # fmt: skip
        for time_s, line, at, state in rows:
            yield TraceRow(time_s, line, tuple(at), trace.states[state])
        return
    if every_s <= 0:
        raise ValueError("every_s has to be more than 0")
    count = int(np.ceil(trace.duration_s / every_s * (1.0 - 1e-12))) + 1
    block = 1 << 14
    for first in range(0, count, block):
        times = np.arange(first, min(first + block, count)) * every_s
        k = trace.interval(times)
        places = trace.at(times).tolist()
        for time_s, index, at in zip(times.tolist(), k.tolist(), places, strict=True):
            line = int(trace.line[index]) if len(trace.line) else 0
            state = trace.states[int(trace.state[index])] if len(trace.line) else State()
            yield TraceRow(time_s, line, tuple(at), state)


def head_axes(machine: Machine) -> tuple[TraceAxis, ...]:
    """The axes of a head over a table, named as the machine's file does: X, Y, and the height of a
    torch over the sheet, where its program moves it.
    """
    names: dict[str, str] = {axis.moves: axis.name for axis in machine.axes}
    lifted: tuple[TraceAxis, ...] = ()
    if machine.triggers is not None:
        if (z := machine.triggers.z) is not None:
            lifted = (TraceAxis(z.axis, "mm", 0.0, z.home_height, has_encoder=False),)
        names = dict(zip("XY", machine.triggers.axes, strict=True))
    torch = machine.torch
    low_x, low_y, high_x, high_y = torch.area if torch else (0.0, 0.0, None, None)
    plane = (
        TraceAxis(names.get("X", "X"), "mm", low_x, high_x),
        TraceAxis(names.get("Y", "Y"), "mm", low_y, high_y),
        *lifted,
    )
    lifts = torch is not None and torch.z == "program"
    return (*plane, TraceAxis(names.get("Z", "Z"))) if lifts else plane
