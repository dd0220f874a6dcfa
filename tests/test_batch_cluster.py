"""A batch on a Dask cluster: the same bytes, the same rows."""

import json
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Thread
from types import SimpleNamespace
from typing import Any

import pytest

from beamcam.batch import cluster, pool
from beamcam.batch.find import find_inputs
from beamcam.batch.pool import MOST_BYTES, HeadStart, Here
from beamcam.batch.run import RunSetup, run
from beamcam.batch.work import BatchSettings, FileResult, Task, make_all, thaw
from beamcam.machine import load
from beamcam.model.request import Request
from tests.conftest import ROOT
from tests.runs import HANG_S, batch, counts, fill, programs, report, wait_until

distributed: Any = pytest.importorskip("distributed", reason="the extra `dask` is not installed")
psutil: Any = pytest.importorskip("psutil")  # comes with it


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """The address of a cluster of two worker processes."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as local:
        yield local.scheduler_address


def test_the_cluster_makes_the_same(tmp_path: Path, scheduler: str) -> None:
    fill(tmp_path / "in", 20, bad=11)
    rows = []
    for name, args in (("here", ("--jobs", 1)), ("there", ("--scheduler", scheduler))):
        said = tmp_path / f"{name}.json"
        result = batch(tmp_path / "in", "-o", tmp_path / name, *args, "--report", said)
        assert counts(result) == (19, 0, 1, 0)
        rows.append([{**row, "seconds": 0} for row in report(said)["files"]])
    assert rows[0] == rows[1]
    assert programs(tmp_path / "here") == programs(tmp_path / "there")


def make_or_die(frozen: bytes, chunk: tuple[Task, ...]) -> list[FileResult]:
    """What a cluster says of a chunk that has cost it several workers, said at once."""
    if any(task.name.endswith("P003.nc1") for task in chunk):
        raise distributed.KilledWorker("make_or_die", SimpleNamespace(address="tcp://x"), 3)
    return make_all(chunk, thaw(frozen))


def test_a_worker_that_dies_there(
    tmp_path: Path, scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path / "in", 6)
    monkeypatch.setattr(cluster, "make_there", make_or_die)
    shop = BatchSettings(Request((), load("beamline")))
    found = find_inputs((str(tmp_path / "in"),)).inputs
    rows = list(run(found, RunSetup(str(tmp_path / "out"), shop, cluster.Cluster(shop, scheduler))))
    assert [row["status"] for row in rows] == ["posted"] * 3 + ["failed"] + ["posted"] * 2
    assert rows[3]["messages"][0]["code"] == "batch-worker"


def test_a_killed_worker_costs_nothing(
    tmp_path: Path, scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The process of one of two workers is killed with chunks in it; the other makes them."""
    fill(tmp_path / "in", 60)
    submit = cluster.Cluster.submit
    with distributed.Client(scheduler, set_as_default=False) as client:
        victims = [next(iter(client.run(os.getpid).values()))]

        def submit_then_kill(self: cluster.Cluster, chunk: tuple[Task, ...]) -> None:
            submit(self, chunk)
            if victims and not self.has_room():
                psutil.Process(victims.pop()).kill()

        monkeypatch.setattr(cluster, "CHUNKS", 1)
        monkeypatch.setattr(cluster.Cluster, "submit", submit_then_kill)
        there = batch(tmp_path / "in", "-o", tmp_path / "there", "--scheduler", scheduler)
        assert (victims, counts(there)) == ([], (60, 0, 0, 0))
        batch(tmp_path / "in", "-o", tmp_path / "here", "--jobs", 1)
        assert programs(tmp_path / "here") == programs(tmp_path / "there")
        client.wait_for_workers(2, timeout=HANG_S)


def test_files_lost_with_the_process_here_go_to_the_cluster(
    tmp_path: Path, scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path / "in", 40)

    def die(chunk: tuple[Task, ...], shop: BatchSettings) -> list[FileResult]:
        os._exit(1)

    monkeypatch.setattr(pool, "make_all", die)
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--scheduler", scheduler)
    assert counts(result) == (40, 0, 0, 0)


def test_nothing_is_written_before_the_cluster_has_answered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path / "in", 40)
    monkeypatch.setattr(cluster, "ANSWER_S", 0.5)
    result = batch(
        tmp_path / "in", "-o", tmp_path / "out", "--scheduler", "tcp://127.0.0.1:9", status=1
    )
    assert "error batch-scheduler: found no cluster that works at" in result.stderr
    assert programs(tmp_path / "out") == {}


def test_a_large_input_waits_for_the_cluster() -> None:
    """A model of minutes would hold the one process here that long."""
    shop = BatchSettings(Request((), load("beamline")))
    there = Here(shop)
    workers = HeadStart(shop, 100, lambda: there)
    large = (Task(0, "large.nc1", b" " * (MOST_BYTES + 1)),)
    assert workers.at_once == 1
    workers.submit(large)
    assert not there.has_room()
    assert [chunk for chunk, _ in workers.wait()] == [large]
    workers.close()


def test_numpy_is_there_after_the_import_of_distributed() -> None:
    said = subprocess.run(
        [sys.executable, "-c", "import sys\nfrom beamcam.batch.cluster import distributed_alone\n"
         "distributed_alone()\nprint('numpy' in sys.modules)\nimport numpy, jinja2"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert said.stdout == "False\n"


def test_another_version_there_is_refused(scheduler: str) -> None:
    shop = BatchSettings(Request((), load("beamline")), version="0.0.1")
    with pytest.raises(cluster.SchedulerError, match=r"has beamcam .*, not 0\.0\.1"):
        cluster.Cluster(shop, scheduler)


@contextmanager
def started(*args: str, path: Path = ROOT) -> Iterator[subprocess.Popen[bytes]]:
    """A process of distributed that finds its modules below `path` first."""
    process = subprocess.Popen(
        [sys.executable, "-m", *args],
        cwd=path, env={**os.environ, "PYTHONPATH": str(path)},
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@contextmanager
def workers(folder: Path, path: Path = ROOT) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """A scheduler and its one worker, as processes: the address and the scheduler's process."""
    said = folder / "scheduler.json"
    scheduler = ("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0",
                 "--no-dashboard", "--scheduler-file", str(said))  # fmt: skip
    worker = ("distributed.cli.dask_worker", "--scheduler-file", str(said), "--no-nanny",
              "--no-dashboard", "--nthreads", "1")  # fmt: skip
    with started(*scheduler) as process, started(*worker, path=path):
        wait_until(lambda: said.exists() and said.read_text(), process)
        address = json.loads(said.read_text())["address"]
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(1, timeout=HANG_S)
        yield address, process


def test_a_worker_without_beamcam_is_told(tmp_path: Path) -> None:
    fill(tmp_path / "in", 2)
    (tmp_path / "there" / "beamcam").mkdir(parents=True)
    (tmp_path / "there" / "beamcam" / "__init__.py").write_text("raise ImportError\n")
    with workers(tmp_path, tmp_path / "there") as (address, _):
        result = batch(tmp_path / "in", "-o", tmp_path / "out", "--scheduler", address)
    assert result.exit_code == 1
    assert "error batch-scheduler: " in result.stderr
    assert "has no beamcam" in result.stderr


def test_a_scheduler_that_goes_away_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path / "in", 60)
    monkeypatch.setattr(cluster, "LOOK_S", 0.2)
    with workers(tmp_path) as (address, process):
        submit = cluster.Cluster.submit

        def kill_then_submit(self: cluster.Cluster, chunk: tuple[Task, ...]) -> None:
            submit(self, chunk)
            process.kill()

        monkeypatch.setattr(cluster.Cluster, "submit", kill_then_submit)
        result = batch(tmp_path / "in", "-o", tmp_path / "out", "--scheduler", address)
    assert result.exit_code == 1
    assert "the scheduler went away" in result.stderr
    assert " refused, 0 failed (not finished)" in result.stderr


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "no-such-thing://x", "\0"])
def test_no_cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, address: str) -> None:
    fill(tmp_path / "in", 1)
    monkeypatch.setattr(cluster, "ANSWER_S", 1)
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--scheduler", address, status=1)
    assert "error batch-scheduler: found no cluster that works at" in result.stderr


@pytest.mark.exhaustive
def test_the_cluster_of_the_configuration(tmp_path: Path) -> None:
    fill(tmp_path / "in", 1)
    config = tmp_path / "in" / "beamcam.toml"
    config.write_text('[dask]\nscheduler = "tcp://127.0.0.1:9"\nanswer_s = 0.5\nchunks = 3\n')
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--trust", tmp_path)
    assert "error batch-scheduler: found no cluster that works at tcp://127.0.0.1:9" in (
        result.stderr
    )
    other = batch(tmp_path / "in", "-o", tmp_path / "out", "--scheduler", "tcp://127.0.0.1:7")
    assert "works at tcp://127.0.0.1:7" in other.stderr
    config.write_text("[dask]\nanswer_s = 0\n")
    result = batch(tmp_path / "in", "-o", tmp_path / "out")
    assert "beamcam.toml:2: error config-value: found 0 for 'dask.answer_s'" in result.stderr


def test_another_service_at_the_address(tmp_path: Path) -> None:
    """Such as the page of a dashboard, whose answer is no word of a scheduler's."""
    fill(tmp_path / "in", 1)
    page = b"HTTP/1.0 400 Bad Request\r\n\r\n<html>this is no scheduler</html>"
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            with suppress(OSError):
                while True:
                    server.accept()[0].sendall(page)

        Thread(target=answer, daemon=True).start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        result = batch(tmp_path / "in", "-o", tmp_path / "out", "--scheduler", address)
    assert (result.exit_code, "error batch-scheduler" in result.stderr) == (1, True)


def test_without_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    fill(tmp_path / "in", 1)
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--scheduler", "tcp://x:1", status=1)
    assert "the package distributed is not installed" in result.stderr
