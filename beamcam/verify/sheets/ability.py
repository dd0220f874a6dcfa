"""What feed a move should have where the program tells the controller its accelerations.

The feed of the machine's row, or the greatest one that the axes can follow: on the smallest radius
of the curve the acceleration across is v^2 / r and the jerk v^3 / r^2.
"""

from math import cbrt, dist, inf, sqrt

from beamcam.geometry.curves import Arc, Bezier, EllipseArc
from beamcam.machine.machine import Machine
from beamcam.machine.path_limits import PathLimits, path_limits
from beamcam.verify.sheets.events import Leg

SECONDS_PER_MINUTE = 60.0
FLAT = 1e-12


def told_limits(machine: Machine) -> PathLimits | None:
    """The limits of a machine whose programs have to tell accelerations; None of others."""
    told = any("{acceleration}" in word for word in machine.words.modal)
    return path_limits(machine) if told else None


def expected_feed(leg: Leg, asked_mm_min: float, limits: PathLimits) -> float:
    """The feed in mm/min that a move should have, at most what is asked for."""
    asked = asked_mm_min / SECONDS_PER_MINUTE
    if leg.curve is None:
        if asked <= limits.speed_mm_s:
            return asked_mm_min
        greatest = _straight_mm_s(leg, limits)
    else:
        radius = _least_radius(leg.curve)
        greatest = min(
            limits.speed_mm_s,
            sqrt(limits.across_mm_s2 * radius),
            cbrt(limits.jerk_mm_s3 * radius**2),
        )
    return min(asked, greatest) * SECONDS_PER_MINUTE


def _straight_mm_s(leg: Leg, limits: PathLimits) -> float:
    length = dist(leg.start, leg.end)
    speeds = (limits.speed_x_mm_s, limits.speed_y_mm_s)
    ways = (abs(b - a) for a, b in zip(leg.start, leg.end, strict=True))
    return min(
        (speed * length / way for speed, way in zip(speeds, ways, strict=True) if way),
        default=inf,
    )


def _least_radius(curve: Arc | Bezier | EllipseArc) -> float:
    """The least radius of an arc or a parabola; of an ellipse that at the ends of its main axis."""
    if isinstance(curve, Arc):
        return curve.radius
    if isinstance(curve, EllipseArc):
        return curve.major * curve.ratio**2
    # The curvature of a parabola grows towards its vertex from both sides: it is greatest there,
    # or at the end that is nearer to it.
    low, high = 0.0, 1.0
    for _ in range(60):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        if abs(curve.curvature(a)) < abs(curve.curvature(b)):
            low = a
        else:
            high = b
    bend = max(abs(curve.curvature(t)) for t in (0.0, (low + high) / 2, 1.0))
    return 1.0 / bend if bend > FLAT else inf
