"""Which coordinates are taken for those of a drawing."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Bezier, BSpline, EllipseArc, Line
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.readers.drawing import is_in_bounds


@given(st.lists(st.floats(), min_size=4, max_size=4))
def test_coordinates_in_bounds(values) -> None:
    x, y, z, w = values
    wanted = all(abs(v) <= MAX_COORDINATE for v in values)
    assert is_in_bounds(Line((x, y), (z, w))) == wanted
    assert is_in_bounds(Bezier(((x, y), (z, w)))) == wanted
    assert is_in_bounds(EllipseArc((x, y), (z, w), 0.5, 0.0, 90.0)) == wanted
    assert not is_in_bounds(Arc((x, y), float("inf"), z, w))


@pytest.mark.parametrize("knot", [float("inf"), float("nan"), 1e300])
def test_a_knot_beyond_all_numbers_is_out_of_bounds(knot: float) -> None:
    control = ((0.0, 0.0), (1.0, 2.0), (2.0, 0.0))
    assert is_in_bounds(BSpline(2, control, (0.0, 0.0, 0.0, 1.0, 1.0, 1.0)))
    assert not is_in_bounds(BSpline(2, control, (0.0, 0.0, 0.0, 1.0, 1.0, knot)))
