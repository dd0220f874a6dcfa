"""Trigger programs in plain IEC 61131-3: the same path as on SIMOTION, and the same laws."""

from collections.abc import Callable
from functools import cache

import pytest
import shapely
from msgspec.structs import replace

from beamcam.controllers.simotion.syntax import Unit
from beamcam.emitters import simotion
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.machine.runtime import runtime_of
from beamcam.verify.st import verify_triggers

from . import test_faults as laws
from .plant import (
    DONE,
    FAULT,
    HOMING,
    STOPPED_S,
    WAITS,
    WORK,
    Plant,
    alarm,
    close,
    disable,
    displace,
    freeze,
    mend,
    small_job,
    units_of,
)
from .plant import small_machine as small_simotion
from .shop import NAMES, steel_part, table_machine, triggers

STYLES = ("chain", "table")


def plain_machine(**changes: object) -> Machine:
    machine = load("table-plcopen")
    assert machine.triggers is not None
    return replace(machine, triggers=replace(machine.triggers, **changes))


@cache
def small_machine() -> Machine:
    machine = plain_machine(back_off=5.0, overrun=5.0, max_homing_s=15.0, max_late_s=1.0)
    assert machine.torch is not None
    return replace(machine, torch=replace(machine.torch, length=40.0, width=40.0))


@cache
def loaded(style: str = "chain") -> tuple[Unit, ...]:
    machine = small_machine()
    return units_of(simotion.emit(small_job(), machine, style), machine)


def plant(style: str = "chain", path_objects: bool = False, **more: object) -> Plant:
    """A table with plain blocks, where a law of test_faults.py asks for one."""
    return Plant(loaded(style), small_machine(), **more)  # type: ignore[arg-type]


@cache
def program(name: str, style: str) -> str:
    return simotion.emit(triggers(name), plain_machine(), style)


# -- what it makes --------------------------------------------------------------------------


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("name", NAMES)
def test_every_sample_makes_its_part(name: str, style: str) -> None:
    text = program(name, style)
    machine = plain_machine()
    assert verify_triggers(text, [steel_part(name)], machine, (), "a.st") == ()
    assert verify_triggers(text, [], machine, (), "a.st") == ()
    assert text.isascii()
    assert "//" not in text
    fixed = runtime_of(machine, style)
    for piece in (fixed.head, fixed.middle, fixed.end):
        assert text.count(piece) == 1


@pytest.mark.parametrize(
    ("name", "style"),
    [("shield", "chain"), ("rounded-rectangle", "table"), ("four-nodes", "chain"),
     ("two-tangents", "table")],
)  # fmt: skip
def test_both_dialects_draw_the_same_path(name: str, style: str) -> None:
    """Lines, arcs and a polynomial, run by an executor of each text."""
    points = {}
    for machine in (table_machine(), plain_machine()):
        text = simotion.emit(triggers(name), machine, style)
        one = Plant(units_of(text, machine), machine)
        one.press_start()
        one.run_until(DONE, 900.0)
        assert one.said == []
        assert one.states == [WAITS, HOMING, WORK, DONE]
        points[machine.name] = one.points
    simotion_points, plain_points = points.values()
    assert simotion_points.keys() == plain_points.keys() != set()
    tolerance = plain_machine().torch.tolerance  # type: ignore[union-attr]
    for process, drawn in simotion_points.items():
        one, other = shapely.LineString(drawn), shapely.LineString(plain_points[process])
        assert shapely.hausdorff_distance(one, other) <= tolerance


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("restarts", [0, 1])
def test_both_dialects_take_the_same_path_and_time(style: str, restarts: int) -> None:
    """A restart begins the part anew, behind a fault in mid cut."""
    told = []
    for machine in (small_simotion(), small_machine()):
        one = Plant(units_of(simotion.emit(small_job(), machine, style), machine), machine)
        for _ in range(restarts):
            one.press_start()
            while not one.tool_on or one.still:
                one.cycle()
            one.wait(0.3)
            close(1)(one)
            one.cycle()
            assert (one.value("workState"), one.value("faultNumber")) == (FAULT, 1)
            assert not one.tool_on
            one.wait(STOPPED_S)
            assert one.still
            mend(one)
            one.press_acknowledge()
            one.cycle()
            assert one.value("workState") == WAITS
            one.points.clear()
        one.press_start()
        one.run_until(WORK)
        before = one.count
        one.run_until(DONE)
        assert [round(axis.position, 6) for axis in one.axes] == [0.0, 0.0]
        told.append((one.count - before, one.points))
    (cycles, points), (other_cycles, other_points) = told
    assert cycles == other_cycles
    assert points.keys() == other_points.keys() == {"cut", "mark"}
    for process in points:
        pairs = zip(points[process], other_points[process], strict=True)
        assert all(a == pytest.approx(b, abs=1e-6) for a, b in pairs)


# -- the laws of every dialect --------------------------------------------------------------

LAWS: tuple[tuple[Callable[..., None], tuple[object, ...]], ...] = (
    (laws.test_a_run_without_faults_ends_at_home, ("chain", False, False)),
    (laws.test_a_run_without_faults_ends_at_home, ("chain", False, True)),
    (laws.test_a_run_without_faults_ends_at_home, ("table", False, False)),
    (laws.test_a_low_switch_that_closes_in_work_is_a_fault, (0,)),
    (laws.test_a_low_switch_that_closes_in_work_is_a_fault, (2,)),
    (laws.test_one_disturbed_reading_stops_nothing_and_two_do, ()),
    (laws.test_a_stop_that_is_refused_is_repeated, ("MC_STOP",)),
    (laws.test_homing_that_takes_too_long_is_a_fault, (0,)),
    (laws.test_homing_leaves_a_high_switch_but_does_not_meet_it_again, ()),
    (laws.test_an_axis_that_drops_out_in_mid_cut, ()),
    (laws.test_a_button_that_is_held_at_power_up_starts_nothing, ()),
    (laws.test_after_the_end_a_new_press_makes_the_part_again, ()),
    (laws.test_a_start_button_does_nothing_in_work_or_in_a_fault, ()),
    (laws.test_a_fault_stays_until_the_axis_reports_no_error, ()),
    (laws.test_an_axis_that_reports_an_error_before_the_start_is_told, ()),
    (laws.test_an_acknowledge_button_that_is_held_acknowledges_nothing, ()),
)  # fmt: skip


@pytest.mark.parametrize(
    ("law", "values"), LAWS, ids=[f"{law.__name__}{values}" for law, values in LAWS]
)
def test_a_law_of_every_dialect(
    law: Callable[..., None], values: tuple[object, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(laws, "plant", plant)
    law(*values)


@pytest.mark.parametrize(
    "law",
    [laws.test_whatever_fails_ends_in_a_shown_fault_and_a_new_press_begins_anew,
     laws.test_whatever_happens_the_laws_of_every_cycle_hold,
     laws.test_an_encoder_that_jitters_by_a_count_stops_nothing],
)  # fmt: skip
def test_a_law_at_any_time(law: Callable[..., None], monkeypatch: pytest.MonkeyPatch) -> None:
    """A plain program has no task that the system calls for faults, and no stop input."""
    monkeypatch.setattr(laws, "plant", plant)
    for kind in ("fault task", "stop button"):
        monkeypatch.setitem(laws.DEEDS, kind, (alarm(0), (2,)))
    law()


@pytest.mark.parametrize("index", [0, 1])
@pytest.mark.parametrize("cycle", range(0, 100, 10))
def test_an_axis_that_sticks_stops_the_torch_in_the_second_cycle_beyond_its_window(
    index: int, cycle: int
) -> None:
    """At ten moments of the cut; each axis by its own speed, and by what is left of its lag."""
    one = plant()
    one.press_start()
    while not one.tool_on:
        one.cycle()
    for _ in range(cycle):
        one.cycle()
    axis, t = one.axes[index], one.triggers
    trail, before, beyond = 0.0, axis.position, 0
    freeze(index)(one)
    while one.tool_on:
        now = axis.position
        one.cycle()
        trail = max(trail * t.following_lag_s / (t.following_lag_s + t.cycle_s),
                    min(8.0, abs(now - before) / t.cycle_s) * t.following_lag_s)  # fmt: skip
        beyond += abs(one.frozen[axis.name] - now) > t.arrival_window + trail
        before = now
    assert (beyond, one.value("faultNumber")) == (2, 7)
    # Two cycles at 8 mm/s, and the jitter of the last count.
    window = t.arrival_window + 8 * t.following_lag_s
    assert abs(axis.actual - axis.position) <= window + 2 * 8 * t.cycle_s + t.count


@pytest.mark.parametrize("style", STYLES)
def test_an_operation_that_does_not_arrive_is_a_fault(style: str) -> None:
    """Both axes stand, a count or two beyond the window of arrival, or one waits for ever."""
    one = plant(style)
    one.press_start()
    while not one.tool_on or one.still:
        one.cycle()
    since, triggers = one.clock_s, one.triggers
    for axis in one.axes:
        axis.advance = lambda seconds: None  # type: ignore[method-assign]
    one.run_until(FAULT)
    longest = 10 / 8 + 8 / triggers.acceleration
    assert one.clock_s - since <= longest + triggers.max_late_s + 0.3
    assert one.value("faultNumber") == 4
    assert not one.tool_on


def test_the_window_goes_by_the_speed_of_each_axis() -> None:
    """Y rests on the line to (6, 2): what X may trail at 8 mm/s, Y may not."""
    for index, state in ((0, WORK), (1, FAULT)):
        one = plant()
        one.press_start()
        while not one.tool_on or one.still:
            one.cycle()
        one.wait(0.2)
        displace(index, 0.4)(one)
        one.wait(0.1)
        assert one.value("workState") == state
        assert one.value("faultNumber") == (7 if state == FAULT else 0)


def test_a_low_switch_that_sticks_is_a_fault_of_homing() -> None:
    one = plant()
    close(0)(one)
    one.press_start()
    one.run_until(FAULT)
    assert one.value("faultNumber") == 1
    assert WORK not in one.states
    mend(one)
    one.press_acknowledge()
    one.press_start()
    one.run_until(DONE)


def test_an_axis_that_runs_from_its_switch_ends_at_the_other_one() -> None:
    one = plant()
    real = one.axes[1].run
    one.axes[1].run = lambda v, a: real(-v, a)  # type: ignore[method-assign]
    one.press_start()
    one.run_until(FAULT, 10.0)
    assert one.value("faultNumber") == 1
    one.wait(STOPPED_S)
    assert one.still


def test_homing_that_ends_off_its_switch_is_a_fault() -> None:
    """A drive that homes somewhere else: no part is made from a wrong zero."""
    one = plant()
    one.at_low = lambda axis: axis.place <= 2.0  # type: ignore[method-assign]
    one.press_start()
    one.run_until(FAULT, 2.0)
    assert one.value("faultNumber") == 3
    assert WORK not in one.states


@pytest.mark.parametrize("refused", ["MC_MOVEABSOLUTE", "MC_HOME"])
def test_a_command_that_is_refused_is_a_fault(refused: str) -> None:
    one = plant()
    real = one.command
    one.command = lambda name, values, line: 1 if name == refused else real(name, values, line)  # type: ignore[method-assign]
    one.press_start()
    one.run_until(FAULT, 30.0)
    assert one.value("faultNumber") == 5
    assert not one.tool_on


def test_an_axis_that_is_held_by_a_stop_is_let_go_by_the_acknowledgement() -> None:
    one = plant()
    one.press_start()
    one.run_until(WORK)
    close(3)(one)
    one.wait(STOPPED_S)
    assert all(axis.held_by is not None for axis in one.axes)
    mend(one)
    one.press_acknowledge()
    one.wait(0.1)
    assert all(axis.held_by is None for axis in one.axes)


def test_a_homing_that_was_stopped_begins_anew() -> None:
    """Execute was on when it was stopped; an edge has to start it again."""
    one = plant()
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


def test_drives_are_off_until_the_first_start() -> None:
    one = plant()
    one.wait(0.5)
    assert not any(axis.enabled for axis in one.axes)
    one.press_start()
    one.wait(0.1)
    assert all(axis.enabled for axis in one.axes)


RUNTIME_MUTANTS = [
    # What stands in the runtime, which word of it is changed, and into what.
    ("IF limitXLow OR limitXHigh OR limitYLow OR limitYHigh THEN",
     "limitXLow OR limitXHigh OR limitYLow OR limitYHigh", "FALSE"),
    ("strays := beyond AND wasBeyond;", " AND wasBeyond", ""),
    ("strays := beyond AND wasBeyond;", "beyond AND wasBeyond", "FALSE"),
    ("trail := speed * FOLLOWING_LAG_S;", "speed", "targetSpeed"),
    ("ELSIF elapsed > allowed THEN", "elapsed > allowed", "FALSE"),
    ("IF elapsed > MAX_HOMING_S THEN", "elapsed > MAX_HOMING_S", "FALSE"),
    ("startButton AND NOT startBefore", " AND NOT startBefore", ""),
    ("startBefore : BOOL := TRUE", "TRUE", "FALSE"),
    ("acknowledgeButton AND NOT acknowledgeBefore", " AND NOT acknowledgeBefore", ""),
    ("    IF commandFault THEN\n        fault := INT#5;", "commandFault", "FALSE"),
    ("stopAll(holds := workState = INT#4);", "workState = INT#4", "FALSE"),
    ("Execute := holds AND NOT stopX.Error", " AND NOT stopX.Error", ""),
    ("IF watchX.faulty OR watchY.faulty THEN", "watchX.faulty OR watchY.faulty", "FALSE"),
    ("IF (workState <> INT#2) OR commandFault THEN", "(workState <> INT#2) OR commandFault",
     "FALSE"),
    ("ELSIF NOT leavesHigh OR (phase > INT#1) THEN", "NOT leavesHigh OR (phase > INT#1)", "FALSE"),
    ("leavesHigh := limitHigh;", "limitHigh", "FALSE"),
    ("IF limitLow THEN\n                fault := INT#1;", "limitLow", "FALSE"),
    ("IF limitLow THEN\n                    seeks", "limitLow", "TRUE"),
    ("IF NOT begins\n        AND (seek", "NOT begins", "TRUE"),
    ("IF fit AND NOT begins THEN", " AND NOT begins", ""),
    ("operation := DINT#0;\n                operationWaits", "DINT#0", "operation"),
    ("triggerActive[row] := FALSE;", "FALSE", "triggerActive[row]"),
    ("Velocity := targetSpeed * shareX", "shareX", "shareY"),
    ("runX(Axis := AxisX, Execute := FALSE);", "FALSE", "runsX"),
    ("resets := acknowledgePressed;", "acknowledgePressed", "FALSE"),
    ("ELSIF NOT begins THEN", "NOT begins", "TRUE"),
    ("0, 3: (*", "0, 3", "0"),
    ("workFault := workState = INT#4;", "INT#4", "INT#5"),
]  # fmt: skip
OF_MUTANTS: tuple[tuple[Callable[..., None], tuple[object, ...]], ...] = (
    *LAWS,
    (test_homing_that_ends_off_its_switch_is_a_fault, ()),
    (test_an_axis_that_sticks_stops_the_torch_in_the_second_cycle_beyond_its_window, (0, 40)),
    (test_an_operation_that_does_not_arrive_is_a_fault, ("chain",)),
    (test_the_window_goes_by_the_speed_of_each_axis, ()),
    (test_a_low_switch_that_sticks_is_a_fault_of_homing, ()),
    (test_a_command_that_is_refused_is_a_fault, ("MC_MOVEABSOLUTE",)),
    (laws.test_a_stop_that_is_refused_is_repeated, ("MC_STOP",)),
    (test_a_homing_that_was_stopped_begins_anew, ()),
    (test_an_axis_that_is_held_by_a_stop_is_let_go_by_the_acknowledgement, ()),
    (laws.test_an_encoder_that_jitters_by_a_count_stops_nothing, ()),
)


#: Every third of them; the exhaustive tests try the others too.
TRIED = [pytest.param(*row, marks=[pytest.mark.exhaustive] * (k % 3 > 0)) for k, row in
         enumerate(RUNTIME_MUTANTS)]  # fmt: skip


@pytest.mark.parametrize(("where", "find", "put"), TRIED)
def test_a_changed_runtime_breaks_a_law(
    where: str, find: str, put: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = small_machine()
    text = simotion.emit(small_job(), machine, "chain")
    mutant = text.replace(where, where.replace(find, put, 1), 1)
    assert mutant != text
    units = units_of(mutant, machine)
    monkeypatch.setattr("tests.unit.tables.test_plcopen.loaded", lambda *_: units)
    monkeypatch.setattr(laws, "plant", plant)
    for law, values in OF_MUTANTS:
        try:
            law(*values)
        except AssertionError:
            return
    pytest.fail("no law is broken")


def test_the_remaining_faults_are_told_with_their_numbers() -> None:
    for deed, number in ((disable(1), 2), (alarm(0), 2), (close(2), 1)):
        one = plant("table")
        one.press_start()
        one.run_until(WORK)
        one.wait(0.2)
        deed(one)
        one.cycle()
        one.cycle()
        assert (one.value("workState"), one.value("faultNumber")) == (FAULT, number)
