"""Typed access to JSON objects whose errors say where in the file they are.

A place is written as a path: `contours[2].curves[0].arc.radius`.
"""

from collections.abc import Callable, Collection, Iterable
from typing import TypeVar

from beamcam.errors import Diagnostic, ReadError, Rule, Severity, Source
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.plain_text import whole_text

T = TypeVar("T")

JSON_TYPE = Rule(
    "json-type",
    Severity.ERROR,
    "found {found}, expected {expected}",
    "A value is of another type than its key has.",
)
JSON_VALUE = Rule(
    "json-value",
    Severity.ERROR,
    "found {found}, expected {expected}",
    "A value lies outside what its key allows.",
)
JSON_KEY_MISSING = Rule(
    "json-key-missing",
    Severity.ERROR,
    "found no key {key!r}, expected {expected}",
    "Without the key the part is not known.",
)
JSON_KEY_UNKNOWN = Rule(
    "json-key-unknown",
    Severity.ERROR,
    "found key {key!r}, expected one of {expected}; nearest is {nearest!r}",
    "A key that nobody reads is a feature that nobody makes, so a misspelt one is refused.",
)

#: A part reaches from one end of all coordinates to the other at most.
MAX_NUMBER = 10 * MAX_COORDINATE
_SHOWN = 60  #: characters of a value that a message shows


def show(value: object) -> str:
    """`value` for a message, cut to a length that can be read."""
    text = repr(value)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."


class JsonObject:
    """One JSON object at a path; each key is asked for once and `finish` refuses the others."""

    def __init__(self, value: object, path: str, file: str) -> None:
        self.path = path
        self.file = file
        if not isinstance(value, dict):
            raise self.fault(JSON_TYPE, "", found=show(value), expected="an object {...}")
        self._value: dict[str, object] = value
        self._asked: dict[str, None] = {}

    def __contains__(self, key: str) -> bool:
        return key in self._value

    def at(self, key: str) -> str:
        """The path of `key` in this object."""
        return f"{self.path}.{key}" if self.path and key else self.path or key

    def diagnostic(self, rule: Rule, key: str, /, **values: object) -> Diagnostic:
        return rule.at(Source(self.file, None, self.at(key) or "$"), **values)

    def fault(self, rule: Rule, key: str, /, **values: object) -> ReadError:
        return ReadError(self.diagnostic(rule, key, **values))

    def raw(self, key: str) -> object:
        """The value of `key`, None if it is not there."""
        self._asked[key] = None
        return self._value.get(key)

    def _required(self, key: str, expected: str) -> object:
        value = self.raw(key)
        if key not in self._value:
            raise self.fault(JSON_KEY_MISSING, key, key=key, expected=expected)
        return value

    def text(self, key: str, default: str | None = None) -> str:
        """A text; `default` where the key is not there, which None forbids."""
        if default is not None and key not in self._value:
            self._asked[key] = None
            return default
        value = self._required(key, "a text")
        if not isinstance(value, str):
            raise self.fault(JSON_TYPE, key, found=show(value), expected="a text")
        return whole_text(value)

    def text_or_none(self, key: str) -> str | None:
        """A text, or None where the key is null or not there."""
        return None if self.raw(key) is None else self.text(key)

    def number(self, key: str, default: float | None = None) -> float:
        """A finite number; `default` where the key is not there, which None forbids."""
        if default is not None and key not in self._value:
            self._asked[key] = None
            return default
        return self.as_number(self._required(key, "a number"), key)

    def number_or_none(self, key: str) -> float | None:
        """A number, or None where the key is null or not there."""
        return None if self.raw(key) is None else self.number(key)

    def positive(self, key: str) -> float:
        """A number above 0."""
        value = self.number(key)
        if value <= 0:
            raise self.fault(JSON_VALUE, key, found=show(value), expected="a number above 0")
        return value

    def integer(self, key: str, default: int | None = None) -> int:
        """A whole number; `default` where the key is not there, which None forbids."""
        if default is not None and key not in self._value:
            self._asked[key] = None
            return default
        value = self._required(key, "a whole number")
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.fault(JSON_TYPE, key, found=show(value), expected="a whole number")
        if abs(value) > MAX_NUMBER:
            expected = f"a whole number between -{MAX_NUMBER:g} and {MAX_NUMBER:g}"
            raise self.fault(JSON_VALUE, key, found=show(value), expected=expected)
        return value

    def boolean(self, key: str, default: bool) -> bool:
        """True or false."""
        value = self.raw(key)
        if key not in self._value:
            return default
        if not isinstance(value, bool):
            raise self.fault(JSON_TYPE, key, found=show(value), expected="true or false")
        return value

    def choice(self, key: str, options: Collection[str], default: str | None = None) -> str:
        """One of some words."""
        value = self.text(key, default)
        if value not in options:
            expected = "one of " + " ".join(option or "''" for option in options)
            raise self.fault(JSON_VALUE, key, found=show(value), expected=expected)
        return value

    def as_number(self, value: object, key: str) -> float:
        """`value` as a finite number; `key` is its place."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.fault(JSON_TYPE, key, found=show(value), expected="a number")
        try:
            result = float(value)
        except OverflowError:
            result = float("inf")
        if not abs(result) <= MAX_NUMBER:  # nan is above all
            expected = f"a number between -{MAX_NUMBER:g} and {MAX_NUMBER:g}"
            raise self.fault(JSON_VALUE, key, found=show(value), expected=expected)
        return result

    def numbers(self, key: str, count: int | None = None) -> tuple[float, ...]:
        """A list of numbers, of `count` ones where that is given."""
        return self.as_numbers(self._required(key, "a list of numbers"), key, count)

    def as_numbers(self, value: object, key: str, count: int | None = None) -> tuple[float, ...]:
        """`value` as a list of numbers."""
        expected = f"a list of {count} numbers" if count else "a list of numbers"
        if not isinstance(value, list) or (count is not None and len(value) != count):
            raise self.fault(JSON_TYPE, key, found=show(value), expected=expected)
        return tuple(self.as_number(v, f"{key}[{i}]") for i, v in enumerate(value))

    def point(self, key: str) -> tuple[float, float]:
        """A point [x, y]."""
        x, y = self.numbers(key, 2)
        return x, y

    def vector(self, key: str) -> tuple[float, float, float]:
        """A point or direction [x, y, z]."""
        x, y, z = self.numbers(key, 3)
        return x, y, z

    def points(self, key: str, least: int = 2) -> tuple[tuple[float, float], ...]:
        """A list of `least` points or more."""
        found = []
        for i, value in enumerate(self.items(key)):
            x, y = self.as_numbers(value, f"{key}[{i}]", 2)
            found.append((x, y))
        if len(found) < least:
            expected = f"{least} points or more"
            raise self.fault(JSON_VALUE, key, found=f"{len(found)} points", expected=expected)
        return tuple(found)

    def items(self, key: str) -> list[object]:
        """A list; an empty one where the key is not there."""
        value = self.raw(key)
        if key not in self._value:
            return []
        if not isinstance(value, list):
            raise self.fault(JSON_TYPE, key, found=show(value), expected="a list [...]")
        return value

    def child(self, key: str) -> "JsonObject":
        """The object under `key`."""
        return JsonObject(self._required(key, "an object {...}"), self.at(key), self.file)

    def children(self, key: str, read: "Callable[[JsonObject], T]") -> tuple[T, ...]:
        """Each object of the list under `key`, read and checked for unknown keys."""
        found = []
        for i, value in enumerate(self.items(key)):
            child = JsonObject(value, f"{self.at(key)}[{i}]", self.file)
            found.append(read(child))
            child.finish()
        return tuple(found)

    def ignore(self, keys: Iterable[str]) -> None:
        """Allow `keys`, whose values are computed and not read."""
        self._asked.update(dict.fromkeys(keys))

    def finish(self) -> None:
        """Refuse the keys that nobody asked for."""
        for key in self._value:
            if key not in self._asked:
                from difflib import get_close_matches

                known = list(self._asked)
                nearest = get_close_matches(key, known, 1, 0.0)
                expected = ", ".join(known)
                raise self.fault(
                    JSON_KEY_UNKNOWN, key, key=key, expected=expected, nearest=(nearest or [""])[0]
                )


JSON_OBJECT_RULES = (JSON_TYPE, JSON_VALUE, JSON_KEY_MISSING, JSON_KEY_UNKNOWN)
