"""What the reader does in its own way for speed is what the curves do themselves."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Bezier, BSpline, EllipseArc, Line
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.readers.drawing import is_in_bounds
from beamcam.readers.svg.walk import _has_length, _moved

numbers = st.floats(-1e6, 1e6)
points = st.tuples(numbers, numbers)
rows = st.tuples(numbers, numbers, numbers)
chains = st.lists(points, min_size=2, max_size=6).map(
    lambda row: [Line(a, b) for a, b in pairwise(row)] + [Bezier((row[-1], (0.0, 1.0), row[0]))]
)
arcs = st.builds(
    Arc,
    points,
    st.floats(1e-12, 1e6),
    st.floats(-720, 720),
    st.sampled_from([360.0, -360.0, 90.0, 1e-13]),
)


@given(chains, rows, rows)
def test_moved_chains_are_their_images(chain, x, y) -> None:
    assert repr(_moved(chain, (x, y))) == repr(tuple(c.transformed((x, y)) for c in chain))


@given(arcs)
def test_an_arc_has_a_length_where_its_box_has_one(arc) -> None:
    assert _has_length(arc) == (arc.start != arc.end or arc.bbox[:2] != arc.bbox[2:])


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
