"""The folder and the shell of a new user: a copy of the project, and nothing known of beamcam.

`python3 -m venv`, `pip`, `pipx` and `uvx` stand in for those of the system, so that no registry is
asked: they take the words that the real ones take, and `beamcam` is there once it is installed.
"""

import shutil
import sys
import tomllib
from pathlib import Path

from tests.conftest import ROOT, SAMPLES

_PYTHON3 = """#!/bin/sh
# makes an environment that has no package yet, and a pip that installs what the project names
[ "$1 $2" = "-m venv" ] || exec {python} "$@"
{python} -m venv --without-pip "$3" && cp {stubs}/pip "$3/bin/pip"
"""
_PIP = """#!{python}
import pathlib, sys, tomllib
words = sys.argv[1:]
assert words.pop(0) == "install", words
words = [word for word in words if word not in ("-q", "-e")]
(what,) = words
path, _, extras = what.removesuffix("]").partition("[")
project = tomllib.loads((pathlib.Path(path) / "pyproject.toml").read_text())["project"]
for extra in filter(None, extras.split(",")):
    assert extra in project["optional-dependencies"], extra
there = pathlib.Path(sys.argv[0]).parent
script = there / "beamcam"
script.write_text("#!/bin/sh\\nexec {python} -m beamcam \\"$@\\"\\n")
script.chmod(0o755)
for python in there.parent.glob("lib/python*/site-packages"):
    (python / "installed.pth").write_text("\\n".join({paths!r}))
"""
_UVX = """#!/bin/sh
[ "$1 $2 $3" = "--from . beamcam" ] || exit 2
shift 3
exec {python} -m beamcam "$@"
"""
_TOOL = """#!/bin/sh
exec {python} -m beamcam "$@"
"""


def lay_out(home: Path) -> tuple[Path, dict[str, str]]:
    """The folder of a new user, and the environment of their shell; beamcam is not installed."""
    folder, stubs = home / "beamcam", home / "bin"
    shutil.copytree(SAMPLES, folder / "samples")
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, folder)
    (folder / "tests").mkdir()
    (folder / "tests" / "test_it.py").write_text("def test_it() -> None:\n    pass\n")
    stubs.mkdir()
    paths = [str(ROOT), *(path for path in sys.path if path.endswith("site-packages"))]
    texts = {"python3": _PYTHON3, "pip": _PIP, "uvx": _UVX}
    for name, text in texts.items():
        _script(stubs / name, text, stubs, paths)
    environment = {
        "PATH": f"{stubs}:/usr/local/bin:/usr/bin:/bin", "PYTHONPATH": str(ROOT),
        "LC_ALL": "C.UTF-8", "HOME": str(home), "PYTEST_ADDOPTS": "-n 0",
    }  # fmt: skip
    return folder, environment


def install(home: Path) -> None:
    """Let the shell know beamcam, as pipx does."""
    _script(home / "bin" / "beamcam", _TOOL, home / "bin", [])


def _script(path: Path, text: str, stubs: Path, paths: list[str]) -> None:
    path.write_text(text.format(python=sys.executable, stubs=stubs, paths=paths))
    path.chmod(0o755)


def extras() -> dict[str, list[str]]:
    """The extras of the project, with the packages of each."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found: dict[str, list[str]] = project["optional-dependencies"]
    return found
