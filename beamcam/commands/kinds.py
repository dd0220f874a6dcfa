"""Kinds of files that the commands write, by the suffix of the output."""

from collections.abc import Callable, Mapping
from pathlib import PurePath

import click

PICTURES = (".svg", ".png", ".pdf")
#: What a command writes besides programs and parts; a name without a suffix is taken too.
KINDS: Mapping[str, tuple[str, ...]] = {
    "batch": (".json", ".csv", ".html"),  # its report
    "diff": (".html", *PICTURES),
    "plan": (".txt", ".json"),
    "plot": PICTURES,
    "profile": (".csv", *PICTURES, ".html"),
    "report": (".html", ".pdf"),
    "simulate": (".csv", ".json", *PICTURES, ".html"),
}
#: Suffixes that are never programs, whatever suffix a machine uses.
NO_PROGRAMS = (*PICTURES, ".html", ".json", ".dxf", ".nc1", ".ifc", ".ifczip", ".toml")
STANDARD = "-"

Callback = Callable[[click.Context, click.Parameter, str | None], str | None]


def expected(found: str, kind: str) -> str:
    """The message for an output of another kind."""
    return f"found {found!r}; expected a name in {', '.join(KINDS[kind])}, or -"


def of_kind(kind: str) -> Callback:
    """Refuses an output whose suffix says what the command cannot write."""

    def check(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
        if value not in (None, STANDARD) and _suffix(value) not in ("", *KINDS[kind]):
            raise click.BadParameter(expected(value, kind))
        return value

    return check


def program(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
    """Refuses an output that is called as a picture, a report or a part is."""
    if value is not None and _suffix(value) in NO_PROGRAMS:
        who = {".json": "convert", ".dxf": "convert", ".nc1": "convert", ".html": "report"}
        command = "plot" if _suffix(value) in PICTURES else who.get(_suffix(value), "")
        hint = f" (`beamcam {command}` writes such)" if command else ""
        raise click.BadParameter(f"found {value!r}; expected the name of a program{hint}")
    return value


def _suffix(name: str) -> str:
    return PurePath(name).suffix.lower()
