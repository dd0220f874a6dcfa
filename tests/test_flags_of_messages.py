"""Every option that a message names exists, in each command that may say it."""

import ast
import json
import re
from pathlib import Path

import click

from beamcam.cli import main
from beamcam.commands.codes import all_rules
from tests.conftest import ROOT

FLAG = re.compile(r"(?<![\w-])--[a-z][a-z-]*[a-z]")
PACKAGE = ROOT / "beamcam"
#: Commands that plan parts, and those that read them besides.
PLANNING = (
    "post", "plan", "list", "labels", "plot", "report", "simulate", "batch", "watch",
)  # fmt: skip
READING = (*PLANNING, "verify", "inspect", "convert")
READERS = ("dstv", "dxf", "svg", "ifc", "drawing", "json", "read")
#: Said where its option was given only: a chain is written where --style asks for one.
OF_ITS_OPTION = {"plan-chain"}
OF_CSS = {"--speed"}  #: custom properties begin with two hyphens too


def options_of(command: click.Command, name: str = "") -> dict[str, set[str]]:
    """The options of each command and subcommand, by its words."""
    context = click.Context(command)
    params = command.get_params(context)
    found = {name: {o for p in params for o in (*p.opts, *p.secondary_opts)}}
    if isinstance(command, click.Group):
        for word in command.list_commands(context):
            below = command.get_command(context, word)
            assert below is not None
            found |= options_of(below, f"{name} {word}".strip())
    return found


OPTIONS = options_of(main)
KNOWN = set().union(*OPTIONS.values())


def unknown(text: str) -> list[str]:
    return [flag for flag in FLAG.findall(text) if flag not in KNOWN]


def said_in(path: Path) -> list[tuple[int, str]]:
    """The texts of a module that may be said, all but its docstrings; none where all is known."""
    written = path.read_text(encoding="utf-8")
    if not unknown(written):
        return []
    tree = ast.parse(written)
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
    of_docs = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, documented) and node.body and isinstance(node.body[0], ast.Expr)
    }
    return [
        (node.lineno, node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        if id(node) not in of_docs
    ]


def test_no_text_names_an_option_that_does_not_exist() -> None:
    paths = [*PACKAGE.rglob("*.py")]
    found = {
        f"{path.name}:{line}": flags
        for path in paths
        for line, text in said_in(path)
        if (flags := [flag for flag in unknown(text) if flag not in OF_CSS])
    }
    assert len(paths) > 400
    assert found == {}


def test_explanations_and_pages_of_help_name_options_that_exist() -> None:
    told = json.loads((PACKAGE / "commands" / "explanations.json").read_text(encoding="utf-8"))
    found = {code: unknown(" ".join(map(str, one.values()))) for code, one in told.items()}
    assert {code: flags for code, flags in found.items() if flags} == {}
    for rule in all_rules():
        assert unknown(f"{rule.message} {rule.reason}") == [], rule.code


def test_each_command_takes_the_options_that_its_messages_name() -> None:
    missing = [
        (rule.code, flag, command)
        for rule in all_rules()
        if rule.code not in OF_ITS_OPTION
        for flag in FLAG.findall(rule.message)
        for command in _commands_that_say(rule.code)
        if flag not in OPTIONS[command]
    ]
    assert missing == []


def _commands_that_say(code: str) -> tuple[str, ...]:
    family = code.partition("-")[0]
    if family == "plan":
        return PLANNING
    if code == "write-format":
        return ("convert", "list", "labels")
    if code == "list-mark-twice":
        return ("list", "labels")
    return READING if family in READERS else ()


def test_the_check_sees_an_option_that_is_not_there(tmp_path: Path) -> None:
    path = tmp_path / "module.py"
    path.write_text('"""--in-a-docstring"""\nTEXT = "give --no-such-option, or --machine"\n')
    assert [flag for _, text in said_in(path) for flag in unknown(text)] == ["--no-such-option"]
    assert {"post", "machines", "batch"} <= OPTIONS.keys()
