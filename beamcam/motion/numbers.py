"""The numbers of a controller: how lengths are written, and which arcs it accepts."""

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Floats
from beamcam.geometry.plane import Point

#: A number as near to the middle of two steps, in steps, is rounded by its exact decimals.
DOUBT = 1e-5


class Numbers(Struct, frozen=True):
    """Number format of the controller, and what it accepts."""

    decimals: int
    angle_decimals: int
    tolerance: float  #: left for chords that replace an arc
    arc_limit: float  #: max difference of the radii at both ends
    min_radius: float
    max_radius: float

    @property
    def step(self) -> float:
        """The smallest length that is written."""
        return 10.0**-self.decimals

    def at(self, point: Point) -> Point:
        """A point as it is written; never -0."""
        d = self.decimals
        return round(point[0], d) + 0.0, round(point[1], d) + 0.0

    def rounded(self, values: Floats) -> Floats:
        """Numbers as they are written, each as `at` has it."""
        scaled = values * 10.0**self.decimals
        whole = np.rint(scaled)
        found: Floats = whole / 10.0**self.decimals + 0.0
        # Scaled to steps a number may come to lie on the other side of a middle.
        for place in zip(*np.nonzero(np.abs(scaled - whole) > 0.5 - DOUBT), strict=True):
            found[place] = round(float(values[place]), self.decimals) + 0.0
        return found
