"""The bodies of each shipped cell: where they stand, and that a program that drives them together
is warned of."""

import re
from math import radians, tan
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.machine import load
from beamcam.machine.load import shipped
from beamcam.machine.machine import MachineBox
from beamcam.machine.stations import Formula
from beamcam.pipeline import post, read_file
from beamcam.simulation.cell_trace import cell_axes
from beamcam.simulation.limits import strikes
from beamcam.simulation.trace import State, TraceBuilder
from tests.conftest import examples
from tests.runs import call

DSTV = Path(__file__).resolve().parents[3] / "samples" / "dstv"
CELLS = tuple(name for name in shipped() if load(name).stock == "beam")
SECTION = {"height": 200.0, "width": 75.0}


@pytest.mark.parametrize("name", CELLS)
def test_each_cell_has_its_saw_its_spindles_and_its_clamps(name: str) -> None:
    machine = load(name)
    wanted = {"saw blade", "left spindle", "top spindle", "right spindle", "left clamp",
              "right clamp"}  # fmt: skip
    names = {body.name for body in machine.bodies}
    assert wanted <= names
    assert ("stop" in names) is (machine.axes[0].name == "stop")


@settings(max_examples=examples(20))
@given(st.sampled_from(CELLS), st.floats(0.0, 1.0), st.floats(0.0, 200.0))
@example("beamline", 1.0, 0.0)
@example("beamline-pusher", 0.0, 200.0)
def test_the_blade_stands_where_the_cut_goes_through(name: str, share: float, y: float) -> None:
    machine = load(name)
    saw = machine.saw
    assert saw is not None
    turn = next(k for k, axis in enumerate(machine.axes) if axis.moves == "angle")
    down = next(k for k, axis in enumerate(machine.axes) if axis.moves == "saw")
    axis = machine.axes[turn]
    assert axis.min is not None
    assert axis.max is not None
    angle = axis.min + share * (axis.max - axis.min)
    rise = y - SECTION["height"] if saw.pivot == "o" else y
    x = saw.x + rise * tan(radians(saw.angle_sign * (angle - saw.zero_angle)))
    across = SECTION["height"] / 2 - y
    at = [axis.park for axis in machine.axes]
    at[turn], at[down] = angle, 50.0
    builder = TraceBuilder(cell_axes(machine), at)
    builder.wait(1.0, 1, State())
    blade = next(body for body in machine.bodies if body.name == "saw blade")

    def is_struck(place: float) -> bool:
        low, high = ((place - 0.1, across - 0.1, 0.0), (place + 0.1, across + 0.1, 10.0))
        probe = MachineBox("probe", *(tuple(Formula(f"{v:.6f}") for v in c) for c in (low, high)))  # type: ignore[arg-type]
        return bool(strikes(builder.trace(), replace(machine, bodies=(blade, probe)), SECTION))

    assert is_struck(x)
    assert not is_struck(x - 30.0)
    assert not is_struck(x + 30.0)


@pytest.mark.parametrize("name", CELLS)
def test_spindles_that_are_driven_together_are_warned_of(name: str, tmp_path: Path) -> None:
    machine = load(name)
    path = tmp_path / "job.gcode"
    text = b"".join(post(read_file(str(DSTV / "channel.nc1")).parts, machine).pieces()).decode()
    words = ["simulate", str(path), "--machine", name, "-o", str(tmp_path / "trace.json")]
    path.write_text(text)
    said = set(re.findall("simulate-[a-z]+", call(*words).output))
    assert said == ({"simulate-tips"} if name == "beamline-annex" else set())
    # The strokes of both flange drills are the moves along Y at the height of the flange's holes.
    stroke = re.compile(r"(G01 X[\d.]+ Y)[1-9][\d.]*( Z143\.6)")
    path.write_text(stroke.sub(r"\g<1>450\2", text))
    line = text[: next(stroke.finditer(text)).start()].count("\n") + 1
    done = call(*words, status=0)
    said = next(row for row in done.stderr.splitlines() if "simulate-collision" in row)
    found = re.search(r":(\d+): warning .* at ([\d.]+) s .* left spindle and right spindle", said)
    assert found is not None, said
    assert int(found[1]) in (line - 1, line)
    assert float(found[2]) > 0.0
