"""Copes near to a root: where their corner is still round web and flange are cut square."""

from math import sqrt
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.geometry.curves import Arc, Line
from beamcam.machine import Machine, load
from beamcam.model.part import Contour, Part, Profile
from beamcam.model.request import Job, Request
from beamcam.planning.coping.plan import plan_coping
from beamcam.planning.manual_list import manual_rows
from beamcam.solid.opinion import solid_faults
from benchmarks.coping_faults import program_of as text_of
from benchmarks.coping_roots import STEPS
from tests.conftest import examples, sampled
from tests.random_copes import CEES, polygon, random_cope, random_tee
from tests.unit.coping.samples import (
    AT,
    COPER,
    IPE300,
    L100,
    UPN200,
    outline,
    part_of,
    program_of,
    sample,
    with_keys,
)

TUBE = load("tube-linuxcnc")
DEEP = {"IPE300": 25.0, "UPN200": 25.0, "L100*65*8": 20.0}  #: mm that a pass through a root cuts
SQUARE = 0.1  #: mm that a cut may slant and be square


def coped(deep: float, profile: Profile = IPE300, side: float = 0.0, flange: float = 0.0) -> Part:
    """A part coped so deep at the start of its flange `u`; the side of the cope leans by `side` mm
    to the flange, which ends `flange` mm from it."""
    high, wide = profile.height, profile.width
    end = 80.0 + side * (1.0 - profile.flange_thickness / deep) + flange
    return part_of(
        outline("v", [(80.0 + side, 0.0), (600.0, 0.0), (600.0, high), (0.0, high), (0.0, deep),
                      (80.0, deep)]),
        outline("u", [(end, 0.0), (600.0, 0.0), (600.0, wide), (end, wide)]),
        profile=profile,
    )  # fmt: skip


def steps(part: Part, machine: Machine = COPER) -> list[Diagnostic]:
    return [d for d in plan_coping((part,), machine).remarks if d.code == "plan-coping-step"]


def refusals(part: Part, machine: Machine = COPER) -> list[Diagnostic]:
    with pytest.raises(PlanError) as caught:
        plan_coping((part,), machine)
    return errors_in(caught.value.diagnostics)


def too_long(deep: float, pass_deep: float, radius: float) -> float:
    """How far before the side of a cope its round is where the pass ends, 0.05 mm deeper."""
    over = radius - (deep - pass_deep - 0.05)
    return radius - sqrt(radius**2 - over**2) if over > 0.0 else 0.0


def test_the_round_ends_where_the_pass_through_the_root_does_and_that_is_told() -> None:
    plan = plan_coping((coped(30.0),), COPER)
    (told,) = [d for d in plan.remarks if d.code == "plan-coping-step"]
    x = 80.0 - too_long(30.0, 25.0, 10.0)
    assert (told["face"], told["found"]) == ("u", "1.4")
    assert float(told["x"]) == pytest.approx(x, abs=0.01)
    rows = [(row["kind"], row["face"], row["why"]) for row in manual_rows(plan)]
    assert rows == [("outline", "v", "root"), ("outline", "u", "root")]
    (flange,) = [cut for cut in plan.operations if cut.face == "u" and cut.kind == "near"]
    over_web = {round(px, 2) for px, pz in flange.path if 60.0 < pz < 90.0}
    beside = {round(px, 2) for px, pz in flange.path[flange.lead + 1 :] if not 50.0 < pz < 100.0}
    half_kerf = flange.row.kerf / 2
    assert over_web <= {round(x - half_kerf, 2)}
    assert beside == {round(80.0 - half_kerf, 2)}


@given(
    st.sampled_from([IPE300, UPN200, L100]), st.floats(1.0, 16.0),
    st.sampled_from([4.0, 10.0, 14.0]), st.sampled_from([COPER, TUBE]),
)  # fmt: skip
@settings(max_examples=examples(10), deadline=None)
def test_copes_of_any_depth_from_the_root_on_are_made(
    profile: Profile, more: float, radius: float, machine: Machine
) -> None:
    deep = round(DEEP[profile.name] + more, 2)
    part, machine = coped(deep, profile), replace(
        machine, coper=replace(machine.needed(machine.coper, "coper"), corner_radius=radius)
    )  # fmt: skip
    most = too_long(deep, DEEP[profile.name], radius)
    told = [float(d["found"]) for d in steps(part, machine)]
    assert told == ([pytest.approx(most, abs=0.06)] if told or most > SQUARE + 0.01 else [])
    text = program_of(part, machine)
    assert not errors_in(solid_faults(text, Request((part,), machine), None))


@given(st.integers(0, 5000), st.sampled_from([COPER, TUBE]), st.sampled_from("ICT"))
@settings(max_examples=examples(12), deadline=None)
def test_random_copes_near_roots_are_read_back_and_their_solid_is_the_part(
    seed: int, machine: Machine, kind: str
) -> None:
    if kind == "T":
        part = random_tee(seed, near=True)
    else:
        part = random_cope(seed, CEES, near=True) if kind == "C" else random_cope(seed, near=True)
    try:
        text = program_of(part, machine)
    except PlanError as refused:  # in the root, without room, or too high for the chuck
        codes = {d.code.removeprefix("plan-") for d in errors_in(refused.diagnostics)}
        assert codes <= {"coping-root", "coping-narrow", "coping-off", "section"}
        return
    assert not errors_in(solid_faults(text, Request((part,), machine), None))


@pytest.mark.parametrize("name", STEPS)
@pytest.mark.parametrize("deep", [27.0, 30.0])
def test_other_steps_are_refused(name: str, deep: float) -> None:
    part = coped(deep)
    plan = plan_coping((part,), COPER)
    for seed in (0, 1):
        wrong = STEPS[name](plan, Random(seed))
        assert wrong is not None
        text = text_of(wrong, Job(Request((part,), COPER, name="JOB"), (0,)))
        assert errors_in(verify_coping(text, (part,), COPER, (), "JOB"))


def test_a_drawn_round_that_enters_the_root_too() -> None:
    drawn = coped(30.0)
    for radius, found in ((8.0, "0.6"), (20.0, "6.8")):
        flange = drawn.features[1]
        ring = (
            Line((0.0, 30.0), (80.0 - radius, 30.0)),
            Arc((80.0 - radius, 30.0 - radius), radius, 90.0, -90.0),
            *polygon([(80.0, 30.0 - radius), (80.0, 0.0), (600.0, 0.0), (600.0, 300.0),
                      (0.0, 300.0), (0.0, 30.0)])[:-1],
        )  # fmt: skip
        part = replace(drawn, features=(Contour("v", "outer", ring, AT), flange))
        assert [d["found"] for d in steps(part)] == [found]
        assert not errors_in(solid_faults(program_of(part), Request((part,), COPER), None))


@pytest.mark.parametrize("side", sampled([-12.0, 2.0, 12.0, -2.0], 2))
def test_a_side_that_leans_and_ends_in_a_round(side: float) -> None:
    part = coped(30.0, side=side)
    assert steps(part)
    assert not errors_in(solid_faults(program_of(part), Request((part,), COPER), None))


@pytest.mark.parametrize(("part", "expected"), [
    (coped(24.0), "25.1 mm off the outside of face u at least"),
    (coped(12.0), "25.1 mm off the outside of face u at least"),
    (coped(28.0, flange=5.0), "with one of face u that it meets"),
    (coped(28.0, flange=-5.0), "with one of face u that it meets"),
    (coped(60.0, flange=5.0), "one of face v at that x"),
])  # fmt: skip
def test_what_lies_in_a_root_or_apart_is_refused(part: Part, expected: str) -> None:
    assert any(expected in d.message for d in refusals(part))
    assert {d.code for d in refusals(part)} == {"plan-coping-root"}


@pytest.mark.parametrize("radius", [8.0, 12.0])
def test_a_small_access_hole_is_not_closed(radius: float) -> None:
    high = 300.0 - IPE300.flange_thickness
    ring = (
        Line((600.0, 0.0), (600.0, high - radius)),
        Arc((600.0, high), radius, 270.0, -90.0),
        *polygon([(600.0 - radius, high), (600.0, high), (600.0, 300.0), (0.0, 300.0), (0.0, 0.0),
                  (600.0, 0.0)])[:-1],
    )  # fmt: skip
    part = part_of(Contour("v", "outer", ring, AT))
    assert {d.code for d in refusals(part)} == {"plan-coping-root"}


def test_a_machine_without_passes_through_roots() -> None:
    refused = refusals(coped(30.0), with_keys(k_area="refuse"))
    assert {d.code for d in refused} == {"plan-coping-k-area"}


@pytest.mark.exhaustive
def test_a_piece_that_comes_cut_and_copes_at_both_ends() -> None:
    for part, count in ((replace(coped(30.0), made=()), 1), (sample("stringer"), 3)):
        text = program_of(part)
        assert len(steps(part)) == count
        assert not errors_in(solid_faults(text, Request((part,), COPER), None))


@pytest.mark.parametrize("long", [0.4, 1.0])
def test_the_solid_takes_copes_that_are_hardly_longer_than_noise(long: float) -> None:
    """A saw line takes an outline so near to an end for that end; a torch follows it."""
    part = part_of(
        outline("v", [(long, 0.0), (600.0, 0.0), (600.0, 300.0), (0.0, 300.0), (0.0, 60.0),
                      (long, 60.0)]),
        outline("u", [(long, 0.0), (600.0, 0.0), (600.0, 150.0), (long, 150.0)]),
    )  # fmt: skip
    text = text_of(plan_coping((part,), COPER), Job(Request((part,), COPER, name="JOB"), (0,)))
    assert not errors_in(solid_faults(text, Request((part,), COPER)))
