"""Skew ends of profiles: hand-worked figures, laws, and what a torch cannot make of them."""

import random
import re
from collections.abc import Callable
from math import cos, radians, sin, tan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.checks.coping.section import CoperSection
from beamcam.checks.coping.skew import skew_ends
from beamcam.errors import PlanError, errors_in
from beamcam.machine import Machine, load
from beamcam.machine.coper import torch_way
from beamcam.model.part import Bevel, EndCuts, Part, Profile
from beamcam.model.plan import CopeCut, CopePlan
from beamcam.model.request import Request
from beamcam.pipeline import post, read_file
from beamcam.planning.coping.ends import planes_of
from beamcam.planning.coping.plan import plan_coping
from beamcam.planning.manual_list import manual_rows
from beamcam.solid.opinion import solid_faults
from benchmarks import coping_faults, coping_plans
from tests.conftest import SAMPLES, examples, sampled
from tests.random_copes import CEES, random_mitre
from tests.unit.coping.samples import COPER, IPE300, faults, job_of, outline, part_of, program_of

BEVEL = load("coper-tilt-linuxcnc")


def skew(profile: Profile = IPE300, length: float = 1500.0, **cuts: float) -> Part:
    return replace(part_of(profile=profile, length=length), cuts=EndCuts(**cuts))


def planned(part: Part, machine: Machine = BEVEL) -> CopePlan:
    return plan_coping((part,), machine)


def cut_at(plan: CopePlan, kind: str, face: str) -> CopeCut:
    (cut,) = [c for c in plan.operations if c.kind == kind and c.face == face]
    return cut


def refused(part: Part, machine: Machine = BEVEL) -> set[str]:
    with pytest.raises(PlanError) as caught:
        planned(part, machine)
    return {d.code for d in caught.value.diagnostics}


def found(text: str, part: Part, machine: Machine = BEVEL) -> set[str]:
    return {d.code for d in faults(text, part, machine)}


def mitre() -> Part:
    (part,) = read_file(str(SAMPLES / "coping" / "rafter.nc1")).parts
    return part


# --- plan -----------------------------------------------------------------------------------------


def test_the_torch_is_tilted_in_the_plane_of_the_end() -> None:
    plan = planned(skew(web_end=30.0))
    # x = 1500 - y tan 30: the lower flange reaches the length at its outside, y 0.
    low, high = cut_at(plan, "far", "u"), cut_at(plan, "far", "o")
    assert (low.b_deg, high.b_deg) == (pytest.approx(30.0), pytest.approx(-30.0))
    # Half a kerf off the plane is half / cos(30) along the bar.
    assert low.path[2][0] == pytest.approx(1500.0 + low.row.kerf / 2 / cos(radians(30.0)))
    top = 1500.0 - 300.0 * tan(radians(30.0))
    assert high.path[2][0] == pytest.approx(top + high.row.kerf / 2 / cos(radians(30.0)))
    # Through flange and root, 24.56 mm square to it.
    assert low.thickness == pytest.approx(24.562 / cos(radians(30.0)), abs=0.01)
    assert low.row.up_to == 32.0
    web = cut_at(plan, "far", "v")
    assert web.b_deg == 0.0
    assert all(x == pytest.approx(1500.0 - y * tan(radians(30.0)) + 1.1 / cos(radians(30.0)))
               for x, y in web.path[1:])  # fmt: skip


def test_a_flange_angle_tilts_the_torch_over_the_web() -> None:
    plan = planned(skew(flange_start=20.0))
    # x = 150 tan 20 - z tan 20; the web's front stands at z 78.55.
    web, flange = cut_at(plan, "near", "v"), cut_at(plan, "near", "o")
    assert web.b_deg == pytest.approx(-20.0)
    front = (150.0 - 78.55) * tan(radians(20.0))
    assert web.path[1][0] == pytest.approx(front - web.row.kerf / 2 / cos(radians(20.0)))
    assert flange.b_deg == 0.0
    ends = [(150.0 - z) * tan(radians(20.0)) - flange.row.kerf / 2 / cos(radians(20.0))
            for _, z in flange.path[2:-1]]  # fmt: skip
    assert [x for x, _ in flange.path[2:-1]] == [pytest.approx(x) for x in ends]


def test_a_compound_end_tilts_it_over_all_walls() -> None:
    plan = planned(skew(web_end=15.0, flange_end=-25.0))
    tilts = {c.face: c.b_deg for c in plan.operations if c.kind == "far"}
    assert tilts == {
        "v": pytest.approx(25.0), "o": pytest.approx(-15.0), "u": pytest.approx(15.0)
    }  # fmt: skip
    assert not [d for d in plan.remarks if d.code == "plan-coping-slant"]


def test_the_way_of_the_torch_lies_in_the_plane_of_the_end() -> None:
    part = skew(web_end=15.0, flange_end=-25.0)
    _, end = planes_of(part)
    for face, a_deg in (("o", -90.0), ("v", 0.0), ("u", 90.0)):
        x, y, z = torch_way(a_deg, cut_at(planned(part), "far", face).b_deg)
        assert x == pytest.approx(-end.by_y * y - end.by_z * z)


@pytest.mark.parametrize(("machine", "angle"), [(COPER, 30.0), (BEVEL, 50.0)])
def test_without_enough_tilt_it_is_cut_square_and_told(machine: Machine, angle: float) -> None:
    slope = tan(radians(angle))
    plan = planned(skew(web_end=angle), machine)
    assert not any(c.b_deg for c in plan.operations)
    low, high = cut_at(plan, "far", "u"), cut_at(plan, "far", "o")
    assert low.path[2][0] == pytest.approx(1500.0 + low.row.kerf / 2)
    # Below the upper flange the plane reaches farthest where the pass through the root ends.
    deep = 300.0 - 25.0
    xs = [x for x, _ in high.path[1:]]
    assert max(xs) == pytest.approx(1500.0 - slope * deep + high.row.kerf / 2, abs=0.1)
    (told,) = [d for d in plan.remarks if d.code == "plan-coping-slant"]
    assert float(str(told["found"])) == pytest.approx(slope * 25.05, abs=0.02)
    assert "v, o, u" in told.message


def test_the_outlines_of_such_an_end_are_manual_work() -> None:
    part = mitre()
    assert not manual_rows(planned(part))
    rows = manual_rows(planned(part, COPER))
    assert [(row["kind"], row["face"]) for row in rows] == [
        ("outline", "v"), ("outline", "o"), ("outline", "u")
    ]  # fmt: skip


@pytest.mark.parametrize(("code", "face"), [("I", "h"), ("C", "v")])
def test_an_outline_on_the_far_side_of_such_a_web_is_manual_work_too(code: str, face: str) -> None:
    """That of a C lies there as the C lies on its lips."""
    ends = [(0.0, 0.0), (1500.0, 0.0), (1500.0 - 300.0 * tan(radians(20.0)), 300.0), (0.0, 300.0)]
    profile = IPE300 if code == "I" else CEES[1]  # both 300 mm high
    part = replace(skew(profile, web_end=20.0), features=(outline(face, ends),))
    assert [row["face"] for row in manual_rows(planned(part, COPER))] == [face]
    post((part,), COPER)


def test_bevels_that_an_end_shows_are_made_with_it() -> None:
    part = skew(web_end=30.0)
    drawn = [(0.0, 0.0), (1500.0, 0.0), (1500.0, 150.0), (0.0, 150.0)]
    flange = replace(outline("u", drawn), bevels=(Bevel(1, -30.0, 0.0),))
    other = replace(flange, bevels=(Bevel(1, -40.0, 0.0),))
    for contour, left in ((flange, 0), (other, 1)):
        plan = planned(replace(part, features=(contour,)))
        assert len(manual_rows(plan)) == left
        text = coping_faults.program_of(plan, job_of(plan.pieces[0].part, BEVEL))
        said = verify_coping(text, (replace(part, features=(contour,)),), BEVEL, (), "JOB")
        assert [d.code for d in said] == ["verify-by-hand"] * left


def test_an_end_that_only_the_outline_has_skew_is_cut_so() -> None:
    points = [(0.0, 0.0), (1500.0, 0.0), (1500.0 - 300.0 * tan(radians(30.0)), 300.0), (0.0, 300.0)]
    drawn = replace(part_of(outline("v", points), length=1500.0))
    plan, header = planned(drawn), planned(skew(web_end=30.0))
    assert [c.path for c in plan.operations] == [
        tuple((pytest.approx(x, abs=1e-3), pytest.approx(y, abs=1e-3)) for x, y in c.path)
        for c in header.operations
    ]
    assert "plan-cut-from-contour" in {d.code for d in plan.remarks}
    assert not found(program_of(drawn, BEVEL), drawn)


def test_what_is_refused_of_skew_ends() -> None:
    assert refused(skew(length=300.0, web_start=45.0, web_end=-45.0)) == {"plan-coping-crossed"}
    square = outline("v", [(0.0, 0.0), (1500.0, 0.0), (1500.0, 300.0), (0.0, 300.0)])
    part = replace(skew(web_end=30.0), features=(square,))
    assert refused(part) == {"plan-cut-denied", "plan-coping-beyond"}
    half = 1500.0 - 200.0 * tan(radians(30.0)), 200.0
    cope = outline("v", [(0.0, 0.0), (1500.0, 0.0), half, (1300.0, 200.0), (1300.0, 300.0),
                         (0.0, 300.0)])  # fmt: skip
    assert "plan-coping-root" in refused(replace(skew(web_end=30.0), features=(cope,)))


def test_a_web_too_deep_for_a_tilted_torch_is_cut_square() -> None:
    wide = Profile("I", "HEB300", 300.0, 300.0, 19.0, 11.0, 27.0)
    # 200 cos 40 - 60 sin 40 - 20 is 94.6 mm; the web lies 144.5 mm below the edges.
    plan = planned(skew(profile=wide, flange_end=40.0))
    assert "plan-coping-slant" in {d.code for d in plan.remarks}
    assert not any(c.b_deg for c in plan.operations)
    assert not found(program_of(plan.pieces[0].part, BEVEL), plan.pieces[0].part)


# --- read-back ------------------------------------------------------------------------------------


@given(st.integers(0, 5000), st.sampled_from([BEVEL, COPER]))
@settings(max_examples=examples(40))
def test_no_random_mitre_that_is_planned_is_refused(seed: int, machine: Machine) -> None:
    part = random_mitre(seed)
    try:
        plan = plan_coping((part,), machine)
    except PlanError:
        return
    assert not found(coping_faults.program_of(plan, job_of(part, machine)), part, machine)


@given(st.integers(0, 5000))
@settings(max_examples=examples(60))
def test_both_sides_know_the_same_planes(seed: int) -> None:
    part = random_mitre(seed)
    if part.profile.code == "T":
        return
    section = CoperSection(part.profile)
    for mine, other in zip(planes_of(part), skew_ends(part, section), strict=True):
        if other is None:
            assert not mine.is_skew
            continue
        for y0, z0, y1, z1 in section.plates():
            assert mine.x(y0, z1) == pytest.approx(other.x(y0, z1))
            assert mine.x(y1, z0) == pytest.approx(other.x(y1, z0))


def test_the_tip_stands_off_so_that_its_edge_keeps_the_height() -> None:
    assert BEVEL.coper is not None
    # 3 / cos 30 + 6 tan 30
    assert BEVEL.coper.standoff(3.0, -30.0) == pytest.approx(6.928, abs=1e-3)
    assert BEVEL.coper.standoff(3.0, 0.0) == 3.0
    x, y, z = torch_way(90.0, 30.0)
    assert (x, y, z) == (pytest.approx(0.5), pytest.approx(-0.8660254), pytest.approx(0.0))


def test_a_wrong_tilt_is_refused() -> None:
    part = mitre()
    wrong = dict(coping_faults.faults(part, BEVEL, random.Random(1)))
    for name in (*coping_plans.TILTS, "cut square"):
        assert found(wrong[name], part), name


WORDS: list[tuple[str, Callable[[str], str]]] = [
    ("verify-coping-tilt", lambda text: text.replace("G1 X", "G1 B3 X", 90)),
    ("verify-coping-tilt", lambda text: re.sub(r"B-?35", "B46", text)),
    ("verify-coping-torch", lambda text: text.replace("G0 A0 B0", "G0 A0", 1)),
    ("verify-coping-limit", lambda text: re.sub(r"B-?35", "B50", text)),
]


def test_words_of_b() -> None:
    part = mitre()
    text = program_of(part, BEVEL)
    for code, change in WORDS:
        assert code in found(change(text), part)


def test_a_square_program_of_a_skew_part_is_refused() -> None:
    part = skew(web_end=20.0)
    square = program_of(part_of(length=1500.0), BEVEL)
    assert found(square, part) >= {"verify-coping-left"}
    assert found(program_of(part, COPER), part, COPER) == set()
    assert found(program_of(part, BEVEL), part_of(length=1500.0)) >= {"verify-coping-hurt"}


def test_an_outline_beyond_a_skew_end_is_not_made() -> None:
    part = skew(web_end=20.0)
    drawn = outline("o", [(0.0, 0.0), (1500.0, 0.0), (1500.0, 150.0), (0.0, 150.0)])
    said = found(program_of(part, BEVEL), replace(part, features=(drawn,)))
    assert "verify-coping-short" in said


def test_a_torch_whose_places_are_those_of_its_axes() -> None:
    words = replace(BEVEL.words, turn=("G0 X{x} Y{y} Z{z} A{a} B{b}",))
    assert BEVEL.coper is not None
    pivoted = replace(BEVEL, coper=replace(BEVEL.coper, tcp=False, pivot=250.0), words=words)
    limits = [replace(a, min=-2000.0, max=20000.0) if a.moves not in "AB" else a
              for a in BEVEL.axes]  # fmt: skip
    pivoted = replace(pivoted, axes=tuple(limits))
    part = skew(web_end=25.0, flange_start=-30.0)
    text = program_of(part, pivoted)
    assert found(text, part)
    # Over the web the axes stand 250 mm off the tip along the torch.
    tips, axes = (
        next(line for line in program.split("(near end on face v)")[1].split("\n") if "G1" in line)
        for program in (program_of(part, BEVEL), text)
    )
    place, axis = ([float(v) for v in re.findall(r"[XYZ](-?[\d.]+)", one)] for one in (tips, axes))
    assert axis[0] - place[0] == pytest.approx(250.0 * sin(radians(30.0)), abs=1e-3)
    assert axis[2] - place[2] == pytest.approx(250.0 * cos(radians(30.0)), abs=1e-3)


# --- solids ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", sampled(range(12), 5))
@pytest.mark.parametrize("machine", [BEVEL, COPER])
def test_the_solid_agrees(seed: int, machine: Machine) -> None:
    part = random_mitre(seed)
    try:
        text = program_of(part, machine)
    except PlanError:
        return
    said = solid_faults(text, Request((part,), machine), None)
    assert {d.code for d in said} <= {"solid-square", "solid-rounded"}, [d.message for d in said]
    if all(c.b_deg for c in planned(part, machine).operations if c.root):
        assert not said or machine is COPER


def test_the_solid_sees_a_wrong_tilt() -> None:
    part = mitre()
    text = program_of(part, BEVEL)
    wrong = text.replace("B-35", "B-33")
    assert wrong != text
    assert errors_in(solid_faults(wrong, Request((part,), BEVEL), None))
