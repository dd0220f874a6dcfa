"""What all commands have in common: how they talk, and where they read and write."""

import errno
import json
import os
import re
import subprocess
import sys
from io import StringIO
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result

from beamcam.cli import COMMANDS, main
from beamcam.commands import common
from beamcam.commands.common import Console
from tests.conftest import ROOT, SAMPLES, sampled
from tests.runs import BAD, part
from tests.test_docs import WORDS

#: Its reader warns, and it can be made all the same.
WARNED = (SAMPLES / "dstv" / "channel.nc1").read_text().replace("     15.000\n", "0.000\n", 1)

#: A call of each command that takes --quiet and --verbose, on a part `{i}.nc1`.
CALLS = {
    "post": "post {i}.nc1 -o {i}.out",
    "plan": "plan {i}.nc1",
    "inspect": "inspect {i}.nc1",
    "convert": "convert {i}.nc1 -o {i}.json",
    "verify": "verify {i}.gcode --against {i}.nc1",
    "diff": "diff {i}.gcode {i}.gcode",
    "recover": "recover {i}.gcode --profile {i}.nc1 -o {i}.made.nc1",
    "check": "check golden/beamline --samples .",
    "simulate": "simulate {i}.gcode -o {i}.csv",
    "plot": "plot {i}.nc1 -o {i}.svg",
    "report": "report {i}.nc1 -o {i}.html",
    "profile": "profile --velocity 100 --time 2 -o {i}.csv",
    "split": "split {i}.nc1 --machines beamline -o chain",
    "batch": "batch {i}.nc1 -o out --force",
    "watch": "watch . -o out --once --settle 0",
    "list": "list {i}.nc1 -o {i}.list.csv",
    "labels": "labels {i}.nc1 -o {i}.zpl",
    "machines check": "machines check beamline",
    "machines plot": "machines plot beamline -o {i}.line.svg",
}
#: Those whose --json is about messages, on standard error, and those that print their result so.
_SECONDS = re.compile(r'"seconds":[^,]*,')  #: a batch tells how long each file took
JSON_MESSAGES, JSON_RESULT = ("post", "convert", "simulate", "recover", "plot", "report",
                              "split"), (
    "plan", "inspect", "verify", "diff", "check", "batch", "watch",
)  # fmt: skip


def call(line: str, stdin: str | None = None) -> Result:
    done = CliRunner().invoke(main, line.split(), input=stdin)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("good"))
        Path("w.nc1").write_text(WARNED)
        assert call("post w.nc1 -o w.gcode").exit_code == 0
        return Path("w.gcode").read_bytes()


@pytest.fixture
def good(program: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of a part that is warned of, with its program, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    Path("w.nc1").write_text(WARNED)
    Path("golden/beamline").mkdir(parents=True)
    for name in ("w.gcode", "golden/beamline/w.gcode"):
        Path(name).write_bytes(program)
    return "w"


def test_every_command_with_messages_is_tried() -> None:
    def has_voice(command: click.Command) -> bool:
        return any("--quiet" in param.opts for param in command.params)

    assert {words for words, command in WORDS.items() if has_voice(command)} == {
        *CALLS, "monitor", "machines new",  # which writes no file twice
    }  # fmt: skip
    assert set(COMMANDS) - set(CALLS) == {
        "machines", "config", "completion", "codes", "doctor", "monitor",
    }  # fmt: skip


@pytest.mark.parametrize("command", CALLS)
def test_quiet_says_nothing_of_what_is_right(good: str, command: str) -> None:
    done = call(CALLS[command].format(i=good) + " -q")
    assert (done.exit_code, done.stderr) == (0, "")
    done = call(CALLS[command].format(i=good) + " -q -v")
    assert (done.exit_code, "--quiet and --verbose exclude each other." in done.stderr) == (2, True)


@pytest.mark.parametrize("command", ["post", "plan", "inspect", "convert", "batch", "verify"])
def test_quiet_says_errors(good: str, command: str) -> None:
    text = WARNED.replace("EN\n", "BO\n  v  500.00u   60.00    65.00\nXX\nEN\n")
    Path("w.nc1").write_text(text)
    quiet, loud = (call(CALLS[command].format(i=good) + more) for more in (" --quiet", ""))
    assert quiet.exit_code == loud.exit_code == 1
    assert quiet.stderr
    assert all(": error " in line for line in quiet.stderr.splitlines())
    assert ": warning " in loud.stderr


@pytest.mark.parametrize("command", CALLS)
def test_verbose_tells_what_is_done_and_how_long_it_takes(good: str, command: str) -> None:
    line = CALLS[command].format(i=good)
    plain, verbose = call(line), call(line + " -v")
    assert verbose.exit_code == 0
    told = [line for line in verbose.stderr.splitlines() if line.endswith(" ms)")]
    assert told
    assert " ms)" not in plain.stderr
    assert verbose.stdout == plain.stdout
    if command in ("post", "plan", "batch", "watch"):
        assert "17 read = 13 made + 4 merged" in verbose.stderr


@pytest.mark.parametrize("command", JSON_MESSAGES)
def test_messages_and_account_are_one_json_list(good: str, command: str) -> None:
    line = CALLS[command].format(i=good) + " --json"
    plain, verbose, quiet = (json.loads(call(line + more).stderr) for more in ("", " -v", " -q"))
    assert [m for m in verbose if m["code"] != "account"] == plain
    assert len(verbose) > len(plain)
    assert quiet == []
    if command not in ("simulate", "split"):
        assert {m["severity"] for m in plain} == {"warning"}


@pytest.mark.parametrize("command", JSON_RESULT)
def test_results_are_json_on_standard_output(good: str, command: str) -> None:
    line = CALLS[command].format(i=good) + " --json"
    plain, verbose = (call(line + more) for more in ("", " -v"))
    first, second = (
        _SECONDS.sub("", done.stdout).replace("unchanged", "posted") for done in (plain, verbose)
    )
    assert json.loads(first) == json.loads(second)
    assert plain.stderr == ""
    assert {m["code"] for m in json.loads(verbose.stderr)} == {"account"}


@pytest.mark.parametrize(
    ("piped", "named"),
    [
        ("post - -o -", "post w.nc1 -o -"),
        ("plan -", "plan w.nc1"),
        ("convert - -o - --to part-json", "convert w.nc1 -o - --to part-json"),
        ("diff - w.nc1", "diff w.nc1 w.nc1"),
        ("diff w.nc1 -", "diff w.nc1 w.nc1"),
        ("verify w.gcode --against -", "verify w.gcode --against w.nc1"),
        ("inspect - --json", "inspect w.nc1 --json"),
    ],
)
def test_parts_from_standard_input(good: str, piped: str, named: str) -> None:
    left, right = call(piped, WARNED), call(named)
    assert left.exit_code == right.exit_code == 0
    assert left.stdout.replace("stdin", "w.nc1").replace('"file": "-"', '"file": "w.nc1"') == (
        right.stdout
    )
    assert left.stderr.replace("stdin", "w.nc1") == right.stderr


@pytest.mark.parametrize(
    ("piped", "named"),
    [
        ("verify - --against w.nc1", "verify w.gcode --against w.nc1"),
        ("verify -", "verify w.gcode"),
        ("diff - w.gcode", "diff w.gcode w.gcode"),
        ("diff w.gcode -", "diff w.gcode w.gcode"),
        ("simulate - -o -", "simulate w.gcode -o -"),
    ],
)
def test_programs_from_standard_input(good: str, piped: str, named: str) -> None:
    left, right = call(piped, Path("w.gcode").read_text()), call(named)
    said = left.stderr.replace("stdin", "w.gcode")
    assert (left.exit_code, left.stdout, said) == (0, right.stdout, right.stderr)


@pytest.mark.parametrize(
    "line", ["post - - -o x", "plan - -", "inspect - -", "verify - --against -", "diff - -"]
)
def test_standard_input_is_read_once(line: str) -> None:
    done = call(line, WARNED)
    assert done.exit_code == 2
    assert "found - twice; expected it once" in done.stderr


@pytest.mark.parametrize(
    "line",
    [
        "post w.nc1 -o no/such/a.gcode",
        "plan w.nc1 -o no/such/plan.txt",
        "convert w.nc1 -o no/such/a.json",
        "convert w.nc1 -o w.nc1/",
        "simulate w.gcode -o no/such/a.csv",
        "profile --velocity 100 --time 2 -o no/such/a.csv",
    ],
)
def test_an_output_that_cannot_be_written(good: str, line: str) -> None:
    done = call(line)
    assert done.exit_code == 1
    assert ": error write-file: found" not in done.stderr  # the name, then why
    assert "error write-file: '" in done.stderr
    assert "cannot be written (" in done.stderr
    assert Path("w.nc1").read_text() == WARNED


@pytest.mark.parametrize("line", ["verify none", "simulate none -o -", "diff none none"])
def test_a_program_that_cannot_be_read(line: str) -> None:
    done = call(line)
    assert done.exit_code == 1
    assert done.stderr.startswith("none: error read-file: found no file that can be read (No such")


@pytest.mark.parametrize(
    "command",
    sampled(["post", "inspect", "plan", "--help", "post --help", "convert", "--version"], 3),
)
def test_a_full_standard_output(good: str, command: str) -> None:
    """A device without room, as a disk that is full: no traceback, and it is not silent."""
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    line = {"post": "post w.nc1 -o -", "convert": "convert w.nc1 -o - --to dstv"}.get(
        command, command if "--" in command else f"{command} w.nc1"
    )
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "beamcam", *line.split()], stdout=full, text=True,
            stderr=subprocess.PIPE, env={"PYTHONPATH": str(ROOT)}, check=False,
        )  # fmt: skip
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "error write-file: 'stdout' cannot be written (No space left on device)" in done.stderr


def test_a_reader_that_has_had_enough(good: str) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "beamcam", "codes"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    said = process.stderr.read()
    process.stderr.close()
    assert process.wait() == 1
    assert said == b""


def test_a_command_that_is_none() -> None:
    done = call("pots a.nc1")
    assert done.exit_code == 2
    assert "No such command 'pots'. Did you mean 'post'?" in done.stderr


def test_names_of_odd_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Spaces, umlauts, a leading dash: the command for one part takes them as a batch does."""
    monkeypatch.chdir(tmp_path)
    for name in ("two words.nc1", "Träger ß.nc1", "-o.nc1"):
        Path(name).write_text(part("A"))
        args = ["post", "-o", f"{name}.gcode", "--", name]
        assert CliRunner().invoke(main, args).exit_code == 0
        assert Path(f"{name}.gcode").read_text().endswith("M30\n%\n")
    Path("bad.nc1").write_text(BAD)
    assert "bad.nc1:28: error plan-tool" in call("post bad.nc1 -o -").stderr


@pytest.mark.parametrize(
    "line",
    sampled(
        ["post {i} -o x", "plan {i}", "inspect {i}", "convert {i} -o x.json",
         "verify w.gcode --against {i}", "verify {i}", "diff {i} w.nc1", "simulate {i} -o x"], 4
    ),
)  # fmt: skip
def test_a_file_of_zeros_is_not_read_into_memory(good: str, line: str) -> None:
    with open("zeros.nc1", "wb") as file:
        file.truncate(20 * 1024 * 1024)
    done = call(line.format(i="zeros.nc1"))
    assert done.exit_code == 1
    assert "zeros.nc1: error read-zeros: found 20 971 520 bytes that are all zero" in done.stderr
    assert len(done.output) < 1000
    assert not Path("x").exists()


@pytest.mark.parametrize("command", ["post {i} -o x", "convert {i} -o x.json", "verify {i}"])
def test_a_file_that_may_not_be_read(
    good: str, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: object, *_: object, **__: object) -> object:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)

    # Modes do not hold back the superuser, who may well run the tests.
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.R_OK)
    monkeypatch.setattr(os, "open", refuse)
    done = call(command.format(i="w.nc1"))
    assert done.exit_code == 1
    assert "w.nc1: error read-file: found no file that can be read (Permission denied)" in (
        done.stderr
    )


def test_a_bar_appears_when_reading_takes_long(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    now = [100.0]
    monkeypatch.setattr(common, "perf_counter", lambda: now[0])
    with common.followed("m.ifc", Console()) as follow:
        assert follow is not None
        follow(1, 4)
        assert terminal.getvalue() == ""  # a file that is read at once has none
        now[0] += 2 * common.PATIENCE
        follow(2, 4)
        follow(4, 4)
    assert "m.ifc" in terminal.getvalue()
    assert "100%" in terminal.getvalue()
    with common.followed("m.ifc", Console(quiet=True)) as follow:
        assert follow is None
    monkeypatch.setattr(sys, "stderr", StringIO())
    with common.followed("m.ifc", Console()) as follow:
        assert follow is None


@pytest.mark.parametrize("number", sampled(["nan", "inf", "-inf"], 3))
@pytest.mark.parametrize(
    "line",
    [
        "post w.nc1 -o x --bar", "plan w.nc1 --bar", "post w.nc1 -o x --thickness",
        "plan w.nc1 --kerf", "batch w.nc1 -o out --kerf", "watch . -o out --settle",
        "watch . -o out --every", "simulate w.gcode -o x --pace",
        "profile --velocity 5 -o - --time", "profile --time 5 -o - --velocity",
        "profile -o - --points 0:0,1:",
    ],
)  # fmt: skip
def test_a_number_is_finite(good: str, line: str, number: str) -> None:
    """nan is neither above nor below a limit, so that none would hold."""
    done = call(line + number if line.endswith(":") else f"{line} {number}")
    assert done.exit_code == 2
    assert not Path("x").exists()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("profile -o - --time x", "found 'x'; expected a number."),
        ("post w.nc1 -o x --bar 0", "found '0'; expected a number above 0."),
        ("post w.nc1 -o x --kerf -1", "found '-1'; expected a number 0 or more."),
        ("watch . -o out --every 0", "found '0'; expected a number 0.01 or more, at most 86400."),
    ],
)
def test_a_number_within_limits(good: str, words: str, expected: str) -> None:
    done = call(words)
    assert done.exit_code == 2
    assert expected in done.stderr


def test_a_profile_with_more_rows_than_memory_holds() -> None:
    done = call("profile --velocity 10 --time 1 --step 1e-9 -o -")
    assert done.exit_code == 2
    assert "found a step of 1e-09 s; expected 1e-06 s or more, for at most 1,000,000 rows" in (
        done.stderr
    )


def test_a_profile_of_no_known_form(tmp_path: Path) -> None:
    done = call(f"profile --velocity 10 --time 1 -o {tmp_path}/ramp.gif")
    assert done.exit_code == 2
    assert "ramp.gif'; expected a name in .csv, .svg, .png, .pdf, .html, or -" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("option", ["--tab-width", "--gap", "--corner", "--lip", "--amps"])
@pytest.mark.parametrize("value", ["0", "-1"])
def test_a_size_that_is_none_is_wrong_usage(option: str, value: str, tmp_path: Path) -> None:
    words = ["post", str(SAMPLES / "dxf" / "plate.dxf"), option, value, "-o", str(tmp_path / "x")]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 2, done.output
    assert f"found {value!r}; expected a number above 0" in done.output
    assert not [*tmp_path.iterdir()]
