"""The part of a program that copes a profile or turns a tube."""

import re
from collections.abc import Callable
from math import pi
from pathlib import Path

import pytest
from msgspec.structs import replace
from shapely import Point

import beamcam
from beamcam.checks.coping import verify_coping
from beamcam.checks.coping.chart import job_of
from beamcam.checks.coping.required_wall import required_on
from beamcam.checks.coping.section import CoperSection, TubeSection
from beamcam.checks.coping.stock import stock_of
from beamcam.errors import errors_in
from beamcam.geometry.curves import Arc
from beamcam.machine import Machine, load
from beamcam.model.part import EndCuts, Feature, Hole, Part, Profile, Slot, TextMark
from beamcam.pipeline import post
from beamcam.recovery import KnownStock, Recovered, recover
from beamcam.recovery.box_tube import faces_of
from beamcam.recovery.rules import (
    COMES_CUT,
    CORNER,
    LEFT_OUT,
    MANUAL_WORK,
    NOT_PARTED,
    REFITTED,
    ROUNDED,
    UNNAMED,
)
from tests.conftest import SAMPLES, sampled
from tests.random_boxes import over_corner, random_box
from tests.random_copes import random_tee
from tests.random_tubes import window
from tests.runs import call
from tests.unit.coping.samples import (
    AT,
    COPER,
    IPE300,
    L100,
    outline,
    part_of,
    program_of,
    sample,
    with_keys,
)

TUBE = load("tube-linuxcnc")
MACHINES = {
    "coped": COPER, "trimmer": COPER, "cleat": COPER, "hanger": COPER, "brace": TUBE, "stub": TUBE,
    "leg": TUBE, "hip": TUBE, "joist": COPER,
}  # fmt: skip
CHS = Profile("RO", "CHS168.3*8", 168.3, 168.3, 8.0, 8.0)
TOLD = [REFITTED.code, ROUNDED.code]


def made(part: Part, machine: Machine = COPER, skips: tuple[str, ...] = ()) -> str:
    return post((part,), machine, skips=skips).text if skips else program_of(part, machine)


def recovered(text: str, machine: Machine = COPER, stock: KnownStock = KnownStock()) -> Part:  # noqa: B008
    found = recover(text, machine, "jobs/p.ngc", stock)
    assert not errors_in(found.diagnostics), [str(d) for d in found.diagnostics]
    (part,) = found.parts
    return part


def codes(found: Recovered) -> list[str]:
    return [d.code for d in found.diagnostics]


def of(part: Part, kind: type[Feature]) -> list[Feature]:
    """The features of a kind wherever they stand, in the order of their places."""
    found = [replace(f, source=AT) for f in part.features if isinstance(f, kind)]
    return sorted(found, key=lambda f: (f.face, f.x, f.y))  # type: ignore[union-attr]


#: Sections that no catalogue has by their name in the head.
NAMED = {name: sample(name).profile for name in ("hanger", "joist")}


@pytest.mark.parametrize("name", sampled(MACHINES, 2))
def test_each_program_makes_both_parts(name: str) -> None:
    """The law: the first program makes the part that comes back, and the second the first part."""
    part, machine = sample(name), MACHINES[name]
    text = made(part, machine)
    back = recovered(text, machine, KnownStock(NAMED.get(name)))
    again = made(back, machine)
    assert not errors_in(verify_coping(text, (back,), machine))
    assert not errors_in(verify_coping(again, (part,), machine))
    assert (back.mark, back.grade, back.length) == (part.mark, part.grade, part.length)
    assert (back.order, back.drawing) == (part.order, part.drawing)
    assert len(re.findall("^M3 ", again, re.M)) == len(re.findall("^M3 ", text, re.M))


def test_holes_slots_and_outlines_have_their_figures() -> None:
    """Those of samples/coping/coped.nc1; the hole at the corner of a cope is in the outline."""
    part = recovered(made(sample("coped")))
    assert of(part, Hole) == [
        Hole("u", 300.0, 35.0, 18.0, AT), Hole("u", 300.0, 115.0, 18.0, AT),
        Hole("v", 40.0, 90.0, 22.0, AT), Hole("v", 40.0, 160.0, 22.0, AT),
        Hole("v", 900.0, 150.0, 60.0, AT),
    ]  # fmt: skip
    assert of(part, Slot) == [
        Slot("o", 420.0, y, 18.0, 40.0, 0.0, 0.0, AT) for y in (30.0, 120.0)
    ]  # fmt: skip
    shapes = {(c.face, c.kind): c for c in part.contours}
    assert set(shapes) == {("v", "outer"), ("o", "outer"), ("v", "inner")}  # u is a whole one
    curves = shapes["v", "outer"].curves
    places = {(round(x, 6), round(y, 6)) for x, y in (curve.start for curve in curves)}
    assert {(0.0, 0.0), (1200.0, 0.0), (1200.0, 250.0), (1142.0, 250.0), (1130.0, 262.0),
            (1130.0, 300.0), (80.0, 300.0), (0.0, 255.0)} <= places  # fmt: skip
    radii = sorted(c.radius for c in curves if isinstance(c, Arc))
    assert radii == pytest.approx([12.0, 12.5], abs=0.01)
    assert [c.radius for c in shapes["v", "inner"].curves if isinstance(c, Arc)] == (
        pytest.approx([10.0] * 4)
    )
    assert part.profile == sample("coped").profile


@pytest.mark.parametrize("name", sampled(["coped", "trimmer", "cleat"], 3))
def test_the_steel_of_each_wall_is_the_same(name: str) -> None:
    part = sample(name)
    back = recovered(made(part))
    assert COPER.coper is not None
    section = CoperSection(part.profile)
    for face in section.faces:
        walls = [
            required_on(
                job_of(p, COPER, ""), face, section, (), stock_of(p, section, COPER.coper)
            ).cut
            for p in (part, back)
        ]
        off = walls[0].symmetric_difference(walls[1])
        assert off.buffer(-0.015).is_empty


def test_what_crosses_the_seam_of_a_tube_is_one_feature() -> None:
    holes = (Hole("v", 150.0, 0.0, 26.0, AT), Hole("v", 300.0, 100.0, 30.0, AT))
    slot = Slot("v", 220.0, pi * 168.3 - 2.0, 18.0, 14.0, 0.0, 30.0, AT)
    part = Part("T", CHS, 500.0, AT, features=(*holes, slot, window(350.0, -20.0, 60.0, 50.0)))
    back = recovered(made(part, TUBE), TUBE)
    assert {(h.x, h.diameter) for h in back.holes} == {(150.0, 26.0), (300.0, 30.0)}
    for hole, y in zip(sorted(back.holes, key=lambda h: h.x), (0.0, 100.0), strict=True):
        assert (hole.y + 1.0) % (pi * 168.3) - 1.0 == pytest.approx(y, abs=0.005)
    (found,) = of(back, Slot)
    assert isinstance(found, Slot)
    assert (found.diameter, found.length, found.angle) == pytest.approx(
        (18.0, 14.0, 30.0), abs=0.02
    )
    (cut,) = back.contours  # its ends are square: no outline
    assert [c.radius for c in cut.curves if isinstance(c, Arc)] == pytest.approx([12.0] * 4)
    assert not errors_in(verify_coping(made(back, TUBE), (part,), TUBE))


def test_a_program_that_was_edited_makes_what_it_says() -> None:
    """A hole is put 7 mm further along, all blocks of its stroke."""
    text = made(part_of(Hole("v", 300.0, 150.0, 22.0, AT)))
    end = text.index("M5")
    moved = re.sub(r"X([0-9.]+)", lambda m: f"X{float(m[1]) + 7.0:g}", text[:end]) + text[end:]
    part = recovered(moved)
    assert of(part, Hole) == [Hole("v", 307.0, 150.0, 22.0, AT)]
    assert part.length == 600.0


def test_a_far_end_elsewhere_than_the_head_says_gives_the_length() -> None:
    text = made(part_of())
    at = text.index("(far end")
    longer = text[:at] + re.sub(r"X([0-9.]+)", lambda m: f"X{float(m[1]) + 25.0:g}", text[at:])
    assert recovered(longer).length == 625.0


def test_an_axis_that_is_not_the_tip() -> None:
    pivoted = load("coper-linuxcnc")
    assert pivoted.coper is not None
    pivoted = replace(
        pivoted, coper=replace(pivoted.coper, tcp=False, pivot=150.0),
        words=replace(pivoted.words, turn=("G0 Y{y} Z{z} A{a}",)),
        axes=tuple(replace(a, min=a.min - 300.0, max=a.max + 300.0) for a in pivoted.axes),
    )  # fmt: skip
    part = sample("cleat")
    back = recovered(made(part, pivoted), pivoted)
    holes = [(h.face, h.x, h.y, h.diameter) for h in part.holes]
    assert sorted((h.face, h.x, h.y, h.diameter) for h in back.holes) == sorted(holes)


def test_what_is_drawn_and_what_is_the_machines_is_told() -> None:
    sharp = recover(made(sample("cleat")), COPER, "p")
    assert codes(sharp) == TOLD
    assert "found 3 re-entrant corner(s) with the machine's own radius of 10 mm" in str(
        sharp.diagnostics
    )
    drawn = recover(made(sample("trimmer")), COPER, "p")  # its radii are 12 mm
    assert codes(drawn) == [REFITTED.code]
    assert "found 3 contour(s) of chords, taken as lines and arcs within 0.025 mm" in str(
        drawn.diagnostics
    )
    assert codes(recover(made(part_of()), COPER, "p")) == []


def test_marks_and_small_holes_are_told_as_missing() -> None:
    text = TextMark("v", 200.0, 100.0, 0.0, 20.0, "C6", AT)
    found = recover(made(part_of(text)), COPER, "p")
    assert codes(found) == [MANUAL_WORK.code]
    small = part_of(Hole("v", 200.0, 100.0, 6.0, AT), Hole("v", 300.0, 100.0, 22.0, AT))
    found = recover(made(small, skips=("tool",)), COPER, "p")
    assert codes(found) == [LEFT_OUT.code]
    assert len(found.parts[0].features) == 1


def test_a_section_is_named_or_asked_for() -> None:
    odd = replace(IPE300, name="BUILT 300", height=302.0)
    part = part_of(Hole("v", 300.0, 150.0, 22.0, AT), profile=odd)
    text = made(part)
    found = recover(text, COPER, "p")
    assert (codes(found), found.parts) == ([UNNAMED.code], ())
    assert "found the section BUILT 300 in the program's head" in str(found.diagnostics[0])
    assert recovered(text, stock=KnownStock(odd)).profile == odd
    bare = re.sub(r"^\((BEAMCAM|SECTION IPE|PART).*\n", "", made(part_of()), flags=re.M)
    assert codes(recover(bare, COPER, "p")) == [UNNAMED.code]
    found = recover(bare, COPER, "jobs/x.ngc", KnownStock(IPE300, "S235JR"))
    (back,) = found.parts
    assert (back.mark, back.length, back.grade, found.marked) == ("x", 600.0, "S235JR", False)


def test_the_wrong_section_is_refused() -> None:
    """Heights over the steel are those of another web; a tube is no section of this torch."""
    text = made(part_of(Hole("v", 300.0, 150.0, 22.0, AT)))
    wrong = replace(IPE300, web_thickness=12.0)
    assert errors_in(recover(text, COPER, "p", KnownStock(wrong)).diagnostics)
    assert codes(recover(text, COPER, "p", KnownStock(CHS))) == ["verify-coping-section"]


def test_a_piece_that_comes_cut_is_refused() -> None:
    (rest,) = beamcam.read(SAMPLES / "coping" / "header-rest.nc1").parts
    found = recover(made(rest), COPER, "p")
    assert (codes(found), found.parts) == ([COMES_CUT.code], ())


LAW = [(make, seed) for seed in range(5) for make in (random_box, random_tee)]


@pytest.mark.parametrize(("make", "seed"), sampled(LAW, 4))
def test_random_boxes_and_tees_keep_the_law(make: Callable[[int], Part], seed: int) -> None:
    part = make(seed)
    machine = TUBE if part.profile.code == "M" else COPER
    text = made(part, machine)
    back = recovered(text, machine, KnownStock(part.profile))
    assert not errors_in(verify_coping(made(back, machine), (part,), machine))
    assert (back.length, back.profile) == (part.length, part.profile)


RHS = Profile("M", "RHS120*80*5", 120.0, 80.0, 5.0, 5.0, 10.0)


def box_of(*features: Feature, cuts: EndCuts | None = None) -> Part:
    return Part("R", RHS, 500.0, AT, features=features, grade="S235", cuts=cuts or EndCuts())


def test_a_rectangular_tube_has_its_figures() -> None:
    """The radius of its corners, which no name of a section says, is that of the program."""
    part = box_of(
        Hole("h", 100.0, 60.0, 22.0, AT),
        Slot("o", 200.0, 40.0, 16.0, 20.0, 0.0, 0.0, AT),
        *over_corner(RHS, 1, 300.0, 60.0, 0.0),
        cuts=EndCuts(30.0, 0.0, 0.0, -20.0),
    )
    back = recovered(made(part, TUBE), TUBE)
    assert back.profile.radius == 10.0
    assert back.cuts == part.cuts
    assert of(back, Hole) == of(part, Hole)
    (slot,) = of(back, Slot)
    assert isinstance(slot, Slot)
    assert (slot.face, slot.x, slot.y, slot.diameter, slot.length) == ("o", 200.0, 40.0, 16.0, 20.0)
    windows = {c.face: [p for curve in c.curves for p in curve.start] for c in back.contours}
    assert {face: max(places) for face, places in windows.items()} == {"v": 360.0, "o": 360.0}


def surface_of(*gone: object) -> object:
    """Three turns of the surface of a tube without some polygons."""
    from shapely import box, union_all

    turn = TubeSection(RHS, 10.0).turn
    return box(0.0, -turn, 500.0, 2 * turn).difference(union_all(gone))


def test_lines_that_run_together_in_a_corner_are_refused() -> None:
    """A window with two legs on u that are one on v: the corner lies from 30 to 30 + 5 pi."""
    from shapely import Polygon

    high = 30.0 + 5 * pi
    legs = [(100.0, 20.0), (110.0, 20.0), (120.0, 36.0), (130.0, 20.0), (140.0, 20.0),
            (140.0, high + 10.0), (100.0, high + 10.0)]  # fmt: skip
    assert faces_of(surface_of(Polygon(legs)), RHS, 0.025).lost == "u and v"
    assert faces_of(surface_of(), RHS, 0.025).lost == ""
    assert "between faces u and v; expected lines" in str(CORNER.at(AT, found="u and v"))


def test_what_ends_in_a_corner_is_seen_from_its_face() -> None:
    """A slit from u into the first half of the corner: 10 sin t of it beyond the flat."""
    from shapely import box

    faces = faces_of(surface_of(box(100.0, 20.0, 110.0, 30.0 + 10.0 * pi / 6)), RHS, 0.025)
    gone = box(0.0, 0.0, 500.0, 80.0).difference(faces.steel["u"])
    assert gone.bounds == pytest.approx((100.0, 60.0, 110.0, 75.0), abs=0.01)
    assert faces.steel["v"].area == pytest.approx(500.0 * 120.0, abs=0.1)


@pytest.mark.parametrize(("profile", "face"), [(IPE300, "o"), (L100, "u")])
def test_a_wall_that_is_not_parted_is_refused(profile: Profile, face: str) -> None:
    """Without the cut of that face at the far end, which cuts the root of the web too."""
    text = made(part_of(profile=profile))
    at = text.index(f"(far end on face {face}")
    behind = text.find("(far end", at + 5)
    behind = behind if behind > 0 else text.index("M30")
    found = recover(text[:at] + text[behind:], COPER, "p")
    assert codes(found) == [NOT_PARTED.code] * 2
    assert [d.message.split(" that ")[0] for d in found.diagnostics] == [
        f"found no piece of face {one}" for one in ("v", face)
    ]


def test_a_cut_that_is_wrong_by_itself_is_refused_as_verify_does() -> None:
    text = made(sample("trimmer"))
    found = recover(text.replace("M5", "M3 S1", 1), COPER, "p")
    assert (codes(found)[0], found.parts) == ("verify-coping-torch", ())
    hurt = recover(text.replace("G4 P0.4", "G4 P0.1"), COPER, "p")
    assert "verify-coping-pierce" in codes(hurt)


def test_a_coarse_circle_is_a_contour() -> None:
    """A ring of 24 sides is no hole, so nothing says that it was one."""
    sides = list(Point(300.0, 150.0).buffer(40.0, 6).exterior.coords)[:-1]
    back = recovered(made(part_of(outline("v", sides, "inner"))))
    assert not of(back, Hole)
    assert len([*back.contours]) == 1


# The command


def run(*words: object) -> tuple[int, str]:
    done = call(*words)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, done.stderr


@pytest.mark.parametrize("suffix", [".nc1", ".json"])
def test_the_command_writes_the_part_of_the_head(suffix: str, tmp_path: Path) -> None:
    program, back = tmp_path / "a.ngc", tmp_path / f"b{suffix}"
    program.write_text(program_of(sample("coped")))
    code, said = run("recover", program, "-o", back)
    assert code == 0
    assert "note recover-refitted" in said
    (part,) = beamcam.read(back).parts
    assert (part.mark, part.grade) == ("C1", "S235JR")
    assert run("verify", program, "--against", back)[0] == 0


def test_from_python() -> None:
    found = beamcam.recover(made(sample("trimmer")), "coper-linuxcnc")
    assert [part.mark for part in found.parts] == ["C2"]
    narrow = with_keys(corner_radius=15.0)
    assert codes(recover(made(sample("cleat"), narrow), narrow, "p")) == TOLD
