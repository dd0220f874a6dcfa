"""Cuts of a bar in figures, and ends that header and contours describe."""

from math import cos, radians, sin, tan

import pytest
from msgspec.structs import replace

from beamcam.checks.bars.cuts import off_outline
from beamcam.checks.bars.pieces import ends_of as required_ends
from beamcam.errors import PlanError
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.machine.machine import saw_of
from beamcam.model.part import Bevel, Contour, EndCuts, Part, Profile
from beamcam.model.plan import Plan, SawOp
from beamcam.model.request import Request
from beamcam.model.section import corners
from beamcam.pipeline import plans_of
from beamcam.planning.beam import plan_bar
from beamcam.planning.operations.finished_part import SawnEnd, ends_of, web_borders
from beamcam.planning.operations.outlines import leaves_stock
from beamcam.planning.operations.work import saw_angles
from beamcam.solid.kernel import outline as outline_of_section
from tests.unit.planning.shop import ANGLE, BEAM, CHANNEL, SOURCE, TUBE, part, plan

SAW = saw_of(load("beamline-pusher"))


def cuts(found: Plan) -> list[tuple[str, float, float]]:
    return [
        (op.purpose, round(op.x, 3), op.angle)
        for op in found.operations
        if isinstance(op, SawOp)
    ]  # fmt: skip


def test_square_parts_share_a_cut() -> None:
    found = plan(part(), part(), machine="beamline")
    assert cuts(found) == [
        ("trim", 17.98, 0.0), ("parting", 3022.02, 0.0), ("parting", 6026.06, 0.0)
    ]  # fmt: skip
    assert found.operations[1].reasons == ("cut-parting-both",)


def test_parts_that_share_an_angle_share_a_cut() -> None:
    skew = part(cuts=EndCuts(30.0, 30.0))
    found = plan(skew, skew, machine="beamline")
    kerf = 4.04 / cos(radians(30))
    lean = 300 * tan(radians(30))
    assert [c[0] for c in cuts(found)] == ["mitre", "common", "mitre"]
    first, second = found.pieces
    # Both ends lean the same way, so the second part lies in the first one's wedge.
    assert second.start == pytest.approx(first.end + kerf - lean)
    assert found.bar.nested == pytest.approx(lean)
    assert found.bar.length == pytest.approx(20 + 6000 + 2 * kerf - lean)
    common = found.operations[1]
    assert isinstance(common, SawOp)
    assert (common.pieces, common.reasons) == ((0, 1), ("cut-common",))


def test_a_dialect_without_common_cuts_parts_each_of_them() -> None:
    skew = part(cuts=EndCuts(30.0, 30.0), profile=CHANNEL)
    found = plan(skew, skew, machine="beamline-annex")
    assert [c[0] for c in cuts(found)] == ["mitre", "mitre", "parting", "mitre", "mitre"]
    assert found.bar.nested == 0


def test_angles_are_counted_as_the_machine_counts() -> None:
    found = plan(part(cuts=EndCuts(web_end=-20.0, flange_start=30.0)))
    first = found.operations[0]
    assert isinstance(first, SawOp)
    assert (first.angle, first.tilt, first.at) == (90.0, pytest.approx(30.0), "start")
    last = found.operations[1]
    assert isinstance(last, SawOp)
    assert (last.angle, last.tilt) == (70.0, 0.0)


def test_a_compound_cut_tilts_in_the_turned_plane() -> None:
    saw = load("beamline-pusher").saw
    assert saw is not None
    angle, tilt = saw_angles(SawnEnd("end", 40.0, 0.0, 35.0), saw)
    assert angle == 130.0
    # The plane's normal is along (1, tan w, tan f); its part along z is sin(tilt) of the whole.
    normal = (1.0, tan(radians(40)), tan(radians(35)))
    size = sum(n * n for n in normal) ** 0.5
    assert cos(radians(tilt)) == pytest.approx((size**2 - normal[2] ** 2) ** 0.5 / size)


def test_dead_zone_and_trims_stand_in_the_account() -> None:
    machine = load("beamline-pusher")
    assert machine.layout is not None
    machine = replace(machine, layout=replace(machine.layout, end_trim=10.0))
    bar = plan_bar([part()], machine).bar
    assert (bar.front_trim, bar.remnant, bar.end_trim) == (15.0, pytest.approx(280.0), 10.0)
    assert bar.length == pytest.approx(15 + 3000 + 1.6 + 280 + 10)
    assert plan_bar([part()], machine, 4000.0).bar.remnant == pytest.approx(4000 - 3026.6)


SECTIONS = (
    BEAM, ANGLE, TUBE, replace(TUBE, radius=20.0), replace(BEAM, code="T"),
    Profile("C", "C200", 200.0, 70.0, 4.0, 4.0, 6.0), Profile("RU", "RD60", 60.0, 60.0, 0.0, 60.0),
    Profile("RO", "CHS168", 168.3, 168.3, 8.0, 8.0), Profile("B", "FL", 150.0, 0.0, 0.0, 20.0),
)  # fmt: skip


@pytest.mark.parametrize("profile", SECTIONS, ids=lambda profile: profile.code)
def test_corners_are_the_furthest_places_of_the_solid_section(profile: Profile) -> None:
    drawn = outline_of_section(part(profile=profile)).exterior.coords
    within = 4.2 if profile.code == "C" else 0.05  # whose solid has sharp bends
    for turn in range(0, 360, 7):
        u, v = cos(radians(turn)), sin(radians(turn))
        reach = max(y * u + z * v for y, z in corners(profile))
        assert reach == pytest.approx(max(y * u + z * v for y, z in drawn), abs=within)


def test_a_mitred_angle_touches_its_length_with_steel() -> None:
    """Leaned both ways, an angle ends at a leg's edge and not at the box's corner."""
    angle = part(profile=ANGLE, cuts=EndCuts(web_start=20.0, flange_start=10.0))
    start, _ = ends_of(angle, SAW)[0]
    assert start.x0 == pytest.approx(150 * tan(radians(20)) + 12 * tan(radians(10)))
    assert min(start.x(y, z) for y, z in corners(ANGLE)) == pytest.approx(0.0)


def outline(face: str, *points: tuple[float, float], bevels: tuple[Bevel, ...] = ()) -> Contour:
    chain = tuple(Line(a, b) for a, b in zip(points, (*points[1:], points[0]), strict=True))
    return Contour(face, "outer", chain, SOURCE, bevels=bevels)


def flange_cut_part(*faces: str) -> Part:
    skew = ((0.0, 0.0), (3000.0, 0.0), (2900.0, 150.0), (0.0, 150.0))
    return part(*(outline(face, *skew) for face in faces))


def test_a_flange_cut_that_both_flanges_show_is_sawn() -> None:
    (_, end), said = ends_of(flange_cut_part("o", "u"), SAW)
    assert end.flange_deg == pytest.approx(33.69, abs=0.01)
    assert [d.code for d in said] == ["plan-cut-from-contour"]


def test_one_skew_flange_alone_is_a_cope() -> None:
    (_, end), said = ends_of(flange_cut_part("u"), SAW)
    assert end.flange_deg == 0.0
    assert said == ()
    with pytest.raises(PlanError) as caught:
        plan_bar([flange_cut_part("u")], load("beamline-pusher"))
    assert [d.code for d in caught.value.diagnostics] == ["plan-cope"]


def test_the_webs_contour_may_be_as_long_as_either_side_of_it_under_a_flange_cut() -> None:
    tilted = part(cuts=EndCuts(flange_end=30.0), profile=CHANNEL)
    ends = ends_of(tilted, SAW)[0]
    low, high = web_borders(CHANNEL, "v")
    for z in (low, high):
        x = ends[1].x(0.0, z)
        web = outline("v", (0, 0), (x, 0), (x, 200), (0, 200))
        assert leaves_stock(web, tilted, ends) is None
    wrong = outline("v", (0, 0), (2990, 0), (2990, 200), (0, 200))
    assert leaves_stock(wrong, tilted, ends) is not None


@pytest.mark.parametrize("way", [(0, 2, 1, 3), (1, 0, 2, 3), (3, 1, 0, 2)])
def test_an_outline_across_its_face_is_no_stock_though_its_corners_are(
    way: tuple[int, ...],
) -> None:
    corners_of_web = ((0.0, 0.0), (3000.0, 0.0), (3000.0, 200.0), (0.0, 200.0))
    flat = part(profile=CHANNEL)
    crossed = outline("v", *(corners_of_web[k] for k in way))
    assert leaves_stock(crossed, flat, ends_of(flat, SAW)[0]) is not None
    assert off_outline(crossed, flat, required_ends(flat, SAW)) is not None
    right = outline("v", *corners_of_web)
    assert leaves_stock(right, flat, ends_of(flat, SAW)[0]) is None
    assert off_outline(right, flat, required_ends(flat, SAW)) is None


def test_a_bevel_that_the_flange_cut_leaves_on_the_web_is_no_weld_preparation() -> None:
    x = 3000.0
    web = outline("v", (0, 0), (x, 0), (x, 200), (0, 200), bevels=(Bevel(1, 30.0, 0.0),))
    tilted = part(web, cuts=EndCuts(flange_end=30.0), profile=CHANNEL)
    assert plan_bar([tilted], load("beamline-pusher")).outcomes[0].by == "saw"


def test_what_is_left_of_the_bar_holds_its_last_part() -> None:
    long, short = part(length=3000.0), part(length=145.0)
    found = plan(long, short, machine="beamline")
    last = found.pieces[-1]
    assert found.bar.length == pytest.approx(last.start + 1200)
    assert found.bar.remnant == pytest.approx(1200 - 145 - 4.04)
    assert found.bar.total == pytest.approx(found.bar.length)
    turned_round = plan(short, long, machine="beamline")  # the long one holds itself
    assert turned_round.bar.remnant == 0.0
    with pytest.raises(PlanError) as caught:
        plan(long, short, machine="beamline", bar=3900.0)
    assert [said.code for said in caught.value.diagnostics] == ["plan-bar-left"]

    request = Request((long, short), load("beamline"), stock=(3900.0, 4500.0, 12000.0))
    (planned,) = plans_of(request)
    assert isinstance(planned.plan, Plan)
    assert planned.plan.bar.length == 4500.0


@pytest.mark.parametrize("web_end", [30.0, -30.0])
def test_nothing_is_squared_behind_a_skew_end_at_the_end_of_the_bar(web_end: float) -> None:
    skew = part(cuts=EndCuts(web_end=web_end))
    assert [c[0] for c in cuts(plan(skew, machine="beamline"))] == ["trim", "mitre"]
    more = plan(skew, machine="beamline", bar=6000.0)
    assert [c[0] for c in cuts(more)] == ["trim", "mitre", "parting"]
    # The gripper holds a rest, so there is always one.
    assert [c[0] for c in cuts(plan(skew, machine="beamline-pusher"))][-1] == "parting"
