"""Switching state while a program runs."""

from msgspec import Struct


class State(Struct, frozen=True):
    """Switching state, of bars and of sheets."""

    spindle: int = 0  #: number that the program chose, 0 before
    diameter: float = 0.0
    turning: int = 0  #: 1 clockwise, -1 counter-clockwise, 0 standing
    coolant: bool = False
    sawing: bool = False
    process: str = ""  #: of the torch, laser or marker that is on
