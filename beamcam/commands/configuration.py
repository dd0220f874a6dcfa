"""A configuration file as the commands take it: read, and its words checked against what they know.

Apart from `settings`, so that a job without such a file pays nothing for it.
"""

import os.path
from collections.abc import Callable, Sequence
from typing import Any

from msgspec.structs import replace

from beamcam.asked import expected_job
from beamcam.config import rules
from beamcam.config.load import ConfigError, load
from beamcam.config.places import ConfigFiles, harmless, is_in, is_ones_own_place, not_followed
from beamcam.config.values import Config, merged
from beamcam.errors import Source
from beamcam.planning.rules import ALL_SKIPS, SKIP_NAMES, named_skips


def checked(files: ConfigFiles, trust: Sequence[str] = ()) -> Config:
    """The configuration that the files are together; `trust` are folders that are one's own too.

    Raises ConfigError.
    """
    if files.two:
        raise ConfigError(rules.TWO.at(Source(files.two[1]), found=files.two[0]))
    config = Config()
    for path in reversed(files.own):
        config = merged(config, _loaded(path))
    trusted = (*trust, *config.trust)
    for path in reversed(files.beside):
        near = _loaded(path)
        config = merged(config, near if is_in(path, trusted) else harmless(near))
    return config


def checked_again(files: ConfigFiles, trust: Sequence[str]) -> Config:
    """The configuration of a batch by the files that its record names.

    Raises ConfigError if a file that it followed in full is not trusted.
    """
    for path in files.own:
        if not_followed(_loaded(path)):
            refuse_strange(path, trust)
    return checked(files)


def refuse_strange(path: str, trust: Sequence[str]) -> None:
    """Raises ConfigError for a file that a record names and that is not trusted."""
    if not (is_ones_own_place(path) or is_in(path, trust)):
        folder = os.path.dirname(path) or os.curdir
        raise ConfigError(rules.NOT_REPEATED.at(Source(path), found=path, folder=folder))


def _loaded(path: str) -> Config:
    """The configuration in a file, its words checked. Raises ConfigError."""
    config = load(path)
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
    from beamcam.batch.names import TemplateError, check_template

    try:
        check_template(template)
    except TemplateError as error:
        return error.expected
    return ""


def _expected_skips(skips: Sequence[str]) -> str:
    known = (*SKIP_NAMES, ALL_SKIPS)
    return "" if set(skips) <= set(known) else f"names of {', '.join(known)}"


_CHECKS: dict[str, Callable[[Any], str]] = {
    "name": _expected_name,
    "job": expected_job,
    "allow_skips": _expected_skips,
}
