"""The runtime of trigger programs with faults thrown in at any time, by an executor of its text."""

from itertools import chain, repeat

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.emitters import simotion
from beamcam.machine.runtime import INPUTS
from beamcam.model.triggers import Switch

from .plant import (
    DONE,
    FAULT,
    HOMING,
    STOPPED_S,
    WAITS,
    WORK,
    Deed,
    Plant,
    alarm,
    alarm_that_stays,
    break_wire,
    close,
    disable,
    displace,
    fault_task,
    loaded,
    mend,
    override,
    press_stop,
    small_job,
    small_machine,
    units_of,
)

WAYS = [("chain", False), ("table", False), ("chain", True), ("table", True)]
#: What fails, and the numbers that may be shown: a drive that is not ready refuses commands.
DEEDS: dict[str, tuple[Deed, tuple[int, ...]]] = {
    "X disabled": (disable(0), (2, 5)),
    "Y disabled": (disable(1), (2, 5)),
    "alarm of X": (alarm(0), (2,)),
    "alarm of Y": (alarm(1), (2,)),
    "fault task": (fault_task, (6,)),
    "X high switch": (close(1), (1,)),
    "Y high switch": (close(3), (1,)),
    "stop button": (press_stop, (9,)),
}
CYCLES = 500  #: of a run with nothing wrong, about


def cutting(one: Plant) -> Plant:
    """The same plant, homed and cutting its first line."""
    one.press_start()
    while not one.tool_on or one.still:
        one.cycle()
    return one


def plant(style: str = "chain", path_objects: bool = False, **more: object) -> Plant:
    return Plant(loaded(style, path_objects), small_machine(path_objects), **more)  # type: ignore[arg-type]


def places(job_of: Plant) -> list[tuple[float, float]]:
    return [(round(x, 2), round(y, 2)) for x, y in job_of.points["cut"]]


@pytest.mark.parametrize(("style", "path_objects"), WAYS)
@pytest.mark.parametrize("late", [False, True])
def test_a_run_without_faults_ends_at_home(style: str, path_objects: bool, late: bool) -> None:
    one = plant(style, path_objects)
    one.late = late
    one.press_start()
    one.run_until(DONE)
    assert one.states == [WAITS, HOMING, WORK, DONE]
    assert one.said == []
    assert [round(a.position, 6) for a in one.axes] == [0.0, 0.0]
    for op in small_job(path_objects).operations:
        if not isinstance(op, Switch) and (op.x, op.y) not in ((0, 0), (10, 4), (10, 9)):
            assert (op.x, op.y) in places(one)
    assert max(y for _, y in one.points["mark"]) == 9.0


@settings(max_examples=50, deadline=None)
@given(
    way=st.sampled_from(WAYS),
    kind=st.sampled_from(sorted(DEEDS)),
    at=st.integers(0, CYCLES),
    start_held=st.booleans(),
)
def test_whatever_fails_ends_in_a_shown_fault_and_a_new_press_begins_anew(
    way: tuple[str, bool], kind: str, at: int, start_held: bool
) -> None:
    deed, numbers = DEEDS[kind]
    one = plant(*way)
    one.press_start()
    while one.count < at and one.value("workState") != DONE:
        one.cycle()
    before = one.value("workState")
    deed(one)
    one.cycle()
    one.cycle()
    told_always = kind in ("fault task", "stop button") or kind.startswith("alarm")
    if before not in (HOMING, WORK) and not told_always:
        assert not one.tool_on  # nothing runs; the next start will find it
        return
    if kind.endswith("disabled") and before == HOMING and one.value("workState") == HOMING:
        while one.value("workState") == HOMING:  # not enabled yet, or enabled in this cycle
            one.cycle()
        assert one.clock_s < 2 * one.triggers.max_homing_s
        return
    if before == HOMING and kind.endswith("high switch"):
        one.run_until(FAULT, 5.0)  # which is told as soon as the axis should have left it
    assert one.value("workState") == FAULT
    assert one.value("faultNumber") in numbers
    assert not one.tool_on
    one.start = start_held
    one.wait(STOPPED_S)
    assert one.still
    mend(one)
    one.wait(0.5)
    assert one.value("workState") == FAULT, "only an acknowledgement ends a fault"
    one.press_acknowledge()
    one.wait(0.5)
    assert one.value("workState") == WAITS, "a held button starts nothing"
    one.points.clear()
    one.press_start()
    assert one.value("workState") == HOMING
    one.run_until(DONE)
    again = plant(*way)
    again.press_start()
    again.run_until(DONE)
    assert set(places(one)) == set(places(again)), "the part is begun anew, and made whole"


@st.composite
def scripts(draw: st.DrawFn) -> dict[int, Deed]:
    """Faults and buttons at any time, in any order."""
    buttons = {
        "start": press("start", True),
        "let start go": press("start", False),
        "acknowledge": press("acknowledge", True),
        "let go": press("acknowledge", False),
        "mend": mend,
    }
    deeds = buttons | {name: deed for name, (deed, _) in DEEDS.items()}
    drawn = draw(st.lists(st.tuples(st.integers(2, 900), st.sampled_from([*deeds])), max_size=25))
    return {1: buttons["start"]} | {at: deeds[name] for at, name in drawn}


def press(button: str, down: bool) -> Deed:
    return lambda plant: setattr(plant, button, down)


@settings(max_examples=40, deadline=None)
@given(way=st.sampled_from(WAYS), script=scripts())
def test_whatever_happens_the_laws_of_every_cycle_hold(
    way: tuple[str, bool], script: dict[int, Deed]
) -> None:
    """See `Plant.observe`: no tool out of work, no work in mid cut, no start without a press."""
    one = plant(*way, script=script)
    for _ in range(1000):
        one.cycle()
    assert one.count == 1000  # each of them held against the laws


@settings(max_examples=25, deadline=None)
@given(way=st.sampled_from(WAYS), jitter=st.lists(st.integers(-1, 1), min_size=1, max_size=40))
def test_an_encoder_that_jitters_by_a_count_stops_nothing(
    way: tuple[str, bool], jitter: list[int]
) -> None:
    counts = chain.from_iterable(repeat(jitter))
    one = plant(*way, jitter=lambda: next(counts))
    one.press_start()
    one.run_until(DONE)
    assert one.states == [WAITS, HOMING, WORK, DONE]


@pytest.mark.parametrize(("style", "path_objects"), WAYS)
def test_an_operation_that_is_slow_is_a_fault(style: str, path_objects: bool) -> None:
    """A tenth of the speed: the way made so far has to be made in its time."""
    one = cutting(plant(style, path_objects))
    override(0.1)(one)
    since = one.clock_s
    one.run_until(FAULT, 2.0)
    t = one.triggers
    # max_late_s + late_factor x (way / speed + ramp), where the way is made at a tenth of it
    longest = (t.max_late_s + t.late_factor * 8 / t.acceleration) / (1 - t.late_factor / 10)
    assert one.clock_s - since <= longest + 3 * t.cycle_s
    assert one.value("faultNumber") == 4
    assert not one.tool_on


@pytest.mark.parametrize(("style", "path_objects"), WAYS)
def test_set_positions_that_stop_short_are_a_fault(style: str, path_objects: bool) -> None:
    one = cutting(plant(style, path_objects))
    override(0.0)(one)
    one.cycle()  # sees the last move
    assert one.value("workState") == WORK
    one.cycle()
    assert one.value("workState") == WORK
    one.cycle()
    assert (one.value("faultNumber"), one.tool_on) == (4, False)


def test_a_move_that_does_not_begin_is_a_fault_after_two_cycles_more() -> None:
    one = plant()
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


def test_the_window_goes_by_the_speed_of_each_axis() -> None:
    """Y rests on the line to (6, 2): what X may trail at 8 mm/s, Y may not."""
    for index, state in ((0, WORK), (1, FAULT)):
        one = cutting(plant())
        displace(index, 0.4)(one)
        one.wait(0.1)
        assert one.value("workState") == state
        assert one.value("faultNumber") == (7 if state == FAULT else 0)
    for index, state in ((0, FAULT), (1, WORK)):  # up to (9, 8), where Y is twice as fast
        one = cutting(plant())
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


@pytest.mark.parametrize(("style", "path_objects"), WAYS)
def test_axes_that_trail_by_the_lag_stop_nothing(style: str, path_objects: bool) -> None:
    one = plant(style, path_objects)
    one.trails_s = one.triggers.following_lag_s
    one.press_start()
    one.run_until(DONE)
    assert one.states == [WAITS, HOMING, WORK, DONE]
    slack = plant(style, path_objects)
    slack.trails_s = 3 * slack.triggers.following_lag_s
    slack.press_start()
    slack.run_until(FAULT)
    assert slack.value("faultNumber") == 7


def test_the_stop_button_stops_and_a_start_waits_for_its_release() -> None:
    one = plant()
    press_stop(one)
    one.press_start()
    assert (one.value("workState"), one.value("faultNumber")) == (FAULT, 9)
    one.press_acknowledge()
    one.wait(0.5)
    assert one.value("workState") == FAULT, "stop is still pressed"
    one.stop = False
    one.cycle()
    assert one.value("workState") == WAITS, "it was acknowledged"
    cutting(one)
    press_stop(one)
    one.cycle()
    assert (one.value("faultNumber"), one.tool_on) == (9, False)
    one.wait(STOPPED_S)
    assert one.still


def test_a_broken_wire_of_what_is_normally_closed_stops_and_of_another_does_nothing() -> None:
    numbers = {}
    for k, name in enumerate(INPUTS):
        one = cutting(plant())
        break_wire(k)(one)
        one.cycle()
        one.cycle()
        numbers[name] = one.value("faultNumber")
        assert one.tool_on == (numbers[name] == 0)
    assert numbers == {
        "limitXLow": 1, "limitXHigh": 1, "limitYLow": 1, "limitYHigh": 1, "startButton": 0,
        "acknowledgeButton": 0, "stopButton": 9,
    }  # fmt: skip


def test_inputs_may_be_normally_open() -> None:
    machine = small_machine()
    assert machine.triggers is not None
    machine = replace(machine, triggers=replace(machine.triggers, normally_closed=()))
    units = units_of(simotion.emit(small_job(), machine, "chain"), machine)
    one = Plant(units, machine)
    one.press_start()
    one.run_until(DONE)
    assert one.value("limitXLow") is False
    cutting(one)
    close(2)(one)
    one.cycle()
    assert one.value("faultNumber") == 1


def test_one_disturbed_reading_stops_nothing_and_two_do() -> None:
    for cycles, state in ((1, WORK), (2, FAULT)):
        one = cutting(plant())
        displace(0, 2.0)(one)
        for _ in range(cycles):
            one.cycle()
        mend(one)
        one.cycle()
        assert one.value("workState") == state
        assert one.value("faultNumber") == (7 if state == FAULT else 0)


@pytest.mark.parametrize("index", [0, 2])
def test_a_low_switch_that_closes_in_work_is_a_fault(index: int) -> None:
    one = plant()
    one.press_start()
    one.run_until(WORK)
    one.wait(0.5)
    close(index)(one)
    one.cycle()
    assert one.value("faultNumber") == 1
    assert not one.tool_on


@pytest.mark.parametrize("index", [0, 1])
def test_homing_that_takes_too_long_is_a_fault(index: int) -> None:
    one = plant()
    one.axes[index].place = 1000.0  # the switch is far, or does not work
    one.ends = (2000.0, 2000.0)
    one.press_start()
    one.run_until(FAULT)
    assert one.value("faultNumber") == 3
    assert one.clock_s <= one.triggers.max_homing_s + 0.2
    one.wait(STOPPED_S)
    assert one.still


def test_an_axis_that_drops_out_in_mid_cut() -> None:
    """Disabled in mid cut, the torch stayed on until the end of the operation and beyond."""
    one = plant()
    one.press_start()
    while not one.tool_on or one.still:
        one.cycle()
    disable(0)(one)
    one.cycle()
    assert (one.value("workState"), one.value("faultNumber")) == (FAULT, 2)
    assert not one.tool_on
    one.wait(STOPPED_S)
    assert one.still


def test_homing_leaves_a_high_switch_but_does_not_meet_it_again() -> None:
    one = plant()
    one.axes[0].place = one.ends[0] + 0.5
    one.press_start()
    one.run_until(DONE)
    stuck = plant()
    close(1)(stuck)
    stuck.press_start()
    stuck.run_until(FAULT)
    assert stuck.value("faultNumber") == 1
    assert WORK not in stuck.states


def test_an_axis_that_runs_from_its_switch_is_a_fault() -> None:
    one = plant()
    real = one.axes[1].run
    one.axes[1].run = lambda v, a: real(-v, a)  # type: ignore[method-assign]
    one.press_start()
    one.run_until(FAULT, 2.0)
    assert one.value("faultNumber") == 3
    one.wait(STOPPED_S)
    assert one.still


def test_a_command_that_is_refused_is_a_fault() -> None:
    one = plant()
    one.press_start()
    one.run_until(WORK)
    while not one.tool_on:
        one.cycle()
    real = one.command
    one.command = lambda name, values, line: 1 if name == "_POS" else real(name, values, line)  # type: ignore[method-assign]
    one.run_until(FAULT, 3.0)
    assert one.value("faultNumber") == 5
    assert not one.tool_on


@pytest.mark.parametrize("stop", ["_STOP"])
def test_a_stop_that_is_refused_is_repeated(stop: str) -> None:
    one = plant()
    one.press_start()
    while not one.tool_on or one.still:
        one.cycle()
    real, refused = one.command, [0]

    def command(name: str, values: dict[str, object], line: int) -> int:
        if name == stop and refused[0] < 3:
            refused[0] += 1
            return 1
        return real(name, values, line)

    one.command = command  # type: ignore[method-assign]
    close(1)(one)
    one.wait(STOPPED_S)
    assert refused == [3]
    assert one.still
    assert one.axes[0].position < 5.0, "the axis ran on to its end at 6"


def test_a_button_that_is_held_at_power_up_starts_nothing() -> None:
    one = plant()
    one.start = True
    one.wait(0.5)
    assert one.value("workState") == WAITS
    one.press_start()
    assert one.value("workState") == HOMING


def test_after_the_end_a_new_press_makes_the_part_again() -> None:
    one = plant()
    one.press_start()
    one.run_until(DONE)
    first = places(one)
    one.wait(1.0)
    assert one.value("workState") == DONE, "the button is still held"
    one.points.clear()
    one.press_start()
    one.run_until(HOMING)
    one.run_until(DONE)
    assert set(places(one)) == set(first)


def test_a_start_button_does_nothing_in_work_or_in_a_fault() -> None:
    one = plant()
    one.press_start()
    one.run_until(WORK)
    one.press_start()
    assert one.value("workState") == WORK
    alarm(0)(one)
    one.run_until(FAULT, 1.0)
    one.press_start()
    one.wait(0.5)
    assert one.value("workState") == FAULT


def test_a_fault_stays_until_the_axis_reports_no_error() -> None:
    one = plant()
    one.press_start()
    one.run_until(WORK)
    alarm_that_stays(0, 10)(one)
    one.run_until(FAULT, 1.0)
    one.press_acknowledge()
    assert one.value("workState") == FAULT
    one.press_start()
    one.wait(1.0)
    assert one.value("workState") == WAITS
    assert one.value("faultNumber") == 0


def test_an_axis_that_reports_an_error_before_the_start_is_told() -> None:
    one = plant()
    one.cycle()
    alarm(1)(one)
    one.cycle()
    assert one.value("faultNumber") == 2
    one.press_start()
    assert one.value("workState") == FAULT


def test_an_acknowledge_button_that_is_held_acknowledges_nothing() -> None:
    one = plant()
    one.acknowledge = True
    one.press_start()
    one.run_until(WORK)
    alarm(0)(one)
    one.wait(0.5)
    assert one.value("workState") == FAULT
    one.press_acknowledge()
    one.cycle()
    assert one.value("workState") == WAITS
