"""Laws of the times of moves: what takes how long, without an array."""

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.ramps import move_seconds, ramp_seconds
from beamcam.motion.profile import AxisLimits, stretch_seconds
from tests.conftest import examples
from tests.property.test_profile import duration_by_ruckig

amounts = st.floats(0.01, 1e4)
jerks = st.one_of(amounts, st.just(inf))


@settings(max_examples=examples(300), deadline=None)
@given(amounts, amounts, amounts, jerks)
def test_no_move_is_faster_than_its_velocity(distance, velocity, acceleration, jerk):
    seconds = move_seconds(distance, velocity, acceleration, jerk)
    assert seconds >= distance / velocity
    assert seconds == move_seconds(-distance, velocity, acceleration, jerk)
    assert move_seconds(0.0, velocity, acceleration, jerk) == 0.0


@settings(max_examples=examples(300), deadline=None)
@given(st.lists(amounts, min_size=2, max_size=2), amounts, amounts, jerks)
def test_a_longer_move_never_takes_less_time(distances, velocity, acceleration, jerk):
    near, far = (move_seconds(d, velocity, acceleration, jerk) for d in sorted(distances))
    assert near <= far * (1 + 1e-12)


@settings(max_examples=examples(300), deadline=None)
@given(amounts, amounts, amounts, amounts, st.floats(1, 10))
def test_more_of_any_limit_never_takes_longer(distance, velocity, acceleration, jerk, more):
    seconds = move_seconds(distance, velocity, acceleration, jerk) * (1 + 1e-9)
    assert move_seconds(distance, velocity * more, acceleration, jerk) <= seconds
    assert move_seconds(distance, velocity, acceleration * more, jerk) <= seconds
    assert move_seconds(distance, velocity, acceleration, jerk * more) <= seconds
    assert move_seconds(distance, velocity, acceleration) <= seconds


def test_a_thousand_moves_take_as_long_as_ruckigs():
    dice = np.random.default_rng(5)
    for _ in range(1000):
        v, a, j, way = (10.0 ** dice.uniform(-2, 4, 4)).tolist()
        expected = duration_by_ruckig(AxisLimits(v, a, j), way, 0.0, 0.0)
        assert move_seconds(way, v, a, j) == pytest.approx(expected, rel=1e-3)


def ramp_distance(v0, v1, acceleration, jerk):
    """The mean velocity of a ramp times its time."""
    return (v0 + v1) / 2 * ramp_seconds(abs(v1 - v0), acceleration, jerk)


def test_a_thousand_stretches_take_as_long_as_ruckigs():
    dice = np.random.default_rng(7)
    for _ in range(1000):
        v, a, j, way = (10.0 ** dice.uniform(-2, 4, 4)).tolist()
        first, last = (v * dice.choice([0.0, 1.0], 2) * dice.uniform(0, 1, 2)).tolist()
        least = ramp_distance(first, last, a, j)
        (seconds,) = stretch_seconds(*np.array([[least + way], [first], [last], [v], [a], [j]]))
        assert seconds >= ramp_seconds(abs(first - last), a, j) * (1 - 1e-9)
        # Next to the least distance ruckig gives up.
        if least + way >= 1.05 * least:
            expected = duration_by_ruckig(AxisLimits(v, a, j), least + way, first, last)
            assert seconds == pytest.approx(expected, rel=1e-3)


@given(amounts, amounts, amounts, jerks)
def test_a_stretch_from_rest_to_rest_is_a_move(way, velocity, acceleration, jerk):
    values = np.array([[way], [0.0], [0.0], [velocity], [acceleration], [jerk]])
    expected = move_seconds(way, velocity, acceleration, jerk)
    assert stretch_seconds(*values) == pytest.approx(expected, rel=1e-6)
