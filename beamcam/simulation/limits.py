"""Warnings where a program exceeds a machine's limits, reach or free space."""

from collections.abc import Iterator, Mapping
from itertools import combinations, groupby

import numpy as np
from msgspec import Struct

from beamcam.checks.bars.stations import choices_of
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Floats
from beamcam.machine.machine import SECTION_NAMES, Machine, MachineBox, signed
from beamcam.model.part import Profile
from beamcam.simulation import COLLISION, LIMIT, REACH, TIPS
from beamcam.simulation.trace import Trace

# --- collisions between bodies of a machine while a program runs ----------------------------------

# Bodies are boxes, upright and turned about the vertical at most. Two of them overlap if their
# heights do and no side of either rectangle, seen from above, parts them (separating axes):
#
#       _____            all four directions of the sides are tried; the least overlap of
#      |  a  |  /\       them is how deep the bodies lie in each other
#      |_____| /b  \
#              \  /
#               \/


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
    pairs = [
        (one, other)
        for one, other in combinations(machine.bodies, 2)
        if one.carriers != other.carriers or one.turn
    ]
    if not pairs:
        return ()
    values = {name: section.get(name, 0.0) for name in SECTION_NAMES}
    times = looks(trace)
    depths = np.empty((len(pairs), len(times)))
    for first in range(0, len(times), CHUNK):
        own = slice(first, first + CHUNK)
        at = trace.at(times[own])
        placed = {b.name: _placed(b, trace, at, values) for b in machine.bodies}
        for k, (one, other) in enumerate(pairs):
            depths[k, own] = _depth(placed[one.name], placed[other.name])
    collisions = []
    for (one, other), depth in zip(pairs, depths, strict=True):
        inside = np.flatnonzero(depth > MIN_DEPTH).tolist()
        for _, run in groupby(enumerate(inside), key=lambda pair: pair[1] - pair[0]):
            looked = [index for _, index in run]
            first, last = looked[0], looked[-1]
            line = int(trace.line[trace.interval([times[first]])[0]]) if len(trace.line) else 0
            deepest, begin_s = float(depth[first : last + 1].max()), float(times[first])
            collisions.append(
                Collision(one.name, other.name, begin_s, line, deepest, float(times[last]))
            )
    return tuple(sorted(collisions, key=lambda one: (one.time_s, one.one, one.other)))


def looks(trace: Trace) -> Floats:
    """Times so near to each other that no axis moves much more than `STEP` between them.

    A move farther than any machine goes ends beyond its limits, and is not looked at on its way.
    """
    ways = np.abs(np.diff(trace.positions, axis=0)).max(axis=1, initial=0.0)
    ways[~(ways <= LONGEST)] = 0.0
    counts = np.maximum(1, np.ceil(ways / STEP)).astype(np.int64)
    interval = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(interval)) - np.repeat(np.cumsum(counts) - counts, counts)
    lasts = np.diff(trace.time_s)
    times: Floats = trace.time_s[interval] + lasts[interval] * number / counts[interval]
    return np.append(times, trace.duration_s)


def _placed(body: MachineBox, trace: Trace, at: Floats, values: Mapping[str, float]) -> _Placed:
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
    deepest: Floats = depth
    return deepest


def _reach(body: _Placed, angle: Floats) -> Floats:
    """Extent of a body from its middle in a direction, in plan view."""
    own = angle - body.turn_rad
    reach: Floats = body.half[0] * np.abs(np.cos(own)) + body.half[1] * np.abs(np.sin(own))
    return reach


SLACK = 1e-6  #: mm or degrees that rounding may put an axis beyond its limit
SQUARE = 0.05  #: degrees; a cut less off the square counts as square


def run_warnings(
    trace: Trace, machine: Machine, section: Mapping[str, float], name: str
) -> tuple[Diagnostic, ...]:
    """Each place where an axis leaves its limits, a cut its reach, or bodies or tips strike, by
    line.
    """
    diagnostics = [
        *_beyond_limits(trace, machine, name),
        *_beyond_reach(trace, machine, section, name),
        *(
            COLLISION.at(
                Source(name, one.line),
                one=one.one,
                other=one.other,
                time=f"{one.time_s:.2f}",
                found=f"{one.depth:.1f}",
                until=f"{one.until_s:.2f}",
            )
            for one in strikes(trace, machine, section)
        ),
        *_met(trace, machine, section, name),
    ]
    return tuple(sorted(diagnostics, key=lambda d: (d.source.line or 0, d.code)))


def _beyond_limits(trace: Trace, machine: Machine, name: str) -> Iterator[Diagnostic]:
    """The first time that an axis leaves its limits in each excursion; knots are the extremes."""
    rule = LIMIT if machine.stock == "beam" or machine.axes else REACH
    for k, axis in enumerate(trace.axes):
        low = -np.inf if axis.min is None else axis.min
        high = np.inf if axis.max is None else axis.max
        at = trace.positions[:, k]
        off = np.maximum(low - at, at - high)
        outside = off > SLACK
        for first in np.flatnonzero(outside & ~np.append(False, outside[:-1])).tolist():
            behind = np.flatnonzero(~outside[first:])
            last = first + int(behind[0]) if len(behind) else len(at)
            worst = first + int(off[first:last].argmax())
            line = int(trace.line[max(first - 1, 0)]) if len(trace.line) else 0
            yield rule.at(
                Source(name, line), axis=axis.name, time=f"{trace.time_s[first]:.2f}",
                found=f"{at[worst]:.3f}", unit=axis.unit, expected=f"{low:g} to {high:g}",
            )  # fmt: skip


def _beyond_reach(
    trace: Trace, machine: Machine, section: Mapping[str, float], name: str
) -> Iterator[Diagnostic]:
    """Cuts through a section that the blade does not reach across at their angle."""
    saw = machine.saw
    turns = [k for k, axis in enumerate(machine.axes) if axis.moves == "angle"]
    height, width = section.get("height", 0.0), section.get("width", 0.0)
    if saw is None or not turns:
        return
    sawing = np.array([state.sawing for state in trace.states])[trace.state]
    for k in np.flatnonzero(sawing & ~np.append(False, sawing[:-1])).tolist():
        angle = abs(float(trace.positions[k, turns[0]]) - saw.zero_angle)
        # Height and width that the blade reaches across at that angle off the square cut.
        rows = [row for row in saw.max_sections if row.max_angle + SQUARE >= angle]
        limit = min(rows, key=lambda row: row.max_angle, default=saw)
        most = limit.max_height, limit.max_width
        if height > most[0] + SLACK or width > most[1] + SLACK:
            yield REACH.at(
                Source(name, int(trace.line[k])), axis="saw", time=f"{trace.time_s[k]:.2f}",
                found=f"{height:g} x {width:g}", unit="mm",
                expected=f"at most {most[0]:g} x {most[1]:g} at {angle:.2f} deg",
            )  # fmt: skip


def _met(
    trace: Trace, machine: Machine, section: Mapping[str, float], name: str
) -> Iterator[Diagnostic]:
    """Strokes of two opposite spindles at once whose tips meet in the middle of the section."""
    profile = Profile("SO", "", section.get("height", 0.0), section.get("width", 0.0), 0.0, None)
    choices = choices_of(machine, profile)
    for pair in machine.pairs:
        sides = {frozenset("ou"): profile.height, frozenset("vh"): profile.width}
        size = sides.get(frozenset(pair.faces), 0.0)
        columns = [
            k for s in choices[pair.number].stations for k, shown in enumerate(trace.axes)
            for axis in machine.axes
            if axis.name == shown.name and (axis.spindle, axis.moves) == (s.number, "XYZ"[s.stroke])
        ]  # fmt: skip
        if not size or len(columns) != len(pair.faces):
            continue
        depths = [
            s.way * (trace.positions[:, k] - s.surface)
            for s, k in zip(choices[pair.number].stations, columns, strict=True)
        ]
        on = np.array([state.spindle == pair.number for state in trace.states])[trace.state]
        meet = np.append(False, on) & (depths[0] + depths[1] >= size - SLACK)
        one, other = (trace.axes[k].name for k in columns)
        for k in np.flatnonzero(meet & ~np.append(False, meet[:-1])).tolist():
            yield TIPS.at(
                Source(name, int(trace.line[k - 1])), time=f"{trace.time_s[k]:.2f}", one=one,
                other=other, first=f"{depths[0][k]:g}", second=f"{depths[1][k]:g}",
                size=f"{size:g}",
            )  # fmt: skip
