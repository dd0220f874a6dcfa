"""Segments of a path joined to stretches that are passed with one rise and one fall of speed.

At the joints of stretches the acceleration is 0, so a ramp cannot reach across them. A curve
that was cut in short chords would therefore never gain speed if every chord were a stretch of
its own:

    speed limit   ____      ____________      The limits of segments and of the junctions
                 |    |_ _ |            |     between them are a skyline. A tower that is too
                 |      | |             |     narrow to be climbed is levelled with its higher
              ___|      |_|             |__   neighbour; small steps in one direction are taken
                   narrow    worth it         together.
"""

from collections.abc import Sequence
from math import inf

from msgspec import Struct

from beamcam.geometry.ramps import ramp_seconds

#: A tower is worth climbing if the speed rises by this share of its foot in half its width.
WORTH_RISE = 0.1

#: Limits nearer to each other than this share are one.
SAME_SPEED = 1e-3

#: Short steps of a stair are one stretch while their limits lie within this ratio.
STAIR_RATIO = 1.25


class SpeedSection(Struct):
    """Segments `first` to `last` (excluded) under one limit; a junction has none."""

    limit: float
    length: float
    first: int
    last: int
    acceleration: float
    jerk: float


def _is_worth(tower: SpeedSection, foot: float) -> bool:
    """Whether a stretch is long enough to rise above `foot` and come down again."""
    gain = tower.limit - foot
    if gain <= SAME_SPEED * foot:
        return False
    change = min(gain, WORTH_RISE * foot)
    ramp_s = ramp_seconds(change, tower.acceleration, tower.jerk)
    return tower.length >= 2 * (foot + change / 2) * ramp_s


def _absorb(into: SpeedSection, other: SpeedSection) -> None:
    into.length += other.length
    into.first, into.last = min(into.first, other.first), max(into.last, other.last)
    into.acceleration = min(into.acceleration, other.acceleration)
    into.jerk = min(into.jerk, other.jerk)


def join_segments(
    lengths: Sequence[float],
    limits: Sequence[float],
    junctions: Sequence[float],
    accelerations: Sequence[float],
    jerks: Sequence[float],
) -> list[SpeedSection]:
    """The stretches of a path with n segments and n + 1 junctions, its ends included.

    Stretches without length are junctions whose limit stands for itself. Each segment is looked
    at a bounded number of times on average: a level tower is never looked at again.
    """
    skyline: list[SpeedSection] = []
    for i, junction in enumerate(junctions):
        _add(skyline, SpeedSection(junction, 0.0, i, i, inf, inf))
        if i < len(lengths):
            segment = SpeedSection(limits[i], lengths[i], i, i + 1, accelerations[i], jerks[i])
            _add(skyline, segment)
    return _join_stairs(skyline)


def _add(skyline: list[SpeedSection], new: SpeedSection) -> None:
    """Puts a stretch at the end, after levelling towers that it leaves too narrow."""
    while len(skyline) > 1 and skyline[-1].limit > new.limit:
        before, tower = skyline[-2], skyline[-1]
        if before.limit >= tower.limit or _is_worth(tower, max(before.limit, new.limit)):
            break
        skyline.pop()
        _absorb(before if before.limit >= new.limit else new, tower)
    if skyline and skyline[-1].limit == new.limit:
        _absorb(skyline[-1], new)
    else:
        skyline.append(new)


def _join_stairs(skyline: list[SpeedSection]) -> list[SpeedSection]:
    """Joins neighbours too short for a rise of their own while their limits are near."""
    found: list[SpeedSection] = []
    lowest = highest = 0.0
    for new in skyline:
        is_short = new.length > 0.0 and not _is_worth(new, new.limit / STAIR_RATIO)
        if is_short and lowest > 0.0:
            low, high = min(lowest, new.limit), max(highest, new.limit)
            if high <= STAIR_RATIO * low:
                _absorb(found[-1], new)
                found[-1].limit = lowest = low
                highest = high
                continue
        found.append(new)
        lowest, highest = (new.limit, new.limit) if is_short else (0.0, 0.0)
    return found
