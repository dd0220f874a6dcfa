"""Warnings where a program exceeds a machine's limits, reach or free space."""

from collections.abc import Iterator, Mapping

import numpy as np

from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Saw
from beamcam.model.part import Profile
from beamcam.simulate import rules
from beamcam.simulate.collisions import strikes
from beamcam.simulate.trace import Trace
from beamcam.verify.bars.stations import choices_of

SLACK = 1e-6  #: mm or degrees that rounding may put an axis beyond its limit
SQUARE = 0.05  #: degrees; a cut less off the square counts as square


def run_warnings(
    trace: Trace, machine: Machine, section: Mapping[str, float], name: str
) -> tuple[Diagnostic, ...]:
    """Each place where an axis leaves its limits, a cut its reach, or bodies or tips strike, by
    line.
    """
    found = [
        *_beyond_limits(trace, machine, name),
        *_beyond_reach(trace, machine, section, name),
        *_struck(trace, machine, section, name),
        *_met(trace, machine, section, name),
    ]
    return tuple(sorted(found, key=lambda said: (said.source.line or 0, said.code)))


def _beyond_limits(trace: Trace, machine: Machine, name: str) -> Iterator[Diagnostic]:
    """The first time that an axis leaves its limits in each excursion; knots are the extremes."""
    rule = rules.LIMIT if machine.stock == "beam" or machine.axes else rules.REACH
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
        angle = abs(float(trace.positions[k, turns[0]]) - saw.square)
        most = _largest(saw, angle)
        if height > most[0] + SLACK or width > most[1] + SLACK:
            yield rules.REACH.at(
                Source(name, int(trace.line[k])), axis="saw", time=f"{trace.time_s[k]:.2f}",
                found=f"{height:g} x {width:g}", unit="mm",
                expected=f"at most {most[0]:g} x {most[1]:g} at {angle:.2f} deg",
            )  # fmt: skip


def _largest(saw: Saw, angle: float) -> tuple[float, float]:
    """Height and width that the blade reaches across at an angle off the square cut."""
    rows = [row for row in saw.max_sections if row.max_angle + SQUARE >= angle]
    if not rows:
        return saw.max_height, saw.max_width
    row = min(rows, key=lambda row: row.max_angle)
    return row.max_height, row.max_width


def _struck(
    trace: Trace, machine: Machine, section: Mapping[str, float], name: str
) -> Iterator[Diagnostic]:
    for strike in strikes(trace, machine, section):
        yield rules.COLLISION.at(
            Source(name, strike.line), one=strike.one, other=strike.other,
            time=f"{strike.time_s:.2f}", found=f"{strike.depth:.1f}",
            until=f"{strike.until_s:.2f}",
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
            yield rules.TIPS.at(
                Source(name, int(trace.line[k - 1])), time=f"{trace.time_s[k]:.2f}", one=one,
                other=other, first=f"{depths[0][k]:g}", second=f"{depths[1][k]:g}",
                size=f"{size:g}",
            )  # fmt: skip
