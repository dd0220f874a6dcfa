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

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.curves import Bezier, BSpline
from beamcam.verify.sheets.elements import Pieces, straight_pieces
from beamcam.verify.sheets.splines import Bounds, Spans, all_spans, bounds_of, points_on

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
