"""Ctrl-C ends every command within a second, with exit status 130 and no traceback."""

import os
import signal
import subprocess
import sys
import time
from math import inf
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.runs import fill, part

WITHIN_S = 1.0
#: Each waits for what stands on its standard input, in the middle of its work.
WAITING = (
    "post - -o x.gcode", "plan -", "inspect -", "convert - -o x.json", "verify - ", "diff - a.nc1",
    "recover - --profile UPN200 -o x.nc1", "simulate - -o x.csv", "plot - -o x.svg",
    "batch - -o out", "list - -o -", "labels - -o x.pdf",
)  # fmt: skip
#: Each has work for many seconds, or until it is ended.
WORKING = (
    "post big.dxf --thickness 3 -o x.ngc", "plan big.dxf --thickness 3", "inspect big.dxf",
    "batch many -o out --jobs 1", "batch many -o out-of-two --jobs 2",
    "watch many -o out --settle 0",
    "check golden --samples many", "diff many more",
    "profile --velocity 1 --time 9 --step 1e-5 -o -",
)  # fmt: skip


def drawing(count: int) -> str:
    """A drawing of so many circles."""
    rows = []
    for k in range(count):
        x, y = 5 * (k % 250), 5 * (k // 250)
        rows.append(f"0\nCIRCLE\n8\n0\n10\n{x}.0\n20\n{y}.0\n40\n2.0\n")
    return f"0\nSECTION\n2\nENTITIES\n{''.join(rows)}0\nENDSEC\n0\nEOF\n"


@pytest.fixture(scope="module")
def shop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("shop")
    (folder / "a.nc1").write_text(part("A"))
    (folder / "big.dxf").write_text(drawing(60_000))
    fill(folder / "many", 4000)
    (folder / "golden" / "beamline").mkdir(parents=True)
    (folder / "more").mkdir()
    for path in (folder / "many").iterdir():
        (folder / "golden" / "beamline" / f"{path.stem}.gcode").write_text("%\n")
        (folder / "more" / path.name).write_text(path.read_text().replace("18.00", "19.00"))
    return folder


#: Imports into a start, counted from that of the command line, at which Ctrl-C comes.
AT_IMPORTS = {"post a.nc1 -o x.gcode": (1, 30, 120, 260), "inspect big.dxf": (5, 400, 500)}
#: What a Python loads at its start: it sends itself Ctrl-C in the midst of an import.
INTERRUPTS_ITSELF = """
import os, signal, sys

class Counting:
    left = None

    @classmethod
    def find_spec(cls, name, *_):
        if name == "beamcam.cli":
            cls.left = int(os.environ["AT_IMPORT"])
        if cls.left is not None:
            cls.left -= 1
            if cls.left == 0:
                os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Counting)
"""


@pytest.mark.parametrize(
    ("command", "at"), [(command, at) for command, each in AT_IMPORTS.items() for at in each]
)
def test_a_command_that_is_being_loaded(command: str, at: int, shop: Path, tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(INTERRUPTS_ITSELF)
    path = os.pathsep.join((str(tmp_path), str(ROOT)))
    run = subprocess.run(
        [sys.executable, "-m", "beamcam", *command.split()], cwd=shop, check=False,
        env={**os.environ, "PYTHONPATH": path, "AT_IMPORT": str(at)}, capture_output=True,
        text=True, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    assert (run.returncode, run.stderr) == (130, "")


def test_a_command_that_starts_processes(shop: Path, tmp_path: Path) -> None:
    """What Python calls at a fork swallows exceptions."""
    (tmp_path / "sitecustomize.py").write_text(
        "import os, signal\n"
        "os.register_at_fork(after_in_parent=lambda: os.kill(os.getpid(), signal.SIGINT))\n"
    )
    path = os.pathsep.join((str(tmp_path), str(ROOT)))
    run = subprocess.run(
        [sys.executable, "-m", "beamcam", "batch", "many", "-o", "out", "--jobs", "2"], cwd=shop,
        env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=False,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    assert (run.returncode, run.stderr[:8]) == (130, "0 posted")


def test_a_command_that_is_to_hear_of_no_interrupt_hears_of_none(shop: Path) -> None:
    """As `nohup` and shells start what they leave in the background."""
    run = subprocess.run(
        [sys.executable, "-c", "import atexit, signal; from beamcam.__main__ import main; "
         "atexit.register(lambda: print(signal.getsignal(2) is signal.SIG_IGN)); main()",
         "--version"], cwd=shop, check=True, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),
    )  # fmt: skip
    assert run.stdout.endswith("True\n")


def ended(command: str, shop: Path, messages: Path, after_s: float) -> tuple[int, float, str]:
    """Status, seconds until the end and messages of a command sent Ctrl-C after a while.

    Its standard input gives nothing and does not end. Its messages go to a file: it would wait for
    who reads them once a pipe is full.
    """
    with messages.open("wb") as told:
        process = subprocess.Popen(
            [sys.executable, "-m", "beamcam", *command.split()], cwd=shop,
            env={**os.environ, "PYTHONPATH": str(ROOT)}, stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL, stderr=told,
        )  # fmt: skip
    try:
        time.sleep(after_s)
        assert process.poll() is None, "it ended before it was asked to"
        begun = time.monotonic()
        process.send_signal(signal.SIGINT)
        status = process.wait(timeout=30)
        took = time.monotonic() - begun
    finally:
        process.kill()
        process.communicate()
    return status, took, messages.read_text()


def assert_ends(command: str, shop: Path, messages: Path, after_s: float) -> None:
    """Ends within a second once in three times: other work on the machine may take it once."""
    fastest = inf
    for _ in range(3):
        status, took, said = ended(command, shop, messages, after_s)
        assert status == 130, said
        assert "Traceback" not in said
        fastest = min(fastest, took)
        if fastest < WITHIN_S:
            break
    assert fastest < WITHIN_S


@pytest.mark.parametrize("command", WAITING)
def test_a_command_that_waits(command: str, shop: Path, tmp_path: Path) -> None:
    assert_ends(command, shop, tmp_path / "messages.txt", 0.6)


@pytest.mark.parametrize("command", WORKING)
def test_a_command_at_work(command: str, shop: Path, tmp_path: Path) -> None:
    assert_ends(command, shop, tmp_path / "messages.txt", 0.7)
