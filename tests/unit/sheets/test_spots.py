"""Spots: centres for the drill that a torch burns where it stands, each once, before any cut."""

import re
from math import cos, pi, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch_faults import torch_faults
from beamcam.model.part import Hole, Part, Slot
from beamcam.model.plan import SheetPlan
from beamcam.pipeline import post
from beamcam.recovery import recover
from tests.conftest import examples
from tests.unit.sheets.parts import S, plate

SPOTTED = re.compile(r"G0 X(\S+) Y(\S+)\nM3 \$2 S1\nF2300\nG1 X(\S+) Y(\S+)\nM5 \$2\n")


def spots(text: str) -> list[tuple[float, float]]:
    """Places in the part's own numbers; the table lays it 10 mm from its corner."""
    return sorted((float(x) - 10, float(y) - 10) for x, y, _, _ in SPOTTED.findall(text))


def posted(part: Part, machine: Machine | None = None) -> str:
    text = post((part,), machine or load("plate-qtplasmac")).text
    assert isinstance(text, str)
    return text


#: On 6 mm holes below 4.8 mm are drilled; a thread, a centre point, and a slot of 4 mm too.
DRILLED = plate(
    Hole("v", 30, 20, 4.0, S), Hole("v", 60, 20, 12.0, S, kind="thread"),
    Hole("v", 90, 20, 0.0, S, kind="mark"), Slot("v", 150, 50, 4.0, 30.0, 0.0, 30.0, S),
    Hole("v", 60, 70, 20.0, S), Hole("v", 30, 20, 4.0, S),
)  # fmt: skip


def test_what_the_torch_does_not_make_is_spotted_once() -> None:
    """By hand: both ends of the slot are 15 mm from its middle; two holes lie at one place."""
    text = posted(DRILLED)
    x, y = 15 * cos(pi / 6), 15 * sin(pi / 6)
    expected = [(30, 20), (60, 20), (90, 20), (150 - x, 50 - y), (150 + x, 50 + y)]
    for found, wanted in zip(spots(text), expected, strict=True):
        assert found == pytest.approx(wanted, abs=1e-3)
    moves = [float(x1) - float(x0) for x0, _, x1, _ in SPOTTED.findall(text)]
    assert all(0.0 < move <= 0.011 for move in moves)
    assert text.index("M3 $2") < text.index("M3 $0")
    assert text.index("(o=0") < text.index("M3 $2")  # the arc is that of the sheet's material


def test_the_ledger_has_them_for_the_hand() -> None:
    plan = post((DRILLED,), load("plate-qtplasmac")).plan
    assert isinstance(plan, SheetPlan)
    hows = ["listed", "listed", "made", "listed", "made", "listed"]
    assert [o.how for o in plan.outcomes] == hows
    assert plan.outcomes[2].by == "spot"


LINE = "G0 X70 Y30\nM3 $2 S1\nF2300\nG1 X70.01 Y30\nM5 $2\n"
MUTANTS = [
    ("left out", "", "no spot"),
    ("twice", LINE * 2, "a second spot"),
    ("moved", LINE.replace("X70 ", "X70.3 ").replace("X70.01", "X70.31"), "a spot"),
    ("led", LINE.replace("G1 X70.01", "G1 X72"), "moves 2.000 mm"),
]


@pytest.mark.parametrize(("what", "other", "message"), MUTANTS, ids=[m[0] for m in MUTANTS])
def test_other_spots_are_refused(what: str, other: str, message: str) -> None:
    text = posted(DRILLED)
    machine = load("plate-qtplasmac")
    assert LINE in text
    said = verify_sheet(text.replace(LINE, other), (DRILLED,), machine)
    found = [d for d in said if d.code == "verify-sheet-spot"]
    assert found, said
    assert any(message in d.message for d in found), found


def test_a_spot_behind_a_cut_is_refused() -> None:
    text = posted(DRILLED)
    late = text.replace(LINE, "").replace(
        "M68 E3 Q0\nM65 P2\nG0 X0 Y0", f"{LINE}M68 E3 Q0\nM65 P2\nG0 X0 Y0"
    )
    assert late.count("M3 $2") == text.count("M3 $2")
    said = verify_sheet(late, (DRILLED,), load("plate-qtplasmac"))
    assert "a spot behind a cut" in " ".join(d.message for d in said)


def test_a_spot_in_the_place_of_a_cross_is_refused() -> None:
    """Each machine marks by its own: the program of the one is not right for the other."""
    spotting = load("plate-qtplasmac")
    marking = with_torch(spotting, drilled="mark")
    for one, other in ((spotting, marking), (marking, spotting)):
        assert verify_sheet(posted(DRILLED, one), (DRILLED,), other)
        assert not [
            d for d in verify_sheet(posted(DRILLED, one), (DRILLED,), one)
            if d.code != "verify-by-hand"
        ]  # fmt: skip


@settings(max_examples=examples(40), deadline=None)
@given(
    places=st.lists(st.tuples(st.floats(5, 195), st.floats(5, 95)), max_size=12),
    gap=st.sampled_from([0.01, 0.5]), tolerance=st.sampled_from([0.005, 0.01, 0.1]),
    copies=st.sampled_from([(1, 1), (2, 1)]), rotate=st.sampled_from([0.0, 30.0]),
)  # fmt: skip
def test_any_centres_are_read_back(
    places: list[tuple[float, float]], gap: float, tolerance: float, copies: tuple[int, int],
    rotate: float,
) -> None:  # fmt: skip
    part = plate(*(Hole("v", x, y, 0.0, S, kind="mark") for x, y in places))
    machine = with_torch(
        load("plate-qtplasmac"), gap=gap, tolerance=tolerance, copies=copies, rotate=rotate
    )
    text = posted(part, machine)
    assert len(spots(text)) <= len(places) * copies[0] * copies[1]
    assert bool(spots(text)) == bool(places)


def test_a_program_of_spots_gives_its_centres_back() -> None:
    part = plate(Hole("v", 60, 70, 0.0, S, kind="mark"))
    (found,) = recover(posted(part), load("plate-qtplasmac"), "a.ngc").parts
    (centre,) = [f for f in found.features if isinstance(f, Hole)]
    assert (centre.x, centre.y, centre.kind) == (pytest.approx(60), pytest.approx(70), "mark")


@pytest.mark.parametrize("name", ["plate-linuxcnc", "table-simotion"])
def test_a_table_that_has_no_spots_is_told(name: str) -> None:
    machine = load(name)
    assert machine.torch is not None
    other = replace(machine, torch=replace(machine.torch, drilled="spot"))
    assert "torch.drilled" in {key for key, _ in torch_faults(other)}
