"""Arcs for all free curves of a drawing at once.

The same as `fitting.fit_path` in arrays: what is an arc in disguise becomes that arc, neighbours
on one circle become one, and the rest becomes pairs of arcs with one tangent at their joint.
"""

from collections.abc import Iterator, Sequence
from itertools import chain as concatenated
from math import atan2, ceil, cos, degrees, radians, sin, tan

import numpy as np
from msgspec import Struct

from beamcam.geometry.arrays import rows
from beamcam.geometry.biarcs import BASIS, MARGIN, fit_cubics
from beamcam.geometry.conics import arc_between
from beamcam.geometry.cubics import cubics_of
from beamcam.geometry.curves import Arc, Bezier, Curve, EllipseArc, Line, bezier_pieces
from beamcam.geometry.fitting import fit_path, known_error
from beamcam.geometry.plane import Point, distance

Cubic = Sequence[Point]  #: four control points

#: Greatest sweep of a cubic that stands for a stretch of an ellipse: off by 1.3e-7 of its size.
ELLIPSE_STEP_DEG = 22.5


def fit_chains(chains: Sequence[Sequence[Curve]], tolerance: float) -> list[tuple[Line | Arc, ...]]:
    """Each chain of curves as lines and arcs within `tolerance`.

    A cubic that a drawing program wrote for an arc becomes the arc, though it misses it by up to
    2.7e-4 of the radius. Raises ValueError if the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    chains = [[half for curve in chain for half in _open_halves(curve)] for chain in chains]
    free = [c for chain in chains for c in chain if not isinstance(c, Line | Arc)]
    if not free:
        return [tuple(chain) for chain in chains]  # type: ignore[arg-type]
    fits = iter(_fits(free, tolerance))
    return [_assembled(chain, fits, tolerance) for chain in chains]


def _open_halves(curve: Curve) -> tuple[Curve, ...]:
    """A Bezier curve that ends where it begins in two: it may go out and back on one line."""
    if isinstance(curve, Bezier) and curve.start == curve.end:
        return curve.split(0.5)
    return (curve,)


class _Fit(Struct, frozen=True):
    """Lines and arcs that stand for a free curve, in its direction."""

    curves: list[Line | Arc]
    #: For each that is an arc for the whole of a cubic its control points, else None; nothing at
    #: all if there is no such arc.
    cubics: list[Cubic | None]


def _fits(free: Sequence[Curve], tolerance: float) -> list[_Fit]:
    """What stands for each of the free curves."""
    control, owner, others = cubics_of(free)
    more: list[Sequence[Point]] = []
    more_owner: list[int] = []
    alone: dict[int, _Fit] = {}
    for k in others:
        pieces = _as_cubics(free[k])
        if pieces is None:
            alone[k] = _Fit(list(fit_path((free[k],), tolerance).curves), [])
        else:
            more += pieces
            more_owner += [k] * len(pieces)
    points = rows(concatenated.from_iterable(more), 8).reshape(-1, 4, 2)
    control = np.concatenate((control, points))
    owner = np.concatenate((owner, np.array(more_owner, dtype=np.int64)))
    order = np.argsort(owner, kind="stable")
    control, owner = control[order], owner[order]
    strokes = fit_cubics(control, tolerance)
    curves = strokes.curves()
    begins = np.searchsorted(owner[strokes.cubic], np.arange(len(free) + 1))
    # Arcs for whole cubics so far, so that most curves are seen to have none.
    wholes = np.concatenate(([0], np.cumsum(strokes.single)))[begins].tolist()
    begin = begins.tolist()
    found: list[_Fit] = []
    for k in range(len(free)):
        stretch = slice(begin[k], begin[k + 1])
        cubics: list[Cubic | None] = []
        if wholes[k + 1] > wholes[k]:
            cubics = [
                [(x, y) for x, y in control[cubic].tolist()] if single else None
                for cubic, single in zip(
                    strokes.cubic[stretch].tolist(), strokes.single[stretch].tolist(), strict=True
                )
            ]
        found.append(alone[k] if k in alone else _Fit(curves[stretch], cubics))
    return found


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


_Run = Sequence[tuple[Arc, Cubic]]  #: arcs that follow one another, each for a cubic


def _assembled(
    chain: Sequence[Curve], fits: Iterator[_Fit], tolerance: float
) -> tuple[Line | Arc, ...]:
    """A chain as lines and arcs, neighbours on one circle joined."""
    found: list[Line | Arc] = []
    run: list[tuple[Arc, Cubic]] = []

    def finish() -> None:
        if run:
            found.extend(_merged_run(run, tolerance))
            run.clear()

    for curve in chain:
        if isinstance(curve, Line | Arc):
            finish()
            found.append(curve)
            continue
        fit = next(fits)
        if not fit.cubics:
            finish()
            found += fit.curves
            continue
        for part, cubic in zip(fit.curves, fit.cubics, strict=True):
            if cubic is not None and isinstance(part, Arc):
                run.append((part, cubic))
            else:
                finish()
                found.append(part)
    finish()
    return tuple(found)


def _merged_run(run: _Run, tolerance: float) -> list[Line | Arc]:
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
    group: _Run,
    following: tuple[Arc, Cubic],
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
        samples = np.einsum("ks,kd->sd", BASIS, np.array(points))
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
