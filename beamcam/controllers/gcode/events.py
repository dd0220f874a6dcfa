"""What the program of a cutting table does, event by event, whatever its controller.

Plain tuples, because a drawing makes tens of thousands. Lengths mm, feeds mm/min.
"""

from typing import Literal, NamedTuple

from beamcam.geometry.curves import Arc, Bezier, EllipseArc
from beamcam.geometry.plane import Point

Side = Literal["on", "left", "right"]


class Leg(NamedTuple):
    """A move of the head."""

    line: int
    rapid: bool
    start: Point
    end: Point
    curve: Arc | Bezier | EllipseArc | None  #: None for a straight one
    feed_mm_min: float


class Switch(NamedTuple):
    """An M word."""

    line: int
    number: int
    words: tuple[tuple[str, float], ...]  #: its parameters by letter, in the alphabet's order

    def __str__(self) -> str:
        return " ".join([f"M{self.number}", *(f"{k}{v:g}" for k, v in self.words)])


class Pause(NamedTuple):
    """A dwell."""

    line: int
    seconds: float


class Keep(NamedTuple):
    """From here on the controller keeps beside the contour, by a radius."""

    line: int
    side: Side
    radius: float


class Ramp(NamedTuple):
    """From here on the head runs up, or brakes, at an acceleration in mm/s2."""

    line: int
    braking: bool
    mm_s2: float


Event = Leg | Switch | Pause | Keep | Ramp
