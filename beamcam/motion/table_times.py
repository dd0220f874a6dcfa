"""Run times of tables without G-code: chains of triggers, and step tables."""

from collections.abc import Iterator
from math import asin, ceil, dist

from beamcam.geometry.plane import Point, cross
from beamcam.geometry.ramps import move_seconds
from beamcam.machine.machine import Machine
from beamcam.machine.tables import Triggers
from beamcam.model.plan import SheetPlan, WorkTime
from beamcam.model.program import ArcTravel, LiftTorch, SwitchTool, TriggerOp, TriggerTable
from beamcam.motion.sheet_times import by_operation
from beamcam.motion.step_events import MICROSECONDS
from beamcam.motion.steps import plan_way, ways

HeadPlace = tuple[float, float, float]  #: X, Y, and the height over the sheet

CYCLE_SLACK = 1e-9


def trigger_time(plan: SheetPlan, table: TriggerTable, machine: Machine) -> WorkTime:
    """Run time of a chain of triggers, from the corner of the work area and back to it.

    Each operation runs from rest to rest; the next begins in the cycle behind the one that sees
    its arrival. Homing is not included, as its start position is unknown.
    """
    return by_operation(
        plan, _table_passes(table, machine.needed(machine.triggers, "trigger program"))
    )


def _table_passes(table: TriggerTable, triggers: Triggers) -> Iterator[float]:
    """Seconds of each pass with the traverse to it, and of the return home."""
    here, seconds = (0.0, 0.0, triggers.home_over(table.thickness)), 0.0
    for op in table.operations:
        seconds += operation_seconds(op, here, triggers)
        here = place_behind(op, here)
        if isinstance(op, SwitchTool) and not op.on:
            yield seconds
            seconds = 0.0
    yield seconds


def length_through(start: Point, middle: Point, end: Point) -> float:
    """Length of the arc through three points, neither half of it above half a circle."""
    a, b, c = dist(start, middle), dist(middle, end), dist(start, end)
    to_middle = middle[0] - start[0], middle[1] - start[1]
    twice_area = abs(cross(to_middle, (end[0] - start[0], end[1] - start[1])))
    if twice_area <= 1e-12 * c * c:
        return a + b
    radius = a * b * c / (2 * twice_area)
    return 2 * radius * sum(asin(min(1.0, chord / (2 * radius))) for chord in (a, b))


def place_behind(op: TriggerOp, here: HeadPlace) -> HeadPlace:
    """Where an operation that starts `here` ends."""
    if isinstance(op, LiftTorch):
        return *here[:2], op.height
    return here if isinstance(op, SwitchTool) else (op.x, op.y, here[2])


def operation_seconds(op: TriggerOp, here: HeadPlace, triggers: Triggers) -> float:
    """Seconds from an operation that starts `here` to the start of the next one."""
    cycles = ceil(_seconds(op, here, triggers) / triggers.cycle_s - CYCLE_SLACK) + 1
    return cycles * triggers.cycle_s


def _seconds(op: TriggerOp, here: HeadPlace, triggers: Triggers) -> float:
    if isinstance(op, SwitchTool):
        return op.wait_s
    way = dist(here, place_behind(op, here))
    if isinstance(op, ArcTravel):
        way = length_through(here[:2], (op.middle_x, op.middle_y), (op.x, op.y))
    return move_seconds(way, op.speed_mm_s, triggers.acceleration)


def step_time(plan: SheetPlan, machine: Machine) -> WorkTime:
    """Run time of a step table: until its last step, and the standstill after it.

    Each way is planned by the look-ahead, from rest to rest, as for the rows themselves.
    """
    return by_operation(plan, _way_passes(plan, machine))


def _way_passes(plan: SheetPlan, machine: Machine) -> Iterator[float]:
    """Seconds of each pass with the way to it, and of the return home."""
    stepper = machine.needed(machine.stepper, "stepping motors")
    rest_us = int(2 * MICROSECONDS / stepper.max_hz) + 1
    microseconds = 0
    for way in ways(plan, machine):
        waits = round(way.wait_s * MICROSECONDS) if way.laser else 0
        moves = ceil(plan_way(way, stepper).duration_s * MICROSECONDS)
        microseconds += waits + moves + 2 * rest_us
        if way.laser:
            yield microseconds / MICROSECONDS
            microseconds = 0
    yield microseconds / MICROSECONDS
