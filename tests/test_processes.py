"""Calls in other processes: each comes back once, whatever befalls a process."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from multiprocessing import active_children
from pathlib import Path

import pytest

from beamcam import processes
from beamcam.processes import Died, Pool
from tests.runs import lives, wait_until


def square(n: int) -> int:
    return n * n


def deadly(fatal: frozenset[int], n: int) -> int:
    if n in fatal:
        os.kill(os.getpid(), signal.SIGKILL)
    return n * n


def all_of(work: Callable[[int], int], count: int, workers: int = 2) -> dict[int, int | Died]:
    pool = Pool[int, int](work, workers)
    todo, found = list(range(count)), dict[int, int | Died]()
    try:
        while len(found) < count:
            while todo and pool.has_room():
                pool.submit(todo.pop(0))
            for given, made in pool.wait():
                assert given not in found
                found[given] = made
    finally:
        pool.close()
    return found


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_each_task_comes_back_once(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "start_method", lambda: method)
    assert all_of(square, 9) == {n: n * n for n in range(9)}


@pytest.mark.parametrize("fatal", [{0}, {3}, {7}, {2, 3}, set(range(8))])
def test_only_who_kills_a_worker_by_itself_has_died(fatal: set[int]) -> None:
    found = all_of(partial(deadly, frozenset(fatal)), 8)
    assert found == {n: Died() if n in fatal else n * n for n in range(8)}


def test_a_worker_killed_from_outside_costs_nothing(tmp_path: Path) -> None:
    """Once: the task is tried again."""
    seen = tmp_path / "seen"

    def killed_once(n: int) -> int:
        if n == 2 and not seen.exists():
            seen.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return n

    assert all_of(killed_once, 5) == {n: n for n in range(5)}


def test_a_fault_is_raised_here() -> None:
    def faulty(n: int) -> int:
        raise AssertionError(f"at {n}")

    with pytest.raises(AssertionError, match="at 0"):
        all_of(faulty, 1)
    assert not active_children()


def test_a_closed_pool_has_no_processes() -> None:
    pool = Pool[float, None](time.sleep, 2)
    for _ in range(4):
        pool.submit(600.0)
    assert not pool.has_room()
    assert active_children()
    pool.close()
    assert not active_children()


CODE = """
import os, sys, time
from beamcam.processes import Pool

def work(path):
    open(path, "w").write(str(os.getpid()))
    time.sleep(600)

pool = Pool(work, 2)
for path in sys.argv[1:]:
    pool.submit(path)
for _ in pool.wait():
    pass
"""


def test_workers_end_with_a_process_that_is_killed(tmp_path: Path) -> None:
    notes = [tmp_path / "a", tmp_path / "b"]
    run = subprocess.Popen([sys.executable, "-c", CODE, *map(str, notes)])
    wait_until(lambda: all(n.exists() and n.read_text() for n in notes), run)
    run.kill()
    run.wait()
    wait_until(lambda: not any(lives(int(n.read_text())) for n in notes))
