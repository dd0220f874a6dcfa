"""The trace of a coper: as long as `post` says, at the places that its blocks name."""

import csv
import io
import re

import pytest
from msgspec.structs import replace

from beamcam.errors import MachineError
from beamcam.machine import load
from beamcam.pipeline import Posted, post, read_file
from beamcam.simulation.limits import run_warnings
from beamcam.simulation.program import simulate_program
from tests.conftest import SAMPLES
from tests.runs import call

COPING = SAMPLES / "coping"
MACHINES = {
    "coped": "coper-linuxcnc", "trimmer": "coper-linuxcnc", "cleat": "coper-linuxcnc",
    "stub": "tube-linuxcnc", "brace": "tube-linuxcnc", "leg": "tube-linuxcnc",
    "hip": "tube-linuxcnc",
}  # fmt: skip


TURNED = [("coped", "tube-linuxcnc"), ("trimmer", "tube-linuxcnc")]


def posted(name: str, machine: str = "") -> Posted:
    path = next(p for p in COPING.iterdir() if p.stem == name)
    return post(read_file(str(path)).parts, load(machine or MACHINES[name]))


@pytest.mark.parametrize(("name", "machine_name"), [*MACHINES.items(), *TURNED])
def test_it_takes_as_long_as_post_says_and_goes_where_its_blocks_say(
    name: str, machine_name: str
) -> None:
    program = posted(name, machine_name)
    machine = program.job.machine
    done = simulate_program(program.text, machine, f"{name}.ngc")
    trace = done.trace
    assert trace.duration_s == pytest.approx(program.time(machine).total_s, abs=0.01)
    assert run_warnings(trace, machine, done.section, name) == ()
    # By hand: the words of each block, as they stand, are where the axes are behind it.
    here: dict[str, float] = {}
    lines = program.text.split("\n")
    wanted = {}
    for number, line in enumerate(lines, 1):
        if not line.startswith("("):
            here |= {axis: float(v) for axis, v in re.findall(r"\b([XYZA])(-?[\d.]+)", line)}
        wanted[number] = dict(here)
    for k, line_number in enumerate(trace.line.tolist(), 1):
        found = dict(zip("XYZA", trace.positions[k].tolist(), strict=True))
        for axis, value in wanted[line_number].items():
            assert found[axis] == pytest.approx(value, abs=1e-6), (line_number, axis)
    # The torch burns from its word on to that which ends it, and nowhere else.
    for k, line_number in enumerate(trace.line.tolist()):
        before = [w for line in lines[:line_number] for w in re.findall(r"\bM([35])\b", line)]
        assert trace.states[int(trace.state[k])].process == ("cut" if before[-1:] == ["3"] else "")


def test_limits_are_those_of_the_file_and_axes_are_needed() -> None:
    program, machine = posted("trimmer"), load("coper-linuxcnc")
    near = replace(
        machine, axes=tuple(replace(a, max=100.0) if a.moves == "X" else a for a in machine.axes)
    )
    done = simulate_program(program.text, near)
    said = run_warnings(done.trace, near, done.section, "t")
    assert {one.code for one in said} == {"simulate-limit"}
    with pytest.raises(MachineError):
        simulate_program(program.text, replace(machine, axes=()))


def test_the_command_writes_the_axes_by_their_names() -> None:
    words = ["simulate", str(COPING / "trimmer.nc1"), "--machine", "coper-linuxcnc", "-o", "-"]
    done = call(*words, status=0)
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    assert [*rows[0]] == ["time_s", "carriage", "across", "height", "head", "process", "line"]
    assert {row["process"] for row in rows} == {"", "cut"}
