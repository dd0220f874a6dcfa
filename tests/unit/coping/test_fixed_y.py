"""A torch without Y, which stays over the axis of a round tube."""

from pathlib import Path

import pytest

from beamcam.arguments import load_tested
from beamcam.errors import MachineError
from beamcam.machine import Machine, load
from beamcam.pictures import ReadProgram
from beamcam.pipeline import post
from beamcam.recovery import recover
from beamcam.setup_sheet.content import SheetSources, content_of
from beamcam.simulation.program import simulate_program
from tests.conftest import sampled
from tests.unit.coping.samples import sample
from tests.unit.coping.test_tubes import TUBE, found, program_of

OWN = """
base = "tube-linuxcnc"

[coper]
y = "fixed"
profiles = ["RO"]

[words]
traverse = ["G0 X{x} Z{z}"]
feed = ["G1 X{x} Z{z} A{a} F{inverse}"]
"""
AXES = "".join(
    f'\n[[axes]]\nname = "{a.name}"\nmoves = "{a.moves}"\nspeed = {a.speed}\nacceleration = 500\n'
    + ("" if a.max is None else f"min = {a.min}\nmax = {a.max}\n")
    for a in TUBE.axes if a.moves != "Y"
)  # fmt: skip


@pytest.fixture
def fixed(tmp_path: Path) -> Machine:
    path = tmp_path / "fixed.toml"
    path.write_text(OWN + AXES)
    return load_tested(str(path))


@pytest.mark.parametrize("name", sampled(["brace", "stub"], 2))
def test_a_program_is_that_of_the_other_torch_without_its_y(fixed: Machine, name: str) -> None:
    part = sample(name)
    text = program_of(part, fixed)
    with_y = program_of(part).replace(" Y0", "")
    assert text.splitlines()[6:] == with_y.splitlines()[6:]
    assert " Y" not in text.partition("LENGTH")[2]
    assert not found(text, part, fixed)
    (again,) = recover(text, fixed, "JOB").parts
    assert not found(text, again, fixed)


def test_a_torch_beside_the_axis_is_refused(fixed: Machine) -> None:
    part = sample("brace")
    lines = program_of(part, fixed).splitlines()
    k = next(k for k, line in enumerate(lines) if line.startswith("G1"))
    lines[k] = lines[k].replace(" Z", " Y3 Z")
    assert {d.code for d in found("\n".join(lines), part, fixed)} == {"verify-coping-square"}


def test_it_is_simulated_and_shown(fixed: Machine) -> None:
    part = sample("brace")
    made = post((part,), fixed)
    trace = simulate_program(made.text, fixed, "brace.ngc", (part,)).trace
    assert [axis.name for axis in trace.axes] == ["carriage", "height", "chuck"]
    program = ReadProgram(made.text.encode(), fixed, "brace.ngc", parts=(part,))
    here = content_of(SheetSources(program, made.plan, made.remarks)).trace.positions
    with_y = post((part,), TUBE)
    program = ReadProgram(with_y.text.encode(), TUBE, "brace.ngc", parts=(part,))
    there = content_of(SheetSources(program, with_y.plan, with_y.remarks)).trace.positions
    assert here.shape[1] == 4  # along, round the bar, height, chuck
    assert here[-1].tolist() == pytest.approx(there[-1][[0, 1, 3, 4]].tolist())


WRONG = [
    (OWN.replace('["RO"]', '["RO", "M"]') + AXES, "RO alone"),
    (OWN.replace("G0 X{x} Z{z}", "G0 X{x} Y{y} Z{z}") + AXES, "no {y}"),
    (OWN, "no such axis where coper.y is fixed"),
    (OWN.replace("G0 X{x} Z{z}", "G0 X{x}") + AXES, "a move to {x} and {z}"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "said"), WRONG)
def test_its_file_has_no_y(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    with pytest.raises(MachineError) as error:
        load_tested(str(path))
    assert said in " ".join(d.message for d in error.value.diagnostics)


def test_the_shipped_machines_have_one() -> None:
    assert {load(name).coper.y for name in ("tube-linuxcnc", "tube-surface")} == {"follows"}  # type: ignore[union-attr]
