"""What the commands share: how they print messages and stop."""

from collections.abc import Iterable
from typing import NoReturn

import click

from beamcam.errors import Diagnostic
from beamcam.files import write_whole

REFUSED = 1  #: exit status if an input was refused


def say(diagnostics: Iterable[Diagnostic], as_json: bool = False) -> None:
    """Print messages on standard error, a line each, or as one JSON list."""
    if as_json:
        import json

        click.echo(json.dumps([as_record(d) for d in diagnostics], ensure_ascii=False), err=True)
    else:
        for said in diagnostics:
            click.echo(str(said), err=True)


def as_record(said: Diagnostic) -> dict[str, object]:
    """A message as data."""
    return {
        "file": said.source.file,
        "line": said.source.line,
        "where": said.source.where,
        "severity": said.severity.value,
        "code": said.code,
        "message": said.message,
    }


def stop(diagnostics: Iterable[Diagnostic], as_json: bool = False) -> NoReturn:
    """Print messages and end with the status of a refused input."""
    say(diagnostics, as_json)
    raise SystemExit(REFUSED)


def write(output: str, data: str | bytes | Iterable[bytes]) -> None:
    """Write to a file, whole or not at all, or to standard output for `-`."""
    if output == "-":
        for piece in (data,) if isinstance(data, str | bytes) else data:
            click.echo(piece, nl=False)
        return
    try:
        write_whole(output, data)
    except OSError as error:
        click.echo(f"{output}: cannot be written: {error.strerror or error}", err=True)
        raise SystemExit(REFUSED) from error
