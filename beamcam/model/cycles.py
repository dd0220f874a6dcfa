"""Canned cycles of drilling: one block that is carried out as several moves.

    G81 X Y Z R F      to X Y in rapid, to R in rapid, to Z at the feed, back in rapid
    G82 ... P          likewise, with a dwell of P seconds at Z
    G83 ... Q          Q deeper at a time, each time out to R and back in rapid, to clear chips
    G73 ... Q          Q deeper at a time, each time a little back, to break them
    G80                the end of the cycle

A tool that stood between R and Z before a run of cycles goes to R first, of each of them; one
that was drawn back to an R further in goes to the next place and to R at once. It is drawn back
to where it stood before the cycle, or to R where that lies further out or the controller is told
so (G99). Source: LinuxCNC documentation, "Canned Cycles", and what its interpreter does; DIN
66025.
"""

from collections.abc import Iterator
from typing import NamedTuple

DRILL, DRILL_AND_DWELL, PECK, BREAK_CHIPS, END = 81, 82, 83, 73, 80
DRILLING = (DRILL, DRILL_AND_DWELL, PECK, BREAK_CHIPS)
PECKING = (PECK, BREAK_CHIPS)
#: What each of them takes besides X, Y, Z, R and F.
OWN_LETTERS = {DRILL: "", DRILL_AND_DWELL: "P", PECK: "Q", BREAK_CHIPS: "Q"}
BACK = 0.254  #: mm between the tool and what is drilled, before it feeds on; 0.01 in
MAX_PECKS = 1000  #: of one hole; more is a slip of the decimal point
Place = tuple[float, float, float]


class CycleMove(NamedTuple):
    """One move of a cycle."""

    rapid: bool
    end: Place


def cycle_moves(
    at: Place, place: tuple[float, float], bottom: float, approach: float, clear: float,
    before: float, cycle: int = DRILL, peck: float = 0.0,
) -> Iterator[CycleMove]:  # fmt: skip
    """Moves of a cycle from the tool's position; `approach` is R, `clear` the retract position.

    `before` is where the tool stood before the first of a run of cycles; nan where that is unknown.
    """
    x, y = place
    inward = 1.0 if bottom > approach else -1.0
    z = at[2]
    if not inward * (before - approach) <= 0.0:
        if z != approach:
            yield CycleMove(True, (at[0], at[1], approach))
        at, z = (at[0], at[1], approach), approach
    elif inward * (z - approach) > 0.0:
        z = approach
    if (x, y, z) != at:
        yield CycleMove(True, (x, y, z))
    if z != approach:
        yield CycleMove(True, (x, y, approach))
    if cycle in PECKING:
        depth = approach + inward * peck
        while inward * (bottom - depth) > 0.0:
            yield CycleMove(False, (x, y, depth))
            if cycle == PECK:
                yield CycleMove(True, (x, y, approach))
            yield CycleMove(True, (x, y, depth - inward * BACK))
            depth += inward * peck
    yield CycleMove(False, (x, y, bottom))
    yield CycleMove(True, (x, y, clear))


def clear_place(before: float, approach: float, bottom: float, to_approach: bool) -> float:
    """The retract position of a cycle; `before` is the position before it."""
    if to_approach or before != before:
        return approach
    inward = 1.0 if bottom > approach else -1.0
    return before if inward * (approach - before) >= 0.0 else approach


def peck_fault(peck: float | None, approach: float, bottom: float) -> str | None:
    """What the depth fed at a time should be, where it cannot be what it is."""
    least = abs(bottom - approach) / MAX_PECKS
    if peck is None or peck <= 0.0:
        return "Q above 0, the depth that is fed at a time"
    return f"Q of at least {least:.4g}, {MAX_PECKS} feeds at most" if peck < least else None
