"""Weld preparations in any direction: along the bar, slanted, at skew ends, round arcs."""

from itertools import pairwise, product
from math import atan, cos, degrees, hypot, radians, sin, tan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.errors import PlanError, errors_in
from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.plane import Point
from beamcam.machine.coper import A_OF_FACE, torch_angles, torch_way
from beamcam.model.part import Bevel, Contour, EndCuts, Part, Profile
from beamcam.model.plan import CopePlan
from beamcam.model.request import Request
from beamcam.pipeline import RefusedProgram, post
from beamcam.planning.coping import plan as planner
from beamcam.planning.coping.bevels import BevelsMade
from beamcam.planning.coping.plan import plan_coping
from beamcam.planning.manual_list import manual_rows
from beamcam.solid.opinion import solid_faults
from benchmarks import coping_faults
from benchmarks.coping_bevels import BEVEL_PLANS, BEVEL_TEXTS
from tests.conftest import examples, sampled
from tests.random_copes import polygon, random_shaped_bevel
from tests.unit.coping.samples import AT, L100, job_of, outline, part_of, program_of, sample
from tests.unit.coping.test_bevels import TILT, flanged, found, passes, planned, prepared

IPE450 = Profile("I", "IPE450", 450.0, 190.0, 14.6, 9.4, 21.0)
LEG: list[Point] = [(0.0, 0.0), (500.0, 0.0), (500.0, 65.0), (0.0, 65.0)]
SHORT: list[Point] = [(0.0, 0.0), (700.0, 0.0), (700.0, 190.0), (0.0, 190.0)]


def webbed(end: list[Line | Arc], *bevels: Bevel) -> Part:
    """An IPE450 of 800 whose web goes on beyond its flanges at the far end, from y 90 to 360."""
    points = [(0.0, 0.0), (700.0, 0.0), (700.0, 90.0), end[0].start]
    after = [end[-1].end, (700.0, 360.0), (700.0, 450.0), (0.0, 450.0), (0.0, 0.0)]
    curves = (*(Line(a, b) for a, b in pairwise(points)), *end,
              *(Line(a, b) for a, b in pairwise(after)))  # fmt: skip
    length = max(curve.bbox[2] for curve in curves)
    web = Contour("v", "outer", curves, AT, bevels=bevels)
    return part_of(web, *(outline(f, SHORT) for f in "ou"), profile=IPE450, length=length)


def hollow(radius: float, turn: float) -> list[Line | Arc]:
    """An arc of the web's end, its middle in the air, so many degrees to either side."""
    half = radius * sin(radians(turn))
    assert abs(half - 135.0) < 1e-6
    return [Arc((800.0 + radius * cos(radians(turn)), 225.0), radius, 180.0 + turn, -2 * turn)]


HOLLOW = hollow(270.0, 30.0)
BULGING: list[Line | Arc] = [
    Arc((800.0 - 270.0 * cos(radians(30.0)), 225.0), 270.0, -30.0, 60.0)
]  # fmt: skip


def solid_codes(part: Part) -> set[str]:
    text = program_of(part, TILT)
    return {d.code for d in solid_faults(text, Request((part,), TILT), None)}


# --- by hand --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("face", "lean", "wanted"),
    [
        ("v", (0.0, 1.0), (-45.0, 0.0)), ("o", (0.0, 1.0), (45.0, 0.0)),
        ("u", (0.0, 1.0), (-45.0, 0.0)), ("v", (1.0, 0.0), (0.0, 45.0)),
        ("u", (-tan(radians(30.0)), 0.0), (0.0, -30.0)),
        ("v", (1.0, 1.0), (-45.0, degrees(atan(1.0 / 2.0**0.5)))),
    ],
)  # fmt: skip
def test_the_turns_of_a_lean(face: str, lean: Point, wanted: Point) -> None:
    """The head is at X sin B, Y -sin A cos B, Z cos A cos B: over o Z rises with A, over u and v
    Y or Z falls as A rises."""
    off, b_deg = torch_angles(face, lean)
    assert (off, b_deg) == pytest.approx(wanted)
    x, y, z = torch_way(A_OF_FACE[face] + off, b_deg)
    out, along = {"v": (z, y), "o": (y, z), "u": (-y, z)}[face]
    assert (x / out, along / out) == pytest.approx(lean)


def test_a_bevel_along_the_bar_is_an_offset_of_a() -> None:
    """10.7 mm of flange, a land of 2 and 30 degrees: 8.7 tan 30 inside at the surface, less half a
    kerf of 2.4 / cos 30. The edge is the bar's own: no square cut, and it goes before the ends."""
    (cut,) = passes(flanged(Bevel(0, 30.0, 2.0)))
    inside = 8.7 * tan(radians(30.0)) - 1.2 / cos(radians(30.0))
    assert (cut.kind, cut.face, cut.turns) == ("notch", "u", ())
    assert (cut.a_off_deg, cut.b_deg) == (pytest.approx(-30.0), 0.0)
    assert cut.thickness == pytest.approx(10.7 / cos(radians(30.0)))
    assert cut.path == (
        (0.0, 0.0), (-3.2, pytest.approx(inside)), (803.2, pytest.approx(inside))
    )  # fmt: skip
    order = [(c.kind, c.face) for c in planned(flanged(Bevel(0, 30.0, 2.0))).operations]
    assert order[0] == ("notch", "u")
    text = program_of(flanged(Bevel(0, 30.0, 2.0)), TILT)
    # The tip: 3 mm over the flange, 6 mm more for its lower edge, towards +Z with the head.
    assert "G0 A60 B0" in text
    high = 3.0 + 6.0 * sin(radians(30.0))
    assert f"G1 X833.2 Y-{high:g} Z{inside + high * tan(radians(30.0)):.4f}" in text
    assert not solid_codes(flanged(Bevel(0, 30.0, 2.0)))


def test_the_upper_edge_of_a_flange_is_beyond_the_reach_of_a() -> None:
    """There the head would have to lean to the rollers: A 120 on u."""
    part = flanged(Bevel(2, 30.0, 2.0))
    assert not passes(part)
    wide = replace(TILT, axes=tuple(
        replace(axis, max=130.0) if axis.moves == "A" else axis for axis in TILT.axes
    ))  # fmt: skip
    (cut,) = (c for c in plan_coping((part,), wide).operations if c.bevel)
    assert cut.a_off_deg == pytest.approx(30.0)
    assert not found(program_of(part, wide), part, wide)
    assert "verify-coping-limit" in found(program_of(part, wide), part)


def test_a_slanted_edge_takes_both_axes_and_goes_on_over_the_blunt_corner() -> None:
    """60 over 270 mm: the normal leans by atan(60 / 270). At the corner of 90 degrees and that the
    bevel reaches the next edge 7.4 tan 30 tan(that) beyond the end, and the run-out is longer."""
    end: list[Line | Arc] = [Line((800.0, 90.0), (740.0, 360.0))]
    part = webbed(end, Bevel(3, 30.0, 2.0))
    (cut,) = passes(part)
    slant = atan(60.0 / 270.0)
    lean = tan(radians(30.0)) * -cos(slant), tan(radians(30.0)) * -sin(slant)
    assert (cut.a_off_deg, cut.b_deg) == pytest.approx(torch_angles("v", lean))
    (xa, ya), (xb, yb) = cut.path[1:]
    along = hypot(60.0, 270.0) + 2 * (1.2 + 2.0) + 7.4 * tan(radians(30.0)) * 60.0 / 270.0
    assert hypot(xb - xa, yb - ya) == pytest.approx(along)
    assert not found(program_of(part, TILT), part)
    assert not manual_rows(planned(part))
    assert solid_codes(part) <= {"solid-rounded"}


def test_the_ruled_surface_of_a_curve_lies_in_its_cone() -> None:
    """Between two places of a program tip, A and B go straight. At a hundred places of each
    stretch both faces of the web are met where the cone meets them, less half a kerf, within twice
    the chord error of a path."""
    for end in (HOLLOW, BULGING):
        part = webbed(end, Bevel(3, 40.0, 1.0))
        (cut,) = passes(part)
        (arc,) = end
        assert isinstance(arc, Arc)
        side = 1.0 if end is HOLLOW else -1.0  # of the steel, from the middle of the arc
        slope = tan(radians(40.0))
        for (a, b), (ta, tb) in zip(
            pairwise(cut.path[2:-1]), pairwise(cut.turns[2:-1]), strict=True
        ):
            away = [TILT.coper.standoff(3.0, 40.0) if TILT.coper else 0.0] * 2
            tips = [
                tuple(p + far * q for p, q in zip((*at, 0.0), torch_way(*turn), strict=True))
                for at, turn, far in zip((a, b), (ta, tb), away, strict=True)
            ]  # fmt: skip
            for k in range(11):
                share = k / 10
                tip = [p + share * (q - p) for p, q in zip(*tips, strict=True)]
                way = torch_way(*(p + share * (q - p) for p, q in zip(ta, tb, strict=True)))
                for depth in (0.0, 9.4):
                    down = (tip[2] + depth) / way[2]
                    x, y = tip[0] - down * way[0], tip[1] - down * way[1]
                    off = (9.4 - 1.0 - depth) * slope - cut.row.kerf / 2 / cos(radians(40.0))
                    wanted = arc.radius + side * off
                    apart = hypot(x - arc.centre[0], y - arc.centre[1]) - wanted
                    assert abs(apart) < 0.02, (depth, apart)


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("end", "bevel"),
    sampled(product([HOLLOW, BULGING], [Bevel(3, 35.0, 1.0), Bevel(3, -35.0, 5.0)]), 4),
)
def test_arcs_are_planned_read_back_and_cut_as_a_solid(end: list[Line | Arc], bevel: Bevel) -> None:
    part = webbed(end, bevel)
    (cut,) = passes(part)
    assert len(cut.turns) == len(cut.path) > 30
    assert cut.lower == (bevel.angle < 0.0)
    assert not manual_rows(planned(part))
    text = program_of(part, TILT)
    assert solid_codes(part) <= {"solid-rounded"}
    # Each block of inverse time goes along the face at the feed of the row.
    blocks = [line.split() for line in text.splitlines() if line.startswith("G93")]
    assert len(blocks) == len(cut.path) - 1
    for block, (a, b) in zip(blocks, pairwise(cut.path), strict=True):
        feed = float(block[-1][1:]) * hypot(b[0] - a[0], b[1] - a[1])
        assert feed == pytest.approx(cut.row.feed_mm_min, rel=1e-4)


def test_a_bevel_along_the_bar_round_a_corner_and_across_it_is_one_pass() -> None:
    ring = (Line((0.0, 0.0), (780.0, 0.0)), Arc((780.0, 20.0), 20.0, -90.0, 90.0),
            *polygon([(800.0, 20.0), (800.0, 150.0), (0.0, 150.0), (0.0, 0.0)])[:3])  # fmt: skip
    bevels = tuple(Bevel(k, 30.0, 2.0) for k in (0, 1, 2))
    part = part_of(Contour("u", "outer", ring, AT, bevels=bevels), length=800.0)
    (cut,) = passes(part)
    assert (cut.kind, cut.turns[0], cut.turns[-1]) == (
        "far", (pytest.approx(-30.0), 0.0), (pytest.approx(0.0), pytest.approx(-30.0))
    )  # fmt: skip
    assert not found(program_of(part, TILT), part)
    assert not solid_codes(part)
    # Another angle round the corner: nothing runs out there, so all of it is manual work.
    other = replace(part, features=(
        replace(part.features[0], bevels=(bevels[0], Bevel(1, 40.0, 2.0), bevels[2])),
    ))  # fmt: skip
    assert not passes(other)
    assert [row["angle"] for row in manual_rows(planned(other))] == [30.0, 40.0, 30.0]
    assert not found(program_of(other, TILT), other)


def test_flanges_that_end_skew_are_prepared_too() -> None:
    """The web leans there and is cut with B; the flanges are cut square to themselves."""
    slope = tan(radians(20.0))
    ring = [(0.0, 0.0), (900.0 - 190.0 * slope, 0.0), (900.0, 190.0), (0.0, 190.0)]
    part = part_of(*(prepared(Bevel(1, 30.0, 2.0), points=ring, face=f) for f in "ou"),
                   profile=IPE450, length=900.0)  # fmt: skip
    part = replace(part, cuts=EndCuts(flange_end=-20.0))
    made = passes(part)
    assert {cut.face for cut in made} == {"o", "u"}
    assert all(cut.kind == "far" for cut in made)
    assert not manual_rows(planned(part))
    assert not found(program_of(part, TILT), part)


MANUAL: list[tuple[str, Part]] = [
    # The pass would run out into the steel of the web.
    ("beside a re-entrant corner", webbed(HOLLOW, Bevel(2, 30.0, 1.0))),
    ("steeper than B tilts", webbed(HOLLOW, Bevel(3, 50.0, 1.0))),
    ("along the root", part_of(prepared(Bevel(0, 30.0, 0.0), points=LEG), profile=L100,
                               length=500.0)),
    ("on a cone that has no room", part_of(
        Contour("u", "outer", (
            Line((0.0, 0.0), (795.0, 0.0)), Arc((795.0, 5.0), 5.0, -90.0, 90.0),
            *polygon([(800.0, 5.0), (800.0, 150.0), (0.0, 150.0), (0.0, 0.0)])[:3],
        ), AT, bevels=tuple(Bevel(k, 40.0, 0.0) for k in (0, 1, 2))), length=800.0)),
]  # fmt: skip


@pytest.mark.parametrize(("why", "part"), MANUAL, ids=[why for why, _ in MANUAL])
def test_what_no_pass_makes_is_told(why: str, part: Part) -> None:
    assert not passes(part)
    bevels = [b for c in part.contours for b in c.bevels]
    assert len(manual_rows(planned(part))) == len(bevels)
    said = verify_coping(program_of(part, TILT), (part,), TILT, (), "JOB")
    assert "verify-by-hand" in {d.code for d in said}
    assert not errors_in(said)


def test_without_a_word_for_it_nothing_turns_on_the_way() -> None:
    words = replace(TILT.words, feed_turning=())
    plain = replace(TILT, words=words)
    part = webbed(HOLLOW, Bevel(3, 35.0, 1.0))
    assert not [c for c in planned(part, plain).operations if c.bevel]
    assert len(manual_rows(planned(part, plain))) == 1


def test_a_pivot_and_feeds_between_rows_change_nothing_of_it() -> None:
    """Without tool centre point the axes go along the pivot, 150 mm from the tip."""
    coper = TILT.needed(TILT.coper, "coper")
    turn = ("G0 X{x} Y{y} Z{z} A{a} B{b}",)
    pivot = replace(
        TILT, coper=replace(coper, tcp=False, pivot=150.0), words=replace(TILT.words, turn=turn)
    )
    between = replace(TILT, coper=replace(coper, between_rows="interpolate"))
    part = sample("collar")
    for machine in (pivot, between):
        assert len([c for c in planned(part, machine).operations if c.bevel]) == 3
        assert not found(program_of(part, machine), part, machine)


# --- strangers and wrong programs -----------------------------------------------------------------


@pytest.mark.exhaustive
def test_a_sample_has_a_curve_and_an_edge_along_the_bar() -> None:
    part = sample("collar")
    turning = [bool(cut.turns) for cut in passes(part)]
    assert turning == [False, False, True]
    assert not manual_rows(planned(part))
    assert solid_codes(part) == {"solid-rounded"}


def test_a_pass_that_is_missing_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The head has no manual work; the read-back finds some."""
    part = sample("collar")
    plan = planned(part)
    short = replace(plan, operations=tuple(c for c in plan.operations if not c.turns))
    text = coping_faults.program_of(short, job_of(part, TILT))
    said = verify_coping(text, (part,), TILT, (), "JOB")
    assert [d.code for d in said] == ["verify-by-hand"]
    monkeypatch.setattr(planner, "bevel_cuts", _without_turning)
    with pytest.raises(RefusedProgram, match="verify-head"):
        post((part,), TILT, "JOB")


_bevel_cuts = planner.bevel_cuts


def _without_turning(*args: object) -> BevelsMade:
    made = _bevel_cuts(*args)  # type: ignore[arg-type]
    return replace(made, cuts=[cut for cut in made.cuts if not cut.turns])


@given(st.integers(0, 20000))
@settings(max_examples=examples(20), deadline=None)
def test_random_bevels_are_planned_and_none_is_refused(seed: int) -> None:
    part = random_shaped_bevel(seed)
    try:
        plan: CopePlan = planned(part)
    except PlanError as error:
        if {d.code for d in errors_in(error.diagnostics)} <= {"plan-coping-root"}:
            return  # a flange that ends skew over its root
        raise
    text = coping_faults.program_of(plan, job_of(part, TILT))
    assert not found(text, part)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", sampled([8, 11, 14, 23, 31, 38, 43], 7))
def test_the_solid_of_random_bevels_is_the_part(seed: int) -> None:
    part = random_shaped_bevel(seed)
    assert passes(part)
    assert not manual_rows(planned(part))
    said = solid_faults(program_of(part, TILT), Request((part,), TILT), None)
    assert not errors_in(said)
    assert "solid-square" not in {d.code for d in said}


def test_wrong_programs_are_refused() -> None:
    """Of a part with a round bevel and one along the bar, every class that it has something for."""
    import random

    part = sample("collar")
    chance, plan, job = random.Random(5), planned(part), job_of(part, TILT)
    right = coping_faults.program_of(plan, job)
    assert not found(right, part)
    tried = 0
    for name, of_plan in BEVEL_PLANS.items():
        wrong = of_plan(plan, chance)
        if wrong is not None:
            tried += 1
            assert found(coping_faults.program_of(wrong, job), part), name
    for name, of_text in BEVEL_TEXTS.items():
        lines = of_text(right.split("\n"), chance)
        assert lines is not None
        tried += 1
        assert found("\n".join(lines), part), name
    assert tried >= len(BEVEL_PLANS) + len(BEVEL_TEXTS) - 2  # two are of cuts through a wall
