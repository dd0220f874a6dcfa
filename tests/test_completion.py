"""What shells are given, and what they complete with it."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from beamcam.cli import COMMANDS
from tests.conftest import ROOT
from tests.runs import call


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_lines_of_a_shell(shell: str) -> None:
    done = call("completion", shell)
    assert done.exit_code == 0
    assert f"_BEAMCAM_COMPLETE={shell}_complete" in done.stdout
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=done.stdout, text=True, check=True)


#: Each shell, made to say what it offers behind a line; BEAMCAM is how it is called here.
ASKED = {
    "bash": "source lines; COMP_WORDS=({words} {last}); COMP_CWORD={count}; "
    "_beamcam_completion beamcam; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
    "zsh": "compdef() {{ }}; compadd() {{ print -l -- $completions }}; "
    "_describe() {{ print -l -- $completions_with_descriptions }}; source ./lines; "
    "words=({words} {last}); CURRENT={count}+1; _beamcam_completion",
    "fish": "source lines; complete -C '{words} {last}'",
}


@pytest.mark.parametrize("shell", [shell for shell in ASKED if shutil.which(shell)])
@pytest.mark.parametrize(
    ("words", "last", "offered"),
    [
        ("beamcam", "ba", {"batch"}),
        ("beamcam batch in --machine", "beamline-", {"beamline-annex", "beamline-pusher"}),
        ("beamcam post a.nc1", "--verb", {"--verbose"}),
        ("beamcam machines", "sh", {"show"}),
    ],
)
def test_a_shell_that_is_at_hand_completes(
    tmp_path: Path, shell: str, words: str, last: str, offered: set[str]
) -> None:
    program = tmp_path / "beamcam"
    program.write_text(
        f"#!/bin/sh\nPYTHONPATH={shlex.quote(str(ROOT))} exec {shlex.quote(sys.executable)} "
        '-m beamcam "$@"\n'
    )
    program.chmod(0o755)
    (tmp_path / "lines").write_text(call("completion", shell).stdout)
    asked = ASKED[shell].format(words=words, last=last, count=len(words.split()))
    done = subprocess.run(
        [shell, "-c", asked], cwd=tmp_path, capture_output=True, text=True, check=False,
        env=os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}", "HOME": str(tmp_path)},
    )  # fmt: skip
    found = {line.partition("\t")[0].partition(":")[0] for line in done.stdout.splitlines()}
    assert found - {""} == offered, done.stderr


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


def test_powershell_asks_as_bash_does() -> None:
    """The words before the cursor, and the number of the one that is completed; then kind,value."""
    lines = call("completion", "powershell").stdout
    assert lines.startswith("Register-ArgumentCompleter -Native -CommandName beamcam ")
    assert all(lines.count(a) == lines.count(b) for a, b in ("{}", "()", "[]"))
    asked = {"_BEAMCAM_COMPLETE", "COMP_WORDS", "COMP_CWORD"}
    assert {*re.findall(r"\$env:(\w+) = ", lines)} == asked == {*re.findall(r" Env:(\w+)", lines)}
    assert "$env:_BEAMCAM_COMPLETE = 'bash_complete'" in lines
    # A word that is not begun yet is the one behind the last.
    assert "show" in complete("beamcam machines ", 2)


def test_an_unknown_shell() -> None:
    assert call("completion", "dos").exit_code == 2
