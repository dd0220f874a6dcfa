"""Many curves as polylines at once, each within a tolerance of its curve.

A drawing has tens of thousands of curves, most of them lines, arcs and cubics; these are drawn
together, in arrays, and only what is left one by one.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.arrays import CurveTable
from beamcam.geometry.biarcs import cubics_of
from beamcam.geometry.curves import Arc, Bezier, BSpline, Curve, EllipseArc, Line, NewtonCurve


def points_at(curve: Curve, t: Floats) -> Floats:
    """The points at parameters `t` of shape (n,): an array of shape (n, 2).

    Where `t` is 0 or 1 the ends come back exactly.
    """
    t = np.asarray(t, dtype=np.float64)
    points: Floats
    match curve:
        case Line():
            start = np.asarray(curve.start)
            points = start + t[:, None] * (np.asarray(curve.end) - start)
        case Arc():
            angle = np.radians(curve.start_deg + t * curve.sweep_deg)
            circle = np.column_stack((np.cos(angle), np.sin(angle)))
            points = np.asarray(curve.centre) + curve.radius * circle
        case EllipseArc():
            angle = np.radians(curve.start_deg + t * curve.sweep_deg)
            (ax, ay), r = curve.axis, curve.ratio
            c, s = np.cos(angle), r * np.sin(angle)
            points = np.asarray(curve.centre) + np.column_stack((c * ax - s * ay, c * ay + s * ax))
        case Bezier():
            points = bezier_points(curve, t)
        case BSpline():
            points = _spline_points(curve, t)
        case NewtonCurve():
            points = bezier_points(curve.as_bezier(), t)
    points[t == 0.0] = curve.start
    points[t == 1.0] = curve.end
    return points


def bezier_points(curve: Bezier, t: Floats) -> Floats:
    """Points of a Bezier curve by de Casteljau, array (n, 2)."""
    rows = [np.asarray(p)[:, None] for p in curve.homogeneous]
    # One row for each coordinate keeps the arrays contiguous.
    while len(rows) > 1:
        rows = [a + t * (b - a) for a, b in itertools.pairwise(rows)]
    x, y, w = rows[0]
    return np.column_stack((x / w, y / w))


def _spline_points(spline: BSpline, t: Floats) -> Floats:
    pieces, breaks = spline.pieces(), np.asarray(spline.breaks())
    which = np.clip(np.searchsorted(breaks, t, side="right") - 1, 0, len(pieces) - 1)
    points = np.empty((len(t), 2))
    for k, piece in enumerate(pieces):
        mine = which == k
        local = (t[mine] - breaks[k]) / (breaks[k + 1] - breaks[k])
        points[mine] = bezier_points(piece, local)
    return points


LARGEST_STEP_RAD = 0.8  #: of an arc, whatever the tolerance
MOST_STEPS = 4096


@dataclass(frozen=True, slots=True)
class Polylines:
    """Points of curve k are `points[begins[k] : begins[k + 1]]`, both of its ends among them."""

    points: Floats  #: (n, 2)
    begins: Counts  #: one more than there are curves


def polylines(curves: Sequence[Curve], tolerance: float) -> Polylines:
    """The polylines of curves, no chord farther than `tolerance` from its curve.

    Steps of an arc: sagitta r (1 - cos(step / 2)); of a Bezier curve of degree d: Wang's bound
    sqrt(d (d - 1) / 8 max|P(i) - 2 P(i+1) + P(i+2)| / tolerance). Raises ValueError if the
    tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    table = CurveTable(curves)
    lines, arcs, free = table.where(Line), table.where(Arc), table.free()
    control, owner, odd = cubics_of([curves[k] for k in free])
    cubic_owner = np.array(free, dtype=np.int64)[owner]
    others = [(free[k], _one(curves[free[k]], tolerance)) for k in odd]
    count = np.zeros(len(curves), dtype=np.int64)
    arc_steps = _arc_steps(table.arcs, tolerance)
    cubic_steps = _cubic_steps(control, tolerance)
    count[lines] = 2
    count[arcs] = arc_steps + 1
    np.add.at(count, cubic_owner, cubic_steps)
    count[cubic_owner] += 1  # the end, once for each curve
    for k, points in others:
        count[k] = len(points)
    begins = np.concatenate(([0], np.cumsum(count)))
    found = np.empty((int(begins[-1]), 2))
    found[begins[lines]], found[begins[lines] + 1] = table.lines[:, :2], table.lines[:, 2:]
    _draw_arcs(found, begins[arcs], table.arcs, arc_steps)
    _draw_cubics(found, begins, cubic_owner, control, cubic_steps)
    for k, points in others:
        found[begins[k] : begins[k + 1]] = points
    return Polylines(found, begins)


def _arc_steps(arcs: Floats, tolerance: float) -> Counts:
    share = np.clip(1 - tolerance / arcs[:, 2], -1.0, 1.0)
    step = np.clip(2 * np.arccos(share), 1e-6, LARGEST_STEP_RAD)
    turns = np.ceil(np.abs(np.radians(arcs[:, 4])) / step).astype(np.int64)
    arc_steps: Counts = np.maximum(turns, 1)
    return arc_steps


def _cubic_steps(control: Floats, tolerance: float) -> Counts:
    bend = control[:, :-2] - 2 * control[:, 1:-1] + control[:, 2:]
    size = np.sqrt(np.max(np.sum(bend * bend, axis=2), axis=1, initial=0.0))
    steps = np.ceil(np.sqrt(0.75 * size / tolerance)).astype(np.int64)
    cubic_steps: Counts = np.clip(steps, 1, MOST_STEPS)
    return cubic_steps


def _within(steps: Counts) -> tuple[Counts, Counts]:
    """For runs of so many: the run of each member, and its number in it from 0."""
    owner = np.repeat(np.arange(len(steps)), steps)
    return owner, np.arange(len(owner)) - (np.cumsum(steps) - steps)[owner]


def _draw_arcs(points: Floats, begins: Counts, arcs: Floats, steps: Counts) -> None:
    owner, number = _within(steps + 1)
    turn = np.radians(arcs[owner, 3] + arcs[owner, 4] * (number / steps[owner]))
    at = begins[owner] + number
    points[at, 0] = arcs[owner, 0] + arcs[owner, 2] * np.cos(turn)
    points[at, 1] = arcs[owner, 1] + arcs[owner, 2] * np.sin(turn)


def _draw_cubics(
    points: Floats, begins: Counts, owners: Counts, control: Floats, steps: Counts
) -> None:
    """Cubics of one curve follow one another; each draws its start, the last one its end too."""
    if not len(control):
        return
    before = np.cumsum(steps) - steps
    first = np.concatenate(([True], owners[1:] != owners[:-1]))
    base = np.maximum.accumulate(np.where(first, before, 0))
    piece, number = _within(steps)
    t = (number / steps[piece])[:, None]
    s = 1 - t
    p = control[piece]
    at = begins[owners[piece]] + (before - base)[piece] + number
    points[at] = (
        s * s * s * p[:, 0] + 3 * s * s * t * p[:, 1] + 3 * s * t * t * p[:, 2] + t**3 * p[:, 3]
    )
    last = np.concatenate((first[1:], [True]))
    points[begins[owners[last] + 1] - 1] = control[last, 3]


def _one(curve: Curve, tolerance: float) -> Floats:
    """Points of any curve, twice as many until the sagitta of no chord is above the tolerance."""
    pieces = len(curve.pieces()) if isinstance(curve, BSpline) else 1
    count = 8 * ceil(pieces)
    while True:
        points = points_at(curve, np.linspace(0.0, 1.0, 2 * count + 1))
        sag = points[1::2] - (points[:-1:2] + points[2::2]) / 2
        if np.max(np.hypot(sag[:, 0], sag[:, 1])) <= tolerance or count >= MOST_STEPS:
            return points
        count *= 2
