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
from math import comb, inf, sqrt

import numpy as np
from msgspec import Struct, field

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.arrays import numbered
from beamcam.geometry.bezier import Bezier
from beamcam.geometry.curves import Arc, Curve, EllipseArc, Line, bezier_pieces
from beamcam.geometry.plane import Point, distance
from beamcam.motion.spans import ArcSpan, bend_bounds, divided, parts_for, span_arc, step_counts

#: Coordinates this share of a count below a whole count are that count when truncated: 0.29 is
#: a hair less than 0.29 in binary and shall not become 0.289.
TRUNCATION_SLACK = 1e-6


def truncated(points: Floats, counts: int) -> Floats:
    """The points on a grid of so many counts a mm, towards zero and without -0.0.

    Doing it twice changes nothing more; 0 counts leave points as they are.
    """
    if counts == 0:
        return points
    counted = points * counts
    return (np.trunc(counted + np.copysign(TRUNCATION_SLACK, counted)) + 0.0) / counts


def worst_truncation(counts: int) -> float:
    """The farthest that a point of the plane can be moved by it."""
    return sqrt(2) / counts if counts else 0.0


# Points of spans, many at a time.
#
# Spans that have few points each are drawn together: their numbers are repeated for each point.


class Spans(Struct):
    """All pieces of a path, by their numbers along it, and the spans that each is drawn in."""

    steps: list[list[int]] = field(default_factory=list)  #: of the spans of each piece
    arcs: list[tuple[int, ArcSpan]] = field(default_factory=list)
    lines: list[tuple[int, tuple[float, float]]] = field(default_factory=list)
    #: (degree, with weights) -> (number, control points and steps of its spans, end) of each
    free: dict[tuple[int, bool], list[tuple[int, Floats, Counts, Point]]] = field(
        default_factory=lambda: defaultdict(list)
    )
    deviation: float = 0.0


def draw(start: tuple[float, float], spans: Spans) -> Floats:
    """The points of all spans, array (sum of steps + 1, 2)."""
    ends = np.cumsum([sum(own) for own in spans.steps])
    begins = np.append(0, ends[:-1])
    points = np.empty((int(ends[-1]) + 1, 2))
    points[0] = start
    if spans.lines:
        which = np.array([k for k, _ in spans.lines])
        points[ends[which]] = [end for _, end in spans.lines]
    if spans.arcs:
        _draw_arcs(points, begins, spans.arcs)
    for (degree, weighted), pieces in spans.free.items():
        starts = np.concatenate([begins[k] + np.cumsum(n) - n for k, _, n, _ in pieces])
        control = np.concatenate([c for _, c, _, _ in pieces])
        steps = np.concatenate([n for _, _, n, _ in pieces])
        # By Horner's scheme in powers of the parameter. Powers are safe here: the control points of
        # a span lie close together, and are taken from its start.
        origin = control[:, :1, :2] / control[:, :1, 2:]
        about = control.copy()
        about[..., :2] -= origin * control[..., 2:]
        n = range(degree + 1)  # from Bernstein coefficients to those of 1, t, t^2, ...
        to_powers = [[(-1.0) ** (p - i) * comb(degree, p) * comb(p, i) for i in n] for p in n]
        powers = np.einsum("pi,mic->pcm", np.array(to_powers), about)
        cuts = (np.flatnonzero(np.diff(np.cumsum(steps) // CHUNK)) + 1).tolist()
        for low, high in itertools.pairwise((0, *cuts, len(steps)) if len(steps) else ()):
            which, index = numbered(steps[low:high])
            which, index = which + low, index + 1
            t = index / steps[which]
            at = starts[which] + index
            scale = 1.0 / _horner(powers[:, 2, which], t) if weighted else 1.0
            for i in (0, 1):
                points[at, i] = _horner(powers[:, i, which], t) * scale + origin[which, 0, i]
        points[starts + steps] = control[:, -1, :2] / control[:, -1, 2:]
        # Dividing by a weight costs a bit; the ends of the curves are exact.
        points[[ends[k] for k, *_ in pieces]] = [end for *_, end in pieces]
    return points


#: Arcs with as many steps as this are drawn one by one, shorter ones together: that is where the
#: cost of a numpy call and the cost of repeating an arc's numbers for each point meet.
LONG_SPAN = 40

#: So many points are drawn together: enough to hide the cost of the calls, few enough to stay
#: in the processor's cache.
CHUNK = 1 << 14


def _draw_arcs(points: Floats, begins: Counts, arcs: list[tuple[int, ArcSpan]]) -> None:
    short = []
    for k, span in arcs:
        if span.steps < LONG_SPAN:
            short.append((k, span))
            continue
        _draw_long_arc(points[begins[k] + 1 : begins[k] + span.steps + 1], span)
    if short:
        numbers = np.array([k for k, _ in short])
        steps = np.array([span.steps for _, span in short])
        table = np.array(
            [(np.radians(a.start_deg), np.radians(a.sweep_deg) / a.steps,
              a.centre[0], a.u[0], a.v[0], a.centre[1], a.u[1], a.v[1]) for _, a in short]
        ).T  # fmt: skip
        which, index = numbered(steps)
        index += 1
        start, step, cx, ux, vx, cy, uy, vy = (row[which] for row in table)
        angle = start + step * index
        c, s = np.cos(angle), np.sin(angle)
        at = begins[numbers][which] + index
        points[at, 0] = cx + ux * c + vx * s
        points[at, 1] = cy + uy * c + vy * s
    last = [begins[k] + span.steps for k, span in arcs]
    points[last] = [span.end for _, span in arcs]


def _draw_long_arc(block: Floats, span: ArcSpan) -> None:
    """Fills `block` with the points of one arc, by turning one short row of them.

    Rows of about sqrt(n) points differ by a turn of u and v, so sine and cosine are needed for
    2 sqrt(n) angles instead of n; each point is one turn away from them, so that errors do not
    add up.
    """
    n = span.steps
    step = np.radians(span.sweep_deg) / n
    width = int(np.ceil(np.sqrt(n)))
    rows = -(-n // width)
    within = np.arange(1, width + 1) * step
    base = np.arange(rows) * (width * step) + np.radians(span.start_deg)
    c, s = np.cos(within), np.sin(within)
    cb, sb = np.cos(base)[:, None], np.sin(base)[:, None]
    for i in (0, 1):
        # u cos(b + w) + v sin(b + w), regrouped by cos(w) and sin(w)
        grid = (span.u[i] * cb + span.v[i] * sb) * c
        grid += (span.v[i] * cb - span.u[i] * sb) * s
        grid += span.centre[i]
        block[:, i] = grid.reshape(-1)[:n]


def _horner(coefficients: Floats, t: Floats) -> Floats:
    """The polynomial c0 + c1 t + ..., coefficients along the first axis."""
    total: Floats = coefficients[-1] * t
    for c in coefficients[-2:0:-1]:
        total += c
        total *= t
    total += coefficients[0]
    return total


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
    # Steps of no length are dropped, speeds lowered by the cycle rule.
    deviation = float(spans.deviation + moved + gap + blur)
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
        # Cuts free curves of one degree in spans, all of them at once.
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
    return spans
