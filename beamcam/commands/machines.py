"""`beamcam machines`: which machines there are, and where their values come from."""

import json
import os
from typing import Any

import click

from beamcam.arguments import load_tested
from beamcam.batch.names import cleaned
from beamcam.commands import options
from beamcam.commands.common import Console, cannot_write, say_json, say_lines, write
from beamcam.commands.value_types import picture_suffix
from beamcam.config.values import own_files
from beamcam.errors import BeamcamError, Diagnostic, Source
from beamcam.files import FilesRead, write_whole
from beamcam.machine import Machine, load, shipped
from beamcam.machine.chart_file import chart_rows
from beamcam.machine.keys import machine_keys, machine_schema, settings, starting_file
from beamcam.machine.load import files_of, machine_folders, own_machines, resolved

MAX_CHART_BYTES = 10_000_000


@click.group("machines")
def command() -> None:
    """List the machines, or show one with all its values.

    A machine is a TOML file. One of your own is laid over a shipped one and is known by its name if
    it lies in a folder `machines` beside beamcam.toml, in this folder or among the user's settings;
    else by its path, as in --machine ./mine.toml.

    \b
    beamcam machines list
    beamcam machines new mine --base beamline
    beamcam machines show beamline
    beamcam machines check mine
    beamcam machines plot mine -o mine.svg
    beamcam machines keys
    beamcam machines schema
    """


@command.command("list")
@options.as_json
def list_machines(as_json: bool) -> None:
    """Print the name, the controller and the title of every machine that is known by name.

    \b
    beamcam machines list
    beamcam machines list --json
    """
    own = own_machines(own_files())
    machines: list[Machine] = []
    faults: list[Diagnostic] = []
    for place in (*shipped(), *own.values()):
        try:
            machines.append(load(place))
        except BeamcamError as error:
            faults += error.diagnostics
    if as_json:
        say_json([{"name": m.name, "controller": m.controller, "title": m.title} for m in machines])
    else:
        width = max(len(m.name) for m in machines)
        say_lines(f"{m.name:{width}}  {m.controller:10}  {m.title}" for m in machines)
    if faults:
        Console().stop(faults)


@command.command("new")
@click.argument("name")
@click.option(
    "--base", default="beamline", show_default=True, shell_complete=options.machine_names,
    metavar="NAME", help="Shipped machine to base it on.",
)  # fmt: skip
@click.option(
    "--chart",
    metavar="FILE",
    type=click.Path(exists=True, dir_okay=False),
    help="Cut chart for its rows: QtPlasmaC's material.cfg, SheetCam's .tools.",
)
@click.option("--user", is_flag=True, help="Among the user's settings, for jobs in every folder.")
@options.verbosity
def new(name: str, base: str, chart: str | None, user: bool, console: Console) -> None:
    """Write a machine file of your own: all values of the base as comments, to be made yours.

    It goes to `machines` beside the nearest beamcam.toml, or in this folder, where it is known by
    its name. No file is written over.

    \b
    beamcam machines new mine --base beamline
    beamcam machines new drill-3 --base beamline-pusher --user
    beamcam machines new table --base plate-qtplasmac --chart material.cfg
    """
    if not name or cleaned(name) != name or name in shipped():
        expected = "letters, digits, - and _, and no shipped machine's name"
        raise click.UsageError(f"found {name!r} for the machine's name; expected {expected}.")
    folder = machine_folders(own_files())[-1 if user else 0]
    path = os.path.join(folder, f"{name}.toml")
    rows: list[dict[str, Any]] = []
    if chart:
        with open(chart, encoding="utf-8", errors="replace") as file:
            rows, faults = chart_rows(file.read(MAX_CHART_BYTES), chart)
        if faults:
            console.stop(faults)
    if rows and load(base).torch is None:
        raise click.UsageError(f"{base} has no torch, so --chart has no effect.")
    text = starting_file(name, base, rows)
    if os.path.lexists(path):
        raise click.UsageError(f"{path} is there already; expected a name that is free.")
    try:
        os.makedirs(folder, exist_ok=True)
        write_whole(path, text)
    except OSError as error:
        console.stop([cannot_write(path, error)])
    console.did(f"wrote {path}")
    if not console.quiet:
        say_lines([f"{path}: change what differs, then `beamcam machines check {name}`:"])
        _held_up(load(path), path, console)


@command.command("show")
@click.argument("name")
@options.as_json
def show(name: str, as_json: bool) -> None:
    """Print every value of the machine NAME, and the file and line it comes from.

    \b
    beamcam machines show beamline-annex
    beamcam machines show ./mine.toml --json
    """
    try:
        place = resolved(name, own_files())
        rows, machine = settings(place), load_tested(place)
    except BeamcamError as error:
        Console(as_json=as_json).stop(error.diagnostics)
    Console(as_json=as_json).say(machine.remarks)
    if as_json:
        say_json({r.key: {"value": r.value, "source": r.source and str(r.source)} for r in rows})
        return
    width = max(len(r.key) for r in rows)
    for row in rows:
        shown = json.dumps(row.value, ensure_ascii=False)
        origin = "in the heads of its programs" if row.key == "checksum" else row.source
        say_lines([f"{row.key:{width}} = {shown}  # {origin or 'default'}"])


@command.command("check")
@click.argument("name")
@options.verbosity
def check(name: str, console: Console) -> None:
    """Hold a section up to the machine NAME: where each spindle puts a hole, to be measured.

    One sentence for each spindle, in the axes of its programs. A face that the file takes for its
    mirror image is refused, where the axes of the other spindles tell: exit status 1.

    \b
    beamcam machines check mine
    """
    place = resolved(name, own_files())
    machine = load_tested(place)
    console.say(machine.remarks)
    faults = _held_up(machine, place, console)
    console.did(f"held a section up to {machine.name}")
    if faults:
        console.stop(faults)


def _held_up(machine: Machine, place: str, console: Console) -> tuple[Diagnostic, ...]:
    """Print where holes go; what tells that a face is mirrored comes back."""
    from beamcam.planning.held_up import hand_faults, held_up

    held = held_up(machine)
    if not console.quiet:
        none = f"{machine.name} has no spindles; its words make a part that is read back"
        say_lines((one.sentence for one in held) if held else [none])
    return tuple(hand_faults(held, Source(place)))


@command.command("plot")
@click.argument("name")
@options.output(".svg, .png or .pdf; - is SVG on standard output.")
@options.verbosity
def plot(name: str, output: str, console: Console) -> None:
    """Draw the line NAME: its stations along X, and its spindles at a section.

    What the machine file says of X, of the saw's signs and of the axes of each spindle, to be held
    against the machine itself. PNG and PDF need beamcam[pictures].

    \b
    beamcam machines plot mine -o mine.svg
    """
    from beamcam.pictures.formats import picture
    from beamcam.pictures.line import line_scene

    suffix = picture_suffix(output)
    place = resolved(name, own_files())
    machine = load_tested(place)
    if machine.stock != "beam":
        what = "a coper" if machine.stock == "profile" else "a table"
        raise click.UsageError(f"found {machine.name}, {what}; expected a saw or drilling line")
    drawn = picture([line_scene(machine)], suffix)
    write(output, drawn, console, FilesRead(files_of(place)))


@command.command("keys")
@click.option("--markdown", is_flag=True, help="Print a page for the documentation.")
def keys(markdown: bool) -> None:
    """List every key that a machine file may have, with its meaning.

    \b
    beamcam machines keys
    beamcam machines keys --markdown > docs/machine-keys.md
    """
    if markdown:
        click.echo("# Keys of a machine file\n\nMade by `beamcam machines keys --markdown`.\n")
        click.echo("| key | value | default | meaning |\n| --- | --- | --- | --- |")
    for name, kind, default, meaning in machine_keys():
        shown = f"`{default}`" if default else "required"
        if markdown:
            click.echo(f"| `{name}` | {kind} | {shown} | {meaning.replace('|', chr(92) + '|')} |")
        else:
            click.echo(f"{name}\n    {kind}, {shown.strip('`')}; {meaning}".rstrip("; "))


@command.command("schema")
def schema() -> None:
    """Print the JSON schema of a machine file, by which an editor completes and checks it.

    \b
    beamcam machines schema > machine.schema.json
    """
    click.echo(json.dumps(machine_schema(), indent=1))
