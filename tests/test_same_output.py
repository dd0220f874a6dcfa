"""The same input gives the same bytes, whatever the machine that it is posted on is set to."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.conftest import ROOT, SAMPLES, sampled

PARTS = [str(SAMPLES / "dstv" / f"{name}.nc1") for name in ("strut", "strut")]
LOCALES = ("tr_TR.UTF-8", "C", "POSIX", "de_DE.UTF-8", "C.UTF-8", "pt_PT.ISO-8859-1")
SEEDS = ("0", "1", "17", "4294967295", "random")


def post(directory: Path, **environment: str) -> bytes:
    """The program's bytes, as a fresh process writes them."""
    code = "from beamcam.cli import main; main()"
    run = subprocess.run(
        [sys.executable, "-c", code, "post", *PARTS, "-o", "-"],
        capture_output=True,
        cwd=directory,
        env={"PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT), **environment},
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


@pytest.fixture(scope="module")
def expected() -> bytes:
    text = post(ROOT)
    assert b"M30" in text
    return text


@pytest.mark.parametrize("locale", sampled(LOCALES, 3))
def test_locales(expected: bytes, locale: str, tmp_path: Path) -> None:
    assert post(tmp_path, LANG=locale, LC_ALL=locale, LC_NUMERIC=locale) == expected


@pytest.mark.parametrize("seed", sampled(SEEDS, 2))
def test_hash_seeds(expected: bytes, seed: str) -> None:
    assert post(ROOT, PYTHONHASHSEED=seed) == expected


def test_directories(expected: bytes, tmp_path: Path) -> None:
    below = tmp_path / "a folder of another name"
    below.mkdir()
    assert post(below) == post(tmp_path) == expected


@pytest.mark.parametrize("workers", sampled([4, 2, 1], 3))
def test_workers(expected: bytes, workers: int) -> None:
    """Programs posted side by side, in processes of their own and in threads of one."""
    with ThreadPoolExecutor(workers) as pool:
        assert set(pool.map(lambda _: post(ROOT), range(3))) == {expected}


@pytest.mark.parametrize("workers", sampled([3, 1], 2))
def test_threads_of_one_process(expected: bytes, workers: int) -> None:
    from beamcam.machine import load
    from beamcam.pipeline import parts_of, read_file
    from beamcam.pipeline import post as post_here

    machine = load("beamline")

    def text(_: int) -> bytes:
        parts, _said = parts_of(read_file(path) for path in PARTS)
        return post_here(parts, machine).text.encode()

    with ThreadPoolExecutor(workers) as pool:
        assert set(pool.map(text, range(6))) == {expected}


PICTURES = (
    "plot part.nc1 -o part.svg", "plot part.nc1 -o part.pdf", "plot job.gcode -o job.png",
    "report job.gcode part.nc1 -o job.html", "report part.nc1 -o sheet.pdf",
    "simulate job.gcode --encoder 512/65 -o study.svg", "diff part.nc1 other.nc1 -o diff.html",
)  # fmt: skip


def drawn(folder: Path, **environment: str) -> dict[str, bytes]:
    """All kinds of pictures and pages, as a fresh process writes them."""
    folder.mkdir()
    part = (SAMPLES / "dstv" / "strut.nc1").read_bytes()
    (folder / "part.nc1").write_bytes(part)
    (folder / "other.nc1").write_bytes(part.replace(b"120.00", b"125.00"))
    calls = ["post part.nc1 -o job.gcode", *PICTURES]
    code = (
        "import sys; from click.testing import CliRunner; from beamcam.cli import main\n"
        "for call in sys.argv[1:]: CliRunner().invoke(main, call.split())"
    )
    run = subprocess.run(
        [sys.executable, "-c", code, *calls], cwd=folder,
        env={"PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT), **environment},
    )  # fmt: skip
    assert run.returncode == 0
    return {call.split()[-1]: (folder / call.split()[-1]).read_bytes() for call in PICTURES}


@pytest.mark.exhaustive
def test_pictures_and_pages(tmp_path: Path) -> None:
    one = drawn(tmp_path / "one", PYTHONHASHSEED="1", TZ="UTC")
    other = drawn(tmp_path / "another", PYTHONHASHSEED="2", LC_ALL="de_DE.UTF-8", TZ="Asia/Tokyo")
    assert [name for name in one if one[name] != other[name]] == []
    assert all(len(data) > 1000 for data in one.values())
