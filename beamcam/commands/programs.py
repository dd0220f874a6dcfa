"""What the commands that read programs share."""

import click

from beamcam.commands.common import REFUSED


def read_program(path: str) -> str:
    """The text of a program, `-` for standard input; bytes that are no text become `\\ufffd`.

    Ends the process with the status of a refused input if the file cannot be read.
    """
    try:
        with click.open_file(path, "rb") as file:
            data: bytes = file.read()
    except OSError as error:
        click.echo(f"{path}: cannot be read: {error.strerror or error}", err=True)
        raise SystemExit(REFUSED) from error
    return data.decode("utf-8", "replace")


def shown_name(path: str) -> str:
    return "stdin" if path == "-" else path
