"""Lengths of many curves at once, what lies twice, and the extent of a drawing."""

from math import pi, radians

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Bezier, BSpline, EllipseArc, Line, join_boxes
from beamcam.model.lengths import duplicate_length, total_length
from beamcam.model.part import Measures, extent
from tests.conftest import examples
from tests.property.curve_strategies import curves

CUBIC = Bezier(((0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 3.0)))
SPLINE = BSpline(2, ((0, 0), (5, 9), (9, 0), (14, 2)), (0, 0, 0, 1, 2, 2, 2))
ELLIPSE = EllipseArc((0, 0), (10, 0), 0.5, 0, 360)


@settings(max_examples=examples(60), deadline=None)
@given(st.lists(curves, max_size=5))
def test_the_sum_is_that_of_the_parts(many) -> None:
    expected = sum(curve.length for curve in many)
    assert total_length(many) == pytest.approx(expected, rel=1e-8, abs=1e-9)


@settings(max_examples=examples(60), deadline=None)
@given(st.lists(curves, max_size=5))
def test_the_extent_is_that_of_the_parts(many) -> None:
    expected = join_boxes([curve.bbox for curve in many])
    found = extent(many)
    assert found == expected if found is None else found == pytest.approx(expected, abs=1e-9)


def test_cusps_and_points_have_lengths_too() -> None:
    there_and_back = Bezier(((0, 0), (10, 0), (0, 0)))
    assert total_length([there_and_back]) == pytest.approx(10, rel=1e-8)
    assert total_length([Bezier(((1, 1), (1, 1), (1, 1)))]) == 0
    assert total_length([]) == 0


@settings(max_examples=examples(60), deadline=None)
@given(curves)
def test_a_curve_drawn_again_lies_twice(curve) -> None:
    again = [curve, curve.reversed()]
    expected = pytest.approx(total_length([curve]), rel=1e-6, abs=3e-3)
    assert duplicate_length(again) == expected
    assert duplicate_length([curve]) == 0


@pytest.mark.parametrize(
    ("many", "length"),
    [
        ([Line((0, 0), (10, 0)), Line((5, 0), (20, 0))], 5),
        ([Line((0, 0), (10, 0)), Line((10, 0), (20, 0))], 0),
        ([Line((0, 0), (10, 0)), Line((0, 1), (10, 1))], 0),
        ([Line((0, 0), (0, 9)), Line((0, 9), (0, 3))], 6),
        ([Line((0, 0), (3, 4))] * 3, 10),
        ([Line((0, 0), (30, 40)), Line((3, 4), (6, 8)), Line((40, 30), (0, 0))], 5),
        ([Arc((0, 0), 5, 0, 360), Arc((0, 0), 5, 350, 20)], 5 * radians(20)),
        ([Arc((0, 0), 5, 0, 90), Arc((0, 0), 5, 90, -45)], 5 * radians(45)),
        ([Arc((0, 0), 5, 0, 360), Arc((0, 0), 5, 90, -360)], 10 * pi),
        ([Arc((0, 0), 5, 0, 90), Arc((0, 0), 5.1, 0, 90)], 0),
        ([CUBIC, CUBIC.reversed()], CUBIC.length),
        ([CUBIC, Bezier(((0, 0), (0, 10), (10, 10), (10, 4)))], 0),
        ([SPLINE, SPLINE.reversed()], SPLINE.length),
        ([ELLIPSE, EllipseArc((0, 0), (-10, 0), 0.5, 90, -360)], ELLIPSE.length),
        ([ELLIPSE, EllipseArc((0, 0), (0, 10), 0.5, 0, 360)], 0),
        ([Bezier(((0, 0), (5, 5))), Bezier(((0, 5), (5, 0)))], 0),
    ],
)
def test_what_lies_twice(many, length: float) -> None:
    assert duplicate_length(many) == pytest.approx(length, abs=1e-9)


def test_measures_tell_their_lengths() -> None:
    measures = Measures((CUBIC,), (Line((0, 0), (3, 4)), CUBIC), (("TEXT", 2),))
    assert total_length(measures.filled) == pytest.approx(CUBIC.length)
    assert total_length(measures.hidden) == pytest.approx(5 + CUBIC.length)


def test_a_sheet_of_many_lines_on_one_carrier_takes_no_square_of_them() -> None:
    row = [Line((10.0 * k, 0.0), (10.0 * k + 6.0, 0.0)) for k in range(20_000)]
    assert duplicate_length([*row, *row[::2]]) == pytest.approx(6 * 10_000)
