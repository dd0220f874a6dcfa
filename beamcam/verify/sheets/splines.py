"""The polynomials of many B-splines at once, straight from their definition.

Nothing is taken apart into Bezier curves here: points are found by de Boor's scheme, and what
derivatives are at most follows from their control points, since they are B-splines themselves.
"""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct
from numpy.lib.stride_tricks import sliding_window_view

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.curves import Bezier, BSpline

SLOWEST = 1e-3  #: share of the maximum speed that counts as the speed of a span
TINY = 1e-30  #: for a span that is a point


class Spans(Struct, frozen=True):
    """The polynomials of curves of one degree p, curve by curve, without those of no width."""

    owner: Counts  #: the curve of each
    control: Floats  #: the control points that count for it, (n, p + 1, 2)
    knots: Floats  #: the p knots up to its start and the p from its end on, (n, 2 p)
    width: Floats

    def some(self, which: Counts | Flags) -> "Spans":
        """Some of them."""
        return Spans(*(getattr(self, name)[which] for name in self.__struct_fields__))


class Bounds(Struct, frozen=True):
    """What the derivatives f', f'', f''' of each span are, (n,)."""

    first: Floats  #: |f'| at most
    second: Floats  #: |f''| at most
    third: Floats  #: |f'''| at most
    stretch: Floats  #: |f' . f''| at most
    speed: Floats  #: |f'|, about
    bend: Floats  #: curvature in 1/mm, about

    def some(self, which: Counts) -> "Bounds":
        """Those of some of the spans."""
        return Bounds(*(getattr(self, name)[which] for name in self.__struct_fields__))


def all_spans(curves: Sequence[BSpline | Bezier]) -> dict[int, Spans]:
    """The polynomials of curves without weights, by their degree."""
    alike: dict[tuple[int, int], list[int]] = {}
    for k, curve in enumerate(curves):
        points = curve.control if isinstance(curve, BSpline) else curve.points
        degree = curve.degree if isinstance(curve, BSpline) else len(points) - 1
        alike.setdefault((degree, len(points)), []).append(k)
    parts: dict[int, list[Spans]] = {}
    for (degree, _), members in alike.items():
        parts.setdefault(degree, []).append(_windows(degree, curves, members))
    return {degree: _in_order(part) for degree, part in parts.items()}


def _windows(degree: int, curves: Sequence[BSpline | Bezier], members: list[int]) -> Spans:
    """The polynomials of curves with equally many control points."""
    these = [curves[k] for k in members]
    once = (0.0,) * (degree + 1) + (1.0,) * (degree + 1)  # a Bezier curve is a spline of one span
    points = np.array([c.control if isinstance(c, BSpline) else c.points for c in these])
    said = np.array([c.knots if isinstance(c, BSpline) else once for c in these])
    control = sliding_window_view(points, degree + 1, axis=1)  # (m, spans, 2, p + 1)
    knots = sliding_window_view(said[:, 1:-1], 2 * degree, axis=1).reshape(-1, 2 * degree)
    owner = np.repeat(members, control.shape[1])
    width = knots[:, degree] - knots[:, degree - 1]
    kept = np.flatnonzero(width > 0.0)
    control = control.reshape(-1, 2, degree + 1).transpose(0, 2, 1)
    return Spans(owner, control, knots, width).some(kept)


def _in_order(parts: Sequence[Spans]) -> Spans:
    """Spans of one degree together, by the number of their curve."""
    if len(parts) == 1:
        return parts[0]
    names = Spans.__struct_fields__
    every = Spans(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))
    return every.some(np.argsort(every.owner, kind="stable"))


def bounds_of(spans: Spans) -> Bounds:
    """Upper bounds of the derivatives of spans.

    Each lies in the hull of its control points, which are differences of those before.
    """
    degree = spans.control.shape[1] - 1
    none = np.zeros((len(spans.control), 1, 2))
    found = [spans.control]
    for order in range(degree):
        left, right = spans.knots[:, order:degree], spans.knots[:, degree : 2 * degree - order]
        step = (degree - order) * np.diff(found[-1], axis=1)
        found.append(step / (right - left)[..., None])
    first, second, third = (found[k] if k <= degree else none for k in (1, 2, 3))
    sizes = (np.hypot(d[..., 0], d[..., 1]).max(axis=1) for d in (first, second, third))
    stretch = np.abs(np.einsum("nip,njp->nij", first, second)).max(axis=(1, 2))
    (x1, y1), (x2, y2) = first.mean(axis=1).T, second.mean(axis=1).T
    most_1, most_2, most_3 = sizes
    speed = np.maximum(np.hypot(x1, y1), SLOWEST * most_1 + TINY)
    return Bounds(most_1, most_2, most_3, stretch, speed, np.abs(x1 * y2 - y1 * x2) / speed**3)


def points_on(spans: Spans, steps: Counts) -> Floats:
    """x and y of the start, the middle and the end of equal steps along each span, (2, 3, n)."""
    first = np.cumsum(steps) - steps
    found = np.empty((2, 3, int(steps.sum())))
    for count in sorted(set(steps.tolist())):
        which = np.flatnonzero(steps == count)
        points = _de_boor(spans, which, np.arange(2 * count + 1) / (2 * count))
        rows = first[which, None] + np.arange(count)
        for k in range(3):
            found[:, k, rows] = points[..., k : k + 2 * count : 2]
    return found


def _de_boor(spans: Spans, which: Counts, shares: Floats) -> Floats:
    """x and y of some spans at shares of their widths, (2, len(which), len(shares)).

    Source: de Boor, "On calculating with B-splines", 1972.
    """
    degree = spans.control.shape[1] - 1
    knots = spans.knots[which]
    at = knots[:, degree - 1, None] + spans.width[which, None] * shares
    control = spans.control[which]
    near = [np.ascontiguousarray(control[:, k].T)[..., None] for k in range(degree + 1)]
    for level in range(1, degree + 1):
        for k in range(degree, level - 1, -1):
            low, high = knots[:, k - 1, None], knots[:, k + degree - level, None]
            share = (at - low) / (high - low)
            near[k] = near[k - 1] + share * (near[k] - near[k - 1])
    found: Floats = near[degree]
    return found
