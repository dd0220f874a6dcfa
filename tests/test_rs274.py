"""LinuxCNC's own interpreter runs the programs of plate-linuxcnc and ends where we say."""

import re
from math import dist, isnan
from pathlib import Path

import pytest

from beamcam.checks.sheets.compensation import CompensationError, compensated
from beamcam.controllers import cell_events, table_events
from beamcam.controllers.events import Compensation, HeadMove, Move
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.machine.torch import LayerSettings
from beamcam.model.part import TextMark
from beamcam.pipeline import post, read_file
from tests.conftest import GOLDEN, SAMPLES
from tests.letters import Lines, read
from tests.linuxcnc_cell import linuxcnc_cell
from tests.rs274 import INI, interpreted, needs_rs274
from tests.unit.sheets.parts import NESTED, S, box, contour, drawing, plate, table

PROGRAMS = sorted((GOLDEN / "plate-linuxcnc").glob("*.ngc"))
_CALL = re.compile(r"(STRAIGHT_TRAVERSE|STRAIGHT_FEED|ARC_FEED)\(([^)]*)\)")

pytestmark = needs_rs274


def moves_of(path: Path) -> list[tuple[str, list[float]]]:
    """The canonical moves that the interpreter prints. Fails if it stops with an error."""
    return [
        (name, [float(v) for v in values.split(",")])
        for name, values in _CALL.findall(canonical(path))
    ]


def canonical(path: Path) -> str:
    """What the interpreter prints. Fails if it stops with an error."""
    run = interpreted(path, ini=INI)
    assert run.returncode == 0, run.stderr
    return run.stdout


def ends_as_we_say(path: Path) -> int:
    """Compares each move's end, and each arc's centre and direction; how many there were."""
    events, said = table_events(path.read_text(), load("plate-linuxcnc"))
    assert not said
    legs = [e for e in events if isinstance(e, Move)]
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
    _, said = table_events(broken, load("plate-linuxcnc"))
    assert [d.code for d in said] == ["verify-sheet-arc"]
    with pytest.raises(AssertionError, match="Radius to end of arc differs"):
        moves_of(path)


def test_compensation_by_the_machine(tmp_path: Path) -> None:
    """G41.1 and G42.1: the beam goes where the read-back says, corner by corner."""
    machine = table(kerf_by="machine", lead="line")
    path = tmp_path / "beside.ngc"
    path.write_text(post((NESTED,), machine).text)
    assert "G41.1 D1.5" in path.read_text()
    beam = beam_of(path.read_text())
    theirs = [values for name, values in moves_of(path) if name != "STRAIGHT_TRAVERSE"]
    assert len(beam) == len(theirs) > 20
    for leg, values in zip(beam, theirs, strict=True):
        assert values[:2] == pytest.approx(leg.end, abs=2e-4)


def beam_of(text: str) -> list[HeadMove]:
    """The feeds of a program as the read-back has them, those beside a contour compensated."""
    events, said = table_events(text, load("plate-linuxcnc"))
    assert not said
    found: list[HeadMove] = []
    side, radius, waiting = "on", 0.0, list[HeadMove]()
    for event in events:
        if isinstance(event, Compensation):
            found += compensated(waiting, side, radius) if side != "on" else waiting  # type: ignore[arg-type]
            side, radius, waiting = event.side, event.radius, []
        elif isinstance(event, Move) and not event.rapid:
            waiting.append(event)
    return found + waiting


NOT_COMPENSATED = {
    "an arc no larger than the tool": "G1 X20 Y20\nG3 X20.5 Y20.5 I0 J0.5\nG1 X20.5 Y40\n",
    "an entry that is too short": "G1 X10.5 Y10\nG1 X10.5 Y30\n",
    "a notch narrower than the tool": "G1 X20 Y10\nG1 X20 Y30\nG1 X19.5 Y30\nG1 X19.5 Y10\n",
}


@pytest.mark.parametrize("moves", NOT_COMPENSATED.values(), ids=NOT_COMPENSATED.keys())
def test_what_it_cannot_keep_beside_it_refuses_as_we_do(tmp_path: Path, moves: str) -> None:
    path = tmp_path / "beside.ngc"
    path.write_text(
        f"G21 G17 G90 G91.1 G40 G94\nF900\nG0 X10 Y10\nG41.1 D1.5\n{moves}G40\nG0 X0 Y0\nM2\n"
    )
    with pytest.raises(AssertionError):
        moves_of(path)
    with pytest.raises(CompensationError):
        beam_of(path.read_text())


def test_bridges(tmp_path: Path) -> None:
    path = tmp_path / "bridges.ngc"
    path.write_text(post((NESTED,), table(tabs=3)).text)
    assert ends_as_we_say(path) > 30


def test_overcuts_passes_and_hatches_are_as_long_as_they_are_asked(tmp_path: Path) -> None:
    """A square of 40 mm twice, each time 1.5 mm beyond its start, and lines 2 mm apart in one."""
    own = {"red": LayerSettings(passes=2, overcut=1.5),
           "blue": LayerSettings(hatch=2.0, hatch_outline=False)}  # fmt: skip
    machine = with_torch(
        load("plate-linuxcnc"), {"red": "cut", "blue": "mark"}, settings=own, kerf=0.0, lead="none"
    )  # fmt: skip
    part = drawing(contour(box(0, 0, 40, 40)), contour(box(10, 10, 11, 11), "#0000ff"))
    path = tmp_path / "asked.ngc"
    path.write_text(post((part,), machine).text)
    assert ends_as_we_say(path) > 10
    lengths = {"cut": 0.0, "mark": 0.0}
    here, tool = [0.0, 0.0], ""
    for line in canonical(path).splitlines():
        if started := re.search(r"START_SPINDLE_CLOCKWISE\((\d)", line):
            tool = "cut" if started[1] == "0" else "mark"
        if moved := re.search(r"STRAIGHT_(?:FEED|TRAVERSE)\((-?[\d.]+), (-?[\d.]+)", line):
            end = [float(moved[1]), float(moved[2])]
            if "FEED" in line:
                lengths[tool] += dist(here, end)
            here = end
    assert lengths["cut"] == pytest.approx(2 * (160 + 1.5), abs=0.01)
    assert lengths["mark"] == pytest.approx(5 * (11 - 2), abs=0.01)


@pytest.mark.parametrize("name", ["beam", "channel", "strut", "tie"])
def test_a_cell(name: str, tmp_path: Path) -> None:
    """Strokes in X, Y and Z; the machine's own words are left out, as they move nothing."""
    cell = linuxcnc_cell()
    text = post(read_file(SAMPLES / "dstv" / f"{name}.nc1").parts, cell, bar=12000.0).text
    events, said = cell_events(text, cell)
    assert not said
    path = tmp_path / "cell.ngc"
    path.write_text(re.sub(r"(?m)^(N\d+) M1\d\d .*", r"\1", text))
    ours = [e for e in events if isinstance(e, Move)]
    theirs = [(kind, values[:3]) for kind, values in moves_of(path) if kind != "SET_FEED_RATE"]
    assert len(theirs) == len(ours) > 10
    for (kind, values), move in zip(theirs, ours, strict=True):
        assert kind == ("STRAIGHT_TRAVERSE" if move.rapid else "STRAIGHT_FEED")
        named = [0.0 if isnan(at) else at for at in move.end]  # they begin at 0, ours anywhere
        assert values == pytest.approx(named, abs=1e-4), move


_TRACED = re.compile(
    r"(START_SPINDLE\w+|STOP_SPINDLE\w+|STRAIGHT_TRAVERSE|STRAIGHT_FEED)\(([^)]*)\)"
)


def traced(path: Path) -> Lines:
    """The lines along which the interpreter moves with the second spindle on."""
    found: Lines = []
    place, marks = (0.0, 0.0), False
    for name, values in _TRACED.findall(canonical(path)):
        numbers = [float(v) for v in values.split(",")]
        if name.startswith("START"):
            marks = numbers[0] == 1.0
        elif name.startswith("STOP"):
            marks = marks and numbers[0] != 1.0
        else:
            end = numbers[0], numbers[1]
            if marks and name == "STRAIGHT_FEED":
                found.append((place, end))
            place = end
    return found


def test_the_interpreter_traces_the_text() -> None:
    """Both texts of the sample, the first at the place that it was moved to."""
    lines = traced(GOLDEN / "plate-linuxcnc" / "lettered.ngc")
    low = [line for line in lines if line[0][1] < 80 + 10]
    high = [line for line in lines if line[0][1] > 80 + 10]
    assert read(low, 10.0) == "L-7/b"
    assert read(high, 12.0) == "Part_7"


@pytest.mark.parametrize("angle", [0.0, 90.0, 205.0])
def test_the_interpreter_traces_a_text_along_its_angle(angle: float, tmp_path: Path) -> None:
    path = tmp_path / "text.ngc"
    part = plate(TextMark("v", 100.0, 50.0, angle, 8.0, "X17", S))
    path.write_text(post([part], load("plate-linuxcnc")).text)
    assert read(traced(path), 8.0, angle) == "X17"
