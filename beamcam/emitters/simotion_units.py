"""The units of a trigger program: their names, and a program taken apart into them."""

import re
from zlib import crc32

UNIT_MARK = "(* ===== UNIT {name} ===== *)"
_MARK = re.compile(r"\(\* ===== UNIT (\w+) ===== \*\)")
MAX_NAME = 24


def unit_name(job: str) -> str:
    """An ASCII name for the units of a job: letters, digits and single underscores.

    What is too long ends in a check sum, so that two jobs that begin alike keep two names.
    """
    plain = re.sub(r"[^A-Za-z0-9]+", "_", job).strip("_")
    if len(plain) > MAX_NAME:
        plain = f"{plain[: MAX_NAME - 9].strip('_')}_{crc32(plain.encode()):08x}"
    return f"unit_{plain}" if plain else "unit_job"


def units(program: str) -> tuple[tuple[str, str], ...]:
    """Name and text of each unit of a program, the main one first."""
    pieces = _MARK.split(program)
    return tuple((pieces[k], pieces[k + 1].lstrip("\n")) for k in range(1, len(pieces), 2))


def split_units(program: str) -> tuple[tuple[str, str], ...]:
    """Name and text of each unit with its mark, so that joined files are the program again."""
    marks = list(_MARK.finditer(program))
    ends = [*(mark.start() for mark in marks[1:]), len(program)]
    return tuple(
        (mark[1], program[mark.start() : end]) for mark, end in zip(marks, ends, strict=True)
    )
