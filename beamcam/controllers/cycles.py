"""Canned cycles of drilling: one block that is carried out as several moves.

    G81 X Y Z R F      to X Y in rapid, to R in rapid, to Z at the feed, back in rapid
    G82 ... P          likewise, with a dwell of P seconds at Z
    G80                the end of the cycle

A tool that stands between R and Z goes to R first. It is drawn back to where it stood before the
cycle, or to R where that lies further out or the controller is told so (G99). Source: LinuxCNC
documentation, "Canned Cycles"; DIN 66025.
"""

from collections.abc import Iterator
from typing import NamedTuple

from beamcam.controllers.events import Place

DRILL, DRILL_AND_DWELL, END = 81, 82, 80


class Step(NamedTuple):
    """One move of a cycle."""

    rapid: bool
    end: Place


def steps(
    at: Place, x: float, y: float, bottom: float, near: float, clear: float
) -> Iterator[Step]:
    """Moves of a cycle from the tool's position; `near` is R `clear` the retract position."""
    inward = 1.0 if bottom > near else -1.0
    z = at[2]
    if not inward * (z - near) <= 0.0:  # nearer the bottom than R, or from nowhere
        z = near
        yield Step(True, (at[0], at[1], near))
    if (x, y) != at[:2]:
        yield Step(True, (x, y, z))
    if z != near:
        yield Step(True, (x, y, near))
    yield Step(False, (x, y, bottom))
    yield Step(True, (x, y, clear))


def clear_place(before: float, near: float, bottom: float, to_near: bool) -> float:
    """The retract position of a cycle; `before` is the position before it."""
    if to_near or before != before:
        return near
    inward = 1.0 if bottom > near else -1.0
    return before if inward * (near - before) >= 0.0 else near
