"""The command line tunes the garbage collector and numpy; the library leaves both to its host."""

import gc
import os
import re
import subprocess
import sys

import pytest
from click.testing import CliRunner

import beamcam
from beamcam.cli import main
from beamcam.system import SELDOM
from tests.conftest import SAMPLES

PACKAGE = SAMPLES.parent / "beamcam"


def test_the_library_leaves_the_collector_alone() -> None:
    before, frozen = (gc.isenabled(), gc.get_threshold()), gc.get_freeze_count()
    reading = beamcam.read(SAMPLES / "dstv" / "channel.nc1")
    posted = beamcam.post(reading.parts, "beamline")
    assert not beamcam.verify(posted.text, reading.parts, "beamline")
    assert (gc.isenabled(), gc.get_threshold()) == before
    assert gc.get_freeze_count() <= frozen  # some of what the tests collected may have gone


def test_only_the_command_line_and_its_workers_tune_it() -> None:
    tuning = [
        path.relative_to(PACKAGE).as_posix()
        for path in sorted(PACKAGE.rglob("*.py"))
        if re.search(r"import gc\b|collector_seldom", path.read_text(encoding="utf-8"))
    ]
    assert tuning == ["batch/pool.py", "cli.py", "system.py"]


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
        "from beamcam.system import collector_seldom\n"
        "collector_seldom()\n"
        "before = len(gc.get_objects())\n"
        f"for _ in range({2 * SELDOM[0]}):\n    ring = []\n    ring.append(ring)\n"
        "print(len(gc.get_objects()) - before)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout) <= SELDOM[0]


@pytest.mark.parametrize(("said", "kept"), [(None, "1"), ("4", "4")])
def test_a_command_has_numpy_start_no_threads_unless_it_is_told_to(
    said: str | None, kept: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "")
    if said is None:
        monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    else:
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", said)
    assert CliRunner().invoke(main, ["--version"]).exit_code == 0
    assert os.environ["OPENBLAS_NUM_THREADS"] == kept
