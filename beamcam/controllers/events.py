"""What a program does, event by event: one vocabulary for every controller.

Bars, and what moves along three axes:

    Move     the tool or the bar goes straight from place to place, in rapid or at a feed
    Turn     it goes along an arc

Tables, and what follows contours in a plane:

    Leg      the head goes straight or along a curve, in rapid or at a feed
    Keep     the controller keeps beside the contour from here on
    Ramp     the head runs up or brakes at another acceleration from here on

Both:

    Switch   an M word: something starts, stops, is chosen, cuts, or the program ends
    Pause    it waits

Plain tuples, because every run of `post` makes thousands of them, and a drawing tens of thousands.
Coordinates are mm, feeds mm/min; a coordinate that no block has named yet is not a number (nan). A
controller that has more (outputs that are switched on the way) adds its event here, so that whoever
follows a program learns one set of words.
"""

from typing import Literal, NamedTuple

from beamcam.geometry.curves import Arc, Bezier, EllipseArc
from beamcam.geometry.plane import Point

Place = tuple[float, float, float]  #: X, Y, Z
Side = Literal["on", "left", "right"]


class Move(NamedTuple):
    """A straight move."""

    line: int
    rapid: bool
    start: Place
    end: Place
    feed_mm_min: float  #: 0 where no F stands before
    own_feed: bool = False  #: whether the feed stands in its own block


class Turn(NamedTuple):
    """A move along an arc in X and Y, Z in step with it."""

    line: int
    start: Place
    end: Place
    centre: tuple[float, float]
    sweep_deg: float
    feed_mm_min: float


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
    words: dict[str, float]  #: its parameters by letter

    @property
    def said(self) -> "Said":
        """The word by itself, wherever it stands."""
        return self.number, tuple(sorted(self.words.items()))

    def __str__(self) -> str:
        return " ".join([f"M{self.number}", *(f"{k}{v:g}" for k, v in sorted(self.words.items()))])


Said = tuple[int, tuple[tuple[str, float], ...]]  #: number of an M word, and its parameters


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


BarEvent = Move | Turn | Switch | Pause
TableEvent = Leg | Keep | Ramp | Switch | Pause
