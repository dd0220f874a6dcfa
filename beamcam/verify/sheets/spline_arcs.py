"""Splines as arcs and chords: a few of them for each polynomial, with a bound of the distance.

An arc goes through the start, the middle and the end of a step h of the parameter. With c its
centre and r its radius, the power of the curve f with regard to its circle,

    p = (|f - c|^2 - r^2) / 2r,    p''' = (3 f' . f'' + (f - c) . f''') / r,

is zero at these three, so that |p| <= sqrt(3) / 216 h^3 max |p'''|: the error of interpolation
at three places. Where h |f'| <= r, the curve stays within r / 4 of one of the three, so that
|f - c| <= 1.25 r, and its distance from the circle is at most |p| / 0.875. Where h^2 |f''| is not
above the chord, f' turns by less than 45 degrees to either side of it, so that the curve runs on
from one end of the arc to the other.
"""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct
from numpy.lib.stride_tricks import sliding_window_view

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.curves import Bezier, BSpline
from beamcam.verify.sheets.grid import Pieces, straight_pieces

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


MOST_STEPS = 4096  #: of a polynomial
THREE_PLACES = 3**0.5 / 216 / 0.875
AIMED_SHARE = 0.4  #: of the tolerance, since the curvature is not known before
STRAIGHT_SHARE = 1e-3  #: of the tolerance; what leaves its chord by less has no centre to speak of


def spline_pieces(curves: Sequence[BSpline | Bezier], tolerance: float) -> Pieces:
    """Arcs and chords along one or more curves without weights, at most `tolerance` off."""
    drawn: list[tuple[Counts, Counts, Pieces]] = []
    for spans in all_spans(curves).values():
        drawn += _pieces(spans, tolerance)
    owner, span = (np.concatenate([part[k] for part in drawn]) for k in (0, 1))
    order = np.lexsort((span, owner)) if len(drawn) > 1 else np.arange(len(owner))
    columns = zip(*(pieces.columns for _, _, pieces in drawn), strict=True)
    return Pieces(
        np.bincount(owner, minlength=len(curves)),
        *(np.concatenate(column)[order] for column in columns),
    )


def _pieces(spans: Spans, tolerance: float) -> list[tuple[Counts, Counts, Pieces]]:
    """Spans in arcs and others in chords: the curve and the span of each piece, and the pieces."""
    bounds = bounds_of(spans)
    # Chords of a step h leave a curve by h^2 / 8 of its second derivative at most.
    chords = _steps(spans.width * np.sqrt(bounds.second / (8 * tolerance)))
    arcs = _steps(spans.width * _arcs_in_one(bounds, tolerance))
    bent = np.flatnonzero(arcs < chords)
    found = []
    if len(bent):
        steps = arcs[bent]
        pieces, near = _arcs(spans.some(bent), steps, bounds.some(bent), tolerance)
        good = np.logical_and.reduceat(near, np.cumsum(steps) - steps)
        chords[bent[good]] = 0
        span = np.repeat(bent, steps)
        kept = np.repeat(good, steps)
        found.append((spans.owner[span[kept]], span[kept], pieces.some(kept)))
    rest = np.flatnonzero(chords)
    if len(rest):
        start, _, end = points_on(spans.some(rest), chords[rest]).transpose(1, 2, 0)
        span = np.repeat(rest, chords[rest])
        ones = np.ones(len(span), dtype=np.int64)
        found.append((spans.owner[span], span, straight_pieces(ones, start, end)))
    return found


def _steps(count: Floats) -> Counts:
    return np.clip(np.ceil(count), 1, MOST_STEPS).astype(np.int64)


def _arcs_in_one(bounds: Bounds, tolerance: float) -> Floats:
    """About how many arcs it takes for a step of 1 of the parameter."""
    bent = THREE_PLACES * (3 * bounds.stretch * bounds.bend + 1.25 * bounds.third)
    return np.maximum(
        np.cbrt(bent / (AIMED_SHARE * tolerance)),
        np.maximum(bounds.first * bounds.bend, bounds.second / bounds.speed),
    )


def _arcs(spans: Spans, steps: Counts, bounds: Bounds, tolerance: float) -> tuple[Pieces, Flags]:
    """Arcs along spans in so many steps each, and which of them are surely within tolerance."""
    start, middle, end = points_on(spans, steps).transpose(1, 0, 2)
    (ux, uy), (wx, wy) = end - start, middle - start
    chord = np.hypot(ux, uy)
    cross = ux * wy - uy * wx
    is_arc = np.abs(cross) > STRAIGHT_SHARE * tolerance * chord
    uu, ww, twice = chord * chord, wx * wx + wy * wy, np.where(is_arc, 2 * cross, 1.0)
    x, y = (wy * uu - uy * ww) / twice, (ux * ww - wx * uu) / twice
    radius = np.hypot(x, y)
    bend = np.where(is_arc, 1 / np.where(is_arc, radius, 1.0), 0.0)
    sweep = -2 * np.sign(cross) * np.arcsin(np.minimum(chord * bend / 2, 1.0))
    arcs = np.column_stack((start[0] + x, start[1] + y, radius, np.arctan2(-y, -x), sweep))
    arcs[~is_arc] = 0.0
    step = np.repeat(spans.width / steps, steps)
    first, second, third, stretch = (
        np.repeat(column, steps)
        for column in (bounds.first, bounds.second, bounds.third, bounds.stretch)
    )
    off = THREE_PLACES * step**3 * (3 * stretch * bend + 1.25 * third)
    near = off <= (1 - STRAIGHT_SHARE) * tolerance
    near &= (step * first * bend <= 1.0) & (step * step * second <= chord)
    ones = np.ones(len(step), dtype=np.int64)
    return Pieces(ones, start.T, end.T, is_arc, arcs), near
