"""Small parts for tests of many files, and commands called as from a shell."""

import json
import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from click.testing import CliRunner, Result

from beamcam.cli import main

HEAD = (
    "ST\n** {mark}.nc1\n  TEST\n  1\n  1\n  {mark}\n  S235JR\n  {quantity}\n  UPN200\n  U\n"
    "{length:13.2f}\n       200.00\n        75.00\n        11.50\n         8.50\n        11.50\n"
    "       25.300\n        0.661\n        0.000\n        0.000\n        0.000\n        0.000\n"
    "\n\n\n\n"
)


def part(mark: str, length: float = 2000.0, quantity: int = 1, diameter: float = 18.0) -> str:
    """The text of a DSTV file with one hole; of 7.2 threaded no machine has a tap for it."""
    head = HEAD.format(mark=mark, quantity=quantity, length=length)
    return f"{head}BO\n  v  100.00u   60.00  {diameter:7.2f}\nEN\n"


#: A thread that no machine here has a tap for; whatever is as large and round can be drilled.
BAD = part("BAD", diameter=7.2).replace("   60.00  ", "   60.00g ")


def fill(folder: Path, count: int, bad: int | None = None) -> None:
    """`count` parts P000.nc1, ...; number `bad` is one that is refused."""
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(count):
        text = BAD if k == bad else part(f"P{k}", 1500.0 + k, 1 + k % 3)
        (folder / f"P{k:03d}.nc1").write_text(text)


def call(*words: object, stdin: str | bytes | None = None, status: int | None = None) -> Result:
    """What comes of a command, which ends in this status, or in any, never in an exception."""
    done = CliRunner().invoke(main, [*map(str, words)], input=stdin)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    assert status in (None, done.exit_code), (words, done.exit_code, done.output)
    return done


def batch(
    *args: object, stdin: str | None = None, command: str = "batch", status: int | None = None
) -> Result:
    return call(command, *args, stdin=stdin, status=status)


def counts(result: Result) -> tuple[int, int, int, int]:
    """Posted, unchanged, refused and failed of the last line."""
    words = result.stderr.splitlines()[-1].replace(",", "").split()
    assert words[1::2][:4] == ["posted", "unchanged", "refused", "failed"]
    return int(words[0]), int(words[2]), int(words[4]), int(words[6])


def programs(folder: Path) -> dict[str, bytes]:
    """Every file in a folder by its path below it, but for the record."""
    return {
        p.relative_to(folder).as_posix(): p.read_bytes()
        for p in folder.rglob("*")
        if p.is_file() and p.name != ".beamcam-batch.jsonl"
    }


def report(path: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data


#: Seconds after which a test gives up that would wait for good; no measure of anything.
HANG_S = 300.0


def wait_until(event: Callable[[], object], process: subprocess.Popen[Any] | None = None) -> None:
    """Wait for something, however long it takes; the process that does it must not end before."""
    end = time.monotonic() + HANG_S
    while not event():
        assert process is None or process.poll() is None or event(), "it ended before"
        assert time.monotonic() < end, "nothing happens"
        time.sleep(0.01)


def processor_s(pid: int) -> float:
    """Seconds that a process has had of the processor."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def is_asleep(pid: int) -> bool:
    """Whether a process waits for something, as for its input."""
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "S"


def children(pid: int) -> list[int]:
    """The processes that one has started, and those that they have."""
    try:
        text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    except FileNotFoundError:  # it has ended
        return []
    own = [int(word) for word in text.split()]
    return [*own, *(below for one in own for below in children(one))]


def lives(pid: int) -> bool:
    """Whether a process is there, and not one that ended and is still listed."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def interrupted(process: subprocess.Popen[str]) -> None:
    """Ctrl-C ends a server, without a traceback."""
    assert process.stderr is not None
    process.send_signal(signal.SIGINT)
    assert process.wait(HANG_S) == 130
    assert "Traceback" not in process.stderr.read()
