"""Points of many B-splines at once, straight from their definition.

Nothing is taken apart into Bezier curves here: each point is found by de Boor's scheme, and how
close they lie follows from the second derivative, which is a B-spline itself.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from beamcam.geometry.curves import BSpline

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]

MOST_STEPS = 4096  #: of a span


def spans_of(spline: BSpline) -> int:
    """How many polynomials a spline is made of."""
    drawn = spline.knots[spline.degree : len(spline.control) + 1]
    return len(set(drawn)) - 1


def spline_points(splines: Sequence[BSpline], tolerance: float) -> list[Floats]:
    """Points (n, 2) along each spline without weights, no chord farther than `tolerance` off."""
    found: list[Floats] = [np.zeros((0, 2))] * len(splines)
    groups: dict[tuple[int, int], list[int]] = {}
    for k, spline in enumerate(splines):
        groups.setdefault((spline.degree, len(spline.control)), []).append(k)
    for (degree, _), members in groups.items():
        control = np.array([splines[k].control for k in members], dtype=np.float64)
        knots = np.array([splines[k].knots for k in members], dtype=np.float64)
        points, counts = _drawn(degree, control, knots, tolerance)
        for k, part in zip(members, np.split(points, np.cumsum(counts)[:-1]), strict=True):
            found[k] = part
    return found


def _drawn(degree: int, control: Floats, knots: Floats, tolerance: float) -> tuple[Floats, Counts]:
    """The points of splines with equally many control points (m, n, 2), and how many of each."""
    count = control.shape[1]
    low, high = knots[:, degree:count], knots[:, degree + 1 : count + 1]
    width = high - low
    # Chords of a step h leave a curve by h^2 / 8 of its second derivative at most.
    bend = _greatest_bend(degree, control, knots)
    steps = np.ceil(width * np.sqrt(bend / (8 * tolerance))).astype(np.int64)
    steps = np.where(width > 0.0, np.clip(steps, 1, MOST_STEPS), 0)
    flat = steps.ravel()
    owner = np.repeat(np.arange(flat.size), flat)
    number = np.arange(len(owner)) - (np.cumsum(flat) - flat)[owner]
    row, span = np.divmod(owner, steps.shape[1])
    at = low[row, span] + width[row, span] * (number / flat[owner])
    starts = _points(degree, control, knots, row, span + degree, at)
    last = np.array([np.flatnonzero(one)[-1] for one in steps])
    every = np.arange(len(control))
    ends = _points(degree, control, knots, every, last + degree, high[every, last])
    counts = steps.sum(axis=1)
    return np.insert(starts, np.cumsum(counts), ends, axis=0), counts + 1


def _greatest_bend(degree: int, control: Floats, knots: Floats) -> Floats:
    """A bound of the second derivative on each span of knots, (m, spans)."""
    spans = control.shape[1] - degree
    if degree < 2:
        return np.zeros((len(control), spans))
    values = control
    for order in (0, 1):
        left, right = knots[:, order + 1 : -degree - 1], knots[:, degree + 1 : -order - 1]
        gap = (right - left)[..., None]
        step = (degree - order) * np.diff(values, axis=1)
        # Where there is no gap no span lies, so that nothing depends on the value.
        values = np.divide(step, gap, out=np.zeros_like(step), where=gap > 0.0)
    sizes = np.hypot(values[..., 0], values[..., 1])
    windows = np.lib.stride_tricks.sliding_window_view(sizes, degree - 1, axis=1)
    found: Floats = windows.max(axis=2)
    return found


def _points(
    degree: int, control: Floats, knots: Floats, row: Counts, span: Counts, at: Floats
) -> Floats:
    """Points of splines `row` at parameters between knot `span` and the next, (n, 2).

    Source: de Boor, "On calculating with B-splines", 1972.
    """
    near = [control[row, span - degree + k] for k in range(degree + 1)]
    for level in range(1, degree + 1):
        for k in range(degree, level - 1, -1):
            first = span - degree + k
            low, high = knots[row, first], knots[row, first + degree + 1 - level]
            share = ((at - low) / (high - low))[:, None]
            near[k] = near[k - 1] + share * (near[k] - near[k - 1])
    return near[degree]
