"""Groups of options, colours, kinds of files, folders in the place of files."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result

from beamcam.cli import COMMANDS, main
from beamcam.commands import common
from beamcam.commands.common import NO_PROGRAMS
from beamcam.commands.options import FIRST, GROUPS, MOST_SHOWN, OTHER, Grouped, heading_of
from beamcam.commands.value_types import KINDS
from beamcam.machine.machine import DEFAULTS
from tests.conftest import ROOT, SAMPLES
from tests.runs import call, part
from tests.test_docs import WORDS


@pytest.mark.parametrize(
    "words", [w for w, command in WORDS.items() if isinstance(command, Grouped)]
)
def test_every_option_stands_in_a_group(words: str) -> None:
    options = [p for p in WORDS[words].params if isinstance(p, click.Option)]
    others = [o.name for o in options if heading_of(str(o.name)) == OTHER]
    assert not others, f"give them a heading in commands/parts.py: {others}"
    few = len(options) + 1 <= MOST_SHOWN
    said = call(words, "--help" if few else "--help-all").stdout
    assert "\nOptions:" not in said
    for option in options:
        assert option.opts[-1] in said


@pytest.mark.parametrize(
    "words", [w for w, command in WORDS.items() if isinstance(command, Grouped)]
)
def test_the_help_of_many_options_is_a_screen_of_the_first(words: str) -> None:
    options = [p for p in WORDS[words].params if isinstance(p, click.Option)]
    said = call(words, "--help").stdout
    if len(options) + 1 > MOST_SHOWN:
        shown = re.findall(r"^  (?:-\w, )?(--[\w-]+)", said.split("\nOptions:\n")[1], re.M)
        first = [o for name in FIRST for o in options if o.name == name]
        assert [*(o.opts[-1] for o in first), "--help", "--help-all"] == shown
        assert len(shown) <= 14
    else:
        assert "--help-all" not in said
        assert call(words, "--help-all").exit_code == 2


def test_commands_of_many_options_have_groups() -> None:
    for words, command in WORDS.items():
        if sum(isinstance(p, click.Option) for p in command.params) > 25:
            assert isinstance(command, Grouped), words
    names = [name for group in GROUPS.values() for name in group]
    assert len(names) == len(set(names))


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("simulate a.gcode -o t.gif", "found 't.gif'; expected a name in .csv, .json, .svg"),
        ("plan a.nc1 -o p.html", "found 'p.html'; expected a name in .txt, .json, or -"),
        ("plan a.nc1 -o p.csv", "expected a name in .txt, .json, or -"),
        ("post a.nc1 -o p.svg", "expected the name of a program (`beamcam plot` writes such)"),
        ("post a.nc1 -o p.json", "expected the name of a program (`beamcam convert` writes such)"),
        ("post a.nc1 -o p.ifc", "found 'p.ifc'; expected the name of a program"),
        ("plot a.nc1 -o p.txt", "found 'p.txt'; expected a name in .svg, .png, .pdf, or -"),
        ("plot a.nc1 -o p.svg --paper a3", "found --paper a3 with .svg; expected it with a .pdf"),
        ("report a.nc1 -o p.html --paper a3", "found --paper a3 with .html; expected it with"),
        ("profile --velocity 1 --time 1 -o p.txt", "expected a name in .csv, .svg"),
        ("batch a.nc1 -o out --report r.xml", "expected a name in .json, .csv, .html, or -"),
        ("convert a.nc1 -o a.step", "found '.step' for the output's format; expected one of"),
    ],
)
def test_a_kind_that_a_command_cannot_write_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: str, expected: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.nc1").write_text(part("A"))
    assert call("post", "a.nc1", "-o", "a.gcode").exit_code == 0
    before = sorted(path.name for path in tmp_path.iterdir())
    done = call(*line.split())
    assert done.exit_code in (1, 2)
    assert expected in " ".join(done.stderr.split())
    assert sorted(path.name for path in tmp_path.iterdir()) == before


def test_no_suffix_of_a_machine_is_refused() -> None:
    assert not {suffix for _, suffix in DEFAULTS} & set(NO_PROGRAMS)
    assert set(KINDS) <= set(WORDS)


def test_a_plan_called_json_is_json(tmp_path: Path) -> None:
    target = tmp_path / "plan.json"
    assert call("plan", SAMPLES / "dstv" / "channel.nc1", "-o", target).exit_code == 0
    assert json.loads(target.read_text())["machine"] == "beamline"


@pytest.mark.parametrize(
    "line", ["post {f} -o x", "plan {f}", "inspect {f}", "verify {f}", "convert {f} -o x.json",
             "simulate {f} -o x", "plot {f} -o x.svg"],
)  # fmt: skip
def test_a_folder_in_the_place_of_a_file_is_told_who_takes_it(tmp_path: Path, line: str) -> None:
    done = call(*line.format(f=tmp_path).split(), status=1)
    assert f"{tmp_path}: error read-folder: found a folder; expected a file" in done.output
    assert f"(`beamcam batch {tmp_path} -o OUT` posts the files of a folder" in done.output


class Terminal:
    """A stream that says whether it is a terminal."""

    def __init__(self, is_terminal: bool) -> None:
        self._is_terminal = is_terminal

    def isatty(self) -> bool:
        return self._is_terminal


@pytest.mark.parametrize(
    ("is_terminal", "environment", "coloured"),
    [
        (True, {}, True),
        (False, {}, False),
        (True, {"NO_COLOR": "1"}, False),
        (True, {"NO_COLOR": ""}, True),
        (True, {"TERM": "dumb"}, False),
        (False, {"FORCE_COLOR": "1"}, True),
        (True, {"FORCE_COLOR": "1", "NO_COLOR": "1"}, False),
    ],
)
def test_colours_are_for_terminals(
    monkeypatch: pytest.MonkeyPatch, is_terminal: bool, environment: dict[str, str], coloured: bool
) -> None:
    for name in ("NO_COLOR", "FORCE_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert common.shows_colour(Terminal(is_terminal)) is coloured


def test_the_severity_of_a_message_is_coloured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    wrong = SAMPLES / "bad" / "slot.nc1"
    done = CliRunner().invoke(
        main, ["post", str(wrong), "-o", "-", "--machine", "beamline"], color=True
    )
    assert f"{wrong}:27: \x1b[31m\x1b[1merror\x1b[0m plan-slot: found a slot" in done.stderr
    monkeypatch.setenv("NO_COLOR", "1")
    plain = CliRunner().invoke(
        main, ["post", str(wrong), "-o", "-", "--machine", "beamline"], color=True
    )
    assert plain.stderr == click.unstyle(done.stderr)
    as_json = CliRunner().invoke(
        main, ["post", str(wrong), "-o", "-", "--json", "--machine", "beamline"], color=True
    )
    assert json.loads(as_json.stderr)


def test_inspect_takes_the_thickness_that_post_takes(tmp_path: Path) -> None:
    drawing, plate = SAMPLES / "dxf" / "plate.dxf", SAMPLES / "dstv" / "gusset.nc1"
    record = json.loads(call("inspect", drawing, "--thickness", 3, "--json").stdout)
    assert record["parts"][0]["profile"]["web_thickness"] == 3.0
    done = call("inspect", plate, "--thickness", 3, status=1)
    assert "error plan-thickness-other: found --thickness 3; expected 6" in done.stderr
    outline = tmp_path / "o.svg"
    outline.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="50mm" height="50mm" '
                       'viewBox="0 0 50 50"><rect width="40" height="40" fill="none" '
                       'stroke="#f00"/></svg>')  # fmt: skip
    call("convert", outline, "-o", tmp_path / "o.nc1", "--thickness", 4, status=0)
    again = json.loads(call("inspect", tmp_path / "o.nc1", "--json").stdout)
    assert again["parts"][0]["profile"]["web_thickness"] == 4.0


#: Options of `post` that a folder has not, and why.
NOT_OF_FOLDERS = {
    "--from-operation": "a stop in mid bar is of one program",
    "--from-contour": "a stop within a sheet is of one program",
    "--frame": "a program to lay a sheet by, beside one job",
    "--rest": "what is left of one part; `split` takes many",
    "--force": "has a batch post unchanged inputs again; a model's members stand for themselves",
}


@pytest.mark.parametrize("command", ["batch", "watch"])
def test_a_folder_has_the_options_of_post_under_the_same_names(command: str) -> None:
    def options(words: str) -> dict[str, tuple[object, ...]]:
        found = (p for p in WORDS[words].params if isinstance(p, click.Option))
        return {o.opts[-1]: (str(o.type), o.is_flag, o.multiple, o.nargs) for o in found}

    one, many = options("post"), options(command)
    assert one.keys() - many.keys() == NOT_OF_FOLDERS.keys() - many.keys()
    assert NOT_OF_FOLDERS.keys() <= one.keys()
    same = one.keys() & many.keys() - NOT_OF_FOLDERS.keys() - {"-o", "--output"}
    assert {name: one[name] for name in same} == {name: many[name] for name in same}
    # What a run over stock has besides is of one run: a folder that is watched has no last file.
    assert ({"--remnant", "--nest"} <= many.keys()) == (command == "batch")


def test_a_batch_of_trigger_programs_has_a_style(tmp_path: Path) -> None:
    words = ("batch", SAMPLES / "json" / "shield-small.json", "--machine", "table-simotion")
    texts = {}
    for style in ("chain", "table"):
        done = call(*words, "-o", tmp_path / style, "--style", style, status=0)
        (path,) = (tmp_path / style).glob("*.st")
        texts[style] = path.read_text()
        assert ("triggerActive" in texts[style]) == (style == "chain")
        call("check", tmp_path / style, status=0)
    done = call("batch", SAMPLES / "dstv" / "tie.nc1", "-o", tmp_path, "--style", "table")
    assert (done.exit_code, "--style is not for plate-linuxcnc" in done.stderr) == (2, True)


# --- what post says of what it wrote --------------------------------------------------------------


DSTV = SAMPLES / "dstv"


def post(*words: object) -> Result:
    done = call("post", *words)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


@pytest.mark.parametrize(
    ("words", "output", "line"),
    [
        ((DSTV / "channel.nc1", "--bar", 12000), "channel.gcode",
         "14 holes, 2 cuts, 1 bar of 12000, 3:14 min; read back: the part, exactly"),
        ((DSTV / "tie.nc1", DSTV / "tie.nc1"), "ties.gcode",
         "8 holes, 3 cuts, 1 bar of 12000, 2:20 min; read back: the 2 parts, exactly"),
        ((DSTV / "gusset.nc1",), "g.ngc",
         "5 contours, 1 marked line, 1 sheet of 6 mm, 0:40 min; read back: the part, exactly"),
        ((SAMPLES / "json" / "shield-small.json",), "s.st",
         "1 contour, 1 sheet of 8 mm, 0:12 min; read back: the part, exactly"),
        ((SAMPLES / "json" / "shield-small.json", "--no-verify"), "s.steps",
         "1 contour, 1 sheet of 8 mm, 0:05 min; NOT read back"),
        ((SAMPLES / "bad" / "slot.nc1", "--machine", "beamline", "--allow-skips", "slot"),
         "s.gcode",
         "2 cuts, 1 bar of 4024.04, 0:42 min; read back: the part but for 1 feature left out"),
        ((DSTV / "marked.nc1", "--machine", "beamline"), "m.gcode",
         "3 holes, 2 cuts, 1 bar of 2424.04, 1:43 min; "
         "read back: the part but for 3 features left for manual work"),
        ((DSTV / "channel.nc1", "--from-operation", 4), "rest.gcode",
         "operations 4 to 12 of 12; read back: the rest of the whole program, exactly"),
        ((SAMPLES / "dxf" / "plate.dxf", "--thickness", 3, "--from-contour", 2), "rest.ngc",
         "contours 2 to 7 of 7; read back: the rest of the whole program, exactly"),
        ((SAMPLES / "coping" / "coped.nc1", "--machine", "coper-linuxcnc"), "coped.ngc",
         "14 cuts, 1260 mm of bar, 1:47 min; read back: the part but for 4 corners rounded"),
    ],
)  # fmt: skip
def test_a_line_says_what_was_written(
    tmp_path: Path, words: tuple[object, ...], output: str, line: str
) -> None:
    done = post(*words, "-o", tmp_path / output)
    assert done.exit_code == 0, done.stderr
    assert done.stderr.splitlines()[-1] == f"{output}: {line}"
    assert done.stdout == ""


def test_a_line_for_each_program(tmp_path: Path) -> None:
    done = post(DSTV / "channel.nc1", "--quantity", 2, "--bar", 6000, "-o", tmp_path / "c.gcode")
    assert [line.partition(":")[0] for line in done.stderr.splitlines()[-2:]] == [
        "c-1.gcode", "c-2.gcode",
    ]  # fmt: skip
    done = post(DSTV / "channel.nc1", "-o", "-")
    assert done.stderr.startswith("the program: 14 holes, ")


def test_no_line_where_nothing_is_wanted_or_nothing_was_written(tmp_path: Path) -> None:
    out = tmp_path / "c.gcode"
    assert post(DSTV / "channel.nc1", "-o", out, "--quiet").stderr == ""
    assert "read back" not in post(DSTV / "channel.nc1", "-o", out, "--json").stderr
    refused = post(SAMPLES / "bad" / "slot.nc1", "--machine", "beamline", "-o", out)
    assert refused.exit_code == 1
    assert "read back" not in refused.stderr


# --- completion -----------------------------------------------------------------------------------


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_lines_of_a_shell(shell: str) -> None:
    done = call("completion", shell, status=0)
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
