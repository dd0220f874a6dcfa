"""Laws of every curve."""

from math import dist, hypot

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Bezier, BSpline, EllipseArc, NewtonCurve, signed_area
from beamcam.geometry.plane import is_similarity, mapped
from beamcam.geometry.polylines import points_at
from tests.conftest import examples
from tests.property.curve_strategies import arcs, beziers, curves, regular_matrices

shares = st.floats(0, 1)


def size_of(curve):
    x0, y0, x1, y1 = curve.bbox
    reach = max(abs(x0), abs(y0), abs(x1), abs(y1))
    if isinstance(curve, Arc | EllipseArc):
        reach += curve.radius if isinstance(curve, Arc) else curve.major
    return max(1.0, reach)


@settings(max_examples=examples(150), deadline=None)
@given(curves)
def test_ends_are_exact(curve):
    assert curve.point(0.0) == curve.start
    assert curve.point(1.0) == curve.end
    assert points_at(curve, np.array([0.0, 1.0])).tolist() == [list(curve.start), list(curve.end)]


@settings(max_examples=examples(150), deadline=None)
@given(curves, shares)
def test_reversed_runs_the_same_points_backwards(curve, t):
    back = curve.reversed()
    assert dist(back.point(t), curve.point(1 - t)) <= 1e-7 * size_of(curve)
    again = back.reversed()
    assert dist(again.point(t), curve.point(t)) <= 1e-9 * size_of(curve)
    assert back.length == pytest.approx(curve.length, rel=1e-8)


@settings(max_examples=examples(150), deadline=None)
@given(curves, st.floats(0.01, 0.99), shares)
def test_split_parts_agree_with_the_parent(curve, t, s):
    first, second = curve.split(t)
    slack = 1e-8 * size_of(curve)
    assert dist(first.start, curve.start) <= slack
    assert dist(second.end, curve.end) <= slack
    assert dist(first.end, second.start) <= slack
    assert dist(first.end, curve.point(t)) <= slack
    assert first.length + second.length == pytest.approx(curve.length, rel=1e-7)
    if not isinstance(curve, BSpline) or curve.weights is None:
        assert dist(first.point(s), curve.point(s * t)) <= 10 * slack
        assert dist(second.point(s), curve.point(t + s * (1 - t))) <= 10 * slack


@settings(max_examples=examples(200), deadline=None)
@given(curves, regular_matrices(), shares)
def test_transformed_points_are_points_of_the_transformed(curve, matrix, t):
    image = curve.transformed(matrix)
    expected = mapped(matrix, curve.point(t))
    scale = max(size_of(curve), size_of(image), 1000 * hypot(*matrix[0][:2], *matrix[1][:2]))
    assert dist(image.point(t), expected) <= 1e-8 * scale


@settings(max_examples=examples(100), deadline=None)
@given(arcs, regular_matrices())
def test_arc_stays_an_arc_only_under_similarities(arc, matrix):
    image = arc.transformed(matrix)
    assert isinstance(image, Arc if is_similarity(matrix) else EllipseArc)
    (a, b, _), (d, e, _) = matrix
    assert (image.sweep_deg * arc.sweep_deg > 0) == (a * e - b * d > 0)


@settings(max_examples=examples(150), deadline=None)
@given(curves)
def test_box_holds_every_point_and_is_tight(curve):
    points = points_at(curve, np.linspace(0, 1, 4001))
    x0, y0, x1, y1 = curve.bbox
    slack = 1e-9 * size_of(curve)
    assert np.all(points >= [x0 - slack, y0 - slack])
    assert np.all(points <= [x1 + slack, y1 + slack])
    reach = np.max(np.abs(np.diff(points, axis=0))) + slack
    assert np.allclose(points.min(axis=0), [x0, y0], atol=reach)
    assert np.allclose(points.max(axis=0), [x1, y1], atol=reach)


@settings(max_examples=examples(150), deadline=None)
@given(curves, st.lists(shares, min_size=1, max_size=20))
def test_many_points_at_once_are_the_single_ones(curve, ts):
    points = points_at(curve, np.array(ts))
    for t, point in zip(ts, points, strict=True):
        assert dist(curve.point(t), point) <= 1e-9 * size_of(curve)


@settings(max_examples=examples(150), deadline=None)
@given(curves)
def test_length_is_that_of_a_fine_polyline(curve):
    points = points_at(curve, np.linspace(0, 1, 20001))
    polyline = float(np.sum(np.hypot(*np.diff(points, axis=0).T)))
    assert polyline <= curve.length * (1 + 1e-7)
    # It cuts the corners of a spline of degree 1.
    assert curve.length == pytest.approx(polyline, rel=1e-3)


@settings(max_examples=examples(200), deadline=None)
@given(curves, st.floats(0.02, 0.98))
def test_tangent_and_curvature_are_those_of_near_points(curve, t):
    h = 1e-4
    if isinstance(curve, BSpline):
        assume(all(abs(t - k) > 2 * h for k in curve.breaks()))
    a, b, c = (np.array(curve.point(s)) for s in (t - h, t, t + h))
    velocity, acceleration = (c - a) / (2 * h), (a - 2 * b + c) / h**2
    speed = hypot(*velocity)
    assume(speed > 1e-2 * size_of(curve) and hypot(*acceleration) < 1e3 * speed)
    assert dist(curve.tangent(t), velocity / speed) <= 1e-2
    assert hypot(*curve.tangent(t)) == pytest.approx(1, rel=1e-9)
    if not isinstance(curve, Bezier):
        return
    turning = (velocity[0] * acceleration[1] - velocity[1] * acceleration[0]) / speed**3
    slack = 1e-2 * hypot(*acceleration) / speed**2 + 1e-3 / size_of(curve)
    assert curve.curvature(t) == pytest.approx(turning, abs=slack + 1e-6)


@settings(max_examples=examples(60), deadline=None)
@given(st.one_of(arcs, beziers()), regular_matrices())
def test_area_scales_with_the_determinant(curve, matrix):
    closed = (curve, Bezier((curve.end, (7.0, 9.0), curve.start)))
    image = tuple(c.transformed(matrix) for c in closed)
    (a, b, _), (d, e, _) = matrix
    scale = size_of(image[0]) ** 2 + 1e6 * hypot(a, b, d, e) ** 2
    assert signed_area(image) == pytest.approx(
        signed_area(closed) * (a * e - b * d), rel=1e-8, abs=1e-9 * scale
    )


@settings(max_examples=examples(150), deadline=None)
@given(curves.filter(lambda curve: isinstance(curve, Bezier | EllipseArc | NewtonCurve)))
def test_extremes_are_where_x_or_y_turns(curve):
    for t in curve.extremes():
        assert 0.0 < t < 1.0
        if isinstance(curve, Bezier | NewtonCurve):
            continue
        assert min(map(abs, curve.tangent(t))) <= 1e-7
