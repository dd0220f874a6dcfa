"""What a program does, event by event, whatever controller it is written for.

Plain tuples, because every run of `post` makes thousands of them. Coordinates are mm, feeds
mm/min; a coordinate that no block has named yet is not a number (nan).
"""

from typing import NamedTuple

Place = tuple[float, float, float]  #: X, Y, Z


class Move(NamedTuple):
    """A straight move."""

    line: int
    rapid: bool
    start: Place
    end: Place
    feed_mm_min: float  #: 0 where no F stands before


class Turn(NamedTuple):
    """A move along an arc in X and Y, Z in step with it."""

    line: int
    start: Place
    end: Place
    centre: tuple[float, float]
    sweep_deg: float
    feed_mm_min: float


class Switch(NamedTuple):
    """An M word."""

    line: int
    number: int
    words: dict[str, float]  #: its parameters by letter


class Pause(NamedTuple):
    """A dwell."""

    line: int
    seconds: float


Event = Move | Turn | Switch | Pause
