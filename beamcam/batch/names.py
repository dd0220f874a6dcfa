"""The names of a batch's outputs: from a template, and no two alike.

    "{mark}_{quantity}.gcode"      M58_4.gcode
    "{profile}/{mark}{suffix}"     IPE300/M58.gcode: a slash of the template makes a folder

Without a template an output is called after its input, and where that holds several parts, after
the part's mark too.
"""

import re
import unicodedata
from collections.abc import Mapping
from string import Formatter

from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.system import free_of_devices

_FORM = re.compile(r"[^{}]?[<>^]?[0-9]{0,2}[sd]?")  #: of a value in a name
_NOT_IN_NAMES = frozenset('<>:"|?*\\')  #: which Windows has for something else
MOST_LETTERS = 80  #: as DSTV has it; a name of 255 bytes holds two such in most alphabets
#: Placeholders of a template, each with a sample value.
FIELDS: Mapping[str, str | int] = {
    "stem": "M58",  # the input's name without its suffix
    "mark": "M58",
    "quantity": 4,
    "number": 1,  # of the part in its file, from 1
    "profile": "IPE300",
    "grade": "S355",
    "order": "1",
    "drawing": "1",
    "phase": "1",
    "machine": "beamline",
    "suffix": ".gcode",  # the machine's
}


class TemplateError(ValueError):
    """A template that no output can be called after, and what was expected."""

    def __init__(self, found: str, expected: str) -> None:
        self.expected = expected
        super().__init__(f"found {found}; expected {expected}")


def check_template(template: str) -> None:
    """Raises TemplateError if no output can be called after a template."""
    try:
        for _, name, form, _ in Formatter().parse(template):
            if name is None:
                continue
            if not _FORM.fullmatch(form or ""):
                raise TemplateError(repr(template), "widths of two digits at most")
            if name not in FIELDS:
                known = ", ".join("{" + field + "}" for field in FIELDS)
                raise TemplateError(f"{{{name}}} in {template!r}", f"one of {known}")
        made = template.format_map(FIELDS)
    except TemplateError:
        raise
    except (IndexError, KeyError, AttributeError, ValueError) as error:
        raise TemplateError(repr(template), f"a template ({error})") from error
    if made.startswith("/") or not _NOT_IN_NAMES.isdisjoint(made):
        raise TemplateError(repr(template), "a path below the output folder")
    if not all(word.strip(". ") and word[-1] not in ". " for word in made.split("/")):
        raise TemplateError(repr(template), "names between the slashes")


def cleaned(text: str) -> str:
    """`text` as a part of a file's name: letters, digits and `-_.+`, everything else as `_`.

    Of a longer one than any system takes the beginning.
    """
    return "".join(c if c.isalnum() or c in "-_.+" else "_" for c in text[:MOST_LETTERS]).strip(".")


def output_name(
    template: str | None, stem: str, part: Part, number: int, several: bool, machine: Machine
) -> str:
    """Output name of a part, below the folder of its input.

    `number` counts the parts of the file from 1, `several` says whether there are more.
    """
    mark = cleaned(part.mark) or "part"
    if template is None:
        return free_of_devices((f"{stem}_{mark}" if several else stem) + machine.suffix)
    values: dict[str, str | int] = {
        "stem": stem,
        "mark": mark,
        "quantity": part.quantity,
        "number": number,
        "profile": cleaned(part.profile.name) or part.profile.code,
        "grade": cleaned(part.grade) or "_",
        "order": cleaned(part.order) or "_",
        "drawing": cleaned(part.drawing) or "_",
        "phase": cleaned(part.phase) or "_",
        "machine": cleaned(machine.name),
        "suffix": machine.suffix,
    }
    return "/".join(map(free_of_devices, template.format_map(values).split("/")))


class FileNames:
    """Names of files that were given out, no two of which read the same on any system."""

    def __init__(self) -> None:
        self._owners: dict[str, str] = {}
        self._last: dict[str, int] = {}  #: number given last, by the name that was wanted

    def owner(self, name: str) -> str | None:
        """The mark of the part that has the name; None where it is free."""
        return self._owners.get(folded(name))

    def take(self, name: str, mark: str) -> str:
        """Give out `name`, with -2, -3, ... before its suffix if one that reads the same is."""
        wanted = folded(name)
        stem, dot, suffix = name.rpartition(".")
        count = self._last.get(wanted, 1)
        while folded(name) in self._owners:
            count += 1
            name = f"{stem}-{count}{dot}{suffix}"
        self._last[wanted] = count
        self._owners[folded(name)] = mark
        return name


def folded(name: str) -> str:
    """Key that two names share if they are one file on any system."""
    return unicodedata.normalize("NFC", name).casefold()
