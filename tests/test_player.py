"""The player of samples/player, compiled and run: its port shows the table, no step is lost.

The steps are counted here from the words on the port alone.
"""

import shutil
import subprocess
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from beamcam.machine import load
from tests.conftest import ROOT, examples
from tests.runs import HANG_S, call

PLAYER = ROOT / "samples" / "player"
GCC = shutil.which("gcc")
FLAGS = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-fsanitize=undefined", "-O1")
WORDS = ("00", "01", "10", "11")
RUN_UP_US = 300_000  #: a ramp and what is spare

Write = tuple[int, str, str, str]  #: microseconds, word of X, word of Y, laser

pytestmark = pytest.mark.skipif(GCC is None, reason="no C compiler (Debian: gcc)")


def compiled(target: Path, *flags: str) -> Path:
    assert GCC is not None
    sources = [str(PLAYER / name) for name in ("host.c", "player.c")]
    run = subprocess.run(
        [GCC, *FLAGS, *flags, "-o", str(target), *sources], capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    return target


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A job in three forms, and a player of its .bin and one of its .h."""
    at = tmp_path_factory.mktemp("player")
    part = ROOT / "samples" / "json" / "shield-small.json"
    for suffix in ("steps", "bin", "h"):
        call("post", part, "-o", at / f"job.{suffix}", status=0)
    compiled(at / "play")
    compiled(at / "play-h", f'-DTABLE="{at / "job.h"}"')
    return at


def writes(text: str) -> list[Write]:
    rows = [line.split(",") for line in text.split()]
    return [(int(time), x, y, laser) for time, x, y, laser in rows]


def played(folder: Path, *more: str) -> list[Write]:
    run = subprocess.run(
        [folder / "play", folder / "job.bin", *more], capture_output=True, text=True, timeout=HANG_S
    )
    assert run.returncode == 0, run.stderr
    return writes(run.stdout)


def step(before: str, after: str) -> int:
    """The step from one word to the next. Fails for a word that skips one."""
    turn = (WORDS.index(after) - WORDS.index(before)) % 4
    return {0: 0, 1: 1, 3: -1}[turn]


def places(rows: Sequence[Write]) -> list[tuple[int, int]]:
    """Where the head stands after each write, in steps."""
    x = y = 0
    found = [(0, 0)]
    for (_, x0, y0, _), (_, x1, y1, _) in pairwise(rows):
        x, y = x + step(x0, x1), y + step(y0, y1)
        found.append((x, y))
    return found


def burnt(rows: Sequence[Write]) -> Counter[tuple[int, int]]:
    """For how long the laser was on at each place, in microseconds."""
    time: Counter[tuple[int, int]] = Counter()
    for at, (a, b) in zip(places(rows), pairwise(rows), strict=False):
        if a[3] == "1":
            time[at] += b[0] - a[0]
    return time


def table(folder: Path) -> list[Write]:
    text = (folder / "job.steps").read_text(encoding="ascii")
    rows = writes("\n".join(line for line in text.split("\n") if line[:1].isdigit()))
    return [rows[0], *(b for a, b in pairwise(rows) if a[1:] != b[1:])]


def test_the_port_is_the_table(folder: Path) -> None:
    assert played(folder) == table(folder)
    run = subprocess.run([folder / "play-h"], capture_output=True, text=True, timeout=HANG_S)
    assert (run.returncode, writes(run.stdout)) == (0, table(folder))


@settings(max_examples=examples(25), deadline=None)
@given(st.integers(1, 5_400_000), st.integers(1, 2_000_000))
@example(1, 50_000)  # before the first step
@example(150_000, 10)  # nearer to the begin than a run-up
@example(240_000, 700_000)  # while the laser pierces
@example(5_253_100, 400_000)  # where the laser ends
@example(5_470_000, 400_000)  # in the last steps
def test_a_door_that_opens_loses_no_step(folder: Path, opens: int, wait: int) -> None:
    whole, rows = played(folder), played(folder, f"{opens}:{opens + wait}")
    assert burnt(rows) == burnt(whole)
    assert places(rows)[-1] == (0, 0)
    assert rows[-1][1:] == ("00", "00", "0")
    assert set(places(rows)) == set(places(whole))
    for (time, *_, laser), (later, *_) in pairwise(rows):
        if laser == "1":  # it is out from the moment that the door opens until it is resumed
            assert later <= opens or time >= opens + wait


@settings(max_examples=examples(10), deadline=None)
@given(st.integers(1, 5_400_000))
def test_no_motor_is_driven_faster_for_a_door(folder: Path, opens: int) -> None:
    stepper = load("laser-stepper").stepper
    assert stepper is not None
    rows = played(folder, f"{opens}:{opens + RUN_UP_US}")
    for axis in (1, 2):
        times = [b[0] for a, b in pairwise(rows) if a[axis] != b[axis]]
        assert min(b - a for a, b in pairwise(times)) >= 1e6 / stepper.max_hz - 100


@pytest.mark.parametrize(("option", "says", "count"), [
    ("--not-in-corner", "not in corner", 1),
    ("0:1000", "door open", 1),
    ("--lost", "lost steps", None),
])  # fmt: skip
def test_it_does_not_begin_or_end_elsewhere(
    folder: Path, option: str, says: str, count: int | None
) -> None:
    run = subprocess.run(
        [folder / "play", folder / "job.bin", option],
        capture_output=True,
        text=True,
        timeout=HANG_S,
    )
    assert (run.returncode, run.stderr) == (1, f"{says}\n")
    rows = writes(run.stdout)
    assert len(rows) == (count or len(table(folder)))
    assert rows[-1][1:] == ("00", "00", "0")


@settings(max_examples=examples(30), deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 3))
def test_a_table_whose_words_skip_is_not_begun(folder: Path, row: int, bit: int) -> None:
    """A word that skips one, or a head that does not come back; another way there is sound."""
    data = bytearray((folder / "job.bin").read_bytes())
    rows = memoryview(data)[32:]
    rows[4 * row % len(rows)] ^= 1 << bit
    (folder / "bad.bin").write_bytes(data)
    bits = [byte & 15 for byte in rows[::4]]
    head = [(0, f"{b & 3:02b}", f"{b >> 2:02b}", "0") for b in bits]
    try:
        is_sound = places(head)[-1] == (0, 0) and bits[0] == bits[-1] == 0
    except KeyError:
        is_sound = False
    run = subprocess.run(
        [folder / "play", folder / "bad.bin"], capture_output=True, text=True, timeout=HANG_S
    )
    assert (run.returncode, run.stderr) == ((0, "") if is_sound else (1, "bad table\n"))
    assert is_sound or run.stdout == "0,00,00,0\n"
