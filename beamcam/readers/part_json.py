"""The reader of the JSON form of parts: a file of one part, `beamcam/part/1`."""

import json
import re
from typing import Any

from beamcam.errors import ReadError, Rule, Severity, Source
from beamcam.model.part_from_json import JSON_PART_RULES, part_from_json
from beamcam.model.part_json import PART_SCHEMA
from beamcam.plain_text import fault_text, whole_text
from beamcam.readers.polynomials import checked_polynomials
from beamcam.readers.reading import Reading

JSON_SYNTAX = Rule(
    "json-syntax",
    Severity.ERROR,
    "found {found}, expected JSON",
    "The file is not JSON, so nothing in it can be read.",
)
JSON_KEY_TWICE = Rule(
    "json-key-twice",
    Severity.ERROR,
    "found key {key!r} twice in one object, expected it once",
    "One of the two values would be lost silently.",
)

RULES = (JSON_SYNTAX, JSON_KEY_TWICE, *JSON_PART_RULES)


class _KeyTwice(ValueError):
    """An object with a key that is there twice."""


def looks_like(data: bytes) -> bool:
    """Whether the bytes are a JSON object that names the schema of parts or has its main keys."""
    start = data[:4000].lstrip(b"\xef\xbb\xbf \t\r\n")
    return start.startswith(b"{") and (
        PART_SCHEMA.encode() in start or (b'"mark"' in data and b'"profile"' in data)
    )


def read(data: bytes, name: str) -> Reading:
    """The part of a JSON file; never raises."""
    try:
        value = json.loads(
            data.decode("utf-8-sig"), object_pairs_hook=_unique, parse_constant=_refuse_constant
        )
        if _HALF.search(data):
            value = _whole(value)
    except _KeyTwice as error:
        return Reading("part-json", (), (JSON_KEY_TWICE.at(Source(name), key=str(error)),))
    except json.JSONDecodeError as error:
        found = f"{error.msg} in column {error.colno}"
        return Reading("part-json", (), (JSON_SYNTAX.at(Source(name, error.lineno), found=found),))
    except UnicodeDecodeError as error:
        found = f"bytes that are no UTF-8 at {error.start}"
        return Reading("part-json", (), (JSON_SYNTAX.at(Source(name), found=found),))
    except (RecursionError, ValueError) as error:
        return Reading("part-json", (), (JSON_SYNTAX.at(Source(name), found=fault_text(error)),))
    try:
        part = part_from_json(value, name)
    except ReadError as error:
        return Reading("part-json", (), error.diagnostics)
    return Reading("part-json", (part,), tuple(checked_polynomials(part)))


#: What half of a character is written as, which no file takes afterwards.
_HALF = re.compile(rb"\\u[dD][89a-fA-F]")


def _whole(value: Any) -> Any:
    """A value whose texts hold no half of a character."""
    if isinstance(value, dict):
        return {whole_text(key): _whole(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_whole(item) for item in value]
    return whole_text(value) if isinstance(value, str) else value


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        raise _KeyTwice(next(key for key in keys if keys.count(key) > 1))
    return found


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name}, which is no number")
