"""From a file to a verified program, from Python; what the commands take, by the names that they
have there."""

import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, Unpack, get_args

from msgspec.structs import replace

from beamcam.api.inputs import (
    FileInput,
    ReadOptions,
    SheetOptions,
    ask_value,
    check_choice,
    check_flags,
    check_text,
    checked_parts,
    converted,
)
from beamcam.arguments import (
    ASK_TYPE,
    HERE,
    AnyMachine,
    AskError,
    ask_type,
    check_arguments,
    for_job,
    machine_of,
)
from beamcam.errors import Diagnostic, ReadError
from beamcam.machine import Machine
from beamcam.machine.machine import DEFAULT_MACHINE
from beamcam.machine.runtime import STYLES
from beamcam.machine.tables import DIALECTS, STEP_FORMS, TABLE_CONTROLLERS
from beamcam.model.part import Part
from beamcam.model.plan import AnyPlan, Order, named_skips
from beamcam.model.request import Options, Request, Selection, marked
from beamcam.pipeline import Posted, judged, read_file, remarks_on, whole_job
from beamcam.pipeline import post as post_bar
from beamcam.pipeline import read_back as read_program_back
from beamcam.posts import post_of
from beamcam.readers import Reading, content
from beamcam.readers import read as read_bytes

if TYPE_CHECKING:
    from beamcam.writers import Target

Process = Literal["cut", "mark", "engrave", "ignore"]


def load(
    machine: AnyMachine = DEFAULT_MACHINE,
    *,
    map: Mapping[str, Process | Mapping[str, object]] | None = None,
    tolerances: Mapping[str, float] | None = None,
    corner: float | None = None,
    lip: float | None = None,
    **sheet: Unpack[SheetOptions],
) -> Machine:
    """A machine as a job wants it, for every function that takes one.

    `map` says what is done with a colour or layer, `tolerances` are those of a drill (merge,
    duplicate, sink, path, same_tool), `corner` is the outer radius of a rectangular tube's corners
    and `lip` the length of a C's lips where neither its file nor the machine's has one, `sheet` how
    a sheet is cut; all as in `beamcam.toml`, over what the machine's file says. Raises
    MachineError; AskError for a name or value that cannot be meant; ConfigError and PlanError for
    what this machine cannot do.
    """
    from beamcam.config.values import Config, ConfigFile

    loaded = machine_of(machine)
    tables: dict[str, Any] = {"sheet": sheet, "map": map or {}, "tolerances": tolerances or {}}
    read = converted({**tables, "corner": corner, "lip": lip}, ConfigFile)
    given = {name: getattr(read, name) for name in (*tables, "corner", "lip")}
    return for_job(loaded, Config(loaded.name, **given))


def read(
    source: FileInput, *, name: str = "part", strict: bool = False, **options: Unpack[ReadOptions]
) -> Reading:
    """What is in a file of any format: `parts` and `diagnostics`.

    A file is given by its path, its bytes, or open. `name` is what bytes are called in messages;
    its suffix, if any, says which format is tried first. `strict` makes warnings errors. Raises
    ReadError if there is an error; its diagnostics are all of them.
    """
    check_flags(strict=strict)
    check_text("name", name)
    data = bytes_of(source, "source")
    how = _reader_options(options)
    if data is None:
        reading = read_file(os.fspath(source), strict, **how)  # type: ignore[arg-type]
    else:
        reading = judged(read_bytes(data, name, **how), strict)
    if reading.refused:
        raise ReadError(reading.diagnostics)
    return replace(reading, parts=marked(reading.parts, options.get("mark_from", "mark")))


def _reader_options(options: ReadOptions) -> dict[str, object]:
    """The options of a reader, by the names that readers have for them. Raises AskError."""
    for name in options.keys() - ReadOptions.__annotations__.keys():
        raise AskError(ask_value("the options", f"Object contains unknown field `{name}`"))
    values: dict[str, Any] = {**converted(options, ReadOptions)}
    if (encoding := values.get("encoding")) is not None:
        try:
            "a".encode(encoding)
        except (LookupError, UnicodeError) as error:
            raise AskError(ask_value("encoding", str(error))) from error
    names = ("units", "width", "encoding", "ends", "wrap", "layers", "letters", "fit")
    given: dict[str, Any] = {
        name: tuple(of) if isinstance(of, list) else of
        for name in names
        if (of := values.get(name)) not in (None, [])
    }
    members = (values.get(name, ()) for name in ("marks", "guids", "classes", "assemblies"))
    how = Options(
        values.get("force", False), values.get("check", True),
        letter=values.get("letter") == "mark", workers=values.get("workers", 1),
    )  # fmt: skip
    return given | {"selection": Selection(*map(frozenset, members)), "options": how}


def convert(part: Part, to: str = "dstv", *, thickness: float | None = None) -> str:
    """The text of a part in another format: "dstv", "part-json" or "faces-dxf".

    `thickness` is that of a drawing's sheet in mm, which no drawing says. Raises AskError, and
    BeamcamError for what the format cannot hold.
    """
    from beamcam.writers import TARGETS

    (only,) = checked_parts(part)
    target = _target(to, TARGETS)
    if thickness is not None and only.profile.web_thickness is None:
        from beamcam.config.values import Sheet

        given = converted({"thickness": thickness}, Sheet).thickness
        only = replace(only, profile=replace(only.profile, web_thickness=given))
    return target.write(only)


def plan(
    parts: Part | Iterable[Part], machine: AnyMachine = DEFAULT_MACHINE, *,
    bar: float | None = None, skips: Collection[str] = (), order: Order = "given",
    turn: bool = False, strict: bool = False,
) -> AnyPlan:  # fmt: skip
    """The work that makes `parts` from one bar, in the order given, or from one sheet.

    `bar` is its length in mm; without it the bar is as long as the parts need. `skips` names what
    may be left out, as `--allow-skips` does. `order` "best" lays the parts so that mitres nest,
    `turn` lets them lie turned; `strict` makes warnings errors. Raises PlanError and MachineError.
    """
    check_arguments(bar=bar, skips=skips)
    check_flags(turn=turn, strict=strict)
    check_choice("order", order, get_args(Order))
    loaded = machine_of(machine)
    request = Request(
        checked_parts(parts), loaded, named_skips(skips), order=order, turn=turn, strict=strict
    )
    made = post_of(loaded).plan(whole_job(request, bar))
    remarks_on(made, loaded, strict)
    return made


def post(
    parts: Part | Iterable[Part], machine: AnyMachine = DEFAULT_MACHINE, *, job: str = "JOB",
    bar: float | None = None, skips: Collection[str] = (), order: Order = "given",
    turn: bool = False, style: str | None = None, strict: bool = False, read_back: bool = True,
    from_operation: int | None = None, from_contour: int | None = None, date: str = "",
) -> Posted:  # fmt: skip
    """The program that makes `parts` from one bar: its `text`, the `plan`, and `remarks`.

    `order`, `turn` and `strict` as of `plan`; `style` is "chain" or "table" of triggers, of step
    tables the suffix of their form. `from_operation` gives the remainder of the program only, from
    that operation of the plan on, `from_contour` that of a sheet; `date` is what `{date}` of the
    machine's words says. It was read back and compared with the parts, unless `read_back` is False,
    which the program then says.
    Raises PlanError, MachineError, and VerifyError for a program that would make anything else.
    """
    check_flags(read_back=read_back, turn=turn, strict=strict)
    check_arguments(job, bar, skips)
    loaded, all_parts = machine_of(machine), checked_parts(parts)
    check_choice("order", order, get_args(Order))
    check_style(style, loaded)
    check_text("date", date)
    posted = post_bar(
        all_parts, loaded, job, bar, skips, read_back, order, turn, strict, style, date
    )
    first = _first(from_operation, from_contour, loaded)
    if first is None:
        return posted
    from beamcam.remainder import rest_of, rest_of_sheet

    return (rest_of if from_contour is None else rest_of_sheet)(posted, first)


def rest(posted: Posted, to: str = "dstv") -> str | None:
    """What a program leaves of its only part for the next machine, as a text; None if nothing.

    `to` is "dstv" or "part-json". Raises AskError, and VerifyError where program and rest together
    are not the part.
    """
    from beamcam.rest_part import rest_of_part
    from beamcam.writers import TARGETS

    target, request = _target(to, TARGETS[:2]), posted.job.request
    if len(request.parts) != 1 or request.turn or request.machine.stock == "sheet":
        found = "a program of several parts, of a sheet, or of a part that is turned"
        expected = "one of one part of a bar, as it was read"
        raise AskError(ASK_TYPE.at(HERE, name="posted", found=found, expected=expected))
    left = rest_of_part(posted, target)
    return None if left is None else left[1]


def _target(to: str, targets: "Sequence[Target]") -> "Target":
    """The format of that name. Raises AskError."""
    target = next((target for target in targets if target.name == to), None)
    if target is None:
        expected = ", ".join(target.name for target in targets)
        raise AskError(ASK_TYPE.at(HERE, name="to", found=repr(to), expected=expected))
    return target


def verify(
    program: FileInput, parts: Part | Iterable[Part], machine: AnyMachine = DEFAULT_MACHINE, *,
    skips: Collection[str] = (), name: str = "program", order: Order = "given", turn: bool = False,
    bar: float | None = None, style: str | None = None, from_operation: int | None = None,
    from_contour: int | None = None, after: FileInput | None = None, solid: bool = False,
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """Everything that is wrong with a program, by itself and against `parts`.

    It is its text, its bytes, or its file as a `Path` or open. Nothing comes back for a program
    that makes exactly the parts, in their order on the bar; `order` "best" and `turn` take them in
    another one and turned. `skips` names the kinds of features that may be missing, as
    `--allow-skips` does; `bar` is the bar's length, where it is known. With `from_operation` the
    program is the remainder of one (`from_contour`: of a sheet's), of `after`, or of the program
    that `post` makes of the parts. `solid` machines a whole program as a solid too, and compares
    the pieces.
    Raises MachineError, and PlanError where that cannot be posted.
    """
    check_arguments(bar=bar, skips=skips)
    check_flags(turn=turn, solid=solid)
    check_text("name", name)
    if solid and (from_operation is not None or from_contour is not None):
        raise AskError(ask_value("solid", "a remainder has no solid of its own"))
    loaded, all_parts, data = machine_of(machine), checked_parts(parts), program_bytes(program)
    check_choice("order", order, get_args(Order))
    check_style(style, loaded)
    request = Request(all_parts, loaded, named_skips(skips), name, order, turn, style=style)
    first = _first(from_operation, from_contour, loaded)
    if first is None:
        diagnostics = read_program_back(data, request, bar)
        if not solid:
            return diagnostics
        from beamcam.solid.opinion import solid_faults

        return (*diagnostics, *solid_faults(data, request, bar))
    from beamcam.remainder import faults_of, faults_of_sheet_rest

    if after is None:
        whole = post_bar(all_parts, loaded, "JOB", bar, skips, False, order, turn).text
    else:
        whole = program_bytes(after).decode("utf-8", "replace")
    rest, job = data.decode("utf-8", "replace"), whole_job(request, bar)
    return (faults_of if from_contour is None else faults_of_sheet_rest)(rest, whole, first, job)


def check_style(style: object, machine: Machine) -> None:
    """Raise AskError for what is not a form of a program of the machine's controller."""
    known = {**dict.fromkeys(DIALECTS, STYLES), "stepper": STEP_FORMS}
    forms = known.get(machine.controller, ())
    if style is not None and style not in forms:
        raise AskError(ask_type("style", style, " or ".join(map(repr, (*forms, None)))))


def _first(operation: object, contour: object, machine: Machine) -> int | None:
    """The contour of a sheet or the operation that a remainder begins with, if it is asked for.

    Raises AskError.
    """
    if contour is not None:
        number: int = converted(contour, int, "from_contour")
        if machine.stock != "sheet" or machine.controller in TABLE_CONTROLLERS:
            fault = f"{machine.name} runs no program of contours"
            raise AskError(ask_value("from_contour", fault))
        return number
    if operation is None:
        return None
    number = converted(operation, int, "from_operation")
    if machine.stock != "beam":
        raise AskError(ask_value("from_operation", f"{machine.name} works on no bars"))
    return number


# --- files as they are given ----------------------------------------------------------------------


def bytes_of(source: object, what: str) -> bytes | None:
    """The bytes of a file that is given by its content or open; None of a path.

    Raises AskError for anything else.
    """
    if isinstance(source, bytes | bytearray | memoryview):
        return bytes(source)
    if isinstance(source, str | os.PathLike):
        return None
    read: Any = getattr(source, "read", None)
    if not callable(read):
        raise AskError(ask_type(what, source, "a path, bytes, or a file that is open to be read"))
    data = read()
    return data.encode() if isinstance(data, str) else bytes(data)


def program_bytes(program: object) -> bytes:
    """The bytes of a program: of its text, its bytes, or its file as a `Path` or open.

    Raises AskError, and ReadError for a file that cannot be read.
    """
    if isinstance(program, str):
        return program.encode()
    data = bytes_of(program, "program")
    if data is not None:
        return data
    read = content(os.fspath(program))  # type: ignore[call-overload]
    if isinstance(read, Diagnostic):
        raise ReadError(read)
    return bytes(read)
