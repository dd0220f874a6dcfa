"""A configuration file as the commands take it: read, and its words checked against what they know.

Apart from `settings`, so that a job without such a file pays nothing for it.
"""

from collections.abc import Callable, Sequence
from typing import Any

from msgspec.structs import replace

from beamcam.config import rules
from beamcam.config.load import ConfigError, load
from beamcam.config.values import Config
from beamcam.errors import Source
from beamcam.plain_text import terminal_text
from beamcam.planning.rules import ALL_SKIPS, SKIP_NAMES, named_skips


def checked(files: Sequence[str]) -> Config:
    """The configuration of a job that lies beside `files`, of which there may be one only.

    Raises ConfigError.
    """
    first, *others = files
    if others:
        raise ConfigError(rules.TWO.at(Source(others[0]), found=first))
    config = load(first)
    for key, check in _CHECKS.items():
        value = getattr(config, key)
        if value and (expected := check(value)):
            found = repr(value) if isinstance(value, str) else ", ".join(map(repr, value))
            said = rules.WRONG_VALUE.at(
                config.sources[key], key=key, found=found, expected=expected
            )
            raise ConfigError(said)
    return replace(config, allow_skips=named_skips(config.allow_skips))


def _expected_name(template: str) -> str:
    """The expected form of an invalid name template; "" if it is valid."""
    from beamcam.batch.names import check_template

    try:
        check_template(template)
    except ValueError as error:
        return str(error).partition("; expected ")[2] or f"a template ({error})"
    return ""


def _expected_job(name: str) -> str:
    return "" if terminal_text(name) == name else "one line of printable characters"


def _expected_skips(skips: Sequence[str]) -> str:
    known = (*SKIP_NAMES, ALL_SKIPS)
    return "" if set(skips) <= set(known) else f"names of {', '.join(known)}"


_CHECKS: dict[str, Callable[[Any], str]] = {
    "name": _expected_name,
    "job": _expected_job,
    "allow_skips": _expected_skips,
}
