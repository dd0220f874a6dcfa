"""Checks of a request and its machine before any work, for library and command line alike."""

import os
from collections.abc import Collection, Iterable, Iterator
from math import isfinite
from typing import Any, TypeVar

import msgspec
from msgspec import Struct

from beamcam.controllers.machine_words import known_faults
from beamcam.conversion import nearest
from beamcam.errors import BeamcamError, Diagnostic, MachineError, Source, error
from beamcam.machine.load import load, shipped, source_in
from beamcam.machine.machine import Machine
from beamcam.machine.words import WORD
from beamcam.model.part import Part
from beamcam.plain_text import MAX_COMMENT, terminal_text
from beamcam.planning.left_out import ALL_SKIPS, SKIP_NAMES

ASK_TYPE = error("ask-type",
    "found {found} for {name}; expected {expected}",
    "A value of another type would be misread, or fail in the middle of the work.")  # fmt: skip
ASK_BAR = error("ask-bar",
    "found a bar of {found} mm; expected a finite length above 0, or none",
    "Without a length the bar is as long as the parts need.")  # fmt: skip
ASK_JOB = error("ask-job",
    "found the job name {found}; expected {expected}",
    "The name is written in the program's first line; a line end in it would turn the rest into "
    "blocks, and what a controller's line does not hold would be cut off.")  # fmt: skip
ASK_SKIP = error("ask-skip",
    "found {found!r} among the skips; expected {expected}",
    "A misspelt name would leave out nothing, or another kind than was meant.")  # fmt: skip
ASK_NUMBER = error("ask-number",
    "found {found} as {name} of the part; expected a finite number",
    "A part that was put together by a program may hold nan or inf, which no axis can move "
    "to.")  # fmt: skip

ASK_VALUE = error("ask-value",
    "found a wrong value of {name} ({fault}); expected one that the option of that name takes",
    "The options of the library are those of the command line and of beamcam.toml, by their "
    "names.")  # fmt: skip

_HERE = Source("beamcam")

AnyMachine = str | os.PathLike[str] | Machine  #: how a caller may say which machine is meant
Asked = TypeVar("Asked")


class AskError(BeamcamError):
    """A request is invalid, whatever the parts are."""


def check_arguments(job: object = "JOB", bar: object = None, skips: object = ()) -> None:
    """Raise AskError for a job's name, a bar or names of skips that cannot be meant."""
    if diagnostics := tuple(_faults(job, bar, skips)):
        raise AskError(diagnostics)


def expected_job(job: str) -> str:
    """The expected form of a job's name that cannot be meant; "" of one that can."""
    if terminal_text(job) != job:
        return "one line of printable characters"
    return "" if len(job) <= MAX_COMMENT else f"{MAX_COMMENT} characters at most"


def _faults(job: object, bar: object, skips: object) -> Iterator[Diagnostic]:
    if not isinstance(job, str):
        yield ask_type("job", job, "a text")
    elif expected := expected_job(job):
        from beamcam.conversion import shown

        yield ASK_JOB.at(_HERE, found=shown(job), expected=expected)
    if bar is not None:
        if isinstance(bar, bool | str | bytes) or not hasattr(bar, "__float__"):
            yield ask_type("bar", bar, "a number, or None")
        elif not (isfinite(bar) and bar > 0):  # type: ignore[operator]
            yield ASK_BAR.at(_HERE, found=f"{bar}")
    if isinstance(skips, str | bytes) or not isinstance(skips, Collection):
        yield ask_type("skips", skips, "a list of names")
        return
    for name in skips:
        if name not in SKIP_NAMES and name != ALL_SKIPS:
            yield ASK_SKIP.at(_HERE, found=name, expected=nearest(str(name), SKIP_NAMES))


def check_flags(**flags: object) -> None:
    """Raise AskError for what is neither True nor False."""
    for name, flag in flags.items():
        if not isinstance(flag, bool):
            raise AskError(ask_type(name, flag, "True or False"))


def check_choice(name: str, value: object, choices: Collection[str]) -> None:
    """Raise AskError for what is not one of the choices."""
    if value not in choices:
        raise AskError(ask_type(name, value, " or ".join(map(repr, choices))))


def check_text(name: str, value: object, *others: type) -> None:
    """Raise AskError for what is neither text nor one of `others`."""
    if not isinstance(value, (str, *others)):
        raise AskError(
            ask_type(name, value, " or ".join(("a text", *(t.__name__ for t in others))))
        )


def checked_parts(parts: Part | Iterable[Part]) -> tuple[Part, ...]:
    """The parts that are meant. Raises AskError for anything else, and for nan and inf."""
    if isinstance(parts, Part):
        parts = (parts,)
    if isinstance(parts, str | bytes) or not isinstance(parts, Iterable):
        raise AskError(ask_type("parts", parts, "a Part, or several"))
    all_parts = tuple(parts)
    for part in all_parts:
        if not isinstance(part, Part):
            raise AskError(ask_type("parts", part, "a Part, or several"))
        _check_numbers(part)
    return all_parts


def machine_of(machine: AnyMachine) -> Machine:
    """The machine of that name or path; one that is a machine already is itself.

    Raises AskError for anything else, and MachineError.
    """
    if isinstance(machine, Machine):
        return machine
    if not isinstance(machine, str | os.PathLike):
        raise AskError(ask_type("machine", machine, "a name, the path of a file, or a Machine"))
    return load_tested(str(os.fspath(machine)))


def load_tested(name: str) -> Machine:
    """The machine called `name`, or the one in the file at that path, whose programs can be read.

    Those that are shipped are proved by the tests. Raises MachineError.
    """
    machine = load_machine(name)
    if name in shipped():
        return machine
    from beamcam.self_test import known_proof_faults

    diagnostics = tuple(
        WORD.at(source_in(name, key, text), key=key, said=fault)
        for key, text, fault in known_proof_faults(machine)
    )
    if diagnostics:
        raise MachineError(diagnostics[:1])
    return machine


def load_machine(name: str) -> Machine:
    """The machine called `name`, or the one in the file at that path, whose words can be read.

    Raises MachineError.
    """
    machine = load(name)
    diagnostics = tuple(
        WORD.at(source_in(name, key, text), key=key, said=fault)
        for key, text, fault in known_faults(machine)
    )
    if diagnostics:
        raise MachineError(diagnostics)
    return machine


def converted(value: object, kind: type[Asked], name: str = "") -> Asked:
    """A value as one of a `kind`. Raises AskError that names the part of it which is not."""
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        fault, _, where = str(error).partition(" - at `$")
        place = where.rstrip("`").lstrip(".") or name
        raise AskError(ASK_VALUE.at(_HERE, name=place or "the options", fault=fault)) from error


def ask_type(name: str, value: object, expected: str) -> Diagnostic:
    """What is said of a value of another type than the call takes."""
    found = f"{type(value).__name__} {value!r:.60}" if value is not None else "None"
    return ASK_TYPE.at(_HERE, name=name, found=found, expected=expected)


def _check_numbers(part: Part) -> None:
    """Raise AskError for the first number of a part that is not finite."""
    waiting: list[tuple[str, Any]] = [("", part)]
    while waiting:
        name, value = waiting.pop()
        if isinstance(value, float):
            if not isfinite(value):
                raise AskError(ASK_NUMBER.at(part.source, found=value, name=name))
        elif isinstance(value, Struct):
            fields = ((field, getattr(value, field)) for field in value.__struct_fields__)
            waiting += ((f"{name}.{f}".lstrip("."), inner) for f, inner in fields)
        elif isinstance(value, tuple):
            waiting += ((name, inner) for inner in value)
