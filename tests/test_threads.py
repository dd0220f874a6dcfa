"""Threads that read, post and verify at once get what one thread gets."""

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

import beamcam
from beamcam.errors import BeamcamError
from tests.conftest import SAMPLES
from tests.runs import part

THREADS, PARTS = 8, 96
BARS = ("beamline", "beamline-annex", "beamline-pusher")
SHEETS = ("plate-linuxcnc", "plate-codesys", "laser-grbl")


@pytest.fixture
def hasty() -> Iterator[None]:
    """Threads take turns as often as they can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(before)


def inputs() -> list[tuple[str, bytes, str]]:
    """Name, bytes and machine of 96 parts: of 21 kinds, with some that are refused."""
    drawn = [(path.name, path.read_bytes()) for path in sorted((SAMPLES / "dstv").glob("*.nc1"))]
    made = [
        (f"P{k}.nc1", part(f"P{k}", 1500.0 + k, 1, (10, 12, 14, 18, 22, 65)[k % 6]).encode())
        for k in range(12)
    ]
    files = [*drawn, *made]
    found = []
    for k in range(PARTS):
        name, data = files[k % len(files)]
        plate = name in ("gusset.nc1", "plate.nc1")
        found.append((name, data, (SHEETS if plate else BARS)[k // len(files) % 3]))
    return found


def outcome(asked: tuple[str, bytes, str]) -> tuple[object, ...]:
    name, data, machine = asked
    try:
        parts = beamcam.read(data, name=name).parts
        posted = beamcam.post(parts, machine)
        return posted.text, posted.remarks, beamcam.verify(posted.text, parts, machine)
    except BeamcamError as error:
        return (error.diagnostics,)


@pytest.mark.exhaustive
def test_eight_threads_post_what_one_posts(hasty: None) -> None:
    asked = inputs()
    with ThreadPoolExecutor(THREADS) as pool:
        found = list(pool.map(outcome, asked))  # first, while nothing is known yet
    assert found == [outcome(one) for one in asked]
    posted = [one for one in found if len(one) == 3]
    assert len(posted) > PARTS / 2
