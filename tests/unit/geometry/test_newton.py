"""Polynomials through nodes: tables whose answers are known."""

from itertools import pairwise
from math import dist

import pytest

from beamcam.geometry import approximation
from beamcam.geometry.approximation import curves_of_function, curves_of_way
from beamcam.geometry.curves import Bezier, Line, NewtonCurve
from beamcam.geometry.newton import (
    divided_differences,
    find_oscillation,
    newton_derivatives,
    newton_through,
    node_error,
)

TABLE = ((10, 11), (40, 22), (60, 20), (90, 5))


def runge(count):
    xs = [-1 + 2 * k / (count - 1) for k in range(count)]
    return NewtonCurve(tuple((x, 1 / (1 + 25 * x * x)) for x in xs))


def test_nodes_that_are_not_equidistant_are_all_met():
    curve = NewtonCurve(TABLE)
    for t, node in zip(curve.parameters, TABLE, strict=True):
        assert curve.point(t) == node
        near = curve.point(t + (1e-9 if t < 1 else -1e-9))
        assert near == pytest.approx(node, abs=1e-6)
    assert curve.end == (90, 5)


def test_the_polynomial_of_divided_differences_meets_its_values():
    xs, ys = (0.0, 30.0, 60.0, 90.0), (11.0, 22.0, 20.0, 5.0)
    coefficients = divided_differences(xs, ys)
    assert [newton_derivatives(coefficients, xs, x)[0] for x in xs] == pytest.approx(ys)


def test_three_nodes_are_a_parabola_with_its_vertex():
    curve = NewtonCurve(((0, 0), (10, 30), (40, 0)))
    form = curve.as_bezier()
    assert (form.degree, form.start, form.end) == (2, (0, 0), (40, 0))
    assert form.point(0.5) == pytest.approx((20, 40))  # y = x (40 - x) / 10
    assert curve.tangent(0.5) == pytest.approx((1, 0))


def test_a_curve_that_is_no_function_of_x_is_parametric():
    curve = NewtonCurve(((0, 0), (10, 10), (0, 20)))
    assert not curve.is_function
    assert curve.point(0.5) == (10, 10)
    assert curve.tangent(0.5) == pytest.approx((0, 1), abs=1e-12)
    assert curve.as_bezier().point(0.5) == pytest.approx((10, 10))
    closed = NewtonCurve(((0, 0), (10, 10), (0, 20), (-10, 10), (0, 0)))
    assert closed.start == closed.end
    assert [closed.point(t) for t in closed.parameters] == list(closed.nodes)


def test_bezier_form_is_the_same_curve():
    curve = NewtonCurve(TABLE)
    form = curve.as_bezier()
    assert form.degree == 3
    for k in range(21):
        assert form.point(k / 20) == pytest.approx(curve.point(k / 20), abs=1e-12)


def test_a_turned_function_stays_the_same_curve():
    curve = NewtonCurve(TABLE)
    turned = curve.transformed(((0, -1, 3), (1, 0, 4)))
    assert isinstance(turned, Bezier)
    x, y = curve.point(0.37)
    assert turned.point(0.37) == pytest.approx((3 - y, 4 + x))
    assert isinstance(curve.transformed(((2, 0, 3), (1, 5, 4))), NewtonCurve)


def test_many_nodes_oscillate_and_the_overshoot_is_measured():
    found = find_oscillation(runge(11))
    assert found is not None
    assert found.nodes == 11
    assert found.overshoot == pytest.approx(1.957 - 0.0588, abs=0.02)
    assert abs(found.near[0]) > 0.8
    assert str(found).startswith("the polynomial through 11 nodes leaves them by 1.")
    assert str(found).endswith("expected at most 5 nodes")


def test_nodes_that_turn_as_often_as_the_curve_may_swing_too():
    values = (0.0, 5.0, -5.0, 4.0, -4.0, 5.0, -3.0, 5.0)
    found = find_oscillation(NewtonCurve(tuple((10.0 * k, v) for k, v in enumerate(values))))
    assert found is not None
    assert found.overshoot > 0.25 * 70


def test_a_polynomial_loses_a_digit_a_node():
    calm = NewtonCurve(tuple((float(x), x * x / 10.0) for x in range(8)))
    assert node_error(calm) < 1e-12
    assert node_error(NewtonCurve(tuple((float(x), (-1.0) ** x) for x in range(26)))) > 1e-6


def test_nodes_without_a_place_of_their_own_are_refused():
    assert newton_through(TABLE) == NewtonCurve(TABLE)
    with pytest.raises(ValueError, match="at most 26 nodes, found 27"):
        newton_through(tuple((float(x), 0.0) for x in range(27)))
    with pytest.raises(ValueError, match="too near to the one before"):
        newton_through(((0.0, 0.0), (1e8, 0.0), (1e8, 1e-9)))


@pytest.mark.parametrize("tolerance", [1.0, 0.01, 1e-5])
@pytest.mark.parametrize(
    ("x", "y", "low", "high"),
    [("9 * cos(t)", "4 * sin(t)", 0, 6.3), ("t", "t^3", 2, -2), ("t^2", "t^3", -1, 1),
     ("20*(cos(t)+t*sin(t))", "20*(sin(t)-t*cos(t))", 0, 2)],
)  # fmt: skip
def test_a_way_is_followed_within_its_tolerance(x, y, low, high, tolerance):
    from beamcam.conversion import compile_expression

    fit = curves_of_way(x, y, low, high, tolerance)
    fx, fy = compile_expression(x, ("t",)), compile_expression(y, ("t",))
    assert fit.deviation <= tolerance / 2
    places = [(fx({"t": t}), fy({"t": t})) for t in (low, high)]
    assert [fit.curves[0].start, fit.curves[-1].end] == places
    for a, b in pairwise(fit.curves):
        assert a.end == b.start
    # Every place of the way has a place of the curves within the tolerance.
    drawn = [curve.point(k / 200) for curve in fit.curves for k in range(201)]
    step = max(dist(a, b) for a, b in pairwise(drawn))
    for k in range(101):
        t = low + (high - low) * k / 100
        place = fx({"t": t}), fy({"t": t})
        assert min(dist(place, p) for p in drawn) <= tolerance + step


def test_a_formula_of_endless_swings_is_refused(monkeypatch):
    monkeypatch.setattr(approximation, "MOST_CURVES", 50)
    with pytest.raises(ValueError, match="takes more than 50 curves up to x = 0"):
        curves_of_function("sin(9999 * x)", 0, 99, 0.1)


def test_a_straight_way_is_one_line():
    assert curves_of_way("2 * t", "t + 1", 0, 5, 0.01).curves == (Line((0, 1), (10, 6)),)


def test_few_or_calm_nodes_are_no_oscillation():
    assert find_oscillation(runge(5)) is None
    calm = NewtonCurve(tuple((float(x), x * x / 10.0) for x in range(8)))
    assert find_oscillation(calm) is None


@pytest.mark.parametrize("tolerance", [1.0, 0.01, 1e-5])
@pytest.mark.parametrize(
    ("text", "low", "high"),
    [("25 * sin(x / 10)", 0, 100), ("sqrt(100 - x^2)", -9.9, 9.9), ("exp(-x)", 3, -2)],
)
def test_a_function_is_followed_within_its_tolerance(text, low, high, tolerance):
    from beamcam.conversion import compile_expression

    fit = curves_of_function(text, low, high, tolerance)
    value = compile_expression(text, ("x",))
    assert fit.deviation <= tolerance / 2
    assert fit.curves[0].start[0] == low
    assert fit.curves[-1].end[0] == high
    for a, b in zip(fit.curves, fit.curves[1:], strict=False):
        assert a.end == b.start
    for curve in fit.curves:
        for k in range(41):
            x, y = curve.point(k / 40)
            assert abs(y - value({"x": x})) <= tolerance


def test_a_straight_function_is_one_line():
    assert curves_of_function("2 * x + 1", 0, 10, 0.01).curves == (Line((0, 1), (10, 21)),)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: curves_of_function("x", 1, 1, 0.1), "two different ends, found 1 and 1"),
        (lambda: curves_of_function("x", 0, 1, 0), "tolerance must be above 0, found 0"),
        (lambda: curves_of_function("1 / x", 0, 1, 0.1), "'1 / x' has no value at x = 0"),
        (lambda: curves_of_function("sqrt(x)", -1, 1, 0.1), "has no value at x = -1"),
        (lambda: curves_of_function("floor(x)", 0.1, 1.9, 0.1), "jumps near x = "),
        (lambda: curves_of_function("y", 0, 1, 0.1), "'y' is not understood"),
        (lambda: curves_of_way("1", "2", 0, 1, 0.1), "stands still near t = 0"),
        (lambda: curves_of_way("floor(t)", "t", 0, 2.1, 0.1), "jumps near t = "),
    ],
)
def test_what_has_no_curve_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
