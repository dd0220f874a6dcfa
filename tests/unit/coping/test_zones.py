"""Where the machine file keeps a torch from: root, seam, supports and chuck."""

import pytest
from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.errors import PlanError, errors_in
from beamcam.machine import Machine, load
from beamcam.machine.coper import SupportZone
from beamcam.model.part import EndCuts, Part
from beamcam.planning.coping.plan import plan_coping
from benchmarks.coping_faults import over_the_chuck
from tests.unit.coping import samples
from tests.unit.coping.samples import UPN200, outline, part_of
from tests.unit.coping.test_box_tubes import RHS
from tests.unit.coping.test_tubes import HOLE, TUBE, found, program_of, tube

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


def test_nothing_is_cut_over_a_support() -> None:
    """The hole of the web at X 230 is cut from 218.1 to 241.9; the torch is 12 wide."""
    bored = part_of(replace(HOLE, y=120.0), profile=UPN200)
    for low, high, wrong in ((248.2, 260.0, False), (247.6, 260.0, True), (225.0, 226.0, True)):
        there = keyed(TUBE, supports=(SupportZone(low, high),))
        text = program_of(bored, TUBE)
        told = {"verify-coping-zone"} if wrong else set()
        assert {d.code for d in found(text, bored, there)} == told
        if not wrong:
            assert program_of(bored, there).count("G93") == text.count("G93")
            continue
        with pytest.raises(PlanError) as error:
            plan_coping((bored,), there)
        (said,) = error.value.diagnostics
        assert said.code == "plan-coping-support"
        assert f"on face v, over the support from X {low:g} to {high:g}" in said.message


def test_a_path_that_goes_over_a_support_is_seen() -> None:
    """A window from X 230 to 430 has no place over it, but its long sides pass it."""
    window = outline("v", [(200.0, 60.0), (400.0, 60.0), (400.0, 140.0), (200.0, 140.0)], "inner")
    part = part_of(window, profile=UPN200)
    there = keyed(TUBE, supports=(SupportZone(300.0, 340.0),))
    assert {d.code for d in found(program_of(part, TUBE), part, there)} == {"verify-coping-zone"}
    with pytest.raises(PlanError) as error:
        plan_coping((part,), there)
    assert {d.code for d in error.value.diagnostics} == {"plan-coping-support"}


def test_a_tube_is_not_cut_over_a_support_either() -> None:
    part = tube(HOLE)
    there = keyed(TUBE, supports=(SupportZone(220.0, 240.0),))
    assert {d.code for d in found(program_of(part, TUBE), part, there)} == {"verify-coping-zone"}
    with pytest.raises(PlanError, match="over the support from X 220 to 240"):
        plan_coping((part,), there)
