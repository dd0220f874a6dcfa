"""beamcam from Python: read a part, plan the work, post the program, verify any program.

    import beamcam

    reading = beamcam.read("samples/dstv/channel.nc1")
    posted = beamcam.post(reading.parts, "beamline")
    assert not beamcam.verify(posted.text, reading.parts, "beamline")
    print(posted.text)

These four functions and what they give back are stable. A machine is the name of a shipped one,
the path of a TOML file, or a `Machine`. What cannot be done raises a `BeamcamError` that carries
its diagnostics, an `AskError` where the call itself is wrong; what is only to be said comes back
as diagnostics beside the result. All four may be called from several threads at once.
"""

import os
from collections.abc import Collection, Iterable

from msgspec.structs import replace

from beamcam.asked import check_asked, check_flags, check_text, machine_asked, parts_asked
from beamcam.controllers.machine_words import load_machine
from beamcam.errors import Diagnostic, ReadError
from beamcam.machine import Machine
from beamcam.machine.defaults import DEFAULT_MACHINE
from beamcam.model.part import Part
from beamcam.model.plan import Plan, SheetPlan
from beamcam.pipeline import Posted, as_error, read_file
from beamcam.pipeline import post as post_bar
from beamcam.pipeline import read_back as read_program_back
from beamcam.planning.rules import named_skips
from beamcam.posts import Job, Request, post_of
from beamcam.readers import read as read_bytes
from beamcam.readers.reading import Reading

__all__ = ["plan", "post", "read", "verify"]

AnyMachine = str | os.PathLike[str] | Machine


def read(
    source: str | os.PathLike[str] | bytes, *, name: str = "part", strict: bool = False
) -> Reading:
    """What is in a file of any format, or in its bytes: `parts` and `diagnostics`.

    `name` is what bytes are called in messages; its suffix, if any, says which format is tried
    first. `strict` makes warnings errors. Raises ReadError if there is an error; its diagnostics
    are all of them.
    """
    check_flags(strict=strict)
    check_text("name", name)
    check_text("source", source, bytes, os.PathLike)
    if isinstance(source, bytes):
        reading = read_bytes(source, name)
        if strict:
            reading = replace(reading, diagnostics=tuple(map(as_error, reading.diagnostics)))
    else:
        reading = read_file(os.fspath(source), strict)
    if reading.refused:
        raise ReadError(reading.diagnostics)
    return reading


def plan(
    parts: Part | Iterable[Part],
    machine: AnyMachine = DEFAULT_MACHINE,
    *,
    bar: float | None = None,
    skips: Collection[str] = (),
) -> Plan | SheetPlan:
    """The work that makes `parts` from one bar, in the order given, or from one sheet.

    `bar` is its length in mm; without it the bar is as long as the parts need. `skips` names what
    may be left out, as `--allow-skips` does. Raises PlanError and MachineError.
    """
    check_asked(bar=bar, skips=skips)
    loaded = _machine(machine)
    return post_of(loaded).plan(Job(parts_asked(parts), loaded, bar=bar, skips=named_skips(skips)))


def post(
    parts: Part | Iterable[Part],
    machine: AnyMachine = DEFAULT_MACHINE,
    *,
    job: str = "JOB",
    bar: float | None = None,
    skips: Collection[str] = (),
    read_back: bool = True,
) -> Posted:
    """The program that makes `parts` from one bar: its `text`, the `plan`, and `remarks`.

    It was read back and compared with the parts, unless `read_back` is False, which the program
    then says. Raises PlanError, MachineError, and VerifyError for a program that would make
    anything else.
    """
    check_flags(read_back=read_back)
    return post_bar(parts_asked(parts), _machine(machine), job, bar, skips, read_back)


def verify(
    program: str | bytes,
    parts: Part | Iterable[Part],
    machine: AnyMachine = DEFAULT_MACHINE,
    *,
    skips: Collection[str] = (),
    name: str = "program",
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with the text of a program, by itself and against `parts`.

    Nothing comes back for a program that makes exactly the parts, in their order on the bar.
    `skips` names the kinds of features that may be missing, as `--allow-skips` does. Raises
    MachineError.
    """
    check_asked(skips=skips)
    check_text("program", program, bytes)
    check_text("name", name)
    request = Request(parts_asked(parts), _machine(machine), named_skips(skips), name)
    return read_program_back(program, request)


def _machine(machine: AnyMachine) -> Machine:
    asked = machine_asked(machine)
    return asked if isinstance(asked, Machine) else load_machine(asked)
