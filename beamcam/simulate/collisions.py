"""Collisions between bodies of a machine while a program runs.

Bodies are boxes, upright and turned about the vertical at most. Two of them overlap if their
heights do and no side of either rectangle, seen from above, parts them (separating axes):

      _____            all four directions of the sides are tried; the least overlap of
     |  a  |  /\\       them is how deep the bodies lie in each other
     |_____| /b  \\
             \\  /
              \\/
"""

from collections.abc import Iterator, Mapping
from itertools import combinations, groupby

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.bodies import Body, section_values, signed
from beamcam.machine.machine import Machine
from beamcam.simulate.trace import Trace

STEP = 1.0  #: mm or degrees that an axis moves at most between two looks, at even speed
LONGEST = 100_000.0  #: mm of one move
MIN_DEPTH = 1e-6  #: bodies that touch do not strike
CHUNK = 20_000  #: looks at a time


class Collision(Struct, frozen=True):
    """Two bodies that lie in each other for a while."""

    one: str
    other: str
    time_s: float  #: when it begins
    line: int  #: of the program
    depth: float  #: mm, maximum
    until_s: float


class _Placed(Struct, frozen=True):
    """A body at many times: the middle and the half sides of its box, and its turn."""

    middle: Floats  #: (n, 3)
    half: Floats  #: (3,)
    turn_rad: Floats  #: (n,)


def strikes(trace: Trace, machine: Machine, section: Mapping[str, float]) -> tuple[Collision, ...]:
    """All strikes of a machine's bodies, in the order of time; none where it has no bodies.

    `section` says what is worked, by `SECTION_NAMES`. Raises MachineError for a body whose
    arithmetic has no value.
    """
    pairs = [pair for pair in combinations(machine.bodies, 2) if _may_move(*pair)]
    if not pairs:
        return ()
    values = section_values(section)
    times = looks(trace)
    depths = np.empty((len(pairs), len(times)))
    for first in range(0, len(times), CHUNK):
        own = slice(first, first + CHUNK)
        at = trace.at(times[own])
        placed = {b.name: _placed(b, trace, at, values) for b in machine.bodies}
        for k, (one, other) in enumerate(pairs):
            depths[k, own] = _depth(placed[one.name], placed[other.name])
    found = [
        strike
        for (one, other), depth in zip(pairs, depths, strict=True)
        for strike in _runs(one.name, other.name, trace, times, depth)
    ]
    return tuple(sorted(found, key=lambda strike: (strike.time_s, strike.one, strike.other)))


def looks(trace: Trace) -> Floats:
    """Times so near to each other that no axis moves much more than `STEP` between them.

    A move farther than any machine goes ends beyond its limits, and is not looked at on its way.
    """
    ways = np.abs(np.diff(trace.positions, axis=0)).max(axis=1, initial=0.0)
    ways[ways > LONGEST] = 0.0
    counts = np.maximum(1, np.ceil(ways / STEP)).astype(np.int64)
    interval = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(interval)) - np.repeat(np.cumsum(counts) - counts, counts)
    lasts = np.diff(trace.time_s)
    found: Floats = trace.time_s[interval] + lasts[interval] * number / counts[interval]
    return np.append(found, trace.duration_s)


def _may_move(one: Body, other: Body) -> bool:
    """Whether two bodies move against each other at all."""
    return one.carriers != other.carriers or bool(one.turn)


def _placed(body: Body, trace: Trace, at: Floats, values: Mapping[str, float]) -> _Placed:
    names = [axis.name for axis in trace.axes]

    def carried(carrier: str) -> Floats:
        name, sign = signed(carrier)
        return sign * at[:, names.index(name)] if name else np.zeros(len(at))

    low = np.array([formula(values) for formula in body.min])
    high = np.array([formula(values) for formula in body.max])
    low, high = np.minimum(low, high), np.maximum(low, high)
    middle = np.broadcast_to((low + high) / 2, (len(at), 3)).copy()
    turn = np.radians(carried(body.turn))
    if body.turn:
        px, py = (formula(values) for formula in body.pivot) if body.pivot else (0.0, 0.0)
        x, y = middle[:, 0] - px, middle[:, 1] - py
        middle[:, 0] = px + x * np.cos(turn) - y * np.sin(turn)
        middle[:, 1] = py + x * np.sin(turn) + y * np.cos(turn)
    middle += np.column_stack([carried(body.x), carried(body.y), carried(body.z)])
    return _Placed(middle, (high - low) / 2, turn)


def _depth(a: _Placed, b: _Placed) -> Floats:
    """Penetration depth of two bodies at each time; negative where they are apart."""
    off = b.middle - a.middle
    depth = a.half[2] + b.half[2] - np.abs(off[:, 2])
    for turn in (a.turn_rad, b.turn_rad):
        for quarter in (0.0, np.pi / 2):
            angle = turn + quarter
            between = np.abs(off[:, 0] * np.cos(angle) + off[:, 1] * np.sin(angle))
            depth = np.minimum(depth, _reach(a, angle) + _reach(b, angle) - between)
    found: Floats = depth
    return found


def _reach(body: _Placed, angle: Floats) -> Floats:
    """Extent of a body from its middle in a direction, in plan view."""
    own = angle - body.turn_rad
    found: Floats = body.half[0] * np.abs(np.cos(own)) + body.half[1] * np.abs(np.sin(own))
    return found


def _runs(one: str, other: str, trace: Trace, times: Floats, depth: Floats) -> Iterator[Collision]:
    """The stretches of time in which a pair lies in each other."""
    inside: Counts = np.flatnonzero(depth > MIN_DEPTH)
    for _, run in groupby(enumerate(inside.tolist()), key=lambda pair: pair[1] - pair[0]):
        own = [index for _, index in run]
        first, last = own[0], own[-1]
        line = int(trace.line[trace.interval([times[first]])[0]]) if len(trace.line) else 0
        deepest = float(depth[first : last + 1].max())
        yield Collision(one, other, float(times[first]), line, deepest, float(times[last]))
