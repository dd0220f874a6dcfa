"""Shared by the commands that write pictures."""

from collections.abc import Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING

import click

from beamcam.commands.common import STANDARD
from beamcam.commands.kinds import PICTURES, expected

if TYPE_CHECKING:
    from beamcam.pictures.pdf import Paper
    from beamcam.pictures.scene import Scene

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
    suffix = ".svg" if output == STANDARD else PurePath(output).suffix.lower()
    if suffix not in PICTURES:
        raise click.UsageError(expected(output, "plot"))
    return suffix


def picture(scenes: "Sequence[Scene]", suffix: str, paper: "Paper" = "a4") -> str | bytes:
    """Pictures in a format; only a PDF has room for more than the first.

    Raises PictureError where the library for the format is not installed.
    """
    if suffix == ".pdf":
        from beamcam.pictures.pdf import to_pdf

        return to_pdf(scenes, paper)
    if suffix == ".png":
        from beamcam.pictures.png import to_png

        return to_png(scenes[0])
    from beamcam.pictures.svg import to_svg

    return to_svg(scenes[0])
