"""The plan of a coper: hand-worked figures, laws, and each thing that it refuses."""

from math import cos, inf, pi, sin, sqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from shapely import LineString, MultiPoint, Point, Polygon

from beamcam.checks.coping.section import kerf_of
from beamcam.errors import PlanError
from beamcam.geometry.curves import Arc
from beamcam.machine import Machine
from beamcam.machine.coper import SupportZone
from beamcam.model.part import Bend, Bevel, Contour, Hole, Part, Profile, Slot, TextMark
from beamcam.model.plan import CopePlan
from beamcam.planning.coping.plan import ORDER, plan_coping
from beamcam.planning.coping.regions import region_of
from beamcam.planning.coping.rules import RULES
from beamcam.planning.coping.walls import walls_of
from beamcam.planning.manual_list import manual_rows
from tests.conftest import examples
from tests.random_copes import random_cope
from tests.unit.coping.samples import (
    AT,
    COPER,
    IPE300,
    L100,
    NAMES,
    UPN200,
    outline,
    part_of,
    program_of,
    sample,
    with_keys,
)

CORNERED = [(0.0, 0.0), (600.0, 0.0), (600.0, 300.0), (80.0, 300.0), (80.0, 250.0), (0.0, 250.0)]
BACK = outline("o", [(80.0, 0.0), (600.0, 0.0), (600.0, 150.0), (80.0, 150.0)])


def planned(part: Part, machine: Machine = COPER) -> CopePlan:
    return plan_coping((part,), machine)


def test_how_near_the_torch_comes_to_a_flange() -> None:
    assert COPER.coper is not None
    # 6 mm of torch; a fillet of 15 mm, 3 mm over the web, 0.5 mm clear: a circle of 14.5 mm.
    assert COPER.coper.reach_beside(15.0, 3.0) == pytest.approx(6.0 + 15.0 - sqrt(14.5**2 - 12**2))
    assert COPER.coper.reach_beside(0.0, 3.0) == 6.5
    assert COPER.coper.reach_beside(2.0, 3.0) == 6.5


@pytest.mark.parametrize(
    ("profile", "face", "low", "high"),
    [
        (IPE300, "v", 10.7 + 12.86, 300.0 - 10.7 - 12.86), (IPE300, "o", -inf, inf),
        (UPN200, "v", 11.5 + 10.52, 200.0 - 11.5 - 10.52), (L100, "v", 8.0 + 9.58, inf),
        (L100, "u", -inf, inf),
    ],
)  # fmt: skip
def test_where_the_torch_comes_to(profile: Profile, face: str, low: float, high: float) -> None:
    assert COPER.coper is not None
    wall = walls_of(profile, COPER.coper, 3.0)[face]
    assert (wall.low, wall.high) == (pytest.approx(low, abs=0.01), pytest.approx(high, abs=0.01))


def test_an_angle_has_no_upper_flange() -> None:
    assert COPER.coper is not None
    assert sorted(walls_of(L100, COPER.coper, 3.0)) == ["u", "v"]


def test_a_square_end_is_cut_half_a_kerf_off() -> None:
    plan = planned(part_of())
    assert [(c.kind, c.face, c.root, c.row.up_to) for c in plan.operations] == [
        ("near", "o", True, 25.0), ("near", "v", False, 10.0), ("near", "u", True, 25.0),
        ("far", "u", True, 25.0), ("far", "v", False, 10.0), ("far", "o", True, 25.0),
    ]  # fmt: skip
    for cut in plan.operations:
        off = cut.row.kerf / 2
        edge = -off if cut.kind == "near" else 600.0 + off
        assert all(x == pytest.approx(edge) for x, _ in cut.path[1:])
        way = -1.0 if cut.kind == "near" else 1.0  # the lead, in scrap
        assert way * (cut.path[0][0] - edge) == pytest.approx(8.0, abs=0.1)


def test_a_sharp_corner_gets_the_radius_of_the_machine() -> None:
    assert COPER.coper is not None
    part = part_of(outline("v", CORNERED), BACK)
    wall = walls_of(IPE300, COPER.coper, 3.0)["v"]
    region, said = region_of(wall, part, [0], COPER.coper)
    assert not said
    assert region.rounded == {(80.0, 250.0): 10.0}
    more = region.shape.area - (600.0 * 300.0 - 80.0 * 50.0)
    assert more == pytest.approx(100.0 * (1 - pi / 4), abs=0.3)
    told = [d.message for d in planned(part).remarks if d.code == "plan-coping-rounded"]
    assert told == ["found 1 sharp re-entrant corner(s) on face v, cut with a radius of 10 mm"]


@settings(max_examples=examples(6))
@given(st.floats(14.0, 22.0), st.floats(0.0, 0.95), st.floats(-pi, pi))
def test_a_relief_in_a_corner_is_as_round_as_it_is_drawn(
    diameter: float, share: float, way: float
) -> None:
    """A hole over a corner is its radius: no steel of the machine's own stays beside it."""
    assert COPER.coper is not None
    far = share * diameter / 2
    relief = Hole("v", 80.0 + far * cos(way), 250.0 + far * sin(way), diameter, AT)
    part = part_of(outline("v", CORNERED), BACK, relief)
    region, said = region_of(walls_of(IPE300, COPER.coper, 3.0)["v"], part, [0, 2], COPER.coper)
    disc = Point(relief.x, relief.y).buffer(diameter / 2, 256)
    drawn = Polygon([*CORNERED, CORNERED[0]]).difference(disc)
    assert not said
    assert not region.rounded
    assert region.shape.symmetric_difference(drawn).area < 0.5
    program_of(part)


def test_a_hole_beside_a_corner_is_cut_out_of_what_rounds_that() -> None:
    for x, y in ((72.0, 258.0), (90.5, 255.0), (86.0, 244.0)):
        program_of(part_of(outline("v", CORNERED), BACK, Hole("v", x, y, 18.0, AT)))


def test_a_drawn_radius_stays_as_it_is() -> None:
    assert COPER.coper is not None
    hole = Contour("v", "inner", (Arc((300.0, 150.0), 8.0, 0.0, 360.0),), AT)
    wall = walls_of(IPE300, COPER.coper, 3.0)["v"]
    region, _ = region_of(wall, part_of(hole), [0], COPER.coper)
    assert not region.rounded
    assert region.shape.area == pytest.approx(600.0 * 300.0 - 64.0 * pi, abs=0.5)


def test_an_outline_near_the_edges_of_its_wall_lies_on_them() -> None:
    flat = outline("o", [(0.0, 0.4), (600.0, 0.4), (600.0, 149.5), (0.0, 149.5)])
    assert [c.path for c in planned(part_of(flat)).operations] == [
        c.path for c in planned(part_of()).operations
    ]


def test_what_is_behind_the_web_lies_in_it() -> None:
    front, behind = (planned(part_of(Hole(f, 300.0, 100.0, 22.0, AT))) for f in "vh")
    assert [c.path for c in front.operations] == [c.path for c in behind.operations]


def test_marks_are_manual_work_and_every_feature_has_an_outcome() -> None:
    text = TextMark("v", 10.0, 10.0, 0.0, 10.0, "A1", AT)
    plan = planned(part_of(Hole("v", 300.0, 100.0, 22.0, AT), text, outline("v", CORNERED), BACK))
    assert [(o.feature, o.how, o.by) for o in plan.outcomes] == [
        ((0, 0), "made", "cut"), ((0, 1), "listed", "marks"), ((0, 2), "made", "cut"),
        ((0, 3), "made", "cut"),
    ]  # fmt: skip


def test_bevels_are_cut_square_and_on_the_list_of_manual_work() -> None:
    plan = planned(part_of(BEVELLED))
    assert [(o.how, o.manual_work) for o in plan.outcomes] == [("made", "bevel")]
    assert [(row["kind"], row["angle"]) for row in manual_rows(plan)] == [("bevel", 30.0)]
    program_of(part_of(BEVELLED))


def test_a_small_hole_is_left_out_where_that_is_allowed() -> None:
    part = part_of(Hole("v", 300.0, 100.0, 9.0, AT))
    plan = plan_coping((part,), COPER, skips=("tool",))
    assert [(o.how, o.by) for o in plan.outcomes] == [("skipped", "plan-tool")]


def planned_or_none(part: Part) -> CopePlan | None:
    """The plan of a random part; None of one with a hole in a notch, or too narrow a notch."""
    try:
        return planned(part)
    except PlanError as error:
        if {d.code for d in error.diagnostics} <= {"plan-coping-narrow", "plan-coping-off"}:
            return None
        raise


@given(st.integers(0, 2000))
@settings(max_examples=examples(50))
def test_paths_keep_half_a_kerf_off_the_part_and_come_in_order(seed: int) -> None:
    part = random_cope(seed)
    assert COPER.coper is not None
    plan = planned_or_none(part)
    if plan is None:
        return
    kinds = [c.kind for c in plan.operations]
    assert kinds == sorted(kinds, key=tuple(ORDER).index)
    walls = walls_of(part.profile, COPER.coper, 3.0)
    for cut in plan.operations:
        wall = walls[cut.face]
        features = [f for f, one in enumerate(part.features)
                    if getattr(one, "face", "").replace("h", "v") == cut.face]  # fmt: skip
        region, _ = region_of(wall, part, features, COPER.coper)
        off = region.shape.distance(LineString(cut.path))
        assert off == pytest.approx(cut.row.kerf / 2, abs=0.02)
        ys = [y for _, y in cut.path]
        assert wall.low - 1e-6 <= min(ys)
        assert max(ys) <= wall.high + 1e-6
        assert cut.row.up_to >= cut.thickness


@pytest.mark.parametrize("name", NAMES)
def test_samples_are_planned(name: str) -> None:
    assert planned(sample(name)).operations


RAT_HOLE = outline("v", [(0.0, 0.0), (600.0, 0.0), (600.0, 300.0), (40.0, 300.0), (40.0, 250.0),
                         (0.0, 250.0)])  # fmt: skip
BEVELLED = replace(outline("o", [(0.0, 0.0), (600.0, 0.0), (600.0, 150.0), (0.0, 150.0)]),
                   bevels=(Bevel(1, 30.0, 0.0),))  # fmt: skip
NOTCH = [(0.0, 0.0), (600.0, 0.0), (600.0, 150.0), (304.0, 150.0), (304.0, 110.0), (300.0, 110.0),
         (300.0, 150.0), (0.0, 150.0)]  # fmt: skip
HEAVY = Profile("I", "HD260", 290.0, 268.0, 32.5, 18.0, 24.0)
DEEP = Profile("I", "W", 300.0, 390.0, 20.0, 10.0, 15.0)
HIGH = Profile("I", "W", 1100.0, 300.0, 20.0, 10.0, 15.0)

LONG = [(0.0, 0.0), (603.0, 0.0), (603.0, 300.0), (0.0, 300.0)]
REFUSED = [
    ("plan-no-parts", None, COPER),
    ("plan-coping-lip", part_of(profile=Profile("C", "C200", 200.0, 70.0, 2.0, 2.0, 3.0)), COPER),
    ("plan-section", part_of(profile=HIGH), COPER),
    ("plan-section-shape", part_of(profile=replace(IPE300, flange_thickness=200.0)), COPER),
    ("plan-bar-long", part_of(length=12000.0), COPER),
    ("plan-coping-deep", part_of(profile=DEEP), COPER),
    ("plan-coping-deep", part_of(profile=Profile("T", "W", 390.0, 150.0, 10.0, 20.0, 15.0)), COPER),
    ("plan-coping-short", replace(part_of(outline("v", LONG)), made=()), COPER),
    ("plan-coping-flange-alone", part_of(outline("v", [
        (0.0, 0.0), (600.0, 0.0), (600.0, 90.0), (0.0, 250.0)])), COPER),
    ("plan-coping-root", part_of(RAT_HOLE), COPER),
    ("plan-coping-root", part_of(BACK), COPER),
    ("plan-coping-root", part_of(Hole("v", 300.0, 30.0, 22.0, AT)), COPER),
    ("plan-coping-root", part_of(Hole("o", 300.0, 70.0, 22.0, AT)), COPER),
    ("plan-coping-k-area", part_of(), with_keys(k_area="refuse")),
    ("plan-coping-narrow", part_of(outline("o", NOTCH)), COPER),
    ("plan-coping-narrow", part_of(outline("v", [(300.0, 100.0), (305.0, 100.0), (305.0, 110.0),
                                                 (300.0, 110.0)], "inner")), COPER),
    ("plan-coping-off", part_of(outline("v", CORNERED), BACK, Hole("v", 40.0, 280.0, 22.0, AT)),
     COPER),
    ("plan-coping-origin", part_of(
        outline("v", [(-50.0, 0.0), (550.0, 0.0), (550.0, 300.0), (-50.0, 300.0)]),
        *(outline(f, [(-50.0, 0.0), (550.0, 0.0), (550.0, 150.0), (-50.0, 150.0)]) for f in "ou"),
    ), COPER),
    ("plan-coping-support", part_of(Hole("v", 300.0, 100.0, 22.0, AT)),
     with_keys(supports=(SupportZone(300.0, 320.0),))),
    ("plan-coping-thick", part_of(profile=HEAVY), COPER),
    ("plan-tool", part_of(Hole("v", 300.0, 100.0, 9.0, AT)), COPER),
    ("plan-tool", part_of(Hole("v", 300.0, 100.0, 22.0, AT, 5.0, "blind")), COPER),
    ("plan-slot", part_of(Slot("v", 300.0, 100.0, 9.0, 20.0, 0.0, 0.0, AT)), COPER),
    ("plan-face", part_of(Hole("o", 300.0, 30.0, 22.0, AT), profile=L100), COPER),
    ("plan-mark", part_of(replace(outline("v", CORNERED), process="punch", kind="open")), COPER),
    ("plan-other", part_of(Bend((0.0, 0.0), (0.0, 9.0), 90.0, None, AT)), COPER),
    ("plan-other", part_of(replace(outline("v", CORNERED), kind="open", closed=False)), COPER),
]  # fmt: skip


@pytest.mark.parametrize(("code", "part", "machine"), REFUSED)
def test_what_cannot_be_made_is_refused(code: str, part: Part | None, machine: Machine) -> None:
    with pytest.raises(PlanError) as caught:
        plan_coping(() if part is None else (part,), machine)
    assert {d.code for d in caught.value.diagnostics} == {code}
    assert all(d.source == AT or part is None for d in caught.value.diagnostics)


def test_two_parts_are_two_programs() -> None:
    with pytest.raises(PlanError, match="plan-coping-alone: found 2 parts"):
        plan_coping((part_of(), part_of()), COPER)


def test_a_bar_that_is_too_short_is_refused() -> None:
    with pytest.raises(PlanError, match="plan-bar-full"):
        plan_coping((part_of(),), COPER, bar=659.0)
    assert plan_coping((part_of(),), COPER, bar=660.0).bar == 660.0


def test_the_bar_is_told_and_a_quantity() -> None:
    codes = [d.code for d in planned(replace(part_of(), quantity=3)).remarks]
    assert codes == ["plan-coping-bar", "plan-quantity"]


TEE = Profile("T", "1/2 IPE300", 150.0, 120.0, 7.1, 10.7, 15.0)


def test_a_tee_lies_on_its_side() -> None:
    """Its flange stands at Y 0, h outwards; u of its stem is up: Y is its z, Z is 150 - its y.

    The stem's upper side is 75 + 3.55 over the rollers; the tip pierces 6 over it, and 7 before
    the flange, as their rows of the cut chart have it.
    """
    holes = (
        Hole("v", 100.0, 30.0, 18.0, AT), Hole("h", 200.0, 30.0, 18.0, AT),
        Hole("o", 100.0, 80.0, 18.0, AT), Hole("u", 200.0, 80.0, 18.0, AT),
    )  # fmt: skip
    plan = planned(part_of(*holes, profile=TEE))
    assert [d.code for d in plan.remarks] == ["plan-coping-bar", "plan-coping-tee"]
    inner = [cut for cut in plan.operations if cut.kind == "inner"]
    middles = [(cut.face, *MultiPoint(cut.path[1:]).envelope.centroid.coords[0]) for cut in inner]
    assert [(face, round(x, 1), round(y, 1)) for face, x, y in middles] == [
        ("v", 100.0, 80.0), ("v", 200.0, 80.0), ("u", 100.0, 120.0), ("u", 200.0, 120.0),
    ]  # fmt: skip
    lines = program_of(part_of(*holes, profile=TEE)).splitlines()
    assert "(THE T LIES ON ITS SIDE: FACE H AT Y 0, FACE U UP)" in lines
    pierced = [lines[k - 1].split() for k, line in enumerate(lines) if line.startswith("M3")]
    assert [words[3] for words in pierced[:2]] == ["Z84.55", "Z84.55"]
    assert [words[2] for words in pierced[2:4]] == ["Y-7", "Y-7"]


def test_every_rule_has_a_case() -> None:
    tested = {code for code, *_ in REFUSED}
    tested |= {"plan-coping-alone", "plan-coping-rounded", "plan-coping-bar"}
    tested |= {"plan-coping-piece", "plan-coping-open"}  # in test_pieces.py
    tested |= {"plan-coping-tee"}  # above
    tested |= {"plan-coping-pipe", "plan-coping-no-pipe", "plan-coping-seam"}  # in test_tubes.py
    of_boxes = (
        "radius",
        "given-radius",
        "table-radius",
        "corner",
        "reaches",
        "tangents",
        "slant",
        "slow",
    )  # in test_box_tubes.py
    tested |= {f"plan-coping-{name}" for name in of_boxes}
    tested |= {"plan-coping-wedge"}  # in test_tube_ends.py
    tested |= {"plan-coping-crossed", "plan-coping-beyond"}  # in test_skew.py
    tested |= {"plan-coping-ledge"}  # in test_ledges.py
    tested |= {"plan-coping-bevel"}  # in test_undercuts.py
    tested |= {"plan-coping-step"}  # in test_slants.py
    tested |= {"plan-coping-chuck"}  # in test_turned.py
    tested |= {"plan-coping-tube-end"}  # in test_tube_pieces.py
    tested |= {
        f"plan-coping-{name}" for name in ("lips", "given-lip", "into-lip")
    }  # in test_lips.py
    assert {rule.code for rule in RULES} <= tested


def test_kerfs_of_a_path_that_runs_round_again_and_again() -> None:
    """What GEOS takes minutes for is put together of its stretches, each once."""
    ring = [(100.0, 100.0), (140.0, 100.0), (140.0, 130.0), (100.0, 130.0)]
    once = kerf_of([*ring, ring[0]], 1.2)
    assert kerf_of(ring * 50, 1.2).symmetric_difference(once).area < 1e-3
    assert kerf_of([ring[0]] * 5, 1.2).area == pytest.approx(pi * 1.44, rel=0.01)
