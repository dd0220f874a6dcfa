"""Toolpaths of a stepper table: points with a speed, laser on or off, from corner to corner."""

from collections.abc import Iterator
from itertools import pairwise
from math import dist, floor, hypot

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Floats
from beamcam.machine.machine import Machine
from beamcam.model.plan import SheetPlan
from beamcam.model.steps import VelocityRow
from beamcam.motion.densify import DensifyRules, densify

HOME = (0.0, 0.0)
SAME_POINT = 1e-9  #: mm; there is no way to a place that is no farther
SECONDS_PER_MINUTE = 60.0


class Way(Struct, frozen=True):
    """Points that follow one another and are passed at one speed."""

    points: Floats
    speed_mm_s: float
    laser: bool
    wait_s: float


def ways(plan: SheetPlan, machine: Machine) -> list[Way]:
    """Traverses and contours in order; the first begins and the last ends in the corner."""
    torch = machine.needed(machine.torch, "stepping motors")
    stepper = machine.needed(machine.stepper, "stepping motors")
    rules = DensifyRules(torch.tolerance / 2)
    found: list[Way] = []
    here = HOME
    for op in plan.operations:
        speed = op.row.feed_mm_min / SECONDS_PER_MINUTE
        for one in op.passes:
            path = densify((*one.lead_in, *one.curves, *one.lead_out), rules)
            start = (float(path.points[0, 0]), float(path.points[0, 1]))
            if dist(start, here) > SAME_POINT:
                found.append(Way(np.array([here, start]), stepper.traverse_mm_s, False, 0.0))
            found.append(Way(path.points, speed, True, op.row.pierce_s))
            here = (float(path.points[-1, 0]), float(path.points[-1, 1]))
    if dist(here, HOME) > SAME_POINT:
        found.append(Way(np.array([here, HOME]), stepper.traverse_mm_s, False, 0.0))
    return found


def stretches(job: list[Way], step: float, max_mm_s: float) -> Iterator[VelocityRow]:
    """A row for each stretch; the steps of all rows add up to the way from corner to corner.

    `max_mm_s` is what an axis can do; a stretch that asks for more is slower.
    """
    count = [0, 0]
    for way in job:
        for (x0, y0), (x1, y1) in pairwise(way.points.tolist()):
            dx, dy = x1 - x0, y1 - y0
            length = hypot(dx, dy)
            speed = min(way.speed_mm_s, max_mm_s * length / max(abs(dx), abs(dy)))
            vx, vy = speed * dx / length, speed * dy / length
            ends = [floor(x1 / step + 0.5), floor(y1 / step + 0.5)]
            yield VelocityRow(
                x1, y1, vx, vy, way.laser, ends[0] - count[0], ends[1] - count[1],
                abs(vx) / step, abs(vy) / step,
            )  # fmt: skip
            count = ends
