"""What a planned path does at a time and at its joints, by its phases."""

import numpy as np


def positions(path, times):
    """Positions and velocities of the axes at some times."""
    t = np.clip(np.asarray(times, dtype=float), 0.0, path.duration_s)
    k = np.maximum(np.searchsorted(path.phase_start_s, t, side="right") - 1, 0)
    s = np.minimum(t - path.phase_start_s[k], path.phase_duration_s[k])
    v, a, j = path.phase_velocity[k], path.phase_acceleration[k], path.phase_jerk[k]
    segment = path.phase_segment[k]
    along = path.directions[segment]
    way = path.phase_position[k] + s * (v + s * (a / 2 + s * j / 6))
    return path.points[segment] + along * way[:, None], along * (v + s * (a + s * j / 2))[:, None]


def entries(path):
    """The speed at which each segment is entered."""
    first = np.searchsorted(path.phase_segment, np.arange(len(path.lengths)))
    return path.phase_velocity[first]
