"""Start, stop and acknowledge: what a press of each does, and what a held one does not."""

from .deeds import alarm, alarm_that_stays, press_stop
from .plant import DONE, FAULT, HOMING, STOPPED_S, WAITS, WORK, cutting, each_kind, plant


@each_kind
def test_the_stop_button_stops_and_a_start_waits_for_its_release(kind: str) -> None:
    one = plant(kind=kind)
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


@each_kind
def test_a_button_that_is_held_at_power_up_starts_nothing(kind: str) -> None:
    one = plant(kind=kind)
    one.start = True
    one.wait(0.5)
    assert one.value("workState") == WAITS
    one.press_start()
    assert one.value("workState") == HOMING


@each_kind
def test_after_the_end_a_new_press_makes_the_part_again(kind: str) -> None:
    one = plant(kind=kind)
    one.press_start()
    one.run_until(DONE)
    first = one.places()
    one.wait(1.0)
    assert one.value("workState") == DONE, "the button is still held"
    one.points.clear()
    one.press_start()
    one.run_until(HOMING)
    one.run_until(DONE)
    assert set(one.places()) == set(first)


@each_kind
def test_a_start_button_does_nothing_in_work_or_in_a_fault(kind: str) -> None:
    one = plant(kind=kind)
    one.press_start()
    one.run_until(WORK)
    one.press_start()
    assert one.value("workState") == WORK
    alarm(0)(one)
    one.run_until(FAULT, 1.0)
    one.press_start()
    one.wait(0.5)
    assert one.value("workState") == FAULT


@each_kind
def test_a_fault_stays_until_the_axis_reports_no_error(kind: str) -> None:
    one = plant(kind=kind)
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


@each_kind
def test_an_axis_that_reports_an_error_before_the_start_is_told(kind: str) -> None:
    one = plant(kind=kind)
    one.cycle()
    alarm(1)(one)
    one.cycle()
    assert one.value("faultNumber") == 2
    one.press_start()
    assert one.value("workState") == FAULT


@each_kind
def test_an_acknowledge_button_that_is_held_acknowledges_nothing(kind: str) -> None:
    one = plant(kind=kind)
    one.acknowledge = True
    one.press_start()
    one.run_until(WORK)
    alarm(0)(one)
    one.wait(0.5)
    assert one.value("workState") == FAULT
    one.press_acknowledge()
    one.cycle()
    assert one.value("workState") == WAITS
