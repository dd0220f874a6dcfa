"""Holes of a web right under a flange that stays: what is cut of them, what is told and refused."""

import random
from itertools import pairwise
from math import cos, radians, tan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.errors import PlanError, errors_in
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine import Machine, load
from beamcam.model.part import Contour, EndCuts, Part, Profile
from beamcam.model.plan import CopePlan
from beamcam.model.request import Request
from beamcam.planning.coping.plan import plan_coping
from beamcam.planning.manual_list import manual_rows
from beamcam.solid.opinion import solid_faults
from benchmarks import coping_faults
from tests.conftest import examples
from tests.unit.coping.samples import (
    AT,
    COPER,
    IPE300,
    UPN200,
    faults,
    job_of,
    outline,
    part_of,
    program_of,
    sample,
    with_keys,
)

TILT = load("coper-tilt-linuxcnc")
HEB300 = Profile("I", "HEB300", 300.0, 300.0, 19.0, 11.0, 27.0)


def holed(profile: Profile = IPE300, radius: float = 40.0, length: float = 1200.0) -> Part:
    """A web with a quarter of a circle out of it at both flanges of its far end."""
    t, high = profile.flange_thickness, profile.height
    curves: list[Curve] = []

    def to(*places: Point) -> None:
        curves.extend(Line(a, b) for a, b in pairwise(places))

    to((0.0, 0.0), (length, 0.0), (length, t), (length - radius, t))
    curves.append(Arc((length, t), radius, 180.0, -90.0))
    to((length, t + radius), (length, high - t - radius))
    curves.append(Arc((length, high - t), radius, 270.0, -90.0))
    to((length - radius, high - t), (length, high - t), (length, high), (0.0, high), (0.0, 0.0))
    return part_of(Contour("v", "outer", tuple(curves), AT), profile=profile, length=length)


def planned(part: Part, machine: Machine = COPER) -> CopePlan:
    return plan_coping((part,), machine)


def refused(part: Part, machine: Machine = COPER) -> set[str]:
    with pytest.raises(PlanError) as caught:
        planned(part, machine)
    return {d.code for d in caught.value.diagnostics}


def found(text: str, part: Part) -> set[str]:
    return {d.code for d in faults(text, part)}


def test_a_hole_is_cut_up_to_where_the_root_goes_with_the_flange() -> None:
    plan = planned(holed())
    told = [d for d in plan.remarks if d.code == "plan-coping-ledge"]
    # A pass of 25 mm through the root is 14.3 mm deeper than the flange.
    assert [(d["face"], d["x"], d["found"]) for d in told] == [
        ("u", "1200", "14.4"), ("o", "1200", "14.4")
    ]  # fmt: skip
    (web,) = [c for c in plan.operations if (c.kind, c.face) == ("far", "v")]
    # Half a kerf over the ledges, 25.1 mm off the outside of the flanges.
    at_ledge = [y for x, y in web.path[1:] if x < 1200.0]
    assert min(at_ledge) == pytest.approx(25.1 + web.row.kerf / 2, abs=0.01)
    assert max(at_ledge) == pytest.approx(300.0 - 25.1 - web.row.kerf / 2, abs=0.01)
    assert [(row["kind"], row["why"]) for row in manual_rows(plan)] == [("outline", "root")]


@pytest.mark.parametrize(
    ("profile", "radius"), [(IPE300, 40.0), (IPE300, 20.0), (HEB300, 45.0), (UPN200, 35.0)]
)
def test_the_program_and_its_solid_are_the_part_but_for_the_ledges(
    profile: Profile, radius: float
) -> None:
    part = holed(profile, radius)
    text = program_of(part)
    said = verify_coping(text, (part,), COPER, (), "JOB")
    assert [d.code for d in said] == ["verify-by-hand"]
    codes = [d.code for d in solid_faults(text, Request((part,), COPER), None)]
    assert set(codes) == {"solid-rounded", "solid-square"}


def test_a_hole_that_is_all_beside_the_flange_is_refused() -> None:
    assert refused(holed(radius=14.0)) == {"plan-coping-root"}


def test_a_hole_under_a_flange_in_the_middle_is_refused() -> None:
    hole = outline("v", [(500.0, 5.0), (560.0, 5.0), (560.0, 60.0), (500.0, 60.0)], "inner")
    assert "plan-coping-root" in refused(part_of(hole))


def test_a_web_that_is_drawn_without_its_flange_has_no_hole_under_it() -> None:
    cope = outline("v", [(0.0, 0.0), (1200.0, 0.0), (1200.0, 250.0), (1120.0, 250.0),
                         (1120.0, 300.0), (0.0, 300.0)])  # fmt: skip
    part = part_of(cope, length=1200.0)
    assert refused(part) == {"plan-coping-root"}
    assert "verify-coping-left" in found(program_of(part_of(length=1200.0)), part)


def mitred(angle: float, profile: Profile = IPE300, size: float = 45.0) -> Part:
    """A web with chamfered holes at both flanges of its far end, which is skew."""
    t, high, length = profile.flange_thickness, profile.height, 1200.0
    rise = tan(radians(angle))

    def x(y: float) -> float:
        return length - rise * (y if angle > 0.0 else y - high)

    ends = [(x(0.0), 0.0), (x(t), t), (x(t) - size, t), (x(t + size), t + size)]
    other = high - t
    ends += [(x(other - size), other - size), (x(other) - size, other), (x(other), other)]
    drawn = outline("v", [(0.0, 0.0), *ends, (x(high), high), (0.0, high)])
    return replace(part_of(drawn, profile=profile, length=length), cuts=EndCuts(web_end=angle))


@given(
    st.floats(5.0, 33.0), st.sampled_from((-1.0, 1.0)), st.sampled_from([IPE300, UPN200, HEB300]),
    st.floats(42.0, 60.0),
)  # fmt: skip
@settings(max_examples=examples(10), deadline=None)
def test_at_a_skew_end_the_ledge_runs_to_its_plane(
    angle: float, sign: float, profile: Profile, size: float
) -> None:
    part = mitred(round(sign * angle, 1), profile, round(size, 1))
    plan = planned(part, TILT)
    assert [d.code for d in plan.remarks].count("plan-coping-ledge") == 2
    assert [row["why"] for row in manual_rows(plan)] == ["root"]
    text = program_of(part, TILT)
    assert not errors_in(solid_faults(text, Request((part,), TILT), None))
    straight = replace(part, features=())
    assert errors_in(verify_coping(program_of(straight, TILT), (part,), TILT, (), "JOB"))
    assert errors_in(verify_coping(text, (straight,), TILT, (), "JOB"))


def test_a_ledge_at_a_skew_end_is_as_high_as_the_tilted_pass_is_deep() -> None:
    (told, _) = [d for d in planned(mitred(15.0), TILT).remarks if d.code == "plan-coping-ledge"]
    # The row of 28 mm at 15 degrees goes 27.05 mm deep, 16.35 mm more than the flange.
    assert float(told["found"]) == pytest.approx(28.0 * cos(radians(15.0)) - 10.7 + 0.1, abs=0.06)


def test_without_b_a_hole_at_a_skew_end_is_refused() -> None:
    assert refused(mitred(15.0)) == {"plan-coping-root"}


def test_a_hole_at_a_skew_end_that_the_web_leans_over_is_refused() -> None:
    part = replace(holed(length=1200.0 - 150.0 * tan(radians(20.0))), length=1200.0)
    end = EndCuts(flange_end=20.0)
    assert refused(replace(part, cuts=end)) == {"plan-coping-root"}


def test_no_root_is_passed_where_the_machine_refuses_it() -> None:
    assert "plan-coping-k-area" in refused(holed(), with_keys(k_area="refuse"))


def test_a_program_for_the_whole_web_is_not_that_of_one_with_holes() -> None:
    whole = program_of(part_of(length=1200.0))
    assert found(whole, holed()) >= {"verify-coping-left"}
    assert "verify-coping-hurt" in found(program_of(holed()), part_of(length=1200.0))
    assert found(program_of(holed(radius=38.0)), holed())


def test_the_flange_is_not_cut_for_the_hole() -> None:
    coped = outline("u", [(0.0, 0.0), (1160.0, 0.0), (1160.0, 150.0), (0.0, 150.0)])
    part = holed()
    other = replace(part, features=(*part.features, coped))
    assert found(program_of(part), other)


@given(st.floats(18.0, 60.0), st.sampled_from([IPE300, HEB300, UPN200]))
@settings(max_examples=examples(15))
def test_no_hole_that_is_planned_is_refused(radius: float, profile: Profile) -> None:
    part = holed(profile, round(radius, 2))
    try:
        plan = planned(part)
    except PlanError:
        return
    assert not found(coping_faults.program_of(plan, job_of(part)), part)


def test_wrong_programs_of_holes_are_refused() -> None:
    part = sample("girder")
    for name, text in coping_faults.faults(part, COPER, random.Random(3)):
        assert found(text, part), name
