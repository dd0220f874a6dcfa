"""Facets of a section become the arcs of the cylinders that they stand for."""

from math import cos, hypot, radians, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Line, Point
from beamcam.readers.ifc.region import Circles, circles_in, on_circles
from beamcam.readers.ifc.space import Cylinder

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def on(centre: Point, radius: float, at_deg: float) -> Point:
    at = radians(at_deg)
    return centre[0] + radius * cos(at), centre[1] + radius * sin(at)


@given(
    st.tuples(st.floats(-1e4, 1e4), st.floats(-1e3, 1e3)),
    st.floats(1.0, 500.0),
    st.floats(0.0, 360.0),
    st.lists(st.floats(3.0, 25.0), min_size=1, max_size=8),
    st.sampled_from([1, -1]),
)
def test_facets_of_any_length_are_one_arc(
    centre: Point, radius: float, first: float, steps: list[float], way: int
) -> None:
    """Even of a single facet, which no circle can be laid through."""
    at = [first + way * sum(steps[:i]) for i in range(len(steps) + 1)]
    points = [on(centre, radius, a) for a in at]
    far = (centre[0] + 3 * radius, centre[1] + 3 * radius)
    ring = [*points, far]
    chain = tuple(Line(p, ring[(i + 1) % len(ring)]) for i, p in enumerate(ring))
    found = on_circles(chain, Circles([(centre, radius)], facets=True))
    assert [type(c) for c in found] == [Arc, Line, Line]
    (arc, *_) = found
    assert isinstance(arc, Arc)
    assert (arc.centre, arc.radius) == (centre, radius)
    assert arc.sweep_deg == pytest.approx(way * sum(steps), abs=1e-6)
    ends = zip((arc.start, arc.end), (points[0], points[-1]), strict=True)
    assert all(hypot(p[0] - q[0], p[1] - q[1]) < 1e-6 for p, q in ends)


def test_what_is_no_facet_of_the_circle_stays() -> None:
    circle = ((0.0, 0.0), 10.0)
    side = Line(on((0, 0), 10, 0), on((0, 0), 10, 40))  # wider than any facet
    off = Line(on((0, 0), 10.001, 0), on((0, 0), 10.001, 10))
    for line in (side, off):
        assert on_circles((line,), Circles([circle], facets=True)) == (line,)
        assert on_circles((line,), Circles()) == (line,)


def test_circles_are_those_square_to_the_normal_each_once() -> None:
    upright = Cylinder((3.0, 4.0, 9.0), Z, 5.0)
    turned = Cylinder((3.0, 4.0, -9.0), (0.0, 0.0, -1.0), 5.0)
    lying = Cylinder((3.0, 4.0, 9.0), X, 5.0)
    wider = Cylinder((3.0, 4.0, 9.0), Z, 6.0)
    every = (upright, turned, lying, wider)
    assert circles_in(every, Z, X, Y).known == [((3.0, 4.0), 5.0), ((3.0, 4.0), 6.0)]
    assert circles_in(every, X, Y, Z).known == [((4.0, 9.0), 5.0)]
