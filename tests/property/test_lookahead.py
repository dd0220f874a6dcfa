"""Laws of the look-ahead: no axis is asked for too much, and nothing is left without room."""

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Line
from beamcam.motion.densify import DensifyRules, densify
from beamcam.motion.lookahead import LookAheadRules, plan_speeds
from beamcam.motion.speeds import reachable_speed
from beamcam.motion.velocity_profile import AxisLimits, fastest_profile
from tests.conftest import examples
from tests.path_samples import entries, positions
from tests.property.curve_strategies import curves
from tests.property.test_one_time import ramp_distance

axes = st.builds(
    AxisLimits,
    st.sampled_from([20.0, 100.0, 500.0]),
    st.sampled_from([50.0, 1000.0, 5000.0]),
    st.sampled_from([500.0, 20_000.0, 1e6, inf]),
)
rules_of_tables = st.builds(
    lambda x, y, d: LookAheadRules((x, y), d), axes, axes, st.sampled_from([0.0, 0.01, 0.1])
)


@st.composite
def polylines(draw):
    """Random walks, zigzags, straight lines in pieces, densified curves."""
    dice = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(1, 60))
    kind = draw(st.sampled_from(["walk", "tiny", "straight", "zigzag", "curve"]))
    if kind == "curve":
        rules = DensifyRules(draw(st.sampled_from([0.003, 0.05])), 1000)
        points = densify((draw(curves),), rules).points
        return points if len(points) > 1 else np.array([[0.0, 0.0], [1.0, 0.0]])
    steps = dice.normal(size=(count, 2)) * 10.0 ** dice.uniform(-3, 2, size=(count, 1))
    if kind == "tiny":
        steps = np.array([1.0, 0.3]) + dice.normal(size=(count, 2)) * 0.01
        steps *= draw(st.sampled_from([0.01, 0.3]))
    elif kind == "straight":
        steps = np.outer(dice.uniform(0.01, 5, count), [0.6, 0.8])
    elif kind == "zigzag":
        steps = np.column_stack((np.ones(count), (-1.0) ** np.arange(count))) * 5
    return np.concatenate((np.zeros((1, 2)), np.cumsum(steps, axis=0)))


@settings(max_examples=examples(200), deadline=None)
@given(polylines(), rules_of_tables, st.sampled_from([5.0, 50.0, 400.0]))
def test_no_axis_passes_its_limits_and_every_segment_is_made(points, rules, speed):
    path = plan_speeds(points, speed, rules)
    assert np.all(path.phase_duration_s > 0)
    limit = {
        name: np.array([getattr(axis, name) for axis in rules.axes])
        for name in ("velocity", "acceleration", "jerk")
    }
    along = np.abs(path.directions[path.phase_segment])
    assert np.all(along * np.abs(path.phase_jerk)[:, None] <= limit["jerk"] * (1 + 1e-9))
    # Samples over every phase, its ends included.
    shares = np.linspace(0, 1, 9)[:, None]
    s = shares * path.phase_duration_s
    v = path.phase_velocity + s * (path.phase_acceleration + s * path.phase_jerk / 2)
    a = path.phase_acceleration + s * path.phase_jerk
    assert np.all(v >= -1e-6 * speed)
    assert np.all(v <= speed * (1 + 1e-6))
    assert np.all(along * np.abs(v)[..., None] <= limit["velocity"] * (1 + 1e-6))
    assert np.all(along * np.abs(a)[..., None] <= limit["acceleration"] * (1 + 1e-6))
    # From phase to phase: time and speed go on, acceleration too where jerk is finite.
    starts = np.cumsum(path.phase_duration_s) - path.phase_duration_s
    assert path.phase_start_s == pytest.approx(starts, abs=1e-9 * path.duration_s)
    assert path.duration_s == pytest.approx(np.sum(path.phase_duration_s), rel=1e-9)
    assert v[-1, :-1] == pytest.approx(path.phase_velocity[1:], abs=1e-5 * speed)
    assert v[0, 0] == 0.0
    assert abs(v[-1, -1]) <= 1e-5 * speed
    if max(limit["jerk"]) < inf:
        jump = np.abs(a[-1, :-1] - path.phase_acceleration[1:])
        assert np.all(jump <= 1e-4 * max(limit["acceleration"]))
    # Every segment is travelled from its start to its end.
    gone = s[-1] * (
        path.phase_velocity + s[-1] * (path.phase_acceleration / 2 + s[-1] * path.phase_jerk / 6)
    )
    made = np.bincount(path.phase_segment, gone, minlength=len(path.lengths))
    whole = np.sum(path.lengths)
    assert made == pytest.approx(path.lengths, rel=1e-6, abs=1e-9 * whole)
    assert np.all(np.diff(path.phase_segment) >= 0)


@settings(max_examples=examples(150), deadline=None)
@given(polylines(), rules_of_tables)
def test_junctions_are_passed_no_faster_than_their_circles_allow(points, rules):
    path = plan_speeds(points, 1e4, rules)
    u, v = path.directions, entries(path)[1:]
    turn = u[1:] - u[:-1]
    size = np.hypot(*turn.T)
    bent = size > 1e-6
    cosine = np.sum(u[1:] * u[:-1], axis=1)
    half = np.sqrt((1 + np.clip(cosine, -1, 1)) / 2)
    most = np.array([axis.acceleration for axis in rules.axes])
    with np.errstate(divide="ignore", invalid="ignore"):
        across = np.min(most * size[:, None] / np.abs(turn), axis=1)
        corner = across * rules.deviation * half / (1 - half)
    assert np.all(v[bent] ** 2 <= corner[bent] * (1 + 1e-4) + 1e-12)
    short = np.minimum(path.lengths[1:], path.lengths[:-1])
    for k in range(2):
        # The turn, spread over half of both segments, keeps each axis' acceleration.
        change = v**2 * np.abs(turn[:, k]) / short
        assert np.all(change[bent] <= most[k] * (1 + 1e-6))


@settings(max_examples=examples(100), deadline=None)
@given(st.integers(1, 400), axes, st.floats(1, 2000))
def test_a_straight_line_in_pieces_is_one_line(pieces, axis, length):
    share = np.linspace(0, 1, pieces + 1)[:, None]
    rules = LookAheadRules((axis, axis))
    path = plan_speeds(share * np.array([length, 0.0]), 80.0, rules)
    whole = fastest_profile(
        length, AxisLimits(min(80.0, axis.velocity), axis.acceleration, axis.jerk)
    )
    assert path.duration_s == pytest.approx(whole.duration_s, rel=1e-6)


@settings(max_examples=examples(200), deadline=None)
@given(st.floats(0, 500), st.floats(1e-4, 1e3), axes)
def test_the_reached_speed_needs_the_whole_way(speed, way, axis):
    reached = reachable_speed(speed, way, axis.acceleration, axis.jerk)
    assert reached >= speed
    limits = axis.acceleration, axis.jerk
    assert ramp_distance(speed, reached, *limits) <= way * (1 + 1e-4) + 1e-6
    assert ramp_distance(speed, reached + 1e-6 * (1 + reached), *limits) >= way * (1 - 1e-4) - 1e-6


@settings(max_examples=examples(150), deadline=None)
@given(polylines(), rules_of_tables)
def test_samples_lie_on_the_path_and_end_at_rest(points, rules):
    path = plan_speeds(points, 50.0, rules)
    t = np.linspace(0, path.duration_s, 500)
    position, velocity = positions(path, t)
    assert position[0] == pytest.approx(points[0])
    size = np.sum(path.lengths)
    assert position[-1] == pytest.approx(points[-1], abs=1e-6 * size)
    assert np.max(np.abs(velocity[[0, -1]])) <= 1e-3
    low, high = points.min(axis=0), points.max(axis=0)
    assert np.all((position >= low - 1e-6 * size) & (position <= high + 1e-6 * size))


@pytest.mark.parametrize(("places", "tolerance"), [(9, 0.01), (3, 0.01), (3, 0.002), (2, 0.05)])
def test_a_densified_circle_is_driven_smoothly(places, tolerance):
    """Rounding makes the corners of a circle uneven; that shall not make the machine crawl."""
    axis = AxisLimits(200.0, 1000.0, 20_000.0)
    circle = (
        Line((0.0, 0.0), (100.0, 0.0)),
        Arc((100.0, 20.0), 20.0, -90.0, 180.0),
        Line((100.0, 40.0), (0.0, 40.0)),
    )
    points = densify(circle, DensifyRules(tolerance, 10**places)).points
    path = plan_speeds(points, 150.0, LookAheadRules((axis, axis)))
    # Across: 0.866 of the acceleration, by jerk v^3 / r^2.
    steady = min((0.866 * 1000 * 20) ** 0.5, (20_000 * 20**2) ** (1 / 3), 150.0)
    ideal = 262.8 / steady + 0.3
    assert path.duration_s <= (1.05 if places > 3 else 1.6) * ideal
    # Seen through a window wider than a chord, the axes keep their limits on the curve too.
    window = 2 * np.max(path.lengths[1:-1]) / np.min(entries(path)[1:])
    t = np.arange(window, path.duration_s - window, window / 4)
    x = [positions(path, t + k * window)[0] for k in (-1, 0, 1)]
    seen = np.abs(x[0] - 2 * x[1] + x[2]) / window**2
    assert np.max(seen) <= 1000.0 * 1.05
