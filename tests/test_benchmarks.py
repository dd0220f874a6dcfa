"""The benchmarks as commands of a shell."""

import ast
import os
import re
import runpy
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.conftest import ROOT

BENCHMARKS = ROOT / "benchmarks"
#: Are there to be imported.
OTHERS = (
    "asked_liars", "bent_accessories", "coping_bevels", "coping_plans", "coping_roots",
    "coping_texts", "damage",
    "doors", "faults", "feed_faults", "heads", "ifc_anyhow", "ifc_families", "letterings", "liars",
    "mutants", "script", "sheet_faults", "sheet_liars", "solid_cases",
    "solid_copers", "uses",
)  # fmt: skip
SCRIPTS = sorted(path.name for path in BENCHMARKS.glob("*.py") if path.stem not in OTHERS)


def run(script: str, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, BENCHMARKS / script, *arguments],
        capture_output=True, text=True, cwd=cwd, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip


@pytest.fixture
def called(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[object, str, str]]:
    """Runs a script in this process, which has its libraries: its status, output and errors."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(BENCHMARKS))

    def call(script: str, *given: str) -> tuple[object, str, str]:
        monkeypatch.setattr(sys, "argv", [str(BENCHMARKS / script), *given])
        with pytest.raises(SystemExit) as ended:
            runpy.run_path(str(BENCHMARKS / script), run_name="__main__")
        assert list(tmp_path.iterdir()) == []
        said = capsys.readouterr()
        return ended.value.code, said.out, said.err

    return call


@pytest.mark.parametrize("script", SCRIPTS)
def test_help_is_what_the_script_says_of_itself(
    script: str, called: Callable[..., tuple[object, str, str]]
) -> None:
    status, out, errors = called(script, "--help")
    assert (status, errors) == (0, "")
    said = ast.get_docstring(ast.parse((BENCHMARKS / script).read_text(encoding="utf-8")))
    assert said is not None
    assert said in out
    assert f"python benchmarks/{script}" in said


@pytest.mark.parametrize("script", SCRIPTS)
def test_an_option_that_is_none_is_refused(
    script: str, called: Callable[..., tuple[object, str, str]]
) -> None:
    status, out, errors = called(script, "--nothing", "1", "2", "3")
    assert (status, out) == (2, "")
    assert "error: " in errors


@pytest.mark.parametrize("number", ["0", "-1", "x", "1.5"])
def test_a_number_that_is_too_small_or_none(
    number: str, called: Callable[..., tuple[object, str, str]]
) -> None:
    status, _, errors = called("dstv.py", f"--rounds={number}")
    assert status == 2
    assert f"argument --rounds: found '{number}'; expected 1 or more" in errors


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


def test_each_truth_stands_where_it_is_made_untrue(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT))
    from benchmarks.truths import edited, edits

    every = edits()
    assert len(every) >= 80
    for edit in every:
        text = (ROOT / "beamcam" / edit.path).read_text(encoding="utf-8")
        assert edited(text, edit) != text


@pytest.mark.exhaustive  # its tests run in a process of their own
def test_a_truth_that_is_untrue_is_seen(tmp_path: Path) -> None:
    done = run("truths.py", "--only", "depth of a trough", "--jobs", "1", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"model/part\.py +test_sections\.py::", done.stdout)
    assert done.stdout.endswith("\n1 of 1 seen\n")


def test_random_jobs_are_posted(called: Callable[..., tuple[object, str, str]]) -> None:
    status, out, errors = called("random_jobs.py", "--bars", "6", "--plates", "8", "--seed", "2")
    assert (status, errors) == (0, "")
    assert out.startswith("bars: 6 posted (2 beamline, 2 beamline-annex, 2 beamline-pusher)\n")
    assert "plates: 8 posted (2 plate-linuxcnc, " in out
    assert out.endswith("refused by the read-back: 0\n")
