"""Laws of velocity profiles."""

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruckig import InputParameter, Ruckig, Trajectory

from beamcam.motion.velocity_profile import (
    AxisLimits,
    fastest_profile,
    profile_by_acceleration,
    profile_over_distance,
    profile_through,
    profile_to_velocity,
)
from tests.conftest import examples

RANDOM_PROFILES = 10_000

amounts = st.floats(0.01, 1e4)
percents = st.one_of(st.sampled_from([0.0, 50.0, 100.0]), st.floats(0, 100))
time_points = st.tuples(st.floats(0.1, 100), st.floats(-1e3, 1e3))
limits_of_axes = st.builds(AxisLimits, amounts, amounts, st.one_of(amounts, st.just(inf)))


@st.composite
def tasks(draw):
    """Limits and a distance."""
    return draw(limits_of_axes), draw(st.floats(1e-6, 1e4))


def integral_of_velocity(profile):
    """Simpson's rule over each phase: exact, as velocity is a parabola there."""
    total = 0.0
    for p in profile.phases:
        h, v, a, j = p.duration_s, p.velocity, p.acceleration, p.jerk
        middle, end = v + h / 2 * (a + h / 2 * j / 2), v + h * (a + h * j / 2)
        total += h / 6 * (v + 4 * middle + end)
    return total


def check_joints(profile):
    """Position and velocity go on from phase to phase; acceleration too where jerk is finite."""
    size = max(abs(profile.distance), 1e-12)
    speed = max(abs(p.velocity) + abs(p.acceleration) * p.duration_s for p in profile.phases)
    ends = [*profile.phases[1:], None]
    for p, q in zip(profile.phases, ends, strict=True):
        h = p.duration_s
        x = p.position + h * (p.velocity + h * (p.acceleration / 2 + h * p.jerk / 6))
        v = p.velocity + h * (p.acceleration + h * p.jerk / 2)
        assert x == pytest.approx(q.position if q else profile.distance, abs=1e-9 * size)
        assert v == pytest.approx(q.velocity if q else profile.end_velocity, abs=1e-9 * speed)


@settings(max_examples=examples(300), deadline=None)
@given(tasks())
def test_fastest_profiles_join_keep_their_limits_and_arrive(task):
    limits, distance = task
    profile = fastest_profile(distance, limits)
    check_joints(profile)
    t = np.linspace(0, profile.duration_s, 200)
    x, v, a = profile.sample(t)
    assert (x[0], x[-1], v[0], v[-1]) == (0.0, distance, 0.0, 0.0)
    assert np.all((v >= -1e-9 * limits.velocity) & (v <= limits.velocity * (1 + 1e-9)))
    assert np.max(np.abs(a)) <= limits.acceleration * (1 + 1e-9)
    assert all(abs(p.jerk) <= limits.jerk * (1 + 1e-9) for p in profile.phases)
    assert np.all(np.diff(x) >= -1e-9 * distance)
    if limits.jerk < inf:
        jumps = np.abs(np.diff(a)) - np.diff(t) * limits.jerk
        assert np.all(jumps <= 1e-6 * limits.acceleration)


def duration_by_ruckig(limits, distance, v0, v1):
    asked, answer = InputParameter(1), Trajectory(1)
    asked.current_position, asked.target_position = [0.0], [distance]
    asked.current_velocity, asked.target_velocity = [v0], [v1]
    asked.max_velocity, asked.max_acceleration = [limits.velocity], [limits.acceleration]
    asked.max_jerk = [limits.jerk]
    Ruckig(1).calculate(asked, answer)
    return answer.duration


@settings(max_examples=examples(100), deadline=None)
@given(tasks())
def test_backwards_is_the_mirror_image(task):
    limits, distance = task
    ahead, back = (fastest_profile(s * distance, limits) for s in (1.0, -1.0))
    t = np.linspace(0, ahead.duration_s, 50)
    assert back.duration_s == ahead.duration_s
    assert np.array_equal(back.sample(t)[0], -ahead.sample(t)[0])


@settings(max_examples=examples(200), deadline=None)
@given(amounts, amounts, percents)
def test_ramps_by_velocity_and_by_acceleration_are_one(velocity, time_s, percent):
    by_velocity = profile_to_velocity(velocity, time_s, percent)
    check_joints(by_velocity)
    peak = max(p.acceleration for p in by_velocity.phases)
    again = profile_by_acceleration(peak, time_s, percent)
    assert again.end_velocity == pytest.approx(velocity, rel=1e-12)
    assert by_velocity.duration_s == pytest.approx(time_s, rel=1e-12)
    assert by_velocity.sample(time_s / 2)[1] == pytest.approx(velocity / 2, rel=1e-9)


@settings(max_examples=examples(200), deadline=None)
@given(amounts, amounts, percents, st.floats(0, 0.9))
def test_profiles_over_a_distance_start_and_end_at_rest(distance, time_s, percent, cruise):
    profile = profile_over_distance(distance, time_s, percent, cruise * time_s)
    check_joints(profile)
    assert profile.sample(profile.duration_s)[0] == distance
    assert profile.sample(profile.duration_s)[1] == 0.0
    top = profile.sample(profile.duration_s / 2)[1]
    assert top == pytest.approx(distance / (time_s * (1 + cruise) / 2), rel=1e-9)


@settings(max_examples=examples(200), deadline=None)
@given(st.lists(time_points, min_size=2, max_size=8), percents)
def test_profiles_pass_through_their_points(steps, percent):
    times = np.cumsum([t for t, _ in steps])
    profile = profile_through(list(zip(times, [v for _, v in steps], strict=True)), percent)
    check_joints(profile)
    found = profile.sample(times - times[0])[1]
    assert found == pytest.approx([v for _, v in steps], abs=1e-8)


def test_ten_thousand_profiles_arrive_and_take_no_longer_than_ruckigs():
    dice = np.random.default_rng(11)
    worst = slowest = 0.0
    for _ in range(RANDOM_PROFILES):
        v, a, j, distance = 10.0 ** dice.uniform(-2, 4, 4)
        limits = AxisLimits(v, a, j)
        profile = fastest_profile(distance, limits)
        worst = max(worst, abs(integral_of_velocity(profile) / distance - 1))
        peak = max(abs(p.acceleration) for p in profile.phases)
        assert peak <= a * (1 + 1e-12)
        expected = duration_by_ruckig(limits, distance, 0.0, 0.0)
        slowest = max(slowest, profile.duration_s / expected)
    assert worst <= 1e-9
    assert slowest <= 1.001
