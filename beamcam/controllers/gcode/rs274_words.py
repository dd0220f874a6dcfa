"""What a block of RS274/NGC says by itself, whatever was said before it.

Written from the "G-Code Overview" of the LinuxCNC documentation and the grbl 1.1 wiki.
"""

import re
from collections.abc import Callable

from msgspec import Struct

from beamcam.controllers.events import Keep, Pause, Side, Switch, TableEvent
from beamcam.controllers.gcode import rules
from beamcam.errors import Rule
from beamcam.geometry.plane import Point

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)"
_WORD = re.compile(rf"([A-Z])({_NUMBER})")
_COMMENT = re.compile(r"\([^()]*\)|;.*")

MOTIONS = {"G0": 0, "G1": 1, "G2": 2, "G3": 3}
ENDS = (2, 30)
Fault = str | None


class Dialect(Struct, frozen=True):
    """What a controller of the family takes, and what it does with arcs."""

    name: str
    percent: bool  #: whether % stands alone on the first and the last line
    longest_line: int  #: characters
    settings: frozenset[str]  #: G words that need no more than to be there
    needed: tuple[str, ...]  #: those that a program has to say before it moves
    switches: dict[int, frozenset[str]]  #: M words and the letters that belong to them
    beside: dict[str, Side]  #: G words of cutter compensation
    arc_fault: Callable[[Point, Point, Point, bool], Fault]  #: start, end, centre, clockwise


class Block(Struct, frozen=True):
    """What a block says by itself, whatever was said before it."""

    faults: tuple[tuple[Rule, str, str], ...] = ()  #: what is wrong, found, expected
    feed: float | None = None
    events: tuple[TableEvent, ...] = ()  #: before its move; their lines are 0
    settings: tuple[str, ...] = ()
    motion: int | None = None
    values: dict[str, float] = {}  #: of the words that are left for the move
    ends: tuple[int, ...] = ()
    blank: bool = False
    percent: bool = False


def read_block(text: str, dialect: Dialect) -> Block:
    """What the words of a block say."""
    bare = _COMMENT.sub(" ", text).upper().strip()
    if bare == "%":
        return Block(percent=True)
    if "(" in bare or ")" in bare:
        return _not_read(text, "a comment that begins and ends on its line")
    squeezed = "".join(bare.split())
    words = _WORD.findall(squeezed)
    if "".join(letter + digits for letter, digits in words) != squeezed:
        return _not_read(text, "letters with a number each")
    if not words:
        return Block(blank=True)
    values: dict[str, float] = {}
    codes: list[str] = []
    switches: list[int] = []
    faults: list[tuple[Rule, str, str]] = []

    def wrong(found: str, expected: str) -> None:
        faults.append((rules.WORD, found, expected))

    for place, (letter, digits) in enumerate(words):
        value = float(digits)
        if letter == "N":
            if place:
                wrong(f"N{digits}", "it at the beginning of a block")
        elif letter == "G":
            codes.append(f"G{value:g}")
        elif letter == "M":
            switches.append(int(value))
            if value != int(value):
                wrong(f"M{digits}", "a whole number")
        elif letter in values:
            wrong(f"{letter} twice in a block", "it once")
        else:
            values[letter] = value
    feed = values.pop("F", None)
    events: list[TableEvent] = []
    for number in switches:
        letters = dialect.switches.get(number)
        if number in ENDS:
            continue
        if letters is None:
            wrong(f"M{number}", f"an M word that {dialect.name} knows")
        else:
            own = {k: values.pop(k) for k in letters & values.keys()}
            events.append(Switch(0, number, own))
    settings = [code for code in codes if code not in MOTIONS]
    for code in settings:
        if code == "G4":
            if "P" in values:
                events.append(Pause(0, values.pop("P")))
            else:
                wrong("G4", "P with seconds")
        elif code in dialect.beside:
            events.append(Keep(0, dialect.beside[code], values.pop("D", 0.0) / 2))
        elif code == "G40":
            events.append(Keep(0, "on", 0.0))
        elif code == "G64" and code in dialect.settings:
            values.pop("P", None)
            values.pop("Q", None)
        elif code not in ("G90", "G91") and code not in dialect.settings:
            wrong(code, f"a G word that {dialect.name} knows here")
    motions = [MOTIONS[code] for code in codes if code in MOTIONS]
    if len(motions) > 1:
        wrong("two motions in a block", "one")
    return Block(
        tuple(faults), feed, tuple(events), tuple(settings), motions[-1] if motions else None,
        values, tuple(m for m in switches if m in ENDS),
    )  # fmt: skip


def _not_read(text: str, expected: str) -> Block:
    return Block(((rules.SYNTAX, text.strip(), expected),))
