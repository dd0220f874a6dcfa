"""Weld preparations of walls by a second pass: where it runs, what it leaves, what is refused."""

import random
from math import cos, radians, tan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.errors import PlanError, errors_in
from beamcam.geometry.plane import Point
from beamcam.machine import Machine, load
from beamcam.model.part import Bevel, Contour, EndCuts, Part, Profile
from beamcam.model.plan import CopeCut, CopePlan
from beamcam.model.request import Request
from beamcam.planning.coping.plan import plan_coping
from beamcam.planning.manual_list import manual_rows
from beamcam.solid.opinion import solid_faults
from benchmarks import coping_faults
from tests.conftest import examples, sampled
from tests.random_copes import random_bevel, random_prepared_web
from tests.unit.coping.samples import (
    COPER,
    L100,
    faults,
    job_of,
    outline,
    part_of,
    program_of,
    sample,
)

TILT = load("coper-tilt-linuxcnc")
FLANGE: list[Point] = [(0.0, 0.0), (800.0, 0.0), (800.0, 150.0), (0.0, 150.0)]


def prepared(*bevels: Bevel, points: list[Point] = FLANGE, face: str = "u") -> Contour:
    return replace(outline(face, points), bevels=bevels)


def flanged(*bevels: Bevel) -> Part:
    return part_of(prepared(*bevels), length=800.0)


_PLANS: dict[tuple[str, str], CopePlan] = {}


def planned(part: Part, machine: Machine = TILT) -> CopePlan:
    """The plan of a part; many tests look at the same more than once."""
    key = repr(part), repr(machine)
    if key not in _PLANS:
        _PLANS[key] = plan_coping((part,), machine)
    return _PLANS[key]


def passes(part: Part) -> list[CopeCut]:
    return [cut for cut in planned(part).operations if cut.bevel]


def found(text: str, part: Part, machine: Machine = TILT) -> set[str]:
    return {d.code for d in faults(text, part, machine)}


def test_a_second_pass_takes_the_wedge_off() -> None:
    (cut,) = passes(flanged(Bevel(1, 30.0, 2.0)))
    assert (cut.kind, cut.face, cut.b_deg) == ("far", "u", pytest.approx(-30.0))
    # 10.7 mm of flange along the torch.
    assert cut.thickness == pytest.approx(10.7 / cos(radians(30.0)))
    assert cut.row.up_to == 13.0
    # The bevel meets the surface 8.7 tan 30 inside of the edge; half a kerf goes into the scrap.
    inside = 8.7 * tan(radians(30.0)) - 1.2 / cos(radians(30.0))
    assert cut.path == (
        (800.0, 0.0), (pytest.approx(800.0 - inside), pytest.approx(-3.2)),
        (pytest.approx(800.0 - inside), pytest.approx(153.2)),
    )  # fmt: skip


def test_it_follows_the_square_cut_and_the_web_parts_the_piece() -> None:
    part = part_of(
        prepared(Bevel(1, 30.0, 2.0), face="o"), prepared(Bevel(1, 30.0, 2.0)), length=800.0
    )
    order = [(c.face, c.bevel) for c in planned(part).operations if c.kind == "far"]
    assert order == [("o", False), ("o", True), ("u", False), ("u", True), ("v", False)]
    assert not manual_rows(planned(part))


def test_the_last_wall_of_a_bar_has_no_second_pass() -> None:
    leg = [(0.0, 0.0), (500.0, 0.0), (500.0, 65.0), (0.0, 65.0)]
    web = [(0.0, 0.0), (500.0, 0.0), (500.0, 100.0), (0.0, 100.0)]
    part = part_of(
        prepared(Bevel(1, 30.0, 0.0), points=leg), prepared(Bevel(1, 30.0, 0.0), points=web,
                                                            face="v"),
        profile=L100, length=500.0,
    )  # fmt: skip
    assert [(c.face, c.kind) for c in passes(part)] == [("u", "far")]
    assert [row["face"] for row in manual_rows(planned(part))] == ["v"]


def test_a_coped_web_has_its_own() -> None:
    points = [(0.0, 0.0), (720.0, 0.0), (720.0, 50.0), (800.0, 50.0), (800.0, 250.0),
              (720.0, 250.0), (720.0, 300.0), (0.0, 300.0)]  # fmt: skip
    short = [(0.0, 0.0), (720.0, 0.0), (720.0, 150.0), (0.0, 150.0)]
    part = part_of(
        prepared(Bevel(3, 35.0, 1.0), points=points, face="v"),
        *(outline(face, short) for face in "ou"), length=800.0,
    )  # fmt: skip
    (cut,) = passes(part)
    assert (cut.face, cut.b_deg) == ("v", pytest.approx(-35.0))
    text = program_of(part, TILT)
    codes = {d.code for d in solid_faults(text, Request((part,), TILT), None)}
    assert codes <= {"solid-rounded"}


def webbed(*bevels: Bevel, face: str = "v") -> Part:
    """An IPE450 whose web stands out between its flanges, with bevels at its ends."""
    points = [(70.0, 0.0), (720.0, 0.0), (720.0, 90.0), (800.0, 90.0), (800.0, 360.0),
              (720.0, 360.0), (720.0, 450.0), (70.0, 450.0), (70.0, 360.0), (0.0, 360.0),
              (0.0, 90.0), (70.0, 90.0)]  # fmt: skip
    short = [(70.0, 0.0), (720.0, 0.0), (720.0, 190.0), (70.0, 190.0)]
    return part_of(
        prepared(*bevels, points=points, face=face), *(outline(f, short) for f in "ou"),
        profile=Profile("I", "IPE450", 450.0, 190.0, 14.6, 9.4, 21.0), length=800.0,
    )  # fmt: skip


def made(part: Part) -> list[tuple[str, float, bool]]:
    """The cuts of the ends of a web: the tilt of each, and whether it is of the far side."""
    return [
        (cut.kind, round(cut.b_deg, 3), cut.lower)
        for cut in planned(part).operations if cut.face == "v"
    ]  # fmt: skip


def test_a_bevel_of_the_far_side_goes_through_all_of_the_wall_before_the_square_cut() -> None:
    part = webbed(Bevel(3, -40.0, 5.0))
    assert made(part) == [("near", 0.0, False), ("far", 40.0, True), ("far", 0.0, False)]
    (cut,) = passes(part)
    # The plane leaves the edge 4.4 mm below the surface, on which it lies 4.4 tan 40 beyond it.
    beyond = 800.0 + 4.4 * tan(radians(40.0)) + 1.2 / cos(radians(40.0))
    assert cut.row.up_to == 13.0
    assert [x for x, _ in cut.path[1:]] == pytest.approx([beyond, beyond])
    assert [y for _, y in cut.path[1:]] == pytest.approx([90.0 - 3.2, 360.0 + 3.2])
    assert not manual_rows(planned(part))


def test_three_passes_make_a_k_the_lower_one_first() -> None:
    part = webbed(Bevel(9, -40.0, 3.0), Bevel(9, 40.0, 4.5), Bevel(3, 40.0, 4.0))
    assert made(part) == [
        ("near", -40.0, True), ("near", 0.0, False), ("near", 40.0, False),
        ("far", 0.0, False), ("far", -40.0, False),
    ]  # fmt: skip
    assert not manual_rows(planned(part))
    text = program_of(part, TILT)
    told = {d.code: float(d["found"]) for d in solid_faults(text, Request((part,), TILT), None)}
    assert told.keys() == {"solid-rounded", "solid-square"}
    assert told["solid-square"] < 5.0  # mm3, of rounding


def test_what_is_drawn_behind_the_web_is_seen_through_it() -> None:
    front, behind = webbed(Bevel(3, -40.0, 5.0)), webbed(Bevel(3, 40.0, 4.4), face="h")
    assert made(front) == made(behind)
    assert not found(program_of(front, TILT), behind)
    assert found(program_of(webbed(Bevel(3, 40.0, 4.4)), TILT), behind)


@pytest.mark.parametrize(
    "bevel",
    [Bevel(3, -40.0, 8.4),  # the square cut's arc would have no steel
     Bevel(3, -46.0, 4.0), Bevel(2, -30.0, 4.0)],
)  # fmt: skip
def test_what_no_lower_pass_makes_is_manual_work(bevel: Bevel) -> None:
    part = webbed(bevel)
    assert not passes(part)
    assert [row["angle"] for row in manual_rows(planned(part))] == [bevel.angle]
    assert not found(program_of(part, TILT), part)


@given(st.integers(0, 5000))
@settings(max_examples=examples(15), deadline=None)
def test_random_webs_with_bevels_are_read_back_and_are_the_part(seed: int) -> None:
    part = random_prepared_web(seed)
    text = program_of(part, TILT)
    assert not errors_in(solid_faults(text, Request((part,), TILT), None))


MANUAL_WORK = [
    Bevel(1, -30.0, 2.0),  # on the inside, where the root is
    Bevel(2, 30.0, 2.0),  # along the bar, where the head would lean to the rollers
    Bevel(1, 50.0, 2.0),  # beyond the reach of B
    Bevel(1, 30.0, 10.7),  # nothing but land
    Bevel(1, 15.0, 4.0),  # a wedge that is narrower than what piercing burns
]


@pytest.mark.parametrize("bevel", MANUAL_WORK)
def test_what_no_pass_makes_is_manual_work(bevel: Bevel) -> None:
    part = flanged(bevel)
    assert not passes(part)
    assert [row["angle"] for row in manual_rows(planned(part))] == [bevel.angle]
    said = verify_coping(program_of(part, TILT), (part,), TILT, (), "JOB")
    assert [d.code for d in said] == ["verify-by-hand"]


def test_some_bevels_of_a_contour_leave_it_on_the_list() -> None:
    part = flanged(Bevel(1, 30.0, 2.0), Bevel(3, -30.0, 2.0))
    assert len(passes(part)) == 1
    assert {row["angle"] for row in manual_rows(planned(part))} == {30.0, -30.0}
    assert not found(program_of(part, TILT), part)


def test_without_b_all_are_and_at_skew_ends_none_that_is_square() -> None:
    part = flanged(Bevel(1, 30.0, 2.0))
    assert len(manual_rows(planned(part, COPER))) == 1
    skew = replace(part_of(length=800.0), cuts=EndCuts(web_start=10.0))
    drawn = [(0.0, 0.0), (800.0, 0.0), (800.0, 150.0), (0.0, 150.0)]
    skew = replace(skew, features=(prepared(Bevel(1, 30.0, 2.0), points=drawn, face="o"),))
    assert [cut.face for cut in passes(skew)] == ["o"]
    assert not found(program_of(skew, TILT), skew)


def test_without_its_pass_a_bevel_is_told_as_manual_work() -> None:
    part = sample("splice")
    plan = planned(part)
    square = replace(plan, operations=tuple(c for c in plan.operations if not c.bevel))
    text = coping_faults.program_of(square, job_of(part, TILT))
    said = verify_coping(text, (part,), TILT, (), "JOB")
    assert [d.code for d in said] == ["verify-by-hand"] * 2


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("wrong land", "verify-coping-hurt"), ("passes in the wrong order", "verify-coping-passes"),
        ("bevel behind the parting", "verify-coping-passes"), ("B dropped", "verify-coping-extra"),
        ("B the other way", "verify-coping-hurt"),
    ],
)  # fmt: skip
def test_wrong_passes_are_refused(name: str, code: str) -> None:
    part = sample("splice")
    wrong = dict(coping_faults.faults(part, TILT, random.Random(2)))
    assert code in found(wrong[name], part)


@given(st.integers(0, 5000))
@settings(max_examples=examples(25))
def test_no_random_bevel_that_is_planned_is_refused(seed: int) -> None:
    part = random_bevel(seed)
    try:
        plan = planned(part)
    except PlanError:
        return
    assert not found(coping_faults.program_of(plan, job_of(part, TILT)), part)


@pytest.mark.parametrize("seed", sampled(range(10), 4))
def test_the_solid_agrees(seed: int) -> None:
    part = random_bevel(seed)
    text = program_of(part, TILT)
    said = solid_faults(text, Request((part,), TILT), None)
    assert {d.code for d in said} <= {"solid-square"}
    if not manual_rows(planned(part)):
        assert not said
