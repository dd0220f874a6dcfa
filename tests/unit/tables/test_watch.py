"""The watch over each axis, and over the time of each operation: what is too far, and too late."""

from itertools import chain, repeat

from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.emitters import simotion
from tests.conftest import examples

from .deeds import displace, mend, override
from .plant import (
    DONE,
    FAULT,
    HOMING,
    WAITS,
    WAYS,
    WORK,
    Plant,
    cutting,
    each_kind,
    each_way,
    plant,
    small_job,
    small_machine,
    units_of,
)


@settings(max_examples=examples(25), deadline=None)
@given(way=st.sampled_from(WAYS), jitter=st.lists(st.integers(-1, 1), min_size=1, max_size=40))
def test_an_encoder_that_jitters_by_a_count_stops_nothing(
    way: tuple[str, str], jitter: list[int]
) -> None:
    counts = chain.from_iterable(repeat(jitter))
    one = plant(*way, jitter=lambda: next(counts))
    one.press_start()
    one.run_until(DONE)
    assert one.states == [WAITS, HOMING, WORK, DONE]


@each_way
def test_an_operation_that_is_slow_is_a_fault(style: str, kind: str) -> None:
    """A tenth of the speed: the way made so far has to be made in its time."""
    one = cutting(plant(style, kind))
    override(0.1)(one)
    since = one.clock_s
    one.run_until(FAULT, 2.0)
    t = one.triggers
    # max_late_s + late_factor x (way / speed + ramp), where the way is made at a tenth of it
    longest = (t.max_late_s + t.late_factor * 8 / t.acceleration) / (1 - t.late_factor / 10)
    assert one.clock_s - since <= longest + 3 * t.cycle_s
    assert one.value("faultNumber") == 4
    assert not one.tool_on


@each_way
def test_set_positions_that_stop_short_are_a_fault(style: str, kind: str) -> None:
    one = cutting(plant(style, kind))
    override(0.0)(one)
    one.cycle()  # sees the last move
    assert one.value("workState") == WORK
    one.cycle()
    assert one.value("workState") == WORK
    one.cycle()
    assert (one.value("faultNumber"), one.tool_on) == (4, False)


@each_kind
def test_a_move_that_does_not_begin_is_a_fault_after_two_cycles_more(kind: str) -> None:
    one = plant(kind=kind)
    one.press_start()
    while not one.tool_on:
        one.cycle()
    override(0.0)(one)
    while one.value("operation") != 3:
        one.cycle()
    for _ in range(3):
        one.cycle()
        assert one.tool_on
    one.cycle()
    assert (one.value("faultNumber"), one.tool_on) == (4, False)


@each_kind
def test_the_window_goes_by_the_speed_of_each_axis(kind: str) -> None:
    """Y rests on the line to (6, 2): what X may trail at 8 mm/s, Y may not."""
    for index, state in ((0, WORK), (1, FAULT)):
        one = cutting(plant(kind=kind))
        displace(index, 0.4)(one)
        one.wait(0.1)
        assert one.value("workState") == state
        assert one.value("faultNumber") == (7 if state == FAULT else 0)
    for index, state in ((0, FAULT), (1, WORK)):  # up to (9, 8), where Y is twice as fast
        one = cutting(plant(kind=kind))
        while one.value("operation") != 4:
            one.cycle()
        one.wait(0.25)
        displace(index, 0.53)(one)
        one.wait(0.1)
        assert one.value("workState") == state


def test_what_an_axis_trails_runs_down_with_the_lag_while_it_brakes() -> None:
    machine = small_machine()
    assert machine.triggers is not None
    slow = replace(machine.triggers, following_lag_s=0.15, max_late_s=1.0)
    machine = replace(machine, triggers=slow)
    text = simotion.emit(small_job(), machine, "chain")
    forgetful = text.replace("trail := (trail +", "trail := (LREAL#0.0 +")
    assert forgetful != text
    for program, state in ((text, DONE), (forgetful, FAULT)):
        one = Plant(units_of(program, machine), machine)
        one.trails_s = 0.15
        one.press_start()
        one.run_until(state)
        assert one.value("faultNumber") == (7 if state == FAULT else 0)


@each_way
def test_axes_that_trail_by_the_lag_stop_nothing(style: str, kind: str) -> None:
    one = plant(style, kind)
    one.trails_s = one.triggers.following_lag_s
    one.press_start()
    one.run_until(DONE)
    assert one.states == [WAITS, HOMING, WORK, DONE]
    slack = plant(style, kind)
    slack.trails_s = 3 * slack.triggers.following_lag_s
    slack.press_start()
    slack.run_until(FAULT)
    assert slack.value("faultNumber") == 7


@each_kind
def test_one_disturbed_reading_stops_nothing_and_two_do(kind: str) -> None:
    for cycles, state in ((1, WORK), (2, FAULT)):
        one = cutting(plant(kind=kind))
        displace(0, 2.0)(one)
        for _ in range(cycles):
            one.cycle()
        mend(one)
        one.cycle()
        assert one.value("workState") == state
        assert one.value("faultNumber") == (7 if state == FAULT else 0)
