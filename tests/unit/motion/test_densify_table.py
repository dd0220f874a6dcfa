"""Tables of densified paths whose points are known."""

from math import sqrt

import numpy as np
import pytest

from beamcam.geometry.curves import Arc, Bezier, EllipseArc, Line, NewtonCurve
from beamcam.motion.densify import DensifyRules, densify, truncated
from beamcam.motion.lookahead import LookAheadRules, plan_speeds
from beamcam.motion.spans import chord_step_rad
from beamcam.motion.velocity_profile import AxisLimits
from tests.path_samples import entries

ELLIPSE = EllipseArc((0, 0), (9, 0), 0.5, 0, 90)


@pytest.mark.parametrize(
    ("radius", "tolerance", "points"),
    [(5, 0.01, 50), (50, 0.01, 158), (500, 0.01, 497), (5, 0.001, 158), (500, 0.001, 1571)],
)
def test_points_of_a_circle(radius, tolerance, points):
    result = densify((Arc((0, 0), radius, 0, 360),), DensifyRules(tolerance))
    assert len(result.points) == points + 1
    assert result.points[0].tolist() == result.points[-1].tolist() == [radius, 0]


def test_a_step_never_passes_90_degrees():
    result = densify((Arc((0, 0), 1, 0, -360),), DensifyRules(10))
    assert result.points == pytest.approx(np.array([(1, 0), (0, -1), (-1, 0), (0, 1), (1, 0)]))


def test_lines_are_left_alone():
    path = (Line((0, 0), (10, 0)), Line((10, 0), (10, 5)))
    result = densify(path, DensifyRules(0.01))
    assert result.points.tolist() == [[0, 0], [10, 0], [10, 5]]


def test_points_are_read_only():
    result = densify((Line((0, 0), (10, 0)),), DensifyRules(0.01))
    with pytest.raises(ValueError, match="read-only"):
        result.points[0, 0] = 1


def test_newton_polynomial_ends_on_its_last_node():
    curve = NewtonCurve(((10, 11), (40, 22), (60, 20), (90, 5)))
    result = densify((curve,), DensifyRules(0.01, 1000))
    assert result.points[-1].tolist() == [90, 5]


def test_speed_is_lowered_where_points_come_too_fast():
    path = (Line((0, 0), (40, 0)), Arc((40, 10), 10, -90, 90), Line((50, 10), (50, 50)))
    result = densify(path, DensifyRules(0.01, speed_mm_s=20, cycle_s=0.025))
    slowed = np.flatnonzero(result.speeds_mm_s < 20)
    assert slowed.tolist() == list(range(1, len(result.points) - 2))
    chord = 20 * np.sin(np.pi / 4 / (len(result.points) - 3))
    assert result.speeds_mm_s[slowed] == pytest.approx(chord / (3 * 0.025))
    assert result.speeds_mm_s[0] == result.speeds_mm_s[-1] == 20


def test_straight_free_curves_cost_one_step():
    cubic = Bezier(((0, 0), (1, 1), (5, 5), (9, 9)))
    assert len(densify((cubic,), DensifyRules(0.001)).points) == 2


def test_points_that_rounding_makes_one_are_put_out_once():
    path = (Line((0, 0), (0.01, 0)), Line((0.01, 0), (5, 0)))
    result = densify(path, DensifyRules(0.2, 8))
    assert len(result.points) == 2
    tiny = densify((Line((0, 0), (0.01, 0)),), DensifyRules(0.2, 8))
    assert len(tiny.points) == 1


def test_a_gap_between_curves_is_paid_out_of_the_tolerance():
    path = (Line((0, 0), (10, 0)), Line((10, 0.004), (20, 0)))
    assert densify(path, DensifyRules(0.01)).deviation == pytest.approx(0.004)


def test_truncation_knows_decimal_numbers():
    points = np.array([[0.29, -0.29], [1.001, 0.0019999]])
    assert truncated(points, 1000).tolist() == [[0.29, -0.29], [1.001, 0.001]]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: densify((), DensifyRules(0.01)), "one curve or more"),
        (lambda: DensifyRules(0.0), "tolerance must be above 0, found 0"),
        (lambda: DensifyRules(0.1, speed_mm_s=0.0), "speed must be above 0, found 0"),
        (lambda: DensifyRules(0.1, cycle_s=-1.0), "no cycle rule: 3 cycles of -1 s"),
        (lambda: chord_step_rad(0.0, 1.0), "radius 0 and tolerance 1 must be above 0"),
        (
            lambda: densify((ELLIPSE,), DensifyRules(0.01, 8)),
            "tolerance 0.01 is used up: rounding takes 0.176777",
        ),
        (
            lambda: densify((Line((0, 0), (1, 0)), Line((2, 0), (3, 0))), DensifyRules(0.01)),
            r"the widest gap 1 \(before curve 2\)",
        ),
    ],
)
def test_what_cannot_be_densified_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()


# --- look-ahead -----------------------------------------------------------------------------------


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
