"""Arcs for free curves, all those of a drawing at once.

A controller that knows arcs makes in one block what takes many chords; most cubics of drawing
programs are arcs in disguise. They become those arcs, neighbours on one circle become one, and the
rest becomes pairs of arcs with one tangent at their joint. Curves that are not cubics are followed
by cubics first.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, repeat
from math import atan2, ceil, cos, degrees, radians, sin, tan
from typing import cast

import numpy as np
from msgspec import Struct

from beamcam.geometry.arrays import cubics_of, rows
from beamcam.geometry.biarcs import BASIS, MARGIN, MAX_HALVINGS, allowed_off, fit_cubics
from beamcam.geometry.conics import arc_by_points
from beamcam.geometry.curves import Arc, Bezier, Curve, EllipseArc, Line, bezier_pieces
from beamcam.geometry.plane import Point, distance

Cubic = Sequence[Point]  #: four control points

#: Greatest sweep of a cubic that stands for a stretch of an ellipse: off by 1.3e-7 of its size.
ELLIPSE_STEP_DEG = 22.5

#: Of the tolerance, for cubics that stand for curves of other kinds, measured at so many places.
CUBIC_SHARE = 0.01
PROBES = 8


def fit_chains(chains: Sequence[Sequence[Curve]], tolerance: float) -> list[tuple[Line | Arc, ...]]:
    """Each chain of curves as lines and arcs within `tolerance`.

    A cubic that a drawing program wrote for an arc misses it by 2.7e-4 of the radius: it becomes
    the arc where that is no more than `WHOLE` times the tolerance.

    Raises ValueError if the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    # A Bezier curve that ends where it begins in two: it may go out and back on one line.
    chains = [
        [
            half
            for one in chain
            for half in (
                one.split(0.5) if isinstance(one, Bezier) and one.start == one.end else (one,)
            )
        ]
        for chain in chains
    ]
    free = [c for chain in chains for c in chain if not isinstance(c, Line | Arc)]
    if not free:
        return [tuple(chain) for chain in chains]  # type: ignore[arg-type]
    fits = iter(_fits(free, tolerance))
    return [_assembled(chain, fits, tolerance) for chain in chains]


class _Fit(Struct, frozen=True):
    """Lines and arcs that replace a free curve, in its direction."""

    curves: list[Line | Arc]
    #: For each that is an arc for the whole of a cubic its control points, else None; nothing at
    #: all if there is no such arc.
    cubics: list[Cubic | None]


def _fits(free: Sequence[Curve], tolerance: float) -> list[_Fit]:
    control, owner, others = cubics_of(free)
    more: list[Cubic] = []
    more_owner: list[int] = []
    for k in others:
        pieces = _as_cubics(free[k], CUBIC_SHARE * tolerance)
        more += pieces
        more_owner += [k] * len(pieces)
    more_points = [point for cubic in more for point in cubic]
    control = np.concatenate((control, rows(more_points, 2).reshape(-1, 4, 2)))
    owner = np.concatenate((owner, np.array(more_owner, dtype=np.int64)))
    order = np.argsort(owner, kind="stable")
    control, owner = control[order], owner[order]
    strokes = fit_cubics(control, tolerance)
    curves = strokes.curves()
    begins = np.searchsorted(owner[strokes.cubic], np.arange(len(free) + 1))
    # Arcs for whole cubics so far, so that most curves are seen to have none.
    wholes = np.concatenate(([0], np.cumsum(strokes.single)))[begins].tolist()
    begin = begins.tolist()
    fits: list[_Fit] = []
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
        fits.append(_Fit(curves[stretch], cubics))
    return fits


def _as_cubics(curve: Curve, tolerance: float) -> list[Cubic]:
    """A free curve as control points of cubics; rational ones and others within a tolerance."""
    if isinstance(curve, EllipseArc):
        count = max(1, ceil(abs(curve.sweep_deg) / ELLIPSE_STEP_DEG))
        step = radians(curve.sweep_deg) / count
        handle = 4 / 3 * tan(step / 4)
        (cx, cy), (ax, ay), ratio = curve.centre, curve.axis, curve.ratio

        def at(u: float, v: float) -> Point:
            return cx + u * ax - ratio * v * ay, cy + u * ay + ratio * v * ax

        ellipse_cubics: list[Cubic] = []
        for k in range(count):
            a, b = radians(curve.start_deg) + k * step, radians(curve.start_deg) + (k + 1) * step
            ellipse_cubics.append(
                (
                    curve.start if k == 0 else at(cos(a), sin(a)),
                    at(cos(a) - handle * sin(a), sin(a) + handle * cos(a)),
                    at(cos(b) + handle * sin(b), sin(b) - handle * cos(b)),
                    curve.end if k == count - 1 else at(cos(b), sin(b)),
                )
            )
        return ellipse_cubics
    assert not isinstance(curve, Line | Arc)
    cubics: list[Cubic] = []
    for piece in bezier_pieces(curve):
        if piece.weights is not None or piece.degree not in (1, 2, 3):
            cubics += _followed(piece, tolerance)
        elif piece.degree == 1:
            (start, end) = piece.points
            cubics.append((start, start, end, end))
        elif piece.degree == 3:
            cubics.append(piece.points)
        else:
            (x0, y0), (x1, y1), (x2, y2) = piece.points
            first = x0 + 2 * (x1 - x0) / 3, y0 + 2 * (y1 - y0) / 3
            second = x2 + 2 * (x1 - x2) / 3, y2 + 2 * (y1 - y2) / 3
            cubics.append(((x0, y0), first, second, (x2, y2)))
    return cubics


def _followed(curve: Bezier, tolerance: float) -> list[Cubic]:
    """Cubics with the curve's own ends and derivatives, halved until they are near enough.

    The error of a stretch falls with the fourth power of its length.
    """
    cubics: list[Cubic] = []

    def follow(low: float, high: float, halvings: int) -> None:
        (start, leaving, _), (end, coming, _) = curve.derivatives(low), curve.derivatives(high)
        third = (high - low) / 3
        cubic = (
            start,
            (start[0] + third * leaving[0], start[1] + third * leaving[1]),
            (end[0] - third * coming[0], end[1] - third * coming[1]),
            end,
        )
        drawn = Bezier(cubic)
        probes = (k / PROBES for k in range(1, PROBES))
        off = max(distance(drawn.point(t), curve.point(low + t * (high - low))) for t in probes)
        if off <= tolerance or halvings == 0:
            cubics.append(cubic)
            return
        middle = (low + high) / 2
        follow(low, middle, halvings - 1)
        follow(middle, high, halvings - 1)

    follow(0.0, 1.0, MAX_HALVINGS)
    return cubics


_Run = Sequence[tuple[Arc, Cubic]]  #: arcs that follow one another, each for a cubic


def _assembled(
    chain: Sequence[Curve], fits: Iterator[_Fit], tolerance: float
) -> tuple[Line | Arc, ...]:
    """A chain as lines and arcs, neighbours on one circle joined."""
    parts: list[tuple[Line | Arc, Cubic | None]] = []
    for curve in chain:
        if isinstance(curve, Line | Arc):
            parts.append((curve, None))
        else:
            fit = next(fits)
            parts += zip(fit.curves, fit.cubics or repeat(None), strict=False)
    curves: list[Line | Arc] = []
    for is_whole, run in groupby(parts, lambda part: part[1] is not None):
        if is_whole:
            curves += _merged_run(cast("Iterator[tuple[Arc, Cubic]]", run), tolerance)
        else:
            curves += [curve for curve, _ in run]
    return tuple(curves)


def _merged_run(run: Iterable[tuple[Arc, Cubic]], tolerance: float) -> list[Arc]:
    """Single arcs that follow one another, those on one circle as one."""
    arcs: list[Arc] = []
    group: list[tuple[Arc, Cubic]] = []
    for single in run:
        wider = _wider(arcs[-1], group, single, tolerance) if group else None
        if wider is None:
            arcs.append(single[0])
            group = [single]
        else:
            arcs[-1] = wider
            group.append(single)
    return arcs


def _wider(arc: Arc, group: _Run, following: tuple[Arc, Cubic], tolerance: float) -> Arc | None:
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
        through = arc_by_points(start, middle, end)
        if through is None or abs(through.sweep_deg - sweep) > 1.0:
            return None
        wide = through
    shapes = np.array([(a.radius, abs(radians(a.sweep_deg))) for a, _ in members])
    allowed = float(allowed_off(shapes[:, 0], shapes[:, 1], tolerance).max())
    for _, points in members:
        samples = np.einsum("ks,kd->sd", BASIS, np.array(points))
        off = np.abs(np.hypot(*(samples - np.array(wide.centre)).T) - wide.radius)
        if MARGIN * float(np.max(off)) > allowed:
            return None
    return wide
