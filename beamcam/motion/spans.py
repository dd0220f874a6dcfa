"""Subdivision of curves, so that their chords stay within a tolerance.

A span is a stretch of a curve that is drawn in equal steps of its parameter. For each span this
module finds the number of steps and a bound on the distance between curve and chords.
"""

from math import asin, ceil, pi, sqrt

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.caches import cached
from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.conics import Arc, EllipseArc

#: No step of an arc turns further, whatever the tolerance.
MAX_STEP_RAD = pi / 2

#: A share of a step that rounding may add to a sweep without costing a point.
COUNT_SLACK = 1e-9


def chord_step_rad(radius: float, tolerance: float) -> float:
    """Largest angle between points of an arc whose chords stay within `tolerance`, in radians.

    The chord of a step t lies radius (1 - cos(t / 2)) from the arc (the sagitta), which is
    2 radius sin^2(t / 4), so t = 4 asin(sqrt(tolerance / (2 radius))): the usual
    2 acos(1 - tolerance / radius) without its loss of digits. Never above 90 degrees.
    Raises ValueError if radius or tolerance is not positive.
    """
    if not (radius > 0.0 and tolerance > 0.0):
        raise ValueError(f"radius {radius:g} and tolerance {tolerance:g} must be above 0")
    share = tolerance / (2 * radius)
    return min(MAX_STEP_RAD, 4 * asin(sqrt(share))) if share < 1.0 else MAX_STEP_RAD


def sagitta(radius: float, step_rad: float) -> float:
    """Distance between an arc of `step_rad` and its chord."""
    return float(2 * radius * np.sin(step_rad / 4) ** 2)


class ArcSpan(Struct, frozen=True):
    """Equal steps over centre + cos(p) u + sin(p) v."""

    centre: tuple[float, float]
    u: tuple[float, float]
    v: tuple[float, float]
    start_deg: float
    sweep_deg: float
    end: tuple[float, float]
    steps: int
    deviation: float


def span_arc(curve: Arc | EllipseArc, tolerance: float) -> ArcSpan:
    """An arc as one span.

    An ellipse is the image of a circle, stretched by no more than its major half axis: so that
    stands for the radius.
    """
    if isinstance(curve, Arc):
        radius, u, v = curve.radius, (curve.radius, 0.0), (0.0, curve.radius)
    else:
        (ax, ay), r = curve.axis, curve.ratio
        radius, u, v = max(curve.major, curve.minor), (ax, ay), (-r * ay, r * ax)
    step = np.degrees(chord_step_rad(radius, tolerance))
    sweep = curve.sweep_deg
    steps = max(1, ceil(abs(sweep) / step - COUNT_SLACK))
    deviation = sagitta(radius, float(np.radians(abs(sweep))) / steps)
    return ArcSpan(curve.centre, u, v, curve.start_deg, sweep, curve.end, steps, deviation)


@cached("curves.division")
def _division(degree: int, parts: int) -> Floats:
    """Matrices (parts, degree + 1, degree + 1) from control points to those of equal parts."""
    division = np.empty((parts, degree + 1, degree + 1))
    for k in range(parts):
        a, b = k / parts, (k + 1) / parts
        for i in range(degree + 1):
            # Control point i of [a, b] is the blossom at i times b and the rest a.
            row = np.eye(degree + 1)
            for r in range(degree):
                at = b if r < i else a
                row = row[:-1] + at * (row[1:] - row[:-1])
            division[k, i] = row[0]
    return division


def divided(control: Floats, parts: int) -> Floats:
    """Homogeneous control points (m, d + 1, 3) of curves cut in equal parts: (m parts, d + 1, 3).

    The ends of the curves stay as they are, to the last bit.
    """
    if parts == 1:
        return control
    degree = control.shape[1] - 1
    fine: Floats = np.einsum("kij,mjc->mkic", _division(degree, parts), control)
    fine[:, 1:, 0] = fine[:, :-1, degree]
    fine[:, 0, 0] = control[:, 0]
    fine[:, -1, degree] = control[:, -1]
    return fine.reshape(-1, degree + 1, 3)


def bend_bounds(control: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """For curves (m, d + 1, 3): a bound B on how they bend, and whether they run on smoothly.

    n equal steps stay within B / (8 n^2) of the curve. In general B is the greatest second
    derivative. A curve without weights whose control legs all run along its chord is better
    off: with x along the chord, B = max |y''| + slope max |x''|, because error along the chord
    is none. Control points enclose all of these. The second answer says that no leg turns away
    from the chord by more than 45 degrees.
    Source of the general bound: Wang, "The subdivision method for finding the intersection
    between two Bezier curves", 1984.
    """
    degree = control.shape[1] - 1
    if degree < 2:
        return np.zeros(len(control)), np.ones(len(control), dtype=bool)
    weight = control[..., 2:]
    points = control[..., :2] / weight
    legs = np.diff(points, axis=1)
    chord = points[:, -1] - points[:, 0]
    size = np.hypot(chord[:, 0], chord[:, 1])
    along = chord / np.where(size > 0.0, size, 1.0)[:, None]
    beside = np.stack((-along[:, 1], along[:, 0]), axis=-1)
    forward = np.einsum("mic,mc->mi", legs, along)
    sideways = np.abs(np.einsum("mic,mc->mi", legs, beside))
    smooth = np.asarray((size > 0.0) & np.all((forward > 0.0) & (sideways <= forward), axis=1))
    if np.all(control[..., 2] == 1.0):
        bend = degree * (degree - 1) * np.diff(legs, axis=1)
        general = np.max(np.hypot(bend[..., 0], bend[..., 1]), axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.max(sideways / forward, axis=1)
            local = np.max(np.abs(np.einsum("mic,mc->mi", bend, beside)), axis=1)
            local = local + slope * np.max(np.abs(np.einsum("mic,mc->mi", bend, along)), axis=1)
        return np.where(smooth, np.minimum(local, general), general), smooth
    return _rational_bend(control), smooth


def _rational_bend(control: Floats) -> Floats:
    """Bound on the second derivative of r = c + X / W, with X taken about a point c near r.

    r' = (X' - (r - c) W') / W and r'' = (X'' - 2 r' W' - (r - c) W'') / W, each term bounded by
    the control points.
    """
    degree = control.shape[1] - 1
    weight = control[..., 2]
    about = control[:, 0, :2] / weight[:, :1]
    about = (about + control[:, -1, :2] / weight[:, -1:]) / 2
    lifted = control[..., :2] - about[:, None, :] * weight[..., None]

    def greatest(rows: Floats) -> Floats:
        return np.asarray(np.max(np.hypot(rows[..., 0], rows[..., 1]), axis=1))

    least = np.min(weight, axis=1)
    reach = greatest(lifted / weight[..., None])
    first, second = degree, degree * (degree - 1)
    w1 = first * np.max(np.abs(np.diff(weight, axis=1)), axis=1)
    w2 = second * np.max(np.abs(np.diff(weight, n=2, axis=1)), axis=1)
    speed = (first * greatest(np.diff(lifted, axis=1)) + reach * w1) / least
    bend = second * greatest(np.diff(lifted, n=2, axis=1))
    return np.asarray((bend + 2 * speed * w1 + reach * w2) / least)


def step_counts(bend: Floats, smooth: NDArray[np.bool_], tolerance: float) -> Counts:
    """Steps for curves of bend B: the least n with B / (8 n^2) <= tolerance.

    Where a curve turns back on itself there are at least 4, so that none is jumped over.
    """
    n = np.ceil(np.sqrt(bend / (8 * tolerance)) - COUNT_SLACK)
    return np.maximum(n, np.where(smooth, 1, 4)).astype(np.int64)


def parts_for(counts: Counts, smooth: NDArray[np.bool_]) -> Counts:
    """Number of parts, each with its own step size, of each curve: 1 to 16, powers of two.

    Short steps where the curve is sharp then do not cost points where it is nearly straight.
    """
    wished = np.where(counts <= 2, 1, np.where(counts <= 8, 4, np.where(counts <= 64, 8, 16)))
    return np.asarray(np.where(smooth, wished, np.maximum(wished, 4)), dtype=np.int64)
