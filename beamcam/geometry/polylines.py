"""Many curves as polylines at once, each within a tolerance of its curve; chords as curves again.

A drawing has tens of thousands of curves, most of them lines, arcs and cubics; these are drawn
together, in arrays, and only what is left one by one.
"""

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import repeat
from typing import Any, TypeVar

import numpy as np

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.arrays import CurveTable, cubics_of, numbered
from beamcam.geometry.conics import arc_by_points
from beamcam.geometry.curves import Arc, Bezier, BSpline, Curve, EllipseArc, Line, NewtonCurve
from beamcam.geometry.plane import Point


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
            pieces, breaks = curve.pieces(), np.asarray(curve.breaks())
            which = np.clip(np.searchsorted(breaks, t, side="right") - 1, 0, len(pieces) - 1)
            points = np.empty((len(t), 2))
            for k, piece in enumerate(pieces):
                mine = which == k
                local = (t[mine] - breaks[k]) / (breaks[k + 1] - breaks[k])
                points[mine] = bezier_points(piece, local)
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
    others = []
    for curve in (curves[free[k]] for k in odd):
        pieces = len(curve.pieces()) if isinstance(curve, BSpline) else 1
        chords = chords_of(curve, tolerance, 8 * pieces)
        others.append(points_at(curve, np.linspace(0.0, 1.0, 2 * chords + 1)))
    count = np.zeros(len(curves), dtype=np.int64)
    step = 2 * np.arccos(np.clip(1 - tolerance / table.arcs[:, 2], -1.0, 1.0))
    turns = np.abs(np.radians(table.arcs[:, 4])) / np.clip(step, 1e-6, LARGEST_STEP_RAD)
    arc_steps = np.maximum(np.ceil(turns).astype(np.int64), 1)
    bend = control[:, :-2] - 2 * control[:, 1:-1] + control[:, 2:]
    size = np.sqrt(np.max(np.sum(bend * bend, axis=2), axis=1, initial=0.0))
    cubic_steps = np.ceil(np.sqrt(0.75 * size / tolerance)).astype(np.int64)
    cubic_steps = np.clip(cubic_steps, 1, MOST_STEPS)
    count[lines] = 2
    count[arcs] = arc_steps + 1
    np.add.at(count, cubic_owner, cubic_steps)
    count[cubic_owner] += 1  # the end, once for each curve
    for k, some in zip(odd, others, strict=True):
        count[free[k]] = len(some)
    begins = np.concatenate(([0], np.cumsum(count)))
    points = np.empty((int(begins[-1]), 2))
    points[begins[lines]], points[begins[lines] + 1] = table.lines[:, :2], table.lines[:, 2:]
    owner, number = numbered(arc_steps + 1)
    turn = np.radians(table.arcs[owner, 3] + table.arcs[owner, 4] * (number / arc_steps[owner]))
    centre, radius = table.arcs[owner, :2], table.arcs[owner, 2]
    at = begins[arcs][owner] + number
    points[at, 0] = centre[:, 0] + radius * np.cos(turn)
    points[at, 1] = centre[:, 1] + radius * np.sin(turn)
    _draw_cubics(points, begins, cubic_owner, control, cubic_steps)
    for k, some in zip(odd, others, strict=True):
        points[begins[free[k]] : begins[free[k] + 1]] = some
    return Polylines(points, begins)


def chords_of(curve: Curve, tolerance: float, least: int = 8) -> int:
    """Twice as many chords of a curve until the sagitta of none is above the tolerance."""
    count = least
    while count < MOST_STEPS:
        fine = points_at(curve, np.linspace(0.0, 1.0, 2 * count + 1))
        sag = fine[1::2] - (fine[:-1:2] + fine[2::2]) / 2
        if np.max(np.hypot(sag[:, 0], sag[:, 1])) <= tolerance:
            break
        count *= 2
    return count


def _draw_cubics(
    points: Floats, begins: Counts, owners: Counts, control: Floats, steps: Counts
) -> None:
    """Cubics of one curve follow one another; each draws its start, the last one its end too."""
    if not len(control):
        return
    before = np.cumsum(steps) - steps
    first = np.concatenate(([True], owners[1:] != owners[:-1]))
    base = np.maximum.accumulate(np.where(first, before, 0))
    piece, number = numbered(steps)
    t = (number / steps[piece])[:, None]
    s = 1 - t
    p = control[piece]
    at = begins[owners[piece]] + (before - base)[piece] + number
    points[at] = (
        s * s * s * p[:, 0] + 3 * s * s * t * p[:, 1] + 3 * s * t * t * p[:, 2] + t**3 * p[:, 3]
    )
    last = np.concatenate((first[1:], [True]))
    points[begins[owners[last] + 1] - 1] = control[last, 3]


# --- chords to curves -----------------------------------------------------------------------------

# Arcs and longer lines for runs of short chords, as drawing programs write curves.
#
#     p0 - p1 - p2 - ... - pn      an arc from p0 to pn is taken for them where no corner lies
#                                  farther from it than the tolerance, and no chord comes nearer to
#                                  its centre than the radius less the tolerance
#
# so that neither strays from the other by more. What a run cannot be given stays as it is drawn.


Corners = TypeVar("Corners", list[Point], Floats)

LONGEST = 3.0  #: mm of a chord
LEAST_RUN = 8  #: chords
LEAST_ARC = 4  #: chords that an arc stands for
SAME_POINT = 1e-9
ROUNDING = 1e-6  #: share of a distance
#: No chord of a run turns it by more than this: a square is not a circle.
MOST_SWEEP_DEG = 350.0
MOST_TURN = 0.8  #: the least cosine between neighbouring chords of an arc


def refit_runs(chains: Sequence[Sequence[Curve]], tolerance: float) -> list[tuple[Curve, ...]]:
    """Chains whose runs of short chords are arcs and lines within `tolerance` of them.

    They go through the ends of each run. A run comes back as it is where it would not be half as
    long; without one the chain itself does.
    """
    pieces = [list(_pieces(chain)) for chain in chains]
    runs = [piece for chain in pieces for piece in chain if _is_run(piece)]
    drawn = [np.array([run[0].start, *(line.end for line in run)]) for run in runs]
    fits = iter(map(_refit, runs, drawn, kept_chords(drawn, tolerance), repeat(tolerance)))
    refitted: list[tuple[Curve, ...]] = []
    for chain, own in zip(chains, pieces, strict=True):
        curves = [curve for piece in own for curve in (next(fits) if _is_run(piece) else piece)]
        refitted.append(tuple(chain) if len(curves) == len(chain) else tuple(curves))
    return refitted


def _pieces(curves: Sequence[Curve]) -> Iterator[list[Any]]:
    """A chain in its runs of short chords, and in all other curves one by one."""
    run: list[Line] = []
    for curve in curves:
        short = curve if isinstance(curve, Line) and curve.length <= LONGEST else None
        if run:
            (x0, y0), (x1, y1) = run[-1].end, curve.start
            if short is None or max(abs(x1 - x0), abs(y1 - y0)) > SAME_POINT:
                yield run
                run = []
        if short is None:
            yield [curve]
        else:
            run.append(short)
    if run:
        yield run


def _is_run(piece: Sequence[Curve]) -> bool:
    return len(piece) >= LEAST_RUN


def arcs_and_lines(points: Sequence[Point], tolerance: float) -> list[Line | Arc]:
    """Curves from the first of some places to the last, through ends of theirs.

    Arcs within `tolerance` of LEAST_ARC chords at least and of both sides, whatever the length of
    those chords; each other chord is a line by itself.
    """
    places = np.array(points)
    curves: list[Line | Arc] = []
    at = 0
    while at + 1 < len(points):
        arc, reach = longest_arc(places, at, LEAST_ARC, lambda run: _arc_over(run, tolerance))
        if arc is None:
            reach = at + 1
            curves.append(Line(points[at], points[reach]))
        else:
            curves.append(arc)
        at = reach
    return curves


def _refit(
    run: Sequence[Line], points: Floats, kept: Sequence[bool], tolerance: float
) -> Sequence[Curve]:
    fitted: list[Curve] = []
    at = 0
    while at < len(run):
        arc, reach = None, at
        if not kept[at]:
            arc, reach = longest_arc(points, at, LEAST_ARC, lambda run: _arc_over(run, tolerance))
        if arc is not None:
            fitted.append(arc)
        else:
            reach = at + 1
            if not kept[at]:
                reach = longest_line(points, at, lambda run: _is_straight(run, tolerance))
            line = run[at] if reach == at + 1 else Line(run[at].start, run[reach - 1].end)
            fitted.append(line)
        if 2 * len(fitted) > len(run):
            return run
        at = reach
    return fitted


def kept_chords(runs: Sequence[Floats], tolerance: float) -> list[list[bool]]:
    """Of runs by their points, which chords stay: no arc and no line begins at their start.

    An arc over LEAST_ARC chords turns gently at each of the corners between them, a line over two
    has the corner between them within the tolerance.
    """
    if not runs:
        return []
    points = np.concatenate(runs)
    begins = np.cumsum([len(run) for run in runs])[:-1]
    way = np.diff(points, axis=0)
    size = np.hypot(way[:, 0], way[:, 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        sharp = (way[1:] * way[:-1]).sum(axis=1) / (size[1:] * size[:-1]) < MOST_TURN
    over = way[1:] + way[:-1]
    across = np.abs(way[:-1, 0] * over[:, 1] - way[:-1, 1] * over[:, 0])
    # What rounding leaves of a distance is left to `_is_straight`.
    bent = across > (1 + ROUNDING) * tolerance * np.hypot(over[:, 0], over[:, 1])
    # From one run to the next nothing goes on.
    sharp[begins - 2] = bent[begins - 2] = True
    no_arc, no_line = np.ones((2, len(way)), dtype=bool)
    no_arc[: 1 - LEAST_ARC] = np.lib.stride_tricks.sliding_window_view(sharp, LEAST_ARC - 1).any(1)
    no_line[:-1] = bent
    return [kept[:-1].tolist() for kept in np.split(np.append(no_arc & no_line, True), begins)]


def _arc_over(points: Floats, tolerance: float) -> Arc | None:
    """The arc from the first place to the last that all chords are within the tolerance of."""
    first, middle, last = ((x, y) for x, y in points[[0, len(points) // 2, -1]].tolist())
    arc = arc_by_points(first, middle, last)
    if arc is None or abs(arc.sweep_deg) > MOST_SWEEP_DEG:
        return None
    out = points - np.array(arc.centre)
    away = np.hypot(out[:, 0], out[:, 1])
    if np.abs(away - arc.radius).max() > tolerance:
        return None
    way = np.diff(points, axis=0)
    size = np.hypot(way[:, 0], way[:, 1])
    if not size.min() > 0.0:
        return None
    # Corners follow one another round the centre, never back.
    side = 1.0 if arc.sweep_deg > 0.0 else -1.0
    moment = side * (out[:-1, 0] * way[:, 1] - out[:-1, 1] * way[:, 0])
    if moment.min() <= 0.0 or (moment / size).min() < arc.radius - tolerance:
        return None
    turn = (way[1:] * way[:-1]).sum(axis=1) / (size[1:] * size[:-1])
    return arc if turn.min() >= MOST_TURN else None


def _is_straight(points: Floats, tolerance: float) -> bool:
    chord = points[-1] - points[0]
    size = float(np.hypot(*chord))
    if not size > 0.0:
        return False
    steps = np.diff(points, axis=0) @ chord
    out = points - points[0]
    across = np.abs(out[:, 0] * chord[1] - out[:, 1] * chord[0])
    return bool(steps.min() > 0.0 and across.max() <= tolerance * size)


def longest_arc(
    points: Corners, at: int, least: int, arc_over: Callable[[Corners], Arc | None]
) -> tuple[Arc | None, int]:
    """The arc from corner `at` over the most corners; doubles its reach, then halves the step.

    It goes over `least` chords or more. Without one None, and `at`.
    """
    best: Arc | None = None
    reach, step, growing = at, least, True
    while step >= 1:
        wished = reach + step
        arc = arc_over(points[at : wished + 1]) if wished < len(points) else None
        if arc is not None:
            best, reach = arc, wished
            step = step * 2 if growing else step
        elif best is None:
            break
        else:
            growing = False
            step //= 2
    return best, reach


def longest_line(points: Corners, at: int, is_straight: Callable[[Corners], bool]) -> int:
    """The last corner that a line from corner `at` may end at."""
    reach = at + 1
    while reach + 1 < len(points) and is_straight(points[at : reach + 2]):
        reach += 1
    return reach
