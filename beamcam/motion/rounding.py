"""Points truncated to the decimals of a text."""

from math import sqrt

import numpy as np

from beamcam.geometry.array_types import Floats

#: Coordinates this share of a count below a whole count are that count when truncated: 0.29 is
#: a hair less than 0.29 in binary and shall not become 0.289.
TRUNCATION_SLACK = 1e-6


def truncated(points: Floats, counts: int) -> Floats:
    """The points on a grid of so many counts a mm, towards zero and without -0.0.

    Doing it twice changes nothing more; 0 counts leave points as they are.
    """
    if counts == 0:
        return points
    counted = points * counts
    return (np.trunc(counted + np.copysign(TRUNCATION_SLACK, counted)) + 0.0) / counts


def worst_truncation(counts: int) -> float:
    """The farthest that a point of the plane can be moved by it."""
    return sqrt(2) / counts if counts else 0.0
