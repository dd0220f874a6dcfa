"""Look-ahead where the answer is known."""

from math import sqrt

import numpy as np
import pytest

from beamcam.motion.lookahead import LookAheadRules, plan_speeds
from beamcam.motion.profile import AxisLimits
from tests.path_samples import entries

AXIS = AxisLimits(200.0, 1000.0, 1e9)
RULES = LookAheadRules((AXIS, AXIS))


def test_a_right_angle_is_passed_at_grbls_speed():
    path = plan_speeds([(0, 0), (100, 0), (100, 100)], 100.0, RULES)
    half = sqrt(0.5)
    # Both axes help along the diagonal: the acceleration there is 1000 sqrt(2).
    expected = sqrt(1000 * sqrt(2) * 0.01 * half / (1 - half))
    assert entries(path).tolist() == pytest.approx([0.0, expected], rel=1e-9)


def test_a_reversal_stops():
    path = plan_speeds([(0, 0), (100, 0), (0, 0)], 100.0, RULES)
    assert entries(path).tolist() == [0, 0]


def test_deviation_0_stops_at_corners():
    path = plan_speeds([(0, 0), (9, 0), (9, 9)], 100.0, LookAheadRules((AXIS, AXIS), 0.0))
    assert entries(path).tolist() == [0, 0]


def test_the_slow_axis_sets_the_pace_of_a_diagonal():
    slow = AxisLimits(10.0, 1000.0, 1e9)
    path = plan_speeds([(0, 0), (300, 400)], 100.0, LookAheadRules((AXIS, slow)))
    assert np.max(path.phase_velocity) == pytest.approx(12.5)


def test_speeds_of_segments_are_kept():
    path = plan_speeds([(0, 0), (100, 0), (200, 0)], [100.0, 20.0], RULES)
    assert entries(path).tolist() == pytest.approx([0.0, 20.0])
    first = path.phase_segment == 0
    assert max(path.phase_velocity[~first]) == pytest.approx(20.0)
    assert max(path.phase_velocity[first]) == pytest.approx(100.0)
    assert path.duration_s == pytest.approx(6.0, abs=0.2)


def test_three_axes():
    rules = LookAheadRules((AXIS, AXIS, AXIS))
    path = plan_speeds([(0, 0, 0), (10, 10, 10), (20, 20, 20)], 50.0, rules)
    assert entries(path)[1] == pytest.approx(50.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: plan_speeds([(0, 0)], 1, RULES), r"points for 2 axes, found shape \(1, 2\)"),
        (lambda: plan_speeds([(0, 0, 0), (1, 1, 1)], 1, RULES), r"found shape \(2, 3\)"),
        (lambda: plan_speeds([(0, 0), (1, 0), (1, 0)], 1, RULES), "segment 2 has no length"),
        (lambda: plan_speeds([(0, 0), (1, 0)], 0, RULES), "speeds must be above 0, found 0"),
        (lambda: LookAheadRules((AXIS,), -1.0), "deviation must be 0 or more, found -1"),
    ],
)
def test_what_is_no_path_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
