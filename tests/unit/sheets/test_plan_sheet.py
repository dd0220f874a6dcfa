"""The plan of a sheet: what is made of each feature, in which order, and what is refused."""

from dataclasses import dataclass
from itertools import pairwise
from math import dist

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import PlanError, Rule
from beamcam.geometry.curves import Arc, Bezier, BSpline, Line, signed_area
from beamcam.machine import load
from beamcam.model.part import Bend, Bevel, Contour, Feature, Hole, Part, Profile, Slot
from beamcam.model.plan import SheetPlan
from beamcam.pipeline import post
from beamcam.planning.contours import rules
from beamcam.planning.contours.order import order
from beamcam.planning.contours.outline import Shape
from beamcam.planning.sheet import plan_sheet
from tests.conftest import examples
from tests.unit.sheets.parts import NESTED, S, box, circle, contour, drawing, lines, plate, table


def codes(plan: SheetPlan) -> list[str]:
    return [said.code for said in plan.remarks]


def test_marks_first_and_inner_before_outer() -> None:
    plan = plan_sheet((NESTED,), table())
    made = [f for op in plan.operations for _, f in op.features]
    assert made[0] == 3
    assert made.index(2) < made.index(1) < made.index(0)
    assert made.index(4) < made.index(0)
    assert [op.depth for op in plan.operations if op.features == ((0, 2),)] == [2]


def test_every_feature_has_an_outcome() -> None:
    hole = Hole("v", 20, 50, 14.0, S)
    part = plate(hole, hole, Slot("v", 80, 50, 14.0, 30.0, 0.0, 30.0, S), quantity=2)
    plan = plan_sheet((part,), table())
    assert [o.how for o in plan.outcomes] == ["made", "duplicate", "made"]
    assert len(plan.operations) == 3  # the outline of the plate is nobody's feature
    assert codes(plan) == ["plan-overlap", "plan-sheet-quantity"]


def test_the_kerf_lies_in_the_waste() -> None:
    plan = plan_sheet((NESTED,), table(kerf=2.0))
    areas = {op.features[0][1]: abs(signed_area(op.passes[0].curves)) for op in plan.operations}
    assert areas[0] == pytest.approx(202 * 102, abs=0.2)
    assert areas[1] == pytest.approx(34**2 * 3.14159265, rel=1e-6)
    assert areas[2] == pytest.approx(32 * 22, abs=0.2)


def test_climb_has_the_material_at_the_right() -> None:
    for direction, sign in (("climb", -1), ("conventional", 1)):
        plan = plan_sheet((NESTED,), table(direction=direction))
        signs = {
            op.features[0][1]: signed_area(op.passes[0].curves) > 0
            for op in plan.operations
            if op.closed
        }
        outer = sign > 0
        assert signs == {0: outer, 1: not outer, 2: outer, 4: not outer}


def test_leads_and_bridges() -> None:
    plan = plan_sheet((NESTED,), table(tabs=3, tab_width=2.0))
    by_feature = {op.features[0][1]: op for op in plan.operations}
    assert len(by_feature[0].passes) == 4
    assert len(by_feature[1].passes) == 1
    for before, after in pairwise(by_feature[0].passes):
        width = dist(before.curves[-1].end, after.curves[0].start)
        assert width == pytest.approx(2.0 + 1.5, abs=1e-5)
    assert by_feature[0].passes[0].lead_in
    assert not by_feature[0].passes[1].lead_in
    assert by_feature[0].passes[-1].lead_out
    short = plan_sheet((drawing(contour(box(0, 0, 3, 3))),), table(tabs=9, lead="none"))
    assert "plan-tabs" in codes(short)


@pytest.mark.parametrize("start", ["nearest", "drawn", "straight"])
def test_where_a_contour_begins(start: str) -> None:
    machine = table(start=start, kerf_by="none", lead="none", place="drawn")
    part = drawing(contour(box(50, 50, 100, 40)))
    (op,) = plan_sheet((part,), machine).operations
    expected = {"nearest": (50.0, 50.0), "drawn": (50.0, 90.0), "straight": (100.0, 50.0)}
    begin = op.passes[0].curves[0].start
    corners = {(50.0, 50.0), (150.0, 50.0), (150.0, 90.0), (50.0, 90.0)}
    if start == "straight":
        assert begin not in corners
        assert begin[0] == 100.0
    elif start == "nearest":
        assert begin == expected[start]
    else:
        assert begin in corners


def test_joined_from_single_lines() -> None:
    pieces = [contour((c,), line=k) for k, c in enumerate(box(0, 0, 50, 30))]
    pieces[1] = contour((pieces[1].curves[0].reversed(),), line=1)
    (op,) = plan_sheet((drawing(*pieces),), table()).operations
    assert op.closed
    assert op.features == ((0, 0), (0, 1), (0, 2), (0, 3))


@dataclass
class Refusal:
    """A part that is refused, and what is said."""

    features: tuple[Feature, ...]
    code: str
    says: str
    skip: str | None = None


OUTLINE = contour(box(0, 0, 200, 100), None)
BEVELLED = Contour("v", "outer", box(0, 0, 200, 100), S, bevels=(Bevel(0, 30.0, 2.0),))
REFUSALS = [
    Refusal((Hole("v", 9, 9, 12.0, S, kind="thread"),), "plan-tool", "thread hole", "tool"),
    Refusal((Hole("v", 9, 9, 12.0, S, kind="countersink"),), "plan-tool", "countersink", "tool"),
    Refusal((Hole("v", 9, 9, 12.0, S, depth=3.0),), "plan-tool", "blind hole", "tool"),
    Refusal((Hole("v", 9, 9, 1.0, S),), "plan-tool", "expected at least 4", "tool"),
    Refusal((Hole("o", 9, 3, 8.0, S),), "plan-face", "found a through hole on face o", "face"),
    Refusal((Slot("v", 90, 50, 2.0, 9.0, 0.0, 0.0, S),), "plan-slot", "11 x 2", "slot"),
    Refusal((Slot("v", 90, 50, 9.0, 9.0, 0.0, 0.0, S, depth=2.0),), "plan-slot", "sheet", "slot"),
    Refusal((Bend((0, 0), (9, 0), 90.0, 3.0, S),), "plan-other", "a bend", "other"),
    Refusal((BEVELLED,), "plan-bevel", "30 degrees", "bevel"),
]


@pytest.mark.parametrize("case", REFUSALS, ids=lambda c: c.says)
def test_what_a_torch_cannot_make(case: Refusal) -> None:
    part, machine = plate(*case.features), table(drilled="refuse", bevel="refuse")
    machine = replace(machine, marks=replace(machine.marks, bends="refuse"))
    with pytest.raises(PlanError) as caught:
        plan_sheet((part,), machine)
    (said,) = caught.value.diagnostics
    assert (said.code, said.source) == (case.code, S)
    assert case.says in said.message
    assert case.skip is not None
    plan = plan_sheet((part,), machine, (case.skip,))
    if case.skip == "bevel":
        assert [o.how for o in plan.outcomes] == ["made"]
        assert codes(plan) == [rules.SQUARE.code]
    else:
        assert [(o.how, o.by) for o in plan.outcomes] == [("skipped", case.code)]


SQUARE = contour(box(0, 0, 50, 50))
DIAGONAL = Line((0.0, 0.0), (9.0, 9.0))
SPECK = contour(lines((0, 0), (0, 0.01), closed=False))
SLOTTED = contour(
    lines((0, 0), (40, 0), (40, 40), (20.6, 40), (20.6, 20), (20, 20), (20, 40), (0, 40))
)
#: Two chambers and a neck between them, in a plate.
WAISTED = contour(
    lines(
        (0, 0), (10, 0), (10, 4.5), (20, 4.5), (20, 0), (30, 0), (30, 10), (20, 10), (20, 5.5),
        (10, 5.5), (10, 10), (0, 10),
    )
)  # fmt: skip
#: A corner that points into the part, with a chamfer smaller than the kerf.
CHAMFERED = contour(
    lines((0, 0), (60, 0), (60, 20), (40.2, 20), (40, 20.2), (40, 40), (0, 40)), line=1
)
OPEN = contour(lines((0, 0), (50, 0), (50, 50), closed=False))
#: A line that goes out from a corner and back.
#: A spline that runs to and fro over one place, a hundred times each way.
TO_AND_FRO = BSpline(
    2,
    tuple((10.0 + 30.0 * (k % 2), 10.0) for k in range(200)),
    (0.0, 0.0, *map(float, range(199)), 198.0, 198.0),
)
THERE_AND_BACK = Bezier(((0, 0), (40, 0), (0, 0)))
OCTAGON = ((20, 0), (14, 14), (0, 20), (-14, 14), (-20, 0), (-14, -14), (0, -20), (14, -14))
TWICE_ROUND = BSpline(3, tuple(OCTAGON[k % 8] for k in range(19)), tuple(range(23)))
SPIKED = contour(lines((0, 0), (40, 0), (40, 50), (40, 40), (0, 40)))
NOTCHED = contour(lines((0, 0), (40, 0), (40, 40), (23, 40), (20, 31), (17, 40), (0, 40)))
CENTRE = Hole("v", 50, 40, 0.0, S, kind="mark")
#: A torch that cuts holes of any size.
ANY_HOLE: dict[str, object] = {"min_hole": 0.0, "min_hole_share": 0.0}

OTHERS: list[tuple[tuple[Part, ...], dict[str, object], str, str]] = [
    ((), {}, "plan-sheet-parts", "found 0 parts"),
    ((NESTED, replace(NESTED, grade="S355")), {}, "plan-sheet-mixed", "of 6 mm S355; exp"),
    ((NESTED, drawing(SQUARE, thickness=8.0)), {}, "plan-sheet-mixed", "8 mm mild steel"),
    ((NESTED,) * 3, {"length": 450.0, "width": 150.0}, "plan-sheet-full", "of which 2 fit"),
    ((replace(plate(), profile=replace(plate().profile, name="PIPE60*4")),), {}, "plan-unrolled",
     "found the profile PIPE60*4"),
    ((plate(CENTRE),), {"cross": 0.0}, "plan-tool", "the size of a cross in the machine file"),
    ((plate(replace(CENTRE, depth=1.0)),), {}, "plan-tool", "marked by a cross of 5"),
    ((plate(replace(CENTRE, face="o")),), {}, "plan-face", "mark hole"),
    # Beside the plate; a plate is by itself on a sheet.
    ((plate(Hole("v", 300, 50, 18.0, S)),), {}, "plan-sheet-off", "18 on face v at x 300, y 50"),
    ((plate(Slot("v", -60, 50, 18.0, 20.0, 0.0, 0.0, S)),), {}, "plan-sheet-off", "slot 38 x 18"),
    ((plate(replace(contour(box(240, 20, 80, 60), None), kind="inner")),), {}, "plan-sheet-off",
     "found inner contour"),
    ((plate(Hole("v", 300, 50, 18.0, S)), plate()), {}, "plan-sheet-off", "at x 300, y 50"),
    ((drawing(),), {}, "plan-sheet-empty", "the sheet is empty"),
    ((drawing(contour(box(0, 0, 9, 9), "#00ff00")),), {}, "plan-unmapped", "4 curves of colour"),
    ((drawing(contour(box(0, 0, 9, 9), None, "W")),), {}, "plan-unmapped", "on layer 'W'"),
    ((drawing(SQUARE),), {"colours": {"red": "engrave"}}, "plan-process", "4 curves to engrave"),
    ((drawing(SQUARE, thickness=None),), {"thickness": 0.0}, "plan-thickness", "a sheet of 0 mm"),
    ((drawing(SQUARE, thickness=None),), {"thickness": -1.0}, "plan-thickness", "at most 32 mm"),
    ((drawing(SQUARE, thickness=40.0),), {}, "plan-thickness", "found a sheet of 40 mm mild"),
    ((drawing(contour(box(0, 0, 4000, 50))),), {}, "plan-sheet-size", "at most 3000 x 1500"),
    # Of a drawing as large as a planet it is not asked first whether it crosses itself.
    (
        (drawing(contour(lines((0, 0), (5e9, 5e9), (5e9, 0), (0, 5e9)))),), {}, "plan-sheet-size",
        "found a sheet of 5000000000.0 x",
    ),
    ((drawing(SQUARE),), {"place": "drawn"}, "plan-sheet-place", "from x -2.7"),
    ((drawing(contour(circle(0, 0, 1.0))),), {"place": "corner"}, "", ""),
    ((drawing(contour(lines((0, 0), (50, 50), (50, 0), (0, 50)))),), {}, "plan-crossing", "itself"),
    # Along the diagonal twenty-two squares cross each the next one.
    ((drawing(*(contour(box(9.0 * k, 9.0 * k, 10, 10), line=k) for k in range(23))),), {},
     "plan-crossing", "crosses line 1 near x 9.000, y 10.000"),
    ((drawing(*(contour(box(9.0 * k, 9.0 * k, 10, 10), line=k) for k in range(23))),), {},
     "plan-crossings", "2 more places"),
    ((drawing(contour((TO_AND_FRO,), line=9)),), {}, "plan-crowded",
     "found curves that pass the 0.02 mm around"),
    ((drawing(*[contour((DIAGONAL,), line=7)] * 776),), {}, "plan-copies",
     "found one curve 776 times, and 775 copies of curves in all"),
    ((drawing(SQUARE, contour(box(50, 10, 20, 20), line=2)),), {},
     "plan-shared-edge", "lies on line 1 for 20.000 mm near x 50.000, y 20.000"),
    ((drawing(contour((THERE_AND_BACK,))),), {},
     "plan-doubles-back-kerf", "turns round at x 20.000, y 0.000 and runs back along itself"),
    ((drawing(contour((TWICE_ROUND,))),), {}, "plan-runs-over-itself", "runs over itself from x "),
    ((drawing(replace(OPEN, closed=True)),), {},
     "plan-not-closed", "from x 0.000, y 0.000 to x 50.000, y 50.000"),
    ((drawing(SPIKED),), {}, "plan-shared-edge", "lies on itself for 10.000 mm near x 40.000"),
    ((drawing(*(contour((c,), line=k) for k, c in enumerate((*box(0, 0, 9, 9), DIAGONAL)))),), {},
     "plan-junction-kerf", "3 curves that meet at x 0.000, y 0.000, with line 3, line 4"),
    ((drawing(SPECK),), {}, "plan-sheet-empty", "1 curves no larger than 0.05 mm"),
    ((drawing(SQUARE, contour(circle(25, 25, 1.2))),), ANY_HOLE, "plan-kerf", "1.2 x"),
    ((drawing(SLOTTED),), {}, "plan-narrow", "0.600 mm wide at x 20.300, y 39.998, 19.939 mm of"),
    ((drawing(contour(box(-9, -9, 50, 50)), WAISTED),), {},
     "plan-narrow", "a place 1.000 mm wide at x 10.00"),
    ((drawing(SQUARE, contour(box(50.8, 0, 20, 20), line=2)),), {},
     "plan-near", "0.800 mm of waste between the contour and line 2 at x 50.400"),
    ((drawing(SQUARE, contour(circle(25, 25, 4.0))),),
     {"kerf_by": "machine", "lead": "line", "lead_in": 0.5}, "plan-kerf-lead", "1.5 mm"),
    ((drawing(CHAMFERED),), {"kerf_by": "machine", "lead": "line"},
     "plan-kerf-machine", "a side of 0.283 mm at x 40.100, y 20.100"),
    ((drawing(SQUARE),), {"kerf_by": "machine", "lead": "line", "tabs": 2},
     "plan-kerf-tabs", "found 2 bridges"),
    ((drawing(contour(lines((0.25, 0), (80, 0), (80, 50), (0, 50), (0, 0), closed=False))),), {},
     "plan-open-kerf", "x 0.250, y 0.000 to x 0.000, y 0.000, 0.250 mm apart; expected it closed"),
]  # fmt: skip


@pytest.mark.parametrize(("parts", "values", "code", "says"), OTHERS)
def test_refused(parts: tuple[Part, ...], values: dict[str, object], code: str, says: str) -> None:
    machine = table(**values)
    if not code:
        assert plan_sheet(parts, machine).operations
        return
    with pytest.raises(PlanError) as caught:
        plan_sheet(parts, machine)
    told = {said.code: said.message for said in reversed(caught.value.diagnostics)}
    assert says in told[code]


def test_centres_are_marked_by_a_cross() -> None:
    plan = plan_sheet((plate(CENTRE, Hole("v", 90, 40, 12.0, S)),), table(cross=8.0))
    marks = [op for op in plan.operations if op.row.process == "mark"]
    ends = [{c.start, c.end} for op in marks for one in op.passes for c in one.curves]
    x, y = 50 + plan.shift[0], 40 + plan.shift[1]
    assert len(ends) == 2
    assert {(x - 4, y), (x + 4, y)} in ends
    assert {(x, y - 4), (x, y + 4)} in ends
    assert [(o.how, o.by) for o in plan.outcomes] == [("made", "mark"), ("made", "cut")]


def test_a_thickness_that_nobody_says_is_asked_for() -> None:
    machine = load("laser-grbl")
    with pytest.raises(PlanError) as caught:
        plan_sheet((drawing(contour(box(0, 0, 9, 9), "#000000"), thickness=None),), machine)
    assert caught.value.diagnostics[0].code == "plan-thickness-unknown"
    assert "give it by --thickness" in caught.value.diagnostics[0].message


def test_where_the_thickness_of_a_drawing_comes_from_is_said() -> None:
    plan = plan_sheet((drawing(SQUARE, thickness=None),), table(thickness=3.0))
    (said,) = plan.remarks
    assert said.message.startswith("found no thickness in the drawing; the sheet is 3 mm ")
    assert said.message.endswith(", by the options or the machine's file")


def test_a_bar_is_no_sheet() -> None:
    part = Part("B", Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1), 900.0, S)
    with pytest.raises(PlanError, match="plan-stock"):
        plan_sheet((part,), table())


LEFT_OPEN: dict[str, object] = {"allow_open": True}
#: A box whose outline is open by a quarter of a millimetre.
NEARLY = contour(lines((0.25, 0), (80, 0), (80, 50), (0, 50), (0, 0), closed=False))
REMARKS: list[tuple[Part, dict[str, object], set[str]]] = [
    (drawing(SQUARE, thickness=None), {}, {"plan-thickness-assumed"}),
    (drawing(OPEN), LEFT_OPEN, {"plan-open-cut"}),
    (drawing(*(contour(lines((9.0 * k, 0), (9.0 * k, 8), closed=False)) for k in range(12))),
     LEFT_OPEN, {"plan-open-cut", "plan-open-cuts"}),
    (drawing(OPEN, contour(lines((50, 50.2), (0, 0.2), closed=False))), LEFT_OPEN,
     {"plan-open-cut", "plan-gap"}),
    (drawing(*(contour((Line((20.0, 20.0), end),)) for end in ((0, 0), (40, 0), (20, 50)))),
     LEFT_OPEN, {"plan-open-cut", "plan-junction"}),
    (drawing(SQUARE, SQUARE), {}, {"plan-overlap"}),
    (drawing(SPIKED), {"kerf_by": "none"}, {"plan-common-edge"}),
    (drawing(contour((THERE_AND_BACK,))), {"kerf_by": "none"}, {"plan-doubles-back"}),
    (drawing(contour(lines((0, 0), (40, 0), (20, 0), (20, 20), closed=False))), LEFT_OPEN,
     {"plan-open-cut", "plan-overlap"}),
    (drawing(NOTCHED), {}, {"plan-left-in-corner"}),
    (drawing(contour(lines((0, 0), (40, 0)))), LEFT_OPEN, {"plan-open-cut", "plan-overlap"}),
    (drawing(SQUARE, SPECK), {}, {"plan-tiny"}),
    (drawing(SQUARE, contour(box(50, 10, 20, 20))), {"kerf_by": "none"},
     {"plan-common-edge"}),
    (drawing(*(contour(box(9.0 * k, 9.0 * k, 10, 10)) for k in range(23))), {"kerf_by": "none"},
     {"plan-crossing-on-line", "plan-crossings-on-line"}),
    (drawing(SQUARE, contour(circle(25, 25, 4.0))), ANY_HOLE, {"plan-lead"}),
    (drawing(NEARLY), {"gap": 0.3}, {"plan-gaps-closed"}),
]  # fmt: skip


@pytest.mark.parametrize(("part", "values", "expected"), REMARKS)
def test_remarks(part: Part, values: dict[str, object], expected: set[str]) -> None:
    plan = plan_sheet((part,), table(**values))
    assert set(codes(plan)) == expected


def test_what_is_too_small_is_told_once_and_the_rest_posts() -> None:
    posted = post((drawing(SQUARE, SPECK),), table())
    assert [said.code for said in posted.remarks] == ["plan-tiny"]
    assert [o.how for o in posted.plan.outcomes] == ["made", "skipped"]


def test_a_side_without_length_is_nothing() -> None:
    sides = list(box(0.1, 0.1, 50, 40))
    sides.insert(0, Line((0.1, 0.1), (0.1 + 1e-16, 0.1)))
    machine = table(kerf_by="none", start="nearest")
    (op,) = plan_sheet((drawing(contour(tuple(sides))),), machine).operations
    assert op.closed
    assert len(op.passes[0].curves) == 4


def test_parts_a_kerf_apart_share_a_cut() -> None:
    row = [contour(box(51.5 * k, 0, 50, 40), line=k) for k in range(3)]
    posted = post((drawing(*row),), table())
    assert "plan-common-edge" in {said.code for said in posted.remarks}
    assert [op.closed for op in posted.plan.operations].count(True) == 1


def test_a_square_between_others_is_made_by_their_cuts() -> None:
    around = [box(10, 0, 10, 10), box(0, 10, 10, 10), box(20, 10, 10, 10), box(10, 20, 10, 10)]
    sheet = [contour(curves, line=k) for k, curves in enumerate([*around, box(10, 10, 10, 10)])]
    plan = plan_sheet((drawing(*sheet),), table(kerf_by="none", lead="none"))
    assert [o.how for o in plan.outcomes] == ["made"] * 5
    length = sum(c.length for op in plan.operations for one in op.passes for c in one.curves)
    assert length == pytest.approx(160)


#: What the command line says, and what only machines without words for a contour can say.
OF_OTHERS = {
    "plan-map", "plan-sheet-option", "plan-sheet-quantity", "plan-chain",
    "plan-thickness-other", "plan-material-other", "plan-map-setting", "plan-map-order",
    "plan-sheet-layout", "plan-map-hatch", "plan-map-overcut", "plan-overcut",
    "plan-torch-height", "plan-torch-headroom",
}  # fmt: skip


def test_an_open_contour_says_how_far_its_ends_are_apart() -> None:
    """Of an arrowhead whose ends nearly meet, and what would join them."""
    head = lines((0, 0), (20, 8), (0, 16), (5, 8), (0.3, 0.4), closed=False)
    (said,) = [
        str(one) for one in post((drawing(contour(head)),), table(allow_open=True)).remarks
        if one.code == "plan-gap"
    ]  # fmt: skip
    assert "found a gap of 0.5000 mm at x 0.000, y 0.000" in said
    assert said.endswith("or a larger torch.gap in the machine file")
    far = lines((0, 0), (20, 8), (0, 16), (5, 8), (3, 4), closed=False)
    (said,) = [str(one) for one in post((drawing(contour(far)),), table(allow_open=True)).remarks]
    assert "plan-open-cut" in said
    assert "5.000 mm apart; it is cut on its line" in said


@pytest.mark.parametrize("gap", [0.1, 0.25, 0.6])
def test_an_outline_that_is_open_by_a_hair_is_refused_or_joined(gap: float) -> None:
    """A hole in it never becomes an outline; `--gap` joins the ends, which is told."""
    ends = lines((gap, 0), (80, 0), (80, 50), (0, 50), (0, 0), closed=False)
    part = drawing(contour(ends), contour(circle(40, 25, 16)))
    with pytest.raises(PlanError, match=f"{gap:.3f} mm apart.*--gap {gap:g} joins its ends"):
        post((part,), table())
    joined = post((part,), table(gap=gap))
    assert [one.code for one in joined.remarks] == ["plan-gaps-closed"]
    hole = next(op for op in joined.plan.operations if op.features == ((0, 1),))
    assert {c.radius for c in hole.passes[0].curves if isinstance(c, Arc)} == {8.0 - 1.5 / 2}
    opened = post((part,), table(allow_open=True))
    assert {one.code for one in opened.remarks} >= {"plan-open-cut"}


def test_a_hole_that_is_drawn_as_a_cut_out_too_is_cut_once() -> None:
    twice = (replace(contour(circle(60, 50, 18)), kind="inner"), Hole("v", 60, 50, 18.0, S))
    assert post((plate(*twice),), table()).text


def test_every_rule_has_a_case() -> None:
    shown = {c.code for c in REFUSALS} | {code for _, _, code, _ in OTHERS}
    shown |= {code for _, _, more in REMARKS for code in more} | {
        "plan-tabs", "plan-bevel-left", "plan-thickness-unknown", "plan-bevel-noise",
        "plan-sheet-turned", "plan-sheet-apart", "plan-sheet-end", "plan-tabs-joint",
        "plan-sheet-notch",
    }  # fmt: skip
    codes = {rule.code for rule in vars(rules).values() if isinstance(rule, Rule)}
    assert codes - OF_OTHERS <= shown


places = st.tuples(st.integers(0, 40), st.integers(0, 40))


@settings(max_examples=examples(60), deadline=None)
@given(st.lists(st.tuples(places, places, st.booleans()), min_size=1, max_size=25, unique=True))
def test_the_order_keeps_marks_first_and_is_no_longer_than_as_given(
    ways: list[tuple[tuple[int, int], tuple[int, int], bool]],
) -> None:
    shapes = [
        Shape(
            "mark" if mark else "cut",
            (Line((float(a[0]), float(a[1])), (b[0] + 0.5, b[1] + 0.5)),),
            False, (k,), S,
        )
        for k, (a, b, mark) in enumerate(ways)
    ]  # fmt: skip
    tour = order(shapes)
    assert sorted(k for k, _ in tour) == list(range(len(shapes)))
    processes = [shapes[k].process for k, _ in tour]
    assert processes == sorted(processes, reverse=True)
    given_order = [k for p in ("mark", "cut") for k, s in enumerate(shapes) if s.process == p]
    as_given = [(k, False) for k in given_order]
    # Greedy alone may be longer than a lucky order; it is never twice as long.
    assert travel(tour, shapes) <= 2 * travel(as_given, shapes) + 1e-9


def travel(tour: list[tuple[int, bool]], shapes: list[Shape]) -> float:
    """Length of the traverses between the shapes of a tour from 0, 0 on, in its order."""
    total, here = 0.0, (0.0, 0.0)
    for index, turned in tour:
        ends = shapes[index].curves[0].start, shapes[index].curves[-1].end
        start, end = ends[::-1] if turned and not shapes[index].closed else ends
        total += dist(here, start)
        here = end
    return total


@settings(max_examples=examples(40), deadline=None)
@given(st.lists(st.tuples(places, st.integers(0, 9)), min_size=2, max_size=25), st.randoms())
def test_the_order_does_inner_ones_first(
    found: list[tuple[tuple[int, int], int]], random: object
) -> None:
    shapes = [
        Shape("cut", circle(x, y, 1.0), True, (k,), S, parent=p if p < k else -1)
        for k, ((x, y), p) in enumerate(found)
    ]
    places_of = {k: n for n, (k, _) in enumerate(order(shapes))}
    for k, shape in enumerate(shapes):
        if shape.parent >= 0:
            assert places_of[k] < places_of[shape.parent]
