"""Tables of curves whose answers are known."""

from math import inf, pi, sqrt

import pytest

from beamcam.geometry import bezier
from beamcam.geometry.conics import arc_between, ellipse_of
from beamcam.geometry.curves import (
    Arc,
    Bezier,
    BSpline,
    EllipseArc,
    Line,
    NewtonCurve,
    arc_through,
    signed_area,
)
from beamcam.geometry.plane import integrate, normalized, refuse_singular

R = sqrt(0.5)
NURBS_CIRCLE = BSpline(
    2,
    ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)),
    (0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4),
    (1, R, 1, R, 1, R, 1, R, 1),
)


@pytest.mark.parametrize(
    ("curve", "length"),
    [
        (Line((0, 0), (3, 4)), 5.0),
        (Arc((0, 0), 10, 0, -90), 5 * pi),
        (EllipseArc((0, 0), (10, 0), 0.5, 0, 360), 48.442241102738385),  # 4 a E(1 - 1/4)
        (Bezier(((0, 0), (1, 0), (2, 0))), 2.0),
        (Bezier(((0, 0), (1, 0), (1, 1))), 1.6232252401402305),  # parabola, closed form
        (NURBS_CIRCLE, 2 * pi),
        (NewtonCurve(((0, 0), (1, 1), (2, 4))), 4.646783762432935),  # y = x^2 from 0 to 2
    ],
)
def test_length(curve, length):
    assert curve.length == pytest.approx(length, rel=1e-11)


@pytest.mark.parametrize(
    ("curve", "box"),
    [
        (Arc((0, 0), 10, 0, 90), (0, 0, 10, 10)),
        (Arc((5, 5), 5, 45, 360), (0, 0, 10, 10)),
        (EllipseArc((0, 0), (0, 10), 0.5, 0, 360), (-5, -10, 5, 10)),
        (EllipseArc((0, 0), (10, 0), 0.5, 90, -90), (0, 0, 10, 5)),
        (Bezier(((0, 0), (0, 4), (4, 4), (4, 0))), (0, 0, 4, 3)),
        (NURBS_CIRCLE, (-1, -1, 1, 1)),
        (NewtonCurve(((-1, 1), (0, 0), (2, 4))), (-1, 0, 2, 4)),
    ],
)
def test_box(curve, box):
    assert curve.bbox == pytest.approx(box, abs=1e-12)


@pytest.mark.parametrize(
    ("chain", "area"),
    [
        ((Arc((3, 4), 2, 10, 360),), 4 * pi),
        ((EllipseArc((3, 4), (2, 0), 0.5, 10, -360),), -2 * pi),
        ((NURBS_CIRCLE,), pi),
        ((NewtonCurve(((-1, 1), (0, 0), (1, 1))), Line((1, 1), (-1, 1))), 4 / 3),
        ((Bezier(((-1, 1), (0, -1), (1, 1))), Line((1, 1), (-1, 1))), 4 / 3),
    ],
)
def test_signed_area(chain, area):
    assert signed_area(chain) == pytest.approx(area, rel=1e-12)


def test_a_nurbs_circle_lies_on_the_circle():
    for k in range(101):
        x, y = NURBS_CIRCLE.point(k / 100)
        assert x * x + y * y == pytest.approx(1.0, abs=1e-14)
    for piece in NURBS_CIRCLE.pieces():
        for k in range(26):
            assert piece.curvature(k / 25) == pytest.approx(1.0, rel=1e-9)


def test_full_circle_ends_where_it_starts():
    arc = Arc((1.0, 2.0), 3.3, 33.3, 360)
    assert arc.end == arc.start == arc.point(1.0)


def test_mirrored_arc_turns_the_other_way():
    image = Arc((1, 2), 5, 30, 60).transformed(((-1, 0, 0), (0, 1, 0)))
    assert image == Arc((-1, 2), 5, 150, -60)


def test_stretched_circle_is_an_ellipse():
    image = Arc((1, 2), 5, 0, 360).transformed(((1, 0, 0), (0, 3, 0)))
    assert isinstance(image, EllipseArc)
    assert (image.centre, image.major) == ((1, 6), 15)
    assert image.minor == pytest.approx(5)
    assert image.start == pytest.approx((6, 6))


def test_tangent_where_a_curve_stands_still():
    cubic = Bezier(((0, 0), (0, 0), (0, 0), (3, 4)))
    assert cubic.tangent(0.0) == pytest.approx((0.6, 0.8))
    assert Bezier(((0, 0), (3, 4), (3, 4))).tangent(1.0) == pytest.approx((0.6, 0.8))
    assert cubic.curvature(0.0) == inf
    cusp = Bezier(((0, 0), (2, 2), (0, 2), (2, 0)))
    assert abs(cusp.tangent(0.5)[1]) == pytest.approx(1.0)


@pytest.mark.parametrize("knot", [1, 2, 3])
def test_a_spline_is_split_at_a_knot_into_the_points_that_it_has(knot):
    first, second = NURBS_CIRCLE.split(knot / 4)
    assert sum(first.control, ()) == pytest.approx(sum(NURBS_CIRCLE.control[: 2 * knot + 1], ()))
    assert sum(second.control, ()) == pytest.approx(sum(NURBS_CIRCLE.control[2 * knot :], ()))
    assert first.knots == (*NURBS_CIRCLE.knots[: 2 * knot + 1], knot, knot, knot)
    assert second.weights == pytest.approx(NURBS_CIRCLE.weights[2 * knot :])


def test_a_spline_without_ends_on_its_points_keeps_its_knots_where_it_is_not_split():
    spline = BSpline(2, ((0, 0), (4, 0), (4, 4), (0, 4), (0, 0)), tuple(range(8)))
    first, second = spline.split(0.5)
    assert first.knots == (0, 1, 2, 3, 3.5, 3.5, 3.5)
    assert second.knots == (3.5, 3.5, 3.5, 4, 5, 6, 7)
    assert (first.start, first.end, second.end) == ((2, 0), (3.5, 3.5), spline.end)
    assert first.end == second.start == spline.point(0.5)


def test_bernstein_roots():
    thirds = bezier.product([-1 / 3, 2 / 3], [-2 / 3, 1 / 3])
    assert bezier.roots(thirds) == pytest.approx([1 / 3, 2 / 3])
    assert bezier.roots([0.0, 0.0, 0.0]) == []
    assert bezier.roots(bezier.product([-0.5, 0.5], [-0.5, 0.5])) == pytest.approx([0.5])


def test_integral_of_a_kink():
    assert integrate(lambda t: abs(t - 0.3), 0.0, 1.0) == pytest.approx(0.29, rel=1e-9)


def test_arc_between_and_arc_through():
    assert arc_between((1, 0), (0, 1), (0, 0), -1) == Arc((0, 0), 1, 0, -270)
    assert arc_between((1, 0), (1, 0), (0, 0), 1).sweep_deg == 360
    assert arc_through((1, 0), (0, 1), 1).centre == pytest.approx((0, 0), abs=1e-15)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Bezier(((0, 0),)), "2 points or more, found 1"),
        (lambda: Bezier(((0, 0), (1, 1)), (1.0,)), "expected 2 weights, one for each point"),
        (lambda: Bezier(((0, 0), (1, 1)), (1.0, 0.0)), "weights must be above 0, found 0"),
        (lambda: BSpline(0, ((0, 0),), (0, 1)), "degree 1 or more, found 0"),
        (lambda: BSpline(3, ((0, 0), (1, 1)), (0, 1)), "4 control points or more, found 2"),
        (lambda: BSpline(1, ((0, 0), (1, 1)), (0, 1)), "expected 4 knots, found 2"),
        (lambda: BSpline(1, ((0, 0), (1, 1)), (0, 1, 0, 1)), "must not fall"),
        (lambda: BSpline(1, ((0, 0), (1, 1)), (0, 1, 1, 1)), "span nothing: 1 to 1"),
        (lambda: BSpline(1, ((0, 0), (1, 1)), (0, 0, 1e-31, 1)), "differ by less than 1e-30"),
        (lambda: BSpline(1, ((0, 0), (1, 5), (2, 0)), (0, 0, 0, 1, 1)), "is there 2 times at most"),
        (
            lambda: BSpline(1, ((0, 0), (1, 1), (2, 0), (3, 0)), (0, 0, 1, 1, 2, 2)),
            "there too often",
        ),
        (lambda: NURBS_CIRCLE.split(0.0), r"split inside \(0, 1\), not at 0"),
        (lambda: NewtonCurve(((0, 0),)), "2 nodes or more, found 1"),
        (lambda: NewtonCurve(((0, 0), (0, 0))), r"node \(0, 0\) is there twice in a row"),
        (lambda: ellipse_of((0, 0), (1, 1), (2, 2), 0, 90), "may not be parallel"),
        (lambda: normalized((0, 0)), "zero vector has no direction"),
        (lambda: refuse_singular(((1, 1, 0), (1, 1, 0))), "flattens the plane"),
        (lambda: Bezier(((1, 1), (1, 1))).tangent(0), "whose points are one has no direction"),
        (lambda: arc_through((0, 0), (0, 0), 1), "two different points"),
        (lambda: arc_through((0, 0), (9, 0), 1), "do not lie on a circle of radius 1"),
    ],
)
def test_what_is_no_curve_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_posting_needs_no_numpy():
    import subprocess
    import sys

    code = "import beamcam.geometry.curves, sys; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
