"""What commands write besides programs: the names that each kind of output has, and pictures."""

from collections.abc import Callable, Mapping

import click

from beamcam.commands.common import PICTURES, STANDARD, suffix_of

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

Callback = Callable[[click.Context, click.Parameter, str | None], str | None]


def expected(found: str, kind: str) -> str:
    """The message for an output of another kind."""
    return f"found {found!r}; expected a name in {', '.join(KINDS[kind])}, or -"


def of_kind(kind: str) -> Callback:
    """Refuses an output whose suffix says what the command cannot write."""

    def check(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
        if value not in (None, STANDARD) and suffix_of(value) not in ("", *KINDS[kind]):
            raise click.BadParameter(expected(value, kind))
        return value

    return check


unit = click.option(
    "--unit", type=click.Choice(["mm", "inch"]), default="mm", show_default=True,
    help="Of the lengths that are shown.",
)  # fmt: skip


paper = click.option(
    "--paper", type=click.Choice(["a4", "a3"]), default="a4", show_default=True,
    help="Of a PDF; what is wide lies on its side.",
)  # fmt: skip


def check_paper(paper: str, suffix: str) -> None:
    """Raises UsageError for a paper where no PDF is written."""
    if paper != "a4" and suffix != ".pdf":
        raise click.UsageError(f"found --paper {paper} with {suffix}; expected it with a .pdf.")


def picture_suffix(output: str) -> str:
    """The format of a picture by its name; standard output is an SVG."""
    suffix = ".svg" if output == STANDARD else suffix_of(output)
    if suffix not in PICTURES:
        raise click.UsageError(expected(output, "plot"))
    return suffix
