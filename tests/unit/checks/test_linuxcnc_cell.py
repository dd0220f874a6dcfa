"""A cell that another family of controllers runs: the same events, so the same read-back."""

import re
from pathlib import Path

import pytest
from msgspec.structs import astuple

from beamcam.checks.bars import verify
from beamcam.errors import Severity, VerifyError
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.pipeline import RefusedProgram, post, read_file
from tests.conftest import SAMPLES
from tests.linuxcnc_cell import HEADER, linuxcnc_cell
from tests.unit.checks.programs import interpret

CELL = linuxcnc_cell()


def program(path: Path, machine: Machine) -> str:
    text = post(read_file(path).parts, machine, bar=12000.0).text
    assert isinstance(text, str)
    return text


def features(text: str, machine: Machine) -> list[list[object]]:
    """What a program makes, without the lines that make it; feeds are rounded in mm/s or mm/min."""
    return [
        [pytest.approx(v, abs=0.05) if isinstance(v, float) else v for v in astuple(one)[1:]]
        for one in interpret(text, machine).order
    ]


@pytest.mark.parametrize("name", ["beam", "channel", "strut", "tie"])
def test_both_families_make_the_same(name: str) -> None:
    path = SAMPLES / "dstv" / f"{name}.nc1"
    made = features(program(path, CELL), CELL)
    ours = interpret(program(path, load("beamline")), load("beamline"))
    assert [list(astuple(one)[1:]) for one in ours.order] == made
    assert len(made) > 1


TEXT = program(SAMPLES / "dstv" / "beam.nc1", CELL)
WRONG = [
    ("N4 G0 X", "N4 G0 X1", "verify-cut-missing"),
    ("Q22\n", "Q20\n", "verify-tool"),
    ("M140 P2", "M140 P7", "verify-word"),
    ("M140 P2 Q22", "M140 P2", "verify-word"),
    ("M140 P2 Q22", "M141 P2 Q22", "verify-word"),
    ("M140 P2 Q22", "M140 P2 Q22 R1", "verify-word"),
    ("M3 S362", "M3", "verify-word"),
    ("M2\n", "", "verify-end"),
    ("M2\n", "M2\nG0 X9\n", "verify-end"),
    ("N9 M3", "N9 M3.5", "verify-word"),
    ("N9 M3", "N9 M", "verify-syntax"),
    ("N7 G0 X", "N7 G2 I5 X", "verify-arc"),
    (" F90.429", "", "verify-no-feed"),
    ("N9 M3", "N9 G41.1 D2 M3", "verify-word"),
]


@pytest.mark.parametrize(("old", "new", "code"), WRONG)
def test_what_is_wrong_is_said(old: str, new: str, code: str) -> None:
    assert old in TEXT
    said = verify(TEXT.replace(old, new, 1), read_file(SAMPLES / "dstv" / "beam.nc1").parts, CELL)
    assert code in {d.code for d in said}, said


def test_units_and_plane_have_to_be_set() -> None:
    machine = linuxcnc_cell(("G21 G90 G40 G94", *HEADER[1:]))
    with pytest.raises(RefusedProgram) as refused:
        program(SAMPLES / "dstv" / "beam.nc1", machine)
    assert [str(d) for d in refused.value.diagnostics] == [
        "JOB:9: error verify-setting: found a move before G17, G91.1; "
        "expected it to be set at the beginning"
    ]


def test_words_that_the_family_does_not_have() -> None:
    """M40 with K and L is a word of CODESYS; LinuxCNC has none below M100 to give away."""
    text = re.sub(r"M140 P(\S+) Q", r"M40 K\1 L", TEXT)
    with pytest.raises(VerifyError, match="found M40, which beamcam does not know; expected"):
        interpret(text, CELL)


def test_steps_back_are_counted_from_the_last_place() -> None:
    """G91 on an axis that no block has named yet says nothing."""
    head = "G21 G17 G40 G94 G91.1 G91\nM144 P150 Q300\nM143 P1\nM140 P2 Q22\n"
    with pytest.raises(VerifyError, match="a relative move from nowhere"):
        interpret(head + "G0 X5\nM2\n", CELL)


@pytest.mark.parametrize(
    ("word", "refused"),
    [("G64", True), ("G64 P5", True), ("G64 P0.02", False), ("G61", False), ("G61.1", False)],
)
def test_corners_may_be_passed_within_the_tolerance_of_paths(word: str, refused: bool) -> None:
    """A stroke that is rounded off is one that does not come to its place."""
    parts = read_file(SAMPLES / "dstv" / "beam.nc1").parts
    text = TEXT.replace("G94", f"G94 {word}", 1)
    assert word in text
    said = verify(text, parts, CELL, bar=12000.0)
    found = [str(d).partition("error ")[2] for d in said if d.severity is Severity.ERROR]
    expected = [
        f"verify-word: found corners passed {'5' if 'P5' in word else 'inf'} mm off; expected at "
        "most 0.02 mm, or none"
    ]
    assert found == (expected if refused else [])
