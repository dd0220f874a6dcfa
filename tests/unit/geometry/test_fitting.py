"""Arcs for free curves: laws and tables."""

from itertools import pairwise
from math import dist

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.arc_fitting import fit_chains
from beamcam.geometry.curves import Arc, Bezier, BSpline, EllipseArc, Line, NewtonCurve
from beamcam.geometry.polylines import points_at
from tests.conftest import examples, sampled
from tests.property.curve_strategies import beziers, ellipses, newton_curves, splines

K = 0.5522847498307936
QUARTERS = (
    Bezier(((1, 0), (1, K), (K, 1), (0, 1))),
    Bezier(((0, 1), (-K, 1), (-1, K), (-1, 0))),
    Bezier(((-1, 0), (-1, -K), (-K, -1), (0, -1))),
    Bezier(((0, -1), (K, -1), (1, -K), (1, 0))),
)


def scaled(curve, size, x, y):
    return curve.transformed(((size, 0, x), (0, size, y)))


def fitted(curves, tolerance):
    (found,) = fit_chains([tuple(curves)], tolerance)
    return found


def away_from(curves, curve, fine=200):
    """How far a curve lies from what stands for it, the sagitta of the arcs' chords included."""
    samples = points_at(curve, np.linspace(0, 1, 1500))
    return float(np.max(shapely.distance(shapely.points(samples), fine_line(curves, fine))))


def fine_line(curves, count=400):
    parts = [points_at(c, np.linspace(0, 1, 2 if isinstance(c, Line) else count)) for c in curves]
    return shapely.LineString(np.concatenate(parts))


@settings(max_examples=examples(40), deadline=None)
@given(
    st.one_of(beziers(), ellipses(), splines(), newton_curves()),
    st.sampled_from([0.02, 0.2, 2.0]),
)
def test_arcs_stay_within_the_tolerance_and_join(curve, tolerance):
    curves = fitted([curve], tolerance)
    arcs = [c for c in curves if isinstance(c, Arc)]
    size = max(map(abs, curve.bbox)) + max((c.radius for c in arcs), default=0)
    assert dist(curves[0].start, curve.start) <= 1e-9 * size
    assert dist(curves[-1].end, curve.end) <= 1e-9 * size
    for a, b in pairwise(curves):
        assert dist(a.end, b.start) <= 1e-9 * size
    sagittas = [c.radius * (1 - np.cos(np.radians(c.sweep_deg) / 398)) for c in arcs]
    # An arc in disguise may be off by what drawing programs miss it by, 2.7e-4 of the radius.
    known = max((6e-4 * c.radius for c in arcs if abs(c.sweep_deg) > 20), default=0.0)
    allowed = max(1.1 * tolerance, min(known, 2.0 * tolerance))
    assert away_from(curves, curve) <= allowed + max(sagittas, default=0) + 1e-9 * size


@pytest.mark.parametrize("size", [1.0, 5.0, 30.0])
def test_four_cubics_of_a_drawing_program_are_one_circle(size):
    (circle,) = fitted([scaled(q, size, 7.0, 9.0) for q in QUARTERS], 0.005)
    assert isinstance(circle, Arc)
    assert circle.sweep_deg == 360
    assert circle.centre == pytest.approx((7, 9), abs=1e-9 * size)
    assert circle.radius == pytest.approx(size, rel=3e-4)


@pytest.mark.parametrize("size", sampled([150.0, 50.0, 500.0], 3))
def test_cubics_too_far_off_their_circle_are_followed_as_drawn(size):
    drawn = [scaled(q, size, 7.0, 9.0) for q in QUARTERS]
    curves = fitted(drawn, 0.005)
    assert 4 < len(curves) <= 64
    assert max(away_from(curves, q, 400) for q in drawn) <= 0.0052 + 1e-7 * size


def test_three_quarters_and_a_line():
    line = Line((0, -1), (5, -1))
    arc, kept = fitted([*QUARTERS[:3], line], 0.005)
    assert arc.sweep_deg == pytest.approx(270)
    assert kept == line


def test_a_circle_drawn_backwards_runs_clockwise():
    curves = fitted([q.reversed() for q in reversed(QUARTERS)], 0.005)
    assert [c.sweep_deg for c in curves] == [-360]


def test_a_cubic_that_is_no_arc_is_none():
    assert len(fitted([Bezier(((0, 0), (10, 0), (10, 0), (10, 30)))], 0.01)) > 1
    (arc,) = fitted([QUARTERS[0]], 2e-4)
    assert arc.sweep_deg == pytest.approx(90)


def test_a_straight_cubic_is_a_line():
    curves = fitted([Bezier(((0, 0), (1, 1), (2, 2), (9, 9)))], 0.01)
    assert curves == (Line((0, 0), (9, 9)),)


def test_an_ellipse_takes_few_arcs():
    ellipse = EllipseArc((0, 0), (50, 0), 0.5, 0, 360)
    curves, finer = fitted([ellipse], 0.01), fitted([ellipse], 0.01 / 8)
    assert all(isinstance(c, Arc) for c in curves)
    assert len(curves) <= 64
    assert len(finer) <= 2.5 * len(curves)  # tolerance^(-1/3), halving


@pytest.mark.parametrize("curve", [
    Bezier(((0, 0), (20, 0), (20, 30), (40, 30))),
    Bezier(((0, 0), (10, 25), (30, -25), (40, 20), (60, 0))),
    Bezier(((0, 0), (30, 0), (30, 30)), (1, 3, 1)),
])  # fmt: skip
def test_arcs_keep_the_tangents(curve):
    curves = fitted([curve], 0.01)
    assert len(curves) > 2
    assert curves[0].tangent(0.0) == pytest.approx(curve.tangent(0.0), abs=0.02)
    assert curves[-1].tangent(1.0) == pytest.approx(curve.tangent(1.0), abs=0.02)
    for a, b in pairwise(curves):
        assert a.tangent(1.0) == pytest.approx(b.tangent(0.0), abs=0.02)


def test_a_rational_quarter_is_an_arc():
    quarter = Bezier(((10, 0), (10, 10), (0, 10)), (1, 0.5**0.5, 1))
    (arc,) = fitted([quarter], 0.005)
    assert isinstance(arc, Arc)
    assert arc.centre == pytest.approx((0, 0), abs=1e-6)
    assert (arc.radius, arc.sweep_deg) == pytest.approx((10, 90), abs=1e-5)


def test_splines_and_polynomials_are_fitted_piece_by_piece():
    spline = BSpline(2, ((0, 0), (5, 10), (10, 0), (15, 10)), (0, 0, 0, 1, 2, 2, 2))
    for curve in (spline, NewtonCurve(((0, 0), (10, 5), (20, 0)))):
        curves = fitted([curve], 0.01)
        assert curves[-1].end == pytest.approx(curve.end)
        assert away_from(curves, curve) <= 0.012


def test_a_tolerance_of_nothing_is_refused():
    with pytest.raises(ValueError, match="tolerance must be above 0, found 0"):
        fit_chains([QUARTERS], 0.0)


def test_a_flat_curve_of_large_radius_is_no_circle() -> None:
    """The error that drawing programs make is that of a wide cubic; a flat one has none."""
    flat = Bezier(((0.0, 0.0), (30.0, 2.8), (60.0, 2.5), (90.0, 0.0)))
    assert len(fitted([flat], 0.5)) == 1
    curves = fitted([flat], 0.02)
    assert len(curves) > 1
    assert away_from(curves, flat) <= 0.021
