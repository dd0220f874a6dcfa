"""Checks of the templates of a program's blocks."""

import re
from collections.abc import Iterator
from string import Formatter

from beamcam.conversion import nearest
from beamcam.machine.faults import Fault
from beamcam.machine.machine import Machine
from beamcam.machine.words import PART_NAMES, WORD_NAMES

#: How a value may be set in a template; a greater width would fill the memory with blanks.
_FIELD_FORM = re.compile(r"[^{}]?[<>^]?[0-9]{0,2}")
_COMMENT = re.compile(r"\([^()]*\)")
#: What the head of a program cannot say, by what it is for.
_NOT_SAID = {
    "beam": frozenset[str](),
    "sheet": frozenset({"section", "width", "height"}),
    "profile": frozenset({"section"}),
}


def template_faults(machine: Machine) -> Iterator[Fault]:
    """Each template that names what it cannot, or gives a value a form that it must not have.

    Decimals are those of [format], so that a program is read back as it was rounded.
    """
    for key, names in WORD_NAMES.items():
        if key == "header":
            names = names - _NOT_SAID[machine.stock]
        elif machine.stock == "sheet":
            names = names - {"z", "a", "inverse"} if key in ("traverse", "feed") else names
        template = getattr(machine.words, key)
        for line in (template,) if isinstance(template, str) else template:
            for found, expected in _line_faults(line, names):
                yield f"words.{key}", found, expected
            if machine.stock != "beam" and key != "header":
                yield from _outside_comments(f"words.{key}", line)


def _outside_comments(key: str, line: str) -> Iterator[Fault]:
    """Data of a part that would be a figure of a table's program: nothing says which is right."""
    for _, name, _, _ in Formatter().parse(_COMMENT.sub("", line)):
        if name in PART_NAMES:
            yield key, "{" + name + "}", "it in a comment, between ( and )"


def _line_faults(line: str, names: frozenset[str]) -> Iterator[tuple[str, str]]:
    try:
        fields = [field for field in Formatter().parse(line) if field[1] is not None]
    except ValueError as error:
        yield line, f"a template: {error}"
        return
    for _, name, form, conversion in fields:
        if name not in names:
            yield "{" + str(name) + "}", nearest(str(name), names)
        elif conversion or not _FIELD_FORM.fullmatch(form or ""):
            yield line, "{" + name + "}, or with a width of two digits, such as {" + name + ":>8}"
