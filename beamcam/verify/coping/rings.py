"""What is drawn as rings of points, for the read-back alone."""

from collections.abc import Callable, Iterator, Sequence
from math import ceil, cos, inf, pi, radians, sin

from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.model.part import Slot

FINE = 0.02  #: mm between a curve and its chords, at most
STEPS = 256  #: of a curve that is no arc
EDGE_NOISE = 1.0  #: mm that a side of an outline may lie off the edge of its wall and mean it
SEAM_NOISE = 2.5  #: likewise of a tube's seam, which is a long side
EDGE_SLOPE = 0.02  #: of such a side, at most


def ring_of(curves: tuple[Curve, ...]) -> list[Point]:
    """Points along a closed chain of curves."""
    return [point for curve in curves for point in _places(curve)]


def outline_ring(
    curves: tuple[Curve, ...], edges: Sequence[float], at_end: Callable[[Point], Point],
    seam_from: float = inf,
) -> list[Point]:  # fmt: skip
    """Points along an outline, its sides near one of some edges on that edge.

    A side of a tube that is as long as `seam_from` may be its seam.

    Only ends of straight sides are moved, to an edge and then by `at_end`; those of an arc that
    runs into an edge are steel that is asked for.
    """
    found: list[Point] = []
    for k, curve in enumerate(curves):
        first, *rest = _places(curve)
        sides = [one for one in (curves[k - 1], curve) if isinstance(one, Line)]
        x, y = first
        on = [edge for edge in edges if any(_is_edge(side, edge, seam_from) for side in sides)]
        first = (x, on[0] if on else y)
        found += [at_end(first) if sides else first, *rest]
    return found


def _is_edge(side: Line, edge: float, seam_from: float) -> bool:
    """Whether a side of an outline means an edge of its wall."""
    off, run = abs(side.start[1] - edge), side.end[0] - side.start[0]
    rise = side.end[1] - side.start[1]
    most = SEAM_NOISE if abs(run) >= seam_from else EDGE_NOISE
    return max(off, abs(side.end[1] - edge)) <= most and abs(rise) <= EDGE_SLOPE * abs(run)


def _places(curve: Curve) -> list[Point]:
    """Points along a curve, without its end."""
    if isinstance(curve, Line):
        return [curve.start]
    if isinstance(curve, Arc):
        more = round_ring(*curve.centre, curve.radius, curve.start_deg, curve.sweep_deg)
        return list(more)[:-1]
    return [curve.point(k / STEPS) for k in range(STEPS)]


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
