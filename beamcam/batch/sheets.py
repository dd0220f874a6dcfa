"""Setup sheets and small pictures for the programs of a run, beside its report.

Each input is read and posted again, which takes a millisecond; its sheet is made where the program
that stands in the folder is that very one.
"""

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from hashlib import sha256
from pathlib import PurePosixPath

from msgspec import Struct

from beamcam.arguments import on_best_machine
from beamcam.batch.shares import ShareTask
from beamcam.batch.work import BatchSettings, thaw
from beamcam.errors import BeamcamError
from beamcam.files import write_whole
from beamcam.model.request import marked
from beamcam.pictures import ReadProgram
from beamcam.pictures.formats import inline_svg
from beamcam.pictures.part import small_scene
from beamcam.pictures.scene import css
from beamcam.pipeline import Posted, begin, counted, finished
from beamcam.processes import Died, Pool
from beamcam.readers import is_interruptible, read, sound
from beamcam.reports.run import FileRow
from beamcam.reports.run_page import Extra
from beamcam.setup_sheet.content import SheetSources, content_of
from beamcam.setup_sheet.page import setup_page
from beamcam.writers import target_of_suffix

FOLDER_SUFFIX = ".sheets"


class Programs(Struct, frozen=True):
    """The programs of one input."""

    path: str
    outputs: tuple[tuple[str, str], ...]  #: output and hash of each
    share: ShareTask | None = None  #: of a run over stock


class SetupSheet(Struct, frozen=True):
    """Setup sheet and picture of one program."""

    output: str
    page: bytes
    picture: str


def made_sheets(frozen: bytes, programs: Programs) -> tuple[SetupSheet, ...]:
    """The sheets of an input's programs, by a worker; none where it cannot be read any more."""
    with suppress(OSError, BeamcamError):
        return tuple(_sheets(programs, thaw(frozen)))
    return ()


def picture_style() -> str:
    """The styles of the small pictures in a report."""
    dark = "@media screen and (prefers-color-scheme: dark)"
    return f"{css('svg ')}{dark}{{{css('svg ', dark=True)}}}"


def sheets_beside(
    report: str, rows: Iterable[FileRow], settings: BatchSettings, jobs: int,
    shares: Sequence[ShareTask] = (),
) -> dict[str, Extra]:  # fmt: skip
    """Write the sheet of each program of a run into a folder beside its report.

    `shares` are the programs of a run over stock.
    What rows of the report show of them comes back, by the name of the output. Raises OSError.
    """
    folder = os.path.splitext(report)[0] + FOLDER_SUFFIX
    extras: dict[str, Extra] = {}
    for sheet in _made(rows, settings, jobs, {task.name: task for task in shares}):
        name = PurePosixPath(f"{sheet.output}.html")
        path = os.path.join(folder, *name.parts)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        write_whole(path, sheet.page, durable=False)
        link = (PurePosixPath(os.path.basename(folder)) / name).as_posix()
        extras[sheet.output] = Extra(link, sheet.picture)
    return extras


def _made(
    rows: Iterable[FileRow], settings: BatchSettings, jobs: int, shares: Mapping[str, ShareTask]
) -> Iterator[SetupSheet]:
    frozen = settings.freeze
    maker = partial(made_sheets, frozen)
    tasks = (
        Programs(
            row["file"],
            tuple((p["output"], p["sha256"]) for p in row["parts"]),
            shares.get(row["file"]),
        )
        for row in rows
        if row["parts"]
    )
    pool = Pool[Programs, tuple[SetupSheet, ...]](maker, max(jobs, 1), partial(thaw, frozen))
    left, task = 0, next(tasks, None)
    try:
        while left or task is not None:
            if task is None or not pool.has_room():
                for _, made in pool.wait():
                    left -= 1
                    yield from () if isinstance(made, Died) else made
                continue
            if jobs <= 1 and (task.share is not None or is_interruptible(task.path)):
                yield from maker(task)
            else:
                pool.submit(task)
                left += 1
            task = next(tasks, None)
    finally:
        pool.close()


def _sheets(programs: Programs, settings: BatchSettings) -> Iterator[SetupSheet]:
    """Sheets of the parts whose programs are those that were written."""
    if programs.share is not None:
        posted = finished(programs.share.planned(settings))
        if (programs.share.name, _digest(posted)) in programs.outputs:
            yield _sheet(posted, programs.share.name, settings)
        return
    with open(programs.path, "rb") as file:
        reading = read(file.read(), programs.path, **settings.reading)
    left = list(programs.outputs)
    for part in marked(counted(sound(reading)), settings.mark_from):
        with suppress(BeamcamError):
            request = settings.request_of(part)
            if settings.chain:
                from beamcam.rest_part import chain_for, stages_of

                chain, _ = chain_for(request, settings.chain)
                target = target_of_suffix(settings.rest_suffix)
                made: Iterator[Posted] = (one.posted for one in stages_of(request, chain, target))
            else:
                planned, _ = on_best_machine(request, settings.machines_for(part), begin)
                made = map(finished, planned)
            for posted in made:
                digest = _digest(posted)
                output = next((name for name, known in left if known == digest), None)
                if output is not None:
                    left.remove((output, digest))
                    yield _sheet(posted, output, settings)


def _digest(posted: Posted) -> str:
    return sha256(posted.text.encode("utf-8")).hexdigest()


def _sheet(posted: Posted, output: str, settings: BatchSettings) -> SetupSheet:
    parts, machine = posted.job.parts, posted.job.machine
    bar = getattr(getattr(posted.plan, "bar", None), "length", None)
    program = ReadProgram(
        b"".join(posted.pieces()), machine, PurePosixPath(output).name, machine.suffix, parts, bar,
    )  # fmt: skip
    source = SheetSources(program, posted.plan, posted.remarks, compared=settings.request.verified)
    page = setup_page(content_of(source)).encode("utf-8", "backslashreplace")
    return SetupSheet(output, page, inline_svg(small_scene(parts[0])))
