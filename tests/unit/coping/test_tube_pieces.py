"""Tubes that come cut: their ends are there, and what lies between them is cut."""

import random
from math import hypot
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.cli import main
from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.model.part import EndCuts, EndPlane, Feature, Hole, Part
from beamcam.model.request import Request
from beamcam.pipeline import post
from beamcam.planning.coping.plan import plan_coping
from beamcam.solid.opinion import solid_faults
from benchmarks import coping_faults
from tests.conftest import SAMPLES, examples, sampled
from tests.random_boxes import SECTIONS as BOXES
from tests.random_boxes import over_corner
from tests.random_tubes import SECTIONS as ROUND
from tests.random_tubes import window
from tests.unit.coping.samples import AT, outline, program_of
from tests.unit.coping.test_tubes import TUBE, found

SURFACE = load("tube-surface")
SHS = BOXES[1]  # 100 x 100, corners of 12 mm


def piece(
    *features: Feature, made: tuple[Feature, ...] = (), box: bool = True, **cuts: float
) -> Part:
    return Part(
        "T1", SHS if box else ROUND[1], 800.0, AT, features=features, made=made, grade="S235JR",
        cuts=EndCuts(**cuts),
    )  # fmt: skip


def refused(part: Part) -> list[tuple[str, str]]:
    with pytest.raises(PlanError) as caught:
        plan_coping((part,), TUBE)
    return [(d.code, str(dict(d.values).get("what", ""))) for d in caught.value.diagnostics]


HOLE = Hole("v", 300.0, 50.0, 26.0, AT)


@pytest.mark.parametrize("box", [True, False])
def test_only_what_is_left_is_cut(box: bool) -> None:
    """No end, and not the hole that is there."""
    part = piece(HOLE, made=(replace(HOLE, x=200.0),), box=box)
    plan = plan_coping((part,), TUBE)
    assert [cut.kind for cut in plan.operations] == ["inner"]
    xs = [x for x, _ in plan.operations[0].path]
    assert min(xs) == pytest.approx(300.0 - 13.0 + 1.0, abs=0.05)  # half a kerf of 2 within it
    assert plan.bar == 800.0
    text = program_of(part, TUBE)
    assert "(AT A 0 FACE V IS UP, FACE U TO Y-)" in text
    assert "(THE CHUCK HOLDS IT BEHIND X 580)" in text
    said = solid_faults(text, Request((part,), TUBE))
    assert {d.code for d in said} <= {"solid-square"}  # what round holes lack inside


def test_where_a_counts_mm_u_is_up_at_its_0() -> None:
    part = replace(piece(HOLE, box=False), features=(Hole("v", 300.0, 40.0, 26.0, AT),))
    assert "(AT A 0 FACE U IS UP, FACE V TO Y+)" in program_of(part, SURFACE)


def test_no_arc_starts_over_a_hole_that_is_there() -> None:
    plain = piece(window(250.0, 20.0, 80.0, 60.0))
    place = plan_coping((plain,), TUBE).operations[0].path[0]
    s = place[1] - (SHS.width / 2 - SHS.radius) - SHS.radius * 1.5707963267948966
    there = Hole("v", place[0], s + SHS.radius, 12.0, AT)
    part = replace(plain, made=(there,))
    (cut,) = plan_coping((part,), TUBE).operations
    assert hypot(cut.path[0][0] - place[0], cut.path[0][1] - place[1]) > 6.0
    assert {d.code for d in found(program_of(plain, TUBE), part)} == {"verify-coping-air"}
    assert not found(program_of(part, TUBE), part)


def test_a_hole_that_is_there_across_a_cut_is_told() -> None:
    part = piece(window(250.0, 20.0, 80.0, 60.0), made=(Hole("v", 330.0, 50.0, 20.0, AT),))
    assert "plan-coping-open" in {d.code for d in plan_coping((part,), TUBE).remarks}
    assert not found(program_of(part, TUBE), part)


def test_the_ends_stay_as_they_are() -> None:
    end = outline("v", [(0.0, 0.0), (800.0, 0.0), (800.0, 100.0), (0.0, 100.0)])
    plane = EndPlane((0.0, 50.0, 50.0), (-1.0, 0.2, 0.0), AT)
    assert refused(piece(HOLE, end)) == [("plan-coping-tube-end", "an outline")]
    assert refused(piece(HOLE, plane)) == [("plan-coping-tube-end", "a plane that ends it")]
    near = replace(HOLE, x=12.0)
    assert refused(piece(near)) == [("plan-coping-tube-end", "a cut-out from x 0.0 to 25.0")]
    assert not found(program_of(piece(HOLE, made=(end,)), TUBE), piece(HOLE, made=(end,)))


def test_half_of_a_window_over_a_corner_is_not_known() -> None:
    """Of what is there as of what is asked for."""
    half, other = over_corner(SHS, 2, 250.0, 34.0, 3.0)
    assert refused(piece(HOLE, made=(half,))) == [("plan-coping-corner", "")]
    assert not found(program_of(piece(HOLE, made=(half, other)), TUBE),
                     piece(HOLE, made=(half, other)))  # fmt: skip


@pytest.mark.parametrize(("x", "clear"), [(75.0, True), (65.0, False)])
def test_a_skew_end_is_kept_clear_of_all_round(x: float, clear: bool) -> None:
    """100 tan 30 and what the wall of 6 is skew by: 57.7 and 3.5 mm, a hole of 26 behind that."""
    part = piece(replace(HOLE, face="o", x=x), web_start=30.0)
    if clear:
        assert not found(program_of(part, TUBE), part)
    else:
        assert [code for code, _ in refused(part)] == ["plan-coping-tube-end"]


def test_a_stroke_along_an_end_is_refused() -> None:
    """Of a bar that is how an end is cut."""
    part = piece(HOLE)
    bar = replace(part, made=None)
    said = {d.code for d in found(program_of(bar, TUBE), part)}
    assert said & {"verify-coping-air", "verify-coping-zone"}
    assert {d.code for d in found(program_of(part, TUBE), bar)} & {"verify-coping-gone",
                                                                 "verify-coping-left"}  # fmt: skip


@given(st.integers(0, 5000))
@settings(max_examples=examples(25))
def test_no_random_piece_that_is_planned_is_refused(seed: int) -> None:
    part = coping_faults.random_tube_piece(seed)
    try:
        post((part,), TUBE)
    except PlanError:
        return


@pytest.mark.parametrize("seed", sampled([0, 5], 2))
def test_wrong_programs_are_refused(seed: int) -> None:
    part = coping_faults.random_tube_piece(seed)
    kinds = set()
    for kind, text in coping_faults.faults(part, TUBE, random.Random(3)):
        assert found(text, part), kind
        kinds.add(kind)
    assert kinds > {"taken for a bar", "over the chuck", "cut left out", "moved along"}


def test_the_commands_know_them(tmp_path: Path) -> None:
    """A face behind, h, has no A of its own."""
    path, program = SAMPLES / "coping" / "mast-rest.nc1", tmp_path / "mast.ngc"
    for words in (
        ("plan", path, "--machine", "tube-linuxcnc"),
        ("post", path, "--machine", "tube-linuxcnc", "-o", program),
        ("plot", program, "-o", tmp_path / "mast.svg"),
        ("report", program, "--against", path, "-o", tmp_path / "mast.html"),
        ("verify", program, "--against", path),
    ):
        done = CliRunner().invoke(main, [*map(str, words)])
        assert done.exit_code == 0, done.output
    planned = CliRunner().invoke(main, ["plan", str(path), "--machine", "tube-linuxcnc"])
    assert "1500.000 mm, cut to length by another machine" in planned.stdout
    assert " face h  cut-out " in planned.stdout
