"""The collector rests while something is made, and goes on as before, whatever happens."""

import gc
import subprocess
import sys
import weakref
from collections.abc import Iterator
from pathlib import Path

import pytest

from beamcam.collector import SELDOM, collector_resting
from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.pipeline import post, read_file

SAMPLES = Path(__file__).resolve().parents[2] / "samples"


@pytest.fixture(autouse=True)
def as_it_was() -> Iterator[None]:
    was_on = gc.isenabled()
    yield
    (gc.enable if was_on else gc.disable)()


@pytest.mark.parametrize("is_on", [True, False])
def test_it_rests_inside_and_is_as_before_afterwards(is_on: bool) -> None:
    (gc.enable if is_on else gc.disable)()
    with collector_resting():
        assert not gc.isenabled()
        with collector_resting():
            assert not gc.isenabled()
        assert not gc.isenabled()
    assert gc.isenabled() == is_on


def test_it_goes_on_after_an_error() -> None:
    gc.enable()
    with pytest.raises(ZeroDivisionError), collector_resting():
        1 / 0  # noqa: B018
    assert gc.isenabled()


def test_what_nothing_points_to_is_freed_meanwhile() -> None:
    class Thing:
        pass

    with collector_resting():
        thing = Thing()
        ghost = weakref.ref(thing)
        del thing
        assert ghost() is None


def test_it_rests_while_parts_are_posted_and_goes_on_if_they_are_refused() -> None:
    gc.enable()
    states: list[bool] = []
    reading = read_file(str(SAMPLES / "dstv" / "channel.nc1"))
    assert gc.isenabled()
    post(reading.parts, load("beamline"), stage=lambda _: states.append(gc.isenabled()))
    assert states
    assert not any(states)
    assert gc.isenabled()
    with pytest.raises(PlanError):
        post((), load("plate-linuxcnc"))
    assert gc.isenabled()


def test_a_command_looks_for_rings_seldom_and_not_at_its_end() -> None:
    code = (
        "import atexit, gc\n"
        "atexit.register(lambda: print(gc.get_threshold(), gc.get_freeze_count() > 1000))\n"
        "from beamcam.cli import main\n"
        "print(gc.get_threshold(), gc.get_freeze_count())\n"
        "main(['--version'])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    before, _, after = done.stdout.splitlines()
    assert (before, after) == ("(700, 10, 10) 0", f"{SELDOM} True")


def test_rings_are_found_all_the_same() -> None:
    """However long a command runs, what points to itself does not gather."""
    code = (
        "import gc\n"
        "from beamcam.collector import collector_seldom\n"
        "collector_seldom()\n"
        "before = len(gc.get_objects())\n"
        "for _ in range(50_000):\n    ring = []\n    ring.append(ring)\n"
        "print(len(gc.get_objects()) - before)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout) <= SELDOM[0]
