"""Which tool makes which hole, which tools are one, and what a hole needs done."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.machine.stations import Tool, ToolSet
from beamcam.model.part import Bevel, Contour, EndCuts
from beamcam.model.plan import DrillOp, PathOp, Plan, SpindleOp
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from beamcam.planning import rules
from beamcam.planning.beam import settle
from beamcam.planning.operations.tools import Tools, library_of
from beamcam.planning.operations.work import SAW_ANGLE
from tests.conftest import examples
from tests.unit.planning.shop import SOURCE, hole, part, plan, pusher


def strokes(found: Plan) -> list[SpindleOp]:
    return [op for op in found.operations if isinstance(op, DrillOp | PathOp)]


@pytest.mark.parametrize(
    ("diameter", "drill"),
    [
        (18.0, 18.0), (17.9, 18.0), (17.75, 18.0), (17.5, 17.46), (17.6, 17.46), (8.4, 8.5),
        (50.0, 50.0),
        (50.05, None), (7.85, 8.0), (7.65, 8.0), (7.5, None), (20.64, 20.64),
        (13.75, 13.5), (8.25, 8.0),
    ],
)  # fmt: skip
def test_the_nearest_drill_within_the_tolerance(diameter: float, drill: float | None) -> None:
    found = library_of(load("beamline")).drills((diameter,), ("v",))
    assert (found[0].diameter if found else None) == drill


def test_inch_and_millimetre_twins_are_one_tool() -> None:
    """1 1/16 in and 27.0 differ by 0.0125: one drill makes holes of either."""
    found = strokes(plan(part(hole(500, diameter=26.99), hole(800, diameter=27.0))))
    assert [op.tool.diameter for op in found] == [26.9875, 26.9875]
    assert [op.reasons for op in found] == [("drill-nearest",), ("drill-twin",)]
    alone = strokes(plan(part(hole(500, diameter=26.99))))
    assert [op.tool.diameter for op in alone] == [26.9875]
    assert alone[0].reasons == ("drill-nearest",)


def test_a_fraction_is_the_tool_of_its_decimals() -> None:
    found = strokes(plan(part(hole(500, diameter=20.64), hole(700, diameter=20.6375))))
    assert {op.tool for op in found} == {Tool("drill", 20.6375)}


def test_of_two_as_near_the_one_that_is_needed_anyway() -> None:
    drills = ToolSet("drill", (17.9, 18.1))
    machine = pusher(tools=(drills,))
    both = library_of(machine).drills((18.0,), ("v",))
    assert [t.diameter for t in both] == [17.9, 18.1]
    larger = library_of(machine).drills((18.1,), ("v",))
    assert settle([both, larger])[both].diameter == 18.1
    assert settle([both])[both].diameter == 17.9


@settings(max_examples=examples(300), deadline=None)
@given(
    st.lists(
        st.lists(st.integers(0, 6), min_size=1, max_size=3, unique=True), min_size=1, max_size=7
    )
)
def test_settled_tools_are_among_the_choices(ranks: list[list[int]]) -> None:
    choices: list[Tools] = [tuple(Tool("drill", 10.0 + r) for r in row) for row in ranks]
    settled = settle(choices)
    for choice in choices:
        tool = settled.get(choice, choice[0])
        assert tool in choice
        if len(choice) == 1:
            assert tool == choice[0]
    assert settle(reversed(choices)) == settled


def test_a_thread_is_drilled_and_tapped() -> None:
    first, second = strokes(plan(part(hole(500, diameter=16, kind="thread"))))
    assert (first.tool.name, second.tool.name) == ("drill 14", "tap M16 x 2")
    assert (first.depth, second.depth) == (None, None)
    assert (first.reasons, second.reasons) == (("drill-before-tap",), ("tap-thread",))
    assert first.features == second.features == ((0, 0),)


def test_a_blind_thread_is_drilled_deeper_by_the_run_out() -> None:
    """M6: the drill 5 goes 3 pitches of 1 mm deeper; its point of 1.5 stays in the web's 7.1."""
    first, second = strokes(plan(part(hole(500, diameter=6, kind="thread", depth=2.5))))
    assert (first.depth, second.depth) == (5.5, 2.5)
    assert first.tool.tip == pytest.approx(1.502, abs=1e-3)


def test_a_left_thread_needs_a_left_tap() -> None:
    left = ToolSet("tap", (16.0,), pitches=(2.0,), pre_drills=(14.0,), hand="left")
    machine = pusher(tools=(*pusher().tools, left))
    library = library_of(machine)
    assert [t.name for t in library.taps(16.0, True, ("v",))] == ["tap M16 x 2 left"]
    assert [t.name for t in library.taps(16.0, False, ("v",))] == ["tap M16 x 2"]
    assert library.taps(20.0, True, ("v",)) == ()


def test_a_countersink_comes_after_its_hole_and_on_it() -> None:
    sink = hole(500.04, diameter=20, kind="countersink", depth=4.0, angle=90.0)
    first, second = strokes(plan(part(sink, hole(500, diameter=12))))
    assert (first.tool.name, second.tool.name) == ("drill 12", "countersink 20 at 90 deg")
    assert (second.x, second.y) == (first.x, first.y)
    # The point of a cone of 90 degrees and 20 mm is 10 mm deep.
    assert second.depth == pytest.approx(10.0)
    assert second.reasons == ("sink-cone",)


@pytest.mark.parametrize(
    ("diameter", "depth", "angle", "tool", "point", "reason"),
    [
        (18, 3.0, 90.0, "countersink 20 at 90 deg", 9.0, "sink-cone"),  # a larger cone will do
        (20, 6.0, 90.0, "countersink 20 at 90 deg", 12.0, "sink-deep"),  # 6 + 12 / 2
        (18, 5.0, None, "countersink 18 at 180 deg", 5.0, "sink-flat"),
    ],
)
def test_how_deep_a_countersink_goes(
    diameter: float, depth: float, angle: float | None, tool: str, point: float, reason: str
) -> None:
    sink = hole(500, diameter=diameter, kind="countersink", depth=depth, angle=angle)
    _, second = strokes(plan(part(hole(500, diameter=12), sink)))
    assert (second.tool.name, second.reasons) == (tool, (reason,))
    assert second.depth == pytest.approx(point)


def test_a_sink_on_a_hole_that_is_left_out_is_left_out_too() -> None:
    sink = hole(500, diameter=20, kind="countersink", depth=6.4, angle=90.0)
    found = plan(part(hole(500, diameter=4.0), sink), skips=("tool", "countersink"))
    assert [o.by for o in found.outcomes] == ["plan-tool", "plan-countersink"]
    assert strokes(found) == []


def test_flange_countersinks_that_are_the_same_are_one_stroke() -> None:
    features = [
        hole(500, 40, 12 if kind == "through" else 20, face, kind=kind, depth=depth, angle=angle)
        for face in ("o", "u")
        for kind, depth, angle in (("through", None, None), ("countersink", 4.0, 90.0))
    ]
    found = strokes(plan(part(*features)))
    assert [(op.spindle, op.tool.kind) for op in found] == [(13, "drill"), (13, "countersink")]


def test_a_punch_mark() -> None:
    (mark,) = strokes(plan(part(hole(500, diameter=0, kind="mark"))))
    assert (mark.tool.kind, mark.depth, mark.reasons) == ("punch", 1.0, ("punch-mark",))
    (deep,) = strokes(plan(part(hole(500, diameter=0, kind="mark", depth=1.5))))
    assert (deep.tool.kind, deep.depth) == ("punch", 1.5)


def test_a_tool_stands_only_where_its_file_says() -> None:
    web_only = tuple(replace(t, faces=("v",)) for t in pusher().tools)
    machine = pusher(tools=web_only)
    assert library_of(machine).drills((18.0,), ("v",))[0] == Tool("drill", 18.0)
    assert library_of(machine).drills((18.0,), ("o",)) == ()
    assert library_of(machine).drills((18.0,), ("o", "u")) == ()


def test_a_through_hole_behind_the_web_is_drilled_from_the_front() -> None:
    found = plan(part(hole(500, face="h")), machine="beamline")
    (op,) = strokes(found)
    assert (op.faces, op.reasons) == (("v",), ("drill-exact", "from-behind"))
    # Written on both faces it is still one hole.
    both = plan(part(hole(500), hole(500, face="h")), machine="beamline")
    assert [o.how for o in both.outcomes] == ["made", "duplicate"]


# --- fits -----------------------------------------------------------------------------------------


IMPERIAL = (11.11, 14.29, 14.68, 17.46, 20.64)


@pytest.mark.parametrize("name", ["beamline", "beamline-annex", "beamline-pusher"])
def test_holes_in_inches_are_drilled_within_the_fit(name: str) -> None:
    machine = load(name)
    holes = [hole(500 + 100 * k, diameter=d) for k, d in enumerate(IMPERIAL)]
    one = part(*holes)
    made = post([one], machine)
    assert [o.how for o in made.plan.outcomes] == ["made"] * len(IMPERIAL)
    assert machine.drill is not None
    for op in made.plan.operations:
        for _, index in getattr(op, "features", ()):
            wanted = one.features[index].diameter  # type: ignore[union-attr]
            fit = next(f for f in machine.drill.fits if wanted <= f.up_to)
            assert -fit.minus <= op.tool.diameter - wanted <= fit.plus  # type: ignore[union-attr]


def test_a_refusal_gives_the_limits_of_the_fit() -> None:
    with pytest.raises(
        PlanError, match=r"expected a drill of 4\.7 to 5\.4 \(drill\.fits\); the near"
    ):
        post([part(hole(500, diameter=5.0))], load("beamline"))


def sizes(text: str, remarks: tuple[Diagnostic, ...]) -> list[str]:
    assert text
    return [d.message for d in remarks if d.code == rules.DRILL_SIZE.code]


@pytest.mark.parametrize("name", ["beamline", "beamline-annex", "beamline-pusher"])
def test_each_diameter_that_is_not_drilled_exactly_is_told_once_with_both_sizes(name: str) -> None:
    machine = load(name)
    wanted = (18.3, 18.3, 17.8, 18.0, 20.64)
    made = post([part(*(hole(500 + 100 * k, diameter=d) for k, d in enumerate(wanted)))], machine)
    assert isinstance(made.text, str)
    assert sizes(made.text, made.remarks) == [
        "holes of diameter 18.3 are drilled with 18, 0.3 mm under",
        "holes of diameter 17.8 are drilled with 18, 0.2 mm over",
    ]


def test_a_shop_may_never_drill_under() -> None:
    machine = load("beamline")
    assert machine.drill is not None
    strict = replace(machine, drill=replace(machine.drill, never_under=True))
    twins = part(hole(500, diameter=20.65), hole(600, diameter=17.8))
    made = post([twins], strict)
    assert isinstance(made.text, str)
    assert sizes(made.text, made.remarks) == [
        "holes of diameter 17.8 are drilled with 18, 0.2 mm over"
    ]
    under = part(hole(500, diameter=18.3))
    with pytest.raises(PlanError, match=r"expected a drill of 18\.28 to 18\.7 \(drill\.fits\)"):
        post([under], strict)
    loose = post([under], machine).text
    assert read_back(loose, Request((under,), machine)) == ()
    assert {d.code for d in read_back(loose, Request((under,), strict))} == {
        "verify-not-made", "verify-hole-extra",
    }  # fmt: skip


@pytest.mark.parametrize("angle", [0.06, -0.11])
@pytest.mark.parametrize("name", ["beamline", "beamline-annex", "beamline-pusher"])
def test_a_bevel_that_is_noise_is_left_square_and_told(name: str, angle: float) -> None:
    """As two HEA240 of a real file had them, which were refused for a weld preparation."""
    machine = load(name)
    corners = [(0.0, 0.0), (3000.0, 0.0), (3000.0, 150.0), (0.0, 150.0)]
    sides = tuple(map(Line, corners, [*corners[1:], corners[0]]))

    def flange(*bevels: Bevel) -> Contour:
        return Contour("u", "outer", sides, SOURCE, bevels=bevels)

    noisy = part(hole(500), flange(Bevel(1, angle, 0.0)))
    made = post([noisy], machine)
    assert [d.message for d in made.remarks if d.code == rules.BEVEL_NOISE.code] == [
        f"found 1 bevel(s) of at most {abs(angle):g} degrees; below 0.2 degrees an edge is cut "
        "square"
    ]
    assert made.text == post([part(hole(500), flange())], machine).text
    assert errors_in(read_back(made.text, Request((noisy,), machine))) == ()
    with pytest.raises(PlanError, match="plan-bevel"):
        post([part(hole(500), flange(Bevel(1, 0.3, 0.0)))], machine)


NOISE = st.floats(-0.199, 0.199).filter(lambda a: abs(a) > 1e-6)


@settings(max_examples=examples(25), deadline=None)
@given(st.tuples(NOISE, NOISE, NOISE, NOISE))
def test_a_noise_angle_is_sawn_square_and_told(angles: tuple[float, ...]) -> None:
    machine, cuts = load("beamline"), EndCuts(*angles)
    noisy, square = part(hole(500), cuts=cuts), part(hole(500))
    made = post([noisy], machine)
    assert [d.code for d in made.remarks] == [rules.CUT_NOISE.code] * 4
    assert made.text == post([square], machine).text
    assert read_back(made.text, Request((noisy,), machine)) == ()


@pytest.mark.parametrize("angle", [-85.0, 85.0])
@pytest.mark.parametrize("name", ["beamline", "beamline-pusher"])
def test_angles_in_messages_are_those_of_the_file(name: str, angle: float) -> None:
    with pytest.raises(PlanError) as caught:
        post([part(cuts=EndCuts(web_end=angle))], load(name))
    (said,) = (d for d in caught.value.diagnostics if d.code == SAW_ANGLE.code)
    assert f"found a cut of {angle:g} degrees at the end" in said.message
    least, greatest = map(float, said.message.split("from ")[1].split(",")[0].split(" to "))
    assert not least <= angle <= greatest
    for limit in (least, greatest):
        post([part(cuts=EndCuts(web_end=limit))], load(name))
