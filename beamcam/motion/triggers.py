"""The motion of a table without a CNC: a chain of straight operations, each started by arrival.

    pass -> way to its start -> tool on -> points at the controller's cycle -> tool off -> home

Where the table lifts its torch, X and Y go at clearance while the tool is off:

    home        --.                                   .--
    clearance     '--way--.                   .--way--'
    pierce height         '-on-.              |
    cut height                 '---points--off'

Every operation runs from rest to rest, so that a corner is a corner and both axes arrive together.
From that the run time follows, for `plan` and `simulate` alike.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import asin, ceil, copysign, dist, trunc

from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point, cross
from beamcam.machine.machine import Machine
from beamcam.machine.tables import Triggers
from beamcam.model.cell_motion import move_seconds
from beamcam.model.plan import ContourOp, SheetPlan, WorkTime
from beamcam.model.program import ArcTravel, LiftTorch, SwitchTool, Travel, TriggerOp, TriggerTable
from beamcam.motion.sheet_times import by_operation

#: Arcs that a path object runs are cut in pieces of at most this, so that no end is its start.
MAX_ROUND_DEG = 120.0
HOME: Point = (0.0, 0.0)
SECONDS_PER_MINUTE = 60.0
TRUNCATION_SLACK = 1e-6  #: as in `rounding`: 0.29 is a hair less than 0.29 in binary


def trigger_table(plan: SheetPlan, machine: Machine, job: str) -> TriggerTable:
    """The operations that carry out a plan, from the corner of the work area and back to it."""
    texts: list[str] = []
    operations = tuple(_operations(plan, machine, texts))
    return TriggerTable(job, operations, tuple(texts), plan.thickness)


def _operations(plan: SheetPlan, machine: Machine, texts: list[str]) -> Iterator[TriggerOp]:
    triggers = machine.needed(machine.triggers, "trigger program")
    here, z = HOME, triggers.z
    clearance, home = z.clearance if z else 0.0, triggers.home_over(plan.thickness)
    height = home

    def lift(to: float, source: Source | None = None) -> Iterator[LiftTorch]:
        """The torch to a height, where the table lifts it and it is elsewhere."""
        nonlocal height
        if z is not None and to != height:
            height = to
            yield LiftTorch(to, z.speed_mm_s, source)

    for number, op in enumerate(plan.operations, 1):
        for one in op.passes:
            way = _Way(op, machine)
            curves = (*one.lead_in, *one.curves, *one.lead_out)
            start = way.grid(curves[0].start)
            yield from lift(clearance, op.source)
            if start != here:
                yield Travel(*start, triggers.traverse_mm_s, op.source)
            yield from lift(op.row.pierce_height, op.source)
            assert op.row.process != "spot", "a table without G-code has no words for spots"
            yield SwitchTool(op.row.process, True, op.row.pierce_s, op.source)
            yield from lift(op.row.cut_height, op.source)
            moves = list(way.along(start, curves))
            yield from moves
            yield SwitchTool(op.row.process, False, 0.0, op.source)
            yield from lift(clearance, op.source)
            if way.slowest < way.speed_mm_s * (1 - 1e-9):
                texts.append(f"contour {number}: arcs at {way.slowest:.3f} mm/s for the cycle time")
            here = (moves[-1].x, moves[-1].y) if moves else start
    if here != HOME:
        yield Travel(*HOME, triggers.traverse_mm_s)
    yield from lift(home)


class _Way:
    """Follows the curves of one contour in the numbers that will be written."""

    def __init__(self, op: ContourOp, machine: Machine) -> None:
        torch = machine.needed(machine.torch, "torch")
        triggers = machine.needed(machine.triggers, "trigger program")
        self.speed_mm_s = op.row.feed_mm_min / SECONDS_PER_MINUTE
        self.slowest = self.speed_mm_s
        self.tolerance = torch.tolerance - triggers.in_position / 2
        self.source: Source | None = op.source
        self.decimals = machine.format.length_decimals
        self.triggers = triggers

    def grid(self, point: Point) -> Point:
        """The position sent to the controller, truncated after its last decimal."""
        counts = 10**self.decimals
        x, y = (trunc(v * counts + copysign(TRUNCATION_SLACK, v)) / counts + 0.0 for v in point)
        return x, y

    def along(self, start: Point, curves: Sequence[Curve]) -> Iterator[Travel | ArcTravel]:
        """The operations along a chain, from the written place `start`."""
        here = start
        for curve in curves:
            ops: Iterable[Travel | ArcTravel]
            if isinstance(curve, Line):
                ops = [Travel(*self.grid(curve.end), self.speed_mm_s, self.source)]
            elif isinstance(curve, Arc) and self.triggers.path_objects:
                count = max(1, ceil(abs(curve.sweep_deg) / MAX_ROUND_DEG - 1e-9))
                ends = [self.grid(curve.point(k / count)) for k in range(1, count + 1)]
                middles = [self.grid(curve.point((k + 0.5) / count)) for k in range(count)]
                pairs = zip(ends, middles, strict=True)
                ops = [ArcTravel(*a, *m, self.speed_mm_s, self.source) for a, m in pairs]
            else:
                # Chords by the chord rule and the cycle rule; the end is met exactly.
                from beamcam.motion.densify import DensifyRules, densify

                rules = DensifyRules(
                    self.tolerance, 10**self.decimals, self.speed_mm_s, self.triggers.cycle_s,
                    self.triggers.cycles_per_chord,
                )  # fmt: skip
                path = densify((curve,), rules)
                self.slowest = min(self.slowest, float(path.speeds_mm_s.min(initial=self.slowest)))
                points = path.points.tolist()[1:]
                ops = [
                    Travel(x + 0.0, y + 0.0, speed, self.source)
                    for (x, y), speed in zip(points, path.speeds_mm_s.tolist(), strict=True)
                ]
            for op in ops:
                if (op.x, op.y) != here:
                    yield op
                    here = op.x, op.y


HeadPlace = tuple[float, float, float]  #: X, Y, and the height over the sheet

CYCLE_SLACK = 1e-9


def trigger_time(plan: SheetPlan, table: TriggerTable, machine: Machine) -> WorkTime:
    """Run time of a chain of triggers, from the corner of the work area and back to it.

    Each operation runs from rest to rest; the next begins in the cycle behind the one that sees
    its arrival. Homing is not included, as its start position is unknown.
    """
    triggers = machine.needed(machine.triggers, "trigger program")
    here, passes = (0.0, 0.0, triggers.home_over(table.thickness)), [0.0]
    for op in table.operations:
        passes[-1] += operation_seconds(op, here, triggers)
        here = place_behind(op, here)
        if isinstance(op, SwitchTool) and not op.on:
            passes.append(0.0)
    return by_operation(plan, iter(passes))


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
    if isinstance(op, SwitchTool):
        seconds = op.wait_s
    else:
        way = dist(here, place_behind(op, here))
        if isinstance(op, ArcTravel):
            way = length_through(here[:2], (op.middle_x, op.middle_y), (op.x, op.y))
        seconds = move_seconds(way, op.speed_mm_s, triggers.acceleration)
    return (ceil(seconds / triggers.cycle_s - CYCLE_SLACK) + 1) * triggers.cycle_s
