"""Look-ahead: the speed of each segment of a path within the limits of the axes.

    1  Limits. A segment has those of its axes along its direction. A junction turns the path:
       it is passed at the speed at which a circle that stays within `deviation` of the corner
       keeps the acceleration (grbl), and at which the turn, spread over half of both segments,
       keeps acceleration (Klipper) and jerk: that is what limits a curve of short chords.
    2  Segments are joined to sections (`speeds`), between which the acceleration is 0.
    3  Backward, then forward: no joint is passed faster than a jerk-limited ramp over the next,
       the last section allows. A ramp that fits still fits if its faster end gets slower, so
       two passes are enough and no section is left without room.
    4  Each section rises to a peak and falls; its phases are cut where a segment ends.

On a curve acceleration along the path and across it add up, so they share the limit as in
LinuxCNC's planner: 1/2 along, sqrt(3)/2 across.
Sources: grbl, planner.c; Klipper, toolhead.py; LinuxCNC, tp.c.
"""

from collections.abc import Sequence
from math import cos, radians, sqrt

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike

from beamcam.geometry.array_types import Counts, Floats
from beamcam.motion.speeds import (
    SpeedSection,
    join_segments,
    joint_speeds,
    peak_rises,
    ramp_phases,
)
from beamcam.motion.velocity_profile import AxisLimits


class PlannedPath(Struct, frozen=True):
    """The motion along a path, as arrays. A phase has constant jerk and lies in one segment."""

    points: Floats  #: (n + 1, axes)
    lengths: Floats  #: (n,)
    directions: Floats  #: (n, axes)
    duration_s: float
    phase_segment: Counts  #: (m,), the segment of each phase
    phase_start_s: Floats  #: (m,), from the start of the path
    phase_duration_s: Floats  #: (m,)
    phase_position: Floats  #: (m,), distance from the start of the segment
    phase_velocity: Floats  #: (m,)
    phase_acceleration: Floats  #: (m,)
    phase_jerk: Floats  #: (m,)


def cut_phases(
    points: Floats, lengths: Floats, along: Floats, moving: list[SpeedSection], speeds: Floats
) -> PlannedPath:
    """Phases of all sections, cut at the ends of segments."""
    ramps = _ramps_of(moving, speeds)
    first = np.array([s.first for s in moving])
    before = np.cumsum(lengths) - lengths
    section, phase, time, is_segment = _starts(ramps, moving, first, before)
    # Segments are counted anew in each section.
    counted, opens = np.cumsum(is_segment), np.append(True, section[1:] != section[:-1])
    segment = first[section] + counted
    segment -= np.maximum.accumulate(np.where(opens, counted - is_segment, 0))
    last = np.append(opens[1:], True)
    end_t = ramps.end_t
    until = np.where(last, end_t[section, 6], np.append(time[1:], 0.0))
    spent = until - time
    at = section, phase
    s = np.maximum(0.0, time - ramps.start_t[at])
    a = ramps.start_a[at] + s * ramps.held_j[at]
    speed = ramps.v[at] + s * (ramps.start_a[at] + s * ramps.held_j[at] / 2)
    came = ramps.x[at] + s * (ramps.v[at] + s * (ramps.start_a[at] / 2 + s * ramps.held_j[at] / 6))
    came = np.maximum(0.0, came - (before[segment] - before[first[section]]))
    kept = spent > 0.0
    base = np.cumsum(end_t[:, 6]) - end_t[:, 6]
    return PlannedPath(
        points, lengths, along, float(np.sum(end_t[:, 6])),
        segment[kept], (base[section] + time)[kept], spent[kept], came[kept],
        np.maximum(0.0, speed[kept]), a[kept], ramps.held_j[at][kept],
    )  # fmt: skip


class _Ramps(Struct, frozen=True):
    """The seven phases (n, 7) of each section: up, cruise and down."""

    duration: Floats
    start_a: Floats
    held_j: Floats
    v: Floats  #: at the start of each
    x: Floats  #: from the section's start to that of each
    gone: Floats  #: in each
    start_t: Floats
    end_t: Floats


def _ramps_of(moving: list[SpeedSection], speeds: Floats) -> _Ramps:
    way, limit, acceleration, jerk = np.array(
        [(s.length, s.limit, s.acceleration, s.jerk) for s in moving]
    ).T
    v0, v1 = speeds[:-1], speeds[1:]
    low, high = np.minimum(v0, v1), np.maximum(v0, v1)
    rise = peak_rises(way, low, high, limit, acceleration, jerk)
    up = ramp_phases(high + rise - v0, acceleration, jerk)
    down = ramp_phases(-(high + rise - v1), acceleration, jerk)
    ramps = [(high + rise + s) / 2 * np.sum(d, axis=1) for s, (d, _, _) in ((v0, up), (v1, down))]
    peak = np.where(high + rise > 0.0, high + rise, 1.0)
    cruise = np.maximum(0.0, way - ramps[0] - ramps[1]) / peak
    still = np.zeros((len(way), 1))
    duration = np.concatenate((up[0], cruise[:, None], down[0]), axis=1)
    start_a = np.concatenate((up[1], still, down[1]), axis=1)
    held_j = np.concatenate((up[2], still, down[2]), axis=1)
    # State at the start of each phase, from the section's start.
    end_t = np.cumsum(duration, axis=1)
    gain = duration * (start_a + duration * held_j / 2)
    v = v0[:, None] + np.cumsum(gain, axis=1) - gain
    gone = duration * (v + duration * (start_a / 2 + duration * held_j / 6))
    x = np.cumsum(gone, axis=1) - gone
    start_t = np.concatenate((still, end_t[:, :-1]), axis=1)
    return _Ramps(duration, start_a, held_j, v, x, gone, start_t, end_t)


def _starts(
    ramps: _Ramps, moving: list[SpeedSection], first: Counts, before: Floats
) -> tuple[Counts, Counts, Floats, Counts]:
    """All starts of phases and of segments in order: section, phase and time of each, and whether
    it is that of a segment (1 or 0).

    `first` is the first segment of each section, `before` the length before each segment.
    """
    # Where segments begin inside a section, and when that is.
    which = np.repeat(np.arange(len(moving)), [s.last - s.first for s in moving])
    inside = np.flatnonzero(np.arange(len(before)) != first[which])
    run = which[inside]
    offset = before[inside] - before[first[run]]
    # Sections shrink to their phases, which rounding leaves a hair shorter or longer.
    way = np.array([s.length for s in moving])
    offset = offset * (ramps.x[run, -1] + ramps.gone[run, -1]) / way[run]
    k = np.clip(np.sum(offset[:, None] >= ramps.x[run], axis=1) - 1, 0, 6)
    at = run, k
    way, v, a, j = offset - ramps.x[at], ramps.v[at], ramps.start_a[at], ramps.held_j[at]
    # By bisection, as the distance only grows.
    low, high = np.zeros_like(way), ramps.duration[at]
    for _ in range(54):
        t = (low + high) / 2
        short = t * (v + t * (a / 2 + t * j / 6)) < way
        low, high = np.where(short, t, low), np.where(short, high, t)
    section = np.concatenate((np.repeat(np.arange(len(moving)), 7), run))
    inner = np.minimum(ramps.start_t[at] + (low + high) / 2, ramps.end_t[at])
    time = np.concatenate((ramps.start_t.reshape(-1), inner))
    phase = np.concatenate((np.tile(np.arange(7), len(moving)), k))
    is_segment = np.concatenate((np.zeros(7 * len(moving), int), np.ones(len(run), int)))
    # Of one time the phase comes first.
    order = np.lexsort((is_segment, time, phase, section))
    return section[order], phase[order], time[order], is_segment[order]


ALONG_SHARE = 0.5
ACROSS_SHARE = sqrt(0.75)

#: A turn of less than this from chord to chord is part of a curve, a sharper one is a corner.
CURVE_TURN_COS = cos(radians(30.0))


class LookAheadRules(Struct, frozen=True):
    """Axis limits and cornering rules."""

    axes: tuple[AxisLimits, ...]  #: one for each column of the points
    deviation: float = 0.01  #: of a corner's circle from the corner; 0 stops at every corner

    def __post_init__(self) -> None:
        if self.deviation < 0.0:
            raise ValueError(f"deviation must be 0 or more, found {self.deviation:g}")


def plan_speeds(points: ArrayLike, speed_mm_s: ArrayLike, rules: LookAheadRules) -> PlannedPath:
    """The motion from rest to rest along a polyline of shape (n + 1, axes).

    `speed_mm_s` is the greatest path speed, one or one for each segment. Time and memory are
    linear in the number of segments, but for one sort.

    Raises ValueError for fewer than two points, two equal neighbours, a speed that is not above
    0, or limits for another number of axes.
    """
    p = np.asarray(points, dtype=np.float64)
    if p.ndim != 2 or len(p) < 2 or p.shape[1] != len(rules.axes):
        raise ValueError(f"expected points for {len(rules.axes)} axes, found shape {p.shape}")
    step = np.diff(p, axis=0)
    lengths = np.sqrt(np.einsum("ij,ij->i", step, step))
    if not np.all(lengths > 0.0):
        raise ValueError(f"segment {int(np.argmin(lengths)) + 1} has no length")
    feeds = np.broadcast_to(np.asarray(speed_mm_s, dtype=np.float64), lengths.shape)
    if not np.all(feeds > 0.0):
        raise ValueError(f"speeds must be above 0, found {float(np.min(feeds)):g}")
    along = step / lengths[:, None]
    velocity, acceleration, jerk = (
        _along(along, [getattr(axis, name) for axis in rules.axes])
        for name in ("velocity", "acceleration", "jerk")
    )
    limits = np.minimum(feeds, velocity)
    turn = along[1:] - along[:-1]
    size = np.sqrt(np.einsum("ij,ij->i", turn, turn))
    cosine = np.clip(np.einsum("ij,ij->i", along[1:], along[:-1]), -1.0, 1.0)
    straight = size < 1e-9
    ways = np.where(straight[:, None], 1.0, turn / np.where(straight, 1.0, size)[:, None])
    across = _along(ways, [axis.acceleration for axis in rules.axes])
    jerk_across = _along(ways, [axis.jerk for axis in rules.axes])
    # Half of the angle between the segments: its sine is cos(turn / 2), its cosine size / 2.
    half_sine, half_cosine = np.sqrt((1.0 + cosine) / 2), np.where(straight, 1.0, size / 2)
    short = np.minimum(lengths[1:], lengths[:-1])
    # 1 - sin = cos^2 / (1 + sin), without the loss of digits of nearly straight junctions.
    corner = across * rules.deviation * half_sine * (1.0 + half_sine) / half_cosine**2
    spread = 0.5 * short * half_sine / half_cosine * across * ACROSS_SHARE
    squared = np.minimum(corner, spread)
    # Speed v turns the path by size / short in each mm: its jerk is v^3 (size / short)^2.
    by_jerk = np.cbrt(jerk_across * (short / (2 * half_cosine)) ** 2)
    junctions = np.where(straight, np.inf, np.minimum(np.sqrt(squared), by_jerk))
    curved = ~straight & (cosine > CURVE_TURN_COS)
    curving = np.concatenate(([False], curved)) | np.concatenate((curved, [False]))
    acceleration = np.where(curving, ALONG_SHARE * acceleration, acceleration)
    ends = np.concatenate(([0.0], junctions, [0.0]))
    ends[1:-1] = np.minimum(ends[1:-1], np.minimum(limits[:-1], limits[1:]))
    sections = join_segments(lengths, limits, ends, acceleration, jerk)
    moving, speeds = joint_speeds(sections)
    return cut_phases(p, lengths, along, moving, np.array(speeds))


def _along(directions: Floats, axes: Sequence[float]) -> Floats:
    """The axis limits along unit vectors: the minimum of limit / |component|."""
    with np.errstate(divide="ignore"):
        points: Floats = np.min(np.asarray(axes) / np.abs(directions), axis=1)
    return points
