"""Which tool makes which hole, which tools are one, and what a hole needs done."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.machine import load
from beamcam.machine.stations import Tool, ToolSet
from beamcam.model.plan import DrillOp, PathOp, Plan, SpindleOp
from beamcam.planning.beam import settle
from beamcam.planning.operations.tools import Tools, library_of
from tests.conftest import examples
from tests.unit.planning.shop import hole, part, plan, pusher


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
