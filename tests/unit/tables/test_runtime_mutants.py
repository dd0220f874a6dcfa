"""The runtime of both dialects with a line changed: each breaks a law of the other tests."""

import re
from collections.abc import Callable
from functools import partial
from itertools import product

import pytest

from beamcam.emitters import simotion

from . import plant as simulated
from . import test_buttons as buttons
from . import test_faults as laws
from . import test_homing as homing
from . import test_watch as watch
from .deeds import close, freeze, release
from .plant import small_job, small_machine, units_of

Law = Callable[..., None]
#: With what they are called besides the kind of the table.
LAWS: tuple[Law, ...] = (
    partial(laws.test_a_run_without_faults_ends_at_home, style="chain", late=True),
    partial(laws.test_a_low_switch_that_closes_in_work_is_a_fault, index=0),
    partial(watch.test_an_operation_that_is_slow_is_a_fault, style="chain"),
    partial(watch.test_set_positions_that_stop_short_are_a_fault, style="chain"),
    watch.test_a_move_that_does_not_begin_is_a_fault_after_two_cycles_more,
    watch.test_the_window_goes_by_the_speed_of_each_axis,
    partial(watch.test_axes_that_trail_by_the_lag_stop_nothing, style="chain"),
    buttons.test_the_stop_button_stops_and_a_start_waits_for_its_release,
    homing.test_a_low_switch_that_sticks_is_a_fault_of_homing,
    homing.test_an_axis_that_stands_at_its_low_switch_leaves_it_first,
    partial(homing.test_both_switches_of_an_axis_at_once_are_a_fault, index=0),
    homing.test_a_slow_approach_that_does_not_find_the_switch_again_is_a_fault,
    homing.test_a_high_switch_that_was_free_is_a_fault_in_the_same_cycle,
    homing.test_a_low_switch_that_is_actuated_again_while_backing_off_is_a_fault,
    homing.test_a_zero_does_not_blind_the_watch,
    watch.test_one_disturbed_reading_stops_nothing_and_two_do,
    partial(homing.test_homing_that_takes_too_long_is_a_fault, index=0),
    homing.test_homing_leaves_a_high_switch_but_does_not_meet_it_again,
    homing.test_an_axis_that_runs_from_its_switch_is_a_fault,
    homing.test_a_homing_that_was_stopped_begins_anew,
    laws.test_a_command_that_is_refused_is_a_fault,
    laws.test_a_stop_that_is_refused_is_repeated,
    buttons.test_a_button_that_is_held_at_power_up_starts_nothing,
    buttons.test_after_the_end_a_new_press_makes_the_part_again,
    buttons.test_a_start_button_does_nothing_in_work_or_in_a_fault,
    buttons.test_a_fault_stays_until_the_axis_reports_no_error,
    buttons.test_an_axis_that_reports_an_error_before_the_start_is_told,
    buttons.test_an_acknowledge_button_that_is_held_acknowledges_nothing,
    laws.test_an_axis_that_drops_out_in_mid_cut,
    # Those that take long.
    *(
        partial(homing.test_a_low_switch_that_lies_for_some_cycles_makes_no_wrong_zero,
                style="chain", index=0, cycles=cycles, what=what)
        for what, cycles in ((close, 1), (close, 5), (release, 5))
    ),
    partial(homing.test_what_fails_for_good_ends_in_its_fault, deed=freeze(0), numbers={7}),
)  # fmt: skip

NEVER = "FALSE"
MUTANTS = [
    # What stands in the runtime, in lines of any indentation; which word of it, and into what.
    ("IF limitXLow OR limitXHigh OR limitYLow", "limitXLow OR limitXHigh OR limitYLow", NEVER),
    ("ELSIF NOT (watchX.fit AND watchY.fit) THEN", "AND", "OR"),
    ("ELSIF (elapsed > allowed) OR", "elapsed > allowed", NEVER),
    ("(moves AND (stands > INT#1))", "moves AND (stands > INT#1)", NEVER),
    ("stands := INT#-2;", "-2", "0"),
    ("made := made + SQRT(", "made + ", "LREAL#1000.0 + "),
    ("IF speed > fastest THEN", "speed > fastest", NEVER),
    ("speed := progress / CYCLE_S;", "progress / CYCLE_S", "fastest"),
    ("(watchX.fit AND watchX.strays)", "watchX.strays", NEVER),
    ("IF stopButton THEN", "stopButton", NEVER),
    ("AND NOT stopButton THEN", "AND NOT stopButton", ""),
    ("OR limitLow OR (phase > INT#4)", "OR limitLow ", ""),
    ("ELSIF ABS(axis.basicMotion.position - startedAt) > BACK_OFF THEN", "> BACK_OFF",
     "> LREAL#1000.0"),
    ("ELSIF met AND (axis.basicMotion.position < firstAt", "met", NEVER),
    ("leaveTo := firstAt + LREAL#2.0 * HOMING_WINDOW", "LREAL#2.0", "LREAL#-1.0"),
    ("IF NOT limitLow THEN\n                        fault := INT#8;", "NOT limitLow", NEVER),
    ("ELSIF ABS(seenAt - firstAt) > HOMING_WINDOW THEN", "> HOMING_WINDOW", "> LREAL#1000.0"),
    ("speed := HOMING_SLOW;", "HOMING_SLOW", "HOMING_VELOCITY"),
    ("strays := beyond AND wasBeyond;", "beyond AND wasBeyond", NEVER),
    ("strays := beyond AND wasBeyond;", " AND wasBeyond", ""),
    ("IF elapsed > MAX_HOMING_S THEN", "elapsed > MAX_HOMING_S", NEVER),
    ("startPressed := startButton AND NOT startBefore", " AND NOT startBefore", ""),
    ("startBefore : BOOL := TRUE", "TRUE", "FALSE"),
    ("startButton AND NOT startBefore", "NOT startBefore", "startBefore"),
    ("acknowledgeButton AND NOT acknowledgeBefore", " AND NOT acknowledgeBefore", ""),
    ("IF commandFault THEN\n            fault := INT#5;", "commandFault", NEVER),
    ("stopAll(first := TRUE);", "TRUE", "FALSE"),
    ("stoppedX := answer = DINT#0;", "answer = DINT#0", "TRUE"),
    ("IF acknowledged AND NOT watchX.faulty", " AND NOT watchX.faulty", ""),
    ("IF watchX.faulty OR watchY.faulty THEN", "watchX.faulty OR watchY.faulty", NEVER),
    ("IF (workState <> INT#2) OR commandFault", "(workState <> INT#2) OR commandFault", NEVER),
    ("ELSIF NOT leavesHigh OR limitLow", "NOT leavesHigh", NEVER),
    ("leavesHigh := limitHigh;", "limitHigh", "FALSE"),
    ("IF limitLow THEN\n                    fault := INT#8;\n                END_IF;", "limitLow",
     NEVER),
    ("ELSIF axis.basicMotion.position > startedAt", "> startedAt", "> LREAL#1000.0 + startedAt"),
    ("0, 3: (*", "0, 3", "0"),
    ("operation := DINT#0;\n                    operationWaits", "DINT#0", "operation"),
    ("triggerActive[k] := FALSE;", "FALSE", "triggerActive[k]"),
    ("phase := INT#0;\n            homed := FALSE;", "INT#0", "phase"),
    ("shareX,\n                positiveAccelType", "shareX", "shareY"),
    ("fit := (axis.control = ACTIVE) AND NOT faulty;", "(axis.control = ACTIVE) AND ", ""),
    ("commandPosition - targetX) <= IN_POSITION)", "IN_POSITION", "LREAL#100.0"),
    ("ELSIF NOT begins THEN", "NOT begins", "TRUE"),
    ("workFault := workState = INT#4;", "INT#4", "INT#5"),
    ("faultNumber := INT#0;\n                    workState := INT#0;", "INT#0", "faultNumber"),
    # Of the blocks alone.
    ("ELSIF ABS(position - startedAt) > BACK_OFF THEN", "> BACK_OFF", "> LREAL#1000.0"),
    ("ELSIF met AND (position < firstAt", "met", NEVER),
    ("ELSIF position > startedAt", "> startedAt", "> LREAL#1000.0 + startedAt"),
    ("stopAll(holds := workState = INT#4);", "workState = INT#4", NEVER),
    ("Execute := holds AND NOT stopX.Error", " AND NOT stopX.Error", ""),
    ("IF (workState <> INT#2) OR commandFault THEN", "(workState <> INT#2) OR commandFault", NEVER),
    ("sets := TRUE; phase := INT#6;", "sets := TRUE;", ""),
    ("runs := FALSE; halts := FALSE; sets := FALSE; END_IF;", "runs := FALSE;", ""),
    ("IF (runs AND (run.Error", "runs AND", ""),
    ("operation := DINT#0; operationWaits", "DINT#0", "operation"),
    ("triggerActive[row] := FALSE;", "FALSE", "triggerActive[row]"),
    ("Velocity := targetSpeed * shareX", "shareX", "shareY"),
    ("runX(Axis := AxisX, Execute := FALSE);", "FALSE", "runsX"),
    ("resets := acknowledgePressed;", "acknowledgePressed", NEVER),
]  # fmt: skip


KINDS = ("axes", "blocks")
TEXTS = {kind: simotion.emit(small_job(kind), small_machine(kind), "chain") for kind in KINDS}


def place_of(where: str, kind: str) -> re.Match[str] | None:
    """Where the lines of a mutant stand in a program, whatever their indentation."""
    return re.search(r"\s+".join(map(re.escape, where.split())), TEXTS[kind])


#: Mutants that change nothing: a drive that drops out is an error of MC_Power by itself.
EQUIVALENT = {("blocks", "ELSIF NOT (watchX.fit AND watchY.fit) THEN")}
#: Every ninth of them; the exhaustive tests try the others too.
TRIED = [
    pytest.param(kind, *row, marks=[pytest.mark.exhaustive] * (k % 9 > 0))
    for k, (kind, row) in enumerate(product(KINDS, MUTANTS))
    if place_of(row[0], kind) and (kind, row[0]) not in EQUIVALENT
]


def test_every_mutant_is_one_of_a_dialect() -> None:
    assert [row for row in MUTANTS if not any(place_of(row[0], kind) for kind in KINDS)] == []


@pytest.mark.parametrize(("kind", "where", "find", "put"), TRIED)
def test_a_changed_runtime_breaks_a_law(
    kind: str, where: str, find: str, put: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    text, place = TEXTS[kind], place_of(where, kind)
    assert place is not None
    changed = place[0].replace(find, put, 1)
    assert changed != place[0]
    units = units_of(text[: place.start()] + changed + text[place.end() :], small_machine(kind))
    monkeypatch.setattr(simulated, "loaded", lambda *_: units)
    for law in LAWS:
        try:
            law(kind=kind)
        except AssertionError:
            return
    pytest.fail("no law is broken")


@pytest.mark.exhaustive  # the laws are tests by themselves
@pytest.mark.parametrize("kind", KINDS)
def test_the_runtime_as_it_is_breaks_none(kind: str) -> None:
    for law in LAWS:
        law(kind=kind)
