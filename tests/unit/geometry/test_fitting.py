"""Arcs for free curves: laws and tables."""

from math import dist

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Bezier, BSpline, EllipseArc, Line, NewtonCurve
from beamcam.geometry.fitting import biarc, fit_arcs, fit_path, fit_single_arc
from beamcam.geometry.sampling import points_at
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


def fine_line(curves, count=400):
    parts = [points_at(c, np.linspace(0, 1, 2 if isinstance(c, Line) else count)) for c in curves]
    return shapely.LineString(np.concatenate(parts))


@settings(max_examples=40, deadline=None)
@given(
    st.one_of(beziers(), ellipses(), splines(), newton_curves()),
    st.sampled_from([0.02, 0.2, 2.0]),
)
def test_arcs_stay_within_the_tolerance_and_join(curve, tolerance):
    fit = fit_arcs(curve, tolerance)
    assert fit.deviation <= tolerance
    arcs = [c for c in fit.curves if isinstance(c, Arc)]
    size = max(map(abs, curve.bbox)) + max((c.radius for c in arcs), default=0)
    assert dist(fit.curves[0].start, curve.start) <= 1e-9 * size
    assert dist(fit.curves[-1].end, curve.end) <= 1e-9 * size
    for a, b in zip(fit.curves[:-1], fit.curves[1:], strict=True):
        assert dist(a.end, b.start) <= 1e-9 * size
    samples = points_at(curve, np.linspace(0, 1, 1500))
    away = shapely.distance(shapely.points(samples), fine_line(fit.curves, 200))
    sagittas = [c.radius * (1 - np.cos(np.radians(c.sweep_deg) / 398)) for c in arcs]
    longest = max(sagittas, default=0)
    assert np.max(away) <= fit.deviation + longest + 1e-9 * size


@pytest.mark.parametrize("size", [1.0, 5.0, 50.0, 500.0])
def test_four_cubics_of_a_drawing_program_are_one_circle(size):
    fit = fit_path([scaled(q, size, 7.0, 9.0) for q in QUARTERS], 0.005)
    (circle,) = fit.curves
    assert isinstance(circle, Arc)
    assert circle.sweep_deg == 360
    assert circle.centre == pytest.approx((7, 9), abs=1e-9 * size)
    assert circle.radius == pytest.approx(size, rel=3e-4)
    assert fit.deviation <= max(0.005, 3.1e-4 * size)


def test_three_quarters_and_a_line():
    line = Line((0, -1), (5, -1))
    fit = fit_path([*QUARTERS[:3], line], 0.005)
    arc, kept = fit.curves
    assert arc.sweep_deg == pytest.approx(270)
    assert kept == line


def test_a_circle_drawn_backwards_runs_clockwise():
    fit = fit_path([q.reversed() for q in reversed(QUARTERS)], 0.005)
    assert [c.sweep_deg for c in fit.curves] == [-360]


def test_a_cubic_that_is_no_arc_is_none():
    assert fit_single_arc(Bezier(((0, 0), (10, 0), (10, 0), (10, 30))), 0.01) is None
    assert fit_single_arc(Bezier(((0, 0), (1, 1), (2, 2), (3, 3))), 0.01) is None
    found = fit_single_arc(QUARTERS[0], 0.001)
    assert found is not None
    assert found.deviation == pytest.approx(2.7e-4 * 1.1, rel=0.1)


def test_a_straight_cubic_is_a_line():
    fit = fit_arcs(Bezier(((0, 0), (1, 1), (2, 2), (9, 9))), 0.01)
    assert fit.curves == (Line((0, 0), (9, 9)),)


def test_an_ellipse_takes_few_arcs():
    fit = fit_arcs(EllipseArc((0, 0), (50, 0), 0.5, 0, 360), 0.01)
    assert all(isinstance(c, Arc) for c in fit.curves)
    assert len(fit.curves) <= 64
    finer = fit_arcs(EllipseArc((0, 0), (50, 0), 0.5, 0, 360), 0.01 / 8)
    assert len(finer.curves) <= 2.5 * len(fit.curves)  # tolerance^(-1/3), halving


def test_biarcs_keep_both_tangents():
    first, second = biarc((0, 0), (1, 0), (10, 5), (0, 1))
    assert first.tangent(0.0) == pytest.approx((1, 0))
    assert second.tangent(1.0) == pytest.approx((0, 1))
    assert first.end == pytest.approx(second.start)
    assert first.tangent(1.0) == pytest.approx(second.tangent(0.0))
    s_shape = biarc((0, 0), (1, 0), (10, 5), (1, 0))
    assert s_shape[0].sweep_deg == pytest.approx(-s_shape[1].sweep_deg)
    assert biarc((0, 0), (1, 0), (-10, 0), (1, 0)) is None


def test_splines_and_polynomials_are_fitted_piece_by_piece():
    spline = BSpline(2, ((0, 0), (5, 10), (10, 0), (15, 10)), (0, 0, 0, 1, 2, 2, 2))
    for curve in (spline, NewtonCurve(((0, 0), (10, 5), (20, 0)))):
        fit = fit_path([curve], 0.01)
        assert fit.deviation <= 0.01
        assert fit.curves[-1].end == pytest.approx(curve.end)


@pytest.mark.parametrize("call", [fit_arcs, fit_path])
def test_a_tolerance_of_nothing_is_refused(call):
    with pytest.raises(ValueError, match="tolerance must be above 0, found 0"):
        call(QUARTERS[0] if call is fit_arcs else [QUARTERS[0]], 0.0)


def test_a_flat_curve_of_large_radius_is_no_circle() -> None:
    """The error that drawing programs make is that of a wide cubic; a flat one has none."""
    flat = Bezier(((0.0, 0.0), (30.0, 2.8), (60.0, 2.5), (90.0, 0.0)))
    fit = fit_single_arc(flat, 0.5)
    assert fit is not None
    assert 0.02 < fit.deviation < 3e-4 * fit.curves[0].radius
    assert fit_single_arc(flat, 0.02) is None
