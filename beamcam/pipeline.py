"""The architecture on one screen: how an input becomes a program.

    bytes -> readers -> Part -> planning -> Plan -> motion -> Program -> emitters -> text
                                                                     verify <- text

Which motion step and which emitter belong together stands in `POSTS`.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath

from beamcam import readers
from beamcam.emitters import gcode
from beamcam.errors import (
    Diagnostic,
    PlanError,
    ReadError,
    Severity,
    Source,
    VerifyError,
    errors_in,
)
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.plan import FeatureRef, Plan, SheetPlan
from beamcam.model.program import Comment, Program
from beamcam.motion.beam import beam_program
from beamcam.planning import Order, plan_bar
from beamcam.readers import rules
from beamcam.readers.reading import Reading
from beamcam.verify import verify

DEFAULT_MACHINE = "beamline"
#: The machine of a sheet by the suffix of the output, where none is named.
SHEET_MACHINES = {".ngc": "plate-linuxcnc", ".gcode": "plate-codesys", ".nc": "laser-grbl"}
DEFAULT_SHEET_MACHINE = "plate-linuxcnc"
STANDARD_INPUT = "-"
NOT_READ_BACK = Comment("NOT VERIFIED: THIS PROGRAM WAS NOT READ BACK")


@dataclass(frozen=True, slots=True)
class Post:
    """How a kind of machine gets its program."""

    motion: Callable[[Plan, Machine, str], Program]
    emit: Callable[[Program, Machine], str]


#: By controller family and kind of stock.
POSTS = {
    ("codesys", "beam"): Post(beam_program, gcode.emit),
}


@dataclass(frozen=True, slots=True)
class SheetPost:
    """How a cutting table gets its program, and how that is read back."""

    motion: Callable[[SheetPlan, Machine, str], Program]
    emit: Callable[[Program, Machine], str]
    verify: Callable[
        [str, Sequence[Part], Machine, Collection[FeatureRef], str], tuple[Diagnostic, ...]
    ]


def sheet_post(machine: Machine) -> SheetPost:
    """The row of a cutting table; its modules load what a bar never needs."""
    from beamcam.emitters import cutting
    from beamcam.motion.sheet import sheet_program
    from beamcam.verify.sheets import verify_sheet

    posts = {
        name: SheetPost(sheet_program, cutting.emit, verify_sheet)
        for name in ("codesys", "linuxcnc", "grbl")
    }
    return posts[machine.controller]


@dataclass(frozen=True, slots=True)
class Posted:
    """A program and how it came about."""

    text: str
    plan: Plan | SheetPlan
    remarks: tuple[Diagnostic, ...]


def default_machine(parts: Sequence[Part], output: str) -> str:
    """The machine where none is named: of a sheet by the suffix of the output, else of a bar."""
    if not parts or any(part.profile.code != "B" for part in parts):
        return DEFAULT_MACHINE
    return SHEET_MACHINES.get(PurePath(output).suffix.lower(), DEFAULT_SHEET_MACHINE)


def read_file(path: str, strict: bool = False, **options: object) -> Reading:
    """What is in a file, `-` for standard input; a file that cannot be opened is refused.

    `strict` makes its warnings errors. `options` go to a reader that takes them: units, width and
    layers of a drawing.
    """
    name = "stdin" if path == STANDARD_INPUT else path
    try:
        if path == STANDARD_INPUT:
            import sys

            data = sys.stdin.buffer.read()
        else:
            with open(path, "rb") as file:
                data = file.read()
    except OSError as error:
        said = rules.UNREADABLE.at(Source(name), found=error.strerror or error)
        return Reading("unknown", (), (said,))
    reading = readers.read(data, name, **options)
    if strict:
        reading = replace(reading, diagnostics=tuple(map(as_error, reading.diagnostics)))
    return reading


def as_error(said: Diagnostic) -> Diagnostic:
    """A warning as an error; anything else as it is."""
    return replace(said, severity=Severity.ERROR) if said.severity is Severity.WARNING else said


def parts_of(readings: Iterable[Reading]) -> tuple[tuple[Part, ...], tuple[Diagnostic, ...]]:
    """All parts in order, and the remarks of their readers. Raises ReadError for any error."""
    parts: list[Part] = []
    said: list[Diagnostic] = []
    for reading in readings:
        parts += reading.parts
        said += reading.diagnostics
    if errors_in(said):
        raise ReadError(said)
    return tuple(parts), tuple(said)


def post(
    parts: Sequence[Part],
    machine: Machine,
    job: str = "JOB",
    bar: float | None = None,
    skips: Collection[str] = (),
    read_back: bool = True,
    order: Order = "given",
    turn: bool = False,
    strict: bool = False,
) -> Posted:
    """The program that makes `parts` from one bar or sheet, read back and compared with them.

    Without `read_back` a comment in the program says so. Raises PlanError if the machine cannot
    make the parts, or under `strict` if there is a warning; VerifyError if the program would make
    anything else than the parts.
    """
    if machine.stock == "sheet":
        return _post_sheet(parts, machine, job, skips, read_back, strict)
    plan = plan_bar(parts, machine, bar, skips, order, turn)
    if strict and any(said.severity is Severity.WARNING for said in plan.remarks):
        raise PlanError(map(as_error, plan.remarks))
    kind = POSTS[machine.controller, machine.stock]
    program = kind.motion(plan, machine, job)
    if not read_back:
        start, *work = program.commands
        program = replace(program, commands=(start, NOT_READ_BACK, *work))
    text = kind.emit(program, machine)
    said: tuple[Diagnostic, ...] = ()
    if read_back:
        skipped = {o.feature for o in plan.outcomes if o.how == "skipped"}
        lying = [piece.part for piece in plan.pieces]
        given = [parts[piece.given] for piece in plan.pieces]
        said = verify(text, lying, machine, skipped, job, given)
        if errors_in(said):
            raise VerifyError(said)
    return Posted(text, plan, (*plan.remarks, *said))


def _post_sheet(
    parts: Sequence[Part],
    machine: Machine,
    job: str,
    skips: Collection[str],
    read_back: bool,
    strict: bool,
) -> Posted:
    """As `post`, for a machine that cuts sheets."""
    from beamcam.planning.sheet import plan_sheet

    plan = plan_sheet(parts, machine, skips)
    if strict and any(said.severity is Severity.WARNING for said in plan.remarks):
        raise PlanError(map(as_error, plan.remarks))
    kind = sheet_post(machine)
    program = kind.motion(plan, machine, job)
    if not read_back:
        start, *work = program.commands
        program = replace(program, commands=(start, NOT_READ_BACK, *work))
    text = kind.emit(program, machine)
    said: tuple[Diagnostic, ...] = ()
    if read_back:
        skipped = {o.feature for o in plan.outcomes if o.how == "skipped"}
        said = kind.verify(text, parts, machine, skipped, job)
        if errors_in(said):
            raise VerifyError(said)
    return Posted(text, plan, (*plan.remarks, *said))
