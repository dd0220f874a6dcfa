"""Two files compared, both programs or both parts."""

from collections.abc import Sequence
from pathlib import PurePath

import click

from beamcam import readers
from beamcam.api.results import compared
from beamcam.commands.kinds import KINDS, STANDARD, expected
from beamcam.diff.pairing import Difference
from beamcam.diff.parts import diff_parts
from beamcam.diff.programs import ProgramText
from beamcam.errors import Diagnostic, ReadError
from beamcam.machine import Machine
from beamcam.machine.names import is_of_programs
from beamcam.model.part import Part
from beamcam.pipeline import judged, parts_of


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
    found = compared(*(
        ProgramText(name, content.decode("utf-8", "replace"), machine)
        for (name, content), machine in zip(data, machines, strict=True)
    ))  # fmt: skip
    return found.differences, found.diagnostics


def drawn_over(
    data: list[tuple[str, bytes]],
    machines: Sequence[Machine],
    found: tuple[Difference, ...],
    output: str,
) -> str | bytes:
    """Two files over each other in the format that the output's name says.

    Raises ReadError, VerifyError and PictureError; UsageError for another format.
    """
    from beamcam.commands.pictures import picture
    from beamcam.pictures.comparison import compared_parts, compared_programs
    from beamcam.pictures.program import ReadProgram

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

        return diff_page((PurePath(data[0][0]).name, PurePath(data[1][0]).name), compared, found)
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
