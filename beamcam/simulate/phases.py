"""Chords that are passed at planned speeds, as intervals of a trace."""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Counts, Floats
from beamcam.motion.planned import cut_phases
from beamcam.motion.speed_sections import SpeedSection

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

    `sections` are the stretches of the paths by their chords, `joints` the speeds between them.
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
