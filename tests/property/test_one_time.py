"""One model of motion: what is planned takes as long as the program when it is simulated."""

from collections.abc import Iterator
from pathlib import Path
from random import Random

import pytest
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.pipeline import Posted, parts_of, post, read_file
from beamcam.planning.left_out import SKIP_NAMES
from tests.property.test_plan_parts import random_part
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
