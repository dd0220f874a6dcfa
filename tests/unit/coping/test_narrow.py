"""Slots, notches and cut-outs with little room, whose corners are as round as that allows."""

import re
from math import pi

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from shapely import Polygon, box

from beamcam.checks.coping import verify_coping
from beamcam.errors import PlanError, errors_in
from beamcam.geometry.curves import Arc, Line
from beamcam.machine import Machine, load
from beamcam.model.part import Contour, Part, Profile
from beamcam.model.request import Request
from beamcam.planning.coping.plan import plan_coping
from beamcam.solid.opinion import solid_faults
from benchmarks import coping_faults
from tests.conftest import examples, sampled
from tests.random_tubes import random_slotted
from tests.unit.coping.samples import AT, COPER, job_of, outline, part_of, program_of

TUBE = load("tube-linuxcnc")
RHS = Profile("M", "RHS200*100*8", 200.0, 100.0, 8.0, 8.0, 12.0)
CHS = Profile("RO", "CHS168.3*8", 168.3, 168.3, 0.0, 8.0)
TURN_RHS = 2 * (176.0 + 76.0) + 2 * pi * 12.0


def slotted(wide: float, deep: float = 150.0) -> Part:
    """A rectangular tube with a slot for a gusset in two of its walls, as models have it."""
    low, high = 100.0 - wide / 2, 100.0 + wide / 2
    ends = [(0.0, 0.0), (500.0, 0.0), (500.0, 200.0), (0.0, 200.0), (0.0, high), (deep, high),
            (deep, low), (0.0, low)]  # fmt: skip
    walls = (outline("v", ends), outline("h", ends))
    return Part("R1", RHS, 500.0, AT, features=walls, grade="S235JR")


def notched(wide: float, deep: float) -> Part:
    """A profile with a notch of its upper flange."""
    ring = [(0.0, 0.0), (600.0, 0.0), (600.0, 150.0), (300.0 + wide, 150.0),
            (300.0 + wide, 150.0 - deep), (300.0, 150.0 - deep), (300.0, 150.0),
            (0.0, 150.0)]  # fmt: skip
    return part_of(outline("o", ring))


def closed(wide: float) -> Part:
    ring = [(200.0, 90.0), (280.0, 90.0), (280.0, 90.0 + wide), (200.0, 90.0 + wide)]
    return Part("C1", CHS, 500.0, AT, features=(outline("v", ring, "inner"),), grade="S235JR")


def radii(part: Part, machine: Machine) -> list[float]:
    """What is told of re-entrant corners."""
    said = [d for d in plan_coping((part,), machine).remarks if d.code == "plan-coping-rounded"]
    return [float(re.findall(r"radius of (\S+) mm", d.message)[0]) for d in said]


@pytest.mark.parametrize(
    ("part", "machine", "room"),
    sampled([
        (slotted(11.0), TUBE, 5.5), (slotted(19.9), TUBE, 9.95), (closed(12.0), TUBE, 6.0),
        (closed(20.0), TUBE, 10.0), (notched(12.0, 40.0), COPER, 6.0), (closed(20.5), TUBE, 10.0),
        (notched(19.0, 12.0), COPER, 9.5), (notched(6.0, 3.0), COPER, 3.0),
    ], 4),
)  # fmt: skip
def test_corners_are_as_round_as_half_the_slot_allows(
    part: Part, machine: Machine, room: float
) -> None:
    """A disc touches both sides and the floor with half the width; steps are 0.02 mm."""
    (told,) = radii(part, machine)
    assert room - 0.03 <= told <= room
    assert not errors_in(solid_faults(program_of(part, machine), Request((part,), machine)))


def test_a_gusset_goes_as_far_as_its_corners_meet_the_round() -> None:
    """Worked by hand: between rounds of 5.48 mm in a slot 11 mm wide a plate of 10 mm ends
    5.48 - sqrt(5.48^2 - 4.98^2) = 3.19 mm before the floor."""
    near = plan_coping((slotted(11.0),), TUBE).operations[0]
    floor = [u for x, u in near.path if x > 148.8 and u < near.path[1][1] - TURN_RHS / 2]
    axis = (min(floor) + max(floor)) / 2
    free = Polygon([(x, u) for x, u in near.path if abs(u - axis) < 6.0]).buffer(1.1)
    assert free.bounds[2] == pytest.approx(150.0, abs=0.01)
    assert free.intersection(box(20.0, 0.0, 120.0, 1000.0)).area == pytest.approx(1100.0, abs=2.0)
    assert free.contains(box(20.0, axis - 5.0, 150.0 - 3.24, axis + 5.0))
    assert not free.contains(box(20.0, axis - 5.0, 150.0 - 3.14, axis + 5.0))


def tapered(wide: float, deep: float, leans: tuple[float, float], of_tube: bool) -> Part:
    """A notch whose floor is wider or narrower than its mouth, `leans` of its width on each side:
    of a flange, or of the end of a tube by an outline of v alone."""
    low, high = (wide * lean for lean in leans)
    if of_tube:
        ends = [(0.0, 0.0), (500.0, 0.0), (500.0, 200.0), (0.0, 200.0), (0.0, 90.0 + wide),
                (deep, 90.0 + wide + high), (deep, 90.0 + low), (0.0, 90.0)]  # fmt: skip
        return Part("R1", RHS, 500.0, AT, features=(outline("v", ends),), grade="S235JR")
    ring = [(0.0, 0.0), (600.0, 0.0), (600.0, 150.0), (300.0 + wide, 150.0),
            (300.0 + wide + high, 150.0 - deep), (300.0 + low, 150.0 - deep), (300.0, 150.0),
            (0.0, 150.0)]  # fmt: skip
    return part_of(outline("o", ring))


LEAN = st.floats(-0.3, 0.3)


@given(st.floats(5.0, 22.0), st.floats(8.0, 70.0), st.tuples(LEAN, LEAN), st.booleans())
@example(19.5, 44.0, (-0.01, 0.01), False)  # sides that all but face each other
@example(8.9, 51.0, (0.07, 0.14), False)  # a disc that stands in its mouth leaves steel there
@settings(max_examples=examples(12))
def test_notches_that_taper_are_planned_and_none_is_refused(
    wide: float, deep: float, leans: tuple[float, float], of_tube: bool
) -> None:
    part, machine = tapered(wide, deep, leans, of_tube), TUBE if of_tube else COPER
    try:
        plan = plan_coping((part,), machine)
    except PlanError:
        return
    text = coping_faults.program_of(plan, job_of(part, machine))
    assert not errors_in(verify_coping(text, (part,), machine, (), "JOB"))


@pytest.mark.parametrize(
    ("wide", "deep", "leans", "of_tube"),
    sampled([(15.0, 13.0, (-0.07, 0.19), False), (16.9, 33.9, (0.06, 0.2), True)], 2),
)
def test_the_solid_takes_notches_that_taper(
    wide: float, deep: float, leans: tuple[float, float], of_tube: bool
) -> None:
    """Where a step of the radius moves the disc between its sides by many."""
    part, machine = tapered(wide, deep, leans, of_tube), TUBE if of_tube else COPER
    assert not errors_in(solid_faults(program_of(part, machine), Request((part,), machine)))


@pytest.mark.exhaustive
def test_the_corners_of_h_are_those_of_v_where_v_alone_is_drawn() -> None:
    both, alone = slotted(30.0), replace(slotted(30.0), features=slotted(30.0).features[:1])
    paths = [[cut.path for cut in plan_coping((one,), TUBE).operations] for one in (both, alone)]
    assert paths[0] == paths[1]
    assert program_of(alone, TUBE).count("G1") > 40
    assert not errors_in(solid_faults(program_of(alone, TUBE), Request((alone,), TUBE)))


@given(st.integers(0, 5000))
@settings(max_examples=examples(8))
def test_random_narrow_slots_are_planned_and_none_is_refused(seed: int) -> None:
    part = random_slotted(seed)
    text = coping_faults.program_of(plan_coping((part,), TUBE), job_of(part, TUBE))
    assert not errors_in(verify_coping(text, (part,), TUBE, (), "JOB"))


@pytest.mark.parametrize(
    ("part", "machine"),
    sampled([(slotted(11.0), TUBE), (closed(14.0), TUBE), (notched(12.0, 40.0), COPER)], 2),
)
def test_sharper_corners_and_a_slot_that_is_filled_are_refused(
    part: Part, machine: Machine
) -> None:
    assert machine.coper is not None
    sharp = replace(machine, coper=replace(machine.coper, corner_radius=2.5))
    bare = replace(part, features=())
    filled = program_of(bare, machine)
    for text in (program_of(part, sharp), filled):
        assert errors_in(verify_coping(text, (part,), machine, (), "JOB"))
    assert errors_in(solid_faults(filled, Request((part,), machine)))


def test_a_drawn_chamfer_keeps_the_radius_of_the_machine() -> None:
    """Its sides do not face each other: there is room for the whole disc."""
    ring = [(0.0, 0.0), (600.0, 0.0), (600.0, 150.0), (40.0, 150.0), (40.0, 115.0), (35.0, 110.0),
            (0.0, 110.0)]  # fmt: skip
    part = part_of(outline("o", ring))
    assert radii(part, COPER) == [10.0]
    program_of(part)


@pytest.mark.parametrize(
    ("wide", "expected"),
    [(4.0, r"with room for a radius of 2\.00 mm at x 304, y 110 on face o; expected 2\.4 mm "
           r"at least, as a slot 4\.8 mm wide has it"),
     (2.0, r"radius of 0\.99 mm")],
)  # fmt: skip
def test_what_is_narrower_than_two_kerfs_is_refused(wide: float, expected: str) -> None:
    with pytest.raises(PlanError, match=expected):
        plan_coping((notched(wide, 40.0),), COPER)


def test_a_corner_sharper_than_60_degrees_is_refused() -> None:
    ring = [(200.0, 90.0), (280.0, 90.0), (230.0, 130.0), (200.0, 130.0)]
    part = Part("C1", CHS, 500.0, AT, features=(outline("v", ring, "inner"),), grade="S235JR")
    with pytest.raises(PlanError, match="corner sharper than 60 degrees at x 280, y 90 on face v"):
        plan_coping((part,), TUBE)


def test_a_sharp_corner_beside_a_drawn_round_has_the_room_of_the_slot() -> None:
    """One corner of a slot drawn with 3 mm, the other sharp: its sides face each other too."""
    curves = (
        Line((200.0, 90.0), (277.0, 90.0)), Arc((277.0, 93.0), 3.0, -90.0, 90.0),
        Line((280.0, 93.0), (280.0, 102.0)), Line((280.0, 102.0), (200.0, 102.0)),
        Line((200.0, 102.0), (200.0, 90.0)),
    )  # fmt: skip
    part = Part("C1", CHS, 500.0, AT, features=(Contour("v", "inner", curves, AT),))
    assert max(radii(part, TUBE)) <= 9.0
    assert not errors_in(solid_faults(program_of(part, TUBE), Request((part,), TUBE)))
