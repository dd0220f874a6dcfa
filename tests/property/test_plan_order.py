"""The order of work against all orders that there are, for up to seven operations."""

from collections.abc import Sequence
from itertools import pairwise, permutations
from typing import Literal

from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.machine import load
from beamcam.machine.machine import Times
from beamcam.machine.stations import Tool
from beamcam.model.plan import DrillOp, Operation, SawOp
from beamcam.planning.order import sort_along_x, tool_loads, travel
from tests.conftest import examples

SOURCE = Source("a.nc1", 1)
LINE = load("beamline")
Layout = Literal["saw-drill", "drill-saw"]
SETUPS = (
    (2, Tool("drill", 14)), (2, Tool("drill", 22)), (13, Tool("drill", 14)), (1, Tool("drill", 14)),
    (2, Tool("tap", 16, pitch=2)), (2, Tool("countersink", 20, 90)), (1, Tool("tap", 16, pitch=2)),
)  # fmt: skip
FACES = {1: ("o",), 2: ("v",), 13: ("o", "u")}


TIMES = st.sampled_from(
    tuple(
        Times(tool_change_s=t, spindle_change_s=s) for t, s in ((8.0, 0.5), (1.0, 1.0), (0.5, 3.0))
    )
)


@st.composite
def strokes(draw: st.DrawFn, count: int) -> list[Operation]:
    """Strokes at few places, so that many share an X, and some even the place on the face."""
    ops: list[Operation] = []
    for index in range(count):
        spindle, tool = draw(st.sampled_from(SETUPS))
        x, y = draw(st.sampled_from((1200.0, 1500.0, 1900.0))), draw(st.sampled_from((40.0, 100.0)))
        ops.append(
            DrillOp(
                x, spindle, tool, FACES[spindle], y, None, ((0, index),), ("drill-exact",), SOURCE
            )
        )
    return ops


def must_follow(op: Operation, other: Operation) -> bool:
    """Whether `op` needs `other` done: a tap or sink on the drilled hole that it stands in."""
    return (
        isinstance(op, DrillOp)
        and isinstance(other, DrillOp)
        and op.tool.kind in ("tap", "countersink")
        and {"drill": 0, "countersink": 1, "tap": 2}[other.tool.kind]
        < {"drill": 0, "countersink": 1, "tap": 2}[op.tool.kind]
        and (op.x, op.y) == (other.x, other.y)
        and bool(set(op.faces) & set(other.faces))
    )


def change_s(order: Sequence[Operation], times: Times) -> float:
    """Time for changes: each spindle keeps its tool, and holds none before the work."""
    seconds, chosen = 0.0, 0
    held: dict[str, Tool] = {}
    for op in order:
        if isinstance(op, DrillOp):
            seconds += times.spindle_change_s * (op.spindle != chosen)
            seconds += times.tool_change_s * any(held.get(f) != op.tool for f in op.faces)
            chosen = op.spindle
            held |= dict.fromkeys(op.faces, op.tool)
    return seconds


def is_allowed(order: Sequence[Operation], layout: Layout) -> bool:
    """Whether a machine of that layout may work in this order."""
    if layout == "saw-drill":
        if any(b.x < a.x for a, b in pairwise(order)):
            return False
    else:
        # A part is done when it is cut off, and the cuts leave nothing to a cut before them.
        for index, op in enumerate(order):
            if isinstance(op, SawOp) and any(
                isinstance(later, DrillOp) and later.features[0][0] == op.pieces[0]
                for later in order[index + 1 :]
            ):
                return False
    return not any(
        must_follow(before, after)
        for index, before in enumerate(order)
        for after in order[index + 1 :]
    )


def cost(order: Sequence[Operation], times: Times) -> tuple[float, float]:
    """Travel of the bar, and time for changes of spindle or tool."""
    x, way = 0.0, 0.0
    for op in order:
        way += abs(op.x - x)
        x = op.x
    return way, change_s(order, times)


def best_cost(ops: Sequence[Operation], layout: Layout, times: Times) -> tuple[float, float]:
    return min(cost(order, times) for order in permutations(ops) if is_allowed(order, layout))


@settings(max_examples=examples(150), deadline=None)
@given(ops=strokes(5), times=TIMES)
def test_five_strokes(ops: list[Operation], times: Times) -> None:
    assert_best_order(ops, "saw-drill", times)


@settings(max_examples=examples(60), deadline=None)
@given(ops=strokes(6), layout=st.sampled_from(("saw-drill", "drill-saw")), times=TIMES)
def test_six_strokes(ops: list[Operation], layout: Layout, times: Times) -> None:
    assert_best_order(ops, layout, times)


@settings(max_examples=examples(25), deadline=None)
@given(ops=strokes(7), times=TIMES)
def test_seven_strokes(ops: list[Operation], times: Times) -> None:
    assert_best_order(ops, "saw-drill", times)


@settings(max_examples=examples(25), deadline=None)
@given(ops=strokes(5), second=st.sampled_from((2500.0, 3100.0)))
def test_strokes_and_cuts_where_the_drill_comes_first(ops: list[Operation], second: float) -> None:
    ops = [
        replace(op, features=((0 if op.x < 1900 else 1, index),)) for index, op in enumerate(ops)
    ]
    cuts = [
        SawOp(2000.0, 0.0, "parting", (0,), SOURCE),
        SawOp(second, 0.0, "parting", (1,), SOURCE),
    ]
    assert_best_order([*ops, *cuts], "drill-saw", Times(tool_change_s=8.0, spindle_change_s=0.5))


def in_order(
    ops: list[Operation], layout: Layout = "saw-drill", times: Times = LINE.times
) -> tuple[Operation, ...]:
    cuts = [op for op in ops if isinstance(op, SawOp)]
    strokes = [op for op in ops if not isinstance(op, SawOp)]
    assert LINE.layout is not None
    line = replace(LINE, layout=replace(LINE.layout, order=layout), times=times)
    return sort_along_x(cuts, strokes, line)


def assert_best_order(ops: list[Operation], layout: Layout, times: Times) -> None:
    order = in_order(ops, layout, times)
    assert sorted(map(id, order)) == sorted(map(id, ops))
    assert is_allowed(order, layout)
    found, best = cost(order, times), best_cost(ops, layout, times)
    assert abs(found[1] - best[1]) < 1e-9
    assert abs(found[0] - best[0]) < 1e-9
    forward, back = travel(order)
    assert back == 0
    assert abs(forward - found[0]) < 1e-9


@settings(max_examples=examples(200), deadline=None)
@given(ops=strokes(7), seed=st.randoms(use_true_random=False))
def test_the_order_of_the_input_does_not_matter(ops: list[Operation], seed: object) -> None:
    shuffled = list(ops)
    seed.shuffle(shuffled)  # type: ignore[attr-defined]
    assert in_order(shuffled) == in_order(ops)


def min_loads(needs: Sequence[Tool], stations: int) -> int:
    """Fewest loads for needs in this order, by trying every tool that could be thrown out."""
    states: dict[frozenset[Tool], int] = {frozenset(): 0}
    for tool in needs:
        after: dict[frozenset[Tool], int] = {}
        for held, count in states.items():
            if tool in held:
                options = [(held, count)]
            elif len(held) < stations:
                options = [(held | {tool}, count + 1)]
            else:
                options = [((held - {out}) | {tool}, count + 1) for out in held]
            for state, total in options:
                after[state] = min(total, after.get(state, total))
        states = after
    return min(states.values())


@settings(max_examples=examples(200), deadline=None)
@given(sizes=st.lists(st.integers(8, 15), min_size=1, max_size=14), stations=st.integers(1, 5))
def test_the_fewest_tools_are_loaded(sizes: list[int], stations: int) -> None:
    machine = load("beamline")
    web = replace(machine.spindles[1], stations=stations)
    machine = replace(machine, spindles=(web,))
    ops = [
        DrillOp(float(i), 2, Tool("drill", float(d)), ("v",), 40.0, None, ((0, i),), (), SOURCE)
        for i, d in enumerate(sizes)
    ]
    loads = tool_loads(ops, machine)
    assert len(loads) == min_loads([op.tool for op in ops], stations)
    assert sum(load.out is None for load in loads) == min(stations, len(set(sizes)))
    held: dict[int, Tool] = {}
    waiting = list(loads)
    for index, op in enumerate(ops):
        while waiting and waiting[0].before <= index:
            put = waiting.pop(0)
            assert held.get(put.station) == put.out
            held[put.station] = put.tool
        assert op.tool in held.values()
    assert set(held) <= set(range(1, stations + 1))
