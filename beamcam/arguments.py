"""What is asked for, checked before any work, for library and command line alike."""

import os
from collections.abc import Collection, Iterator
from math import isfinite

from beamcam.conversion import nearest, shown
from beamcam.errors import (
    BeamcamError,
    Diagnostic,
    MachineError,
    Source,
    error,
)
from beamcam.machine.load import files_of_machine, is_proved, load, source_in
from beamcam.machine.machine import Machine
from beamcam.machine.words import WORD
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


HERE = Source("beamcam")

AnyMachine = str | os.PathLike[str] | Machine  #: how a caller may say which machine is meant


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
        yield ASK_JOB.at(HERE, found=shown(job), expected=expected)
    if bar is not None:
        if isinstance(bar, bool | str | bytes) or not hasattr(bar, "__float__"):
            yield ask_type("bar", bar, "a number, or None")
        elif not (isfinite(bar) and bar > 0):  # type: ignore[operator]
            yield ASK_BAR.at(HERE, found=f"{bar}")
    if isinstance(skips, str | bytes) or not isinstance(skips, Collection):
        yield ask_type("skips", skips, "a list of names")
        return
    for name in skips:
        if name not in SKIP_NAMES and name != ALL_SKIPS:
            yield ASK_SKIP.at(HERE, found=name, expected=nearest(str(name), SKIP_NAMES))


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

    Raises MachineError.
    """
    if is_proved(files_of_machine(name)):
        return load(name)
    machine = load_machine(name)
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
    from beamcam.controllers.machine_words import known_faults

    machine = load(name)
    diagnostics = tuple(
        WORD.at(source_in(name, key, text), key=key, said=fault)
        for key, text, fault in known_faults(machine)
    )
    if diagnostics:
        raise MachineError(diagnostics)
    return machine


def ask_type(name: str, value: object, expected: str) -> Diagnostic:
    """What is said of a value of another type than the call takes."""
    found = f"{type(value).__name__} {value!r:.60}" if value is not None else "None"
    return ASK_TYPE.at(HERE, name=name, found=found, expected=expected)


# --- choice ---------------------------------------------------------------------------------------

# Of several machines the one that makes all of the parts, or leaves out fewest features.
