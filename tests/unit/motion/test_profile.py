"""Profiles whose numbers are known."""

from math import inf

import pytest

from beamcam.motion.velocity_profile import (
    AxisLimits,
    fastest_profile,
    profile_over_distance,
    profile_through,
    profile_to_velocity,
)

GUIDE = profile_to_velocity(1000.0, 100.0, 50.0)


def test_the_linear_guide_reaches_1000_rpm_in_100_s():
    assert [p.duration_s for p in GUIDE.phases] == [25, 50, 25]
    assert max(p.acceleration for p in GUIDE.phases) == pytest.approx(40 / 3)
    assert GUIDE.sample([25, 75, 100])[1] == pytest.approx([500 / 3, 2500 / 3, 1000])
    assert GUIDE.sample(100.0)[1] == 1000.0


@pytest.mark.parametrize(("percent", "durations"), [(0, [10]), (100, [5, 5]), (20, [1, 8, 1])])
def test_trapezoid_and_fully_rounded_ramps(percent, durations):
    profile = profile_to_velocity(5.0, 10.0, percent)
    assert [p.duration_s for p in profile.phases] == pytest.approx(durations)
    assert profile.distance == 25


def test_a_triangle_peaks_at_twice_the_mean_velocity():
    profile = profile_over_distance(100.0, 10.0, 0.0)
    assert profile.sample(5.0)[1] == 20
    assert [p.acceleration for p in profile.phases] == [4, -4]


def test_a_trapezoid_cruises():
    profile = profile_over_distance(100.0, 10.0, 0.0, cruise_s=6.0)
    assert profile.sample([2.0, 8.0])[1] == pytest.approx([12.5, 12.5])


def test_points_are_joined_and_equal_ones_are_a_cruise():
    profile = profile_through([(5, 0), (7, 10), (9, 10), (10, 0)], 100.0)
    assert profile.distance == 10 + 20 + 5
    assert profile.sample(3.0)[2] == 0
    assert profile.duration_s == 5


@pytest.mark.parametrize(
    ("distance", "jerk", "duration"),
    [
        (1.0, inf, 2 * (1 / 100) ** 0.5),  # triangle: 2 sqrt(s / a)
        (100.0, inf, 100 / 50 + 50 / 100),  # trapezoid: s / v + v / a
        (1000.0, 1000.0, 1000 / 50 + 50 / 100 + 100 / 1000),  # s / v + v / a + a / j
        (0.002, 1000.0, 4 * (0.001 / 1000) ** (1 / 3)),  # jerk alone: (32 s / j)^(1/3)
    ],
)
def test_fastest_from_rest_to_rest(distance, jerk, duration):
    profile = fastest_profile(distance, AxisLimits(50.0, 100.0, jerk))
    assert profile.duration_s == pytest.approx(duration, rel=1e-12)


def test_no_way_takes_no_time():
    profile = fastest_profile(0.0, AxisLimits(50.0, 100.0))
    assert (profile.phases, profile.duration_s) == ((), 0.0)
    assert profile.sample([-1.0, 0.0, 1.0])[1].tolist() == [0, 0, 0]


def test_outside_its_time_a_profile_goes_on():
    assert GUIDE.sample([-5, 105])[1].tolist() == [0, 1000]
    assert GUIDE.sample([-5, 105])[0].tolist() == [0, 55_000]
    assert GUIDE.sample([-5, 105])[2].tolist() == [0, 0]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: profile_to_velocity(1, 0, 50), "time must be above 0 s, found 0"),
        (lambda: profile_to_velocity(1, 1, 101), "jerk must be 0 to 100 %, found 101"),
        (lambda: profile_over_distance(1, 2, 0, 2), "a cruise of 2 s leaves no ramps in 2 s"),
        (lambda: profile_through([(0, 1)], 0), "2 points or more, found 1"),
        (lambda: profile_through([(1, 1), (1, 2)], 0), "times must rise, found 1 s after 1 s"),
        (lambda: AxisLimits(1, 0), "limit of acceleration must be above 0"),
        (lambda: fastest_profile(-inf, AxisLimits(10, 1)), "the distance must be a number of mm"),
    ],
)
def test_what_is_no_profile_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
