"""What a program does, event by event: one vocabulary for every controller.

    Move     the tool or the bar goes straight from place to place, in rapid or at a feed
    Turn     it goes along an arc
    Switch   an M word: something starts, stops, is chosen, cuts, or the program ends
    Pause    it waits

Plain tuples, because every run of `post` makes thousands of them. Coordinates are mm, feeds
mm/min; a coordinate that no block has named yet is not a number (nan). A controller that has more
(compensation, curves, outputs that are switched on the way) adds its event here, so that whoever
follows a program learns one set of words.
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
    own_feed: bool = False  #: whether the feed stands in its own block


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
