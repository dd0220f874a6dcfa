"""A path with its motion: phases of constant jerk, each within one segment."""

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Counts, Floats
from beamcam.motion.jerk_ramps import peak_rises, ramp_phases
from beamcam.motion.speed_sections import SpeedSection


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
    """Phases of all stretches, cut at the ends of segments."""
    ramps = _ramps_of(moving, speeds)
    first = np.array([s.first for s in moving])
    before = np.cumsum(lengths) - lengths
    stretch, phase, time, is_segment = _starts(ramps, moving, first, before)
    segment = first[stretch] + _count_within(is_segment, stretch)
    last = np.append(stretch[1:] != stretch[:-1], True)
    end_t = ramps.end_t
    until = np.where(last, end_t[stretch, 6], np.append(time[1:], 0.0))
    spent = until - time
    at = stretch, phase
    s = np.maximum(0.0, time - ramps.start_t[at])
    a = ramps.start_a[at] + s * ramps.held_j[at]
    speed = ramps.v[at] + s * (ramps.start_a[at] + s * ramps.held_j[at] / 2)
    came = ramps.x[at] + s * (ramps.v[at] + s * (ramps.start_a[at] / 2 + s * ramps.held_j[at] / 6))
    came = np.maximum(0.0, came - (before[segment] - before[first[stretch]]))
    kept = spent > 0.0
    base = np.cumsum(end_t[:, 6]) - end_t[:, 6]
    return PlannedPath(
        points, lengths, along, float(np.sum(end_t[:, 6])),
        segment[kept], (base[stretch] + time)[kept], spent[kept], came[kept],
        np.maximum(0.0, speed[kept]), a[kept], ramps.held_j[at][kept],
    )  # fmt: skip


class _Ramps(Struct, frozen=True):
    """The seven phases (n, 7) of each stretch: up, cruise and down."""

    duration: Floats
    start_a: Floats
    held_j: Floats
    v: Floats  #: at the start of each
    x: Floats  #: from the stretch's start to that of each
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
    # State at the start of each phase, from the stretch's start.
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
    """All starts of phases and of segments in order: stretch, phase and time of each, and whether
    it is that of a segment (1 or 0).

    `first` is the first segment of each stretch, `before` the length before each segment.
    """
    # Where segments begin inside a stretch, and when that is.
    which = np.repeat(np.arange(len(moving)), [s.last - s.first for s in moving])
    inside = np.flatnonzero(np.arange(len(before)) != first[which])
    run = which[inside]
    offset = before[inside] - before[first[run]]
    # Stretches shrink to their phases, which rounding leaves a hair shorter or longer.
    way = np.array([s.length for s in moving])
    offset = offset * (ramps.x[run, -1] + ramps.gone[run, -1]) / way[run]
    k = np.clip(np.sum(offset[:, None] >= ramps.x[run], axis=1) - 1, 0, 6)
    at = run, k
    local = _time_at(
        offset - ramps.x[at], ramps.v[at], ramps.start_a[at], ramps.held_j[at], ramps.duration[at]
    )
    stretch = np.concatenate((np.repeat(np.arange(len(moving)), 7), run))
    inner = np.minimum(ramps.start_t[at] + local, ramps.end_t[at])
    time = np.concatenate((ramps.start_t.reshape(-1), inner))
    phase = np.concatenate((np.tile(np.arange(7), len(moving)), k))
    is_segment = np.concatenate((np.zeros(7 * len(moving), int), np.ones(len(run), int)))
    # Of one time the phase comes first.
    order = np.lexsort((is_segment, time, phase, stretch))
    return stretch[order], phase[order], time[order], is_segment[order]


def _count_within(flags: Counts, groups: Counts) -> Counts:
    """Running sum of `flags` that starts again in each group of equal neighbours."""
    total = np.cumsum(flags)
    opens = np.append(True, groups[1:] != groups[:-1])
    start = np.where(opens, total - flags, 0)
    return np.asarray(total - np.maximum.accumulate(start), dtype=np.int64)


def _time_at(way: Floats, v: Floats, a: Floats, j: Floats, longest: Floats) -> Floats:
    """Times at which phases have covered `way`, by bisection, as the distance only grows."""
    low, high = np.zeros_like(way), longest.copy()
    for _ in range(54):
        t = (low + high) / 2
        short = t * (v + t * (a / 2 + t * j / 6)) < way
        low, high = np.where(short, t, low), np.where(short, high, t)
    return (low + high) / 2
