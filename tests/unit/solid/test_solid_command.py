"""`verify --solid` on the command line and from Python."""

import sys
from pathlib import Path

import pytest

import beamcam
from beamcam.errors import BeamcamError
from tests.conftest import ROOT
from tests.runs import call
from tests.unit.solid.programs import posted, sample

TIE = str(ROOT / "samples/dstv/tie.nc1")


def verify(tmp_path: Path, text: str, *more: str) -> tuple[int, str]:
    program = tmp_path / "tie.gcode"
    program.write_text(text)
    done = call("verify", program, *more)
    return done.exit_code, done.stderr


def test_a_sound_program_says_nothing(tmp_path: Path) -> None:
    assert verify(tmp_path, posted(sample("tie")), "--against", TIE, "--solid") == (0, "")


def test_what_differs_refuses_the_program(tmp_path: Path) -> None:
    wrong = posted(sample("tie")).replace("Z82.408", "Z79.000", 1)
    status, said = verify(tmp_path, wrong, "--against", TIE, "--solid")
    assert status == 1
    assert "tie.gcode: error solid-extra: found" in said
    assert "solid" not in verify(tmp_path, wrong, "--against", TIE)[1]


@pytest.mark.parametrize("more", [[], ["--against", TIE, "--from-operation", "2"]])
def test_it_needs_parts_of_a_whole_program(tmp_path: Path, more: list[str]) -> None:
    status, said = verify(tmp_path, posted(sample("tie")), *more, "--solid")
    assert status == 2
    assert "--solid needs the PARTs of a whole program, behind --against." in said


def test_without_manifold3d_one_line_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "manifold3d", None)
    status, said = verify(tmp_path, posted(sample("tie")), "--against", TIE, "--solid")
    assert status == 1
    (line,) = said.splitlines()
    assert "error solid-kernel: found no manifold3d" in line
    assert verify(tmp_path, posted(sample("tie")), "--against", TIE) == (0, "")


def test_from_python() -> None:
    parts = sample("tie")
    assert beamcam.verify(posted(parts), parts, solid=True) == ()
    wrong = posted(parts).replace("Z82.408", "Z79.000", 1)
    said = beamcam.verify(wrong, parts, solid=True)
    assert [d.code for d in said if d.code.startswith("solid-")] == ["solid-extra"]
    with pytest.raises(BeamcamError, match="a remainder has no solid of its own"):
        beamcam.verify(wrong, parts, solid=True, from_operation=2)
