"""From a file to a verified program, from Python; what the commands take, by the names that they
have there."""

import os
from collections.abc import Collection, Iterable, Mapping
from typing import Any, Literal, Unpack, get_args

from msgspec.structs import replace

from beamcam.api.inputs import (
    ASK_VALUE,
    CheckedReadOptions,
    FileInput,
    ReadOptions,
    SheetOptions,
    check_choice,
    check_flags,
    check_text,
    checked_parts,
    converted,
)
from beamcam.arguments import ASK_TYPE, AnyMachine, AskError, ask_type, check_arguments, machine_of
from beamcam.errors import Diagnostic, PlanError, ReadError, Source
from beamcam.machine import Machine
from beamcam.machine.machine import DEFAULT_MACHINE
from beamcam.machine.overlay import with_section, with_torch
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
    settings = converted({**tables, "corner": corner, "lip": lip}, ConfigFile)
    config = Config(
        loaded.name, sheet=settings.sheet, map=settings.map, tolerances=settings.tolerances
    )
    if config.tolerances.given():
        from beamcam.config.load import with_tolerances

        loaded = with_tolerances(loaded, config)
    loaded = with_section(loaded, settings.corner, settings.lip)
    if not (config.map or sheet):
        return loaded
    try:
        return with_torch(
            loaded, config.meanings, settings=config.layer_settings, **config.sheet.given()
        )
    except ValueError as error:
        from beamcam.planning.contours.rules import OPTION

        raise PlanError(OPTION.at(Source(loaded.name), found=error)) from error


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
    asked = _reader_options(options)
    if data is None:
        reading = read_file(os.fspath(source), strict, **asked)  # type: ignore[arg-type]
    else:
        reading = judged(read_bytes(data, name, **asked), strict)
    if reading.refused:
        raise ReadError(reading.diagnostics)
    source_of_marks = converted(options, CheckedReadOptions).mark_from
    return replace(reading, parts=marked(reading.parts, source_of_marks))


def _reader_options(asked: ReadOptions) -> dict[str, object]:
    """What was asked of a reader, by the names that readers have for it. Raises AskError."""
    values = converted(asked, CheckedReadOptions)
    if values.encoding is not None:
        try:
            "a".encode(values.encoding)
        except (LookupError, UnicodeError) as error:
            diagnostic = ASK_VALUE.at(Source("beamcam"), name="encoding", fault=str(error))
            raise AskError(diagnostic) from error
    names = ("units", "width", "encoding", "ends", "layers", "letters", "fit", "wrap")
    given = {name: value for name in names if (value := getattr(values, name)) not in (None, ())}
    members = (values.marks, values.guids, values.classes, values.assemblies)
    options = Options(
        values.force, values.check, letter=values.letter == "mark", workers=values.workers
    )
    return given | {"selection": Selection(*map(frozenset, members)), "options": options}


def convert(part: Part, to: str = "dstv", *, thickness: float | None = None) -> str:
    """The text of a part in another format: "dstv", "part-json" or "faces-dxf".

    `thickness` is that of a drawing's sheet in mm, which no drawing says. Raises AskError, and
    BeamcamError for what the format cannot hold.
    """
    from beamcam.writers import TARGETS

    (only,) = checked_parts(part)
    target = next((target for target in TARGETS if target.name == to), None)
    if target is None:
        expected = ", ".join(target.name for target in TARGETS)
        raise AskError(ASK_TYPE.at(Source("beamcam"), name="to", found=repr(to), expected=expected))
    if thickness is not None and only.profile.web_thickness is None:
        from beamcam.config.values import Sheet

        asked = converted({"thickness": thickness}, Sheet).thickness
        only = replace(only, profile=replace(only.profile, web_thickness=asked))
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
    if from_contour is not None:
        from beamcam.remainder import rest_of_sheet

        return rest_of_sheet(posted, _contour(from_contour, loaded))
    if from_operation is None:
        return posted
    from beamcam.remainder import rest_of

    return rest_of(posted, _operation(from_operation, loaded))


def rest(posted: Posted, to: str = "dstv") -> str | None:
    """What a program leaves of its only part for the next machine, as a text; None if nothing.

    `to` is "dstv" or "part-json". Raises AskError, and VerifyError where program and rest together
    are not the part.
    """
    from beamcam.rest_part import rest_of_part
    from beamcam.writers import TARGETS

    target = next((target for target in TARGETS[:2] if target.name == to), None)
    if target is None:
        expected = ", ".join(target.name for target in TARGETS[:2])
        raise AskError(ASK_TYPE.at(Source("beamcam"), name="to", found=repr(to), expected=expected))
    request = posted.job.request
    if len(request.parts) != 1 or request.turn or request.machine.stock == "sheet":
        name, found = (
            "posted",
            "a program of several parts, of a sheet, or of a part that is turned",
        )
        expected = "one of one part of a bar, as it was read"
        raise AskError(ASK_TYPE.at(Source("beamcam"), name=name, found=found, expected=expected))
    left = rest_of_part(posted, target)
    return None if left is None else left[1]


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
        fault = "a remainder has no solid of its own"
        raise AskError(ASK_VALUE.at(Source("beamcam"), name="solid", fault=fault))
    loaded, all_parts, data = machine_of(machine), checked_parts(parts), program_bytes(program)
    check_choice("order", order, get_args(Order))
    check_style(style, loaded)
    request = Request(all_parts, loaded, named_skips(skips), name, order, turn, style=style)
    if from_operation is None and from_contour is None:
        diagnostics = read_program_back(data, request, bar)
        if not solid:
            return diagnostics
        from beamcam.solid.opinion import solid_faults

        return (*diagnostics, *solid_faults(data, request, bar))
    from beamcam.remainder import faults_of

    if from_contour is not None:
        first = _contour(from_contour, loaded)
    else:
        first = _operation(from_operation, loaded)
    if after is None:
        whole = post_bar(all_parts, loaded, "JOB", bar, skips, False, order, turn).text
    else:
        whole = program_bytes(after).decode("utf-8", "replace")
    rest, job = data.decode("utf-8", "replace"), whole_job(request, bar)
    if from_contour is not None:
        from beamcam.remainder import faults_of_sheet_rest

        return faults_of_sheet_rest(rest, whole, first, job)
    return faults_of(rest, whole, first, job)


def check_style(style: object, machine: Machine) -> None:
    """Raise AskError for what is not a form of a program of the machine's controller."""
    known = {**dict.fromkeys(DIALECTS, STYLES), "stepper": STEP_FORMS}
    forms = known.get(machine.controller, ())
    if style is not None and style not in forms:
        raise AskError(ask_type("style", style, " or ".join(map(repr, (*forms, None)))))


def _contour(first: object, machine: Machine) -> int:
    """The contour that the rest of a sheet's program begins with. Raises AskError."""
    number: int = converted(first, int, "from_contour")
    if machine.stock != "sheet" or machine.controller in TABLE_CONTROLLERS:
        fault = f"{machine.name} runs no program of contours"
        raise AskError(ASK_VALUE.at(Source("beamcam"), name="from_contour", fault=fault))
    return number


def _operation(first: object, machine: Machine) -> int:
    """The operation that a remainder begins with. Raises AskError."""
    number: int = converted(first, int, "from_operation")
    if machine.stock != "beam":
        fault = f"{machine.name} works on no bars"
        raise AskError(ASK_VALUE.at(Source("beamcam"), name="from_operation", fault=fault))
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
    found = content(os.fspath(program))  # type: ignore[call-overload]
    if isinstance(found, Diagnostic):
        raise ReadError(found)
    return bytes(found)
