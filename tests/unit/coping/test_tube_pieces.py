"""Tubes that come cut: their ends are there, and what lies between them is cut."""

import random
from collections.abc import Callable
from itertools import pairwise
from math import cos, hypot, pi, radians, sin
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.cli import main
from beamcam.errors import PlanError
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Point
from beamcam.machine import load
from beamcam.model.part import Contour, EndCuts, EndPlane, Feature, Hole, Part
from beamcam.model.request import Request
from beamcam.pipeline import post
from beamcam.planning.coping.plan import plan_coping
from beamcam.rest_part import chain_for, stages_of
from beamcam.solid.kernel import kernel
from beamcam.solid.opinion import solid_faults
from beamcam.solid.part_solid import part_solid
from beamcam.writers import TARGETS
from benchmarks import coping_faults
from tests.conftest import SAMPLES, examples
from tests.random_boxes import SECTIONS as BOXES
from tests.random_boxes import over_corner
from tests.random_pieces import random_open
from tests.random_tubes import SECTIONS as ROUND
from tests.random_tubes import window
from tests.rs274 import needs_rs274
from tests.unit.coping.samples import AT, outline, program_of, sample
from tests.unit.coping.test_box_tubes import burns, in_section
from tests.unit.coping.test_rs274 import compare
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
    """Also where an outline that is asked for has them, up to a mm beside them."""
    plane = EndPlane((0.0, 50.0, 50.0), (-1.0, 0.2, 0.0), AT)
    assert refused(piece(HOLE, plane)) == [("plan-coping-tube-end", "a plane that ends it")]
    text = program_of(piece(HOLE), TUBE)
    for off in (-0.7, 0.7):
        ring = [(off, 0.0), (800.0 - off, 0.0), (800.0 - off, 100.0), (off, 100.0)]
        asked, made = piece(HOLE, outline("v", ring)), piece(HOLE, made=(outline("v", ring),))
        assert [cut.kind for cut in plan_coping((asked,), TUBE).operations] == ["inner"]
        assert not found(text, asked)
        assert not found(text, made)


def test_half_of_a_window_over_a_corner_is_not_known() -> None:
    """Of what is there as of what is asked for."""
    half, other = over_corner(SHS, 2, 250.0, 34.0, 3.0)
    assert refused(piece(HOLE, made=(half,))) == [("plan-coping-corner", "")]
    assert not found(program_of(piece(HOLE, made=(half, other)), TUBE),
                     piece(HOLE, made=(half, other)))  # fmt: skip


@pytest.mark.parametrize(("x", "kind"), [(75.0, "inner"), (65.0, "inner"), (8.0, "near")])
def test_a_hole_at_a_skew_end(x: float, kind: str) -> None:
    """On face o the piece begins at x 0, on u at 100 tan 30; a hole of 26 is open at 8 mm."""
    part = piece(replace(HOLE, face="o", x=x), web_start=30.0)
    assert [cut.kind for cut in plan_coping((part,), TUBE).operations] == [kind]
    assert not found(program_of(part, TUBE), part)


SLOT = [(0.0, 40.0), (0.0, 0.0), (800.0, 0.0), (800.0, 100.0), (0.0, 100.0), (0.0, 52.0),
        (90.0, 52.0), (90.0, 40.0)]  # fmt: skip


def test_a_slot_begins_and_ends_in_the_air_before_its_end() -> None:
    """Half a kerf within its sides; the arc starts at x 0 in its scrap."""
    part = piece(outline("v", SLOT), outline("h", [(0.0, 0.0), (800.0, 0.0), (800.0, 100.0),
                                                   (0.0, 100.0)]))  # fmt: skip
    (cut,) = plan_coping((part,), TUBE).operations
    pierce, first, last = cut.path[0], cut.path[cut.lead], cut.path[-1]
    assert pierce[0] == pytest.approx(0.0)
    assert first[0] == pytest.approx(-0.98)
    assert last[0] == pytest.approx(-0.98 - 2.0)
    assert abs(first[1] - last[1]) == pytest.approx(12.0 - 2.0)
    low, high = sorted((first[1], last[1]))
    assert low < pierce[1] < high
    assert max(x for x, _ in cut.path) == pytest.approx(89.0, abs=0.01)


def test_the_other_web_has_the_slot_only_where_it_has_no_outline_of_its_own() -> None:
    bare = piece(outline("v", SLOT))
    assert len(plan_coping((bare,), TUBE).operations) == 2
    whole = outline("h", [(0.0, 0.0), (800.0, 0.0), (800.0, 100.0), (0.0, 100.0)])
    made = piece(outline("v", SLOT), made=(whole,))
    assert len(plan_coping((made,), TUBE).operations) == 1
    for part, other in ((bare, made), (made, bare)):
        text = program_of(part, TUBE)
        assert found(text, other)
    said = solid_faults(text, Request((part,), TUBE))
    assert {d.code for d in said} == {"solid-rounded"}


def test_what_would_be_cut_beside_an_end_is_refused() -> None:
    """On a slope of 3 degrees, and all round."""
    slope = [(0.0, 0.0), (800.0, 0.0), (800.0, 100.0), (0.0, 100.0), (0.0, 85.0), (3.0, 20.0),
             (0.0, 20.0)]  # fmt: skip
    other = outline("h", [(0.0, 0.0), (800.0, 0.0), (800.0, 100.0), (0.0, 100.0)])
    ((code, what),) = refused(piece(outline("v", slope), other))
    assert (code, what[:34]) == ("plan-coping-tube-end", "an outline that leaves too little ")
    turn = ROUND[1].height * pi
    ring = [(20.0, 0.0), (800.0, 0.0), (800.0, turn), (20.0, turn), (45.0, turn / 2)]
    whole = piece(outline("v", ring), box=False)
    assert refused(whole) == [("plan-coping-tube-end", "an outline that takes all of an end")]


@pytest.mark.parametrize("box", [True, False])
def test_a_hole_beside_the_piece_is_refused(box: bool) -> None:
    part = piece(HOLE, replace(HOLE, x=-14.0), box=box)
    assert [code for code, _ in refused(part)] == ["plan-coping-off"]


@pytest.mark.parametrize("box", [True, False])
def test_an_outline_beyond_the_piece_is_refused(box: bool) -> None:
    wide = 100.0 if box else ROUND[1].height * pi
    ring = [(0.0, 0.0), (800.0, 0.0), (800.0, wide), (0.0, wide), (0.0, 80.0), (-5.0, 80.0),
            (-5.0, 30.0), (0.0, 30.0)]  # fmt: skip
    other = outline("h", [(0.0, 0.0), (800.0, 0.0), (800.0, wide), (0.0, wide)])
    part = piece(HOLE, outline("v", ring), box=box, made=(other,) if box else ())
    assert [code for code, _ in refused(part)] == ["plan-coping-short"]
    text = program_of(piece(HOLE, box=box), TUBE)
    assert {d.code for d in found(text, part)} == {"verify-coping-short"}


def test_a_stroke_along_an_end_is_refused() -> None:
    """Of a bar that is how an end is cut."""
    part = piece(HOLE)
    bar = replace(part, made=None)
    said = {d.code for d in found(program_of(bar, TUBE), part)}
    assert said & {"verify-coping-air", "verify-coping-zone"}
    assert {d.code for d in found(program_of(part, TUBE), bar)} & {"verify-coping-gone",
                                                                 "verify-coping-left"}  # fmt: skip


RANDOM = (coping_faults.random_tube_piece, random_open)


@given(st.integers(0, 5000), st.sampled_from(RANDOM))
@settings(max_examples=examples(25))
def test_no_random_piece_that_is_planned_is_refused(seed: int, make: Callable[[int], Part]) -> None:
    part = make(seed)
    try:
        post((part,), TUBE)
    except PlanError:
        return


@pytest.mark.parametrize(("make", "seed"), [(RANDOM[0], 5), (RANDOM[1], 7)])
def test_wrong_programs_are_refused(make: Callable[[int], Part], seed: int) -> None:
    part = make(seed)
    kinds, own = set(), {"over the chuck", "cut left out", "moved along", "open cut in the air"}
    for k, (kind, text) in enumerate(coping_faults.faults(part, TUBE, random.Random(3))):
        if kind in own or k % 3 == 0:  # all the others are tried on parts from a bar
            assert found(text, part), kind
            kinds.add(kind)
    assert kinds > own - {"open cut in the air"}
    assert ("open cut in the air" in kinds) == (make is random_open)


@pytest.mark.parametrize("seed", [4, 9])
def test_what_is_open_to_a_skew_end_is_what_the_kernel_finds(seed: int) -> None:
    """A round tube and a rectangular one, over whose corner it is coped."""
    part = random_open(seed)
    assert part.cuts != EndCuts()
    said = solid_faults(program_of(part, TUBE), Request((part,), TUBE))
    assert {d.code for d in said} <= {"solid-rounded", "solid-square"}


@needs_rs274
def test_the_part_falls_out_of_the_piece_that_rs274_cuts(tmp_path: Path) -> None:
    """What a saw leaves of a strut, less what rs274 prints of the program for it."""
    part = sample("strut-rest")
    (tmp_path / "t.ngc").write_text(program_of(part, TUBE))
    m, strokes = kernel(), burns(tmp_path / "t.ngc")

    def jet(place: tuple[float, ...]) -> list[tuple[float, float, float]]:
        """A ring as wide as the kerf of 2 on both sides of the wall."""
        x, y, z = in_section(place, part)
        a, turns = radians(place[3]), (2 * pi * k / 16 for k in range(16))
        side, out = (cos(a), sin(a)), (-sin(a), cos(a))
        return [
            (x + cos(t), y + sin(t) * side[0] + d * out[0], z + sin(t) * side[1] + d * out[1])
            for t in turns for d in (0.5, -6.8)
        ]  # fmt: skip

    def taken(stroke: list[tuple[float, ...]]) -> Any:
        jets = [jet(place) for place in stroke[2:]]
        hulls = [m.Manifold.hull_points([*a, *b]) for a, b in pairwise(jets)]
        return m.Manifold.batch_boolean(hulls, m.OpType.Add)

    def left(some: list[Any]) -> Any:
        whole = part_solid(replace(part, features=part.made or (), made=None))
        whole = m.Manifold.batch_boolean([whole, *some], m.OpType.Subtract)
        return max(whole.decompose(), key=lambda one: one.volume())

    kerfs = [taken(stroke) for stroke in strokes]
    every = replace(part, features=(*part.features, *(part.made or ())), made=None)
    compare(every, left(kerfs))
    with pytest.raises(AssertionError):
        compare(every, left(kerfs[1:]))


def test_both_programs_of_a_split_strut_are_the_strut() -> None:
    """The torch burns no hole of 6 mm, the saw line copes nothing."""
    part = sample("strut-rest")
    small = Hole("v", 900.0, 60.0, 6.0, AT)
    whole = replace(part, features=(*part.features, *(part.made or ()), small), made=None)
    request = Request((whole,), TUBE)
    chain, _ = chain_for(request, (load("beamline-pusher"), TUBE))
    _, second = stages_of(request, chain, TARGETS[0])
    (rest,) = second.posted.job.parts
    assert [getattr(f, "face", "") for f in rest.features] == ["v", "o", "h"]
    assert not found(second.posted.text, rest)

    def deeper(place: Point) -> Point:
        return place if place[0] != 120.0 else (124.0, place[1])

    slot = rest.features[0]
    assert isinstance(slot, Contour)
    curves = tuple(Line(deeper(c.start), deeper(c.end)) for c in slot.curves)
    other = replace(rest, features=(replace(slot, curves=curves), *rest.features[1:]))
    assert {d.code for d in found(second.posted.text, other)} == {"verify-coping-extra"}


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
