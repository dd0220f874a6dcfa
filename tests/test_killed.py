"""A process that is killed while it writes leaves the old file, or none; never a part of one."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import ROOT, SAMPLES
from tests.runs import wait_until

BEAM = str(SAMPLES / "dstv" / "beam.nc1")

# Writing stops for ever at the step that is named, so that the kill meets it there: in the middle
# of the bytes, on their way to the disk, or just before the file takes its name.
CODE = """
import os, sys, time
step, ready = sys.argv[1], sys.argv[2]
del sys.argv[1:3]
write = os.write

def hang(*_, **__):
    open(ready, "w").close()
    time.sleep(600)

def half(file, data):
    if file <= 2:
        return write(file, data)
    write(file, bytes(data)[: len(data) // 2])
    hang()

if step == "write":
    os.write = half
elif step == "fsync":
    os.fsync = hang
elif step == "name":
    os.replace = hang
    if not os.path.exists(sys.argv[-1]):
        os.link = hang
from beamcam.cli import main
main()
"""
STEPS = ("write", "fsync", "name")


def killed_at(step: str, target: Path) -> None:
    """Post to `target` in a process that is killed at a step of writing."""
    ready = target.parent / "ready"
    process = subprocess.Popen(
        [sys.executable, "-c", CODE, step, str(ready), "post", BEAM, "-o", str(target)],
        cwd=target.parent,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    try:
        wait_until(ready.exists, process)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    ready.unlink()


@pytest.mark.parametrize("step", STEPS)
def test_no_file_where_there_was_none(tmp_path: Path, step: str) -> None:
    target = tmp_path / "job.gcode"
    killed_at(step, target)
    assert not target.exists()


@pytest.mark.parametrize("step", STEPS)
def test_the_old_file_where_there_was_one(tmp_path: Path, step: str) -> None:
    target = tmp_path / "job.gcode"
    target.write_text("the old program\n")
    killed_at(step, target)
    assert target.read_text() == "the old program\n"


def test_what_is_left_beside_it_is_no_program(tmp_path: Path) -> None:
    target = tmp_path / "job.gcode"
    killed_at("name", target)
    assert [p for p in tmp_path.iterdir() if p.suffix == ".gcode"] == []


def test_a_later_run_writes_the_whole(tmp_path: Path) -> None:
    target = tmp_path / "job.gcode"
    killed_at("write", target)
    code = "from beamcam.cli import main; main()"
    subprocess.run(
        [sys.executable, "-c", code, "post", BEAM, "-o", str(target)],
        check=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
    )
    assert target.read_text().endswith("M30\n%\n")
