"""Rounding of a coordinate: to the decimals of a text or the counts of an encoder."""

from math import sqrt

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Floats

#: Coordinates this share of a count below a whole count are that count when truncated: 0.29 is
#: a hair less than 0.29 in binary and shall not become 0.289.
TRUNCATION_SLACK = 1e-6


class Rounding(Struct, frozen=True):
    """A grid of `counts` on every `travel` mm; 0 counts leave coordinates as they are."""

    counts: int
    travel: float = 1.0
    truncate: bool = False  #: towards zero instead of to the nearest count

    def __post_init__(self) -> None:
        if self.counts < 0 or not self.travel > 0.0:
            raise ValueError(f"no grid: {self.counts} counts on {self.travel:g} mm")

    @property
    def worst(self) -> float:
        """The farthest that a point of the plane can be moved."""
        if self.counts == 0:
            return 0.0
        step = self.travel / self.counts
        return step * sqrt(2) if self.truncate else step * sqrt(0.5)

    def apply(self, points: Floats) -> Floats:
        """The points on the grid, without -0.0; applying it twice changes nothing more."""
        if self.counts == 0:
            return points
        counted = points * (self.counts / self.travel)
        if self.truncate:
            whole = np.trunc(counted + np.copysign(TRUNCATION_SLACK, counted))
        else:
            whole = np.rint(counted)
        return (whole + 0.0) * self.travel / self.counts


EXACT = Rounding(0)
MICRON_TRUNCATED = Rounding(1000, truncate=True)  #: as a program that cuts after 0.001 mm
BELT_ENCODER = Rounding(512, 65.0)  #: 512 counts on 65 mm, the two-axis cutting table


def decimals(places: int) -> Rounding:
    """The grid of numbers with so many decimals."""
    return Rounding(10**places)
