"""Bevels of the far side up to the surface, bevels of cut-outs, and bevels along any curve."""

import random
from itertools import pairwise
from math import cos, dist, hypot, pi, radians, sin, tan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from shapely import LineString
from shapely import Point as Place

from beamcam.errors import errors_in
from beamcam.geometry.curves import Arc, BSpline, Curve, EllipseArc, Line
from beamcam.geometry.plane import Point
from beamcam.machine.coper import torch_way
from beamcam.model.part import Bevel, Contour, Face, Part
from beamcam.model.plan import CopeCut
from beamcam.model.request import Request
from beamcam.planning.manual_list import manual_rows
from beamcam.solid.opinion import solid_faults
from benchmarks import coping_faults
from benchmarks.coping_bevels import BEVEL_PLANS, BEVEL_TEXTS
from tests.conftest import examples
from tests.random_bevels import random_cut_out, random_end
from tests.random_copes import polygon
from tests.unit.coping.samples import AT, job_of, part_of, program_of, sample
from tests.unit.coping.test_bevel_directions import HOLLOW, IPE450, solid_codes, webbed
from tests.unit.coping.test_bevels import (
    TILT,
    found,
    made,
    passes,
    planned,
    prepared,
)
from tests.unit.coping.test_bevels import webbed as both_ends

WEB, STANDOFF = 9.4, 3.0
CIRCLE = (Arc((400.0, 225.0), 60.0, 0.0, 180.0), Arc((400.0, 225.0), 60.0, 180.0, 180.0))


def holed(curves: tuple[Curve, ...], angle: float, land: float, face: Face = "v") -> Part:
    """An IPE450 with a cut-out that is bevelled all round."""
    bevels = tuple(Bevel(k, angle, land) for k in range(len(curves)))
    return part_of(Contour(face, "inner", curves, AT, bevels=bevels), profile=IPE450, length=800.0)


def facets(wide: float, tall: float, count: int = 36) -> tuple[Curve, ...]:
    """An ellipse by lines."""
    turns = [2 * pi * k / count for k in range(count)]
    return polygon([(400.0 + wide * cos(t), 225.0 + tall * sin(t)) for t in turns])


def reasons(part: Part) -> list[str]:
    """Why edges are left for manual work."""
    remarks = planned(part).remarks
    return [dict(d.values)["why"] for d in remarks if d.code == "plan-coping-bevel"]


def feet(cut: CopeCut, depth: float) -> list[Point]:
    """Where a pass over the web goes through a plane so far below it, from its first place to its
    last one, at eleven places of each block between which tip, A and B go straight."""
    assert TILT.coper is not None
    turns = cut.turns or ((cut.a_off_deg, cut.b_deg),) * len(cut.path)
    tips = []
    for at, turn in zip(cut.path, turns, strict=True):
        way = torch_way(*turn)
        lean = hypot(way[0], way[1]) / way[2]
        far = STANDOFF * hypot(1.0, lean) + TILT.coper.torch_width / 2 * lean
        tips.append(tuple(p + far * q for p, q in zip((*at, 0.0), way, strict=True)))
    found: list[Point] = []
    for (a, b), (ta, tb) in zip(pairwise(tips[1:]), pairwise(turns[1:]), strict=True):
        for k in range(11):
            x, y, z = (p + k / 10 * (q - p) for p, q in zip(a, b, strict=True))
            way = torch_way(*(p + k / 10 * (q - p) for p, q in zip(ta, tb, strict=True)))
            found.append((x - (z + depth) / way[2] * way[0], y - (z + depth) / way[2] * way[1]))
    return found


# --- by hand --------------------------------------------------------------------------------------


def test_one_cut_makes_an_edge_of_the_far_side_and_the_others_end_in_its_kerf() -> None:
    """At the surface it runs half a kerf of 2.4 / cos 40 beyond the edge at 800. What is before and
    behind it ends where lines half a kerf of 2.4 off both edges of a corner meet."""
    part = both_ends(Bevel(3, -40.0, WEB))
    assert made(part) == [
        ("near", 0.0, False), ("far", 40.0, True), ("far", 0.0, False), ("far", 0.0, False)
    ]  # fmt: skip
    (cut,) = passes(part)
    beyond = 800.0 + 1.2 / cos(radians(40.0))
    assert cut.path[1:] == (
        (pytest.approx(beyond), pytest.approx(86.8)), (pytest.approx(beyond), pytest.approx(363.2))
    )  # fmt: skip
    ends = [c.path[-1] for c in planned(part).operations if (c.face, c.kind) == ("v", "far")][1:]
    half = 1.2
    assert sorted(ends) == [
        (pytest.approx(800.0 + half), pytest.approx(90.0 - half)),
        (pytest.approx(800.0 + half), pytest.approx(360.0 + half)),
    ]  # fmt: skip
    assert not manual_rows(planned(part))
    assert not found(program_of(part, TILT), part)
    assert solid_codes(part) <= {"solid-rounded", "solid-square"}


@pytest.mark.parametrize(("angle", "land"), [(30.0, 2.0), (-30.0, 0.0)])
def test_round_a_hole_the_torch_cuts_a_cone(angle: float, land: float) -> None:
    """At both faces and all between two places of the program: the cone less half a kerf."""
    part = holed(CIRCLE, angle, land)
    (cut,) = passes(part)
    assert (cut.kind, cut.lower, cut.path[1]) == ("inner", angle < 0.0, cut.path[-1])
    for depth in (0.0, WEB):
        off = ((WEB - (land or WEB) if angle < 0.0 else WEB - land) - depth) * tan(radians(angle))
        wanted = 60.0 + off - cut.row.kerf / 2 / cos(radians(angle))
        for place in feet(cut, depth):
            assert dist(place, (400.0, 225.0)) == pytest.approx(wanted, abs=0.02)
    square = [c for c in planned(part).operations if c.kind == "inner" and not c.bevel]
    assert len(square) == (angle > 0.0)  # one cut makes a hole that is bevelled up to the surface
    assert not found(program_of(part, TILT), part)


@pytest.mark.parametrize(
    ("end", "angle", "land"),
    [
        (tuple(Line(HOLLOW[0].point(k / 6), HOLLOW[0].point((k + 1) / 6)) for k in range(6)),
         35.0, 1.0),
        (tuple(Line(HOLLOW[0].point(k / 6), HOLLOW[0].point((k + 1) / 6)) for k in range(6)),
         -35.0, 0.0),
        ((BSpline(3, ((800.0, 90.0), (770.0, 180.0), (830.0, 270.0), (800.0, 360.0)),
                  (0.0,) * 4 + (1.0,) * 4),), 35.0, 1.0),
        ((EllipseArc((760.0, 225.0), (0.0, 135.0 / cos(pi / 6)), 0.4, 210.0, 120.0),), -35.0, 0.0),
    ],
    ids=["lines, near side", "lines, up to the surface", "spline", "ellipse"],
)  # fmt: skip
def test_the_ruled_surface_lies_beside_any_curve(
    end: tuple[Curve, ...], angle: float, land: float
) -> None:
    """At both faces of the web each place of the pass is as far off the drawn end as the bevel and
    half a kerf ask for, between the ends of its blocks too."""
    part = webbed(list(end), *(Bevel(3 + k, angle, land) for k in range(len(end))))  # type: ignore[arg-type]
    (cut,) = passes(part)
    places = [c.point(k / 500) for c in end for k in range(501)]
    low, high = end[0].start[1], end[-1].end[1]
    # Beside lines their planes count, which go on straight at both ends.
    lines = [LineString([c.start, c.end]) for c in end] if len(end) > 1 else []
    drawn = LineString(places)
    for depth in (0.0, WEB):
        over = WEB - (land or (WEB if angle < 0.0 else 0.0)) - depth
        off = over * tan(radians(angle)) - cut.row.kerf / 2 / cos(radians(angle))
        seen = 0
        for x, y in feet(cut, depth):
            if not low + 12.0 < y < high - 12.0:
                continue
            if lines:  # of a hollow end the plane that is farthest, on the steel's side of it
                signed = []
                for line in lines:
                    (xa, ya), (xb, yb) = line.coords
                    signed.append(((xb - xa) * (y - ya) - (yb - ya) * (x - xa)) / line.length)
                apart = max(signed)
            else:
                near = drawn.interpolate(drawn.project(Place(x, y)))
                apart = drawn.distance(Place(x, y)) * (1.0 if x < near.x else -1.0)
            assert apart == pytest.approx(off, abs=0.025)
            seen += 1
        assert seen > 50
    assert not manual_rows(planned(part))
    assert not found(program_of(part, TILT), part)


def test_what_is_drawn_by_lines_is_the_part_as_a_solid() -> None:
    part = holed(facets(50.0, 40.0, 24), 40.0, 0.0, face="h")  # seen from v up to the surface
    (cut,) = passes(part)
    assert cut.lower
    assert len({*cut.turns}) > 24
    text = program_of(part, TILT)
    assert found(text, holed(facets(50.0, 40.0, 24), 40.0, 2.0, face="h"))
    assert not solid_codes(part)


# --- what stays manual work -----------------------------------------------------------------------

FLANGE: list[Point] = [(0.0, 0.0), (800.0, 0.0), (800.0, 190.0), (0.0, 190.0)]
CHAMFER: list[Point] = [(0.0, 0.0), (800.0, 0.0), (800.0, 150.0), (760.0, 190.0), (0.0, 190.0)]


def of_flange(bevel: Bevel, points: list[Point] = FLANGE) -> Part:
    return part_of(prepared(bevel, points=points), profile=IPE450, length=800.0)


MANUAL: list[tuple[Part, str]] = [
    (holed(CIRCLE, -30.0, 5.0), "the slug falls"),
    (holed(CIRCLE, 46.0, 2.0), "leans by 45 degrees at most"),
    (holed((Arc((400.0, 225.0), 6.5, 0.0, 180.0), Arc((400.0, 225.0), 6.5, 180.0, 180.0)),
           -44.0, 0.0), "no room for the kerf"),
    (both_ends(Bevel(3, -40.0, 8.4)), "no arc stands"),
    (of_flange(Bevel(1, -30.0, 5.0)), "behind its flange the web stands"),
    (of_flange(Bevel(2, -30.0, 0.0)), "far side of an edge of the bar"),
    (of_flange(Bevel(2, 30.0, 2.0)), "A would have to reach 120"),
    (of_flange(Bevel(2, -30.0, 0.0), CHAMFER), "go on in the air"),
    (replace(holed(CIRCLE, 30.0, 2.0), features=(
        Contour("v", "inner", polygon([(300.0, 180.0), (500.0, 180.0), (500.0, 270.0),
                                       (300.0, 270.0)]), AT, bevels=(Bevel(0, 30.0, 0.0),)),
    )), "would cut the part"),
    (replace(holed(CIRCLE, 30.0, 2.0), features=(
        replace(next(holed(CIRCLE, 30.0, 2.0).contours), face="u", curves=(
            Arc((400.0, 45.0), 20.0, 0.0, 180.0), Arc((400.0, 45.0), 20.0, 180.0, 180.0))),
    )), "A would have to reach 120"),
]  # fmt: skip


@pytest.mark.parametrize(("part", "why"), MANUAL, ids=[why for _, why in MANUAL])
def test_what_stays_manual_work_is_told_with_its_reason(part: Part, why: str) -> None:
    assert not passes(part)
    assert reasons(part)
    assert [reason for reason in reasons(part) if why not in reason] == []
    assert len(manual_rows(planned(part))) == sum(len(c.bevels) for c in part.contours)
    said = verify(part)
    assert not errors_in(said)


def verify(part: Part) -> list:  # type: ignore[type-arg]
    from beamcam.checks.coping import verify_coping

    said = verify_coping(program_of(part, TILT), (part,), TILT, (), "JOB")
    assert "verify-by-hand" in {d.code for d in said}
    return list(said)


def test_the_edge_of_a_cope_is_left_beside_an_end_that_is_made() -> None:
    """The edge of a cope beside the end of the web, where the torch would lean to its flange."""
    part = both_ends(Bevel(2, -40.0, WEB), Bevel(3, -40.0, WEB))
    assert len(passes(part)) == 1
    assert reasons(part) == ["the torch or its holder would meet a flange"]
    assert not found(program_of(part, TILT), part)


# --- strangers and wrong programs -----------------------------------------------------------------


@given(st.integers(0, 20000))
@settings(max_examples=examples(5), deadline=None)
@pytest.mark.parametrize("random_part", [random_cut_out, random_end])
def test_random_parts_are_planned_and_none_is_refused(random_part, seed: int) -> None:  # type: ignore[no-untyped-def]
    part = random_part(seed)
    text = coping_faults.program_of(planned(part), job_of(part, TILT))
    assert not found(text, part)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", [*range(30), 37, 50])
@pytest.mark.parametrize("random_part", [random_cut_out, random_end])
def test_the_solid_of_random_parts_is_the_part(random_part, seed: int) -> None:  # type: ignore[no-untyped-def]
    part = random_part(seed)
    assert not errors_in(solid_faults(program_of(part, TILT), Request((part,), TILT), None))


def test_wrong_programs_are_refused() -> None:
    """Of an end of four lines that one pass makes, every class that it has something for."""
    end = [Line(HOLLOW[0].point(k / 4), HOLLOW[0].point((k + 1) / 4)) for k in range(4)]
    part = webbed(list(end), *(Bevel(3 + k, -40.0, WEB) for k in range(4)))
    plan, job = planned(part), job_of(part, TILT)
    right = coping_faults.program_of(plan, job)
    assert not found(right, part)
    chance, tried = random.Random(3), []
    for name, of_plan in BEVEL_PLANS.items():
        wrong = of_plan(plan, chance)
        if wrong is not None:
            tried.append(name)
            assert found(coping_faults.program_of(wrong, job), part), name
    for name, of_text in BEVEL_TEXTS.items():
        lines = of_text(right.split("\n"), chance)
        assert lines is not None
        assert found("\n".join(lines), part), name
    for name, text in coping_faults.square_faults(part, plan, job):
        tried.append(name)
        assert "verify-coping-passes" in found(text, part), name
    wanted = {"bevel through the wall left out", "square cut short of a bevel",
              "bevel cut square behind", "bevel cut square before"}  # fmt: skip
    assert wanted <= {*tried}


def test_a_sample_has_cut_outs_an_end_up_to_the_surface_and_one_drawn_by_lines() -> None:
    part = sample("sleeve")
    assert [(c.kind, c.lower) for c in passes(part)] == [
        ("inner", True), ("inner", False), ("near", False), ("far", True)
    ]  # fmt: skip
    assert not manual_rows(planned(part))
    assert not found(program_of(part, TILT), part)


def test_a_cut_beside_a_bevel_through_the_wall_comes_behind_it() -> None:
    part = both_ends(Bevel(3, -40.0, WEB))
    plan = planned(part)
    (cut,) = (c for c in plan.operations if c.bevel)
    rest = [c for c in plan.operations if c is not cut]
    k = next(k for k, c in enumerate(rest) if (c.face, c.kind) == ("v", "far"))
    late = replace(plan, operations=(*rest[: k + 1], cut, *rest[k + 1 :]))
    text = coping_faults.program_of(late, job_of(part, TILT))
    assert "verify-coping-passes" in found(text, part)
