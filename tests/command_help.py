"""The help of a command as a section of its page, whatever version of click prints it."""

import inspect

import click


def section(words: str, command: click.Command) -> str:
    """Usage, text and options of the command that is called by `words`."""
    arguments = [p for p in command.params if isinstance(p, click.Argument)]
    options = [p for p in command.params if isinstance(p, click.Option)]
    usage = " ".join(
        ["beamcam", words, *(["[OPTIONS]"] if options else []),
         *(a.metavar or str(a.name).upper() for a in arguments),
         *(["COMMAND"] if isinstance(command, click.Group) else [])]
    )  # fmt: skip
    lines = [f"## `{usage}`", "", *_text(command.help or "")]
    if options:
        lines += ["| option | |", "| --- | --- |", *map(_row, options), ""]
    return "\n".join(lines)


def _text(help: str) -> list[str]:
    """The paragraphs; one that click leaves as it stands is a block of calls."""
    lines: list[str] = []
    for paragraph in inspect.cleandoc(help).split("\n\n"):
        marker, _, rest = paragraph.partition("\n")
        lines += ["```text", rest, "```", ""] if marker == "\b" else [paragraph, ""]
    return lines


def _row(option: click.Option) -> str:
    names = "`, `".join([*option.opts, *option.secondary_opts])
    value = "" if option.is_flag else f" {_value(option)}"
    text = option.help or ""
    notes = ["required"] if option.required else []
    notes += [f"default `{option.default}`"] if option.show_default else []
    shown = f"{text} ({', '.join(notes)})" if notes else text
    return f"| `{names}{value}` | {shown} |"


def _value(option: click.Option) -> str:
    if isinstance(option.type, click.Choice):
        return ", ".join(map(str, option.type.choices))
    kinds = {"integer": "NUMBER",
             "integer range": "NUMBER", "path": "FILE", "directory": "FOLDER"}  # fmt: skip
    return option.metavar or kinds.get(option.type.name, option.type.name.upper())
