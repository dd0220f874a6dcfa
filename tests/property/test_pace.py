"""Laws of the feeds that a program tells: no axis is asked for more than it can do."""

from math import cos, dist, hypot, inf, radians, sin

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from beamcam.checks.sheets.feeds import expected_feeds
from beamcam.controllers.events import Move
from beamcam.controllers.moves import moves_of
from beamcam.geometry.curves import Arc, Bezier, EllipseArc
from beamcam.geometry.plane import cross
from beamcam.machine.machine import PathLimits
from beamcam.model.program import ArcFeed, EllipseFeed, Feed, ParabolaFeed, SetFeed
from beamcam.motion.sheet import SECONDS_PER_MINUTE, paced
from beamcam.motion.speeds import (
    calm_radius,
    min_radius_of_ellipse,
    min_radius_of_parabola,
    turning_mm_s,
)
from tests.conftest import examples

coordinates = st.floats(-50, 50).map(lambda v: round(v, 3))
points = st.tuples(coordinates, coordinates)
offsets = st.floats(-20, 20).map(lambda v: round(v, 3))
limits_of_tables = st.builds(
    PathLimits,
    st.sampled_from([10.0, 40.0, 400.0]),
    st.sampled_from([15.0, 60.0, 400.0]),
    st.just(300.0),
    st.just(300.0),
    st.sampled_from([100.0, 1000.0]),
    st.sampled_from([2000.0, 1e5, inf]),
    st.just(0.0),
)
moves = st.one_of(
    st.builds(Feed, coordinates, coordinates),
    st.builds(ArcFeed, coordinates, coordinates, offsets, offsets, st.booleans()),
    st.builds(ParabolaFeed, coordinates, coordinates, offsets, offsets),
    st.builds(
        EllipseFeed, coordinates, coordinates, offsets, offsets,
        st.floats(-180, 180), st.floats(0.05, 1), st.booleans(),
    ),
)  # fmt: skip


def leg_of(here, move):
    """The move as the read-back knows it."""
    end = move.x, move.y
    centre = (here[0] + getattr(move, "i", 0.0), here[1] + getattr(move, "j", 0.0))
    curve = None
    if isinstance(move, ArcFeed):
        curve = Arc(centre, hypot(move.i, move.j), 0.0, 90.0)
    elif isinstance(move, ParabolaFeed):
        control = tuple(2 * c - (a + b) / 2 for c, a, b in zip(centre, here, end, strict=True))
        curve = Bezier((here, control, end))
    elif isinstance(move, EllipseFeed):
        c, s = cos(radians(move.angle)), sin(radians(move.angle))
        across = (s * move.i - c * move.j) / move.ratio
        major = hypot(c * move.i + s * move.j, across)
        curve = EllipseArc(centre, (major * c, major * s), move.ratio, 0.0, 360.0)
    return Move(1, False, here, end, 0.0, False, curve)


def bends(move):
    return isinstance(move, Feed) or hypot(move.i, move.j) > 0.01


@settings(max_examples=examples(300), deadline=None)
@given(points, st.lists(moves, min_size=1, max_size=8), st.floats(1, 120), limits_of_tables)
def test_every_move_has_the_feed_that_the_read_back_expects(start, chain, asked, limits):
    assume(all(map(bends, chain)))
    found = list(paced(start, chain, asked * SECONDS_PER_MINUTE, [1.0] * len(chain), limits))
    assert [step for step in found if not isinstance(step, SetFeed)] == chain
    feed, here = asked * SECONDS_PER_MINUTE, start
    for before, step in zip([None, *found], found, strict=False):
        if isinstance(step, SetFeed):
            assert not isinstance(before, SetFeed)
            assert step.feed_mm_min != feed
            feed = step.feed_mm_min
            continue
        if (step.x, step.y) != here:
            row = np.array([asked * SECONDS_PER_MINUTE])
            (expected,) = expected_feeds(moves_of([leg_of(here, step)]), row, limits)
            assert feed == pytest.approx(expected, rel=1.1e-3, abs=1e-6)
            assert feed <= asked * SECONDS_PER_MINUTE
        here = step.x, step.y


@settings(max_examples=examples(200), deadline=None)
@given(points, points, points)
def test_the_least_radius_of_a_parabola_is_the_least_of_many(start, vertex, end):
    control = tuple(2 * v - (a + b) / 2 for v, a, b in zip(vertex, start, end, strict=True))
    curve = Bezier((start, control, end))
    legs = [(b[0] - a[0], b[1] - a[1]) for a, b in ((start, control), (control, end))]
    assume(abs(cross(*legs)) > 0.01)
    radius = min_radius_of_parabola(start, vertex, end)
    bend = max(abs(curve.curvature(k / 500)) for k in range(501))
    if radius > 0.01:
        assert radius <= 1 / max(bend, 1e-12) * (1 + 1e-6) or radius == inf
        assert bend <= 1 / radius * (1 + 1e-6)


@settings(max_examples=examples(100), deadline=None)
@given(points, st.floats(0.5, 100), st.floats(0.05, 1), st.floats(0, 360), st.floats(0, 360))
def test_the_least_radius_of_an_ellipse_is_that_of_its_sharp_end(centre, major, ratio, turn, at):
    axis = (major * cos(radians(turn)), major * sin(radians(turn)))
    curve = EllipseArc(centre, axis, ratio, 0.0, 360.0)
    on_it = tuple(p - c for p, c in zip(curve.point(at / 360), centre, strict=True))
    radius = min_radius_of_ellipse(on_it, turn, ratio)
    a, b, c = (curve.point(t) for t in (1 - 1e-5, 0.0, 1e-5))
    twice_area = cross((b[0] - a[0], b[1] - a[1]), (c[0] - a[0], c[1] - a[1]))
    around = dist(a, b) * dist(b, c) * dist(c, a) / (2 * twice_area)
    assert radius == pytest.approx(around, rel=1e-3)


@given(st.floats(0.5, 300), limits_of_tables)
def test_radius_and_speed_answer_each_other(speed, limits):
    radii = np.array([calm_radius(speed, limits)])
    assert turning_mm_s(radii, limits)[0] == pytest.approx(min(speed, limits.speed_mm_s))
