"""The names of a batch's outputs: from a template, and no two alike.

    "{mark}_{quantity}.gcode"      M58_4.gcode
    "{profile}/{mark}{suffix}"     IPE300/M58.gcode: a slash of the template makes a folder

Without a template an output is called after its input, and where that holds several parts, after
the part's mark too.
"""

import os
import re
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from string import Formatter

from beamcam.batch import OTHER_CONTENT
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.part_json import part_to_json
from beamcam.model.request import MarkFrom
from beamcam.system import EndRequest, free_of_devices

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


def template_fault(template: str) -> tuple[str, str] | None:
    """What of a template no output can be called after, and what is expected; None if one can."""
    try:
        for _, name, form, _ in Formatter().parse(template):
            if name is None:
                continue
            if not _FORM.fullmatch(form or ""):
                return repr(template), "widths of two digits at most"
            if name not in FIELDS:
                known = ", ".join("{" + field + "}" for field in FIELDS)
                return f"{{{name}}} in {template!r}", f"one of {known}"
        made = template.format_map(FIELDS)
    except (IndexError, KeyError, AttributeError, ValueError) as error:
        return repr(template), f"a template ({error})"
    if made.startswith("/") or not _NOT_IN_NAMES.isdisjoint(made):
        return repr(template), "a path below the output folder"
    if not all(word.strip(". ") and word[-1] not in ". " for word in made.split("/")):
        return repr(template), "names between the slashes"
    return None


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
        "stem": stem, "mark": mark, "quantity": part.quantity, "number": number,
        "profile": cleaned(part.profile.name) or part.profile.code,
        "grade": cleaned(part.grade) or "_", "order": cleaned(part.order) or "_",
        "drawing": cleaned(part.drawing) or "_", "phase": cleaned(part.phase) or "_",
        "machine": cleaned(machine.name), "suffix": machine.suffix,
    }  # fmt: skip
    return "/".join(map(free_of_devices, template.format_map(values).split("/")))


def stage_names(
    template: str | None, stem: str, part: Part, number: int, several: bool, machine: Machine,
    place: int, rest_suffix: str,
) -> tuple[str, str]:  # fmt: skip
    """Names of the program that makes a part at a `place` among others, and of what it leaves.

    As M58-1-beamline.gcode and M58-1-rest.nc1; by a template as it says, the place before the
    suffix. Place 0 is that of a program that makes the part by itself: its name as any, and none.
    """
    name = output_name(template, stem, part, number, several, machine)
    if not place:
        return name, ""
    root = name.removesuffix(machine.suffix)
    of_machine = f"-{cleaned(machine.name)}" if template is None else ""
    suffix = name[len(root) :]
    if not suffix and "." in root:  # the template ends otherwise
        root, suffix = os.path.splitext(name)
    return f"{root}-{place}{of_machine}{suffix}", f"{root}-{place}-rest{rest_suffix}"


class FileNames:
    """Names of files that were given out, no two of which read the same on any system."""

    def __init__(self) -> None:
        self._owners: dict[str, str] = {}
        self._last: dict[str, int] = {}  #: number given last, by the name without it

    def owner(self, name: str) -> str | None:
        """The mark of the part that has the name; None where it is free."""
        return self._owners.get(folded(name))

    def take(self, name: str, mark: str) -> str:
        """Give out `name`, with -2, -3, ... before its suffix if one that reads the same is."""
        key = folded(name)
        stem, dot, suffix = name.rpartition(".")
        count = self._last.get(key, 1)
        while folded(name) in self._owners:
            count += 1
            name = f"{stem}-{count}{dot}{suffix}"
        self._last[key] = count
        self._owners[folded(name)] = mark
        return name


def folded(name: str) -> str:
    """Key that two names share if they are one file on any system."""
    return unicodedata.normalize("NFC", name).casefold()


# --- marks that two parts of one order have, though they differ -----------------------------------

#: Keys that say where a part, or something of it, comes from or is listed.
_NO_CONTENT = frozenset({
    "source", "line", "feature", "quantity", "guid", "order", "drawing", "phase", "notes", "info",
    "comments", "file",
})  # fmt: skip

DSTV_SUFFIXES = (".nc", ".nc1")
HEAD_BYTES = 4096  #: in which a DSTV file says its order and mark
MarkKey = tuple[str, str, str]  #: order, phase and mark


def mark_key(part: Part) -> MarkKey:
    """What stands for one part: its mark, within its order and a phase of it."""
    return part.order, part.phase, part.mark


def other_content(parts: Sequence[Part]) -> Iterator[Diagnostic]:
    """An error for each part whose mark another part of its order has with another content.

    Two that differ under one mark would be mixed up on the floor.
    """
    first: dict[MarkKey, Part] = {}
    for part in parts:
        known = first.setdefault(mark_key(part), part) if part.mark else part
        if known is not part and _content(part_to_json(known)) != _content(part_to_json(part)):
            where = f" in order {part.order}" if part.order else ""
            yield OTHER_CONTENT.at(part.source, found=part.mark, where=where, other=known.source)


def mixed_marks(
    paths: Iterable[str], mark_from: MarkFrom, parts_of: Callable[[str], Sequence[Part]],
    interrupt: EndRequest,
) -> dict[str, Diagnostic]:  # fmt: skip
    """The DSTV files that differ from another one under their mark, and why.

    The first lines of each tell which to compare: `parts_of` reads those alone. What says its mark
    elsewhere shows when it is read.
    """
    met: dict[MarkKey, list[str]] = {}
    for path in paths:
        if interrupt:
            return {}
        # A pipe would wait for what somebody writes.
        if not path.lower().endswith(DSTV_SUFFIXES) or not os.path.isfile(path):
            continue
        with suppress(OSError), open(path, "rb", buffering=0) as file:
            texts = map(str.strip, file.read(HEAD_BYTES).decode("latin-1").splitlines())
            lines = [text for text in texts if not text.startswith("**")]
            at = lines.index("ST") + 1 if "ST" in lines else len(lines)
            order, drawing, phase, mark = [*lines[at : at + 4], "", "", "", ""][:4]
            stem = os.path.splitext(os.path.basename(path))[0]
            fields = {"drawing": drawing, "file": stem, "position": phase}
            mark = fields.get(mark_from) or mark
            if mark:
                met.setdefault((order, phase, mark), []).append(path)
    by_mark: dict[str, Diagnostic] = {}
    for several in met.values():
        parts = [part for path in several if len(several) > 1 for part in parts_of(path)]
        for other in (*other_content(parts), *other_content(parts[::-1])):
            by_mark.setdefault(other.source.file, other)
    return by_mark


def _content(value: object) -> object:
    """Content of a part as JSON, without its source."""
    if isinstance(value, dict):
        return {key: _content(v) for key, v in value.items() if key not in _NO_CONTENT}
    if isinstance(value, list | tuple):
        return [_content(item) for item in value]
    return value
