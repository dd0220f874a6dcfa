"""Each command has a page, which ends with the command's own help.

The examples of the pages are run by test_readme.py; `pytest tests/test_docs.py --update-golden`
writes the help into them anew.
"""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from beamcam.cli import COMMANDS, main
from beamcam.machine.load import load, shipped
from tests.command_help import section
from tests.conftest import ROOT, Golden

DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
MARK = "<!-- of the command itself -->\n"
PACKAGE = ROOT / "beamcam"
_LINK = re.compile(r"\]\(([^)#:]+\.md)\)")
_FILE = re.compile(r"`([\w/]+\.py)`")


def every_command() -> Iterator[tuple[str, click.Command]]:
    """The words that call a command, and the command; those of groups too."""
    context = click.Context(main)
    for name in COMMANDS:
        command = main.get_command(context, name)
        assert command is not None
        yield name, command
        if isinstance(command, click.Group):
            yield from ((f"{name} {below}", one) for below, one in command.commands.items())


WORDS = dict(every_command())


def calls(line: str) -> Iterator[list[str]]:
    """The words of each call of beamcam in a line for a shell."""
    words = shlex.shlex(line, posix=True, punctuation_chars="|>")
    words.whitespace_split = True
    call: list[str] = []
    for word in [*words, "|"]:
        if word in ("|", ">"):
            if call[:1] == ["beamcam"]:
                yield call[1:]
            call = []
        else:
            call.append(word)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_page_ends_with_the_help(name: str, golden: Golden) -> None:
    page = DOCS / "commands" / f"{name}.md"
    text, mark, _ = page.read_text(encoding="utf-8").partition(MARK)
    assert mark
    assert f"`beamcam {name}`" in text.splitlines()[0]
    assert f"\nbeamcam {name}" in text
    helps = [section(words, WORDS[words]) for words in WORDS if words.split()[0] == name]
    golden.check(page, text + mark + "\n" + "\n".join(helps))


@pytest.mark.parametrize("words", WORDS)
def test_the_help_has_examples_that_can_be_called(words: str) -> None:
    done = CliRunner().invoke(main, [*words.split(), "--help"], terminal_width=200)
    lines = (line.strip() for line in done.stdout.splitlines())
    shown = [line for line in lines if line.startswith(("beamcam ", "find "))]
    assert any(f"beamcam {words}" in line for line in shown)
    for name, *args in (call for line in shown for call in calls(line)):
        if name == "machines":
            name, *args = f"machines {args[0]}", *args[1:]
        try:
            WORDS[name].make_context(name, args)
        except click.exceptions.Exit as end:  # of an option that prints, and no more
            if end.exit_code:
                raise
        except click.BadParameter as error:
            # An example's folder need not be there; a value has to be one.
            if "does not exist" not in error.message:
                raise


@pytest.mark.parametrize("words", WORDS)
def test_every_option_has_its_help(words: str) -> None:
    for option in WORDS[words].params:
        assert not isinstance(option, click.Option) or option.help, option.name


def test_the_index_leads_to_every_page() -> None:
    index = DOCS / "README.md"
    linked = {(DOCS / link).resolve() for link in _LINK.findall(index.read_text(encoding="utf-8"))}
    assert linked == set(PAGES) - {index}


@pytest.mark.parametrize("page", [ROOT / "README.md", *PAGES], ids=lambda p: p.stem)
def test_links_lead_somewhere(page: Path) -> None:
    for link in _LINK.findall(page.read_text(encoding="utf-8")):
        assert (page.parent / link).is_file(), link


def test_files_that_the_architecture_names_are_there() -> None:
    named = _FILE.findall((DOCS / "architecture.md").read_text("utf-8"))
    there = {f"/{path.relative_to(ROOT).as_posix()}" for path in ROOT.glob("[!.]*/**/*.py")}
    assert [name for name in named if not any(path.endswith(f"/{name}") for path in there)] == []


def test_files_of_the_large_rooms_are_in_their_rooms() -> None:
    text = (DOCS / "architecture.md").read_text("utf-8")
    table = text.partition("## Inside the large rooms")[2].partition("\n## ")[0]
    rows = [line.split("|")[1:3] for line in table.splitlines() if line.startswith("| `")]
    for names, files in rows:
        paths = re.findall(r"`([\w/]+)/`", names)
        rooms = [*paths, *(f"{paths[0].rpartition('/')[0]}/{name}" for name in paths[1:]), ""]
        for file in _FILE.findall(files):
            assert any((PACKAGE / room / file).is_file() for room in rooms), file
    assert len(rows) > 9


def test_the_version() -> None:
    from beamcam import __version__

    done = CliRunner().invoke(main, ["--version"], prog_name="beamcam")
    assert done.stdout == f"beamcam, version {__version__}\n"


def test_the_readme_says_what_machines_take() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([\w-]+)` \| ([A-Z, ]+) \|[^|]*\|([^|]*)\|", text, re.M)
    bars = [name for name in shipped() if load(name).stock != "sheet"]
    assert sorted(name for name, *_ in rows) == sorted(bars)
    for name, sections, more in rows:
        machine = load(name)
        holder = machine.coper or machine.layout
        assert holder is not None
        taken = holder.profiles
        assert sections.split(", ") == [*taken]
        assert bool(more.strip()) == (machine.coper is not None or bool(machine.words.mill))


@pytest.mark.parametrize("name", COMMANDS)
def test_the_readme_shows_every_command(name: str) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"\nbeamcam {name}" in text
