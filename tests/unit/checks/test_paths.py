"""Distances from a polyline, against a plain search along it."""

from itertools import pairwise
from math import acos, ceil, cos, hypot, radians

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.checks.bars.paths import FLAT, distance_to, line_error
from beamcam.geometry.curves import Arc
from tests.conftest import examples

points = st.tuples(st.floats(-50, 50), st.floats(-50, 50))


@settings(deadline=None, max_examples=examples(150))
@given(points, st.lists(points, min_size=1, max_size=6))
def test_the_distance_is_the_least_along_the_path(
    point: tuple[float, float], path: list[tuple[float, float]]
) -> None:
    steps = 400
    tried = [hypot(point[0] - path[0][0], point[1] - path[0][1])]
    for a, b in pairwise(path):
        for i in range(steps + 1):
            x, y = (a[k] + (b[k] - a[k]) * i / steps for k in (0, 1))
            tried.append(hypot(point[0] - x, point[1] - y))
    assert distance_to(point, path) <= min(tried) + 1e-6
    assert distance_to(point, path) == pytest.approx(min(tried), abs=0.36)


def test_a_path_of_one_point_and_one_that_stands_still() -> None:
    assert distance_to((3.0, 4.0), [(0.0, 0.0)]) == 5.0
    assert distance_to((3.0, 4.0), [(0.0, 0.0), (0.0, 0.0)]) == 5.0
    assert distance_to((5.0, 3.0), [(0.0, 0.0), (10.0, 0.0)]) == 3.0


@settings(deadline=None, max_examples=examples(25))
@given(
    st.floats(0.5, 100), st.floats(-360, 360).filter(lambda sweep: abs(sweep) > 5),
    st.sampled_from((0.005, 0.02, 0.1)),
)  # fmt: skip
def test_an_arc_is_measured_as_the_arc_it_is(radius: float, sweep: float, sagitta: float) -> None:
    """Chords are off by their sagitta, and by no more for the way that they are measured."""
    arc = Arc((10.0, -20.0), radius, 30.0, sweep)
    count = ceil(abs(radians(sweep)) / (2 * acos(1 - min(sagitta / radius, 0.5))))
    path = [arc.point(i / count) for i in range(count + 1)]
    exact = radius * (1 - cos(radians(sweep) / count / 2))
    for way in (path, path[::-1]):
        assert line_error((arc,), way) == pytest.approx(exact, abs=FLAT + 1e-9)
    off = [(x + 0.05, y) for x, y in path]
    assert line_error((arc,), off) >= 0.05 - exact - FLAT
