"""What shells are given, and what they complete with it."""

import os
import shutil
import subprocess
import sys

import pytest
from click.testing import CliRunner

from beamcam.cli import COMMANDS, main
from tests.conftest import ROOT


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_lines_of_a_shell(shell: str) -> None:
    done = CliRunner().invoke(main, ["completion", shell])
    assert done.exit_code == 0
    assert f"_BEAMCAM_COMPLETE={shell}_complete" in done.stdout
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=done.stdout, text=True, check=True)


def complete(words: str, number: int) -> list[str]:
    """What bash would offer for the word of that number."""
    environment = os.environ | {
        "_BEAMCAM_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(number),
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", "from beamcam.cli import main; main(prog_name='beamcam')"],
        cwd=ROOT, env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return [line.partition(",")[2] for line in done.stdout.splitlines()]


def test_what_is_completed() -> None:
    assert complete("beamcam ba", 1) == ["batch"]
    assert {"batch", "watch", "config", "completion"} <= set(COMMANDS)
    assert "--flat" in complete("beamcam batch --f", 2)
    assert complete("beamcam batch in --machine beamline-a", 4) == ["beamline-annex"]


def test_an_unknown_shell() -> None:
    assert CliRunner().invoke(main, ["completion", "dos"]).exit_code == 2
