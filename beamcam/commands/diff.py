"""`beamcam diff`: two programs, or two parts, compared by what they mean."""

import os
from pathlib import Path, PurePath
from typing import Any

import click
from msgspec.structs import replace

from beamcam import readers
from beamcam.commands import options
from beamcam.commands.common import REFUSED, STANDARD, Voice, say_json, say_lines
from beamcam.commands.programs import input_bytes
from beamcam.commands.settings import machine_for_program, settled
from beamcam.controllers import rules
from beamcam.diff.differ import diff_parts, diff_programs
from beamcam.diff.pairing import Difference
from beamcam.diff.statements import diff_sheets
from beamcam.errors import BeamcamError, Diagnostic, Severity, VerifyError, errors_in
from beamcam.machine import Machine
from beamcam.machine.defaults import is_of_programs
from beamcam.model.part import Part
from beamcam.pipeline import as_error, parts_of, read_back
from beamcam.posts import Request
from beamcam.readers.content import shown_name
from beamcam.verify.bars import run

#: What a program may not have if its meaning is to be known.
NOT_UNDERSTOOD = {r.code for r in (rules.SYNTAX, rules.WORD, rules.ARC)}


@click.command("diff")
@click.argument("a", type=options.FILE)
@click.argument("b", type=options.FILE)
@options.machine
@options.config
@options.strict
@options.as_json
@options.voiced
def command(a: str, b: str, as_json: bool, voice: Voice, **asked: Any) -> None:
    """Say what program or part B makes otherwise than A; of two folders, file by file.

    Files of two folders belong together that have the same name below them. What is true of
    several is one line.

    Block numbers, comments, spacing, and the order of holes in a part's file count for nothing.
    Exit status: 0 they mean the same, 1 they differ, or one cannot be read, or would be refused for
    what it does: a word that is missing, a retract, a feed, a tool that is not there.

    \b
    beamcam diff yesterday.gcode today.gcode --machine beamline-annex
    beamcam diff M58.nc1 M58-revised.nc1
    beamcam diff golden programs
    beamcam post M58.nc1 -o - | beamcam diff yesterday.gcode -
    """
    folders = [os.path.isdir(path) for path in (a, b)]
    if all(folders):
        from beamcam.commands.folders import diff_folders

        diff_folders(Path(a), Path(b), as_json, voice, asked)
        return
    if any(folders):
        raise click.UsageError("A and B have to be two files or two folders.")
    if a == b == STANDARD:
        raise click.UsageError("found - twice; expected it once, standard input is read once.")
    try:
        config = settled(asked, (a, b))
        machine = machine_for_program(config, a)
        data = [(shown_name(path), input_bytes(path)) for path in (a, b)]
        voice.did(f"read {data[0][0]} and {data[1][0]}, programs as those of {machine.name}")
        found, said = differences_of(data, machine, config.strict)
    except BeamcamError as error:
        voice.stop(error.diagnostics)
    voice.did(f"compared them: {len(found)} difference(s)")
    show(found, as_json)
    if said:
        voice.say(said)
    if found or errors_in(said):
        raise SystemExit(REFUSED)


def differences_of(
    data: list[tuple[str, bytes]], machine: Machine, strict: bool
) -> tuple[tuple[Difference, ...], tuple[Diagnostic, ...]]:
    """What the second of two files, each with its name, makes otherwise, and what is wrong.

    Raises ReadError and VerifyError; UsageError of a program and a part.
    """
    kinds = [is_part(name, content) for name, content in data]
    if kinds[0] != kinds[1]:
        raise click.UsageError("A and B have to be two programs or two parts.")
    if kinds[0]:
        (first, of_a), (second, of_b) = (_parts(*one, strict) for one in data)
        return diff_parts(first, second), (*of_a, *of_b)
    texts = [(name, content.decode("utf-8", "replace")) for name, content in data]
    return _diff_programs(texts, machine)


def show(found: tuple[Difference, ...], as_json: bool) -> None:
    """Print differences on standard output."""
    if as_json:
        say_json([d.as_data() for d in found])
    else:
        say_lines(difference.text for difference in found)


def is_part(name: str, data: bytes) -> bool:
    """Whether a file is of a format that a reader knows.

    `.nc` is that of programs too, and `.json` that of anything.
    """
    suffix = PurePath(name).suffix.lower()
    by_name = any(suffix in form.suffixes for form in readers.FORMATS)
    return (by_name and suffix != ".json" and not is_of_programs(name)) or any(
        f.looks_like(data) for f in readers.FORMATS
    )


def _parts(name: str, data: bytes, strict: bool) -> tuple[tuple[Part, ...], tuple[Diagnostic, ...]]:
    """The parts of a file and the remarks of its reader. Raises ReadError."""
    reading = readers.read(data, name)
    if strict:
        reading = replace(reading, diagnostics=tuple(map(as_error, reading.diagnostics)))
    return parts_of([reading])


def _diff_programs(
    texts: list[tuple[str, str]], machine: Machine
) -> tuple[tuple[Difference, ...], tuple[Diagnostic, ...]]:
    """What two programs, each with its name, make otherwise, and what is wrong with them.

    Raises VerifyError where their blocks are not understood.
    """
    if machine.stock == "sheet":
        (name, first), (_, second) = texts
        found, said = diff_sheets(first, second, machine, name)
        if said:
            raise VerifyError(said)
        alone = (read_back(text, Request((), machine, name=name)) for name, text in texts)
        return found, tuple(d for said in alone for d in said if d.severity is not Severity.NOTE)
    runs = [run(text, machine, None, name) for name, text in texts]
    said = tuple(d for done in runs for d in done.diagnostics)
    if any(d.code in NOT_UNDERSTOOD for d in said):
        raise VerifyError(said)
    old, new = (done.made for done in runs)
    return diff_programs(old, new, machine.format.resolution), said
