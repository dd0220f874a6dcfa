"""Damaged inputs end in a program or in an error of our own, in bounds of time and memory."""

import os
import random
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmarks import damage, doors, fuzz
from tests.conftest import ROOT

FILES = {kind: fuzz.samples(kind) for kind in fuzz.FORMATS}
#: A seed that no run of the benchmark had, and how many of its inputs.
SEED, FEW = 3, 6


@pytest.mark.parametrize("kind", fuzz.FORMATS)
def test_damaged_inputs_hold(kind: str) -> None:
    for index in range(FEW):
        done = fuzz.one(index, SEED, {kind: FILES[kind]})
        assert done.how in fuzz.HELD, done


@pytest.mark.parametrize("kind", fuzz.OF_COMMANDS)
def test_damaged_inputs_hold_in_the_commands(kind: str) -> None:
    files = {kind: fuzz.samples(kind)}
    for index in range(FEW // 2):
        done = fuzz.one(index, SEED, files, by_commands=True)
        assert done.how in fuzz.HELD, done


@pytest.mark.parametrize("kind", fuzz.OF_COMMANDS)
def test_each_command_takes_what_is_sound(kind: str, tmp_path: Path) -> None:
    """A line that was misspelt would be refused whatever the input is."""
    sound = fuzz.samples(kind)[0]
    ways = (doors.go_through(kind, sound, random.Random(seed))[0] for seed in range(20))
    assert "posted" in ways


def test_the_same_seed_gives_the_same_inputs() -> None:
    first, second = ([fuzz.input_of(k, 5, FILES) for k in range(30)] for _ in range(2))
    assert first == second
    assert first != [fuzz.input_of(k, 6, FILES) for k in range(30)]
    assert {kind for kind, _ in first} == set(fuzz.FORMATS)


@pytest.mark.parametrize("change", damage.DAMAGES)
def test_each_damage_takes_any_bytes(change: damage.Damage) -> None:
    data = FILES["json"][0]
    for seed in range(20):
        assert isinstance(change(data, random.Random(seed)), bytes)
        assert isinstance(change(b"", random.Random(seed)), bytes)
    assert any(change(data, random.Random(seed)) != data for seed in range(20))


def _fault(how: str) -> object:
    if how == "crash":
        raise KeyError("x")
    if how == "memory":
        raise MemoryError
    while True:
        pass


@pytest.mark.parametrize("how", fuzz.FAULTS)
def test_a_fault_is_seen(how: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fuzz, "MOST_S", 0.05)
    monkeypatch.setattr(fuzz, "work", lambda *_: _fault(how))
    assert fuzz.one(0, 1, FILES).how == how


def test_a_worker_that_does_not_answer_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the system has no clock of a process, the parent's is looked at."""
    monkeypatch.setattr(fuzz, "PATIENCE", 0.0)
    ended: list[str] = []
    worker = fuzz.Worker.__new__(fuzz.Worker)
    worker.index, worker.since = 7, time.monotonic() - 1.0
    worker._arguments = (1, fuzz.FORMATS)
    monkeypatch.setattr(fuzz, "processor_s", lambda _: 9.0)
    worker._process, worker._before = SimpleNamespace(pid=0), 0.0  # type: ignore[assignment]
    monkeypatch.setattr(worker, "end", lambda: ended.append("end"))
    monkeypatch.setattr(worker, "_begin", lambda: ended.append("begin"))
    late = worker.too_late()
    assert late is not None
    assert (late.how, late.index, ended) == ("hang", 7, ["end", "begin"])


def test_a_worker_that_waits_for_the_processor_is_not_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On a busy machine an input may take long by the clock and little of the processor."""
    monkeypatch.setattr(fuzz, "PATIENCE", 1.0)
    worker = fuzz.Worker.__new__(fuzz.Worker)
    worker.index, worker.since = 7, time.monotonic() - 60.0
    worker._process = SimpleNamespace(pid=os.getpid())  # type: ignore[assignment]
    worker._before = fuzz.processor_s(os.getpid())
    assert worker.too_late() is None


def test_without_bounds_of_the_system(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fuzz, "signal", SimpleNamespace())
    monkeypatch.setattr(fuzz, "work", lambda *_: ("posted", ""))
    assert fuzz.one(0, 1, FILES).how == "posted"


def test_the_table_counts_all() -> None:
    found = [
        fuzz.Outcome(0, "dstv", "posted", "", 0.5, 100.0),
        fuzz.Outcome(1, "dxf", "crash", "KeyError here", 1.0, 120.0),
        fuzz.Outcome(7, "dxf", "crash", "KeyError here", 1.0, 120.0),
    ]
    head, *rows = fuzz.table(found, ("dstv", "dxf"))
    assert rows[-1].split() == ["all", "3", "1", "0", "0", "2", "0", "0", "1.0", "1", "120"]
    assert len(head.split()) == 14  # two words each for the last three
    found.append(fuzz.Outcome(2, "json", "read-back", "verify-ledger"))
    assert list(fuzz.faults(found)) == [
        "     2 x dxf crash, --only 1, 7: KeyError here",
        "     1 x json read-back, --only 2: verify-ledger",
    ]


def test_what_took_too_long_counts_as_it_is_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    again = fuzz.Outcome(4, "json", "refused", "", 1.0)
    asked: list[tuple[range, int]] = []

    def outcomes(
        indices: range, seed: int, jobs: int, kinds: tuple[str, ...], *_: object
    ) -> object:
        asked.append((indices, jobs))
        return iter([again])

    monkeypatch.setattr(fuzz, "outcomes", outcomes)
    crash, hang = (fuzz.Outcome(k, "json", how) for k, how in ((3, "crash"), (4, "hang")))
    assert fuzz.tried_again([crash, hang], 1, ("json",)) == [crash, again]
    assert asked == [(range(4, 5), 1)]


def test_a_run_ends_with_its_table(tmp_path: Path) -> None:
    import subprocess
    import sys

    done = subprocess.run(
        [sys.executable, str(ROOT / "benchmarks/fuzz.py"), "--inputs=6", "--jobs=1",
         "--formats=dstv,json", f"--keep={tmp_path / 'keep'}"],
        capture_output=True, text=True,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-1].split()[:2] == ["all", "6"]
