"""Closed chains as polygons, sampled point by point."""

import numpy as np

from beamcam.geometry.curves import Line
from beamcam.geometry.polylines import points_at


def polygon_of(chain, points_a_curve=256):
    """Corners of a polygon through points of the curves, array (n, 2), not closed."""
    share = np.linspace(0.0, 1.0, points_a_curve + 1)[:-1]
    parts = [
        np.array([c.start], dtype=np.float64) if isinstance(c, Line) else points_at(c, share)
        for c in chain
    ]
    return np.concatenate(parts)
