"""Output styles and files of machines run by tables, for `post`."""

from collections.abc import Iterable, Iterator
from pathlib import PurePath

import click

from beamcam.commands.common import STANDARD, Console, write
from beamcam.config.values import Config
from beamcam.files import FilesRead, remove_made
from beamcam.machine.machine import Machine
from beamcam.machine.tables import DIALECTS
from beamcam.pipeline import Posted


def table_style(machine: Machine, output: str, style: str | None) -> str | None:
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


def job_name(config: Config, machine: Machine, output: str) -> str:
    """The name of a job: of a trigger program that was given none that of its file.

    Its units are files and variables of one project, and would be taken for those of another job.
    """
    if machine.controller in DIALECTS and "job" not in config.sources and output != STANDARD:
        return PurePath(output).stem
    return config.job


def outputs(
    posted: Posted, machine: Machine, output: str
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


def write_list(posted: Posted, output: str, console: Console, read: FilesRead) -> None:
    """Write the list of manual work beside a program, or take away an older one.

    Of a program on standard output the messages alone say what is left for manual work.
    """
    if output == STANDARD:
        return
    from beamcam.reports.hand_list import LIST_BEGIN, LIST_SUFFIX, as_csv, hand_rows

    path = output + LIST_SUFFIX
    if rows := hand_rows(posted.plan):
        write(path, as_csv(rows), console, read)
    else:
        remove_made(path, LIST_BEGIN)
