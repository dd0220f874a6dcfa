"""Profiles and tubes cut as solids: sound programs agree, and every lie of a program is seen."""

import re
from math import atan2, cos, degrees, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Severity
from beamcam.geometry.curves import Arc, Line
from beamcam.machine import Machine, load
from beamcam.machine.coper import TubeCorner
from beamcam.model.part import Bevel, Contour, EndCuts, Feature, Hole, Part, Profile, Slot
from beamcam.model.request import Request
from beamcam.pipeline import post
from beamcam.solid.opinion import solid_faults
from beamcam.solid.part_solid import part_solid
from beamcam.solid.wrapped import Skin, unrolled, wrapped
from benchmarks.coping_faults import random_piece
from benchmarks.solid import KINDS, mutants
from tests.conftest import sampled
from tests.random_boxes import over_corner, random_box
from tests.random_copes import CEES, random_cope, random_lipped, random_mitre, random_tee
from tests.random_tubes import SECTIONS, random_tube, window
from tests.unit.coping.samples import AT, COPER, outline, part_of, program_of, sample, with_keys

TUBE = load("tube-linuxcnc")
CHS = SECTIONS[0]
TURN = pi * 168.3
SAMPLES = (
    ("coped", COPER, ()), ("brace", TUBE, ()), ("trimmer", COPER, ()), ("stub", TUBE, ()),
    ("header-rest", COPER, ()), ("cleat", COPER, ()), ("header", COPER, ("tool",)),
    ("hanger", COPER, ()), ("leg", TUBE, ()), ("hip", TUBE, ()), ("joist", COPER, ()),
    ("joist", TUBE, ()), ("lintel-rest", TUBE, ()), ("mast-rest", TUBE, ()),
    ("strut-rest", TUBE, ()),
)  # fmt: skip


def posted(part: Part, machine: Machine = COPER, skips: tuple[str, ...] = ()) -> str:
    return post((part,), machine, skips=skips).text if skips else program_of(part, machine)


def said(
    text: str, part: Part, machine: Machine = COPER, skips: tuple[str, ...] = (),
    bar: float | None = None,
) -> tuple[Diagnostic, ...]:  # fmt: skip
    return solid_faults(text, Request((part,), machine, skips), bar)


def wrong(text: str, part: Part, machine: Machine = COPER) -> dict[str, str]:
    """What is wrong with a program, by its codes."""
    found = said(text, part, machine)
    return {d.code: d.message for d in found if d.severity is not Severity.NOTE}


def tube(*features: Hole | Slot | Contour, length: float = 500.0) -> Part:
    return Part("T1", CHS, length, AT, features=features, grade="S235JR")


@pytest.mark.parametrize(("name", "machine", "skips"), sampled(SAMPLES, 2))
def test_samples_agree(name: str, machine: Machine, skips: tuple[str, ...]) -> None:
    part = sample(name)
    found = said(posted(part, machine, skips), part, machine, skips)
    assert {d.code for d in found} <= {"solid-rounded", "solid-square", "solid-left-out"}


MAKES = (random_cope, random_piece, random_tee, random_lipped, random_tube, random_box)
RANDOM = [(make, seed) for seed in range(4) for make in MAKES]


def agree(part: Part) -> bool:
    """Whether the opinion agrees with the program of a part; True where there is none."""
    machine = TUBE if part.profile.code in ("RO", "M") else COPER
    try:
        text = posted(part, machine)
    except PlanError:
        return True
    return not wrong(text, part, machine)


@pytest.mark.parametrize(("make", "seed"), sampled(RANDOM, 7))
def test_random_parts_agree(make: object, seed: int) -> None:
    assert callable(make)
    assert agree(make(seed))


@pytest.mark.exhaustive
@pytest.mark.parametrize("make", MAKES)
def test_many_random_parts_agree(make: object) -> None:
    assert callable(make)
    assert [seed for seed in range(100, 150) if not agree(make(seed))] == []


WRONG = [
    (stock, kind, make) for stock in ("profiles", "tubes") for kind, make in KINDS[stock]
]  # fmt: skip


@pytest.mark.parametrize(("stock", "kind", "make"), sampled(WRONG, 5))
def test_wrong_programs_are_refused(stock: str, kind: str, make: object) -> None:
    assert mutants([], stock, kind, make, 1, 3) == (1, [])  # type: ignore[arg-type]


@pytest.mark.exhaustive
@pytest.mark.parametrize(("stock", "kind", "make"), WRONG)
def test_thirty_wrong_programs_of_each_kind_are_refused(
    stock: str, kind: str, make: object
) -> None:
    assert mutants([], stock, kind, make, 30, 1) == (30, [])  # type: ignore[arg-type]


# --- what is said ---------------------------------------------------------------------------------


def without(text: str, comment: str) -> str:
    """A program without the first cut that a comment announces."""
    begin = text.index(f"({comment})")
    end = text.index("M5\n", begin) + 3
    return text[:begin] + text[end:]


def test_a_missing_cut_out_is_named_by_its_place() -> None:
    part = part_of(Hole("v", 300.0, 150.0, 60.0, AT))
    found = wrong(without(posted(part), "cut-out on face v"), part)
    assert list(found) == ["solid-extra"]
    assert "on face v at x 300.0, y 150.0" in found["solid-extra"]


def test_a_missing_cut_out_of_a_tube_is_named_by_its_arc() -> None:
    part = tube(Hole("v", 200.0, 400.0, 26.0, AT))
    found = wrong(without(posted(part, TUBE), "cut-out"), part, TUBE)
    assert re.search(r"on face v at x 200\.0, y (399|400)\.\d", found["solid-extra"])


@pytest.mark.parametrize("name", ["valley", "cleat"])
def test_a_program_that_turns_its_torch_nowhere(name: str) -> None:
    part = sample(name)
    upright = re.sub(r"(?m)^G0 A-?90", "G0 A0", posted(part))
    assert {code for code in wrong(upright, part) if code.startswith("solid-")}


def test_the_mirror_image_is_another_part() -> None:
    """Two holes in one half of the web, at different places from both ends."""
    holes = [(120.0, 90.0), (200.0, 90.0)]
    part = part_of(*(Hole("v", x, y, 26.0, AT) for x, y in holes), Hole("o", 90.0, 110.0, 18.0, AT))
    image = part_of(
        *(Hole("v", 600.0 - x, y, 26.0, AT) for x, y in holes), Hole("o", 510.0, 110.0, 18.0, AT)
    )
    assert list(wrong(posted(image), part)) == ["solid-hand"]
    assert not wrong(posted(image), image)


@pytest.mark.parametrize("off", [-0.6, 0.6])
def test_another_length(off: float) -> None:
    assert "solid-size" in wrong(posted(part_of(length=600.0 + off)), part_of())


def test_an_end_that_does_not_close_leaves_the_trim() -> None:
    text = posted(tube(), TUBE)
    found = wrong(re.sub(r"A90 F", "A84 F", text, count=1), tube(), TUBE)
    assert "solid-size" in found


SHARP = outline("v", [(250.0, 100.0), (350.0, 100.0), (350.0, 180.0), (250.0, 180.0)], "inner")


@pytest.mark.parametrize("faces", ["v", "h", "vh"])
def test_rounded_corners_are_told_by_their_steel(faces: str) -> None:
    """Four corners of 90 degrees keep (1 - pi / 4) r^2 of a web of 7.1 mm each, once, though some
    exporters draw a window on both sides of it."""
    part = part_of(*(replace(SHARP, face=face) for face in faces))
    (told,) = said(posted(part), part)
    assert (told.code, told["count"]) == ("solid-rounded", 4)
    assert float(str(told["found"])) == pytest.approx(4 * (1 - pi / 4) * 100 * 7.1, rel=0.03)


def test_corners_rounder_than_the_machine_rounds_them_are_refused() -> None:
    rounder, sharper = (with_keys(corner_radius=r) for r in (14.0, 5.0))
    assert list(wrong(posted(part_of(SHARP), rounder), part_of(SHARP))) == ["solid-extra"]
    assert not wrong(posted(part_of(SHARP), sharper), part_of(SHARP))


def test_a_corner_that_meets_an_arc_keeps_its_own_round() -> None:
    half = (Arc((310.0, 150.0), 40.0, 0.0, 180.0), Line((270.0, 150.0), (350.0, 150.0)))
    part = part_of(Contour("v", "inner", half, AT))
    assert not wrong(posted(part), part)


def test_what_corners_keep_does_not_hide_a_cut_out() -> None:
    """One as narrow as two of their radii, which no program of the machine has."""
    small = outline("v", [(300.0, 140.0), (318.0, 140.0), (318.0, 158.0), (300.0, 158.0)], "inner")
    assert list(wrong(posted(part_of()), part_of(small))) == ["solid-extra"]


def test_bevels_are_told_by_what_they_leave() -> None:
    """A wedge of 45 degrees over 3.1 mm of the web's window, its upper side 100 mm long."""
    bevelled = replace(SHARP, bevels=(Bevel(2, 45.0, 4.0),))
    part = part_of(bevelled)
    told = {d.code: d for d in said(posted(part), part)}
    assert set(told) == {"solid-rounded", "solid-square"}
    assert told["solid-square"]["what"] == "1 edge(s) with a bevel"
    wedge = 100.0 * 3.1 * 3.1 / 2  # less the margins along it and where the corners are
    assert 0.6 * wedge < float(str(told["solid-square"]["found"])) < wedge


def test_holes_of_a_tube_are_narrower_inside_and_told() -> None:
    part = tube(Hole("v", 200.0, 100.0, 40.0, AT))
    (told,) = said(posted(part, TUBE), part, TUBE)
    assert (told.code, told["what"]) == ("solid-square", "1 hole(s) round its axis")
    radial = part_solid(part).volume()
    assert 0.0 < float(str(told["found"])) < 0.05 * (part_solid(tube()).volume() - radial)


def test_what_may_be_left_out_is_told() -> None:
    part = part_of(Hole("v", 200.0, 150.0, 9.0, AT), SHARP)
    text = posted(part, COPER, ("tool",))
    codes = [d.code for d in said(text, part, COPER, ("tool",))]
    assert codes == ["solid-rounded", "solid-left-out"]
    assert list(wrong(text, part)) == ["solid-extra"]


# --- machines and stocks --------------------------------------------------------------------------


def test_a_torch_whose_places_are_those_of_its_pivot() -> None:
    words = replace(COPER.words, turn=("G0 Y{y} Z{z} A{a}",))
    pivoted = replace(with_keys(tcp=False, pivot=250.0), words=words)
    limits = [replace(a, min=-2000.0, max=20000.0) if a.moves != "A" else a for a in COPER.axes]
    pivoted = replace(pivoted, axes=tuple(limits))
    part = sample("cleat")
    assert not wrong(posted(part, pivoted), part, pivoted)
    assert wrong(posted(part, pivoted), part)


#: Where web and flanges begin that a cut of 30 degrees of the web, or one of 20 degrees of the
#: flange, has ended; a drawing may show either surface of a wall.
SKEW = [
    (EndCuts(web_start=30.0), [(173.2051, 0.0), (0.0, 300.0)], [(0.0, 0.0), (0.0, 150.0)]),
    (EndCuts(flange_start=20.0), [(26.0, 0.0), (26.0, 300.0)], [(54.5955, 0.0), (0.0, 150.0)]),
    (EndCuts(flange_start=20.0), [(28.6, 0.0), (28.6, 300.0)], [(54.5955, 0.0), (0.0, 150.0)]),
]  # fmt: skip


@pytest.mark.parametrize(("cuts", "web", "flange"), sampled(SKEW, 2))
def test_a_cope_at_a_piece_whose_other_end_is_skew(
    cuts: EndCuts, web: list[tuple[float, float]], flange: list[tuple[float, float]]
) -> None:
    cope = [(600.0, 0.0), (600.0, 240.0), (520.0, 240.0), (520.0, 300.0)]
    part = part_of(
        outline("v", [web[0], *cope, web[1]]),
        outline("o", [flange[0], (520.0, 0.0), (520.0, 150.0), flange[1]]),
    )
    part = replace(part, made=(Hole("v", 400.0, 100.0, 22.0, AT),), cuts=cuts)
    assert not wrong(posted(part), part)
    assert "solid-extra" in wrong(posted(part), replace(part, cuts=EndCuts(web_end=10.0)))


def test_a_flange_is_as_long_as_its_lip_beside_a_sharp_bend() -> None:
    """1 mm and half of the widest kerf, 4.8 mm, beside the bend of 1.5 mm: 4.9 mm."""
    part = random_mitre(7, CEES)
    text = posted(part)
    assert not wrong(text, part)
    assert "G1 X1799.7 Y-3 Z4.9\n" in text
    longer = text.replace("G1 X1796.7282 Y-3 Z5.9\n", "G1 X1796.7282 Y-3 Z16\n")
    assert "solid-extra" in wrong(longer, part)


def test_a_bar_that_ends_before_the_part_is_too_short() -> None:
    text = posted(part_of())
    assert [d.code for d in said(text, part_of(), bar=660.0)] == []
    assert "solid-size" in {d.code for d in said(text, part_of(), bar=620.0)}
    assert [d.code for d in said(text, part_of(), bar=0.0)] == ["solid-pieces"]


def test_a_program_makes_one_part() -> None:
    request = Request((part_of(), part_of(SHARP)), COPER)
    assert [d.code for d in solid_faults(posted(part_of()), request)] == ["solid-pieces"]
    twice = Request((part_of(),), COPER, quantity=2)
    assert not solid_faults(posted(part_of()), twice)


NOT_CUT = [
    (r"(G1 X\S+ Y\S+ Z\S+)\n", r"\1 A20\n", "a torch that turns as it cuts"),
    (r"F\d+\n", "F10\n", "a cut at 10 mm/min, the speed of no row of the chart"),
    (r"G0 A0\n", "", "a cut from or to nowhere"),
]


@pytest.mark.parametrize(("pattern", "other", "found"), NOT_CUT)
def test_cuts_that_are_none_of_the_chart_are_refused(pattern: str, other: str, found: str) -> None:
    part = part_of(Hole("v", 300.0, 150.0, 60.0, AT))
    text = re.sub(pattern, other, posted(part), count=0 if "A0" in pattern else 1)
    assert found in wrong(text, part)["solid-none"]


def test_a_torch_beside_the_axis_of_a_tube_is_refused() -> None:
    text = re.sub(r"(G1 \S+) Y0 ", r"\1 Y3 ", posted(tube(), TUBE))
    assert "not square to its tube" in wrong(text, tube(), TUBE)["solid-none"]


# --- tubes ----------------------------------------------------------------------------------------


def test_a_cut_out_of_a_tube_takes_its_sector() -> None:
    """An area a of the outside takes a (d - d^2 / 2R) of a wall d, wherever it lies."""
    for u in (200.0, 0.0, TURN - 20.0):
        part = tube(window(300.0, u, 60.0, 50.0))
        taken = part_solid(tube()).volume() - part_solid(part).volume()
        area = 60.0 * 50.0 - (4 - pi) * 144.0
        assert taken == pytest.approx(area * (8.0 - 64.0 / 168.3), rel=2e-3)


def test_an_outline_of_a_tube_is_as_long_as_it_is_on_each_line() -> None:
    """A straight rise from 0 to 60 mm and back takes 30 mm of the length."""
    rise = [(0.0, 0.0), (500.0, 0.0), (500.0, TURN), (0.0, TURN), (60.0, TURN / 2)]
    whole = part_solid(tube()).volume()
    assert part_solid(tube(outline("v", rise))).volume() == pytest.approx(whole * 470 / 500, 1e-4)


def test_a_shape_lies_on_the_surface_where_it_is_drawn() -> None:
    from shapely import box

    for u, (y, z) in ((0.0, (0.0, 50.0)), (pi * 25.0, (50.0, 100.0)), (pi * 75.0, (50.0, 0.0))):
        body = wrapped(box(10.0, u - 1.0, 12.0, u + 1.0), Skin(100.0, 100.0, 50.0), 0.0, 1.0)
        low, high = body.bounding_box()[:3], body.bounding_box()[3:]
        assert (low[0], high[0]) == pytest.approx((10.0, 12.0))
        assert low[1] - 0.05 <= y <= high[1] + 0.05
        assert low[2] - 0.05 <= z <= high[2] + 0.05
        assert body.volume() == pytest.approx(2.0 * 2.0 * (1.0 - 1.0 / 100.0), rel=1e-3)


# --- rectangular tubes ----------------------------------------------------------------------------

SHS = Profile("M", "SHS100*6", 100.0, 100.0, 6.0, 6.0, 12.0)


def square(*features: Feature, cuts: EndCuts | None = None) -> Part:
    return Part("B1", SHS, 400.0, AT, features=features, grade="S235", cuts=cuts or EndCuts())


def test_the_way_round_a_rectangular_tube_goes_over_its_faces_and_corners() -> None:
    """Places on the surface, by hand: half a face, a corner of 12, a face, and the way back."""
    skin = Skin(100.0, 60.0, 12.0)
    arc = 6.0 * pi
    assert skin.turn == pytest.approx(2 * (76.0 + 36.0) + 4 * arc)
    at = {0.0: (0.0, 30.0), 18.0: (0.0, 48.0), 18.0 + arc: (12.0, 60.0),
          18.0 + arc + 38.0: (50.0, 60.0), skin.turn / 2: (100.0, 30.0),
          -18.0: (0.0, 12.0)}  # fmt: skip
    for u, (y, z) in at.items():
        ((x, *place),) = skin.bent(np.array([[7.0, u, 0.0]]))
        assert (x, *place) == pytest.approx((7.0, y, z))
    middle = 12.0 * (1 - 0.5**0.5)
    ((_, *place),) = skin.bent(np.array([[0.0, 18.0 + arc / 2, 0.0]]))
    assert place == pytest.approx((middle, 60.0 - middle))


@given(u=st.floats(-400.0, 800.0), high=st.floats(0.0, 9.0))
def test_a_torch_square_to_the_surface_is_over_its_place(u: float, high: float) -> None:
    """The tube turns by A so that the place is on top; u and the height come back."""
    skin = Skin(100.0, 60.0, 12.0)
    ((_, y, z), (_, y1, z1)) = skin.bent(np.array([[0.0, u, high], [0.0, u, high + 1.0]]))
    a = atan2(z1 - z, y - y1)  # of the normal from the lowest line, so A is 90 less it
    turns = round((u - skin.radius * a) / skin.turn - 0.0)
    for k in (turns - 1, turns, turns + 1):
        a_deg = 90.0 - degrees(a) - 360.0 * k
        c, s = cos(radians(a_deg)), sin(radians(a_deg))
        tip = c * (y - 50.0) + s * (z - 30.0), c * (z - 30.0) - s * (y - 50.0)
        found, over, beside = skin.place(*tip, a_deg)
        assert (over, beside) == pytest.approx((high, 0.0), abs=1e-6)
        if abs(found - u) < 1e-6:
            return
    raise AssertionError(u)


def test_a_body_is_seen_square_to_its_surface() -> None:
    """A window of the unrolled surface wrapped, cut out of the tube, and unrolled again."""
    from shapely import box

    skin = Skin(100.0, 100.0, 12.0)
    window = box(100.0, 30.0, 160.0, 70.0)  # over a corner, from 38 to 38 + 6 pi
    left = part_solid(square()) - wrapped(window, skin, -1.0, 7.0)
    seen = unrolled(left, skin, 7.0)
    wanted = box(0.0, 0.0, 400.0, skin.turn).difference(window)
    assert seen.symmetric_difference(wanted).area < 0.01 * window.length


@pytest.mark.exhaustive
@pytest.mark.parametrize("lean", sampled([4.0, 0.0, -6.0], 3))
def test_a_window_that_leans_over_a_corner_agrees(lean: float) -> None:
    part = square(*over_corner(SHS, 2, 150.0, 60.0, lean))
    text = posted(part, TUBE)
    assert not wrong(text, part, TUBE)
    other = square(*over_corner(SHS, 2, 150.0, 60.0, lean + 1.5))
    assert wrong(text, other, TUBE)


def test_what_is_there_of_a_tube_is_as_drawn_and_told_of_no_torch() -> None:
    """A skew end, and a window that leans over a corner: a torch would have cut both otherwise."""
    whole = random_box(17)
    asked = tuple(f for f in whole.features if isinstance(f, Slot))
    made = tuple(f for f in whole.features if not isinstance(f, Slot))
    part = replace(whole, features=asked, made=made)
    text = posted(part, TUBE)
    assert said(text, part, TUBE) == ()
    other = wrong(text, replace(part, features=(replace(asked[0], x=206.0),)), TUBE)
    assert {"solid-extra", "solid-missing"} <= other.keys()


def test_a_skew_end_is_told_by_what_a_square_cut_leaves() -> None:
    """45 degrees in the view of v: 6 mm of the walls u and o, whose inside stays, as wedges."""
    part = square(cuts=EndCuts(web_end=45.0))
    (told,) = said(posted(part, TUBE), part, TUBE)
    assert (told.code, told["what"]) == ("solid-square", "1 end(s) skew through the wall")
    wedges = 2 * 100.0 * 6.0 * 6.0 / 2
    assert 0.8 * wedges < float(str(told["found"])) < 1.1 * wedges
    assert "solid-extra" in wrong(posted(square(), TUBE), part, TUBE)
    assert "solid-missing" in wrong(posted(part, TUBE), square(), TUBE)


def test_corners_of_the_machine_are_those_of_the_solid() -> None:
    bare = replace(square(), profile=replace(SHS, radius=0.0))
    assert TUBE.coper is not None
    machine = replace(TUBE, coper=replace(TUBE.coper, corners=(TubeCorner(6.0, 2.0),)))
    assert not wrong(posted(bare, machine), bare, machine)
    rounder = replace(TUBE, coper=replace(TUBE.coper, corners=(TubeCorner(6.0, 2.2),)))
    assert wrong(posted(bare, machine), bare, rounder)


def test_one_outline_of_a_web_is_that_of_both() -> None:
    cut = [(0.0, 0.0), (400.0, 0.0), (400.0, 60.0), (340.0, 60.0), (340.0, 100.0), (0.0, 100.0)]
    top = [(0.0, 0.0), (340.0, 0.0), (340.0, 100.0), (0.0, 100.0)]
    part = square(outline("v", cut), outline("o", top))
    assert not wrong(posted(part, TUBE), part, TUBE)
