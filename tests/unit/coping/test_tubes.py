"""Round tubes: planned on the unrolled surface, cut in inverse time, read back, by strangers."""

import random
import re
from math import asin, cos, dist, pi, radians, sin
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from shapely import LineString, Polygon

from beamcam.checks.coping import verify_coping
from beamcam.errors import Diagnostic, PlanError
from beamcam.machine import Machine, load
from beamcam.model.part import Bevel, Feature, Hole, Part, Profile
from beamcam.model.plan import CopePlan
from beamcam.model.request import Request
from beamcam.planning.coping.plan import plan_coping
from beamcam.planning.coping.stock import as_pipe
from beamcam.planning.manual_list import manual_rows
from beamcam.solid.kernel import kernel
from beamcam.solid.opinion import solid_faults
from beamcam.solid.part_solid import part_solid
from benchmarks import coping_faults
from tests.conftest import examples
from tests.random_tubes import SECTIONS, random_tube, window
from tests.rs274 import INI, interpreted, needs_rs274
from tests.unit.coping import samples
from tests.unit.coping.samples import AT, faults, job_of, outline

TUBE = load("tube-linuxcnc")
CHS = SECTIONS[0]
TURN = pi * 168.3
HOLE = Hole("v", 200.0, 100.0, 26.0, AT)


def tube(*features: Feature, profile: Profile = CHS, length: float = 500.0) -> Part:
    return Part("T1", profile, length, AT, features=features, grade="S235JR")


def planned(part: Part, machine: Machine = TUBE) -> CopePlan:
    return plan_coping((part,), machine)


def program_of(part: Part, machine: Machine = TUBE) -> str:
    return samples.program_of(part, machine)


def found(text: str, part: Part, machine: Machine = TUBE) -> tuple[Diagnostic, ...]:
    return faults(text, part, machine)


def test_no_block_is_shorter_than_a_micron() -> None:
    """The last place of an end and the one before it are one; F would be 67398133579."""
    text = program_of(samples.sample("brace"))
    feeds = [float(f) for f in re.findall(r"A\S+ F([0-9.]+)", text)]
    assert len(feeds) > 600
    assert max(feeds) <= 3000 / 0.001


def test_a_tube_is_cut_to_length_all_round() -> None:
    plan = planned(tube())
    assert [cut.kind for cut in plan.operations] == ["near", "far"]
    assert plan.bar == 500.0 + 2 * 30.0 + 250.0
    for cut, x in zip(plan.operations, (-1.1, 501.1), strict=True):
        assert [p[0] for p in cut.path[1:]] == pytest.approx([x, x])
        assert abs(cut.path[1][1] - cut.path[2][1]) == pytest.approx(TURN)


def test_the_blocks_of_an_end_worked_by_hand() -> None:
    lines = program_of(tube()).splitlines()
    first = lines.index("G93")
    # 3 mm down and 8.05 mm along at 3000 mm/min; then once round 528.730 mm of surface.
    assert lines[first + 1] == "G1 X20.85 Y0 Z87.15 A-270 F1000"
    assert lines[first + 2] == "G1 X28.9 Y0 Z87.15 A-270 F372.6708"
    assert lines[first + 3] == "G1 X28.9 Y0 Z87.15 A90 F5.674"
    assert lines[first + 4 : first + 6] == ["M5", "G94"]


def test_a_hole_is_as_wide_as_a_drill_makes_it() -> None:
    (cut, *_) = planned(tube(HOLE)).operations
    us = [u for _, u in cut.path[1:]]
    xs = [x for x, _ in cut.path[1:]]
    half = 84.15 * asin(13.0 / 84.15)
    assert (min(us), max(us)) == pytest.approx((100 - half + 1.1, 100 + half - 1.1), abs=0.02)
    assert (min(xs), max(xs)) == pytest.approx((188.1, 211.9), abs=0.02)


@pytest.mark.parametrize("u", [0.0, 5.0, TURN - 5.0, TURN])
def test_what_lies_across_the_seam_is_cut_once(u: float) -> None:
    part = tube(Hole("v", 200.0, u, 26.0, AT))
    assert [cut.kind for cut in planned(part).operations] == ["inner", "near", "far"]
    assert not found(program_of(part), part)


def test_the_seam_is_where_the_machine_has_it() -> None:
    assert TUBE.coper is not None
    quarter = replace(TUBE, coper=replace(TUBE.coper, seam=90.0))
    near, _ = planned(tube(), quarter).operations
    assert {round(u, 3) for _, u in near.path} == {round(TURN / 4, 3), round(5 * TURN / 4, 3)}
    assert not found(program_of(tube(), quarter), tube(), quarter)


REFUSED = [
    ("plan-stock", tube(profile=Profile("RU", "RD60", 60.0, 60.0, 0.0, 60.0))),
    ("plan-section", tube(profile=Profile("RO", "CHS406", 406.4, 406.4, 0.0, 8.0))),
    ("plan-bar-long", tube(length=6300.0)),
    ("plan-coping-thick", tube(profile=Profile("RO", "CHS", 200.0, 200.0, 0.0, 60.0))),
    ("plan-face", tube(Hole("o", 200.0, 100.0, 26.0, AT))),
    ("plan-tool", tube(Hole("v", 200.0, 100.0, 7.0, AT))),
    ("plan-coping-off", tube(Hole("v", 900.0, 100.0, 26.0, AT))),
    ("plan-coping-narrow", tube(outline("v", [(200.0, 90.0), (280.0, 90.0), (280.0, 97.0),
                                              (200.0, 97.0)], "inner"))),
]  # fmt: skip


@pytest.mark.parametrize(("code", "part"), REFUSED)
def test_what_cannot_be_made_is_refused(code: str, part: Part) -> None:
    with pytest.raises(PlanError) as caught:
        planned(part)
    assert {d.code for d in caught.value.diagnostics} == {code}


KNOWN = ("solid-rounded", "solid-square")
PLATE = Profile("B", "PIPE168.3*8", TURN, 0.0, 0.0, 8.0)


def test_a_plate_that_is_called_a_pipe_is_wrapped_and_told() -> None:
    as_plate, as_tube = (planned(tube(HOLE, profile=p)) for p in (PLATE, CHS))
    assert all(
        dist(a, b) < 1e-6
        for one, other in zip(as_plate.operations, as_tube.operations, strict=True)
        for a, b in zip(one.path, other.path, strict=True)
    )
    told = [d.message for d in as_plate.remarks if d.code == "plan-coping-pipe"]
    assert told == [
        "found a plate PIPE168.3*8 528.73 mm wide; it is the unrolled surface of a pipe 168.30 mm "
        "in diameter, and is cut as that pipe"
    ]
    assert not found(program_of(tube(HOLE, profile=PLATE)), tube(HOLE, profile=PLATE))


def test_a_pipe_whose_name_has_another_diameter_is_refused() -> None:
    with pytest.raises(PlanError, match=r"plan-coping-no-pipe: .*expected 687\.69 mm"):
        planned(tube(profile=replace(PLATE, name="PIPE218.9*8")))
    with pytest.raises(PlanError, match="plan-stock"):
        planned(tube(profile=replace(PLATE, name="PL8")))


@pytest.mark.parametrize(
    ("name", "diameter"),
    [("PIPE1-1/2SCH40", 48.26), ("PIPE1SCH40", 33.53), ("PIPE 3/4 STD", 26.67), ("CHS6", 168.3),
     ("PIPE12X0.375", 323.85), ("TUBE2.5X.25", 63.5), ("PIPESTD", 60.0)],
)  # fmt: skip
def test_a_name_may_have_inches_or_a_nominal_size(name: str, diameter: float) -> None:
    """Real files call pipes so; 33.53 mm are drawn for the 33.4 of ASME B36.10M."""
    profile = replace(PLATE, name=name, height=pi * diameter)
    pipe, said = as_pipe(tube(profile=profile))
    assert said is not None
    assert said.code == "plan-coping-pipe"
    assert pipe.profile.height == pytest.approx(diameter)
    _, said = as_pipe(tube(profile=replace(profile, height=profile.height + 5.0)))
    assert name == "PIPESTD" or (said is not None and said.code == "plan-coping-no-pipe")


@pytest.mark.parametrize(("off", "is_closed"), [(0.9, True), (2.0, True), (3.0, False)])
def test_the_seam_of_an_outline_is_closed(off: float, is_closed: bool) -> None:
    """A saddle drawn from the last place of one end to the first of the other."""
    saddle = [(0.0, off), (495.0, -off), (500.0, 100.0), (500.0, 400.0), (495.0, TURN + off),
              (0.0, TURN - off), (8.0, 400.0), (8.0, 100.0)]  # fmt: skip
    part = tube(outline("v", saddle))
    if not is_closed:
        with pytest.raises(PlanError):
            planned(part)
        return
    plan = planned(part)
    assert [cut.kind for cut in plan.operations] == ["near", "far"]
    told = [d.message for d in plan.remarks if d.code == "plan-coping-seam"]
    assert told == ([f"found the seam of a tube's outline {off:.2f} mm off its place; taken as "
                     "closed"] if off > 1.0 else [])  # fmt: skip
    text = program_of(part)
    assert not [d for d in solid_faults(text, Request((part,), TUBE)) if d.code not in KNOWN]


def test_bevels_are_cut_square_and_on_the_list_of_manual_work() -> None:
    edge = outline("v", [(0.0, 0.0), (500.0, 0.0), (500.0, TURN), (0.0, TURN)])
    part = tube(replace(edge, bevels=(Bevel(1, 30.0, 0.0), Bevel(3, 0.5, 0.0))))
    plan = planned(part)
    assert [(o.how, o.manual_work) for o in plan.outcomes] == [("made", "bevel")]
    assert [row["angle"] for row in manual_rows(plan)] == [30.0]
    program_of(part)  # the read-back has the same on its list


def test_an_end_plane_is_manual_work_without_a_place() -> None:
    (row,) = manual_rows(plan_coping((samples.sample("hip"),), load("tube-linuxcnc")))
    assert {type(value) for value in row.values()} <= {str, int, float}
    assert (row["face"], row["x"], row["y"], row["why"]) == ("", 0.0, 0.0, "bevel")


def test_a_slot_that_opens_the_whole_tube_leaves_no_end() -> None:
    along = outline("v", [(-5.0, 100.0), (505.0, 100.0), (505.0, 140.0), (-5.0, 140.0)], "inner")
    with pytest.raises(PlanError, match="no end that goes all round"):
        planned(tube(along))


@given(st.integers(0, 5000))
@settings(max_examples=examples(30))
def test_random_tubes_are_planned_and_none_is_refused(seed: int) -> None:
    part = random_tube(seed)
    assert not found(coping_faults.program_of(planned(part), job_of(part, TUBE)), part)


def test_wrong_programs_are_refused() -> None:
    part, chance = tube(HOLE, window(300.0, 500.0, 60.0, 50.0)), random.Random(3)
    for kind, text in coping_faults.faults(part, TUBE, chance):
        assert found(text, part), kind


def test_wrong_walls_are_refused() -> None:
    whole = program_of(tube())
    assert {d.code for d in found(whole, tube(HOLE))} == {"verify-coping-left"}
    cut = program_of(tube(HOLE))
    assert {d.code for d in found(cut, tube())} == {"verify-coping-hurt"}
    thicker = tube(profile=replace(CHS, web_thickness=12.0))
    assert {d.code for d in found(whole, thicker)} == {"verify-coping-feed"}
    smaller = tube(profile=replace(CHS, height=160.0))
    assert found(whole, smaller)


def test_a_block_without_its_own_time_is_refused() -> None:
    text = re.sub(r"(G1 .*) F372.6708", r"\1", program_of(tube()), count=1)
    (said,) = [d for d in verify_coping(text, (tube(),), TUBE, (), "JOB") if d.code != "x"][:1]
    assert said.code == "verify-word"
    assert "no F in that block" in said.message


# --- strangers ------------------------------------------------------------------------------------

MOVE = re.compile(r"STRAIGHT_(TRAVERSE|FEED)\(([^)]*)\)")


def burns(path: Path) -> list[list[tuple[float, float]]]:
    """X of the tube and A, of the strokes of the torch as rs274 prints them."""
    done = interpreted(path, ini=INI)
    assert done.returncode == 0, done.stderr
    strokes: list[list[tuple[float, float]]] = []
    is_on, place = False, (0.0, 0.0)
    for line in done.stdout.splitlines():
        if "START_SPINDLE_CLOCKWISE" in line:
            is_on = True
            strokes.append([place])
        is_on = is_on and "STOP_SPINDLE" not in line
        move = MOVE.search(line)
        if move is not None:
            x, y, _, a = (float(v) for v in move[2].split(",")[:4])
            place = x - 30.0, a
            assert y == 0.0
            if is_on:
                assert move[1] == "FEED"
                strokes[-1].append(place)
    return strokes


def unrolled(stroke: list[tuple[float, float]], radius: float) -> list[tuple[float, float]]:
    """The places of the surface, the lead left out; the lowest line comes on top at A 90."""
    return [(x, radius * radians(90.0 - a)) for x, a in stroke[2:]]


@needs_rs274
def test_the_path_that_rs274_prints_is_the_contour(tmp_path: Path) -> None:
    part = tube(window(300.0, 200.0, 60.0, 50.0))
    (tmp_path / "t.ngc").write_text(program_of(part))
    inner, near, far = burns(tmp_path / "t.ngc")
    drawn = Polygon([(312, 212), (348, 212), (348, 238), (312, 238)]).buffer(12.0, 64)
    for place in unrolled(inner, 84.15)[1:]:
        off = drawn.exterior.distance(LineString([place, (place[0] + 1e-6, place[1])]))
        assert off == pytest.approx(1.1, abs=0.03)
    assert LineString(unrolled(inner, 84.15)).length > 0.9 * drawn.exterior.length
    for stroke, x in ((near, -1.1), (far, 501.1)):
        assert all(place[0] == pytest.approx(x, abs=1e-3) for place in unrolled(stroke, 84.15))
        assert abs(stroke[-1][1] - stroke[2][1]) == pytest.approx(360.0)


def test_each_block_takes_the_time_of_its_way_on_the_surface() -> None:
    text = program_of(random_tube(2))
    radius = random_tube(2).profile.height / 2
    block = re.compile(r"G1 X(\S+) Y0 Z(\S+) A(\S+) F(\S+)")
    rapid = re.compile(r"G0 (?:X(\S+) Y0 Z(\S+)|A(\S+))")
    here = [0.0, 0.0, 0.0]
    speeds = []
    for line in text.splitlines():
        if match := rapid.fullmatch(line):
            here = [float(v) if v else h for v, h in zip(match.groups(), here, strict=True)]
        elif match := block.fullmatch(line):
            x, z, a, f = map(float, match.groups())
            way = dist((x, z, radius * radians(a)), (*here[:2], radius * radians(here[2])))
            here = [x, z, a]
            speeds.append((way * f, way))
    assert len(speeds) > 20
    feeds = {row.feed_mm_min for row in TUBE.coper.rows} if TUBE.coper else set()
    assert all(
        min(abs(speed - feed) for feed in feeds) < 0.01 * speed + 10.0 / way
        for speed, way in speeds
    )


@needs_rs274
def test_holes_are_burnt_where_the_solid_has_them(tmp_path: Path) -> None:
    """A place on top at A lies on the tube where the solid of the part has its holes."""
    holes = (HOLE, Hole("v", 300.0, 20.0, 26.0, AT), Hole("v", 400.0, 430.0, 26.0, AT))
    part = tube(*holes)
    (tmp_path / "t.ngc").write_text(program_of(part))
    solid = part_solid(part)
    m = kernel()

    def is_steel(x: float, a: float) -> bool:
        """Whether there is steel 4 mm below the surface, where the work has turned by -A."""
        y, z = 84.15 - 80.15 * sin(radians(a)), 84.15 + 80.15 * cos(radians(a))
        return bool((m.Manifold.sphere(0.5, 16).translate((x, y, z)) ^ solid).volume() > 0.2)

    strokes = burns(tmp_path / "t.ngc")
    assert len(strokes) == 5
    for stroke in strokes[:3]:
        path = stroke[2:]
        x = (min(p[0] for p in path) + max(p[0] for p in path)) / 2
        a = (min(p[1] for p in path) + max(p[1] for p in path)) / 2
        assert not is_steel(x, a)
        wide = (max(p[0] for p in path) - min(p[0] for p in path)) / 2 + 1.1
        assert not is_steel(x + wide - 1.5, a)
        assert is_steel(x + wide + 1.5, a)
