"""The benchmarks as commands of a shell."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import ROOT

BENCHMARKS = ROOT / "benchmarks"
#: Are there to be imported.
OTHERS = (
    "damage", "faults", "heads", "ifc_anyhow", "ifc_families", "letterings", "liars", "mutants",
    "script", "sheet_liars", "uses",
)  # fmt: skip
SCRIPTS = sorted(path.name for path in BENCHMARKS.glob("*.py") if path.stem not in OTHERS)


def run(script: str, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, BENCHMARKS / script, *arguments],
        capture_output=True, text=True, cwd=cwd, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip


@pytest.mark.parametrize("script", SCRIPTS)
def test_help_is_what_the_script_says_of_itself(script: str, tmp_path: Path) -> None:
    done = run(script, "--help", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    said = ast.get_docstring(ast.parse((BENCHMARKS / script).read_text(encoding="utf-8")))
    assert said is not None
    assert said in done.stdout
    assert f"python benchmarks/{script}" in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("script", SCRIPTS)
def test_an_option_that_is_none_is_refused(script: str, tmp_path: Path) -> None:
    done = run(script, "--nothing", "1", "2", "3", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "error: " in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("number", ["0", "-1", "x", "1.5"])
def test_a_number_that_is_too_small_or_none(number: str, tmp_path: Path) -> None:
    done = run("dstv.py", f"--rounds={number}", cwd=tmp_path)
    assert done.returncode == 2
    assert f"argument --rounds: found '{number}'; expected 1 or more" in done.stderr


def test_a_model_is_written_where_it_is_asked_for(tmp_path: Path) -> None:
    done = run("make_model.py", "two.ifc", "2", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    (path,) = tmp_path.iterdir()
    assert path.name == "two.ifc"
    assert path.read_text(encoding="utf-8").startswith("ISO-10303-21;")


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_has_had_enough_ends_it_without_a_word(unbuffered: str) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "wb") as pipe:
        done = subprocess.run(
            [sys.executable, BENCHMARKS / "dstv.py", "--rounds", "1"],
            stdout=pipe, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": unbuffered},
        )  # fmt: skip
    assert (done.returncode, done.stderr) == (1, "")
