"""The architecture on one screen: how an input becomes a program.

    bytes -> readers -> Part -> planning -> Plan -> motion -> Program -> emitters -> text
                                                                     verify <- text

Which motion step and which emitter belong together stands in `POSTS`.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from pathlib import PurePath
from typing import Any, Literal

from msgspec import Struct
from msgspec.structs import replace

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
from beamcam.verify import skippable, verify

DEFAULT_MACHINE = "beamline"
#: The machine of a sheet by the suffix of the output, where none is named.
SHEET_MACHINES = {
    ".ngc": "plate-linuxcnc", ".gcode": "plate-codesys", ".nc": "laser-grbl",
    ".st": "table-simotion", ".steps": "laser-stepper", ".csv": "laser-stepper",
    ".bin": "laser-stepper", ".h": "laser-stepper",
}  # fmt: skip
DEFAULT_SHEET_MACHINE = "plate-linuxcnc"
STANDARD_INPUT = "-"
Stage = Callable[[str], None]  #: is told what has been done
NOT_READ_BACK = Comment("NOT VERIFIED: THIS PROGRAM WAS NOT READ BACK")


def untold(stage: str) -> None:
    """What is called after a stage where nobody wants to know."""


class Post(Struct, frozen=True):
    """How a kind of machine gets its program."""

    motion: Callable[[Plan, Machine, str], Program]
    emit: Callable[[Program, Machine], str]


#: By controller family and kind of stock.
POSTS = {
    ("codesys", "beam"): Post(beam_program, gcode.emit),
}


class SheetPost(Struct, frozen=True):
    """How a cutting table gets its program or its table, and how that is read back."""

    motion: Callable[[SheetPlan, Machine, str], Any]
    emit: Callable[[Any, Machine], str]
    verify: Callable[
        [str, Sequence[Part], Machine, Collection[FeatureRef], str], tuple[Diagnostic, ...]
    ]


def sheet_post(machine: Machine) -> SheetPost:
    """The row of a cutting table; its modules load what a bar never needs."""
    if machine.controller == "simotion":
        from beamcam.emitters import simotion
        from beamcam.motion.triggers import trigger_table
        from beamcam.verify.st import verify_triggers

        return SheetPost(trigger_table, simotion.emit, verify_triggers)
    if machine.controller == "stepper":
        from beamcam.emitters import step_table
        from beamcam.motion.steps import step_table as steps
        from beamcam.verify.steps import verify_steps

        return SheetPost(steps, step_table.emit, verify_steps)
    from beamcam.emitters import cutting
    from beamcam.motion.sheet import sheet_program
    from beamcam.verify.sheets import verify_sheet

    posts = {
        name: SheetPost(sheet_program, cutting.emit, verify_sheet)
        for name in ("codesys", "linuxcnc", "grbl")
    }
    return posts[machine.controller]


class Posted(Struct, frozen=True):
    """A program and how it came about."""

    text: str
    plan: Plan | SheetPlan
    remarks: tuple[Diagnostic, ...]
    pieces: Callable[[], Iterable[bytes]] | None = None  #: of a table that is not kept as a text


def stock_of(parts: Sequence[Part]) -> Literal["beam", "sheet"]:
    """The kind of stock that parts are made of: a sheet if all of them are plates."""
    return "sheet" if parts and all(part.profile.code == "B" for part in parts) else "beam"


def default_machine(stock: Literal["beam", "sheet"], output: str) -> str:
    """The machine where none is named: of a sheet by the suffix of the output."""
    if stock == "beam":
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


def parts_of(
    readings: Iterable[Reading], parts_in: Callable[[Reading], Iterable[Part]] | None = None
) -> tuple[tuple[Part, ...], tuple[Diagnostic, ...]]:
    """All parts in order, and the remarks of their readers. Raises ReadError for any error.

    `parts_in` says what the parts of a reading are, where that is not just `parts`.
    """
    parts: list[Part] = []
    said: list[Diagnostic] = []
    for reading in readings:
        parts += reading.parts if parts_in is None else parts_in(reading)
        said += reading.diagnostics
    if errors_in(said):
        raise ReadError(said)
    return tuple(parts), tuple(said)


def counted(reading: Reading) -> Sequence[Part]:
    """The parts of a reading, equal members of a model as one with their number as quantity."""
    if reading.format != "ifc":
        return reading.parts
    from beamcam.readers.ifc.quantities import equal_parts

    return equal_parts(reading.parts)


def read_back(
    text: str,
    parts: Sequence[Part],
    machine: Machine,
    skipped: Collection[FeatureRef] = (),
    name: str = "program",
    given: Sequence[Part] = (),
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with a program for bars, sheets or tables, as its machine reads it.

    `parts` come in their order on the bar and as they lie there, `skipped` names features that
    may be missing, `given` are the parts before they were turned.
    """
    if machine.stock == "sheet":
        return sheet_post(machine).verify(text, parts, machine, skipped, name)
    return verify(text, parts, machine, skipped, name, given)


def left_out(
    parts: Sequence[Part], machine: Machine, skips: Collection[str]
) -> frozenset[FeatureRef]:
    """The features that may be missing under the names of `--allow-skips`. Raises PlanError."""
    if not skips:
        return frozenset()
    if machine.stock == "sheet":
        from beamcam.planning.sheet import plan_sheet

        outcomes = plan_sheet(parts, machine, skips).outcomes
        return frozenset(o.feature for o in outcomes if o.how == "skipped")
    return skippable(parts, machine, skips)


def post(
    parts: Sequence[Part],
    machine: Machine,
    job: str = "JOB",
    bar: float | None = None,
    skips: Collection[str] = (),
    verified: bool = True,
    order: Order = "given",
    turn: bool = False,
    strict: bool = False,
    style: str | None = None,
    stage: Stage = untold,
) -> Posted:
    """The program that makes `parts` from one bar or sheet, read back and compared with them.

    `style` is how a controller that knows several is told: "chain" or "table" of triggers; of
    step tables the suffix of the output, whose bytes are then in `pieces`. Unless `verified` a
    comment in the program says so. `stage` is told each step that is done. Raises PlanError if
    the machine cannot make the parts, or under `strict` if there is a warning; VerifyError if the
    program would make anything else.
    """
    if machine.stock == "sheet":
        return _post_sheet(parts, machine, job, skips, verified, strict, style, stage)
    plan = plan_bar(parts, machine, bar, skips, order, turn)
    stage(f"planned {len(plan.operations)} operation(s)")
    if strict and any(said.severity is Severity.WARNING for said in plan.remarks):
        raise PlanError(map(as_error, plan.remarks))
    kind = POSTS[machine.controller, machine.stock]
    program = kind.motion(plan, machine, job)
    if not verified:
        start, *work = program.commands
        program = replace(program, commands=(start, NOT_READ_BACK, *work))
    stage("put in motion")
    text = kind.emit(program, machine)
    stage("printed the program")
    said: tuple[Diagnostic, ...] = ()
    if verified:
        skipped = {o.feature for o in plan.outcomes if o.how == "skipped"}
        lying = [piece.part for piece in plan.pieces]
        given = [parts[piece.given] for piece in plan.pieces]
        said = read_back(text, lying, machine, skipped, job, given)
        stage("read the program back")
        if errors_in(said):
            raise VerifyError(said)
    return Posted(text, plan, (*plan.remarks, *said))


def _post_sheet(
    parts: Sequence[Part],
    machine: Machine,
    job: str,
    skips: Collection[str],
    verified: bool,
    strict: bool,
    style: str | None,
    stage: Stage,
) -> Posted:
    """As `post`, for a machine that cuts sheets."""
    from beamcam.planning.sheet import plan_sheet

    plan = plan_sheet(parts, machine, skips)
    stage(f"planned {len(plan.operations)} operation(s)")
    if strict and any(said.severity is Severity.WARNING for said in plan.remarks):
        raise PlanError(map(as_error, plan.remarks))
    kind = sheet_post(machine)
    program = kind.motion(plan, machine, job)
    if not verified:
        program = _not_read_back(program)
    stage("put in motion")
    pieces: Callable[[], Iterable[bytes]] | None = None
    text = ""
    if machine.controller == "stepper" and style is not None:
        pieces = _step_pieces(program, style)
    elif machine.controller == "simotion":
        text = _triggers_text(program, machine, style, parts)
    else:
        text = kind.emit(program, machine)
    stage("printed the program")
    said: tuple[Diagnostic, ...] = ()
    if verified:
        skipped = {o.feature for o in plan.outcomes if o.how == "skipped"}
        if pieces is not None:
            from beamcam.verify.steps import verify_steps

            # Velocities and the C header are of the same steps as the bytes.
            read = pieces if style in READ_BACK_FORMS else _step_pieces(program, ".bin")
            said = verify_steps(read(), parts, machine, skipped, job)
        else:
            said = read_back(text, parts, machine, skipped, job)
        stage("read the program back")
        if errors_in(said):
            raise VerifyError(said)
    return Posted(text, plan, (*plan.remarks, *said), pieces)


READ_BACK_FORMS = (".steps", ".bin")  #: of step tables


def _not_read_back(program: Any) -> Any:
    """The program with a comment that says so."""
    if isinstance(program, Program):
        start, *work = program.commands
        return replace(program, commands=(start, NOT_READ_BACK, *work))
    from msgspec import structs

    return structs.replace(program, remarks=(NOT_READ_BACK.text, *program.remarks))


def _step_pieces(table: Any, form: str) -> Callable[[], Iterable[bytes]]:
    from beamcam.emitters.step_table import FORMS

    return lambda: FORMS[form](table)


def _triggers_text(table: Any, machine: Machine, style: str | None, parts: Sequence[Part]) -> str:
    """Raises PlanError for a chain that is too long."""
    from beamcam.emitters import simotion
    from beamcam.planning.contours import rules as sheet_rules

    try:
        return simotion.emit(table, machine, style)
    except simotion.ChainError as error:
        said = sheet_rules.CHAIN.at(parts[0].source, found=error.found, expected=error.expected)
        raise PlanError(said) from error
