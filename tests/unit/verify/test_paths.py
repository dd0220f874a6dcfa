"""Distances from a polyline, against a plain search along it."""

from itertools import pairwise
from math import hypot

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.verify.paths import distance_to

points = st.tuples(st.floats(-50, 50), st.floats(-50, 50))


@settings(deadline=None, max_examples=150)
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
