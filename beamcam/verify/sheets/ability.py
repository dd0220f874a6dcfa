"""Expected feed of a move in programs that set the controller's accelerations.

The feed of the machine's row, or the greatest one that the axes can follow: on the smallest radius
of the curve the acceleration across is v^2 / r and the jerk v^3 / r^2.
"""

from math import inf

import numpy as np

from beamcam.controllers.moves import Moves
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Bezier, EllipseArc
from beamcam.machine.machine import Machine
from beamcam.machine.path_limits import PathLimits, path_limits

SECONDS_PER_MINUTE = 60.0
FLAT = 1e-12


def told_limits(machine: Machine) -> PathLimits | None:
    """The limits of a machine whose programs have to give accelerations; None of others."""
    told = any("{acceleration}" in word for word in machine.words.modal)
    return path_limits(machine) if told else None


def expected_feeds(moves: Moves, asked_mm_min: Floats, limits: PathLimits) -> Floats:
    """The feed in mm/min that each move should have, at most what is asked for it, (n,)."""
    asked = asked_mm_min / SECONDS_PER_MINUTE
    radius = np.where(moves.is_arc, moves.arcs[:, 2], inf)
    for k, curve in moves.curves.items():
        radius[k] = _min_radius(curve)
    turning = np.minimum(
        np.sqrt(limits.across_mm_s2 * radius), np.cbrt(limits.jerk_mm_s3 * radius**2)
    )
    straight = ~moves.is_arc
    straight[list(moves.curves)] = False
    greatest = np.where(
        straight, _straight_mm_s(moves, limits), np.minimum(limits.speed_mm_s, turning)
    )
    greatest[straight & (asked <= limits.speed_mm_s)] = inf
    return np.where(greatest < asked, greatest * SECONDS_PER_MINUTE, asked_mm_min)


def _straight_mm_s(moves: Moves, limits: PathLimits) -> Floats:
    """The maximum speed of both axes along each chord; inf where it has no length."""
    ways = np.abs(moves.end - moves.start)
    length = np.hypot(ways[:, 0], ways[:, 1])
    speeds = np.array([limits.speed_x_mm_s, limits.speed_y_mm_s])
    reached = np.divide(
        length[:, None] * speeds, ways, out=np.full(ways.shape, inf), where=ways > 0.0
    )
    found: Floats = reached.min(axis=1, initial=inf)
    return found


def _min_radius(curve: Bezier | EllipseArc) -> float:
    """The minimum radius of a parabola; of an ellipse that at the ends of its main axis."""
    if isinstance(curve, EllipseArc):
        return curve.major * curve.ratio**2
    # The curvature |f' x f''| / |f'|^3 is greatest where f' = 2 (a + t b) is shortest: at the
    # vertex, or at the end that is nearer to it.
    (x0, y0), (x1, y1), (x2, y2) = curve.points
    ax, ay, bx, by = x1 - x0, y1 - y0, x2 - 2 * x1 + x0, y2 - 2 * y1 + y0
    if ax * by == ay * bx:
        return inf
    vertex = -(ax * bx + ay * by) / (bx * bx + by * by)
    bend = abs(curve.curvature(min(max(vertex, 0.0), 1.0)))
    return 1.0 / bend if bend > FLAT else inf
