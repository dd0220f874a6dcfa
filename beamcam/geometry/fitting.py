"""Arcs that stand for free curves, within a stated distance.

A controller that knows arcs makes in one block what takes many chords; most cubics of drawing
programs are arcs in disguise. Where a curve is no arc, two arcs with one tangent at their joint
(a biarc) replace a piece of it; pieces are halved until they are near enough.
"""

from collections.abc import Sequence
from math import atan2, cos, degrees, hypot, radians, sin, sqrt

from msgspec import Struct

from beamcam.geometry.bezier import Bezier
from beamcam.geometry.conics import arc_between, direction_deg
from beamcam.geometry.curves import (
    Arc,
    BSpline,
    Curve,
    EllipseArc,
    Line,
    NewtonCurve,
    bezier_pieces,
)
from beamcam.geometry.plane import Point, cross, distance, dot

#: Cubics of drawing programs miss the circle that they stand for by 2.7e-4 of its radius.
KAPPA_ERROR = 3e-4

#: Drawing programs draw no wider arc than this by one cubic.
WIDEST_KNOWN_DEG = 95.0

#: Where the distance to a curve is measured, per arc; the greatest of them is rounded up by
#: `SAMPLE_MARGIN` for what lies between.
SAMPLES = 24
SAMPLE_MARGIN = 1.1

MAX_HALVINGS = 20


class ArcFit(Struct, frozen=True):
    """Lines and arcs that follow one another, and a bound on their distance from the curve."""

    curves: tuple[Line | Arc, ...]
    deviation: float


Free = EllipseArc | Bezier | BSpline | NewtonCurve


def fit_single_arc(curve: Bezier, tolerance: float) -> ArcFit | None:
    """The arc through start, middle and end of a curve, if it is one; else None.

    To know the circles of drawing programs again, the tolerance is taken as at least what their
    own cubics miss an arc of that sweep by; the deviation that comes back is the measured one.
    """
    a, m, b = curve.start, curve.point(0.5), curve.end
    arc = _arc_through_three(a, m, b)
    if arc is None:
        return None
    off = _distance_from_arc(curve, arc)
    if off > max(tolerance, SAMPLE_MARGIN * known_error(arc)) or not _runs_along(curve, arc):
        return None
    return ArcFit((arc,), off)


def known_error(arc: Arc) -> float:
    """What the usual cubic for an arc misses it by: r 4/27 sin^6(s/4) / cos^2(s/4), s the sweep.

    0 for an arc wider than drawing programs draw by one cubic.
    """
    if abs(arc.sweep_deg) > WIDEST_KNOWN_DEG:
        return 0.0
    quarter = radians(abs(arc.sweep_deg)) / 4
    return arc.radius * 4 / 27 * sin(quarter) ** 6 / cos(quarter) ** 2


def fit_arcs(curve: Free, tolerance: float) -> ArcFit:
    """A free curve as lines and arcs within `tolerance` of it, tangents kept at the joints.

    The error of a biarc falls with the third power of its length, so the number of arcs grows
    with 1 / tolerance^(1/3). Raises ValueError if the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    found: list[tuple[Line | Arc, float]] = []
    if isinstance(curve, EllipseArc):
        _halve(curve, tolerance, found, MAX_HALVINGS)
    else:
        for piece in bezier_pieces(curve):
            for part in _between_extremes(piece):
                _halve(part, tolerance, found, MAX_HALVINGS)
    return ArcFit(tuple(c for c, _ in found), max(off for _, off in found))


def _between_extremes(curve: Bezier) -> list[Bezier]:
    """Pieces that turn in neither direction: none of them makes more than a quarter turn back."""
    parts: list[Bezier] = []
    done, rest = 0.0, curve
    for t in curve.extremes():
        left, rest = rest.split((t - done) / (1.0 - done))
        parts.append(left)
        done = t
    return [p for p in (*parts, rest) if p.start != p.end or p.length > 0.0]


def _halve(
    curve: EllipseArc | Bezier,
    tolerance: float,
    found: list[tuple[Line | Arc, float]],
    halvings: int,
) -> None:
    a, b = curve.start, curve.end
    inner = [curve.point(k / SAMPLES) for k in range(1, SAMPLES)]
    if distance(a, b) > 0.0 and (isinstance(curve, Bezier) or abs(curve.sweep_deg) <= 90.0):
        off = _distance_from_line(inner, a, b)
        if off <= tolerance / 16 or (off <= tolerance and halvings == 0):
            found.append((Line(a, b), off))
            return
        pair = biarc(a, curve.tangent(0.0), b, curve.tangent(1.0))
        if pair is not None:
            off = SAMPLE_MARGIN * max(min(_distance_to(part, p) for part in pair) for p in inner)
            if off <= tolerance:
                found.extend((part, off) for part in pair)
                return
    if halvings == 0:
        found.append((Line(a, b), _distance_from_line(inner, a, b)))
        return
    left, right = curve.split(0.5)
    _halve(left, tolerance, found, halvings - 1)
    _halve(right, tolerance, found, halvings - 1)


def biarc(
    start: Point, start_tangent: Point, end: Point, end_tangent: Point
) -> tuple[Line | Arc, Line | Arc] | None:
    """Two arcs (or lines) from `start` to `end` with given tangents and one at their joint.

    Equal legs d: with v = end - start and t = t0 + t1, d solves
    d^2 (2 - 2 t0.t1) + 2 d v.t - v.v = 0. None where no d above 0 does, or where an arc would
    turn by more than half a circle. Source: Bolton, "Biarc curves", 1975.
    """
    v = (end[0] - start[0], end[1] - start[1])
    t = (start_tangent[0] + end_tangent[0], start_tangent[1] + end_tangent[1])
    spread = 2 * (1 - dot(start_tangent, end_tangent))
    if spread > 1e-12:
        root = sqrt(dot(v, t) ** 2 + spread * dot(v, v))
        # The form without cancellation where v.t > 0, as it is along a curve.
        d = dot(v, v) / (dot(v, t) + root) if dot(v, t) > 0 else (root - dot(v, t)) / spread
    else:
        along = dot(v, end_tangent)
        if along <= 0.0:
            return None
        d = dot(v, v) / (4 * along)
    if not d > 0.0:
        return None
    a = (start[0] + d * start_tangent[0], start[1] + d * start_tangent[1])
    b = (end[0] - d * end_tangent[0], end[1] - d * end_tangent[1])
    joint = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
    first = _arc_from_tangent(start, start_tangent, joint)
    back = _arc_from_tangent(end, (-end_tangent[0], -end_tangent[1]), joint)
    if first is None or back is None:
        return None
    return first, back.reversed()


def _arc_from_tangent(start: Point, tangent: Point, end: Point) -> Line | Arc | None:
    """The arc that leaves `start` along `tangent` and ends in `end`; a line if it is straight."""
    chord = (end[0] - start[0], end[1] - start[1])
    size = hypot(*chord)
    side, ahead = cross(tangent, chord), dot(tangent, chord)
    if size == 0.0 or ahead <= 0.0:
        return None
    if abs(side) <= 1e-9 * size:
        return Line(start, end)
    # Chord and tangent enclose half the sweep; radius = chord / (2 sin(sweep / 2)).
    radius = size * size / (2 * side)
    centre = (start[0] - radius * tangent[1], start[1] + radius * tangent[0])
    sweep = 2 * degrees(atan2(side, ahead))
    return Arc(
        centre, abs(radius), direction_deg((start[0] - centre[0], start[1] - centre[1])), sweep
    )


def _arc_through_three(a: Point, m: Point, b: Point) -> Arc | None:
    """The arc from `a` over `m` to `b`; None if they lie on a line or two of them are one."""
    u, w = (m[0] - a[0], m[1] - a[1]), (b[0] - a[0], b[1] - a[1])
    area = 2 * cross(u, w)
    if abs(area) <= 1e-9 * (dot(u, u) + dot(w, w)):
        return None
    uu, ww = dot(u, u), dot(w, w)
    centre = (a[0] + (w[1] * uu - u[1] * ww) / area, a[1] + (u[0] * ww - w[0] * uu) / area)
    return arc_between(a, b, centre, area)


def _distance_from_arc(curve: Bezier | EllipseArc, arc: Arc) -> float:
    return SAMPLE_MARGIN * max(
        abs(distance(curve.point(k / SAMPLES), arc.centre) - arc.radius) for k in range(SAMPLES + 1)
    )


def _distance_from_line(samples: Sequence[Point], a: Point, b: Point) -> float:
    chord = (b[0] - a[0], b[1] - a[1])
    size = hypot(*chord)
    worst = 0.0
    for x, y in samples:
        from_a = (x - a[0], y - a[1])
        if size == 0.0:
            worst = max(worst, hypot(*from_a))
            continue
        along = dot(chord, from_a) / size
        beyond = max(0.0, -along, along - size)
        worst = max(worst, hypot(cross(chord, from_a) / size, beyond))
    return SAMPLE_MARGIN * worst


def _distance_to(part: Line | Arc, point: Point) -> float:
    near = min(distance(point, part.start), distance(point, part.end))
    if isinstance(part, Line):
        chord = (part.end[0] - part.start[0], part.end[1] - part.start[1])
        rest = (point[0] - part.start[0], point[1] - part.start[1])
        share = dot(chord, rest) / dot(chord, chord)
        return abs(cross(chord, rest)) / hypot(*chord) if 0.0 <= share <= 1.0 else near
    angle = direction_deg((point[0] - part.centre[0], point[1] - part.centre[1]))
    turned = (angle - part.start_deg) if part.sweep_deg > 0 else (part.start_deg - angle)
    if turned % 360.0 <= abs(part.sweep_deg):
        return abs(distance(point, part.centre) - part.radius)
    return near


def _runs_along(curve: Bezier, arc: Arc) -> bool:
    """Whether the curve runs once round the arc's way, never back: its samples turn onward."""
    sign = 1.0 if arc.sweep_deg > 0 else -1.0
    turned = 0.0
    before = curve.start
    for k in range(1, SAMPLES + 1):
        point = curve.point(k / SAMPLES)
        a = (before[0] - arc.centre[0], before[1] - arc.centre[1])
        b = (point[0] - arc.centre[0], point[1] - arc.centre[1])
        step = sign * degrees(atan2(cross(a, b), dot(a, b)))
        if step <= 0.0:
            return False
        turned += step
        before = point
    return abs(turned - abs(arc.sweep_deg)) < 1.0


def fit_path(curves: Sequence[Curve], tolerance: float) -> ArcFit:
    """A chain as lines and arcs: single arcs where free curves are arcs in disguise, neighbours
    on one circle merged, biarcs for the rest. Lines and arcs stay as they are.

    Raises ValueError if the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    parts: list[Line | Arc] = []
    worst = 0.0
    run: list[tuple[Bezier, Arc, float]] = []

    def finish() -> None:
        nonlocal worst
        for arc, off in _merge_run(run, tolerance):
            parts.append(arc)
            worst = max(worst, off)
        run.clear()

    for curve in curves:
        if isinstance(curve, Line | Arc):
            finish()
            parts.append(curve)
            continue
        pieces = (curve,) if isinstance(curve, EllipseArc) else bezier_pieces(curve)
        for piece in pieces:
            single = fit_single_arc(piece, tolerance) if isinstance(piece, Bezier) else None
            if single is not None and isinstance(piece, Bezier):
                (arc,) = single.curves
                assert isinstance(arc, Arc)
                run.append((piece, arc, single.deviation))
                continue
            finish()
            fit = fit_arcs(piece, tolerance)
            parts.extend(fit.curves)
            worst = max(worst, fit.deviation)
    finish()
    return ArcFit(tuple(parts), worst)


def _merge_run(run: list[tuple[Bezier, Arc, float]], tolerance: float) -> list[tuple[Arc, float]]:
    """Arcs of neighbours that lie on one circle, joined; each keeps the curves' ends."""
    found: list[tuple[Arc, float]] = []
    k = 0
    while k < len(run):
        group, arc, off = [run[k][0]], run[k][1], run[k][2]
        while k + 1 < len(run):
            wider = _merged(group, arc, *run[k + 1][:2], tolerance)
            if wider is None:
                break
            arc, off = wider[0], max(off, wider[1])
            group.append(run[k + 1][0])
            k += 1
        found.append((arc, off))
        k += 1
    return found


def _merged(
    group: list[Bezier], arc: Arc, piece: Bezier, other: Arc, tolerance: float
) -> tuple[Arc, float] | None:
    slack = max(tolerance, KAPPA_ERROR * arc.radius)
    same = distance(arc.centre, other.centre) <= 2 * slack
    same = same and abs(arc.radius - other.radius) <= 2 * slack
    sweep = arc.sweep_deg + other.sweep_deg
    if not same or arc.sweep_deg * other.sweep_deg < 0 or abs(sweep) > 360.5:
        return None
    centre = (
        (arc.centre[0] + other.centre[0]) / 2,
        (arc.centre[1] + other.centre[1]) / 2,
    )
    if distance(group[0].start, piece.end) <= 1e-9 * arc.radius:
        radius = distance(centre, piece.end)
        start_deg = direction_deg((piece.end[0] - centre[0], piece.end[1] - centre[1]))
        wide = Arc(centre, radius, start_deg, 360.0 if sweep > 0 else -360.0)
    else:
        found = _arc_through_three(group[0].start, group[-1].end, piece.end)
        if found is None or abs(found.sweep_deg - sweep) > 1.0:
            return None
        wide = found
    off = max(_distance_from_arc(c, wide) for c in (*group, piece))
    return (wide, off) if off <= slack else None
