"""`beamcam diff`: two programs, or two parts, compared by what they mean."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePath
from typing import Any

import click

from beamcam import readers
from beamcam.api.results import compared
from beamcam.batch.record import RECORD_NAME
from beamcam.commands import options
from beamcam.commands.common import REFUSED, STANDARD, Console, say_json, say_lines, write
from beamcam.commands.golden import Checked, Result, say_results
from beamcam.commands.parts import input_bytes
from beamcam.commands.recorded import Recorded
from beamcam.commands.settings import files_read, machine_for_program, settled
from beamcam.commands.value_types import KINDS, expected
from beamcam.comparison.pairing import Difference
from beamcam.comparison.parts import diff_parts
from beamcam.comparison.statements import ProgramText
from beamcam.config.values import COMMAND_LINE, Config
from beamcam.errors import BeamcamError, Diagnostic, ReadError, errors_in
from beamcam.machine import Machine
from beamcam.model.part import Part
from beamcam.pipeline import judged, parts_of
from beamcam.readers import is_of_programs, shown_name
from beamcam.reports.run import as_message


def differences_of(
    data: list[tuple[str, bytes]], machines: Sequence[Machine], strict: bool
) -> tuple[tuple[Difference, ...], tuple[Diagnostic, ...]]:
    """What the second of two files, each with its name, makes otherwise, and what is wrong.

    Programs are read by the machine of each.

    Raises ReadError and VerifyError; UsageError of a program and a part.
    """
    for name, content in data:
        refuse_other_format(name, content)
    kinds = [is_part(name, content) for name, content in data]
    if kinds[0] != kinds[1]:
        names = [name for name, _ in data]
        part, program = names if kinds[0] else reversed(names)
        raise click.UsageError(
            f"found the part {part!r} and the program {program!r}; A and B have to be two programs "
            "or two parts (`beamcam verify PROGRAM --against PART` compares the two)."
        )
    if kinds[0]:
        (first, of_a), (second, of_b) = (_parts(*one, strict) for one in data)
        return diff_parts(first, second), (*of_a, *of_b)
    comparison = compared(*(
        ProgramText(name, content.decode("utf-8", "replace"), machine)
        for (name, content), machine in zip(data, machines, strict=True)
    ))  # fmt: skip
    return comparison.differences, comparison.diagnostics


def drawn_over(
    data: list[tuple[str, bytes]],
    machines: Sequence[Machine],
    differences: tuple[Difference, ...],
    output: str,
) -> str | bytes:
    """Two files over each other in the format that the output's name says.

    Raises ReadError, VerifyError and PictureError; UsageError for another format.
    """
    from beamcam.pictures import ReadProgram
    from beamcam.pictures.comparison import compared_parts, compared_programs
    from beamcam.pictures.formats import picture

    suffix = PurePath(output).suffix.lower()
    if suffix not in KINDS["diff"]:
        raise click.UsageError(expected(output, "diff"))
    if is_part(*data[0]):
        both = [_parts(name, content, False)[0] for name, content in data]
        compared = [compared_parts(a, b) for a, b in zip(*both, strict=False)]
    else:
        programs = [
            ReadProgram(content, machine, PurePath(name).name, PurePath(name).suffix.lower())
            for (name, content), machine in zip(data, machines, strict=True)
        ]
        compared = [compared_programs(*programs)]
    if suffix == ".html":
        from beamcam.setup_sheet.study_page import diff_page

        return diff_page(
            (PurePath(data[0][0]).name, PurePath(data[1][0]).name), compared, differences
        )
    return picture([one.scene for one in compared], suffix)


def is_part(name: str, data: bytes) -> bool:
    """Whether a file is of a format that a reader knows.

    `.nc` is that of programs too, and `.json` that of anything.
    """
    suffix = PurePath(name).suffix.lower()
    by_name = any(suffix in form.suffixes for form in readers.FORMATS)
    return (by_name and suffix != ".json" and not is_of_programs(name)) or any(
        f.looks_like(data) for f in readers.FORMATS
    )


def refuse_other_format(path: str, data: bytes) -> None:
    """Raises ReadError for a PDF, a picture and the like in the place of a program."""
    other = None if is_of_programs(path) else readers.other_format(data, path)
    if other is not None:
        raise ReadError(other)


def refuse_part(path: str, data: bytes) -> None:
    """Raises UsageError for a part where a program is expected, ReadError for another format."""
    refuse_other_format(path, data)
    if path != STANDARD and is_part(path, data):
        raise click.UsageError(
            f"found the part {path!r}; expected a program (`beamcam post` makes one of it)."
        )


def _parts(name: str, data: bytes, strict: bool) -> tuple[tuple[Part, ...], tuple[Diagnostic, ...]]:
    """The parts of a file and the remarks of its reader. Raises ReadError."""
    return parts_of([judged(readers.read(data, name), strict)])


@click.command("diff")
@click.argument("a", type=options.FILE)
@click.argument("b", type=options.FILE, required=False, metavar="B")
@click.option(
    "-o",
    "--output",
    type=options.FILE,
    help="Overlay picture of both: .html with the list, .svg, .png or .pdf.",
)
@options.machine
@options.config
@options.strict
@options.as_json
@options.verbosity
def command(
    a: str, b: str | None, output: str | None, as_json: bool, console: Console, **values: Any
) -> None:
    """Say what program or part B makes differently from A; of two folders, file by file.

    Each program is read by the machine that its own header names, unless --machine names one.
    Files of two folders belong together that have the same name below them. A change that
    several share is one line.

    With -o both are drawn over each other: what moved, what is new, what is gone.

    Block numbers, comments, spacing, and the order of holes in a part's file count for nothing.
    Exit status: 0 they mean the same, 1 they differ, or one cannot be read, or would be
    refused: for a missing word, retract, feed or tool.

    \b
    beamcam diff yesterday.gcode today.gcode --machine beamline-annex
    beamcam diff M58.nc1 M58-revised.nc1
    beamcam diff M58.nc1 M58-revised.nc1 -o diff.html
    beamcam diff golden programs
    beamcam post M58.nc1 -o - | beamcam diff yesterday.gcode -
    """
    if b is None and os.path.isdir(a):
        raise click.UsageError(
            f"found the folder {a!r} alone; expected another one. `beamcam check {a}` posts its "
            f"programs again and says what differs, `beamcam diff {a} B` compares two folders."
        )
    if b is None:
        raise click.UsageError("Missing argument 'B'.")
    folders = [os.path.isdir(path) for path in (a, b)]
    if all(folders):
        if output is not None:
            raise click.UsageError("-o draws two files over each other, not two folders.")
        diff_folders(Path(a), Path(b), as_json, console, values)
        return
    if any(folders):
        raise click.UsageError("A and B have to be two files or two folders.")
    if a == b == STANDARD:
        raise click.UsageError("found - twice; expected it once, standard input is read once.")
    config = settled(values, (a, b))
    contents = [input_bytes(path) for path in (a, b)]
    data = [(shown_name(path), content) for path, content in zip((a, b), contents, strict=True)]
    machines = [machine_for_program(config, *one) for one in zip((a, b), contents, strict=True)]
    for (name, _), machine in zip(data, machines, strict=True):
        console.did(f"read {name}, a program as one of {machine.name}")
    differences, diagnostics = differences_of(data, machines, config.strict)
    if output is not None:
        drawn = drawn_over(data, machines, differences, output)
    console.did(f"compared them: {len(differences)} difference(s)")
    if output is not None:
        write(output, drawn, console, files_read(config, (a, b)))
    elif as_json:
        say_json([difference.as_data() for difference in differences])
    else:
        say_lines(difference.text for difference in differences)
    if diagnostics:
        console.say(diagnostics)
    if differences or errors_in(diagnostics):
        raise SystemExit(REFUSED)


# --- folders: two folders of programs or parts, compared file by file -----------------------------


def diff_folders(
    a: Path, b: Path, as_json: bool, console: Console, options: Mapping[str, Any]
) -> None:
    """Print what the files of `b` make otherwise than those of `a`, and end with the status."""
    config = settled(options, (str(a), str(b)))
    recorded = _recorded(a) | _recorded(b)
    first, second = _files(a, recorded), _files(b, recorded)
    results = []
    for name in sorted(first.keys() & second.keys()):
        results.append(_compared(name, first[name], second[name], recorded, config))
        console.did(f"{name}: {results[-1].result}")
    results += (Checked(str(a / n), "only in A") for n in sorted(first.keys() - second.keys()))
    results += (Checked(str(b / n), "only in B") for n in sorted(second.keys() - first.keys()))
    same = sum(one.result in ("same", "bytes") for one in results)
    counts = f"{same} of {len(results)} files mean the same"
    say_results(results, counts, console, as_json, silent="bytes")
    if same < len(results):
        raise SystemExit(REFUSED)


def _recorded(folder: Path) -> dict[str, Machine]:
    """The machine of each program that a record in the folder knows."""
    return Recorded(folder, None, {}, False).machines() if (folder / RECORD_NAME).is_file() else {}


def _files(folder: Path, recorded: Mapping[str, Machine]) -> dict[str, Path]:
    """The programs and parts below a folder by their names there."""
    files = {}
    for path in folder.rglob("*"):
        name = path.relative_to(folder).as_posix()
        if path.name.startswith(".") or not path.is_file():
            continue
        if name in recorded or is_of_programs(name) or is_part(name, path.read_bytes()):
            files[name] = path
    return files


def _compared(
    name: str, first: Path, second: Path, recorded: Mapping[str, Machine], config: Config
) -> Checked:
    shown = str(second)
    old, new = first.read_bytes(), second.read_bytes()
    if old == new:
        return Checked(shown, "same")
    try:
        # What is asked for counts first, then what the record says.
        known = recorded.get(name) if config.sources.get("machine") != COMMAND_LINE else None
        machines = [known or machine_for_program(config, name, data) for data in (old, new)]
        differences, diagnostics = differences_of(
            [(str(first), old), (shown, new)], machines, config.strict
        )
    except BeamcamError as error:
        return Checked(shown, "refused", (), tuple(map(as_message, error.diagnostics)))
    refused = errors_in(diagnostics)
    result: Result = "differs" if differences else "refused" if refused else "bytes"
    return Checked(shown, result, differences, tuple(map(as_message, diagnostics)))
