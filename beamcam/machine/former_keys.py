"""Renamed keys of machine files: still read for one minor version, with a warning.

`least_x` became `min_x` and `greatest_x` became `max_x`, the words of the field.
"""

import re
from typing import Any

_FORMER = re.compile(r"^(least|greatest)(_|$)")
_PRESENT = {"least": "min", "greatest": "max"}
_WAS = re.compile(r"^(min|max)(_|$)")
_FORMERLY = {present: former for former, present in _PRESENT.items()}
#: Tables whose keys are names that the user chooses.
_FREE = frozenset({"sections", "colours", "names", "default_for"})


class KeyTwice(ValueError):
    """A table has a key under both its former and its present name."""

    def __init__(self, former: str, present: str) -> None:
        super().__init__(former)
        self.former, self.present = former, present


def present_name(key: str) -> str:
    """The name of a key in this version."""
    return _FORMER.sub(lambda found: _PRESENT[found[1]] + found[2], key, count=1)


def former_name(dotted: str) -> str:
    """A dotted key as it was called in the version before."""
    table, dot, key = dotted.rpartition(".")
    was = _WAS.sub(lambda found: _FORMERLY[found[1]] + found[2], key, count=1)
    return f"{table}{dot}{was}"


def with_present_keys(table: dict[str, Any]) -> tuple[dict[str, Any], list[tuple[str, str]]]:
    """The table with its keys as this version names them, and (former, present) for each renamed.

    Former keys are dotted, as `axes.0.least`. Raises KeyTwice where both names stand in one table.
    """
    renamed: list[tuple[str, str]] = []
    return _table(table, "", renamed), renamed


def _table(table: dict[str, Any], prefix: str, renamed: list[tuple[str, str]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in table.items():
        name = present_name(key) if _FORMER.match(key) else key
        if name != key:
            if name in table:
                raise KeyTwice(prefix + key, prefix + name)
            renamed.append((prefix + key, name))
        found[name] = value if key in _FREE else _value(value, f"{prefix}{key}.", renamed)
    return found


def _value(value: Any, prefix: str, renamed: list[tuple[str, str]]) -> Any:
    if isinstance(value, dict):
        return _table(value, prefix, renamed)
    if isinstance(value, list):
        return [_value(item, f"{prefix}{k}.", renamed) for k, item in enumerate(value)]
    return value
