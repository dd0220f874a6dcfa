"""The runtime of trigger programs with faults thrown in at any time, by an executor of its text."""

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.emitters import simotion
from beamcam.machine.runtime import INPUTS
from beamcam.model.program import ArcTravel, Travel
from tests.conftest import examples

from .deeds import alarm, break_wire, close, disable, fault_task, mend, press_stop
from .plant import (
    DONE,
    FAULT,
    HOMING,
    MOVES,
    STOPPED_S,
    STOPS,
    WAITS,
    WAYS,
    WORK,
    Deed,
    Plant,
    cutting,
    each_kind,
    each_way,
    plant,
    small_job,
    small_machine,
    units_of,
)

#: What fails, and the numbers that may be shown: a drive that is not ready refuses commands.
DEEDS: dict[str, tuple[Deed, tuple[int, ...]]] = {
    "X disabled": (disable(0), (2, 5)),
    "Y disabled": (disable(1), (2, 5)),
    "alarm of X": (alarm(0), (2,)),
    "alarm of Y": (alarm(1), (2,)),
    "fault task": (fault_task, (6,)),
    "X high switch": (close(1), (1,)),
    "Y high switch": (close(3), (1,)),
    "alarm of the last axis": (alarm(-1), (2,)),
    "last axis disabled": (disable(-1), (2, 5)),
    "stop button": (press_stop, (9,)),
}
CYCLES = 900  #: of a run with nothing wrong, about


@each_way
@pytest.mark.parametrize("late", [False, True])
def test_a_run_without_faults_ends_at_home(style: str, kind: str, late: bool) -> None:
    one = plant(style, kind)
    one.late = late
    one.press_start()
    one.run_until(DONE)
    assert one.states == [WAITS, HOMING, WORK, DONE]
    assert one.diagnostics == []
    assert [round(a.position, 6) for a in one.axes[:2]] == [0.0, 0.0]
    for op in small_job(kind).operations:
        if isinstance(op, Travel | ArcTravel) and (op.x, op.y) not in ((0, 0), (10, 4), (10, 9)):
            assert (op.x, op.y) in one.places()
    assert max(y for _, y in one.points["mark"]) == 9.0


@settings(max_examples=examples(50), deadline=None)
@given(
    way=st.sampled_from(WAYS),
    what=st.sampled_from(sorted(DEEDS)),
    at=st.integers(0, CYCLES),
    start_held=st.booleans(),
)
def test_whatever_fails_ends_in_a_shown_fault_and_a_new_press_begins_anew(
    way: tuple[str, str], what: str, at: int, start_held: bool
) -> None:
    assume(what != "fault task" or not way[1].startswith("blocks"))  # which has no such task
    deed, numbers = DEEDS[what]
    one = plant(*way)
    one.press_start()
    while one.count < at and one.value("workState") != DONE:
        one.cycle()
    before = one.value("workState")
    deed(one)
    one.cycle()
    one.cycle()
    told_always = what in ("fault task", "stop button") or what.startswith("alarm")
    if before not in (HOMING, WORK) and not told_always:
        assert not one.tool_on  # nothing runs; the next start will find it
        return
    if what.endswith("disabled") and before == HOMING and one.value("workState") == HOMING:
        while one.value("workState") == HOMING:  # not enabled yet, or enabled in this cycle
            one.cycle()
        assert one.clock_s < 2 * one.triggers.max_homing_s
        return
    if before == HOMING and what.endswith("high switch"):
        one.run_until(FAULT, 15.0)  # which is told as soon as the axis should have left it
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
    assert set(one.places()) == set(again.places()), "the part is begun anew, and made whole"


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


@settings(max_examples=examples(40), deadline=None)
@given(way=st.sampled_from(WAYS), script=scripts())
def test_whatever_happens_the_laws_of_every_cycle_hold(
    way: tuple[str, str], script: dict[int, Deed]
) -> None:
    """See `Plant.observe`: no tool out of work, no work in mid cut, no start without a press."""
    if way[1].startswith("blocks"):
        script = {at: deed for at, deed in script.items() if deed is not fault_task}
    one = plant(*way, script=script)
    for _ in range(1000):
        one.cycle()
    assert one.count == 1000  # each of them held against the laws


@each_kind
def test_a_broken_wire_stops_where_its_input_is_normally_closed_only(kind: str) -> None:
    numbers = {}
    for k, name in enumerate(INPUTS[:7]):  # those of Z are in test_lift.py
        one = cutting(plant(kind=kind))
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


@each_kind
@pytest.mark.parametrize("index", [0, 2])
def test_a_low_switch_that_closes_in_work_is_a_fault(kind: str, index: int) -> None:
    one = plant(kind=kind)
    one.press_start()
    one.run_until(WORK)
    one.wait(0.5)
    close(index)(one)
    one.cycle()
    assert one.value("faultNumber") == 1
    assert not one.tool_on


@each_kind
def test_an_axis_that_drops_out_in_mid_cut(kind: str) -> None:
    """Disabled in mid cut, the torch stayed on until the end of the operation and beyond."""
    one = cutting(plant(kind=kind))
    disable(0)(one)
    one.cycle()
    assert (one.value("workState"), one.value("faultNumber")) == (FAULT, 2)
    assert not one.tool_on
    one.wait(STOPPED_S)
    assert one.still


@each_kind
def test_a_command_that_is_refused_is_a_fault(kind: str) -> None:
    one = plant(kind=kind)
    one.press_start()
    one.run_until(WORK)
    while not one.tool_on:
        one.cycle()
    real = one.command
    one.command = lambda name, values, line: 1 if name in MOVES else real(name, values, line)  # type: ignore[method-assign]
    one.run_until(FAULT, 3.0)
    assert one.value("faultNumber") == 5
    assert not one.tool_on


@each_kind
def test_a_stop_that_is_refused_is_repeated(kind: str) -> None:
    one = cutting(plant(kind=kind))
    real, refused = one.command, [0]

    def command(name: str, values: dict[str, object], line: int) -> int:
        if name in STOPS and refused[0] < 3:
            refused[0] += 1
            return 1
        return real(name, values, line)

    one.command = command  # type: ignore[method-assign]
    close(1)(one)
    one.wait(STOPPED_S)
    assert refused == [3]
    assert one.still
    assert one.axes[0].position < 5.0, "the axis ran on to its end at 6"
