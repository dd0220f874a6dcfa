"""`beamcam convert`: a part from one format to another."""

from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path, PurePath
from typing import Any

import click
from msgspec import Struct

from beamcam.commands import options
from beamcam.commands.common import REFUSED, Voice, cannot_write, read_all, write
from beamcam.commands.members import member_choice, member_options
from beamcam.commands.rules import ONE_PART, OUTPUT_FORMAT
from beamcam.commands.settings import settled
from beamcam.commands.sheets import drawing_choice, drawing_options
from beamcam.errors import BeamcamError, ReadError, Severity, Source
from beamcam.model.part import Part
from beamcam.pipeline import counted


class Target(Struct, frozen=True):
    """A format that a part can be written in."""

    name: str
    suffixes: tuple[str, ...]
    module: str  #: its `write` turns a part into the file's content

    @property
    def write(self) -> Callable[[Part], str]:
        function: Callable[[Part], str] = import_module(self.module).write
        return function


TARGETS = (
    Target("dstv", (".nc1", ".nc"), "beamcam.writers.dstv"),
    Target("part-json", (".json",), "beamcam.writers.part_json"),
    Target("faces-dxf", (".dxf",), "beamcam.writers.faces_dxf"),
)


def target_of(output: str, name: str | None) -> Target:
    """The format called `name`, or else the one that the output's suffix says."""
    suffix = PurePath(output).suffix.lower()
    for target in TARGETS:
        if target.name == name or (name is None and suffix in target.suffixes):
            return target
    if name is None and is_folder(output):
        return TARGETS[0]
    expected = ", ".join(s for t in TARGETS for s in t.suffixes)
    raise ReadError(OUTPUT_FORMAT.at(Source(output), found=suffix or output, expected=expected))


def is_folder(output: str) -> bool:
    """Whether an output stands for a folder, which gets a file for each part."""
    return output.endswith("/") or Path(output).is_dir()


def file_names(parts: Iterable[Part], suffix: str) -> list[str]:
    """A name for each part after its mark, with a number where two have the same."""
    names: list[str] = []
    for part in parts:
        stem = "".join(c if c.isalnum() or c in "-_.+" else "_" for c in part.mark).strip(".")
        stem, count = stem or "part", 1
        name = stem + suffix
        while name.lower() in (n.lower() for n in names):
            count += 1
            name = f"{stem}-{count}{suffix}"
        names.append(name)
    return names


@click.command("convert")
@click.argument("source", metavar="INPUT", type=options.FILE)
@options.output("File, folder/ for a file a part, or -.")
@options.config
@click.option("--to", "to", type=click.Choice([t.name for t in TARGETS]), help="Format.")
@member_options
@drawing_options
@options.strict
@options.json_messages
@options.voiced
def command(
    source: str, output: str, to: str | None, as_json: bool, voice: Voice, **asked: Any
) -> None:
    """Write a part in another format: DSTV, JSON, or a drawing of its faces.

    The suffix of the output says which, unless --to does: .nc1 and .nc are DSTV, .json is the
    JSON form, .dxf a drawing with each face on a layer of its own. Into a folder all members of a
    model are written that can be read, and exit status 1 says that there are others.

    \b
    beamcam convert M58.nc1 -o M58.json
    beamcam convert M58.json -o M58.nc1
    beamcam convert M58.nc1 -o faces.dxf
    beamcam convert model.ifc -o nc/
    """
    how = drawing_choice(asked) | member_choice(asked, kernel=True)
    try:
        config = settled(asked, (source,))
        target = target_of(output, to)
        (reading,) = read_all((source,), config.strict, how, voice)
        parts = counted(reading)
        if not is_folder(output):
            if reading.refused:
                raise ReadError(reading.diagnostics)
            if len(parts) != 1:
                raise ReadError(ONE_PART.at(Source(source), found=len(parts), output=output))
        texts = [target.write(part) for part in parts]
    except BeamcamError as error:
        voice.stop(error.diagnostics)
    if is_folder(output):
        _make_folder(output, voice)
        for name, text in zip(file_names(parts, target.suffixes[0]), texts, strict=True):
            write(str(Path(output) / name), text, voice)
    else:
        write(output, texts[0], voice)
    voice.say([d for d in reading.diagnostics if d.severity is not Severity.NOTE])
    if reading.refused:
        raise SystemExit(REFUSED)


def _make_folder(path: str, voice: Voice) -> None:
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        voice.stop([cannot_write(path, error)])
