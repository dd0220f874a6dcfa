"""What commands write: the names that each kind of output has, pictures, programs of tables."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING

import click

from beamcam.commands.common import STANDARD, Console, write
from beamcam.files import FilesRead, remove_made
from beamcam.machine.tables import DIALECTS, TABLE_CONTROLLERS

if TYPE_CHECKING:
    from beamcam.config.values import Config
    from beamcam.machine.machine import Machine
    from beamcam.pictures.formats import Paper
    from beamcam.pictures.scene import Scene
    from beamcam.pipeline import Posted

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
        from beamcam.pictures.formats import to_pdf

        return to_pdf(scenes, paper)
    if suffix == ".png":
        from beamcam.pictures.formats import to_png

        return to_png(scenes[0])
    from beamcam.pictures.formats import to_svg

    return to_svg(scenes[0])


def table_style(machine: "Machine", output: str, style: str | None) -> str | None:
    """The form of the program: the style of a trigger program, the form of a step table.

    Raises click.UsageError where the machine has no styles, or no form of that suffix.
    """
    if style is not None and machine.controller not in DIALECTS:
        raise click.UsageError(f"--style is not for {machine.name}.")
    if machine.controller != "stepper":
        return style
    if output == STANDARD:
        return machine.suffix
    from beamcam.emitters.step_table import FORMS

    suffix = PurePath(output).suffix.lower()
    if suffix not in FORMS:
        raise click.UsageError(f"found {output!r}; expected a name in {', '.join(FORMS)}, or -")
    return suffix


def is_coded_sheet(machine: "Machine") -> bool:
    """Whether a machine cuts sheets by a program of contours."""
    return machine.stock == "sheet" and machine.controller not in TABLE_CONTROLLERS


def job_name(config: "Config", machine: "Machine", output: str) -> str:
    """The name of a job: of a trigger program that was given none that of its file.

    Its units are files and variables of one project, and would be taken for those of another job.
    """
    if machine.controller in DIALECTS and "job" not in config.sources and output != STANDARD:
        return PurePath(output).stem
    return config.job


def outputs(
    posted: "Posted", machine: "Machine", output: str
) -> Iterator[tuple[str, str | Iterable[bytes]]]:
    """Each file with what is to be written to it.

    A trigger program of several units becomes a file a unit, the set-points beside the main one
    and before it, so that it never stands there without them.
    """
    if machine.controller in DIALECTS and output != STANDARD:
        from beamcam.emitters.simotion import split_units

        (_, main), *more = split_units(posted.text)
        folder = PurePath(output).parent
        for name, text in more:
            yield str(folder / f"{name}{machine.suffix}"), text
        yield output, main
        return
    yield output, posted.pieces()


def write_list(posted: "Posted", output: str, console: Console, read: FilesRead) -> None:
    """Write the list of manual work beside a program, or take away an older one.

    Of a program on standard output the messages alone say what is left for manual work.
    """
    if output == STANDARD:
        return
    from beamcam.planning.left_out import LIST_BEGIN, LIST_SUFFIX, as_csv, manual_rows

    path = output + LIST_SUFFIX
    if rows := manual_rows(posted.plan):
        write(path, as_csv(rows), console, read)
    else:
        remove_made(path, LIST_BEGIN)
