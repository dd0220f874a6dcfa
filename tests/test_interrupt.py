"""Ctrl-C ends every command, whatever it does, with exit status 130 and no traceback."""

import fcntl
import os
import signal
import subprocess
import sys
import termios
from collections.abc import Callable
from pathlib import Path

import pytest

from beamcam.system import asked_to_end, interrupts_waiting
from tests.conftest import ROOT, sampled
from tests.property.ifc_cuts import SIZES, Bar, Round, model_of
from tests.runs import HANG_S, children, fill, is_asleep, lives, part, processor_s, wait_until

FILES = 2000
#: Each waits for what stands on its standard input, in the middle of its work.
WAITING = (
    "post - -o x.gcode", "plan -", "inspect -", "convert - -o x.json", "verify - ", "diff - a.nc1",
    "recover - --profile UPN200 -o x.nc1", "simulate - -o x.csv", "plot - -o x.svg",
    "batch - -o out", "list - -o -", "labels - -o x.pdf",
)  # fmt: skip
#: Each has work for many seconds, or until it is ended.
WORKING = (
    "post big.dxf --thickness 3 -o x.ngc", "plan big.dxf --thickness 3", "inspect big.dxf",
    "check golden --samples many", "diff many more",
    "profile --velocity 1 --time 9 --step 1e-5 -o -",
)  # fmt: skip
RUNNING = ("batch many --jobs 1", "batch many --jobs 2", "watch many --settle 0")


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
    fill(folder / "many", FILES)
    (folder / "golden" / "beamline").mkdir(parents=True)
    (folder / "more").mkdir()
    for path in (folder / "many").iterdir():
        (folder / "golden" / "beamline" / f"{path.stem}.gcode").write_text("%\n")
        (folder / "more" / path.name).write_text(path.read_text().replace("18.00", "19.00"))
    return folder


#: Imports into a start, counted from that of the command line, at which Ctrl-C comes.
AT_IMPORTS = {"post a.nc1 -o x.gcode": (1, 30, 120, 180), "inspect big.dxf": (5, 400, 500)}
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
    ("command", "at"),
    sampled([(command, at) for command, each in AT_IMPORTS.items() for at in each], 4),
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
        "once = [signal.SIGINT]\n"
        "os.register_at_fork(after_in_parent=lambda: once and os.kill(os.getpid(), once.pop()))\n"
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


def ended(
    command: str, shop: Path, messages: Path, begun: Callable[["subprocess.Popen[bytes]"], bool]
) -> tuple[int, str]:
    """Status and messages of a command that is sent Ctrl-C once it has begun.

    Its standard input gives an empty line and does not end. Its messages go to a file: it would
    wait for who reads them once a pipe is full.
    """
    with messages.open("wb") as told:
        process = subprocess.Popen(
            [sys.executable, "-m", "beamcam", *command.split()], cwd=shop,
            env={**os.environ, "PYTHONPATH": str(ROOT)}, stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL, stderr=told,
        )  # fmt: skip
    try:
        assert process.stdin is not None
        process.stdin.write(b"\n")
        process.stdin.flush()
        wait_until(lambda: begun(process), process)
        process.send_signal(signal.SIGINT)
        status = process.wait(HANG_S)
    finally:
        process.kill()
        process.communicate()
    return status, messages.read_text()


def has_taken_its_input(process: "subprocess.Popen[bytes]") -> bool:
    """Whether a command has read what stood on its standard input, and waits for more.

    Python hears of a signal that comes between two reads when the second one ends.
    """
    assert process.stdin is not None
    left = fcntl.ioctl(process.stdin.fileno(), termios.FIONREAD, bytes(4))
    return int.from_bytes(left, sys.byteorder) == 0 and is_asleep(process.pid)


def is_at_work(process: "subprocess.Popen[bytes]") -> bool:
    """Whether a command has done more than to load its modules."""
    return processor_s(process.pid) > 0.8


@pytest.mark.parametrize("command", sampled(WAITING, 4))
def test_a_command_that_waits(command: str, shop: Path, tmp_path: Path) -> None:
    status, said = ended(command, shop, tmp_path / "messages.txt", has_taken_its_input)
    assert status == 130, said
    assert "Traceback" not in said


@pytest.mark.parametrize("command", sampled(WORKING, 3))
def test_a_command_at_work(command: str, shop: Path, tmp_path: Path) -> None:
    status, said = ended(command, shop, tmp_path / "messages.txt", is_at_work)
    assert status == 130, said
    assert "Traceback" not in said


@pytest.mark.parametrize("command", sampled(RUNNING, 2))
def test_a_run_of_many_files(command: str, shop: Path, tmp_path: Path) -> None:
    """It ends with the counts of what it wrote."""
    out = tmp_path / "out"
    status, said = ended(
        f"{command} -o {out}", shop, tmp_path / "messages.txt",
        lambda process: out.is_dir() and any(out.glob("*.gcode")),
    )  # fmt: skip
    assert status == 130, said
    assert "Traceback" not in said
    count = len(list(out.glob("*.gcode")))
    assert said.splitlines()[-1].startswith(f"{count} posted, 0 unchanged, 0 refused, 0 failed")
    assert count < FILES


def test_one_long_file_of_a_run(shop: Path, tmp_path: Path) -> None:
    """It is in work elsewhere, and is not waited for."""
    status, said = ended(
        f"batch big.dxf -o {tmp_path / 'out'} --thickness 3", shop, tmp_path / "messages.txt",
        lambda process: any(processor_s(pid) > 0.4 for pid in children(process.pid)),
    )  # fmt: skip
    assert status == 130, said
    assert said.splitlines()[-1] == "0 posted, 0 unchanged, 0 refused, 0 failed (interrupted)"


def test_who_asks_twice_does_not_wait(tmp_path: Path) -> None:
    """In a loop that does not read the flag; what is half made is taken back."""
    half = tmp_path / "half"
    code = (
        "import os, signal, sys\n"
        "from beamcam.system import asked_to_end, taken_back\n"
        "open(sys.argv[1], 'w').close()\n"
        "with asked_to_end() as asked, taken_back(lambda: os.unlink(sys.argv[1])):\n"
        "    signal.raise_signal(signal.SIGINT)\n"
        "    print(bool(asked), flush=True)\n"
        "    signal.raise_signal(signal.SIGINT)\n"
        "    print('goes on', flush=True)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", code, str(half)], capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert (run.returncode, run.stdout, run.stderr) == (130, "True\n", "")
    assert not half.exists()


def test_a_wait_ends_when_it_is_asked_to() -> None:
    with asked_to_end() as asked:
        asked.wait(0.0)
        assert not asked
        signal.raise_signal(signal.SIGTERM)
        asked.wait(1e9)
        assert asked


def test_a_stretch_without_interrupts() -> None:
    """What is heard meanwhile is heard at the end of it."""
    with asked_to_end() as asked:
        with interrupts_waiting():
            signal.raise_signal(signal.SIGINT)
            assert not asked
        assert asked


# --- models ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", sampled(["batch --jobs 1", "inspect"], 2))
def test_an_interrupt_does_not_wait_for_the_kernel(command: str, tmp_path: Path) -> None:
    bar = Bar("I", 9000.0, SIZES["I"])
    model, out = tmp_path / "model.ifc", tmp_path / "out"
    model.write_bytes(  # half a minute of the kernel's time
        model_of(bar, [Round((30.0 + 12 * i, -10.0, 40.0), 1, 10.0, 400.0) for i in range(600)])
    )
    asked = [*command.split(), str(model), *(["-o", f"{out}/"] if command != "inspect" else [])]
    run = subprocess.Popen([sys.executable, "-m", "beamcam", *asked], stdout=subprocess.PIPE)
    wait_until(  # in the process that builds, which has started none
        lambda: any(processor_s(p) > 1.5 for p in children(run.pid) if not children(p)), run
    )
    workers = children(run.pid)
    run.send_signal(signal.SIGINT)
    said = run.communicate(timeout=HANG_S)[0]
    # Had it waited for the kernel, it would have had something to say, and a program to write.
    assert (run.returncode, said) == (130, b"")
    assert not list(out.glob("*.gcode"))
    for pid in workers:
        wait_until(lambda pid=pid: not lives(pid))  # type: ignore[misc]
