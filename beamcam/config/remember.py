"""Folders that the user trusts for good: the key `trust` of the user's own configuration."""

import json
import os
import tomllib
from collections.abc import Sequence

from beamcam.config.load import load
from beamcam.config.places import CONFIG_NAME
from beamcam.files import write_whole
from beamcam.machine.toml import line_of, toml_text
from beamcam.system import user_folder

KEY = "trust"


def remember(folders: Sequence[str]) -> str:
    """Add folders to those that the user's own configuration trusts, and give its path.

    The rest of the file is kept. Raises ConfigError for a file that is no configuration, and
    OSError.
    """
    path = os.path.join(user_folder(), CONFIG_NAME)
    text = ""
    known: Sequence[str] = ()
    if os.path.exists(path):
        known = load(path).trust
        with open(path, "rb") as file:
            text = toml_text(file.read())
    every = tuple(dict.fromkeys((*known, *map(os.path.abspath, folders))))
    os.makedirs(os.path.dirname(path), exist_ok=True)
    write_whole(path, with_trust(text, every))
    return path


def with_trust(text: str, folders: Sequence[str]) -> str:
    """The text of a configuration with these folders as its `trust`, and nothing else changed."""
    line = f"{KEY} = {json.dumps(list(folders), ensure_ascii=False)}\n"
    table = tomllib.loads(text)
    if KEY not in table:
        return line + text
    rest = {key: value for key, value in table.items() if key != KEY}
    lines = text.splitlines(keepends=True)
    begin = (line_of(text, KEY) or 1) - 1
    for end in range(begin + 1, len(lines) + 1):  # the value may go on over several lines
        try:
            if tomllib.loads("".join(lines[:begin] + lines[end:])) == rest:
                return "".join([*lines[:begin], line, *lines[end:]])
        except tomllib.TOMLDecodeError:
            continue
    raise AssertionError("a key that stands in a text stands in one of its lines")
