"""LinuxCNC's own interpreter runs the programs of plate-linuxcnc and ends where we say."""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

from beamcam.machine import load
from beamcam.pipeline import post
from beamcam.verify.sheets import events_of
from beamcam.verify.sheets.events import Leg
from tests.conftest import GOLDEN
from tests.unit.sheets.parts import NESTED, table

RS274 = shutil.which("rs274")
PROGRAMS = sorted((GOLDEN / "plate-linuxcnc").glob("*.ngc"))
_CALL = re.compile(r"(STRAIGHT_TRAVERSE|STRAIGHT_FEED|ARC_FEED)\(([^)]*)\)")

pytestmark = pytest.mark.skipif(
    RS274 is None, reason="rs274 of LinuxCNC is not installed (Debian: linuxcnc-uspace)"
)


def moves_of(path: Path) -> list[tuple[str, list[float]]]:
    """The canonical moves that the interpreter prints. Fails if it stops with an error."""
    assert RS274 is not None
    with tempfile.TemporaryDirectory() as own:  # two of them at once write one file of parameters
        run = subprocess.run(
            [RS274, "-g", str(path.resolve())], capture_output=True, text=True, timeout=60, cwd=own
        )
    assert run.returncode == 0, run.stderr
    return [
        (name, [float(v) for v in values.split(",")]) for name, values in _CALL.findall(run.stdout)
    ]


def ends_as_we_say(path: Path) -> int:
    """Compares each move's end, and each arc's centre and direction; how many there were."""
    events, said = events_of(path.read_text(), load("plate-linuxcnc"))
    assert not said
    legs = [e for e in events if isinstance(e, Leg)]
    moves = moves_of(path)
    assert len(moves) == len(legs)
    for (name, values), leg in zip(moves, legs, strict=True):
        assert values[:2] == pytest.approx(leg.end, abs=1e-4), leg
        if leg.curve is None:
            assert name == ("STRAIGHT_TRAVERSE" if leg.rapid else "STRAIGHT_FEED")
        else:
            assert name == "ARC_FEED"
            assert values[2:4] == pytest.approx(leg.curve.centre, abs=2e-4)  # type: ignore[union-attr]
            assert (values[4] > 0) == (leg.curve.sweep_deg > 0)  # type: ignore[union-attr]
    return len(legs)


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: p.name)
def test_golden(path: Path) -> None:
    assert ends_as_we_say(path) > 5


def test_there_are_golden_programs() -> None:
    assert len(PROGRAMS) >= 5


def test_the_interpreter_refuses_what_we_refuse(tmp_path: Path) -> None:
    """An arc that does not fit stops it as it stops us."""
    text = PROGRAMS[0].read_text()
    broken = re.sub(r"I(\S+) J", lambda m: f"I{float(m[1]) + 3:.4f} J", text, count=1)
    path = tmp_path / "broken.ngc"
    path.write_text(broken)
    _, said = events_of(broken, load("plate-linuxcnc"))
    assert [d.code for d in said] == ["verify-sheet-arc"]
    with pytest.raises(AssertionError, match="Radius to end of arc differs"):
        moves_of(path)


def test_compensation_by_the_machine(tmp_path: Path) -> None:
    """G41.1 and G42.1: the interpreter accepts the leads along which it takes the radius up."""
    path = tmp_path / "beside.ngc"
    path.write_text(post((NESTED,), table(kerf_by="machine", lead="line")).text)
    assert "G41.1 D1.5" in path.read_text()
    assert moves_of(path)


def test_bridges(tmp_path: Path) -> None:
    path = tmp_path / "bridges.ngc"
    path.write_text(post((NESTED,), table(tabs=3)).text)
    assert ends_as_we_say(path) > 30
