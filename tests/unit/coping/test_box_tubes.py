"""Rectangular tubes: planned unrolled, cut in inverse time, read back, by strangers."""

import random
import re
from itertools import pairwise
from math import asin, atan2, cos, degrees, dist, hypot, pi, radians, sin, tan
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

import beamcam
from beamcam.cli import main
from beamcam.errors import PlanError, Severity, VerifyError
from beamcam.machine import Machine
from beamcam.machine.coper import TubeCorner
from beamcam.machine.overlay import with_section
from beamcam.model.part import Contour, EndCuts, Face, Feature, Hole, Part, Profile, Slot
from beamcam.model.request import Request
from beamcam.model.surface import around
from beamcam.pipeline import read_file
from beamcam.planning.manual_list import manual_rows
from beamcam.recovery import recover
from beamcam.solid.kernel import kernel
from beamcam.solid.opinion import solid_faults
from beamcam.solid.part_solid import part_solid
from benchmarks import coping_faults
from tests.conftest import SAMPLES, THIRD_PARTY, examples, sampled
from tests.random_boxes import mitred, over_corner, random_box
from tests.rs274 import INI, interpreted, needs_rs274
from tests.unit.coping import samples
from tests.unit.coping.samples import AT, COPER, job_of
from tests.unit.coping.test_tubes import TUBE, found, planned, program_of

SHS = Profile("M", "SHS100*6", 100.0, 100.0, 6.0, 6.0, 10.0)
RHS = Profile("M", "RHS120*80*5", 120.0, 80.0, 5.0, 5.0, 10.0)
ARC = 10 * pi / 2
TURN = 4 * 80.0 + 4 * ARC  # of SHS
HOLE = Hole("v", 200.0, 60.0, 26.0, AT)


def tube(
    *features: Feature, profile: Profile = SHS, length: float = 500.0, cuts: EndCuts | None = None
) -> Part:
    return Part(
        "T1", profile, length, AT, features=features, grade="S235JR", cuts=cuts or EndCuts()
    )


def with_corners(*rows: TubeCorner) -> Machine:
    assert TUBE.coper is not None
    return replace(TUBE, coper=replace(TUBE.coper, corners=rows))


# --- by hand --------------------------------------------------------------------------------------


def test_a_tube_is_cut_to_length_all_round() -> None:
    plan = planned(tube())
    assert [cut.kind for cut in plan.operations] == ["near", "far"]
    for cut, x in zip(plan.operations, (-1.0, 501.0), strict=True):
        assert [p[0] for p in cut.path[1:]] == pytest.approx([x] * (len(cut.path) - 1))
        assert abs(cut.path[1][1] - cut.path[-1][1]) == pytest.approx(TURN)


def test_the_blocks_of_a_face_and_a_corner_worked_by_hand() -> None:
    """An SHS of 100 with corners of 10, its seam in the middle of the face that lies below."""
    lines = program_of(tube()).splitlines()
    first = lines.index("G93")
    # 3 mm down and 8.05 mm along at 4200 mm/min, then 40 mm across half the face.
    assert lines[first + 1] == "G1 X20.95 Y0 Z53 A-270 F1400"
    assert lines[first + 2] == "G1 X29 Y0 Z53 A-270 F521.7391"
    assert lines[first + 3] == "G1 X29 Y-40 Z53 A-270 F105"
    # The corner: its middle goes round the axis at 40 sqrt 2; sagitta 0.01 asks for 42 blocks.
    corner = [line.split() for line in lines[first + 4 : first + 4 + 42]]
    angles = [float(words[4][1:]) for words in corner]
    count = angles.index(-180.0) + 1
    assert count == 42
    for words in corner[:count]:
        y, z, a, f = (float(word[1:]) for word in words[2:])
        turned = radians(a + 270.0)
        assert y == pytest.approx(hypot(40, 40) * -cos(pi / 4 + turned), abs=1e-3)
        assert z == pytest.approx(hypot(40, 40) * sin(pi / 4 + turned) + 13.0, abs=1e-3)
        assert f == pytest.approx(4200.0 * count / ARC, rel=1e-4)


def test_a_corner_goes_as_fast_on_the_surface_as_a_face() -> None:
    """X, Y and Z go 88.9 mm where the surface has 15.7: F by them would cut at 18 %."""
    moves = [
        [float(word[1:]) for word in line.split()[1:]]
        for line in program_of(tube()).splitlines()
        if line.startswith("G1")
    ][2:]
    corner = [(a, b) for a, b in pairwise(moves) if a[3] != b[3]][:42]
    assert abs(corner[-1][1][3] - corner[0][0][3]) == pytest.approx(90.0)
    assert sum(dist(a[:3], b[:3]) for a, b in corner) == pytest.approx(88.9, abs=0.1)
    assert sum(4200.0 / b[4] for _, b in corner) == pytest.approx(ARC, abs=1e-3)


def test_a_mitre_in_the_header_is_cut_where_the_wall_reaches_farthest() -> None:
    """45 degrees in the view of v: x = 500 - Y at the end that reaches to 500 at face u."""
    part = tube(cuts=EndCuts(web_end=45.0))
    plan = planned(part)
    far = plan.operations[-1].path[1:]
    way = around(SHS)

    def x_at(s: float) -> float:
        return min((abs(u - s), x) for x, u in far)[1]

    # On u outside, on o 6 mm deeper; on v and h along the line, kerf 2 at 45 degrees beside it.
    middle = way.on_face("v").s(50.0)
    assert x_at(0.0) == pytest.approx(501.0, abs=0.05)
    assert x_at(way.on_face("o").s(50.0)) == pytest.approx(500.0 - 94.0 + 1.0, abs=0.05)
    beside = [(x, s) for x, s in far if abs(s - middle) < 40.0]
    assert beside == [] or all(
        x == pytest.approx(500 - 50 - (s - middle) + 2**0.5, abs=0.05) for x, s in beside
    )
    (said,) = [d for d in plan.remarks if d.code == "plan-coping-slant"]
    assert "up to 6.00 mm off at the inside of the walls u, o" in said.message


def test_a_mitre_that_is_drawn_is_the_same_and_on_the_list_of_manual_work() -> None:
    drawn = tube(*mitred(SHS, 500.0, 45.0, True))
    as_header = planned(tube(cuts=EndCuts(web_end=45.0))).operations[-1].path
    plan = planned(drawn)
    far = plan.operations[-1].path
    assert [x for x, _ in far[1::8]] == pytest.approx([x for x, _ in as_header[1::8]], abs=0.02)
    assert [row["face"] for row in manual_rows(plan)] == ["o", "u"]
    program_of(drawn)  # the read-back has the same on its list


@given(st.integers(-45, 45), st.booleans(), st.integers(25, 60), st.integers(12, 20))
@settings(max_examples=examples(20), deadline=None)
def test_a_slot_may_begin_at_a_skew_end(angle: int, by_web: bool, low: int, wide: int) -> None:
    """For a gusset, in both webs: the end is cut in its plane, the slot is as long as drawn."""
    drawn, y0, y1 = [], float(low), float(low + wide)
    for one in mitred(SHS, 500.0, angle, by_web):
        assert isinstance(one, Contour)
        first, near, far, last = (curve.start for curve in one.curves)
        slope = (far[0] - near[0]) / 100.0
        mouth = [(near[0] + slope * y0, y0), (380.0, y0), (380.0, y1), (near[0] + slope * y1, y1)]
        ring = [first, near, *(mouth if one.face in "vh" else []), far, last]
        drawn.append(samples.outline(one.face, ring))
    part = tube(*drawn)
    whole = planned(tube(*mitred(SHS, 500.0, angle, by_web))).operations[-1].path
    far_end = planned(part).operations[-1].path
    assert max(x for x, _ in far_end) == pytest.approx(max(x for x, _ in whole), abs=0.05)
    on_web = [
        x for x, s in far_end if abs(s - around(SHS).on_face("v").s((y0 + y1) / 2)) < 0.4 * wide
    ]
    assert min(on_web) == pytest.approx(381.0, abs=0.1)
    program_of(part)  # the read-back has the same


def test_a_corner_between_a_slope_and_a_square_end_follows_the_slope() -> None:
    """A window that leans in the view of v: over the corner x goes as the view of v says."""
    part = tube(*over_corner(SHS, 1, 200.0, 60.0, 10.0))
    inner = planned(part).operations[0].path[1:]
    corner = around(SHS).legs[3]
    slope = 10.0 / 25.0  # of the sides on v, from its upper edge on
    seen = 0
    for x, s in inner:
        turned = (s - corner.begin) / 10.0
        if 0.1 < turned < pi / 2 - 0.1 and x < 230.0:
            deep = 10.0 - 10.0 * sin(turned)  # below face o
            lean = atan2(slope * cos(turned), 1.0)
            assert x == pytest.approx(200.0 - slope * deep + 1.0 / cos(lean), abs=0.02)
            seen += 1
    assert seen > 5


@pytest.mark.parametrize("corner", range(4))
def test_a_window_over_each_corner_is_cut_once(corner: int) -> None:
    part = tube(*over_corner(RHS, corner, 200.0, 40.0, 0.0), profile=RHS)
    cuts = planned(part).operations
    assert [cut.kind for cut in cuts] == ["inner", "near", "far"]
    assert not found(program_of(part), part)


# --- into a corner --------------------------------------------------------------------------------


def test_a_hole_that_reaches_into_a_corner_worked_by_hand() -> None:
    """A hole of 26 whose lowest place is 7 mm above the edge, 3 of them in a corner of 10: there it
    lies at arcsin 0.3 of the round; 3 / 10 of the wall of 6 are what it is narrower inside."""
    plan = planned(tube(Hole("v", 200.0, 20.0, 26.0, AT)))
    (said,) = [d for d in plan.remarks if d.code == "plan-coping-reaches"]
    assert "of face v that reaches 3.00 mm into a corner" in said.message
    assert "up to 1.80 mm of steel more" in said.message
    border = around(SHS).on_face("v").begin  # half a face and a corner from the middle of u
    assert border == pytest.approx(40.0 + ARC)
    lowest = min(s for _, s in plan.operations[0].path[1:])
    assert lowest == pytest.approx(border - 10.0 * asin(0.3) + 1.0, abs=0.02)


REACHING = st.tuples(
    st.sampled_from(["v", "h", "o", "u"]), st.booleans(), st.floats(0.2, 6.5), st.booleans()
)


@given(st.lists(REACHING, min_size=1, max_size=3))
@settings(max_examples=examples(15))
def test_holes_and_slots_into_corners_are_read_back(
    drawn: list[tuple[Face, bool, float, bool]],
) -> None:
    features: list[Feature] = []
    for k, (face, high, into, is_slot) in enumerate(drawn):
        y = 10.0 + 12.0 - into
        y = SHS.face_width(face) - y if high else y
        x = 100.0 + 90.0 * k
        features.append(
            Slot(face, x, y, 24.0, 20.0, 0.0, 0.0, AT) if is_slot else Hole(face, x, y, 24.0, AT)
        )
    part = tube(*features)
    text = program_of(part)
    moved = replace(features[0], x=features[0].x + 1.0)  # type: ignore[call-arg, union-attr]
    assert found(text, tube(moved, *features[1:]))


@pytest.mark.exhaustive
@pytest.mark.parametrize("face", sampled("ovhu", 4))
def test_the_solid_and_the_recovery_agree_with_a_hole_in_a_corner(face: Face) -> None:
    part = tube(Hole(face, 200.0, 82.0, 26.0, AT), Hole(face, 300.0, 50.0, 26.0, AT))
    text = program_of(part)
    assert not solid_faults(text, Request((part,), TUBE))
    other = tube(Hole(face, 200.0, 80.0, 26.0, AT), Hole(face, 300.0, 50.0, 26.0, AT))
    assert solid_faults(text, Request((other,), TUBE))
    (back,) = recover(text, TUBE).parts
    holes = sorted((h.face, h.x, h.y, h.diameter) for h in back.holes)
    assert holes == [(face, 200.0, 82.0, 26.0), (face, 300.0, 50.0, 26.0)]


# --- refused --------------------------------------------------------------------------------------

REFUSED = [
    ("plan-coping-radius", tube(profile=replace(SHS, radius=60.0))),
    ("plan-section", tube(profile=Profile("M", "RHS400*200*8", 400.0, 200.0, 8.0, 8.0, 16.0))),
    ("plan-section-shape", tube(profile=Profile("M", "SHS", 100.0, 100.0, 60.0, 6.0, 60.0))),
    ("plan-coping-corner", tube(Hole("v", 200.0, 15.0, 26.0, AT))),
    ("plan-coping-corner", tube(Slot("o", 200.0, 89.0, 18.0, 30.0, 0.0, 0.0, AT))),
    ("plan-coping-corner", tube(*over_corner(SHS, 1, 200.0, 40.0, 0.0)[:1])),
    ("plan-coping-corner", tube(*over_corner(SHS, 1, 200.0, 40.0, 0.0)[:1],
                                *over_corner(SHS, 1, 205.0, 40.0, 0.0)[1:])),
    ("plan-cut-denied", tube(*mitred(SHS, 500.0, 45.0, True), cuts=EndCuts(web_end=30.0))),
    ("plan-coping-off", tube(Hole("v", 900.0, 60.0, 26.0, AT))),
    ("plan-tool", tube(Hole("u", 200.0, 60.0, 7.0, AT))),
]  # fmt: skip


@pytest.mark.parametrize(("code", "part"), REFUSED)
def test_what_cannot_be_made_is_refused(code: str, part: Part) -> None:
    with pytest.raises(PlanError) as caught:
        planned(part)
    assert {d.code for d in caught.value.diagnostics} == {code}


def test_corners_that_the_file_does_not_say_are_those_of_the_machine() -> None:
    bare = tube(HOLE, profile=replace(SHS, radius=0.0))
    rows = (TubeCorner(10.0, 2.5), TubeCorner(6.0, 10.0 / 6.0))
    machine = with_corners(*rows)
    assert planned(bare, machine).operations == planned(tube(HOLE)).operations
    text = program_of(bare, machine)
    assert not found(text, tube(HOLE), machine)
    assert found(text, bare, with_corners(TubeCorner(6.0, 2.0)))
    for radius in (0.0, 5.0):  # less than the wall is none
        thick = replace(SHS, flange_thickness=12.0, radius=radius)
        with pytest.raises(PlanError, match="plan-coping-radius"):
            planned(tube(profile=thick), machine)


@pytest.mark.parametrize(
    ("wall", "radius"),
    [(3.0, 6.0), (6.0, 12.0), (6.3, 15.75), (10.0, 25.0), (10.1, 30.3), (12.5, 37.5)],
)
def test_corners_that_nothing_else_says_are_those_of_the_shipped_table(
    wall: float, radius: float
) -> None:
    """EN 10219-2: 2 walls up to 6 mm, 2.5 above up to 10 mm, 3 above; told, in the program too."""
    size = replace(SHS, flange_thickness=wall, web_thickness=wall)
    for own in (0.0, wall - 0.1):  # less than the wall is none
        bare = tube(HOLE, profile=replace(size, radius=own))
        said = tube(HOLE, profile=replace(size, radius=radius))
        plan = planned(bare)
        assert plan.operations == planned(said).operations
        (told,) = [d for d in plan.remarks if d.code == "plan-coping-table-radius"]
        assert told.severity is Severity.WARNING
        assert f"taken as {radius:g} mm outside" in told.message
        assert "by --corner" in told.message
        text = program_of(bare)
        assert f"(CORNERS OF {radius:g} MM OUTSIDE BY THE MACHINES TABLE: MEASURE ONE)" in text
        assert "MACHINES TABLE" not in program_of(said)
        assert not found(text, bare)
        assert found(text, replace(bare, profile=replace(size, radius=1.1 * radius)))


def test_the_read_back_does_not_believe_the_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    bare = tube(HOLE, profile=replace(SHS, radius=0.0))
    monkeypatch.setattr("beamcam.machine.coper.Coper.outer_radius", lambda *_: 10.0)
    with pytest.raises(VerifyError, match="verify-coping-square"):
        program_of(bare)


def test_corners_that_neither_says_are_those_of_the_job() -> None:
    bare = tube(HOLE, profile=replace(SHS, radius=0.0))
    machine = with_section(with_corners(), 10.0, None)
    plan = planned(bare, machine)
    assert plan.operations == planned(tube(HOLE)).operations
    (said,) = [d for d in plan.remarks if d.code == "plan-coping-given-radius"]
    assert "taken as 10 mm outside, as --corner" in said.message
    text = program_of(bare, machine)
    assert {d.code for d in found(text, bare, with_corners())} == {"verify-coping-radius"}
    assert {d.code for d in found(text, bare, with_section(TUBE, 12.0, None))} == {
        "verify-coping-square"
    }
    # The file goes before the job, and that before the machine's table.
    both = with_section(with_corners(TubeCorner(6.0, 14.0 / 6.0)), 10.0, None)
    assert planned(bare, both).operations == plan.operations
    assert not found(text, bare, both)
    assert planned(tube(HOLE), with_section(both, 14.0, None)).operations == plan.operations
    assert with_section(COPER, 10.0, None) is COPER


def test_the_option_and_the_configuration(tmp_path: Path) -> None:
    part = SAMPLES / "coping" / "bare.nc1"
    program = tmp_path / "b.ngc"

    def run(*words: object) -> tuple[int, str]:
        done = CliRunner().invoke(main, [str(word) for word in words])
        return done.exit_code, done.stderr

    post = ("post", part, "--machine", "tube-linuxcnc", "-o", program)
    code, said = run(*post)
    assert (code, "plan-coping-table-radius" in said) == (0, True)
    code, said = run(*post, "--corner", "14")
    assert (code, "plan-coping-given-radius" in said) == (0, True)
    assert run("verify", program, "--against", part, "--corner", "14")[0] == 0
    assert "verify-coping-square" in run("verify", program, "--against", part)[1]
    (tmp_path / "beamcam.toml").write_text("corner = 14\n")
    assert run("verify", program, "--against", part, "--config", tmp_path / "beamcam.toml")[0] == 0
    machine = beamcam.load("tube-linuxcnc", corner=14)
    assert beamcam.post(beamcam.read(part).parts, machine).text == program.read_text()


def test_what_the_file_says_of_its_corners_comes_before_the_machine() -> None:
    machine = with_corners(TubeCorner(6.0, 3.0))
    assert planned(tube(), machine).operations == planned(tube()).operations


def test_an_axis_too_slow_for_the_corners_is_told() -> None:
    """4200 mm/min round 10 mm are 401 degrees a second; the chuck turns 180."""
    (said,) = [d for d in planned(tube()).remarks if d.code == "plan-coping-slow"]
    assert "axis chuck" in said.message
    assert f"{4200 * 180 / degrees(7.0):.0f} mm/min" in said.message
    wide = tube(profile=Profile("M", "SHS100*10", 100.0, 100.0, 10.0, 10.0, 40.0))
    assert not [d for d in planned(wide).remarks if d.code == "plan-coping-slow"]


# --- read back ------------------------------------------------------------------------------------


@given(st.integers(0, 5000))
@settings(max_examples=examples(25))
def test_random_tubes_are_planned_and_none_is_refused(seed: int) -> None:
    part = random_box(seed)
    assert not found(coping_faults.program_of(planned(part), job_of(part, TUBE)), part)


def test_wrong_programs_are_refused() -> None:
    part = tube(HOLE, *over_corner(RHS, 1, 280.0, 40.0, 0.0), *mitred(RHS, 500.0, 30.0, True),
                profile=RHS)  # fmt: skip
    for kind, text in [*coping_faults.faults(part, TUBE, random.Random(3))][::2]:
        assert found(text, part), kind


def test_wrong_walls_are_refused() -> None:
    whole = program_of(tube())
    assert {d.code for d in found(whole, tube(HOLE))} == {"verify-coping-left"}
    assert {d.code for d in found(program_of(tube(HOLE)), tube())} == {"verify-coping-hurt"}
    thicker = tube(profile=replace(SHS, web_thickness=9.0))
    assert {d.code for d in found(whole, thicker)} == {"verify-coping-feed"}
    rounder = tube(profile=replace(SHS, radius=11.0))
    assert {d.code for d in found(whole, rounder)} == {"verify-coping-square"}
    skew = tube(cuts=EndCuts(flange_end=10.0))
    assert found(whole, skew)
    assert found(program_of(skew), tube())


def test_contours_that_do_not_meet_at_a_corner_are_refused_by_the_read_back() -> None:
    part = tube(*over_corner(SHS, 1, 200.0, 40.0, 0.0)[:1])
    assert {d.code for d in found(program_of(tube()), part)} == {"verify-coping-corner"}


@pytest.mark.third_party
def test_a_real_tube_with_skew_ends_is_posted() -> None:
    path = THIRD_PARTY / "corpus" / "dstv" / "tluijken_dstv" / "0008-SE0009.nc1"
    (part,) = read_file(str(path)).parts
    assert not found(program_of(part), part)


# --- strangers ------------------------------------------------------------------------------------

MOVE = re.compile(r"STRAIGHT_(TRAVERSE|FEED)\(([^)]*)\)")


def burns(path: Path) -> list[list[tuple[float, ...]]]:
    """X, Y, Z and A of the strokes of the torch as rs274 prints them."""
    done = interpreted(path, ini=INI)
    assert done.returncode == 0, done.stderr
    strokes: list[list[tuple[float, ...]]] = []
    is_on, place = False, (0.0, 0.0, 0.0, 0.0)
    for line in done.stdout.splitlines():
        if "START_SPINDLE_CLOCKWISE" in line:
            is_on = True
            strokes.append([place])
        is_on = is_on and "STOP_SPINDLE" not in line
        move = MOVE.search(line)
        if move is not None:
            x, y, z, a = (float(v) for v in move[2].split(",")[:4])
            place = x - 30.0, y, z, a
            if is_on:
                assert move[1] == "FEED"
                strokes[-1].append(place)
    return strokes


def in_section(place: tuple[float, ...], part: Part) -> tuple[float, float, float]:
    """x, Y and Z of the part on which the torch stands 3 mm high, where the work turned by -A."""
    x, y, z, a = place
    c, s = cos(radians(a)), sin(radians(a))
    z -= 3.0
    return x, c * y - s * z + part.profile.height / 2, s * y + c * z + part.profile.width / 2


def off_outline(y: float, z: float, profile: Profile) -> float:
    """How far a place lies outside of the rounded rectangle."""
    r = profile.radius
    dy = max(r - y, 0.0, y - profile.height + r)
    dz = max(r - z, 0.0, z - profile.width + r)
    return hypot(dy, dz) - r


@needs_rs274
def test_the_path_that_rs274_prints_goes_over_the_corner_as_drawn(tmp_path: Path) -> None:
    """Seen from v and from o the path of a window over their corner is what is drawn on each."""
    part = tube(*over_corner(RHS, 1, 200.0, 60.0, 0.0), profile=RHS)
    (tmp_path / "t.ngc").write_text(program_of(part))
    inner, near, far = burns(tmp_path / "t.ngc")
    places = [in_section(place, part) for place in inner[2:]]
    assert max(abs(off_outline(y, z, RHS)) for _, y, z in places) < 0.001
    assert min(x for x, _, _ in places) == pytest.approx(201.0, abs=0.01)
    assert max(x for x, _, _ in places) == pytest.approx(259.0, abs=0.01)
    assert min(y for _, y, _ in places) == pytest.approx(120.0 - 25.0 + 1.0, abs=0.01)
    assert min(z for _, _, z in places) == pytest.approx(80.0 - 25.0 + 1.0, abs=0.01)
    sides = [(x, y, z) for x, y, z in places if y > 110.0 and z > 70.0]
    assert len(sides) > 60
    assert {round(x, 2) for x, _, _ in sides} == {201.0, 259.0}
    for stroke, x in ((near, -1.0), (far, 501.0)):
        assert all(place[0] == pytest.approx(x, abs=1e-3) for place in stroke[2:])
        assert abs(stroke[-1][3] - stroke[2][3]) == pytest.approx(360.0)


@needs_rs274
@pytest.mark.parametrize(
    "cuts",
    [EndCuts(web_end=30.0), EndCuts(flange_end=-25.0), EndCuts(web_start=20.0, flange_end=15.0)],
)
def test_a_skew_end_leaves_all_of_the_solid_and_nothing_beyond(
    cuts: EndCuts, tmp_path: Path
) -> None:
    """Half a kerf and a little beyond the path there is no steel of the part through the wall;
    as much on its other side there is some, though not through all of it."""
    part = tube(profile=RHS, cuts=cuts)
    (tmp_path / "t.ngc").write_text(program_of(part))
    near, far = burns(tmp_path / "t.ngc")
    solid, m = part_solid(part), kernel()

    def steel(x: float, y: float, z: float, n: tuple[float, float]) -> bool:
        """Whether there is steel of the part on the way through the wall."""
        return any(
            (m.Manifold.sphere(0.1, 12).translate((x, y - deep * n[0], z - deep * n[1])) ^ solid)
            .volume() > 1e-4
            for deep in (0.2, 1.5, 2.5, 3.5, 4.8)
        )  # fmt: skip

    steepest = max(tan(radians(abs(a))) for a in (cuts.web_start, cuts.web_end, cuts.flange_end))
    for stroke, side in ((near, -1.0), (far, 1.0)):
        for place in stroke[2::7]:
            x, y, z = in_section(place, part)
            a = radians(place[3])
            n = -sin(a), cos(a)
            along = hypot(1.0, steepest)  # half a kerf of 2, at most so long along x
            assert not steel(x + side * 0.5, y, z, n)
            assert steel(x - side * (along + 0.4), y, z, n)


@needs_rs274
def test_holes_are_burnt_where_the_solid_has_them(tmp_path: Path) -> None:
    faces = ("v", "o", "u", "h")
    part = tube(*(Hole(face, 150.0 + 60 * k, 40.0, 26.0, AT) for k, face in enumerate(faces)))
    (tmp_path / "t.ngc").write_text(program_of(part))
    solid, m = part_solid(part), kernel()
    strokes = burns(tmp_path / "t.ngc")
    assert len(strokes) == 6
    for stroke in strokes[:4]:
        places = [in_section(place, part) for place in stroke[2:]]
        lows = [min(p[k] for p in places) for k in range(3)]
        highs = [max(p[k] for p in places) for k in range(3)]
        x, y, z = ((a + b) / 2 for a, b in zip(lows, highs, strict=True))
        a = radians(stroke[2][3])
        y, z = y + 3.0 * sin(a), z - 3.0 * cos(a)  # 3 mm into the wall

        def is_steel(x: float, y: float = y, z: float = z) -> bool:
            ball = m.Manifold.sphere(0.5, 16).translate((x, y, z))
            return bool((ball ^ solid).volume() > 0.2)

        assert highs[0] - lows[0] == pytest.approx(24.0, abs=0.05)
        assert not is_steel(x)
        assert not is_steel(x + 11.5)
        assert is_steel(x + 14.5)


def test_contours_of_the_sample_are_all_accounted_for() -> None:
    part = samples.sample("leg")
    plan = planned(part)
    assert [o.how for o in plan.outcomes] == ["made"] * len(part.features)
    assert sum(isinstance(f, Contour) for f in part.features) == 7
    assert [cut.kind for cut in plan.operations] == ["inner"] * 5 + ["near", "far"]


def test_a_face_of_which_nothing_stays_is_refused(tmp_path: Path) -> None:
    """A contour whose row lacks its line is a line, with no area."""
    text = (SAMPLES / "coping" / "leg.nc1").read_text()
    rows = ("        600.00        0.00        0.00\n        600.00       80.00        0.00\n"
            "          0.00       80.00        0.00\n")  # fmt: skip
    assert text.count(rows) == 1
    path = tmp_path / "leg.nc1"
    path.write_text(text.replace(rows, "        600.00        0 0.00       80.00        0.00\n"))
    with pytest.raises(PlanError) as caught:
        planned(read_file(str(path)).parts[0])
    assert "plan-coping-corner" in {one.code for one in caught.value.diagnostics}
