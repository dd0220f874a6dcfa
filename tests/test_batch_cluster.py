"""A batch on a Dask cluster: the same bytes, the same rows."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from beamcam.batch import Shop, cluster, find_inputs, run
from beamcam.batch.work import Made, Task, make_all
from beamcam.machine import load
from tests.runs import batch, counts, fill, programs, report

distributed: Any = pytest.importorskip("distributed", reason="the extra `dask` is not installed")


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """The address of a cluster of two worker processes."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as local:
        yield local.scheduler_address


def test_the_cluster_makes_the_same(tmp_path: Path, scheduler: str) -> None:
    fill(tmp_path / "in", 40, bad=11)
    rows = []
    for name, args in (("here", ("--jobs", 1)), ("there", ("--scheduler", scheduler))):
        said = tmp_path / f"{name}.json"
        result = batch(tmp_path / "in", "-o", tmp_path / name, *args, "--report", said)
        assert counts(result) == (39, 0, 1, 0)
        rows.append([{**row, "seconds": 0} for row in report(said)["files"]])
    assert rows[0] == rows[1]
    assert programs(tmp_path / "here") == programs(tmp_path / "there")


def make_or_die(frozen: bytes, chunk: tuple[Task, ...]) -> list[Made]:
    """What a cluster says of a chunk that has cost it several workers, said at once."""
    if any(task.name.endswith("P003.nc1") for task in chunk):
        raise distributed.KilledWorker("make_or_die", SimpleNamespace(address="tcp://x"), 3)
    return make_all(chunk, cluster.thaw(frozen))


def test_a_worker_that_dies_there(
    tmp_path: Path, scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path / "in", 6)
    monkeypatch.setattr(cluster, "make_there", make_or_die)
    shop = Shop(load("beamline"))
    found = find_inputs((str(tmp_path / "in"),)).inputs
    rows = list(run(found, str(tmp_path / "out"), shop, cluster.Cluster(shop, scheduler)))
    assert [row["status"] for row in rows] == ["posted"] * 3 + ["failed"] + ["posted"] * 2
    assert rows[3]["messages"][0]["code"] == "batch-worker"


def test_another_version_there_is_refused(
    tmp_path: Path, scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path / "in", 2)
    shop = Shop(load("beamline"), version="0.0.1")
    found = find_inputs((str(tmp_path / "in"),)).inputs
    rows = run(found, str(tmp_path / "out"), shop, cluster.Cluster(shop, scheduler))
    with pytest.raises(cluster.SchedulerError, match=r"a worker has beamcam .*, not 0\.0\.1"):
        list(rows)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "no-such-thing://x", "\0"])
def test_no_cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, address: str) -> None:
    fill(tmp_path / "in", 1)
    monkeypatch.setattr(cluster, "CONNECT_S", 1)
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--scheduler", address)
    assert result.exit_code == 1
    assert "error batch-scheduler: found no cluster that works at" in result.stderr


def test_without_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "distributed", None)
    fill(tmp_path / "in", 1)
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--scheduler", "tcp://x:1")
    assert result.exit_code == 1
    assert "the package distributed is not installed" in result.stderr
