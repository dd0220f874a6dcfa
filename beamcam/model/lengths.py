"""Lengths of many curves at once, and the length of duplicates among them.

Lines and arcs have closed forms. All Bezier curves of one degree are integrated together, by numpy,
which is imported only when a drawing has some.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from itertools import chain, product
from math import atan2, cos, floor, hypot, pi, sin

from beamcam.geometry.curves import (
    Arc,
    Bezier,
    BSpline,
    Curve,
    EllipseArc,
    Line,
    NewtonCurve,
    bezier_pieces,
)
from beamcam.geometry.plane import Point, dot, groups_of

#: Curves nearer than this coincide.
SAME_PLACE = 1e-3


def total_length(curves: Iterable[Curve]) -> float:
    """The sum of the lengths, to about 1e-10 relative."""
    total = 0.0
    free: dict[int, list[Bezier]] = defaultdict(list)
    for curve in curves:
        if isinstance(curve, Bezier | BSpline | NewtonCurve):
            for piece in bezier_pieces(curve):
                free[piece.degree].append(piece)
        else:
            total += curve.length
    if not free:
        return total
    from beamcam.geometry.free_lengths import bezier_length

    return total + sum(
        bezier_length([piece.homogeneous for piece in some]) for some in free.values()
    )


_Cell = tuple[int, ...]


def duplicate_length(curves: Iterable[Curve]) -> float:
    """By how much the summed length exceeds that of the places that the curves cover.

    Of two equal curves one counts. Collinear lines and arcs of one circle count where they
    overlap; ellipses and free curves only as a whole, in either direction.
    """
    every = tuple(curves)
    lines = [curve for curve in every if isinstance(curve, Line)]
    arcs = [curve for curve in every if isinstance(curve, Arc)]
    others = [curve for curve in every if not isinstance(curve, Line | Arc)]
    # Lines of one carrier have one direction and one distance from the origin. A direction is known
    # to `SAME_PLACE` over the length of the line, so that it is compared as the distances of the
    # carrier from two far points of the drawing instead of an angle.
    span = max((abs(v) for line in lines for p in (line.start, line.end) for v in p), default=0.0)
    placed = []
    along: dict[int, tuple[float, float]] = {}
    for index, line in enumerate(lines):
        if line.length <= SAME_PLACE:
            continue
        x, y = line.tangent(0.0)
        if x < -1e-9 or (abs(x) <= 1e-9 and y < 0):  # the same for both ways of drawing it
            x, y = -x, -y
        direction, normal = (x, y), (-y, x)
        placed.append(((dot(line.start, normal), x * span, y * span), index))
        low, high = sorted((dot(line.start, direction), dot(line.end, direction)))
        along[index] = (low, high)
    total = sum(_overlap([along[i] for i in group]) for group in _clusters(placed))
    round_ = 0.0
    for group in _clusters([((*arc.centre, arc.radius), index) for index, arc in enumerate(arcs)]):
        spans: list[tuple[float, float]] = []
        for arc in (arcs[index] for index in group):
            low = min(arc.start_deg, arc.start_deg + arc.sweep_deg) % 360.0
            high = low + abs(arc.sweep_deg)
            spans.append((low, min(high, 360.0)))
            if high > 360.0:
                spans.append((0.0, high - 360.0))
        round_ += _overlap(spans) * pi / 180.0 * arcs[group[0]].radius
    repeats: list[Curve] = []  # those that are another one drawn again, in either direction
    signatures = [_signature(curve) for curve in others]
    by_kind: dict[tuple[str, int], list[int]] = defaultdict(list)
    for index, curve in enumerate(others):
        by_kind[type(curve).__name__, len(signatures[index])].append(index)
    for members in by_kind.values():
        for group in _clusters([(signatures[i], i) for i in members]):
            repeats += (others[i] for i in sorted(group)[1:])
    return total + round_ + total_length(repeats)


def _clusters(values: Iterable[tuple[tuple[float, ...], int]]) -> list[list[int]]:
    """Indices of values that lie within `SAME_PLACE` of one another in every coordinate.

    A grid of cells of that size over the first three coordinates: neighbours are found in the
    cells around, and joined as sets. Equal values count as one, since many lines of a drawing may
    share a carrier.
    """
    same: dict[tuple[float, ...], list[int]] = defaultdict(list)
    for value, index in values:
        same[value].append(index)
    cells: dict[_Cell, list[tuple[float, ...]]] = defaultdict(list)
    for value in same:
        cells[tuple(floor(v / SAME_PLACE) for v in value[:3])].append(value)
    near = (
        (value, other)
        for cell, members in cells.items()
        for around in product(*((place - 1, place, place + 1) for place in cell))
        for other in cells.get(around, ())
        for value in members
        if value < other
        and all(abs(a - b) <= SAME_PLACE for a, b in zip(value, other, strict=True))
    )
    each = groups_of(chain(zip(same, same, strict=True), near))
    clusters = [sorted(index for value in group for index in same[value]) for group in each]
    return [group for group in clusters if len(group) > 1]


def _overlap(spans: Sequence[tuple[float, float]]) -> float:
    """Summed length of spans less that of their union."""
    surplus, reach = 0.0, float("-inf")
    for low, high in sorted(spans):
        surplus += max(0.0, min(high, reach) - low)
        reach = max(reach, high)
    return surplus


def _signature(curve: Curve) -> tuple[float, ...]:
    """Numbers that are the same for both directions of a curve, and for no other curve."""
    if isinstance(curve, EllipseArc) and abs(curve.sweep_deg) == 360.0:
        angle = atan2(curve.axis[1], curve.axis[0]) % pi
        # A full ellipse may begin anywhere: its axes say which one it is.
        axes = (curve.major * cos(2 * angle), curve.major * sin(2 * angle), curve.minor)
        return (*curve.centre, *axes, 0.0)
    row: tuple[Point, ...]
    match curve:
        case Bezier():
            row = curve.points
        case BSpline():
            row = (*curve.control[: len(curve.control) // 2], curve.point(0.5))
            row += curve.control[len(curve.control) // 2 :]
        case _:
            row = (curve.start, curve.point(0.25), curve.point(0.5), curve.point(0.75), curve.end)
    numbers: list[float] = []
    for (x0, y0), (x1, y1) in zip(row[: (len(row) + 1) // 2], row[::-1], strict=False):
        dx, dy = x1 - x0, y1 - y0
        slant = dx * dy / (hypot(dx, dy) or 1.0)  # tells a rising from a falling diagonal
        numbers += [(x0 + x1) / 2, (y0 + y1) / 2, abs(dx), abs(dy), slant]
    return tuple(numbers)
