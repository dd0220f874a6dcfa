"""Programs of cutting tables compared by what they say, and the commands that do so."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from beamcam.cli import main
from beamcam.diff.statements import diff_sheets
from beamcam.machine import load, shipped
from tests.conftest import GOLDEN, ROOT, SAMPLES

PLATE = GOLDEN / "plate-linuxcnc" / "gusset.ngc"


def run(*args: object) -> Result:
    return CliRunner().invoke(main, [str(a) for a in args])


def changed(tmp_path: Path, old: str, new: str) -> Path:
    text = PLATE.read_text()
    assert old in text
    path = tmp_path / "b.ngc"
    path.write_text(text.replace(old, new, 1))
    return path


def diff(b: Path) -> Result:
    return run("diff", PLATE, b, "--machine", "plate-linuxcnc")


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


def test_what_is_not_understood_is_an_error(tmp_path: Path) -> None:
    result = diff(changed(tmp_path, "G21", "G21 ?"))
    assert result.exit_code == 1
    assert "error verify-" in result.stderr


@pytest.mark.parametrize(
    ("machine", "stem", "old", "new"),
    [("table-simotion", "shield.st", "LREAL#0.005;", "LREAL#0.006;"),
     ("laser-stepper", "shield-small.csv", "7,8,", "7,9,")],
)  # fmt: skip
def test_tables_are_compared_line_by_line(machine: str, stem: str, old: str, new: str) -> None:
    text = (GOLDEN / machine / stem).read_text()
    loaded = load(machine)
    spaced = text.replace("\n", "  \n\n")
    assert diff_sheets(text, spaced, loaded) == ((), ())
    assert old in text
    found, said = diff_sheets(text, text.replace(old, new, 1), loaded)
    assert said == ()
    assert [d.how for d in found] == ["changed"]


def test_all_golden_programs_are_checked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of shipped machines, but for samples that have a configuration of their own."""
    monkeypatch.chdir(ROOT)
    configured = {path.stem for path in SAMPLES.glob("svg/*.toml")}
    for path in sorted(p for name in shipped() for p in (GOLDEN / name).glob("*.*")):
        if path.stem not in configured:
            copy = tmp_path / path.relative_to(GOLDEN)
            copy.parent.mkdir(exist_ok=True)
            copy.write_bytes(path.read_bytes())
    result = run("check", tmp_path, "--samples", SAMPLES)
    assert result.exit_code == 0, result.output
    count, _, total, *_ = result.stdout.splitlines()[-1].split()
    assert count == total
    assert int(count) > 20
