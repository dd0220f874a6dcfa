"""`beamcam codes`: every code that a message can have, and why it matters."""

import importlib
import pkgutil
from collections.abc import Iterator
from importlib.resources import files

import click
import msgspec
from msgspec import Struct

import beamcam
from beamcam.checks import Language, Owner, Rows, Stock
from beamcam.commands import UNKNOWN_CODE, options
from beamcam.commands.common import Console, say_json
from beamcam.conversion import nearest
from beamcam.errors import Rule, Source


def all_rules() -> Iterator[Rule]:
    """Every rule that a module has a name for."""
    seen: set[Rule] = set()
    for module in pkgutil.walk_packages(beamcam.__path__, "beamcam."):
        if module.name == "beamcam.__main__":
            continue
        for rule in vars(importlib.import_module(module.name)).values():
            if isinstance(rule, Rule) and rule not in seen:
                seen.add(rule)
                yield rule


def all_owners() -> Rows:
    """What answers for the words of programs: a module that has such rows names them `OWNERS`."""
    owners: dict[tuple[Stock, Language], tuple[Owner, ...]] = {}
    for module in pkgutil.walk_packages(beamcam.__path__, "beamcam."):
        if module.name.endswith(".owners"):
            owners |= getattr(importlib.import_module(module.name), "OWNERS", {})
    return dict(sorted(owners.items()))


class CodeExplanation(Struct, frozen=True):
    """What `beamcam codes CODE` says of a code beside its rule."""

    example: str = ""  #: the message as a sample of beamcam has it
    do: str = ""  #: as docs/refused.md has it


def explanations() -> dict[str, CodeExplanation]:
    """The explanations by code, of those codes that a sample has or that refuse a file."""
    data = files("beamcam.commands").joinpath("explanations.json").read_bytes()
    return msgspec.json.decode(data, type=dict[str, CodeExplanation])


def as_markdown(rules: list[Rule]) -> str:
    """The page of the documentation that lists the codes, in alphabetical order."""
    lines = [
        "# Codes of messages",
        "",
        "Made by `beamcam codes --markdown`; a test keeps it true. An error refuses the part, a",
        "warning is posted with (and is an error under `--strict`), a note is harmless.",
        "",
        "| code | severity | message | why |",
        "| --- | --- | --- | --- |",
    ]
    for rule in rules:
        message, reason = (text.replace("|", "\\|") for text in (rule.message, rule.reason))
        lines.append(f"| `{rule.code}` | {rule.severity.value} | {message} | {reason} |")
    return "\n".join(lines) + "\n"


_STOCKS = {"beam": "bars", "sheet": "tables", "profile": "copers"}


def words_as_markdown(rows: Rows) -> str:
    """The page of the documentation that lists what answers for each word of a program."""
    lines = [
        "# Words of programs, and what answers for them",
        "",
        "Made by `beamcam codes --words --markdown`; tests keep it true and complete. Every G and",
        "M word and every event that the read-back knows is here, with what it carries: letters,",
        "placeholders of the machine file in braces. The codes are those of the messages that",
        "refuse it where it does not belong; where none of them comes it does no harm, for the",
        "reason that stands there. Any other word is refused.",
    ]
    for (stock, language), owners in rows.items():
        lines += ["", f"## Programs for {_STOCKS[stock]}: {language}", ""]
        lines += ["| word | what it carries | refused by | harmless |", "| --- | --- | --- | --- |"]
        for row in owners:
            names, carried, refused = (
                ", ".join(f"`{name}`" for name in names)
                for names in (row.words, row.carries, row.refused_by)
            )
            lines.append(f"| {names} | {carried} | {refused} | {row.harmless} |")
    return "\n".join(lines) + "\n"


def _say_words(rows: Rows, markdown: bool, as_json: bool) -> None:
    if markdown:
        click.echo(words_as_markdown(rows), nl=False)
    elif as_json:
        say_json(
            [
                {"stock": stock, "controller": language, **msgspec.structs.asdict(row)}
                for (stock, language), owners in rows.items()
                for row in owners
            ]
        )
    else:
        for (stock, language), owners in rows.items():
            click.echo(f"{stock}, {language}")
            for row in owners:
                refused = f"refused by {', '.join(row.refused_by)}" if row.refused_by else ""
                harmless = f"harmless: {row.harmless}" if row.harmless else ""
                answer = "; ".join(text for text in (refused, harmless) if text)
                click.echo(f"    {' '.join((*row.words, *row.carries))}  {answer}")


@click.command("codes")
@click.argument("code", required=False)
@click.option("--words", is_flag=True, help="List the words of programs, and what refuses them.")
@click.option("--markdown", is_flag=True, help="Print a page for the documentation.")
@options.as_json
def command(code: str | None, words: bool, markdown: bool, as_json: bool) -> None:
    """Explain the CODE of a message, or list all codes, with severity, message and reason.

    Of one code an example is shown too, and what to do.

    `post` itself says which options make a refused part (plan-ways-out).

    \b
    beamcam codes plan-cope
    beamcam codes
    beamcam codes --words
    beamcam codes --markdown > docs/codes.md
    """
    if words:
        _say_words(all_owners(), markdown, as_json)
        return
    rules = sorted(all_rules(), key=lambda rule: rule.code)
    if code is not None:
        if code not in (known := [rule.code for rule in rules]):
            diagnostic = UNKNOWN_CODE.at(
                Source("beamcam"), found=code, expected=nearest(code, known)
            )
            Console(as_json=as_json).stop([diagnostic])
        rules = [rule for rule in rules if rule.code == code]
    if markdown:
        click.echo(as_markdown(rules), nl=False)
    elif as_json:
        rows = [
            {"code": r.code, "severity": r.severity.value, "message": r.message, "why": r.reason}
            for r in rules
        ]
        say_json(rows)
    else:
        explained = explanations() if code is not None else {}
        for rule in rules:
            click.echo(f"{rule.code}  {rule.severity.value}\n    {rule.message}\n    {rule.reason}")
            more = explained.get(rule.code, CodeExplanation())
            if more.example:
                click.echo(f"example\n    {more.example}")
            if more.do:
                click.echo(f"what to do\n    {more.do}")
