"""Homing with faults thrown in at every cycle of it: no part is made from a wrong zero."""

from collections.abc import Iterator

import pytest

from tests.conftest import sampled

from .deeds import (
    alarm,
    break_wire,
    close,
    creep,
    disable,
    fault_task,
    freeze,
    mend,
    press_stop,
    release,
    reverse,
)
from .plant import DONE, FAULT, HOMING, STOPPED_S, WORK, Deed, Plant, each_kind, plant

EXACT = 0.06  #: mm of the zero: two cycles of the slow approach, and its stop


def wrong_by(one: Plant) -> float:
    """How far the zeros are off: the back-off from the switches, which are at place 0."""
    return max(abs(axis.origin - one.triggers.back_off) for axis in one.axes)


def moments(one: Plant) -> Iterator[bytes]:
    """A copy of the plant in every cycle of its homing, from the press of start."""
    one.press_start()
    while one.value("workState") == HOMING:
        yield one.keep()
        one.cycle()
    assert one.value("workState") == WORK
    assert wrong_by(one) <= EXACT


def outcome(one: Plant, kept: bytes, deed: Deed, cycles: int) -> str:
    """What a fault of so many cycles, from a moment on, leads to: zero, or a number."""
    one.go_back(kept)
    deed(one)
    for left in range(2000, 0, -1):
        one.cycle()
        if left == 2001 - cycles:
            mend(one)
        if one.value("workState") != HOMING:
            break
    assert one.value("workState") in (WORK, FAULT)
    return f"fault {one.value('faultNumber')}" if one.value("workState") == FAULT else "zero"


@pytest.mark.parametrize("index", [0, pytest.param(1, marks=pytest.mark.exhaustive)])
@pytest.mark.parametrize(
    ("style", "kind", "cycles"),
    [("chain", "axes", 5), ("table", "blocks", 2),
     *(pytest.param(*row, marks=pytest.mark.exhaustive) for row in [
         ("chain", "axes", 1), ("table", "blocks", 30), ("table", "axes", 1), ("chain", "axes", 2),
         ("chain", "axes", 30), ("chain", "blocks", 1), ("chain", "blocks", 5)])],
)  # fmt: skip
@pytest.mark.parametrize("what", [close, release])
def test_a_low_switch_that_lies_for_some_cycles_makes_no_wrong_zero(
    style: str, kind: str, index: int, cycles: int, what: object
) -> None:
    one = plant(style, kind)
    found = set()
    for kept in moments(one):
        found.add(outcome(one, kept, what(2 * index), cycles))  # type: ignore[operator]
        late = cycles * one.triggers.homing_slow_mm_s * one.triggers.cycle_s
        early = one.triggers.homing_window if cycles > 1 else 0.0
        most = EXACT + (late if what is release else early)
        assert one.value("workState") == FAULT or wrong_by(one) <= most
        one.go_back(kept)
    assert {"zero", "fault 8"} <= found
    assert found <= {"zero", "fault 8", "fault 3"}


@pytest.mark.parametrize(
    "kind", ["axes", *(pytest.param(k, marks=pytest.mark.exhaustive) for k in ("blocks", "paths"))]
)
@pytest.mark.parametrize(
    ("deed", "numbers"),
    sampled([
        (close(0), {3, 8}), (close(2), {3, 8}), (break_wire(0), {3, 8}), (release(0), {3, 7, 8}),
        (close(1), {1}), (break_wire(3), {1}), (press_stop, {9}), (break_wire(6), {9}),
        (disable(0), {2, 3, 5}), (alarm(1), {2}), (fault_task, {6}), (freeze(0), {7}),
        (freeze(1), {7}),
    ], 2),
)  # fmt: skip
def test_what_fails_for_good_ends_in_its_fault(deed: Deed, numbers: set[int], kind: str) -> None:
    """A switch may also fail behind the zero, where it is not asked any more."""
    if deed is fault_task and kind == "blocks":
        return  # which have no such task
    one = plant("chain", kind)
    for kept in moments(one):
        found = outcome(one, kept, deed, 3000)
        if found == "zero":
            assert wrong_by(one) <= EXACT
        else:
            assert int(found.removeprefix("fault ")) in numbers
        one.go_back(kept)


@each_kind
def test_a_low_switch_that_sticks_is_a_fault_of_homing(kind: str) -> None:
    one = plant(kind=kind)
    close(0)(one)
    one.press_start()
    one.run_until(FAULT)
    assert one.value("faultNumber") == 8
    assert WORK not in one.states
    mend(one)
    one.press_acknowledge()
    one.press_start()
    one.run_until(DONE)


@each_kind
def test_an_axis_that_stands_at_its_low_switch_leaves_it_first(kind: str) -> None:
    for place in (-0.4, -2.0):
        one = plant(kind=kind)
        one.axes[0].place = place
        one.press_start()
        one.run_until(DONE)
        assert wrong_by(one) <= EXACT


@each_kind
@pytest.mark.parametrize("index", [0, 1])
def test_both_switches_of_an_axis_at_once_are_a_fault(kind: str, index: int) -> None:
    one = plant(kind=kind)
    close(2 * index)(one)
    close(2 * index + 1)(one)
    one.press_start()
    one.wait(0.1)
    assert one.value("faultNumber") == 1


@each_kind
def test_a_slow_approach_that_does_not_find_the_switch_again_is_a_fault(kind: str) -> None:
    one = plant(kind=kind)
    one.press_start()
    while one.value("workState") == HOMING and one.axes[0].velocity > -5:
        one.cycle()
    while one.axes[0].velocity < 0.5:
        one.cycle()
    release(0)(one)
    one.run_until(FAULT, 10.0)
    assert one.value("faultNumber") == 8
    assert one.axes[0].place > -2 * one.triggers.homing_window


@each_kind
def test_a_high_switch_that_was_free_is_a_fault_in_the_same_cycle(kind: str) -> None:
    one = plant(kind=kind)
    one.press_start()
    one.wait(0.3)
    close(1)(one)
    one.cycle()
    one.cycle()  # the fault of the block is seen before the next call of it
    assert one.value("faultNumber") == 1


@each_kind
def test_a_low_switch_that_is_actuated_again_while_backing_off_is_a_fault(kind: str) -> None:
    one = plant(kind=kind)
    one.press_start()
    origin = one.axes[0].origin
    while one.axes[0].origin == origin:
        one.cycle()
    one.wait(0.2)
    assert one.value("workState") == HOMING
    close(0)(one)
    one.run_until(FAULT, 3.0)
    assert one.value("faultNumber") == 8
    assert WORK not in one.states


@each_kind
def test_a_zero_does_not_blind_the_watch(kind: str) -> None:
    """The set position of Y jumps by 5 mm while it rests there, which is no speed of 200 mm/s."""
    one = plant(kind=kind)
    one.press_start()
    while one.axes[1].origin < 4.0:
        one.cycle()
    creep(1, 8.0)(one)
    one.run_until(FAULT, 3.0)
    assert one.value("faultNumber") == 7
    assert abs(one.axes[1].lag) <= 1.0


@each_kind
@pytest.mark.parametrize("index", [0, 1])
def test_homing_that_takes_too_long_is_a_fault(kind: str, index: int) -> None:
    one = plant(kind=kind)
    one.axes[index].place = 1000.0  # the switch is far, or does not work
    one.ends = (2000.0, 2000.0)
    one.press_start()
    one.run_until(FAULT)
    assert one.value("faultNumber") == 3
    assert one.clock_s <= one.triggers.max_homing_s + 0.2
    one.wait(STOPPED_S)
    assert one.still


@each_kind
def test_homing_leaves_a_high_switch_but_does_not_meet_it_again(kind: str) -> None:
    one = plant(kind=kind)
    one.axes[0].place = one.ends[0] + 0.5
    one.press_start()
    one.run_until(DONE)
    stuck = plant(kind=kind)
    close(1)(stuck)
    stuck.press_start()
    stuck.run_until(FAULT)
    assert stuck.value("faultNumber") == 1
    assert WORK not in stuck.states


@each_kind
def test_an_axis_that_runs_from_its_switch_is_a_fault(kind: str) -> None:
    one = plant(kind=kind)
    reverse(1)(one)
    one.press_start()
    one.run_until(FAULT, 2.0)
    assert one.value("faultNumber") == 3
    one.wait(STOPPED_S)
    assert one.still


@each_kind
def test_a_homing_that_was_stopped_begins_anew(kind: str) -> None:
    """Execute was on when it was stopped; an edge has to start it again."""
    one = plant(kind=kind)
    one.press_start()
    one.wait(0.3)
    assert one.value("workState") == HOMING
    close(1)(one)
    one.run_until(FAULT, 2.0)
    mend(one)
    one.press_acknowledge()
    one.wait(0.1)
    one.press_start()
    one.run_until(DONE)
