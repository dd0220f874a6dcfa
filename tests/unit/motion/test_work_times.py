"""Times of cutting tables: from the look-ahead over the program, whatever the controller."""

from collections.abc import Sequence
from math import cbrt, ceil, dist, hypot, pi

import numpy as np
import pytest
from msgspec.structs import replace

from beamcam.emitters import simotion
from beamcam.geometry.curves import Arc, Line
from beamcam.machine import Machine, load
from beamcam.machine.machine import PathLimits, path_limits
from beamcam.model.cell_motion import move_seconds
from beamcam.model.part import Part
from beamcam.model.plan import WorkTime
from beamcam.model.program import ArcFeed, EllipseFeed, Feed, Movement, ParabolaFeed
from beamcam.motion.densify import DensifyRules, densify
from beamcam.motion.lookahead import LookAheadRules, plan_speeds
from beamcam.motion.sheet import sheet_program
from beamcam.motion.sheet_times import (
    SECONDS_PER_MINUTE,
    curve_of,
    program_time,
    section_seconds,
    segments_of,
    speeds_along,
)
from beamcam.motion.steps import step_table, step_time
from beamcam.motion.triggers import length_through, trigger_time
from beamcam.motion.velocity_profile import AxisLimits
from beamcam.pipeline import post
from beamcam.planning.sheet import plan_sheet
from tests.unit.sheets.parts import NESTED, box, circle, contour, drawing, lines, table
from tests.unit.tables.plant import Plant, units_of
from tests.unit.tables.shop import NAMES, plan, table_machine, triggers

GCODE = ("plate-linuxcnc", "plate-codesys", "laser-grbl")


def time_of(part: Part, machine: Machine) -> WorkTime:
    found = plan_sheet((part,), machine)
    return program_time(found, sheet_program(found, machine, "J"), machine)


def plain(name: str, **values: object) -> Machine:
    material = "wood" if name == "laser-grbl" else "mild steel"
    return table(name, material=material, kerf_by="none", lead="none", place="drawn", **values)


@pytest.mark.parametrize("name", GCODE)
def test_a_line_takes_its_move_its_piercing_and_the_ways(name: str) -> None:
    machine = plain(name)
    limits, torch = path_limits(machine), machine.torch
    assert limits is not None
    assert torch is not None
    time = time_of(drawing(contour(lines((30, 40), (330, 40), closed=False))), machine)
    rows = [r for r in torch.rows if r.process == "cut" and r.material == torch.material]
    row = next(r for r in rows if r.up_to >= 6)
    rapid, a, j = torch.traverse_mm_min / 60, limits.straight_mm_s2, limits.jerk_mm_s3
    there = move_seconds(50.0, min(rapid, 500.0, 400 / 0.8), a, j)
    cut = move_seconds(300.0, row.feed_mm_min / SECONDS_PER_MINUTE, a, j)
    assert time.operations == (pytest.approx(there + row.pierce_s + cut, rel=1e-2),)
    assert time.home_s == pytest.approx(move_seconds(hypot(330, 40), rapid, a, j), rel=1e-2)
    assert time.total_s == sum(time.operations) + time.home_s


@pytest.mark.parametrize("name", GCODE)
def test_no_sheet_takes_less_than_its_ways_at_full_speed(name: str) -> None:
    machine = plain(name)
    assert machine.torch is not None
    found = plan_sheet((NESTED,), machine)
    program = sheet_program(found, machine, "J")
    time = program_time(found, program, machine)
    unlimited = program_time(found, program, replace(machine, axes=()))
    assert len(time.operations) == len(found.operations) == 5
    for seconds, least, op in zip(
        time.operations, unlimited.operations, found.operations, strict=True
    ):
        way = sum(c.length for one in op.passes for c in one.curves)
        assert least >= way / (op.row.feed_mm_min / 60) * (1 - 1e-6) + op.row.pierce_s
        assert seconds > least
    assert time.total_s > unlimited.total_s


def seconds_along(
    start: tuple[float, float], moves: Sequence[Movement], feed_mm_s: float, limits: PathLimits
) -> float:
    """From rest to rest."""
    starts = [start, *((move.x, move.y) for move in moves)]
    table = segments_of(starts[:-1], moves, [feed_mm_s] * len(moves), limits)
    moving, speeds = speeds_along(table, np.zeros(len(table.places), int), limits)
    return float(section_seconds(moving, speeds).sum())


def test_a_contour_takes_as_long_as_the_look_ahead_over_its_points() -> None:
    """Arcs and lines as they are against chords that another function looks ahead over."""
    machine = plain("plate-linuxcnc")
    limits = path_limits(machine)
    assert limits is not None
    curves = (
        Line((20, 10), (40, 10)), Arc((40, 20), 10, -90, 90), Line((50, 20), (50, 40)),
        Arc((40, 40), 10, 0, 90), Line((40, 50), (20, 50)), Arc((20, 40), 10, 90, 90),
        Line((10, 40), (10, 20)), Arc((20, 20), 10, 180, 90),
    )  # fmt: skip
    moves = [
        ArcFeed(*c.end, c.centre[0] - c.start[0], c.centre[1] - c.start[1], False)
        if isinstance(c, Arc) else Feed(*c.end)
        for c in curves
    ]  # fmt: skip
    axis = AxisLimits(400.0, 2000.0)
    points = densify(curves, DensifyRules(0.0005)).points
    by_points = plan_speeds(points, 60.0, LookAheadRules((axis, axis), 0.01)).duration_s
    assert seconds_along((20.0, 10.0), moves, 60.0, limits) == pytest.approx(by_points, rel=0.01)


def test_corners_cost_time_and_a_controller_that_stops_there_more() -> None:
    machine = plain("plate-linuxcnc")
    zigzag = lines(*((10.0 * k, 20.0 + 20.0 * (k % 2)) for k in range(30)), closed=False)
    straight = lines((10, 20), (10 + sum(c.length for c in zigzag), 20), closed=False)
    stops = plain("plate-linuxcnc")
    assert stops.torch is not None
    stops = replace(stops, torch=replace(stops.torch, corner=0.0))
    times = [
        time_of(drawing(contour(curves)), m).operations[0]
        for curves, m in ((straight, machine), (zigzag, machine), (zigzag, stops))
    ]
    assert times == sorted(times)
    assert times[2] > times[0] + 0.2


def test_lines_in_pieces_take_as_long_as_one() -> None:
    limits = path_limits(plain("plate-codesys"))
    ends = [(x, 0.75 * x) for x in (0.0, 1.0, 1.5, 40.0, 41.0, 200.0)]
    assert limits is not None
    start, *others = ends
    one = seconds_along(start, [Feed(*ends[-1])], 35.0, limits)
    pieces = [Feed(*end) for end in others]
    assert seconds_along(start, pieces, 35.0, limits) == pytest.approx(one, rel=1e-6)
    twice = [move for piece in pieces for move in (piece, piece)]
    assert seconds_along(start, twice, 35.0, limits) == pytest.approx(one, rel=1e-6)
    assert seconds_along(start, [Feed(*start)], 35.0, limits) == 0.0


def test_curves_of_moves() -> None:
    starts = ((10.0, 0.0), (10.0, 0.0), (0.0, 0.0), (1.0, 1.0))
    moves = (
        ArcFeed(10.0, 0.0, -10.0, 0.0, True), ArcFeed(0.0, 10.0, -10.0, 0.0, False),
        ParabolaFeed(20.0, 0.0, 10.0, 5.0), Feed(4.0, 5.0),
    )  # fmt: skip
    table = segments_of(starts, moves, [1.0] * 4, None)
    parabola = curve_of(starts[2], ParabolaFeed(20.0, 0.0, 10.0, 5.0))
    assert table.lengths == pytest.approx([20 * pi, 5 * pi, parabola.length, 5.0])
    assert table.enters[:2].tolist() == [[0.0, -1.0], [0.0, 1.0]]
    assert table.leaves[[0, 1, 3]].tolist() == [[0.0, -1.0], [-1.0, 0.0], [0.6, 0.8]]
    assert parabola.point(0.5) == pytest.approx((10.0, 5.0))
    ellipse = curve_of((20.0, 0.0), EllipseFeed(0.0, 10.0, -20.0, 0.0, 0.0, 0.5, False))
    assert ellipse.end == pytest.approx((0.0, 10.0))
    assert ellipse.point(0.5) == pytest.approx((20 * 0.5**0.5, 10 * 0.5**0.5))


@pytest.mark.parametrize("name", NAMES)
def test_a_chain_of_triggers_takes_as_long_as_its_simulation(name: str) -> None:
    machine = table_machine()
    found = triggers(name, machine)
    plant = Plant(units_of(simotion.emit(found, machine), machine), machine)
    plant.press_start()
    switched = []
    while not plant.value("workDone"):
        before = plant.tool_on
        plant.cycle()
        if plant.tool_on != before:
            switched.append(plant.clock_s)
    time = trigger_time(plan(name, "table-simotion"), found, machine)
    # From the first start of the tool on; before is homing.
    here, ways_there = (0.0, 0.0), 0.0
    first = found.operations[0]
    assert machine.triggers is not None
    cycle = machine.triggers.cycle_s
    if hasattr(first, "x"):
        way = move_seconds(dist(here, (first.x, first.y)), 20.0, 100.0)
        ways_there = (ceil(way / cycle) + 1) * cycle
    simulated = plant.clock_s - switched[0]
    assert time.total_s - ways_there == pytest.approx(simulated, rel=0.01, abs=4 * cycle)
    assert length_through((10, 0), (0, 10), (-10, 0)) == pytest.approx(10 * pi)
    assert length_through((0, 0), (1, 1), (3, 3)) == pytest.approx(18**0.5)


@pytest.mark.parametrize("name", NAMES)
def test_a_step_table_takes_as_long_as_its_last_row_says(name: str) -> None:
    machine = load("laser-stepper")
    stepper = machine.stepper
    assert stepper is not None
    found = plan(name, "laser-stepper")
    table = step_table(found, machine, name)
    last = max(int(rows.time_us[-1]) for rows in table.rows() if len(rows.time_us))
    time = step_time(found, machine)
    # Behind the last step the axis still brakes over half of one.
    half_step_s = cbrt(6 * stepper.step / 2 / stepper.jerk)
    assert last / 1e6 <= time.total_s <= last / 1e6 + 1.1 * half_step_s


def test_every_machine_tells_the_time_of_what_it_posts() -> None:
    part = drawing(contour(box(20, 20, 40, 30)), contour(circle(40, 35, 8)), thickness=3.0)
    for name in (*GCODE, "table-simotion", "laser-stepper"):
        machine = load(name)
        time = post((part,), machine).time(machine)
        assert len(time.operations) == 2
        assert all(seconds > 0 for seconds in time.operations)
        assert 2 < time.total_s < 60
