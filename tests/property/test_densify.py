"""Laws of densified paths: they stay within their stated deviation, and that in the tolerance."""

from math import acos, ceil, pi

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, BSpline, Line
from beamcam.geometry.polylines import points_at
from beamcam.motion.densify import DensifyRules, densify, truncated, worst_truncation
from tests.conftest import examples
from tests.distances import distances
from tests.property.curve_strategies import (
    arcs,
    beziers,
    curves,
    ellipses,
    newton_curves,
    radii,
    splines,
)

SAMPLES = 5000
FAMILIES = {
    "arcs": arcs,
    "ellipses": ellipses(),
    "beziers": beziers(),
    "splines": splines(),
    "polynomials": newton_curves(),
}
counts_a_mm = st.sampled_from([0, 8, 100, 1000])


@st.composite
def densify_rules(draw):
    counts = draw(counts_a_mm)
    tolerance = draw(st.sampled_from([0.001, 0.01, 0.05, 0.5, 5.0])) + worst_truncation(counts)
    return DensifyRules(
        tolerance,
        counts,
        draw(st.sampled_from([2.0, 20.0, 200.0])),
        draw(st.sampled_from([0.0, 0.002, 0.025])),
    )


def as_line(points):
    return shapely.LineString(points if len(points) > 1 else np.repeat(points, 2, axis=0))


@pytest.mark.parametrize("family", FAMILIES)
def test_no_point_of_a_curve_is_farther_than_certified(family):
    measured = []

    @settings(max_examples=examples(40), deadline=None)
    @given(FAMILIES[family], densify_rules(), st.integers(0, 2**32 - 1))
    def check(curve, rules, seed):
        result = densify((curve,), rules)
        t = np.random.default_rng(seed).uniform(0, 1, SAMPLES)
        away = distances(points_at(curve, t), as_line(result.points))
        assert np.max(away) <= result.deviation <= rules.tolerance
        measured.append(len(t))

    check()
    assert sum(measured) >= examples(40) * SAMPLES


@settings(max_examples=examples(40), deadline=None)
@given(curves, densify_rules())
def test_no_point_of_the_path_is_farther_from_the_curve(curve, rules):
    result = densify((curve,), rules)
    times = np.linspace(0, 1, SAMPLES + 1)
    fine = points_at(curve, times)
    slack = np.max(np.hypot(*np.diff(fine, axis=0).T)) ** 2 / 4 + 1e-4
    share = np.linspace(0, 1, 7)[:, None, None]
    between = result.points[:-1] + share * np.diff(result.points, axis=0)
    chosen = between.reshape(-1, 2)[:: max(1, between.size // 1000)]
    away = distances(chosen, as_line(fine))
    for place in chosen[away > result.deviation + slack]:  # the tip of a cusp between two samples
        k = int(np.argmin(np.hypot(*(fine - place).T)))
        beside = np.linspace(times[max(k - 1, 0)], times[min(k + 1, SAMPLES)], SAMPLES)
        finer = as_line(points_at(curve, beside))
        assert shapely.distance(shapely.Point(place), finer) <= result.deviation + slack


def test_the_path_comes_to_the_tip_of_a_cusp():
    there_and_back = ((0.0, 0.0), (0.0, 1.0), (0.0, 2.0), (0.0, 0.5))
    curve = BSpline(1, there_and_back, (0.0, 1.0, 2.0, 3.0, 4.0, 5.0))
    points = densify((curve,), DensifyRules(0.001)).points
    assert shapely.distance(shapely.Point(0.0, 2.0), as_line(points)) <= 0.001


@settings(max_examples=examples(100), deadline=None)
@given(st.lists(curves, min_size=1, max_size=4), densify_rules())
def test_a_path_of_several_curves_meets_every_joint(chosen, rules):
    path = []
    for curve in chosen:
        if path and path[-1].end != curve.start:
            path.append(Line(path[-1].end, curve.start))
        path.append(curve)
    result = densify(path, rules)
    joints = truncated(np.array([path[0].start, *(c.end for c in path)]), rules.counts)
    where = {tuple(p) for p in result.points.tolist()}
    assert {tuple(p) for p in joints.tolist()} <= where
    assert result.points[0].tolist() == joints[0].tolist()
    assert result.points[-1].tolist() == joints[-1].tolist()


@settings(max_examples=examples(100), deadline=None)
@given(curves, densify_rules())
def test_no_step_is_shorter_than_the_cycle_allows(curve, rules):
    result = densify((curve,), rules)
    lengths = np.hypot(*np.diff(result.points, axis=0).T)
    assert np.all(lengths > 0)
    assert np.all(result.speeds_mm_s <= rules.speed_mm_s)
    assert np.all(lengths >= 3 * result.speeds_mm_s * rules.cycle_s * (1 - 1e-12))


@settings(max_examples=examples(200), deadline=None)
@given(radii, st.sampled_from([0.001, 0.01, 0.1]), st.sampled_from([360.0, -360.0, 77.7]))
def test_circles_take_hardly_more_points_than_they_must(radius, tolerance, sweep):
    result = densify((Arc((0.0, 0.0), radius, 0.0, sweep),), DensifyRules(tolerance))
    step = min(pi / 2, 2 * acos(max(0.0, 1 - tolerance / radius)))
    least = ceil(abs(np.radians(sweep)) / step * (1 - 1e-8))
    assert least <= len(result.points) - 1 <= max(least, 1.02 * least)
    lengths = np.hypot(*np.diff(result.points, axis=0).T)
    assert np.ptp(lengths) <= 1e-10 * radius
    assert np.all(2 * np.arcsin(np.minimum(1, lengths / (2 * radius))) <= pi / 2 + 1e-9)


@settings(max_examples=examples(100), deadline=None)
@given(curves, counts_a_mm)
def test_truncating_twice_changes_nothing(curve, counts):
    points = points_at(curve, np.linspace(0, 1, 50))
    once = truncated(points, counts)
    assert np.array_equal(truncated(once, counts), once)
    assert np.max(np.hypot(*(once - points).T)) <= worst_truncation(counts) + 1e-9
    assert not np.any(np.signbit(once) & (once == 0.0)) or counts == 0
