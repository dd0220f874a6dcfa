"""Cuts of a flange along its web, and of a web as near to a flange as the torch comes."""

import re
from collections.abc import Callable
from math import sqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.errors import PlanError, errors_in
from beamcam.machine import Machine, load
from beamcam.model.part import EndCuts, Hole, Part, Profile
from beamcam.model.plan import CopeCut, CopePlan
from beamcam.model.request import Request
from beamcam.planning.coping.plan import plan_coping
from beamcam.solid.opinion import solid_faults
from benchmarks.coping_faults import program_of as text_of
from tests.conftest import examples
from tests.random_copes import SMALL_ROOTS, random_cope, random_stripped
from tests.unit.coping.samples import (
    AT,
    COPER,
    IPE300,
    L100,
    UPN200,
    job_of,
    outline,
    part_of,
    program_of,
    with_keys,
)

TUBE = load("tube-linuxcnc")
ROWS = COPER.needed(COPER.coper, "coper").rows
UB254 = SMALL_ROOTS[0]
BACK, FRONT = 71.45, 78.55  # z of the web's surfaces of an IPE300


def told(part: Part, machine: Machine = COPER) -> set[tuple[str, str]]:
    """What is refused of a part, with what was found."""
    with pytest.raises(PlanError) as caught:
        plan_coping((part,), machine)
    found = errors_in(caught.value.diagnostics)
    return {(d.code, re.sub(r"found (.*?) at x.*", r"\1", d.message)) for d in found}


def pocket(gap: float) -> Part:
    """An IPE300 whose upper flange is cut out between the ends, so many mm beside its web."""
    z = BACK - gap
    ring = [(0.0, 0.0), (300.0, 0.0), (300.0, z), (400.0, z), (400.0, 0.0), (600.0, 0.0),
            (600.0, 150.0), (0.0, 150.0)]  # fmt: skip
    return part_of(outline("o", ring))


def stripped(low: float = BACK, high: float = FRONT) -> Part:
    """An IPE300 whose lower flange is cut off along its web at the far end, on both sides."""
    ring = [(0.0, 0.0), (500.0, 0.0), (500.0, low), (600.0, low), (600.0, high), (500.0, high),
            (500.0, 150.0), (0.0, 150.0)]  # fmt: skip
    return part_of(outline("u", ring))


def coped(profile: Profile, lower: float, upper: float) -> Part:
    """A part that is coped so deep at both flanges of its far end."""
    high, wide = profile.height, profile.width
    flange = [(0.0, 0.0), (530.0, 0.0), (530.0, wide), (0.0, wide)]
    web = [(0.0, 0.0), (530.0, 0.0), (530.0, lower), (600.0, lower), (600.0, high - upper),
           (530.0, high - upper), (530.0, high), (0.0, high)]  # fmt: skip
    outlines = [outline("v", web), outline("o", flange), outline("u", flange)]
    return part_of(*outlines, profile=profile)


def cut_of(plan: CopePlan, kind: str, face: str) -> CopeCut:
    (cut,) = [one for one in plan.operations if (one.kind, one.face) == (kind, face)]
    return cut


def read_back(text: str, part: Part, machine: Machine = COPER) -> set[str]:
    return {d.code for d in errors_in(verify_coping(text, (part,), machine, (), "JOB"))}


@given(st.integers(0, 5000), st.sampled_from([COPER, TUBE]))
@settings(max_examples=examples(12), deadline=None)
def test_flanges_cut_along_their_web_are_read_back_and_their_solid_is_the_part(
    seed: int, machine: Machine
) -> None:
    part = random_stripped(seed)
    try:
        text = program_of(part, machine)
    except PlanError as refused:
        codes = {d.code for d in errors_in(refused.diagnostics)}
        assert codes <= {"plan-section", "plan-coping-narrow"}
        return
    assert not errors_in(solid_faults(text, Request((part,), machine), None))


@given(st.integers(0, 5000))
@settings(max_examples=examples(6), deadline=None)
def test_copes_beside_small_roots_are_read_back_and_their_solid_is_the_part(seed: int) -> None:
    part = random_cope(seed, SMALL_ROOTS, near=True)
    try:
        text = program_of(part)
    except PlanError as refused:
        codes = {d.code for d in errors_in(refused.diagnostics)}
        assert codes <= {"plan-coping-root", "plan-coping-narrow", "plan-coping-off"}
        return
    assert not errors_in(solid_faults(text, Request((part,), COPER), None))


@given(st.floats(0.0, 14.9))
@settings(max_examples=examples(12), deadline=None)
def test_a_cut_beside_the_web_is_as_deep_as_flange_and_fillet_are_there(gap: float) -> None:
    cut = cut_of(plan_coping((pocket(gap),), COPER), "notch", "o")
    deep = 10.7 + 15.0 - sqrt(15.0**2 - (15.0 - gap) ** 2)
    assert cut.thickness == pytest.approx(deep, abs=0.01)
    assert cut.row.up_to == min(row.up_to for row in ROWS if row.up_to >= cut.thickness)
    nearest = max(z for _, z in cut.path)
    assert nearest + cut.row.kerf / 2 == pytest.approx(BACK - gap, abs=0.01)


def test_an_end_with_a_cut_along_the_web_is_one_cut_as_deep_as_both_need() -> None:
    cut = cut_of(plan_coping((stripped(),), COPER), "far", "u")
    assert cut.thickness == pytest.approx(25.7)
    assert cut.root
    # That of a U and of an L too, from the side on which the flange stands.
    for profile, web in ((UPN200, 8.5), (L100, 8.0)):
        wide = profile.width
        ring = [(0.0, 0.0), (600.0, 0.0), (600.0, web), (500.0, web), (500.0, wide), (0.0, wide)]
        part = part_of(outline("u", ring), profile=profile)
        text = program_of(part)
        assert not errors_in(solid_faults(text, Request((part,), COPER), None))


@pytest.mark.parametrize("make", [stripped, lambda: pocket(0.0), lambda: pocket(6.0)])
@pytest.mark.parametrize("by", [1.0, -1.0])
def test_a_cut_along_the_web_elsewhere_is_told(make: Callable[[], Part], by: float) -> None:
    part = make()
    plan = plan_coping((part,), COPER)
    cut = next(c for c in plan.operations if c.thickness not in (10.7, 24.560589701950146)
               and c.face != "v")  # fmt: skip
    path = tuple((x, z + by) if abs(z - 75.0) < 30.0 else (x, z) for x, z in cut.path)
    cuts = tuple(replace(one, path=path) if one is cut else one for one in plan.operations)
    wrong = text_of(replace(plan, operations=cuts), job_of(part))
    assert read_back(wrong, part)
    for row in ROWS:
        if 0.0 < abs(row.up_to - cut.row.up_to) < 5.0:
            cuts = tuple(replace(one, row=row) if one is cut else one for one in plan.operations)
            wrong = text_of(replace(plan, operations=cuts), job_of(part))
            assert "verify-coping-feed" in read_back(wrong, part)


def test_what_would_cut_into_the_web_is_refused() -> None:
    for part in (stripped(BACK + 1.0), stripped(BACK, FRONT - 1.0), pocket(-1.0)):
        assert told(part) == {("plan-coping-root", "a cut into or along a root")}
    # A skew end is cut in its plane, and a bar that has one may be cut along its web elsewhere.
    skew = EndCuts(web_end=-10.0)
    ring = [(0.0, 0.0), (480.0, 0.0), (480.0, BACK), (530.0, BACK), (530.0, 150.0), (0.0, 150.0)]
    part = replace(pocket(3.0), cuts=skew)
    text = program_of(part)
    assert not errors_in(solid_faults(text, Request((part,), COPER), None))
    assert told(replace(part_of(outline("o", ring)), cuts=skew))
    refuses = with_keys(k_area="refuse")
    assert ("plan-coping-k-area", "a cut through the root") in told(pocket(3.0), refuses)
    assert "verify-coping-zone" in read_back(program_of(pocket(3.0)), pocket(3.0), refuses)


def test_a_cope_beside_the_root_is_made_where_a_row_is_no_deeper_than_it() -> None:
    part = coped(UB254, 18.6, 18.6)
    plan = plan_coping((part,), COPER)
    halves = [cut for cut in plan.operations if (cut.kind, cut.face) == ("far", "v")]
    assert len(halves) == 2  # there is no room to pierce at a root
    assert {cut.row.up_to for cut in plan.operations if cut.root and cut.face != "v"} == {18.0}
    text = program_of(part)
    assert not errors_in(solid_faults(text, Request((part,), COPER), None))
    for half in halves:
        cuts = tuple(cut for cut in plan.operations if cut is not half)
        assert read_back(text_of(replace(plan, operations=cuts), job_of(part)), part)
    assert told(coped(UB254, 17.9, 40.0)) == {("plan-coping-root", "a cut into or along a root")}
    # With room beside one of its ends it is cut in one from there.
    whole = plan_coping((coped(UB254, 18.6, 40.0),), COPER)
    assert cut_of(whole, "far", "v")


def test_holes_of_a_web_are_refused_by_how_near_they_are_to_a_flange() -> None:
    def hole(y: float, profile: Profile = UB254) -> Part:
        return part_of(Hole("v", 300.0, y, 22.0, AT), profile=profile)

    assert told(hole(5.0)) == {("plan-coping-root", "a hole that reaches 8.6 mm into face u")}
    assert told(hole(18.6)) == {("plan-coping-root", "a hole that reaches 1.0 mm into face u")}
    beside = "a hole 4.4 mm beside the inner surface of face"
    assert told(hole(24.0)) == {("plan-coping-root", f"{beside} u")}
    assert told(hole(251.4 - 24.0)) == {("plan-coping-root", f"{beside} o")}
    for part in (hole(26.9), hole(251.4 - 26.9), hole(35.8, IPE300)):
        text = program_of(part)
        assert not errors_in(solid_faults(text, Request((part,), COPER), None))
    # A cut-out that goes on beyond an end is no hole of the web.
    ring = [(560.0, 11.0), (620.0, 11.0), (620.0, 60.0), (560.0, 60.0)]
    assert told(part_of(outline("v", ring, "inner"), profile=UB254))


def test_a_web_cut_through_a_flange_that_stays_is_told() -> None:
    ring = [(0.0, 0.0), (300.0, 0.0), (300.0, 40.0), (350.0, 40.0), (350.0, 0.0), (600.0, 0.0),
            (600.0, 300.0), (0.0, 300.0)]  # fmt: skip
    assert told(part_of(outline("v", ring))) <= {
        ("plan-coping-root", "a cut through the flange"), ("plan-coping-root", "a cut to the root"),
    }  # fmt: skip
