"""Programs of cutting tables compared by what they say, and the commands that do so."""

import re
from pathlib import Path

import pytest
from click.testing import Result

from beamcam.comparison.pairing import Difference
from beamcam.comparison.statements import ProgramText, diff_texts
from beamcam.errors import Diagnostic
from beamcam.machine import load, shipped
from tests.conftest import GOLDEN, ROOT, SAMPLES
from tests.runs import call

PLATE = GOLDEN / "plate-linuxcnc" / "gusset.ngc"


def changed(tmp_path: Path, old: str, new: str) -> Path:
    text = PLATE.read_text()
    assert old in text
    path = tmp_path / "b.ngc"
    path.write_text(text.replace(old, new, 1))
    return path


def diff(b: Path) -> Result:
    return call("diff", PLATE, b, "--machine", "plate-linuxcnc")


def test_spacing_comments_and_numbers_count_for_nothing(tmp_path: Path) -> None:
    lines = PLATE.read_text().splitlines()
    b = tmp_path / "b.ngc"
    numbered = [f"N{10 * i}  {line}" if line[:1] in "GM" else line for i, line in enumerate(lines)]
    b.write_text("\n".join([numbered[0], "(another comment)", *numbered[1:]]) + "\n")
    result = diff(b)
    assert (result.exit_code, result.stdout) == (0, ""), result.stdout


def test_a_move_that_changed_is_told(tmp_path: Path) -> None:
    first = next(line for line in PLATE.read_text().splitlines() if line.startswith("G0 X"))
    result = diff(changed(tmp_path, first, first + "1"))
    assert result.exit_code == 1
    assert "rapid to X " in result.stdout
    assert " became " in result.stdout


def test_a_program_that_was_moved_with_its_arcs_says_so_once(tmp_path: Path) -> None:
    def moved(word: re.Match[str]) -> str:
        return f"Y{float(word[1]) + 1.5:.4f}"

    b = tmp_path / "b.ngc"
    b.write_text(re.sub(r"\bY([-0-9.]+)", moved, PLATE.read_text()))
    result = diff(b)
    assert (result.exit_code, result.stderr) == (1, "")
    assert "statements: Y +1.5" in result.stdout


def test_a_switch_that_is_missing_is_told(tmp_path: Path) -> None:
    result = diff(changed(tmp_path, "\nM5\n", "\n"))
    assert result.exit_code == 1
    assert "M5, only in A" in result.stdout


def test_what_is_not_understood_is_an_error_of_its_own_file(tmp_path: Path) -> None:
    wrong = changed(tmp_path, "G21", "G21 ?")
    for pair in ((PLATE, wrong), (wrong, PLATE)):
        result = call("diff", *pair, "--machine", "plate-linuxcnc", status=1)
        assert "error verify-" in result.stderr
        assert all(line.startswith(f"{wrong}:") for line in result.stderr.splitlines())


def test_a_fault_of_the_second_is_not_told_of_the_first(tmp_path: Path) -> None:
    """A program without its end is understood, and wrong."""
    b = changed(tmp_path, "\nM2\n", "\n")
    result = diff(b)
    assert f"{b}:" in result.stderr
    assert f"{PLATE}:" not in result.stderr


def test_each_program_is_read_by_the_machine_of_its_own_head(tmp_path: Path) -> None:
    """The same plate for two tables whose G-code differs, either way round."""
    gusset = SAMPLES / "dstv" / "gusset.nc1"
    made = []
    for name, suffix in (("plate-linuxcnc", "ngc"), ("plate-codesys", "gcode")):
        path = tmp_path / f"{name}.{suffix}"
        assert call("post", gusset, "--machine", name, "-o", path).exit_code == 0
        made.append(path)
    for pair in (made, made[::-1]):
        result = call("diff", *pair, status=1)
        assert "error" not in result.stderr, result.stderr
        assert result.stdout
    bar = tmp_path / "bar.gcode"
    assert call("post", SAMPLES / "dstv" / "channel.nc1", "-o", bar).exit_code == 0
    mixed = call("diff", bar, made[0], status=1)
    assert f"{made[0]}: error ask-type: found a program for plate-linuxcnc, a sheet" in mixed.stderr


@pytest.mark.parametrize(
    ("machine", "stem", "old", "new"),
    [("table-simotion", "shield.st", "LREAL#0.005;", "LREAL#0.006;"),
     ("laser-stepper", "shield-small.csv", "7,8,", "7,9,")],
)  # fmt: skip
def test_tables_are_compared_line_by_line(machine: str, stem: str, old: str, new: str) -> None:
    text = (GOLDEN / machine / stem).read_text()
    loaded = load(machine)
    spaced = text.replace("\n", "  \n\n")

    def diff_to(other: str) -> tuple[tuple[Difference, ...], tuple[Diagnostic, ...]]:
        return diff_texts(ProgramText("A", text, loaded), ProgramText("B", other, loaded))

    assert diff_to(spaced) == ((), ())
    assert old in text
    found, said = diff_to(text.replace(old, new, 1))
    assert said == ()
    assert [d.how for d in found] == ["changed"]


@pytest.mark.parametrize("every", [11, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_golden_programs_are_checked(
    every: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those of shipped machines, but for samples that have a configuration of their own."""
    monkeypatch.chdir(ROOT)
    configured = {path.stem for path in SAMPLES.glob("*/*.toml")}
    # Lists of manual work stand beside the programs of these.
    configured |= {"bevelled", "stub", "leg", "hip", "header-rest", "girder", "rafter", "valley"}
    configured |= {"stringer"}
    programs = sorted(p for name in shipped() for p in (GOLDEN / name).glob("*.*"))
    for path in programs[::every]:
        if path.stem not in configured:
            copy = tmp_path / path.relative_to(GOLDEN)
            copy.parent.mkdir(exist_ok=True)
            copy.write_bytes(path.read_bytes())
    result = call("check", tmp_path, "--samples", SAMPLES, status=0)
    count, _, total, *_ = result.stdout.splitlines()[-1].split()
    assert count == total
    assert int(count) > 20 / every


#: A shipped table, a block of its golden program, another in its place, and the difference.
OF_TABLES = [
    ("plate-mach3", "gusset.tap", "G1 Z1.5 F1500", "G1 Z1.4 F1500",
     "feed to 1.5 mm over the sheet at 1500 mm/min became feed to 1.4 mm"),
    ("plate-mach3", "gusset.tap", "M120\n", "", "thc on, only in A"),
    ("plate-mach3", "gusset.tap", "G31 Z-150 F600", "G31 Z-150 F700",
     "touch the sheet at 600 mm/min became touch the sheet at 700 mm/min"),
    ("plate-mach3", "gusset.tap", "G92.1\n", "", "Z counts from its own place, only in A"),
    ("plate-qtplasmac", "gusset.ngc", "ph=3.8", "ph=3.9", "pierce_height 3.8"),
    ("plate-qtplasmac", "gusset.ngc", "Q60", "Q70", "feed at 60 % became feed at 70 %"),
    ("plate-qtplasmac", "gusset.ngc", "M62 P2", "M64 P2", "thc off with the next move became"),
    ("plate-qtplasmac", "gusset.ngc", "T1 M6", "T2 M6", "places of tool 1 became"),
    ("plate-oxyfuel", "gusset.ngc", "M64 P0\n", "", "preheat on, only in A"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "file", "old", "new", "told"), OF_TABLES)
def test_what_a_torch_does_otherwise_is_told(
    name: str, file: str, old: str, new: str, told: str, tmp_path: Path
) -> None:
    text = (GOLDEN / name / file).read_text()
    assert old in text
    (tmp_path / file).write_text(text.replace(old, new, 1))
    result = call("diff", GOLDEN / name / file, tmp_path / file, "--machine", name, status=1)
    assert told in result.stdout, result.stdout


@pytest.mark.parametrize(
    ("name", "old", "new", "said"),
    [
        ("coper-linuxcnc/coped", "G1 X450 ", "G1 X451 ", "became line to X 451.0000"),
        ("coper-linuxcnc/coped", "M5\n", "", "M5, only in A"),
        ("coper-linuxcnc/coped", "A-90", "A-89", "A -90.000 to -89.000"),
    ],
)  # fmt: skip
def test_what_goes_round_a_profile_is_compared(
    tmp_path: Path, name: str, old: str, new: str, said: str
) -> None:
    path = GOLDEN / f"{name}.ngc"
    text = path.read_text()
    assert old in text
    other = tmp_path / "b.ngc"
    other.write_text(re.sub(r"(?m)^\(.*\)\n", "", text))
    assert call("diff", path, other, "--machine", "coper-linuxcnc").exit_code == 0
    other.write_text(text.replace(old, new, 1))
    done = call("diff", path, other, status=1)
    assert said in done.stdout
