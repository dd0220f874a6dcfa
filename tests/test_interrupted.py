"""Ctrl-C ends the reading of a model at once, whatever the geometry kernel is building."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.property.ifc_cuts import SIZES, Bar, Round, model_of

GRACE_S = 5.0  #: of a loaded machine; left to itself the kernel takes as long as it takes


@pytest.mark.parametrize("command", ["inspect", "batch --jobs 1"])
def test_an_interrupt_does_not_wait_for_the_kernel(command: str, tmp_path: Path) -> None:
    bar = Bar("I", 9000.0, SIZES["I"])
    model, out = tmp_path / "model.ifc", tmp_path / "out"
    model.write_bytes(  # half a minute of the kernel's time
        model_of(bar, [Round((30.0 + 12 * i, -10.0, 40.0), 1, 10.0, 400.0) for i in range(600)])
    )
    asked = [*command.split(), str(model), *(["-o", f"{out}/"] if command != "inspect" else [])]
    run = subprocess.Popen([sys.executable, "-m", "beamcam", *asked], stdout=subprocess.DEVNULL)
    end = time.monotonic() + 30
    while not (workers := children(run.pid)) or max(map(busy, workers)) < 0.5:
        assert run.poll() is None, "it was done before it was interrupted"
        assert time.monotonic() < end
        time.sleep(0.05)
    run.send_signal(signal.SIGINT)
    begun = time.monotonic()
    assert run.wait(60) == 130
    assert time.monotonic() - begun < GRACE_S
    assert not out.exists() or not list(out.iterdir())
    assert not any(Path(f"/proc/{pid}").exists() for pid in workers)


def children(pid: int) -> list[int]:
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(word) for word in text.split()]


def busy(pid: int) -> float:
    """Seconds that a process has had of the processor."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100
