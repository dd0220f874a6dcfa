"""Planes that take nothing, found by planners and read-backs of all machines as by the solid."""

from math import hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.bars.pieces import ends_of as required_ends
from beamcam.checks.bars.targets import Unmakeable, targets_of
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.checks.coping.lying import lying
from beamcam.checks.coping.section import CoperSection
from beamcam.checks.coping.skew import plane_faults, skew_ends
from beamcam.errors import PlanError, Source, VerifyError
from beamcam.machine import load
from beamcam.machine.machine import drill_of, saw_of
from beamcam.model.part import EndCuts, EndPlane, Hole, Part, Profile
from beamcam.pipeline import post
from beamcam.planning.coping.ends import outermost
from beamcam.planning.coping.walls import laid
from beamcam.planning.operations.work import works_on
from beamcam.planning.within import idle_planes
from beamcam.solid.part_solid import part_solid

S = Source("p.nc1", 30)
LINE, COPER, TABLE = load("beamline"), load("coper-linuxcnc"), load("plate-linuxcnc")
PROFILES = {
    "I": Profile("I", "IPE200", 200.0, 100.0, 8.5, 5.6, 12.0),
    "U": Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5),
    "L": Profile("L", "L100*10", 100.0, 100.0, 10.0, 10.0, 12.0),
    "T": Profile("T", "T100", 100.0, 100.0, 10.0, 10.0, 0.0),
}
LENGTH = 600.0


def part_with(plane: EndPlane, code: str, web_end: float = 0.0) -> Part:
    return Part("P1", PROFILES[code], LENGTH, S, cuts=EndCuts(web_end=web_end), features=(plane,))


@given(
    st.sampled_from([*PROFILES]), st.sampled_from([0.0, 20.0]), st.sampled_from([-1.0, 1.0]),
    st.integers(-6, 6), st.integers(-6, 6), st.floats(-40.0, 40.0),
)  # fmt: skip
def test_the_same_planes_take_nothing_for_all(
    code: str, web_end: float, side: float, by_y: int, by_z: int, off: float
) -> None:
    """Half a millimetre about a plane that just touches is not asked."""
    at_y = 0.0 if by_y <= 0 else PROFILES[code].height
    at_z = 0.0 if by_z <= 0 else PROFILES[code].width
    normal = side, by_y / 10, by_z / 10
    plane = EndPlane(((LENGTH if side > 0 else 0.0) + off, at_y, at_z), normal, S)
    part = part_with(plane, code, web_end)
    body = part_solid(replace(part, features=()))
    size = hypot(*normal)
    unit = tuple(n / size for n in normal)
    level = sum(n * p for n, p in zip(unit, plane.point, strict=True))
    if body.trim_by_plane(unit, level - 0.4).volume() > 0 >= body.trim_by_plane(
        unit, level + 0.4
    ).volume():  # fmt: skip
        return
    takes = body.trim_by_plane(unit, level).volume() > 1e-6

    lies = laid(part)
    assert (not dict(idle_planes(lies, outermost(lies)))) == takes
    lies = lying(part)
    section = CoperSection(lies.profile)
    assert bool([*plane_faults(lies, section, skew_ends(lies, section), ())]) == takes
    if code == "I":  # what the line takes
        try:
            works_on([part], LINE, ())
            refused = False
        except PlanError:
            refused = True
        assert refused == takes
        tools = ToolCatalogue(LINE, drill_of(LINE))
        targets = targets_of(part, required_ends(part, saw_of(LINE)), tools)
        assert any(isinstance(one, Unmakeable) for one in targets) == takes


@pytest.mark.parametrize("machine", [LINE, COPER, TABLE, load("beamline-pusher")],
                         ids=lambda m: m.name)  # fmt: skip
def test_a_plane_that_takes_nothing_is_a_note_and_no_other_work(machine: object) -> None:
    plate = Profile("B", "FL100*6", 100.0, 0.0, 0.0, 6.0)
    profile = plate if machine is TABLE else PROFILES["I"]
    hole = Hole("v", 300.0, 50.0, 18.0, S)
    plain = Part("P1", profile, LENGTH, S, features=(hole,))
    planes = (EndPlane((LENGTH, 0.0, 0.0), (1.0, 0.0, 0.0), S),
              EndPlane((-3.0, 0.0, 0.0), (-2.0, 0.0, 0.0), S))  # fmt: skip
    stated = replace(plain, features=(hole, *planes))
    posted = post((stated,), machine)  # type: ignore[arg-type]
    assert posted.text == post((plain,), machine).text  # type: ignore[arg-type]
    assert [d.code for d in posted.remarks].count("plan-plane-nothing") == 2
    cuts = replace(plain, features=(hole, replace(planes[0], point=(LENGTH - 5.0, 0.0, 0.0))))
    with pytest.raises(PlanError, match="plan-other"):
        post((cuts,), machine)  # type: ignore[arg-type]


def test_the_read_back_of_a_coper_finds_a_plane_that_was_forgotten(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("beamcam.planning.within.takes_nothing", lambda *_: True)
    plane = EndPlane((LENGTH - 5.0, 0.0, 0.0), (1.0, 0.0, 0.0), S)
    with pytest.raises(VerifyError, match="verify-coping-plane: found an end plane that takes 5"):
        post((part_with(plane, "I"),), COPER)
