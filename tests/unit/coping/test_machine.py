"""The machine file of a coper, and what commands say of it that do not know such machines."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from msgspec.structs import replace

from beamcam.cli import main
from beamcam.controllers.machine_words import word_faults
from beamcam.errors import MachineError
from beamcam.machine import load
from beamcam.self_test import proof_faults
from tests.conftest import SAMPLES
from tests.unit.coping.samples import COPER

COPED = SAMPLES / "coping" / "coped.nc1"
ROW = """[[coper.rows]]
process = "cut"
up_to = 10
feed_mm_min = 1000
pierce_s = 1
kerf = 2
pierce_height = 5
cut_height = 3
"""

WRONG = [
    ("coper.pivot", "[coper]\ntcp = false\n"),
    ("coper.pivot", "[coper]\npivot = 100\n"),
    ("coper.tolerance", "[coper]\ntolerance = 0.0002\n"),
    ("coper.tolerance", "[coper]\ntolerance = 2\n"),
    ("coper.head_width", "[coper]\nhead_width = 10\n"),
    ("coper.trim", "[coper]\ntrim = 12\n"),
    ("coper.lead", "[coper]\nlead = 1\n"),
    ("coper.corner_radius", "[coper]\ncorner_radius = 1\n"),
    ("coper.rows", "[coper]\nrows = []\n"),
    ("coper.rows.0.process", ROW.replace('"cut"', '"mark"') + ROW),
    ("coper.rows.0.kerf", ROW.replace("kerf = 2\n", "")),
    ("coper.rows.0.cut_height", ROW.replace("cut_height = 3", "cut_height = 0.4")),
    ("coper.rows.0.pierce_height", ROW.replace("pierce_height = 5", "pierce_height = 2")),
    ("coper.rows.0.passes", ROW + "passes = 2\n"),
    ("coper.rows.1.feed_mm_min", ROW + ROW.replace("up_to = 10", "up_to = 20")),
    ("coper.profiles", '[coper]\nprofiles = ["I", "M"]\n'),
    ("words.turn", "[words]\nturn = []\n"),
    ("coper.tilt", "[coper]\ntilt = 70\n"),
    ("words.turn", "[coper]\ntilt = 30\n"),
    ("axes", '[coper]\ntilt = 30\n[words]\nturn = ["G0 A{a} B{b}"]\n'),
    ("words.turn", '[words]\nturn = ["G0 A{a} B{b}"]\n'),
    ("words.cut_on", '[words]\ncut_on = ["M3 S{speed}"]\n'),
    ("words.feed", '[words]\nfeed = ["G1 X{x} Y{y}"]\n'),
    ("words.turn", '[words]\nturn = ["G0 X{x}"]\n'),
    ("words.traverse", '[words]\ntraverse = ["G1 X{x} Y{y} Z{a}"]\n'),
    ("words.header", '[words]\nheader = ["G21 G17 G90 G91.1 G40 G94 S{section}"]\n'),
    ("words.cut_off", '[words]\ncut_off = ["M5 P{mark}"]\n'),
    ("controller", 'controller = "grbl"\n'),
    ("coper", 'stock = "sheet"\n[words]\nheader = ["%"]\ntraverse = ["G0 X{x}"]\nfeed = []\n'),
]


@pytest.mark.parametrize(("key", "text"), WRONG)
def test_keys_that_contradict_each_other(key: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(f'base = "coper-linuxcnc"\n{text}')
    assert key in _faults(path)


def _faults(path: Path) -> set[str]:
    """The keys that a machine file is refused for."""
    try:
        return {key for key, _, _ in word_faults(load(str(path)))}
    except MachineError as error:
        return {str(said["key"]) for said in error.diagnostics}


@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("axes.4.max", "[coper]\ntilt = 50\n"), ("words.turn", '[words]\nturn = ["G0 A{a}"]\n'),
        ("words.turn", '[words]\nturn = ["G0 A{a} B{a} C{b}"]\n'),
        ("words.turn", '[words]\nturn = ["G0 A{b} B{a}"]\n'),
        ("axes", '[coper]\ntilt = 0\n[words]\nturn = ["G0 A{a}"]\n'),
    ],
)  # fmt: skip
def test_keys_of_a_torch_that_tilts(key: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(f'base = "coper-tilt-linuxcnc"\n{text}')
    assert key in _faults(path)


def test_a_profile_needs_a_coper(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text('base = "plate-linuxcnc"\nstock = "profile"\n')
    with pytest.raises(MachineError, match="no key 'coper'"):
        load(str(path))


def test_a_table_has_no_words_of_a_coper(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text('base = "plate-linuxcnc"\n[words]\nfeed = ["G1 X{x} Y{y} Z{z}"]\n')
    with pytest.raises(MachineError, match=r"words\.feed"):
        load(str(path))


def test_words_that_the_read_back_would_refuse_are_a_fault_of_the_file() -> None:
    assert not proof_faults(COPER)
    wrong = replace(COPER, words=replace(COPER.words, cut_off=("M5", "G4 P99")))
    assert proof_faults(wrong)


def run(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("coped") / "coped.ngc"
    assert run("post", COPED, "--machine", "coper-linuxcnc", "-o", path).exit_code == 0
    return path


def test_its_solid_is_the_part(program: Path) -> None:
    done = run("verify", program, "--against", COPED, "--machine", "coper-linuxcnc", "--solid")
    assert done.exit_code == 0
    assert "note solid-rounded: found 610.4 mm3 left in 4 re-entrant corner(s) of C1" in done.stderr
    other = SAMPLES / "coping" / "trimmer.nc1"
    done = run("verify", program, "--against", other, "--machine", "coper-linuxcnc", "--solid")
    assert "error solid-" in done.stderr


def test_the_program_is_read_back_by_the_machine_in_its_head(program: Path) -> None:
    assert run("verify", program, "--against", COPED).exit_code == 0
    other = SAMPLES / "coping" / "trimmer.nc1"
    assert run("verify", program, "--against", other).exit_code == 1
    assert run("verify", program).exit_code == 0


def test_the_plan_is_told_cut_by_cut() -> None:
    done = run("plan", COPED, "--machine", "coper-linuxcnc")
    assert done.exit_code == 0
    assert "   9 face o  near end x     70.400 y  150.000" in done.stdout
    assert "through 24.6 mm, root at 1350 mm/min" in done.stdout
    assert done.stdout.splitlines()[-1].startswith("14 cuts, ")
    as_data = run("plan", COPED, "--machine", "coper-linuxcnc", "--json")
    assert '"kind": "near"' in as_data.stdout


def test_what_a_saw_cannot_make_is_told_who_can() -> None:
    done = run("post", COPED, "-o", "-", "--machine", "beamline")
    assert done.exit_code == 1
    assert "with --machine coper-linuxcnc or" in done.stderr


def test_a_folder_is_posted_and_checked(tmp_path: Path) -> None:
    names = [SAMPLES / "coping" / f"{name}.nc1" for name in ("coped", "trimmer", "cleat")]
    done = run("batch", *names, "--machine", "coper-linuxcnc", "-o", tmp_path / "out")
    assert "3 posted" in done.stderr + done.stdout
    assert run("check", tmp_path / "out").exit_code == 0


def test_a_tube_machine_comes_to_the_corners_of_its_tubes(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text('base = "tube-linuxcnc"\n[coper]\nmax_height = 400\n')
    assert _faults(path) == {"axes.1.max"}
    path.write_text('base = "tube-linuxcnc"\n[coper]\nclearance = 100\n')
    assert _faults(path) == {"axes.2.max"}
    path.write_text('base = "tube-linuxcnc"\n[coper]\nprofiles = ["RO"]\nclearance = 100\n')
    assert _faults(path) == set()


def test_only_round_tubes_turn_by_mm_of_their_surface(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text('base = "tube-linuxcnc"\n[coper]\na_unit = "mm"\n')
    assert _faults(path) == {"coper.a_unit"}
    path.write_text('base = "tube-linuxcnc"\n[coper]\nprofiles = ["RO"]\ncorner = 10\n')
    assert _faults(path) == {"coper.corner"}


def test_only_a_machine_for_c_sections_has_the_length_of_their_lips(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text('base = "coper-linuxcnc"\n[coper]\nlip = 20\n')
    assert _faults(path) == set()
    path.write_text('base = "coper-linuxcnc"\n[coper]\nlip = 20\nprofiles = ["I", "U"]\n')
    assert _faults(path) == {"coper.lip"}
