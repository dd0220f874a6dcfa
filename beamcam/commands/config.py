"""`beamcam config`: the configuration that holds, and where each value comes from."""

import json
from collections.abc import Mapping
from typing import Any, Literal, get_args, get_origin, get_type_hints

import click
from msgspec import Struct

from beamcam.commands import options
from beamcam.commands.common import Voice, say_json, say_lines
from beamcam.commands.settings import settled
from beamcam.config.values import ConfigFile, Setting
from beamcam.errors import BeamcamError


def shown(setting: Setting) -> str:
    """A setting as a line of a configuration file; one that is not set, as a comment."""
    if setting.value is None or setting.value == ():
        return f"# {setting.key} = "
    key = setting.key
    table, dot, name = key.partition(".")
    if dot and not name.replace("-", "").replace("_", "").isalnum():
        key = f"{table}.{json.dumps(name, ensure_ascii=False)}"
    if isinstance(setting.value, dict):
        rows = (f"{name} = {json.dumps(value)}" for name, value in setting.value.items())
        return f"{key} = {{ {', '.join(rows)} }}"
    return f"{key} = {json.dumps(setting.value, ensure_ascii=False)}"


@click.command("config")
@click.argument("inputs", nargs=-1, metavar="[IN]...", type=options.FILE)
@options.config
@options.as_json
@click.option("--keys", is_flag=True, help="Print the keys and their meanings.")
def command(inputs: tuple[str, ...], as_json: bool, keys: bool, **asked: Any) -> None:
    """Show every value of the configuration that a job would have, and where it comes from.

    The configuration is the file given by --config, else the beamcam.toml beside IN or in the
    nearest folder above, else that of this folder or above, else the user's own. Options on the
    command line of the job override it.

    \b
    beamcam config
    beamcam config jobs/4711
    beamcam config --keys
    """
    if keys:
        from beamcam.conversion.schema import documented

        known = documented(ConfigFile)
        width = max(map(len, known))
        for name, (_, help) in known.items():
            names = ", ".join(_rows(name))
            say_lines([f"{name:{width}}  {help}{': ' if names else ''}{names}"])
        return
    try:
        config = settled(asked, inputs)
    except BeamcamError as error:
        Voice(as_json=as_json).stop(error.diagnostics)
    rows = config.settings()
    if as_json:
        say_json({r.key: {"value": r.value, "source": r.source and str(r.source)} for r in rows})
        return
    width = max(len(shown(row)) for row in rows)
    say_lines(f"{shown(row):{width}}  # {row.source or 'default'}" for row in rows)


def _rows(key: str) -> tuple[str, ...]:
    """The rows that the table of a key may have, as far as they have names."""
    from beamcam.conversion.diagnosis import plain

    kind = plain(get_type_hints(ConfigFile)[key])
    if isinstance(kind, type) and issubclass(kind, Struct):
        return kind.__struct_fields__
    rows = plain(get_args(kind)[0]) if get_origin(kind) is Mapping else None
    return get_args(rows) if get_origin(rows) is Literal else ()
