"""`beamcam config`: the configuration that holds, and where each value comes from."""

import json
import os
from collections.abc import Mapping
from typing import Any, Literal, get_args, get_origin, get_type_hints

import click
from msgspec import Struct

from beamcam.commands import options
from beamcam.commands.common import Console, cannot_write, say_json, say_lines
from beamcam.commands.configuration import settings_line
from beamcam.commands.settings import settled
from beamcam.config.load import remember as remember_trust
from beamcam.config.values import CONFIG_NAME, ConfigFile, Setting, Stock
from beamcam.errors import BeamcamError
from beamcam.machine.machine import default_machines
from beamcam.system import user_folder


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
@click.option(
    "--remember", is_flag=True,
    help="Keep the folders of --trust in the user's own beamcam.toml.",
)  # fmt: skip
@click.option("--keys", is_flag=True, help="Print the keys and their meanings.")
def command(
    inputs: tuple[str, ...], as_json: bool, remember: bool, keys: bool, **values: Any
) -> None:
    """Show every value of the configuration that a job would have, and where it comes from.

    The configuration is the file given by --config, else every beamcam.toml beside IN and above,
    in this folder and above, and the user's own, key by key, the nearest first. Of those beside IN
    only what is harmless is followed, unless their folder is trusted. Options on the command line
    of the job override it.

    \b
    beamcam config
    beamcam config jobs/4711
    beamcam config --trust jobs --remember
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
    console, trust = Console(as_json=as_json), values["trust"]
    missing = [f"found no folder {one!r}; expected one that is there."
               for one in trust if not os.path.isdir(one)]  # fmt: skip
    options.refuse_usage(
        (remember and not trust, "found --remember without a folder; expected --trust FOLDER."),
        *((remember, text) for text in missing),
    )
    try:
        if remember:
            try:
                remember_trust(trust)
            except OSError as error:
                console.stop([cannot_write(os.path.join(user_folder(), CONFIG_NAME), error)])
        config = settled(values, inputs)
    except BeamcamError as error:
        console.stop(error.diagnostics)
    if config.remarks:
        console.say(config.remarks)
    rows = config.settings()
    stocks: tuple[Stock, ...] = ("beam", "sheet")
    machines = [
        n for stock in stocks for n in config.machine_names(stock) or default_machines(stock)
    ]
    try:
        used = settings_line(config, [*machines, *config.split])
    except BeamcamError as error:
        console.stop(error.diagnostics)
    if as_json:
        values = {r.key: {"value": r.value, "source": r.source and str(r.source)} for r in rows}
        say_json({**values, "settings": {"value": used, "source": None}})
        return
    width = max(len(shown(row)) for row in rows)
    say_lines(f"{shown(row):{width}}  # {row.source or 'default'}" for row in rows)
    say_lines([f"# {used}"])


def _rows(key: str) -> tuple[str, ...]:
    """The rows that the table of a key may have, as far as they have names."""
    from beamcam.conversion import plain

    kind = plain(get_type_hints(ConfigFile)[key])
    if isinstance(kind, type) and issubclass(kind, Struct):
        return kind.__struct_fields__
    rows = plain(get_args(kind)[0]) if get_origin(kind) is Mapping else None
    return get_args(rows) if get_origin(rows) is Literal else ()
