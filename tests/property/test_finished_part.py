"""Laws of the finished part: what is planned lies wholly in the steel that the cuts leave.

The steel is found here by itself, point by point around each circle, from DSTV's own words: an
angle is positive at the start where the top edge is the longest, at the end where the bottom is,
and the part is as long as its longest edge.
"""

from collections.abc import Iterator
from math import cos, pi, radians, sin, tan

import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from shapely.affinity import rotate, translate
from shapely.geometry.base import BaseGeometry

from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.model.part import EndCuts, Hole, Part, Profile, Slot
from beamcam.model.plan import Plan
from beamcam.planning.beam import plan_bar
from beamcam.planning.operations.slot import core_distance
from tests.conftest import examples
from tests.unit.planning.shop import SOURCE

BEAM = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
CHANNEL = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
ANGLE = Profile("L", "L150*100*12", 150.0, 100.0, 12.0, 12.0, 12.0)
TUBE = Profile("M", "RHS200*120*8", 200.0, 120.0, 8.0, 8.0, 12.0)
LIPPED = Profile("C", "C200*70*3", 200.0, 70.0, 3.0, 3.0, 5.0)
TEE = Profile("T", "T100", 100.0, 100.0, 11.0, 11.0, 11.0)
PROFILES = (BEAM, CHANNEL, ANGLE, TUBE, LIPPED)
FACES = {"I": "vou", "U": "vou", "L": "vu", "M": "vou", "C": "vou", "T": "v"}
PUSHER = load("beamline-pusher")
LENGTH = 1500.0


def end_xs(part: Part, y: float, z: float) -> tuple[float, float]:
    """x of the start and of the end at a place of the section."""
    h, b, cuts = part.profile.height, part.profile.width, part.cuts
    corners = [(0.0, 0.0), (h, 0.0), (0.0, b), (h, b)]
    if part.profile.code == "L":
        corners.pop()  # an angle has no steel there

    def lean(web: float, flange: float, at: tuple[float, float]) -> float:
        return -at[0] * tan(radians(web)) - at[1] * tan(radians(flange))

    starts = [lean(cuts.web_start, cuts.flange_start, corner) for corner in corners]
    ends = [lean(cuts.web_end, cuts.flange_end, corner) for corner in corners]
    start = lean(cuts.web_start, cuts.flange_start, (y, z)) - min(starts)
    return start, part.length + lean(cuts.web_end, cuts.flange_end, (y, z)) - max(ends)


def surfaces(profile: Profile, face: str) -> tuple[float, float]:
    """Where the wall behind a face begins and ends, across it."""
    web = profile.web_thickness or 0.0
    if face in "vh":
        if profile.code == "I":
            return (profile.width - web) / 2, (profile.width + web) / 2
        return (profile.width - web, profile.width) if profile.code == "M" else (0.0, web)
    flange = profile.flange_thickness
    return (0.0, flange) if face == "u" else (profile.height - flange, profile.height)


def rim(hole: Hole) -> Iterator[tuple[float, float]]:
    for k in range(48):
        yield (
            hole.x + hole.diameter / 2 * cos(k * pi / 24),
            hole.y + hole.diameter / 2 * sin(k * pi / 24),
        )


def steel(part: Part, hole: Hole) -> float:
    """The least length along the part from the hole's rim to where the part ends; or beyond it."""
    found = []
    for x, across in rim(hole):
        for deep in surfaces(part.profile, hole.face):
            y, z = (across, deep) if hole.face in "vh" else (deep, across)
            start, end = end_xs(part, y, z)
            found += [x - start, end - x]
    return min(found)


def walls(profile: Profile, face: str) -> list[tuple[float, float]]:
    """y on a face between which another wall stands."""
    h, b, s = profile.height, profile.width, profile.web_thickness or 0.0
    t = profile.flange_thickness
    if face in "vh":
        both = [(0.0, t), (h - t, h)]
        return {"L": both[:1], "T": [((h - t) / 2, (h + t) / 2)]}.get(profile.code, both)
    if profile.code == "I":
        return [((b - s) / 2, (b + s) / 2)]
    return [(0.0, s), (b - s, b)] if profile.code == "M" else [(0.0, s)]


def across(part: Part, hole: Hole) -> float:
    """The least distance across the part from the rim to an edge, a wall or its fillet."""
    radius = hole.diameter / 2
    found = [hole.y - radius, part.profile.face_width(hole.face) - hole.y - radius]
    for low, high in walls(part.profile, hole.face):
        fillet = part.profile.radius
        found.append(max(low - fillet - hole.y - radius, hole.y - radius - high - fillet))
    return min(found)


@st.composite
def drilled(draw: st.DrawFn) -> Part:
    profile = draw(st.sampled_from(PROFILES))
    angle = st.sampled_from((0.0, 0.0, 10.0, 30.0, -30.0, -44.0))
    tilts = st.sampled_from((0.0, 0.0, 20.0))
    cuts = EndCuts(draw(angle), draw(angle), draw(tilts), draw(tilts))
    face = draw(st.sampled_from(FACES[profile.code]))
    width = profile.face_width(face)
    y = draw(st.one_of(st.just(width * 0.6), st.floats(-5, width + 5)))
    bare = Part("P1", profile, LENGTH, SOURCE, cuts=cuts)
    depth = surfaces(profile, face)[0]
    start, end = end_xs(bare, y, depth) if face in "vh" else end_xs(bare, depth, y)
    off = draw(st.floats(-10, 40))
    x = draw(st.sampled_from((start + off, end - off)))
    hole = Hole(face, x, y, draw(st.sampled_from((9.0, 18.0))), SOURCE)
    return replace(bare, features=(hole,))


def planned(part: Part) -> Plan | set[str]:
    """The plan, or the codes of what refuses it."""
    try:
        return plan_bar((part,), PUSHER)
    except PlanError as error:
        return {said.code for said in error.diagnostics}


@settings(deadline=None, max_examples=examples(400))
@given(drilled())
def test_what_is_planned_lies_in_the_steel_that_is_left(part: Part) -> None:
    found = planned(part)
    (hole,) = part.features
    assert isinstance(hole, Hole)
    assume(not isinstance(found, set) or not found & {"plan-compound", "plan-flange-cut"})
    if isinstance(found, Plan):
        assert steel(part, hole) >= -0.03
        assert all(
            not low < hole.y + k * hole.diameter / 2 < high
            for low, high in walls(part.profile, hole.face)
            for k in (-1 + 1e-3, 0, 1 - 1e-3)
        )
    elif steel(part, hole) >= 5 and across(part, hole) >= 5:
        pytest.fail(f"refused by {found}")


@settings(deadline=None, max_examples=examples(200))
@given(drilled())
def test_nothing_is_said_of_a_hole_amid_the_steel(part: Part) -> None:
    found = planned(part)
    (hole,) = part.features
    assert isinstance(hole, Hole)
    if isinstance(found, Plan) and steel(part, hole) >= 5 and across(part, hole) >= 5:
        codes = {said.code for said in found.remarks}
        assert not codes & {"plan-near-edge", "plan-near-fillet", "plan-hole-overlap"}


ON_WALLS = [
    (profile, face, (low + high) / 2)
    for profile in (*PROFILES, TEE)
    for face in FACES[profile.code]
    for low, high in walls(profile, face)
]


@pytest.mark.parametrize(("profile", "face", "y"), ON_WALLS)
def test_a_hole_on_another_wall_is_refused(profile: Profile, face: str, y: float) -> None:
    hole = Hole(face, 700.0, y, 8.0, SOURCE)
    found = planned(Part("P1", profile, LENGTH, SOURCE, features=(hole,)))
    assert isinstance(found, set)
    assert found & {"plan-wall", "plan-reach", "plan-off-part"}


@settings(deadline=None, max_examples=examples(200))
@given(
    st.floats(0, 60), st.floats(-30, 30), st.sampled_from((9.0, 14.0, 18.0, 22.0)),
    st.sampled_from((9.0, 14.0, 18.0, 22.0)),
)  # fmt: skip
def test_two_holes_share_no_steel(dx: float, dy: float, first: float, second: float) -> None:
    holes = (
        Hole("v", 700.0, 150.0, first, SOURCE), Hole("v", 700.0 + dx, 150.0 + dy, second, SOURCE)
    )  # fmt: skip
    found = planned(Part("P1", BEAM, LENGTH, SOURCE, features=holes))
    left = (dx * dx + dy * dy) ** 0.5 - (first + second) / 2
    if isinstance(found, set):
        assert left < 0.02
        assert found <= {"plan-hole-overlap", "plan-too-near"}
    else:
        one_hole = first == second and abs(dx) <= 0.0101 and abs(dy) <= 0.0101
        codes = {said.code for said in found.remarks}
        in_other = (dx * dx + dy * dy) ** 0.5 + min(first, second) / 2 <= max(first, second) / 2
        assert not in_other or one_hole or "plan-within" in codes
        if "plan-within" in codes:
            assert first != second
            return
        assert one_hole or left > -0.02
        told = "plan-near-edge" in codes
        assert one_hole or told == (left < 3.0 - 0.01) or abs(left - 3.0) < 0.02


@pytest.mark.parametrize("angle", [0.0, 90.0, 30.0])
def test_a_slot_is_held_against_the_part_by_its_corners(angle: float) -> None:
    def codes(x: float, y: float, face: str = "v") -> set[str]:
        slot = Slot(face, x, y, 20.0, 40.0, 0.0, angle, SOURCE)
        found = planned(Part("P1", BEAM, LENGTH, SOURCE, features=(slot,)))
        return found if isinstance(found, set) else set()

    reach = 20 * abs(cos(radians(angle))) + 10
    assert codes(reach + 4, 150) == set()
    assert "plan-off-part" in codes(reach - 1, 150)
    assert codes(700, 75, "o")  # across the web, or into it


def slots() -> st.SearchStrategy[Slot]:
    return st.builds(
        lambda x, y, d, b, h, angle: Slot("v", 700 + x, 150 + y, d, b, h, angle, SOURCE),
        st.floats(-60, 60), st.floats(-60, 60), st.sampled_from((18.0, 22.0)),
        st.sampled_from((10.0, 40.0)), st.sampled_from((0.0, 0.0, 30.0)), st.floats(-90, 90),
    )  # fmt: skip


@settings(deadline=None, max_examples=examples(150))
@given(slots(), st.one_of(slots(), st.builds(lambda x, y: Hole("v", 700 + x, 150 + y, 18.0, SOURCE),
                                             st.floats(-60, 60), st.floats(-60, 60))))  # fmt: skip
def test_the_distance_of_slots_is_that_of_their_outlines(one: Slot, other: Slot | Hole) -> None:
    def core(shape: Slot | Hole) -> BaseGeometry:
        if isinstance(shape, Hole):
            return shapely.Point(shape.x, shape.y)
        b, h = shape.length / 2, shape.height / 2
        box = shapely.Polygon([(-b, -h), (b, -h), (b, h), (-b, h)]) if h else (
            shapely.LineString([(-b, 0), (b, 0)])
        )  # fmt: skip
        return translate(rotate(box, shape.angle, (0, 0)), shape.x, shape.y)

    assert core_distance(one, other) == pytest.approx(core(one).distance(core(other)), abs=1e-6)


@settings(deadline=None, max_examples=examples(200))
@given(st.floats(60, 700), st.sampled_from((0.0, 30.0, 45.0)), st.sampled_from((0.0, -30.0, -45.0)))
def test_ends_that_cross_are_refused(length: float, start: float, end: float) -> None:
    part = Part("P1", BEAM, length, SOURCE, cuts=EndCuts(start, end))
    left = length - 300 * (tan(radians(start)) - tan(radians(end)))
    try:
        plan = plan_bar((part,), PUSHER, 15000.0)
    except PlanError as error:
        codes = {said.code for said in error.diagnostics}
        assert codes <= {"plan-cuts-cross", "plan-part-short"}
        assert ("plan-cuts-cross" in codes) == (left < -0.01)
    else:
        assert left >= -0.011
        told = "plan-cuts-touch" in {said.code for said in plan.remarks}
        assert told == (abs(left) <= 0.01) or abs(abs(left) - 0.01) < 1e-6
