"""Every word that a table's controller knows, put into every state of the programs of a table.

Each is refused by one of the codes of its row in `checks/sheets/owners.py`, or the row says why it
is harmless; then the head goes the same way, with its tools on where they were.
"""

import re
from collections.abc import Iterator
from fnmatch import fnmatchcase
from itertools import groupby

import pytest
from msgspec import Struct

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.checks.sheets.owners import OWNERS
from beamcam.controllers import interpreter_of, table_events
from beamcam.controllers.events import Compensation, Lift, Move, Output, Pause, Switch, ToolOffset
from beamcam.errors import Severity
from beamcam.machine import Machine
from beamcam.pipeline import post
from tests.conftest import sampled
from tests.owners import owner_of
from tests.unit.sheets.parts import box, circle, contour, drawing, lines, table

PART = drawing(
    contour(box(0, 0, 60, 40), line=1), contour(circle(30, 20, 16), line=2),
    contour(lines((45, 10), (55, 14), closed=False), "#0000ff", line=3),
)  # fmt: skip
#: The shipped tables that run G-code, each with the options that give it other words, and how many
#: states by turns share a word: fifteen where a controller comes first, 24 where it comes again.
SET_UPS: list[tuple[str, dict[str, object], int]] = [
    ("plate-linuxcnc", {}, 15), ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"}, 24),
    ("plate-oxyfuel", {"thickness": 10.0}, 24), ("plate-codesys", {}, 15),
    ("plate-codesys", {"kerf_by": "machine", "lead": "line"}, 24),
    ("laser-grbl", {"material": "wood"}, 15), ("plate-mach3", {}, 15), ("plate-qtplasmac", {}, 24),
]  # fmt: skip
#: Each word with each of its values in each state.
WHOLE = [
    pytest.param(*set_up, 0, marks=pytest.mark.exhaustive) for *set_up, turns in SET_UPS
    if turns == 15
]  # fmt: skip
#: Usual and absurd values of what a word carries.
VALUES = {
    **dict.fromkeys("XY", ("0", "333", "-50", "99999")), **dict.fromkeys("IJ", ("0", "5", "99999")),
    **dict.fromkeys("PTQ", ("0", "0.01", "1", "-1", "9999")), "R": ("0", "5", "-5", "9999"),
    "K": ("0", "90"), "D": ("0", "2", "-2", "9999"), "S": ("0", "1", "500", "99999"),
    "$": ("0", "1", "2", "9"), "F": ("0", "1", "2300", "-5", "99999999"),
    "L": ("0", "2", "20"), "E": ("0", "1000", "5", "99999"),
    **dict.fromkeys("HZ", ("0", "1", "-5", "9999")),
}  # fmt: skip
#: M words that neither move a head nor switch its tool: coolant, stops, overrides.
IDLE = {0, 1, 6, 7, 8, 9, 48, 49, 50, 51, 52, 53, 60}
PATH = frozenset(("G0", "G1", "G2", "G3", "G6", "G8", "G9"))
NEEDS = {"G2": "I5 J0", "G3": "I5 J0", "G6": "I5 J5", "G8": "I5 J0 K0 R0.5", "G9": "I5 J0 K0 R0.5",
         "G31": "F600", "G92": "Z0", "G10": "L20 P0 Z0", "G81": "R1",
         "G82": "P1 R1", "G83": "Q1 R1", "G73": "Q1 R1"}  # fmt: skip
LIFTING = ("G10", "G31", "G92")
MOVE = re.compile(r"^(?:N\d+ )?G0?[0-9] ?X")


class Put(Struct, frozen=True):
    """A block, and the word and letter whose row it asks for."""

    word: str
    letter: str
    block: str


def blocks(machine: Machine) -> Iterator[Put]:
    """Every word by itself, and with each thing that it carries at each of its values."""
    known = interpreter_of(machine, "").vocabulary()
    for word, letters in known.items():
        if word.startswith("codes: "):
            meant = word.removeprefix("codes: ")
            yield from (Put(word, "", key) for key, does in machine.codes.items() if does == meant)
            continue
        if word in ("other", "choose", "change"):
            continue
        if word in ("F", "S", "T"):
            yield from (Put(word, "", f"{word}{value}") for value in VALUES[word])
            continue
        yield Put(word, "", word)
        own = sorted(letter for letter in letters if not letter.startswith("{"))
        for letter in own:
            for value in VALUES[letter[0]]:
                said = f"{letter}{value}"
                more = NEEDS.get(word, "")
                if letter[0] in "IJKRPQLZ" and word in NEEDS:
                    more = " ".join(w for w in more.split() if w[0] != letter[0])
                flat = word in NEEDS and word not in LIFTING
                place = "X333 Y333" if flat and letter not in "XY" else ""
                if letter in ("E", "E-", "F") and word in PATH and not place:
                    place = "X333 Y333"
                yield Put(word, letter, " ".join(w for w in (word, place, more, said) if w))


def places(text: str) -> dict[str, int]:
    """Where a block is put: before these lines of a program, by the state that holds there."""
    found = text.split("\n")
    moves = [k for k, line in enumerate(found) if MOVE.match(line)]
    cuts = [
        k
        for k, line in enumerate(found)
        if re.match(r"^(N\d+ )?(M0?3(?: \$0)?(?: S1)?|M4 S\d+ F\d+)$", line)
    ]
    start = cuts[1]
    first = next(k for k in moves if k > start)
    end = next(
        k for k in range(first, len(found)) if re.match(r"^(N\d+ )?M0?5(?: \$0)?$", found[k])
    )
    last = next(
        k for k in reversed(range(len(found))) if re.match(r"^(N\d+ )?M0?(2|30)$", found[k])
    )
    return {
        "before the first move": moves[0], "before the tool starts": start,
        "as it pierces": start + 1, "before the first move with the tool on": first,
        "in mid contour": first + 1, "before the tool stops": end, "behind the stop": end + 1,
        "before the end": last, "behind the end": last + 1,
    }  # fmt: skip


def work(text: str, machine: Machine) -> list[tuple[object, ...]]:
    """What the head does: its moves with the tool on, and each word that starts or stops one."""
    found: list[tuple[object, ...]] = []
    on = False
    states: dict[str, int] = {"arc": True}  # unless it is put out
    for event in table_events(text, machine)[0]:
        if isinstance(event, Move) and on:
            if event.start != event.end or event.curve is not None:
                own = event.curve, event.rapid, event.feed_mm_min
                found.append((event.start, event.end, *own, sorted(filter(states.get, states))))
        elif isinstance(event, Switch) and event.number not in IDLE:
            was, on = on, event.number not in (2, 5, 15, 30)
            if on or was:
                found.append(event.said)
        elif isinstance(event, Pause) and on and event.seconds:
            found.append(("pause", event.seconds))
        elif isinstance(event, Output):
            states[event.name] = event.on
        elif isinstance(event, ToolOffset):
            states["tool"] = event.number
        elif isinstance(event, Lift) and on:
            found.append((event.start, event.end, event.rapid))
        elif isinstance(event, Compensation) and on:
            found.append((event.side, event.radius))
    return found


def tried(machine: Machine, states: int, turns: int) -> Iterator[tuple[Put, int]]:
    """Each block with the number of a state that it is put into.

    By turns a word and its letter come in each state, or in one of several, with one of the values.
    """
    rows = groupby(blocks(machine), lambda put: (put.word, put.letter))
    for row, (_, alike) in enumerate(rows):
        several = list(alike)
        for state in range(states):
            if not turns:
                yield from ((put, state) for put in several)
            elif (row + state) % turns == 0:
                yield several[state // turns % len(several)], state


@pytest.mark.parametrize(("name", "values", "turns"), [*sampled(SET_UPS, 2), *WHOLE])
def test_each_word_in_each_state_is_refused_or_harmless(
    name: str, values: dict[str, object], turns: int
) -> None:
    machine = table(name, **values)
    rows = OWNERS["sheet", machine.controller]  # type: ignore[index]
    text = post((PART,), machine).text
    before, done = text.split("\n"), work(text, machine)
    wrong: list[str] = []
    count, states = 0, [*places(text).items()]
    for put, number in tried(machine, len(states), turns):
        owner = owner_of(put.word, put.letter, rows)
        state, k = states[number]
        changed = "\n".join([*before[:k], put.block, *before[k:]])
        said = verify_sheet(changed, (PART,), machine)
        codes = {one.code for one in said if one.severity is Severity.ERROR}
        count += 1
        if codes:
            if not any(fnmatchcase(c, p) for c in codes for p in owner.refused_by):
                wrong.append(f"{put.block} {state}: {sorted(codes)}, of its row none")
        elif not owner.harmless:
            wrong.append(f"{put.block} {state}: passes, and nothing says why")
        elif work(changed, machine) != done:
            wrong.append(f"{put.block} {state}: passes, and the head does something else")
    assert count > {0: 900, 15: 25, 24: 14}[turns]
    assert not wrong, "\n".join(wrong)
