"""The source distribution holds all that the project is: samples, pages, tests, changes."""

import os
import subprocess
import sys
import tarfile
from pathlib import Path

from tests.conftest import ROOT

BUILD = "from setuptools.build_meta import build_sdist; build_sdist('dist')"
FILES = ("CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "README.md", "SECURITY.md", "MANIFEST.in",
         "pyproject.toml")  # fmt: skip


def test_the_source_distribution_is_whole(tmp_path: Path) -> None:
    """Of every folder the files, by their names; built of empty ones, without a network."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True
    ).stdout.decode()
    names = [name for name in listed.split("\0") if name]
    for name in names:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        is_needed = name in FILES or name.endswith("version.py")
        (tmp_path / name).write_bytes((ROOT / name).read_bytes() if is_needed else b"")
    (tmp_path / "tests" / "__pycache__").mkdir()
    (tmp_path / "tests" / "__pycache__" / "x.cpython-311.pyc").write_bytes(b"")
    done = subprocess.run(
        [sys.executable, "-c", BUILD], cwd=tmp_path, capture_output=True, check=False,
        env={**os.environ, "PYTHONPATH": ""},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr.decode()[-500:]
    (built,) = (tmp_path / "dist").iterdir()
    with tarfile.open(built) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    wanted = {name for name in names if name != ".gitignore" and not name.startswith(".ci/")}
    assert wanted - held == set()
    assert not any(".pyc" in name for name in held)
