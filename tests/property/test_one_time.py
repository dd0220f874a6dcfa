"""One model of motion: what is planned takes as long as the program when it is simulated."""

from collections.abc import Iterator
from math import inf
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.cell_motion import move_seconds, ramp_seconds
from beamcam.model.part import Part
from beamcam.model.plan import SKIP_NAMES
from beamcam.motion.speeds import stretch_seconds
from beamcam.motion.velocity_profile import AxisLimits
from beamcam.pipeline import Posted, parts_of, post, read_file
from tests.conftest import examples
from tests.property.test_plan_parts import random_part
from tests.property.test_profile import duration_by_ruckig
from tests.unit.planning.shop import hole, part
from tests.unit.simulation.programs import course_of

MACHINES = ("beamline", "beamline-annex", "beamline-pusher")
SAMPLES = Path(__file__).parents[2] / "samples" / "dstv"
BARS = (("strut",), ("beam",), ("channel", "tie", "channel"))


def simulated_s(posted: Posted, machine: Machine) -> float:
    course = course_of(posted.text, machine)
    return course[-1].begin_s + course[-1].duration_s


def assert_one_time(posted: Posted, machine: Machine) -> None:
    assert posted.time(machine).total_s == pytest.approx(simulated_s(posted, machine), rel=0.01)


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("bar", BARS, ids="+".join)
def test_samples(name: str, bar: tuple[str, ...]) -> None:
    parts, _ = parts_of(read_file(str(SAMPLES / f"{one}.nc1")) for one in bar)
    machine = load(name)
    assert_one_time(post(parts, machine, skips=SKIP_NAMES, bar=14000.0), machine)


def random_bars(name: str) -> Iterator[Part]:
    random = Random(5)
    for number in range(40):
        made = random_part(random, number)
        yield replace(made, grade=random.choice(("S235JR", "S355J2", "S690Q", "1.4301", "")))


@pytest.mark.parametrize("name", MACHINES)
def test_random_bars(name: str) -> None:
    machine, posted = load(name), 0
    for made in random_bars(name):
        try:
            done = post((made,), machine, skips=SKIP_NAMES, verified=False)
        except PlanError:
            continue
        assert_one_time(done, machine)
        posted += 1
    assert posted >= 20


def test_a_row_of_holes_and_tools_by_hand() -> None:
    machine = load("beamline")
    twelve = part(*(hole(200 + 200 * i, 150, 18) for i in range(12)))
    assert_one_time(post((twelve,), machine), machine)
    seven = part(*(hole(400 + 100 * i, 150, 12 + i) for i in range(7)))
    posted = post((seven,), machine)
    assert posted.text.count("M06 K2") == 2
    assert_one_time(posted, machine)
    assert simulated_s(posted, machine) > 180  # both changes


# --- moves ----------------------------------------------------------------------------------------


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


def test_stretches_take_as_long_as_ruckigs():
    dice = np.random.default_rng(7)
    for _ in range(300):
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
