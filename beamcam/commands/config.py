"""`beamcam config`: the configuration that holds, and where each value comes from."""

import json

import click

from beamcam.commands.common import stop
from beamcam.commands.running import settled
from beamcam.config import Setting
from beamcam.config.keys import KEYS
from beamcam.errors import BeamcamError


def shown(setting: Setting) -> str:
    """A setting as a line of a configuration file; one that is not set, as a comment."""
    if setting.value is None or setting.value == ():
        return f"# {setting.key} = "
    key = setting.key
    table, dot, name = key.partition(".")
    if dot and not name.replace("-", "").replace("_", "").isalnum():
        key = f"{table}.{json.dumps(name, ensure_ascii=False)}"
    return f"{key} = {json.dumps(setting.value, ensure_ascii=False)}"


@click.command("config")
@click.argument("inputs", nargs=-1, metavar="[IN]...")
@click.option("--config", "config_file", metavar="FILE", help="Instead of beamcam.toml.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
@click.option("--keys", is_flag=True, help="Print what keys there are, and what they are for.")
def command(inputs: tuple[str, ...], config_file: str | None, as_json: bool, keys: bool) -> None:
    """Show every value of the configuration that a job would have, and where it comes from.

    The configuration is the file given by --config, else the beamcam.toml beside the first IN,
    else the one in this folder. What stands on the command line goes over it.

    \b
    beamcam config
    beamcam config jobs/4711
    beamcam config --keys
    """
    if keys:
        width = max(map(len, KEYS))
        for name, key in KEYS.items():
            click.echo(f"{name:{width}}  {key.help}")
        return
    try:
        config = settled(config_file, inputs)
    except BeamcamError as error:
        stop(error.diagnostics, as_json)
    rows = config.settings()
    if as_json:
        record = {r.key: {"value": r.value, "source": r.source and str(r.source)} for r in rows}
        click.echo(json.dumps(record, ensure_ascii=False, indent=1))
        return
    width = max(len(shown(row)) for row in rows)
    for row in rows:
        click.echo(f"{shown(row):{width}}  # {row.source or 'default'}")
