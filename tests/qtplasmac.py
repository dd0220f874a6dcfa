"""QtPlasmaC's own filter of programs (Debian: linuxcnc-uspace): a stranger who reads every line.

The controller runs it over each program that is opened. Its window, and the pins of a machine that
runs, are stood in for: pins hold 0, and what the window would say is read from the file that the
filter writes for its editor.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from msgspec import Struct

from tests.runs import HANG_S

FILTER = Path("/usr/bin/qtplasmac_gcode")
needs_filter = pytest.mark.skipif(not FILTER.is_file(), reason="QtPlasmaC is not installed")
_QT = "from unittest.mock import MagicMock\n"
_STUBS = {
    "linuxcnc.py": (
        "class command:\n    pass\n\n\nclass ini:\n    def __init__(self, path):\n        pass\n\n"
        "    def find(self, section, key):\n"
        "        return {'DISPLAY': 'qtvcp', 'MACHINE': 'table', 'LINEAR_UNITS': 'mm'}.get(key)\n"
    ),
    "PyQt5/__init__.py": "",
    "PyQt5/QtCore.py": f"{_QT}Qt = MagicMock()\n",
    "PyQt5/QtGui.py": f"{_QT}QIcon = MagicMock()\n",
    "PyQt5/QtWidgets.py": _QT + "".join(
        f"{name} = MagicMock()\n" for name in (
            "QApplication", "QDialog", "QScrollArea", "QWidget", "QVBoxLayout", "QLabel",
            "QPushButton", "QStyle", "QFrame",
        )
    ),
    "halcmd": "#!/bin/sh\necho 0\n",
    "table.prefs": "Cut feed rate = 2300\nKerf width = 1.5\n",
    "table_material.cfg": "[MATERIAL_NUMBER_1]\nCUT_SPEED = 2300\nKERF_WIDTH = 1.5\n",
}  # fmt: skip


class Filtered(Struct, frozen=True):
    """What the filter made of a program."""

    text: str
    faults: tuple[int, ...]  #: lines of errors and warnings


def filtered(program: Path, folder: Path) -> Filtered:
    """What the filter makes of a program, and the lines that it has something to say of.

    It runs in `folder`, with the table of materials that stands there.
    """
    for name, text in _STUBS.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True, parents=True)
        path.write_text(text)
    (folder / "halcmd").chmod(0o755)
    own = folder / "filter.py"
    own.write_text(FILTER.read_text(encoding="utf-8").replace("/tmp/qtplasmac", str(folder)))
    done = subprocess.run(
        [sys.executable, str(own), str(program)], cwd=folder, capture_output=True, text=True,
        env={**os.environ, "INI_FILE_NAME": "table.ini", "PYTHONPATH": str(folder),
             "PATH": f"{folder}:{os.environ['PATH']}"},
        timeout=HANG_S, check=True,
    )  # fmt: skip
    said = (folder / "gcode_errors.txt").read_text().split()
    return Filtered(done.stdout, tuple(map(int, said)))
