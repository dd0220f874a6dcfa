"""LinuxCNC's own interpreter, `rs274` (Debian: linuxcnc-uspace): a stranger who runs a program."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

from tests.runs import HANG_S

RS274 = shutil.which("rs274")
needs_rs274 = pytest.mark.skipif(RS274 is None, reason="rs274 of LinuxCNC is not installed")
#: Of a plasma table, as QtPlasmaC has it: the torch, the scribe and the spotting of centres.
INI = "[TRAJ]\nSPINDLES = 3\n[RS274NGC]\nPARAMETER_FILE = rs274.var\n"


def interpreted(
    program: Path, *, ini: str = "", tools: str = "", folder: Path | None = None
) -> "subprocess.CompletedProcess[str]":
    """What the interpreter prints of a program, with a configuration and a table of tools.

    It runs in `folder`, by default one of its own, which also is its home: it keeps its table of
    tools in `~/.tool.mmap` and dies of SIGBUS when another one empties that file.
    """
    assert RS274 is not None
    with tempfile.TemporaryDirectory() as own:
        options: list[str] = []
        for option, name, text in (("-i", "cell.ini", ini), ("-t", "tools.tbl", tools)):
            if text:
                (Path(own) / name).write_text(text)
                options += [option, str(Path(own) / name)]
        done = subprocess.run(
            [RS274, *options, "-g", str(program.resolve())], cwd=folder or own,
            env={**os.environ, "HOME": own}, capture_output=True, text=True, timeout=HANG_S,
            check=False,
        )  # fmt: skip
    assert done.returncode >= 0, f"rs274 died of signal {-done.returncode}"
    return done
