"""Checks of a stamp or printer: what it has, and the word that tells it a text."""

from collections.abc import Iterator

from beamcam.machine.faults import Fault
from beamcam.machine.machine import Machine

_LAST_ASCII = "~"
#: What the word with the text has to carry, and the key whose values it tells apart.
_CARRIED = (("height", "heights"), ("angle", "angles"), ("face", "faces"))


def marking_faults(machine: Machine) -> Iterator[Fault]:
    """Each key of a stamp or printer that is missing or contradicts another."""
    marks = machine.marks
    if not marks.is_told:
        return
    if machine.stock == "sheet":
        yield "marks.unit", marks.unit, "scribe, plasma or laser, which draw strokes, on a table"
        return
    if not marks.characters:
        yield "marks.characters", "", f"the characters that the {marks.unit} has"
    for sign in marks.characters:
        if not " " <= sign <= _LAST_ASCII:
            yield "marks.characters", sign, "printable characters of ASCII"
    if not marks.faces:
        yield "marks.faces", {}, f"the faces that the {marks.unit} comes to"
    elif not {*marks.faces} <= {*"vouh"}:
        yield "marks.faces", dict(marks.faces), "faces among v, o, u, h"
    elif len(set(marks.faces.values())) < len(marks.faces):
        yield "marks.faces", dict(marks.faces), "a number of its own for each face"
    if not marks.angles:
        yield "marks.angles", [], "at least one angle"
    yield from _place_faults(machine)
    yield from _word_faults(machine)


def _place_faults(machine: Machine) -> Iterator[Fault]:
    """A unit that the bar passes in the wrong order."""
    x, saw, layout = machine.marks.x, machine.saw, machine.layout
    if x is None or saw is None or layout is None:
        return
    if layout.order == "saw-drill" and x < saw.x:
        yield "marks.x", x, "at least saw.x, since the bar reaches the saw first"
    if layout.order == "drill-saw" and x > saw.x:
        yield "marks.x", x, "at most saw.x, or the part is cut off before"


def _word_faults(machine: Machine) -> Iterator[Fault]:
    """What is wrong with the template that tells the unit a text."""
    marks, key = machine.marks, f"words.{machine.marks.unit}"
    template = getattr(machine.words, marks.unit)
    telling = [line for line in template if "{string}" in line]
    if len(telling) != 1 or telling[0].count("{string}") != 1:
        yield key, list(template), "one line with {string}"
        return
    behind = telling[0].partition("{string}")[2][:1]
    if not behind or behind == "{" or behind in marks.characters:
        expected = "a character behind {string} that is not in marks.characters, such as a quote"
        yield key, telling[0], expected
    for name in ("y", *(name for name, _ in _CARRIED)):
        if telling[0].count("{" + name) > 1:
            yield key, telling[0], "{" + name + "} once"
    needed = ["y", *(name for name, of in _CARRIED if len(getattr(marks, of)) != 1)]
    for name in needed:
        if "{" + name + "}" not in telling[0]:
            yield key, telling[0], "{" + name + "} beside {string}"
    if not any("X{x}" in line for line in template if line not in telling):
        yield key, list(template), "a line before it with X{x}, which brings the bar there"
