"""JSON as records, with messages that locate a value in the file."""

from typing import TypeVar

from msgspec import Struct

from beamcam.conversion import Fault, converted
from beamcam.errors import Diagnostic, ReadError, Rule, Source, error

Record = TypeVar("Record")

JSON_TYPE = error("json-type",
    "found {found}, expected {expected}",
    "A value is of another type than its key has.")  # fmt: skip
JSON_VALUE = error("json-value",
    "found {found}, expected {expected}",
    "A value lies outside what its key allows.")  # fmt: skip
JSON_KEY_MISSING = error("json-key-missing",
    "found no key {key!r}, expected {expected}",
    "Without the key the part is not known.")  # fmt: skip
JSON_KEY_UNKNOWN = error("json-key-unknown",
    "found key {key!r}, expected one of {expected}; nearest is {nearest!r}",
    "An unknown key could be a feature that would not be made, so it is refused.")  # fmt: skip

_SHOWN = 60  #: characters of a value that a message shows


def show(value: object) -> str:
    """`value` for a message, cut to a length that can be read."""
    from beamcam.conversion.diagnosis import shown

    text = shown(value)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."


class Place(Struct, frozen=True):
    """A value of a file, for messages: its path is as `contours[2].curves[0].arc.radius`."""

    file: str
    path: str = ""

    def at(self, *steps: str | int) -> "Place":
        """The place of a key or index below."""
        path = self.path
        for step in steps:
            path += f"[{step}]" if isinstance(step, int) else f".{step}" if path else step
        return Place(self.file, path)

    def diagnostic(self, rule: Rule, /, **values: object) -> Diagnostic:
        return rule.at(Source(self.file, None, self.path or "$"), **values)

    def fault(self, rule: Rule, /, **values: object) -> ReadError:
        return ReadError(self.diagnostic(rule, **values))

    def wrong(self, found: object, expected: str) -> ReadError:
        """Message for a value out of the range of its key."""
        return self.fault(JSON_VALUE, found=show(found), expected=expected)


def record_of(value: object, record: type[Record], place: Place) -> Record:
    """The record for a value of `json.loads`. Raises ReadError at the key that is wrong."""
    try:
        return converted(value, record)
    except Fault as fault:
        raise ReadError(_said(fault, place.at(*fault.path))) from None


def _said(fault: Fault, place: Place) -> Diagnostic:
    if fault.kind == "missing":
        return place.diagnostic(JSON_KEY_MISSING, key=fault.path[-1], expected="it, it is required")
    if fault.kind == "unknown":
        from difflib import get_close_matches

        (nearest,) = get_close_matches(str(fault.found), fault.known, 1, 0.0)
        expected = ", ".join(fault.known)
        return place.diagnostic(
            JSON_KEY_UNKNOWN, key=fault.found, expected=expected, nearest=nearest
        )
    rule = JSON_TYPE if fault.kind == "type" else JSON_VALUE
    expected = _JSON_WORDS.get(fault.expected, fault.expected)
    return place.diagnostic(rule, found=show(fault.found), expected=expected)


_JSON_WORDS = {"a table": "an object {...}", "a list": "a list [...]"}

JSON_OBJECT_RULES = (JSON_TYPE, JSON_VALUE, JSON_KEY_MISSING, JSON_KEY_UNKNOWN)
