"""Where the machine file keeps a torch from: root, seam and chuck."""

from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.errors import errors_in
from beamcam.machine import Machine, load
from beamcam.model.part import EndCuts, Part
from benchmarks.coping_faults import over_the_chuck
from tests.unit.coping import samples
from tests.unit.coping.test_box_tubes import RHS
from tests.unit.coping.test_tubes import HOLE, TUBE, program_of, tube

COPER = load("coper-linuxcnc")


def keyed(machine: Machine, **keys: object) -> Machine:
    """A machine with other keys of its coper."""
    return replace(machine, coper=replace(machine.needed(machine.coper, "coper"), **keys))


def codes(text: str, part: Part, machine: Machine) -> list[str]:
    return [said.code for said in errors_in(verify_coping(text, (part,), machine))]


def test_a_root_is_cut_by_no_machine_that_has_none_cut() -> None:
    """Both ends of both flanges go through one."""
    part = samples.sample("coped")
    text = samples.program_of(part, COPER)
    assert codes(text, part, COPER) == []
    refuses = codes(text, part, keyed(COPER, k_area="refuse"))
    assert set(refuses) == {"verify-coping-zone"}
    assert len(refuses) == 4


def test_ends_begin_at_the_seam_of_the_machine() -> None:
    for part in (tube(HOLE), tube(profile=RHS), replace(tube(HOLE), cuts=EndCuts(web_end=20.0))):
        here, there = keyed(TUBE, seam=30.0), keyed(TUBE, seam=200.0)
        text = program_of(part, there)
        assert codes(text, part, there) == []
        assert codes(text, part, here) == ["verify-coping-zone"] * 2


def test_a_hole_has_no_seam() -> None:
    part = tube(HOLE)
    assert codes(program_of(part), part, TUBE) == []


def test_the_torch_does_not_go_over_the_chuck() -> None:
    """A tube of 500 is free to X 560; the torch is 12 wide."""
    part = tube(HOLE)
    text = program_of(part)
    last = max(k for k, line in enumerate(text.split("\n")) if line.startswith("G0 X"))
    for x, wrong in ((553.9, []), (554.2, ["verify-coping-zone"])):
        lines = text.split("\n")
        lines.insert(last + 1, f"G0 X{x}")
        assert codes("\n".join(lines), part, TUBE) == wrong
    assert codes(over_the_chuck(part, TUBE, text), part, TUBE) == ["verify-coping-zone"]
