"""Curves to points, for controllers that only know lines.

Two rules meet here. The chord rule says how far apart points may be, so that their chords stay
near the curve. The cycle rule says how far apart they must be, so that a controller that looks
every T seconds sees each of them: at speed v no chord may be shorter than k v T. The points
follow the chord rule, in equal steps as large as it allows; where the cycle rule forbids that,
the speed of the stretch is lowered until it does not, and the speeds of its steps say so.

            tolerance = chord error + rounding of the points + gaps between the curves
"""

import itertools
from collections import defaultdict
from collections.abc import Sequence
from math import inf

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.bezier import Bezier
from beamcam.geometry.curves import Arc, Curve, EllipseArc, Line, bezier_pieces
from beamcam.geometry.plane import distance
from beamcam.motion.rounding import truncated, worst_truncation
from beamcam.motion.span_points import Spans, draw
from beamcam.motion.spans import (
    bend_bounds,
    divided,
    parts_for,
    span_arc,
    step_counts,
)


class DensifyRules(Struct, frozen=True):
    """Chord tolerance and point rate."""

    tolerance: float  #: maximum distance between the curves and the output path
    counts: int = 0  #: per mm, after which points are truncated; 0 leaves them as they are
    speed_mm_s: float = inf
    cycle_s: float = 0.0  #: time between two looks of the controller; 0 for no cycle rule
    cycles_per_chord: float = 3.0

    def __post_init__(self) -> None:
        if not self.tolerance > 0.0:
            raise ValueError(f"tolerance must be above 0, found {self.tolerance:g}")
        if not self.speed_mm_s > 0.0:
            raise ValueError(f"speed must be above 0, found {self.speed_mm_s:g}")
        if self.cycle_s < 0.0 or not self.cycles_per_chord > 0.0:
            raise ValueError(
                f"no cycle rule: {self.cycles_per_chord:g} cycles of {self.cycle_s:g} s"
            )


class Densified(Struct, frozen=True):
    """The points of a path, read-only, with the speed of each step between them."""

    points: Floats  #: (n, 2)
    speeds_mm_s: Floats  #: (n - 1,)
    deviation: float  #: no point of curve or path is farther from the other, rounding included


def densify(path: Sequence[Curve], rules: DensifyRules) -> Densified:
    """The points of curves that follow one another, start and end included.

    `deviation` bounds the distance between curves and polyline both ways and is at
    most `rules.tolerance`. The number of points grows with 1 / sqrt(tolerance); time and memory
    are linear in it. Points that rounding makes one are put out once.

    Raises ValueError for an empty path, and where rounding and gaps between the curves leave
    nothing of the tolerance.
    """
    if not path:
        raise ValueError("a path needs one curve or more")
    gaps = [distance(a.end, b.start) for a, b in itertools.pairwise(path)]
    gap = max(gaps, default=0.0)
    # Points are computed to some units in the last place of the largest coordinate.
    blur = 64 * np.finfo(np.float64).eps * max(_reach(curve) for curve in path)
    worst = worst_truncation(rules.counts)
    left = rules.tolerance - gap - worst - blur
    if not left > 0.0:
        raise ValueError(
            f"tolerance {rules.tolerance:g} is used up: rounding takes {worst:g}, "
            f"the widest gap {gap:g} (before curve {gaps.index(gap) + 2 if gaps else 1})"
        )
    spans = _collect_spans(path, left * (1 - 1e-8))
    exact = draw(path[0].start, spans)
    points = truncated(exact, rules.counts)
    moved = float(np.max(np.hypot(*(points - exact).T))) if rules.counts else 0.0
    steps = np.array([n for own in spans.steps for n in own])
    return _finish(points, steps, rules, float(spans.deviation + moved + gap + blur))


def _reach(curve: Curve) -> float:
    """A bound on the size of the numbers that a curve is computed with."""
    match curve:
        case Line():
            return max(map(abs, (*curve.start, *curve.end)))
        case Arc():
            return max(map(abs, curve.centre)) + curve.radius
        case EllipseArc():
            return max(map(abs, curve.centre)) + curve.major
        case _:
            return max(abs(v) for piece in bezier_pieces(curve) for p in piece.points for v in p)


def _collect_spans(path: Sequence[Curve], tolerance: float) -> Spans:
    spans = Spans()
    free: dict[tuple[int, bool], list[tuple[int, Bezier]]] = defaultdict(list)
    for curve in path:
        match curve:
            case Line(end=end):
                spans.lines.append((len(spans.steps), end))
                spans.steps.append([1])
            case Arc() | EllipseArc():
                span = span_arc(curve, tolerance)
                spans.arcs.append((len(spans.steps), span))
                spans.deviation = max(spans.deviation, span.deviation)
                spans.steps.append([span.steps])
            case _:
                for piece in bezier_pieces(curve):
                    kind = piece.degree, piece.weights is not None
                    free[kind].append((len(spans.steps), piece))
                    spans.steps.append([])
    for kind, pieces in free.items():
        _span_free(kind, pieces, tolerance, spans)
    return spans


def _span_free(
    kind: tuple[int, bool],
    pieces: list[tuple[int, Bezier]],
    tolerance: float,
    spans: Spans,
) -> None:
    """Cuts free curves of one degree in spans, all of them at once."""
    control = np.array([piece.homogeneous for _, piece in pieces])
    bend, smooth = bend_bounds(control)
    parts = parts_for(step_counts(bend, smooth, tolerance), smooth)
    for count in np.unique(parts).tolist():
        mine = np.flatnonzero(parts == count)
        fine = divided(control[mine], count)
        bend, smooth = bend_bounds(fine)
        steps = step_counts(bend, smooth, tolerance)
        spans.deviation = max(spans.deviation, float(np.max(bend / (8 * steps**2))))
        shaped = fine.reshape(len(mine), count, kind[0] + 1, 3)
        for row, which in enumerate(mine.tolist()):
            number, piece = pieces[which]
            n = steps[row * count : (row + 1) * count]
            spans.steps[number] = n.tolist()
            spans.free[kind].append((number, shaped[row], n, piece.end))


def _finish(points: Floats, steps: Counts, rules: DensifyRules, deviation: float) -> Densified:
    """Drops steps of no length, lowers speeds by the cycle rule."""
    lengths = np.hypot(*np.diff(points, axis=0).T)
    span = np.repeat(np.arange(len(steps)), steps) if rules.cycle_s > 0.0 else lengths
    if np.min(lengths) == 0.0:
        kept = lengths > 0.0
        points = points[np.concatenate(([True], kept))]
        lengths, span = lengths[kept], span[kept]
    speeds = np.full(len(lengths), rules.speed_mm_s)
    if rules.cycle_s > 0.0 and len(lengths):
        starts = np.concatenate(([0], np.flatnonzero(np.diff(span)) + 1))
        least = np.minimum.reduceat(lengths, starts)
        allowed = np.minimum(rules.speed_mm_s, least / (rules.cycles_per_chord * rules.cycle_s))
        speeds = np.repeat(allowed, np.diff(np.concatenate((starts, [len(lengths)]))))
    points.setflags(write=False)
    speeds.setflags(write=False)
    return Densified(points, speeds, deviation)
