"""beamcam from Python: read a part, plan the work, post the program, verify any program.

    import beamcam

    reading = beamcam.read("samples/dstv/channel.nc1")
    posted = beamcam.post(reading.parts, "beamline")
    assert not beamcam.verify(posted.text, reading.parts, "beamline")
    print(posted.text)

These functions, `load` and `convert`, and what they give back are stable. A machine is everywhere
the name of a shipped one, the path of a TOML file, or a `Machine`; `load` gives one as a job wants
it. What cannot be done raises a `BeamcamError` that carries
its diagnostics, an `AskError` where the call itself is wrong; what is only to be said comes back
as diagnostics beside the result. All of them may be called from several threads at once.
"""

import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, Literal, TypedDict, Unpack

from msgspec.structs import replace

from beamcam.asked import (
    ASK_TYPE,
    ASK_VALUE,
    AnyMachine,
    AskError,
    check_asked,
    check_flags,
    check_text,
    converted,
    machine_of,
    parts_asked,
)
from beamcam.errors import Diagnostic, PlanError, ReadError, Source
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

__all__ = ["convert", "load", "plan", "post", "read", "verify"]

Process = Literal["cut", "mark", "engrave", "ignore"]


class SheetOptions(TypedDict, total=False):
    """How a sheet is cut, as the options of the command line and the keys of `[sheet]`; mm."""

    thickness: float
    material: str
    kerf: float
    kerf_by: Literal["none", "offset", "machine"]
    lead: Literal["none", "line", "arc"]
    tabs: int
    inner_tabs: bool
    place: Literal["corner", "drawn"]
    origin: Literal["table", "lower-left", "lower-right", "upper-left", "upper-right", "centre"]
    mirror: Literal["none", "x", "y"]
    rotate: float
    copies: tuple[int, int]
    spacing: float
    sheet_size: tuple[float, float]
    unrolled: bool


def load(
    machine: AnyMachine = DEFAULT_MACHINE,
    *,
    map: Mapping[str, Process | Mapping[str, object]] | None = None,
    tolerances: Mapping[str, float] | None = None,
    **sheet: Unpack[SheetOptions],
) -> Machine:
    """A machine as a job wants it, for every function that takes one.

    `map` says what is done with a colour or layer, `tolerances` are those of a drill (merge,
    duplicate, sink, path, twin), `sheet` how a sheet is cut; all as in `beamcam.toml`, over what
    the machine's file says. Raises MachineError; AskError for a name or value that cannot be
    meant; ConfigError and PlanError for what this machine cannot do.
    """
    from beamcam.config.values import Config, ConfigFile

    loaded = machine_of(machine)
    tables: dict[str, Any] = {"sheet": sheet, "map": map or {}, "tolerances": tolerances or {}}
    asked = converted(tables, ConfigFile)
    config = Config(loaded.name, sheet=asked.sheet, map=asked.map, tolerances=asked.tolerances)
    if config.tolerances:
        from beamcam.config.apply import with_tolerances

        loaded = with_tolerances(loaded, config)
    if not (config.map or sheet):
        return loaded
    from beamcam.machine.overlay import with_torch

    try:
        return with_torch(
            loaded, config.meanings, settings=config.look_settings, **config.sheet.given()
        )
    except ValueError as error:
        from beamcam.planning.contours.rules import OPTION

        raise PlanError(OPTION.at(Source(loaded.name), found=error)) from error


def read(
    source: str | os.PathLike[str] | bytes,
    *,
    name: str = "part",
    strict: bool = False,
    units: str | None = None,
    width: str | None = None,
    layers: Sequence[str] = (),
    letters: Sequence[str] = (),
    encoding: str | None = None,
) -> Reading:
    """What is in a file of any format, or in its bytes: `parts` and `diagnostics`.

    `name` is what bytes are called in messages; its suffix, if any, says which format is tried
    first. `strict` makes warnings errors. Of a drawing `units` are those of its numbers, `width`
    that of an SVG's page ("600mm"), `layers` the ones to read, `letters` those whose texts become
    strokes; `encoding` is the alphabet of a DSTV file. Raises ReadError if there is an error; its
    diagnostics are all of them.
    """
    check_flags(strict=strict)
    check_text("name", name)
    check_text("source", source, bytes, os.PathLike)
    options = _reader_options(units, width, layers, letters, encoding)
    if isinstance(source, bytes):
        reading = read_bytes(source, name, **options)
        if strict:
            reading = replace(reading, diagnostics=tuple(map(as_error, reading.diagnostics)))
    else:
        reading = read_file(os.fspath(source), strict, **options)
    if reading.refused:
        raise ReadError(reading.diagnostics)
    return reading


def _reader_options(
    units: str | None,
    width: str | None,
    layers: Sequence[str],
    letters: Sequence[str],
    encoding: str | None,
) -> dict[str, object]:
    """What was asked of a reader, by the names that readers have for it. Raises AskError."""
    for name, text in (("units", units), ("width", width), ("encoding", encoding)):
        if text is not None:
            check_text(name, text)
    if encoding is not None:
        try:
            "a".encode(encoding)
        except (LookupError, UnicodeError) as error:
            said = ASK_VALUE.at(Source("beamcam"), name="encoding", fault=str(error))
            raise AskError(said) from error
    asked: dict[str, object] = {"units": units, "width": width, "encoding": encoding}
    for name, names in (("layers", layers), ("letters", letters)):
        if names:
            asked[name] = converted(names, tuple[str, ...], name)
    return asked


def convert(part: Part, to: str = "dstv", *, thickness: float | None = None) -> str:
    """The text of a part in another format: "dstv", "part-json" or "faces-dxf".

    `thickness` is that of a drawing's sheet in mm, which no drawing says. Raises AskError, and
    BeamcamError for what the format cannot hold.
    """
    from beamcam.writers import TARGETS

    (only,) = parts_asked(part)
    target = next((target for target in TARGETS if target.name == to), None)
    if target is None:
        expected = ", ".join(target.name for target in TARGETS)
        said = ASK_TYPE.at(Source("beamcam"), name="to", found=repr(to), expected=expected)
        raise AskError(said)
    if thickness is not None and only.profile.web_thickness is None:
        from beamcam.config.values import Sheet

        asked = converted({"thickness": thickness}, Sheet).thickness
        only = replace(only, profile=replace(only.profile, web_thickness=asked))
    return target.write(only)


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
    loaded = machine_of(machine)
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
    return post_bar(parts_asked(parts), machine_of(machine), job, bar, skips, read_back)


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
    request = Request(parts_asked(parts), machine_of(machine), named_skips(skips), name)
    return read_program_back(program, request)
