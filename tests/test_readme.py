"""The examples of the README and of the documentation are run as they stand there.

All lines of the `sh` blocks of a page are run in the folder of a new user, one after another, and
each has to exit 0, unless a comment behind it says another status, as `# exit 1`. Lines for
PowerShell are held against the words that it and beamcam take.
"""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path, PureWindowsPath

import click
import pytest
from click.testing import CliRunner

from beamcam.cli import main
from tests import new_user
from tests.conftest import ROOT, sampled
from tests.runs import HANG_S
from tests.test_docs import WORDS

PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_COMMENT = re.compile(r"\s+#.*$")
_STATUS = re.compile(r"\s+# exit (\d+)\s*$")


def blocks(text: str, language: str) -> list[str]:
    return [body for kind, body in _BLOCK.findall(text) if kind == language]


def commands(text: str) -> list[tuple[str, int]]:
    """Each command of a page, with the status that it has to end with."""
    found = []
    for body in blocks(text, "sh"):
        for line in filter(None, body.replace("\\\n", " ").splitlines()):
            status = _STATUS.search(line)
            found.append((_STATUS.sub("", line), int(status[1]) if status else 0))
    return found


def script(asked: Iterable[tuple[str, int]]) -> str:
    """Commands as one script, which ends at the first that does not do as it says."""
    lines = []
    for command, status in asked:
        told = shlex.quote(f"{command}: expected exit {status}, found exit ")
        lines += [
            "status=0", f"{command} || status=$?",
            f'[ "$status" = {status} ] || {{ echo {told}"$status" >&2; exit 99; }}',
        ]  # fmt: skip
    return "\n".join(lines)


#: What a shell does more with than to take a line apart into words.
_OF_A_SHELL = frozenset("|&;<>$*?`~")


def run_here(command: str) -> tuple[int, str]:
    """A command of beamcam run in this process, which has its libraries: status and output."""
    done = CliRunner().invoke(main, shlex.split(command, comments=True)[1:], prog_name="beamcam")
    if not isinstance(done.exception, SystemExit | None):
        raise done.exception
    return done.exit_code, done.output


def run_examples(
    asked: Iterable[tuple[str, int]], folder: Path, environment: dict[str, str]
) -> None:
    """Runs commands one after another, so that they may build on each; by a shell where it takes
    one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for name in os.environ.keys() - environment.keys():
            patch.delenv(name)
        for name, value in environment.items():
            patch.setenv(name, value)
        for command, expected in asked:
            if command.startswith("beamcam ") and _OF_A_SHELL.isdisjoint(command):
                found, output = run_here(command)
                assert found == expected, f"{command}\n{output}"
            else:
                run_by_shell([(command, expected)], folder, environment)


#: The page of copers has 40 calls, each with a solid or a program that other tests have as well.
LONG = pytest.param(ROOT / "docs" / "coping.md", marks=pytest.mark.exhaustive)


@pytest.mark.parametrize(
    "page",
    [*sampled((page for page in PAGES[1:] if page not in LONG.values), 4), LONG],
    ids=lambda p: p.name,
)
def test_examples_run(page: Path, tmp_path: Path) -> None:
    folder, environment = new_user.lay_out(tmp_path)
    new_user.install(tmp_path)
    text = page.read_text(encoding="utf-8")
    run_examples(commands(text), folder, environment)
    run_python(text, folder, environment)


def test_examples_of_the_readme_run(tmp_path: Path) -> None:
    """By one shell until beamcam is installed, and is found there."""
    folder, environment = new_user.lay_out(tmp_path)
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    asked = commands(text)
    first = next(k for k, (command, _) in enumerate(asked) if command.startswith("beamcam "))
    run_by_shell(asked[: first + 1], folder, environment)
    new_user.install(tmp_path)
    run_examples(asked[first + 1 :], folder, environment)
    run_python(text, folder, environment)


def run_by_shell(
    asked: Iterable[tuple[str, int]], folder: Path, environment: dict[str, str]
) -> None:
    done = subprocess.run(
        ["sh", "-c", script(asked)], cwd=folder, env=environment, capture_output=True, text=True,
        stdin=subprocess.DEVNULL, timeout=HANG_S,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def run_python(text: str, folder: Path, environment: dict[str, str]) -> None:
    """Runs the Python examples of a page."""
    for example in blocks(text, "python"):
        done = subprocess.run(
            [sys.executable, "-c", example], cwd=folder, env=environment, capture_output=True,
            text=True, timeout=HANG_S,
        )  # fmt: skip
        assert done.returncode == 0, f"{example}\n{done.stderr}"


def test_a_new_user_does_not_have_beamcam(tmp_path: Path) -> None:
    folder, environment = new_user.lay_out(tmp_path)
    done = subprocess.run(["sh", "-c", "beamcam"], cwd=folder, env=environment, check=False,
                          capture_output=True)  # fmt: skip
    assert done.returncode == 127


#: What may begin a command of PowerShell, besides beamcam.
CMDLETS = ("py", "pip", "pipx", "uvx", "Get-ChildItem", "ForEach-Object", "Set-ExecutionPolicy")
_WORD = re.compile(r"""'[^']*'|"[^"]*"|\||\{[^}]*\}|[^\s|]+""")


def powershell_calls(text: str) -> Iterator[list[str]]:
    """The words of each command in the PowerShell blocks of a page, quotes taken off."""
    for body in blocks(text, "powershell"):
        for line in filter(None, body.splitlines()):
            call: list[str] = []
            for word in [*_WORD.findall(_COMMENT.sub("", line)), "|"]:
                if word == "|":
                    yield call
                    call = []
                else:
                    call.append(word[1:-1] if word[0] in "'\"" else word)


def check_powershell(words: list[str]) -> None:
    """Whether PowerShell, on a copy of the project, and beamcam take the words of a command."""
    first, *rest = words
    name = PureWindowsPath(first).name
    assert not {"&&", "||", "export", "\\"} & set(words), words
    for word in rest:
        if word.startswith("samples\\"):
            assert "/" not in word
            assert list(ROOT.glob(word.replace("\\", "/"))), word
    if name == "Activate.ps1":
        assert first == ".venv\\Scripts\\Activate.ps1"
    elif name == "beamcam":
        command, *options = rest
        posix = [word.replace("\\", "/") for word in options]
        WORDS[command].make_context(command, posix)
    else:
        assert name in CMDLETS, words
        assert name != "pip" or rest[0] == "install"


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_lines_for_powershell_are_words_that_it_takes(page: Path) -> None:
    for words in powershell_calls(page.read_text(encoding="utf-8")):
        check_powershell(words)


@pytest.mark.parametrize(
    "line",
    ["beamcam pots samples\\dstv\\channel.nc1", "beamcam post samples/dstv/channel.nc1 -x 1",
     "beamcam inspect samples\\dstv\\none.nc1", "cat x", "pip uninstall x",
     "beamcam doctor && beamcam config"],
)  # fmt: skip
def test_the_check_of_powershell_can_fail(line: str) -> None:
    (words,) = powershell_calls(f"```powershell\n{line}\n```\n")
    with pytest.raises((AssertionError, KeyError, click.UsageError)):
        check_powershell(words)


def test_both_shells_are_told_the_same() -> None:
    """The first command that PowerShell is given is the one that the README gives to bash."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    posix = {word for line, _ in commands(text) for word in shlex.split(line)}
    first, *_ = powershell_calls((ROOT / "docs" / "shells.md").read_text(encoding="utf-8"))
    for word in first[1:]:
        assert word.replace("\\", "/") in posix, word


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
        ("ls", 0),
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
