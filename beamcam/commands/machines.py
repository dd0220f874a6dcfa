"""`beamcam machines`: which machines there are, and where their values come from."""

import json

import click

from beamcam.commands import options
from beamcam.commands.common import Voice, say_json, say_lines
from beamcam.controllers.machine_words import load_machine
from beamcam.errors import BeamcamError
from beamcam.machine import load, settings, shipped


@click.group("machines")
def command() -> None:
    """List the machines, or show one with all its values.

    A machine is a TOML file. A file of your own may start from a shipped one by a line such as
    `base = "beamline"` and is named by its path, as in --machine ./mine.toml.

    \b
    beamcam machines list
    beamcam machines show beamline
    beamcam machines keys
    beamcam machines schema
    """


@command.command("list")
@options.as_json
def list_machines(as_json: bool) -> None:
    """Print the name, the controller and the title of every shipped machine.

    \b
    beamcam machines list
    beamcam machines list --json
    """
    machines = [load(name) for name in shipped()]
    if as_json:
        rows = [{"name": m.name, "controller": m.controller, "title": m.title} for m in machines]
        say_json(rows)
        return
    width = max(len(m.name) for m in machines)
    say_lines(f"{m.name:{width}}  {m.controller:10}  {m.title}" for m in machines)


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
        rows, machine = settings(name), load_machine(name)
    except BeamcamError as error:
        Voice(as_json=as_json).stop(error.diagnostics)
    Voice(as_json=as_json).say(machine.remarks)
    if as_json:
        record = {r.key: {"value": r.value, "source": r.source and str(r.source)} for r in rows}
        say_json(record)
        return
    width = max(len(r.key) for r in rows)
    for row in rows:
        shown = json.dumps(row.value, ensure_ascii=False)
        say_lines([f"{row.key:{width}} = {shown}  # {row.source or 'default'}"])


@command.command("keys")
@click.option("--markdown", is_flag=True, help="Print a page for the documentation.")
def keys(markdown: bool) -> None:
    """List every key that a machine file may have, with its meaning.

    \b
    beamcam machines keys
    beamcam machines keys --markdown > docs/machine-keys.md
    """
    from beamcam.machine.keys import machine_keys

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
    from beamcam.machine.schema import machine_schema

    click.echo(json.dumps(machine_schema(), indent=1))
