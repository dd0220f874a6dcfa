"""`batch --dry-run` says what a batch would do, and does nothing."""

import json
from pathlib import Path

import pytest

from tests.runs import batch, counts, fill, programs


def files(folder: Path) -> dict[str, bytes]:
    return {str(p): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture
def shop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    fill(tmp_path / "in" / "deep", 3, bad=1)
    return tmp_path


def test_it_tells_what_the_batch_then_does(shop: Path) -> None:
    before = files(shop)
    dry = batch("in", "-o", "out", "--machine", "beamline", "--dry-run")
    assert files(shop) == before
    assert not Path("out").exists()
    wet = batch("in", "-o", "out", "--machine", "beamline")
    assert dry.exit_code == wet.exit_code == 1
    assert counts(dry) == counts(wet) == (2, 0, 1, 0)
    told = [line.split(" -> ")[1].split(",")[0] for line in dry.stdout.splitlines() if "->" in line]
    assert {Path(name).relative_to("out").as_posix() for name in told} == set(programs(Path("out")))
    assert f"{Path('in/deep/P001.nc1')}: refused" in dry.stdout
    assert dry.stderr.splitlines()[-1].endswith("(dry run, nothing written)")


def test_it_knows_what_is_unchanged(shop: Path) -> None:
    batch("in", "-o", "out")
    before = files(shop)
    dry = batch("in", "-o", "out", "--dry-run")
    assert files(shop) == before
    assert dry.stdout.count(" (unchanged)") == 2
    assert batch("in", "-o", "out", "--job", "B", "--dry-run").stdout.count("(unchanged)") == 0
    assert files(shop) == before


def test_as_json_it_is_the_report(shop: Path) -> None:
    data = json.loads(batch("in", "-o", "out", "--dry-run", "--json").stdout)
    assert data["counts"]["posted"] == 2
    assert not Path("out").exists()
