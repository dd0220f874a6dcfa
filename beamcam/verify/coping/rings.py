"""What is drawn as rings of points, for the read-back alone."""

from collections.abc import Iterator
from math import ceil, cos, pi, radians, sin

from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.model.part import Slot

FINE = 0.02  #: mm between a curve and its chords, at most
STEPS = 256  #: of a curve that is no arc


def ring_of(curves: tuple[Curve, ...]) -> list[Point]:
    """Points along a closed chain of curves."""
    points: list[Point] = []
    for curve in curves:
        if isinstance(curve, Line):
            points.append(curve.start)
        elif isinstance(curve, Arc):
            more = round_ring(*curve.centre, curve.radius, curve.start_deg, curve.sweep_deg)
            points += list(more)[:-1]
        else:
            points += [curve.point(k / STEPS) for k in range(STEPS)]
    return points


def round_ring(
    x: float, y: float, radius: float, first: float = 0.0, sweep: float = 360.0
) -> Iterator[Point]:
    """Points of an arc; a chord of a step t lies r t^2 / 8 off it at most."""
    step = min(pi / 8, (8 * FINE / 2 / radius) ** 0.5) if radius else pi / 8
    count = max(2, ceil(abs(radians(sweep)) / step))
    for k in range(count + 1):
        turn = radians(first + sweep * k / count)
        yield x + radius * cos(turn), y + radius * sin(turn)


def slot_ring(slot: Slot) -> Iterator[Point]:
    """Points of the circles at the corners of a slot, whose hull it is."""
    c, s = cos(radians(slot.angle)), sin(radians(slot.angle))
    for a, b in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)):
        x = slot.x + a * slot.length * c - b * slot.height * s
        y = slot.y + a * slot.length * s + b * slot.height * c
        yield from round_ring(x, y, slot.diameter / 2)
