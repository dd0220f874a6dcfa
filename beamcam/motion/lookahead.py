"""Look-ahead: the speed of each segment of a path within the limits of the axes.

    1  Limits. A segment has those of its axes along its direction. A junction turns the path:
       it is passed at the speed at which a circle that stays within `deviation` of the corner
       keeps the acceleration (grbl), and at which the turn, spread over half of both segments,
       keeps acceleration (Klipper) and jerk: that is what limits a curve of short chords.
    2  Segments are joined to stretches (`stretches`), between which the acceleration is 0.
    3  Backward, then forward: no joint is passed faster than a jerk-limited ramp over the next,
       the last stretch allows. A ramp that fits still fits if its faster end gets slower, so
       two passes are enough and no stretch is left without room.
    4  Each stretch rises to a peak and falls; its phases are cut where a segment ends.

On a curve acceleration along the path and across it add up, so they share the limit as in
LinuxCNC's planner: 1/2 along, sqrt(3)/2 across.
Sources: grbl, planner.c; Klipper, toolhead.py; LinuxCNC, tp.c.
"""

from collections.abc import Sequence
from math import cos, radians, sqrt

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike, NDArray

from beamcam.geometry.array_types import Floats
from beamcam.motion.jerk_ramps import reachable_speed
from beamcam.motion.planned import PlannedPath, cut_phases
from beamcam.motion.profile import Limits
from beamcam.motion.speed_sections import SpeedSection, join_segments

ALONG_SHARE = 0.5
ACROSS_SHARE = sqrt(0.75)

#: A turn of less than this from chord to chord is part of a curve, a sharper one is a corner.
CURVE_TURN_COS = cos(radians(30.0))


class LookAheadRules(Struct, frozen=True):
    """Axis limits and cornering rules."""

    axes: tuple[Limits, ...]  #: one for each column of the points
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
    asked = np.broadcast_to(np.asarray(speed_mm_s, dtype=np.float64), lengths.shape)
    if not np.all(asked > 0.0):
        raise ValueError(f"speeds must be above 0, found {float(np.min(asked)):g}")
    along = step / lengths[:, None]
    velocity, acceleration, jerk = (
        _along(along, [getattr(axis, name) for axis in rules.axes])
        for name in ("velocity", "acceleration", "jerk")
    )
    limits = np.minimum(asked, velocity)
    junctions, curved = _junction_limits(lengths, along, rules)
    curving = np.concatenate(([False], curved)) | np.concatenate((curved, [False]))
    acceleration = np.where(curving, ALONG_SHARE * acceleration, acceleration)
    ends = np.concatenate(([0.0], junctions, [0.0]))
    ends[1:-1] = np.minimum(ends[1:-1], np.minimum(limits[:-1], limits[1:]))
    stretches = join_segments(
        lengths.tolist(), limits.tolist(), ends.tolist(), acceleration.tolist(), jerk.tolist()
    )
    moving, speeds = joint_speeds(stretches)
    return cut_phases(p, lengths, along, moving, np.array(speeds))


def _along(directions: Floats, axes: Sequence[float]) -> Floats:
    """The axis limits along unit vectors: the minimum of limit / |component|."""
    with np.errstate(divide="ignore"):
        found: Floats = np.min(np.asarray(axes) / np.abs(directions), axis=1)
    return found


def _junction_limits(
    lengths: Floats, along: Floats, rules: LookAheadRules
) -> tuple[Floats, NDArray[np.bool_]]:
    """Greatest speeds at the n - 1 inner junctions, and which of them belong to a curve."""
    turn = along[1:] - along[:-1]
    size = np.sqrt(np.einsum("ij,ij->i", turn, turn))
    cosine = np.clip(np.einsum("ij,ij->i", along[1:], along[:-1]), -1.0, 1.0)
    straight = size < 1e-9
    where = np.where(straight, 1.0, size)[:, None]
    across = _along(
        np.where(straight[:, None], 1.0, turn / where), [x.acceleration for x in rules.axes]
    )
    jerk = _along(np.where(straight[:, None], 1.0, turn / where), [x.jerk for x in rules.axes])
    # Half of the angle between the segments: its sine is cos(turn / 2), its cosine size / 2.
    half_sine, half_cosine = np.sqrt((1.0 + cosine) / 2), np.where(straight, 1.0, size / 2)
    short = np.minimum(lengths[1:], lengths[:-1])
    # 1 - sin = cos^2 / (1 + sin), without the loss of digits of nearly straight junctions.
    corner = across * rules.deviation * half_sine * (1.0 + half_sine) / half_cosine**2
    spread = 0.5 * short * half_sine / half_cosine * across * ACROSS_SHARE
    squared = np.minimum(corner, spread)
    # Speed v turns the path by size / short in each mm: its jerk is v^3 (size / short)^2.
    by_jerk = np.cbrt(jerk * (short / (2 * half_cosine)) ** 2)
    limit = np.where(straight, np.inf, np.minimum(np.sqrt(squared), by_jerk))
    return limit, ~straight & (cosine > CURVE_TURN_COS)


def joint_speeds(stretches: list[SpeedSection]) -> tuple[list[SpeedSection], list[float]]:
    """The stretches that have a length, and the speeds at their n + 1 joints."""
    moving: list[SpeedSection] = []
    speeds: list[float] = []
    limit = stretches[0].limit
    for stretch in stretches:
        limit = min(limit, stretch.limit)
        if stretch.length > 0.0:
            moving.append(stretch)
            speeds.append(limit)
            limit = stretch.limit
    speeds.append(limit)
    for k in range(len(moving) - 1, -1, -1):
        s = moving[k]
        if speeds[k] > speeds[k + 1]:
            reach = reachable_speed(speeds[k + 1], s.length, s.acceleration, s.jerk)
            speeds[k] = min(speeds[k], reach)
    for k, s in enumerate(moving):
        if speeds[k + 1] > speeds[k]:
            reach = reachable_speed(speeds[k], s.length, s.acceleration, s.jerk)
            speeds[k + 1] = min(speeds[k + 1], reach)
    return moving, speeds
