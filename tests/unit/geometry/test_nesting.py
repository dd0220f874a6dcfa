"""Holes in sheets and islands in holes."""

import random

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.nesting import Nested, nest_chains, points_inside, polygon_of


def circle(x, y, r):
    return (Arc((x, y), r, 0, 360),)


def square(x, y, size):
    h = size / 2
    corners = [(x - h, y - h), (x + h, y - h), (x + h, y + h), (x - h, y + h)]
    return tuple(Line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))


def test_sheet_hole_island_and_a_part_beside():
    chains = [
        circle(0, 0, 5),
        square(0, 0, 100),
        circle(0, 0, 1),
        circle(30, 0, 5),
        square(200, 0, 9),
    ]
    assert nest_chains(chains) == (
        Nested(1, 1), Nested(0, None), Nested(2, 0), Nested(1, 1), Nested(0, None),
    )  # fmt: skip


def test_a_hole_in_the_box_but_not_in_the_ring():
    corner = (Line((0, 0), (100, 0)), Line((100, 0), (0, 100)), Line((0, 100), (0, 0)))
    assert nest_chains([corner, circle(80, 80, 5)])[1] == Nested(0, None)
    assert nest_chains([corner, circle(20, 20, 5)])[1] == Nested(1, 0)


def test_a_hole_that_touches_the_edge_is_inside():
    assert nest_chains([square(0, 0, 100), circle(45, 0, 5)])[1] == Nested(1, 0)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 12))
def test_rings_within_rings_in_any_order(seed, count):
    dice = random.Random(seed)
    chains = [dice.choice([circle, square])(0, 0, 10.0 * 2**k) for k in range(count)]
    order = list(range(count))
    dice.shuffle(order)
    nested = nest_chains([chains[k] for k in order])
    for place, k in enumerate(order):
        around = nested[place].parent
        assert nested[place].depth == count - 1 - k
        assert (None if around is None else order[around]) == (k + 1 if k + 1 < count else None)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), st.integers(3, 30))
def test_insides_agree_with_another_library(seed, corners):
    dice = np.random.default_rng(seed)
    turn = np.sort(dice.uniform(0, 2 * np.pi, corners))
    reach = dice.uniform(1, 10, corners)
    ring = np.column_stack((reach * np.cos(turn), reach * np.sin(turn)))
    points = dice.uniform(-10, 10, (200, 2))
    expected = shapely.contains_xy(shapely.Polygon(ring).buffer(0), *points.T)
    if shapely.Polygon(ring).is_valid:
        assert np.array_equal(points_inside(points, ring), expected)


def test_polygons_pass_through_their_corners():
    assert polygon_of(square(0, 0, 2)).tolist() == [[-1, -1], [1, -1], [1, 1], [-1, 1]]
