"""Ctrl-C ends the reading of a model at once, whatever the geometry kernel is building."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.property.ifc_cuts import SIZES, Bar, Round, model_of
from tests.runs import HANG_S, children, lives, processor_s, wait_until


@pytest.mark.parametrize("command", ["inspect", "batch --jobs 1"])
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
