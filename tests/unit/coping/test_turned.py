"""Profiles that turn in a chuck below an upright torch: by hand, read back, by strangers."""

import random
import re
from collections.abc import Callable
from itertools import pairwise
from math import cos, dist, hypot, radians, sin
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.coping.lying import lying
from beamcam.checks.coping.program import strokes_of
from beamcam.errors import BeamcamError, MachineError, PlanError, errors_in
from beamcam.machine import load
from beamcam.machine.overlay import with_section
from beamcam.model.part import Hole, Part
from beamcam.model.request import Request
from beamcam.pictures import ReadProgram
from beamcam.planning.coping.plan import plan_coping
from beamcam.recovery import recover
from beamcam.setup_sheet.content import SheetSources, content_of
from beamcam.solid.opinion import solid_faults
from beamcam.solid.part_solid import part_solid
from benchmarks import coping_faults
from tests.conftest import examples, sampled
from tests.random_copes import random_cope, random_lipped, random_mitre, random_slant, random_tee
from tests.rs274 import needs_rs274
from tests.unit.coping.samples import (
    AT,
    COPER,
    IPE300,
    L100,
    UPN200,
    part_of,
    program_of,
    sample,
)
from tests.unit.coping.test_rs274 import CHART, Burn, burns, compare, pieces
from tests.unit.coping.test_tubes import TUBE, found

NAMES = ("coped", "trimmer", "cleat", "hanger", "joist", "lintel-rest")
MAKERS = (
    random_cope, random_tee, random_slant, random_mitre, random_lipped, coping_faults.random_held
)  # fmt: skip
HOLES = (Hole("v", 200.0, 120.0, 26.0, AT), Hole("o", 300.0, 45.0, 26.0, AT))
U = part_of(*HOLES, profile=UPN200)
JOIST, LINTEL = sample("joist"), sample("lintel-rest")

MOVE = re.compile(r"G[01] X(\S+) Y(\S+) Z(\S+)(?: A(\S+) F(\S+))?")


def cuts(text: str) -> dict[str, list[list[float]]]:
    """X, Y, Z, A and F of the blocks with the torch on, by what a program calls them."""
    found: dict[str, list[list[float]]] = {}
    name = ""
    for line in text.splitlines():
        name = line.strip("()") if line.startswith("(") else name
        if (move := MOVE.fullmatch(line)) and move[5]:
            found.setdefault(name, []).append([*map(float, move.groups())])
    return found


# --- by hand --------------------------------------------------------------------------------------


def test_the_blocks_of_a_channel_worked_by_hand() -> None:
    """Its middle is 100 and 37.5 mm from the outsides: the web lies 29 mm below the axis at A 0, an
    upper flange 100 mm above it at A -90."""
    made = cuts(program_of(U, TUBE))
    web, flange = made["cut-out on face v"], made["cut-out on face o"]
    # 8.5 mm are cut at 3000 mm/min with a kerf of 2.2, 11.5 at 2550 with 2.4; the tip 3 mm above.
    assert {(z, a) for _, _, z, a, _ in web} == {(-26.0, 0.0)}
    assert {(z, a) for _, _, z, a, _ in flange} == {(103.0, -90.0)}
    for blocks, x, across, size in (
        (web, 230.0, 20.0, 23.8), (flange, 330.0, 37.5 - 45.0, 23.6)
    ):  # fmt: skip
        ring = blocks[2:]
        xs, ys = [b[0] for b in ring], [b[1] for b in ring]
        assert (min(xs), max(xs)) == pytest.approx((x - size / 2, x + size / 2), abs=0.03)
        assert (min(ys), max(ys)) == pytest.approx((across - size / 2, across + size / 2), abs=0.03)
    assert (web[0][4], flange[0][4]) == (1000.0, 637.5)  # 3 and 4 mm down
    for blocks, feed in ((web, 3000.0), (flange, 2550.0)):
        for before, block in pairwise(blocks):
            assert dist(before[:3], block[:3]) * block[4] == pytest.approx(feed, rel=2e-3)


def test_it_is_cut_with_the_bar_in_the_chuck_and_says_how_it_is_held() -> None:
    plan = plan_coping((U,), TUBE)
    assert plan.bar == 600.0 + 2 * 30.0 + 250.0
    assert [cut.kind for cut in plan.operations[:2]] == ["inner"] * 2
    assert {cut.kind for cut in plan.operations[2:5]} == {"near"}
    assert {cut.kind for cut in plan.operations[5:]} == {"far"}
    lines = program_of(U, TUBE).splitlines()
    assert "(AT A 0 FACE V IS UP, FACE U TO Y-)" in lines
    assert "(IT TURNS ABOUT THE MIDDLE OF HEIGHT AND WIDTH)" in lines
    tee = program_of(sample("hanger"), TUBE).splitlines()
    assert "(THE T LIES ON ITS SIDE: FACE H TO Y-, FACE U UP)" in tee


def test_it_turns_with_the_torch_clear_of_its_corners() -> None:
    """They sweep a circle of 106.8 mm; the torch keeps 20 mm off it."""
    lines = program_of(U, TUBE).splitlines()
    turns = [k for k, line in enumerate(lines) if line.startswith("G0 A")]
    assert len(turns) >= 5
    for k in turns:
        at = MOVE.fullmatch(lines[k - 1])
        assert at is not None
        assert float(at[3]) == pytest.approx(hypot(200.0, 75.0) / 2 + 20.0, abs=1e-3)
        assert next((line for line in reversed(lines[:k]) if line[0] == "M"), "M5") == "M5"


@pytest.mark.parametrize(("profile", "code"), [
    (replace(IPE300, height=310.0), "plan-section"),
    (replace(UPN200, code="C"), "plan-coping-lip"),
    (replace(UPN200, width=290.0), "plan-coping-deep"),
])  # fmt: skip
def test_sections_that_it_does_not_take(profile: object, code: str) -> None:
    with pytest.raises(PlanError) as error:
        plan_coping((part_of(profile=profile),), TUBE)  # type: ignore[arg-type]
    assert [d.code for d in error.value.diagnostics] == [code]


@pytest.mark.parametrize(("axis", "least"), [("Z", "-150 to 232.1"), ("Y", "-156.8 to 156.8")])
def test_its_axes_come_to_webs_and_flanges(axis: str, least: str, tmp_path: Path) -> None:
    """They go 2 mm and a kerf of 4.8 at most beyond an edge; a web lies at the back of a U."""
    rows = [row for row in TUBE.axes if row.moves != axis]
    (own,) = (row for row in TUBE.axes if row.moves == axis)
    text = "".join(
        f'[[axes]]\nname = "{row.name}"\nmoves = "{row.moves}"\nspeed = {row.speed}\n'
        f"acceleration = {row.acceleration}\n"
        + (f"min = {row.min}\nmax = {row.max}\n" if row.max is not None else "")
        for row in (*rows, replace(own, min=-100.0))
    )
    for name, sections, wrong in (("all", "", True), ("round", '["RO"]', False)):
        path = tmp_path / f"{name}.toml"
        only = f"[coper]\nprofiles = {sections}\n" if sections else ""
        path.write_text(f'base = "tube-linuxcnc"\n{only}{text}')
        if not wrong:
            load(str(path))
            continue
        said = re.escape(f"{least} at least, for walls that turn")
        with pytest.raises(MachineError, match=said):
            load(str(path))


def test_a_c_turns_with_its_lips_down_at_a_0() -> None:
    """200 x 75 of a sheet of 2.5: the web lies 37.5 mm above the axis, flanges 100 mm off it."""
    assert "(THE C LIES ON ITS LIPS: FACE O TO Y-, FACE H UP)" in program_of(JOIST, TUBE)
    made = cuts(program_of(JOIST, TUBE))
    assert {(z, a) for _, _, z, a, _ in made["cut-out on face v"]} == {(40.5, 0.0)}
    lips = made["far end on face o, through the lip"]
    assert {(z, a) for _, _, z, a, _ in lips} == {(103.0, -90.0)}
    # The row up to 22 mm, 20 and root_over: half of its kerf of 3 behind the end at 30 + 1400.
    assert {x for x, *_ in lips[1:]} == {1431.5}
    # It begins over the flange, a wall of 2.5, a bend of 3.5 and 1 mm of lap off the edge at 37.5.
    assert lips[1][1] == 30.5
    assert 37.5 < lips[-1][1] < 42.5
    with pytest.raises(PlanError) as error:
        plan_coping((replace(JOIST, profile=replace(JOIST.profile, lip=None)),), TUBE)
    assert [d.code for d in error.value.diagnostics] == ["plan-coping-lip"]
    given = plan_coping(
        (replace(JOIST, profile=replace(JOIST.profile, lip=None)),), with_section(TUBE, None, 20.0)
    )
    assert given.operations == plan_coping((JOIST,), TUBE).operations
    assert "plan-coping-given-lip" in {d.code for d in given.remarks}


def test_a_piece_that_comes_cut_is_held_by_its_own_end() -> None:
    """1600 mm from X 30 on, the last 250 in the chuck: behind X 1380."""
    plan = plan_coping((LINTEL,), TUBE)
    assert plan.bar == 1600.0
    assert [(cut.kind, cut.face) for cut in plan.operations] == [
        ("inner", "v"), ("near", "o"), ("near", "v")
    ]  # fmt: skip
    (told,) = (d for d in plan.remarks if d.code == "plan-coping-piece")
    assert told.message.endswith("face v up, face u to Y-, its last 250 mm in the chuck")
    lines = program_of(LINTEL, TUBE).splitlines()
    first = lines.index("(AT A 0 FACE V IS UP, FACE U TO Y-)")
    assert lines[first + 1 : first + 5] == [
        "(IT TURNS ABOUT THE MIDDLE OF HEIGHT AND WIDTH)", "(COMES CUT: ITS X 0 END AT X 30)",
        "(THE CHUCK HOLDS IT BEHIND X 1380)", "(WHAT ITS FILE CALLS MADE IS THERE)",
    ]  # fmt: skip


@pytest.mark.parametrize(("x", "codes"), [(1329.0, []), (1331.5, ["plan-coping-chuck"])])
def test_what_the_chuck_holds_is_not_cut(x: float, codes: list[str]) -> None:
    """A hole of 26 ends 13 - 1.1 mm behind its middle; the torch is 12 wide: x 1344 at most."""
    part = replace(LINTEL, features=(Hole("v", x + 3.1, 110.0, 26.0, AT),))
    if not codes:
        text = program_of(part, TUBE)
        turned = text.index("M30")
        for at, wrong in ((1373.9, []), (1374.1, ["verify-coping-zone"])):
            moved = f"{text[:turned]}G0 X{at}\n{text[turned:]}"
            assert [d.code for d in found(moved, part)] == wrong
        return
    with pytest.raises(PlanError) as error:
        plan_coping((part,), TUBE)
    assert [d.code for d in error.value.diagnostics] == codes
    assert "expected none beyond x 1344," in str(error.value)


# --- read back ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sampled(NAMES, 6))
def test_samples_are_read_back_by_all(name: str) -> None:
    part = sample(name)
    text = program_of(part, TUBE)
    told = {d.code for d in solid_faults(text, Request((part,), TUBE))}
    assert told <= {"solid-rounded", "solid-square"}


@given(st.integers(0, 5000), st.sampled_from(MAKERS))
@settings(max_examples=examples(30))
def test_seen_from_the_bar_a_torch_goes_round_it(seed: int, make: Callable[[int], Part]) -> None:
    """No random part that is planned is refused; each cut is that of a torch that goes round."""
    part = make(seed)
    try:
        text = program_of(part, TUBE)
    except PlanError:
        return
    there, wrong = strokes_of(text, lying(part), TUBE, "JOB")
    assert not errors_in(wrong)
    round_it, _ = strokes_of(program_of(part, COPER), lying(part), COPER, "JOB")
    assert [(s.face, s.row) for s in there] == [(s.face, s.row) for s in round_it]
    for one, other in zip(there, round_it, strict=True):
        assert max(map(dist, one.points, other.points)) < 2e-3


@pytest.mark.parametrize(
    "make", [*sampled([random_cope, random_slant, random_lipped], 3), random_tee]
)
def test_wrong_programs_are_refused(make: Callable[[int], Part]) -> None:
    part = make(4)
    own = {
        "A off its face", "A the other way round", "A of a place", "F of a block",
        "no inverse time",
        "face left out", "mirrored along", "over the chuck", "first turn too low", "into a wall",
        "tip too low", "cut left out", "twice", "order",
    }  # fmt: skip
    kinds = set()
    for k, (kind, text) in enumerate(coping_faults.faults(part, TUBE, random.Random(3))):
        if kind in own or kind == "turned too low" or k % 3 == 0:
            assert found(text, part), kind
            kinds.add(kind)
    assert kinds > own
    # A T has no steel at two corners of its box.
    assert ("turned too low" in kinds) == (part.profile.code in ("I", "U", "C"))


def test_wrong_programs_for_pieces_that_come_cut_are_refused() -> None:
    kinds = set()
    for kind, text in coping_faults.faults(LINTEL, TUBE, random.Random(3)):
        assert found(text, LINTEL), kind
        kinds.add(kind)
    assert kinds > {"taken for a bar", "over the chuck", "cut left out", "moved along", "twice"}


def test_a_flange_that_is_cut_with_the_bar_the_other_way_round_is_refused() -> None:
    """A hole of o at A 90 is one of u."""
    text = program_of(U, TUBE)
    said = found(re.sub(r"A(-?)90", lambda m: f"A{'' if m[1] else '-'}90", text), U)
    assert {d.code for d in said} >= {"verify-coping-hurt", "verify-coping-left"}


def test_a_torch_in_the_way_of_the_first_turn_is_seen() -> None:
    """How the bar stands before it is not known; 106.8 mm and 0.5 of play are clear."""
    text = program_of(U, TUBE)
    high = re.search(r"Z(\S+)\nG0 A", text)
    assert high is not None
    for z, wrong in ((107.4, []), (107.2, ["verify-coping-strikes"])):
        lowered = text.replace(f"Z{high[1]}\nG0 A", f"Z{z}\nG0 A", 1)
        assert [d.code for d in found(lowered, U)] == wrong
    # A bar that is turned before the torch goes anywhere has it where the operator left it.
    turned = re.sub(r"(G0 X\S+ Y\S+ Z\S+\n)(G0 A\S+\n)", r"\2\1", text, count=1)
    assert turned != text
    assert not found(turned, U)


def test_the_speed_of_a_block_may_be_said_in_mm_a_minute() -> None:
    """A stands still, so that F of G94 is the speed in the steel."""
    text = program_of(U, TUBE)
    begin = text.index("G93")
    end = text.index("M5", begin)
    assert text[:begin].splitlines()[-6] == "(cut-out on face o)"
    for feed, wrong in (("F2550", False), ("F3000", True)):
        plain = re.sub(r" F\S+", f" {feed}", text[begin:end].replace("G93", "G94"))
        assert bool(found(text[:begin] + plain + text[end:], U)) == wrong


@pytest.mark.parametrize("name", sampled(NAMES[:3], 3))
def test_a_program_gives_its_part_back(name: str) -> None:
    part = sample(name)
    text = program_of(part, TUBE)
    (again,) = recover(text, TUBE, "JOB").parts
    assert again.profile.code == part.profile.code
    assert not found(text, again)
    of_coper = recover(program_of(part, COPER), COPER, "JOB").parts
    kinds = [(type(f).__name__, getattr(f, "face", "")) for f in again.features]
    assert kinds == [(type(f).__name__, getattr(f, "face", "")) for f in of_coper[0].features]


def test_a_setup_sheet_shows_the_torch_where_it_is_on_the_bar() -> None:
    part = sample("coped")
    ways = []
    for machine in (TUBE, COPER):
        text = program_of(part, machine)
        program = ReadProgram(text.encode(), machine, "c.ngc", parts=(part,))
        content = content_of(SheetSources(program, None, ()))
        strokes = content.made.strokes  # type: ignore[union-attr]
        ways.append([content.trace.positions[b, :2].tolist() for _, b, _ in strokes])
    assert len(ways[0]) == 14
    for here, there in zip(*ways, strict=True):
        assert here == pytest.approx(there, abs=0.01)


# --- strangers ------------------------------------------------------------------------------------


def turned_back(burn: Burn, part: Part) -> Burn:
    """A stroke as seen from the bar, whose box turned about its middle, at the speed of its row."""
    high, wide = part.profile.height / 2, part.profile.width / 2
    if part.profile.code == "T":
        high, wide = wide, high
    feed = min(CHART, key=lambda one: abs(one - burn.feed))
    assert burn.feed == pytest.approx(feed, rel=5e-3)

    def seen(place: tuple[float, ...]) -> tuple[float, ...]:
        x, y, z, a_deg, b_deg = place
        c, s = cos(radians(a_deg)), sin(radians(a_deg))
        return x, high + y * c - z * s, wide + y * s + z * c, a_deg, b_deg

    return Burn(feed, [*map(seen, burn.points)])


def check(part: Part, folder: Path) -> None:
    """The heaviest piece of the bar that rs274 turns and cuts is the part."""
    path = folder / "part.ngc"
    path.write_text(program_of(part, TUBE))
    stock = None
    if part.made is not None:
        stock = part_solid(replace(part, features=part.made, made=None))
    whole = replace(part, features=(*part.features, *(part.made or ())), made=None)
    compare(whole, pieces(part, [turned_back(burn, part) for burn in burns(path)], stock)[0])


@needs_rs274
@pytest.mark.parametrize("name", sampled(NAMES, 3))
def test_samples_fall_out_of_the_bar_that_rs274_turns(name: str, tmp_path: Path) -> None:
    check(sample(name), tmp_path)


@needs_rs274
@pytest.mark.parametrize(
    "make", [random_cope, random_tee, random_lipped, coping_faults.random_held]
)
@pytest.mark.parametrize("seed", sampled([0, 1, 3, 5, 8, 11], 2))
def test_random_parts_fall_out_of_the_bar(
    make: Callable[[int], Part], seed: int, tmp_path: Path
) -> None:
    part = make(seed)
    try:
        plan_coping((part,), TUBE)
    except BeamcamError:
        return
    check(part, tmp_path)


@needs_rs274
def test_an_angle_that_turns_is_cut_on_its_contour(tmp_path: Path) -> None:
    """Places of a hole in each leg of L100*65*8, half a kerf of 2.2 within its radius of 13."""
    part = part_of(Hole("v", 200.0, 60.0, 26.0, AT), Hole("u", 300.0, 40.0, 26.0, AT), profile=L100)
    path = tmp_path / "angle.ngc"
    path.write_text(program_of(part, TUBE))
    holes = [turned_back(burn, part) for burn in burns(path)][:2]
    assert sorted(burn.points[0][3] for burn in holes) == [0.0, 90.0]
    for burn in holes:
        for x, y, z, a_deg, _ in burn.points[2:]:
            if a_deg:  # the leg that lies at Y 0, looked at from outside
                assert y == pytest.approx(-3.0, abs=1e-3)
                off = hypot(x - 330.0, z - 40.0)
            else:
                assert z == pytest.approx(8.0 + 3.0, abs=1e-3)
                off = hypot(x - 230.0, y - 60.0)
            assert off == pytest.approx(13.0 - 1.1, abs=0.015)
