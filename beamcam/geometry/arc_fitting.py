"""Arcs for all free curves of a drawing at once.

The same as `fitting.fit_path` in arrays: what is an arc in disguise becomes that arc, neighbours
on one circle become one, and the rest becomes pairs of arcs with one tangent at their joint, in
pieces that are halved until no sample lies farther off than the tolerance.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, ceil, cos, degrees, radians, sin, tan

import numpy as np
from numpy.typing import NDArray

from beamcam.geometry.conics import arc_between
from beamcam.geometry.curves import Arc, Bezier, Curve, EllipseArc, Line, bezier_pieces
from beamcam.geometry.fitting import WIDEST_KNOWN_DEG, fit_path, known_error
from beamcam.geometry.plane import Point, distance

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Counts = NDArray[np.int64]

SAMPLES = 16
#: The greatest deviation is looked for at `SAMPLES` places; between them it may be this larger.
MARGIN = 1.1
MAX_HALVINGS = 16
#: Greatest sweep of a cubic that stands for a stretch of an ellipse: off by 1.3e-7 of its size.
ELLIPSE_STEP_DEG = 22.5

_T = (np.arange(SAMPLES) + 0.5) / SAMPLES
_BASIS = np.stack([(1 - _T) ** 3, 3 * _T * (1 - _T) ** 2, 3 * _T**2 * (1 - _T), _T**3])


@dataclass(frozen=True, slots=True)
class _Part:
    """A line or arc that stands for a stretch of cubic number `cubic`."""

    cubic: int
    curve: Line | Arc
    single: bool  #: whether it stands for the whole of the cubic, being that arc


def fit_chains(chains: Sequence[Sequence[Curve]], tolerance: float) -> list[tuple[Line | Arc, ...]]:
    """Each chain of curves as lines and arcs within `tolerance`.

    A cubic that a drawing program wrote for an arc becomes the arc, though it misses it by up to
    2.7e-4 of the radius. Raises ValueError if the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    plan: list[list[Line | Arc | int]] = []
    cubics: list[Sequence[Point]] = []
    for chain in chains:
        steps: list[Line | Arc | int] = []
        for curve in chain:
            if isinstance(curve, Line | Arc):
                steps.append(curve)
                continue
            pieces = _as_cubics(curve)
            if pieces is None:
                steps += fit_path((curve,), tolerance).curves
                continue
            for points in pieces:
                steps.append(len(cubics))
                cubics.append(points)
        plan.append(steps)
    parts = _fit(np.array(cubics).reshape(-1, 4, 2), tolerance)
    by_cubic: dict[int, list[_Part]] = {}
    for part in parts:
        by_cubic.setdefault(part.cubic, []).append(part)
    return [_assembled(steps, by_cubic, cubics, tolerance) for steps in plan]


def _as_cubics(curve: Curve) -> list[Sequence[Point]] | None:
    """A curve as control points of cubics; None for rational ones and those of other degrees."""
    if isinstance(curve, EllipseArc):
        return _ellipse_cubics(curve)
    if isinstance(curve, Line | Arc):
        return None
    found: list[Sequence[Point]] = []
    for piece in bezier_pieces(curve):
        if piece.weights is not None or piece.degree not in (2, 3):
            return None
        found.append(piece.points if piece.degree == 3 else _raised(piece))
    return found


def _raised(curve: Bezier) -> Sequence[Point]:
    """The control points of a parabola as a cubic."""
    (x0, y0), (x1, y1), (x2, y2) = curve.points
    return (
        (x0, y0),
        (x0 + 2 * (x1 - x0) / 3, y0 + 2 * (y1 - y0) / 3),
        (x2 + 2 * (x1 - x2) / 3, y2 + 2 * (y1 - y2) / 3),
        (x2, y2),
    )


def _ellipse_cubics(ellipse: EllipseArc) -> list[Sequence[Point]]:
    """An ellipse as cubics: those of a circle, handles 4/3 tan(step / 4), stretched."""
    count = max(1, ceil(abs(ellipse.sweep_deg) / ELLIPSE_STEP_DEG))
    step = radians(ellipse.sweep_deg) / count
    handle = 4 / 3 * tan(step / 4)
    (cx, cy), (ax, ay), ratio = ellipse.centre, ellipse.axis, ellipse.ratio

    def at(u: float, v: float) -> Point:
        return cx + u * ax - ratio * v * ay, cy + u * ay + ratio * v * ax

    found: list[Sequence[Point]] = []
    for k in range(count):
        a, b = radians(ellipse.start_deg) + k * step, radians(ellipse.start_deg) + (k + 1) * step
        found.append(
            (
                ellipse.start if k == 0 else at(cos(a), sin(a)),
                at(cos(a) - handle * sin(a), sin(a) + handle * cos(a)),
                at(cos(b) + handle * sin(b), sin(b) - handle * cos(b)),
                ellipse.end if k == count - 1 else at(cos(b), sin(b)),
            )
        )
    return found


def _fit(control: Floats, tolerance: float) -> list[_Part]:
    """Lines and arcs for cubics (n, 4, 2), in their order."""
    found: list[tuple[int, float, _Part]] = []
    owner, begin, size = np.arange(len(control)), np.zeros(len(control)), np.ones(len(control))
    singles = _singles(control, tolerance)
    for k, arc in singles.items():
        found.append((k, 0.0, _Part(k, arc, True)))
    left = np.array([k not in singles for k in range(len(control))], dtype=bool)
    control, owner, begin, size = control[left], owner[left], begin[left], size[left]
    for halving in range(MAX_HALVINGS + 1):
        if not len(control):
            break
        flat = _is_flat(control, tolerance / 8)
        if halving == MAX_HALVINGS:
            flat[:] = True
        good, joints, bends = _biarcs(control, tolerance)
        good &= ~flat
        for k in np.flatnonzero(flat).tolist():
            line = Line(_point(control[k, 0]), _point(control[k, 3]))
            if line.start != line.end:
                found.append((int(owner[k]), float(begin[k]), _Part(int(owner[k]), line, False)))
        for k in np.flatnonzero(good).tolist():
            a, joint, b = (_point(p) for p in (control[k, 0], joints[k], control[k, 3]))
            number, at = int(owner[k]), float(begin[k])
            first, second = _curve(a, joint, bends[k, 0]), _curve(joint, b, bends[k, 1])
            found.append((number, at, _Part(number, first, False)))
            found.append((number, at + float(size[k]) / 2, _Part(number, second, False)))
        rest = ~(flat | good)
        control, owner, begin, size = control[rest], owner[rest], begin[rest], size[rest] / 2
        first_half, second_half = _halved(control)
        control = np.concatenate((first_half, second_half))
        owner = np.concatenate((owner, owner))
        begin, size = np.concatenate((begin, begin + size)), np.concatenate((size, size))
    found.sort(key=lambda entry: entry[:2])
    return [part for _, _, part in found]


def _point(row: Floats) -> Point:
    return float(row[0]), float(row[1])


def _is_flat(control: Floats, tolerance: float) -> Flags:
    """Which cubics lie within the tolerance of their chord, controls between its ends."""
    chord = control[:, 3] - control[:, 0]
    size = np.hypot(chord[:, 0], chord[:, 1])
    safe = np.where(size > 0.0, size, 1.0)
    unit = chord / safe[:, None]
    flat = np.ones(len(control), dtype=bool)
    for k in (1, 2):
        rest = control[:, k] - control[:, 0]
        along = np.sum(unit * rest, axis=1)
        away = np.abs(unit[:, 0] * rest[:, 1] - unit[:, 1] * rest[:, 0])
        flat &= (away <= tolerance) & (along >= -tolerance) & (along <= size + tolerance)
    return flat


def _halved(control: Floats) -> tuple[Floats, Floats]:
    a, b, c, d = (control[:, k] for k in range(4))
    ab, bc, cd = (a + b) / 2, (b + c) / 2, (c + d) / 2
    abc, bcd = (ab + bc) / 2, (bc + cd) / 2
    middle = (abc + bcd) / 2
    return np.stack((a, ab, abc, middle), axis=1), np.stack((middle, bcd, cd, d), axis=1)


def _tangents(control: Floats) -> tuple[Floats, Floats]:
    """Directions at both ends: towards the first control point that is another one."""
    reach = np.max(np.abs(control - control[:, :1]), axis=(1, 2)) * 1e-9

    def direction(order: tuple[int, int, int, int]) -> Floats:
        found = np.zeros((len(control), 2))
        open_rows = np.ones(len(control), dtype=bool)
        for k in order[1:]:
            step = control[:, k] - control[:, order[0]]
            size = np.hypot(step[:, 0], step[:, 1])
            take = open_rows & (size > reach)
            found[take] = step[take] / size[take][:, None]
            open_rows &= ~take
        return found

    return direction((0, 1, 2, 3)), -direction((3, 2, 1, 0))


def _cross(a: Floats, b: Floats) -> Floats:
    found: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return found


def _biarcs(control: Floats, tolerance: float) -> tuple[Flags, Floats, Floats]:
    """For each cubic whether two arcs do, their joint (n, 2), and their curvatures (n, 2).

    Equal legs d: with v the chord, t the sum of both tangents and q = 2 (1 - t0.t1),
    d = v.v / (v.t + sqrt((v.t)^2 + q v.v)). Source: Bolton, "Biarc curves", 1975.
    """
    start, end = control[:, 0], control[:, 3]
    t0, t1 = _tangents(control)
    v = end - start
    vv, vt = np.sum(v * v, axis=1), np.sum(v * (t0 + t1), axis=1)
    q = 2 * (1 - np.sum(t0 * t1, axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        legs = vv / (vt + np.sqrt(vt * vt + q * vv))
        ahead = np.isfinite(legs) & (legs > 0.0) & (vt > 0.0)
        legs = np.where(ahead, legs, 0.0)
        joint = (start + legs[:, None] * t0 + end - legs[:, None] * t1) / 2
        one, two = joint - start, end - joint
        # Curvature of the arc that leaves p along t and ends in p + c: 2 cross(t, c) / c.c
        bend0 = 2 * _cross(t0, one) / np.sum(one * one, axis=1)
        bend1 = 2 * _cross(two, t1) / np.sum(two * two, axis=1)
        ahead &= (np.sum(one * t0, axis=1) > 0.0) & (np.sum(two * t1, axis=1) > 0.0)
        samples = np.einsum("ks,nkd->nsd", _BASIS, control)
        # The chord from p is turned by half the sweep, so the joint's tangent is t0 mirrored.
        unit = one / np.hypot(one[:, 0], one[:, 1])[:, None]
        at_joint = 2 * np.sum(unit * t0, axis=1)[:, None] * unit - t0
        before = np.sum((samples - joint[:, None]) * at_joint[:, None], axis=2) <= 0.0
        off0 = _off_circle(samples - start[:, None], t0, bend0)
        off1 = _off_circle(samples - end[:, None], t1, bend1)
    worst = MARGIN * np.max(np.where(before, np.abs(off0), np.abs(off1)), axis=1)
    worst = np.where(np.isfinite(worst), worst, np.inf)
    return ahead & (worst <= tolerance), joint, np.column_stack((bend0, bend1))


def _off_circle(u: Floats, tangent: Floats, bend: Floats) -> Floats:
    """Signed distance of points p + u (n, s, 2) from the circle through p with a tangent there.

    (k s - 2 a) / (1 + sqrt(1 - 2 a k + k^2 s)), a the offset to the left of the tangent, s = u.u:
    no centre is needed, so that a line is a circle as well.
    """
    a = tangent[:, None, 0] * u[..., 1] - tangent[:, None, 1] * u[..., 0]
    s = np.sum(u * u, axis=2)
    k = bend[:, None]
    found: Floats = (k * s - 2 * a) / (1 + np.sqrt(np.maximum(0.0, 1 - 2 * a * k + k * k * s)))
    return found


def _curve(start: Point, end: Point, bend: float) -> Line | Arc:
    """The arc of a curvature between two points, below half a circle; a line if it is straight."""
    chord = distance(start, end)
    if abs(bend) * chord < 1e-9:
        return Line(start, end)
    radius = 1 / abs(float(bend))
    half = chord / 2
    height = (max(0.0, radius * radius - half * half)) ** 0.5
    side = 1.0 if bend > 0 else -1.0
    ux, uy = (end[0] - start[0]) / chord, (end[1] - start[1]) / chord
    centre = (
        (start[0] + end[0]) / 2 - side * height * uy,
        (start[1] + end[1]) / 2 + side * height * ux,
    )
    return arc_between(start, end, centre, side)


def _singles(control: Floats, tolerance: float) -> dict[int, Arc]:
    """Those cubics that are one arc, by their number."""
    if not len(control):
        return {}
    start, end = control[:, 0], control[:, 3]
    middle = (start + 3 * control[:, 1] + 3 * control[:, 2] + end) / 8
    u, w = middle - start, end - start
    area = 2 * _cross(u, w)
    uu, ww = np.sum(u * u, axis=1), np.sum(w * w, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        bent = np.abs(area) > 1e-9 * (uu + ww)
        rise = np.stack((w[:, 1] * uu - u[:, 1] * ww, u[:, 0] * ww - w[:, 0] * uu), axis=1)
        centre = start + rise / area[:, None]
        radius = np.hypot(*(start - centre).T)
        samples = np.einsum("ks,nkd->nsd", _BASIS, control) - centre[:, None]
        off = MARGIN * np.max(
            np.abs(np.hypot(samples[..., 0], samples[..., 1]) - radius[:, None]), axis=1
        )
        turns = np.unwrap(np.arctan2(samples[..., 1], samples[..., 0]), axis=1)
        steps = np.diff(turns, axis=1) * np.where(area > 0, 1.0, -1.0)[:, None]
        sweep = np.abs(turns[:, -1] - turns[:, 0]) * SAMPLES / (SAMPLES - 1)
        # What the best cubic for an arc of that sweep misses it by: 4/27 sin^6 / cos^2 of sweep/4.
        known = radius * 4 / 27 * np.sin(sweep / 4) ** 6 / np.cos(sweep / 4) ** 2
        known[sweep > radians(WIDEST_KNOWN_DEG)] = 0.0
        allowed = np.maximum(tolerance, MARGIN * MARGIN * known)
        good = bent & (off <= allowed) & np.all(steps > 0.0, axis=1)
    return {
        k: arc_between(_point(start[k]), _point(end[k]), _point(centre[k]), float(area[k]))
        for k in np.flatnonzero(good).tolist()
    }


def _assembled(
    steps: Sequence[Line | Arc | int],
    by_cubic: dict[int, list[_Part]],
    cubics: Sequence[Sequence[Point]],
    tolerance: float,
) -> tuple[Line | Arc, ...]:
    """A chain of its lines, arcs and fitted cubics, neighbours on one circle joined."""
    found: list[Line | Arc] = []
    run: list[tuple[Arc, Sequence[Point]]] = []

    def finish() -> None:
        found.extend(_merged_run(run, tolerance))
        run.clear()

    for step in steps:
        if not isinstance(step, int):
            finish()
            found.append(step)
            continue
        for part in by_cubic.get(step, ()):
            if part.single and isinstance(part.curve, Arc):
                run.append((part.curve, cubics[step]))
            else:
                finish()
                found.append(part.curve)
    finish()
    return tuple(found)


def _merged_run(run: Sequence[tuple[Arc, Sequence[Point]]], tolerance: float) -> list[Line | Arc]:
    """Single arcs that follow one another, those on one circle as one."""
    found: list[Line | Arc] = []
    k = 0
    while k < len(run):
        arc, group = run[k][0], [run[k]]
        while k + 1 < len(run):
            wider = _wider(arc, group, run[k + 1], tolerance)
            if wider is None:
                break
            k += 1
            arc = wider
            group.append(run[k])
        found.append(arc)
        k += 1
    return found


def _wider(
    arc: Arc,
    group: Sequence[tuple[Arc, Sequence[Point]]],
    following: tuple[Arc, Sequence[Point]],
    tolerance: float,
) -> Arc | None:
    """The arc over a group of cubics and the next one; None if they are not on one circle."""
    other = following[0]
    slack = max(tolerance, 3e-4 * arc.radius)
    sweep = arc.sweep_deg + other.sweep_deg
    near = distance(arc.centre, other.centre) <= 2 * slack
    near = near and abs(arc.radius - other.radius) <= 2 * slack
    if not near or arc.sweep_deg * other.sweep_deg < 0 or abs(sweep) > 360.5:
        return None
    start, end = group[0][1][0], following[1][3]
    members = [*group, following]
    if distance(start, end) <= 1e-9 * arc.radius:
        total = sum(a.radius for a, _ in members)
        centre = (
            sum(a.centre[0] * a.radius for a, _ in members) / total,
            sum(a.centre[1] * a.radius for a, _ in members) / total,
        )
        turned = degrees(atan2(end[1] - centre[1], end[0] - centre[0]))
        wide = Arc(centre, distance(centre, end), turned, 360.0 if sweep > 0 else -360.0)
    else:
        middle = members[len(members) // 2][1][0]
        through = _through(start, middle, end)
        if through is None or abs(through.sweep_deg - sweep) > 1.0:
            return None
        wide = through
    allowed = max(tolerance, MARGIN * MARGIN * max(known_error(a) for a, _ in members))
    for _, points in members:
        samples = np.einsum("ks,kd->sd", _BASIS, np.array(points))
        off = np.abs(np.hypot(*(samples - np.array(wide.centre)).T) - wide.radius)
        if MARGIN * float(np.max(off)) > allowed:
            return None
    return wide


def _through(a: Point, m: Point, b: Point) -> Arc | None:
    """The arc from `a` over `m` to `b`; None if they lie on a line."""
    ux, uy, wx, wy = m[0] - a[0], m[1] - a[1], b[0] - a[0], b[1] - a[1]
    area = 2 * (ux * wy - uy * wx)
    uu, ww = ux * ux + uy * uy, wx * wx + wy * wy
    if abs(area) <= 1e-9 * (uu + ww):
        return None
    centre = (a[0] + (wy * uu - uy * ww) / area, a[1] + (ux * ww - wx * uu) / area)
    return arc_between(a, b, centre, area)
