"""The examples of the README and of the documentation are run as they stand there.

A line of an `sh` block that calls `beamcam` is run in a copy of the samples and has to exit 0,
unless a comment behind it says another status, as `# exit 1`.
"""

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import ROOT, SAMPLES

PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_CALL = re.compile(r"(?:^|(?<=\| ))beamcam ")
#: Commands of the system that stand beside those of beamcam.
_BESIDE = ("mkdir ", "cp ", "mv ", "printf ", "export ")
_STATUS = re.compile(r"\s+# exit (\d+)\s*$")


def blocks(text: str, language: str) -> list[str]:
    return [body for kind, body in _BLOCK.findall(text) if kind == language]


def commands(text: str) -> list[tuple[str, int]]:
    """Each command of a page, with the status that it has to end with."""
    found = []
    for body in blocks(text, "sh"):
        for line in body.replace("\\\n", " ").splitlines():
            if _CALL.search(line) or line.startswith(_BESIDE):
                status = _STATUS.search(line)
                found.append((_STATUS.sub("", line), int(status[1]) if status else 0))
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_examples_run(page: Path, tmp_path: Path) -> None:
    """The commands of a page, one after another in one folder, so that they may build on each."""
    text = page.read_text(encoding="utf-8")
    shutil.copytree(SAMPLES, tmp_path / "samples")
    beamcam = f"{shlex.quote(sys.executable)} -m beamcam "
    environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/local/bin:/usr/bin:/bin",
                   "LC_ALL": "C.UTF-8", "HOME": str(tmp_path)}  # fmt: skip
    for command, status in commands(text):
        done = subprocess.run(
            ["sh", "-c", _CALL.sub(beamcam, command)], cwd=tmp_path, env=environment,
            capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=60,
        )  # fmt: skip
        assert done.returncode == status, f"{command}\n{done.stderr}"
    for example in blocks(text, "python"):
        done = subprocess.run(
            [sys.executable, "-c", example], cwd=tmp_path, env=environment, capture_output=True,
            text=True, timeout=60,
        )  # fmt: skip
        assert done.returncode == 0, f"{example}\n{done.stderr}"


def test_configurations_in_the_documentation_are_read(tmp_path: Path) -> None:
    from beamcam.config.load import load
    from beamcam.config.values import ConfigFile

    path = tmp_path / "beamcam.toml"
    (example,) = blocks((ROOT / "docs" / "config.md").read_text(encoding="utf-8"), "toml")
    path.write_text(example)
    assert set(ConfigFile.__struct_fields__) == {
        row.key.partition(".")[0] for row in load(path).settings() if row.source
    }


def test_commands_are_found() -> None:
    text = (
        "```sh\nbeamcam a  # exit 1\nls\nbeamcam b \\\n  -c\n```\n```text\nbeamcam d\n```\n"
        "```sh\nbeamcam e # why\ncat x | beamcam f\n```\n"
    )
    assert commands(text) == [
        ("beamcam a", 1),
        ("beamcam b    -c", 0),
        ("beamcam e # why", 0),
        ("cat x | beamcam f", 0),
    ]
    assert commands((ROOT / "docs" / "commands" / "batch.md").read_text(encoding="utf-8"))


def test_the_check_can_fail(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = tmp_path / "page.md"
    page.write_text("```sh\nbeamcam inspect samples/dstv/none.nc1\n```\n")
    with pytest.raises(AssertionError, match="read-file"):
        test_examples_run(page, tmp_path)
