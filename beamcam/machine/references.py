"""Checks of what one table of a machine file names in another: spindles, faces, axes, processes."""

import re
from collections.abc import Iterator, Set
from typing import get_args

from beamcam.machine.machine import Machine
from beamcam.machine.stations import Pair, Spindle
from beamcam.machine.torch import TorchProcess
from beamcam.machine.words import signed

Fault = tuple[str, object, str]  #: dotted key, what was found, what was expected

ACROSS = ("Y", "Z")  #: letters of a spindle's axes
OF_SAW = ("angle", "saw")  #: what only a saw has an axis for


def reference_faults(machine: Machine, left_behind: Set[str] = frozenset()) -> Iterator[Fault]:
    """Each key that names an entry of another table that is not there.

    Axes of a base stay in their registers where a file over it takes their station away:
    `left_behind` has `spindles` or `saw` for them.
    """
    yield from _axis_faults(machine, left_behind)
    yield from _tool_faults(machine)
    yield from _carrier_faults(machine)
    yield from _look_faults(machine)
    if machine.triggers is not None:
        for process, place in machine.triggers.outputs.items():
            if process not in get_args(TorchProcess):
                expected = f"one of {', '.join(get_args(TorchProcess))}"
                yield f"triggers.outputs.{process}", place, expected


def _axis_faults(machine: Machine, left_behind: Set[str]) -> Iterator[Fault]:
    numbers = {spindle.number for spindle in machine.spindles}
    known = ", ".join(map(str, sorted(numbers))) or "none, there are no spindles"
    names: set[str] = set()
    for index, axis in enumerate(machine.axes):
        key = f"axes.{index}"
        if axis.name in names:
            yield f"{key}.name", axis.name, "a name once"
        names.add(axis.name)
        if axis.spindle is None:
            if axis.moves in ACROSS and machine.stock == "beam":
                yield f"{key}.spindle", None, f"the number of a spindle: {known}"
            if axis.moves in OF_SAW and machine.saw is None and "saw" not in left_behind:
                yield f"{key}.moves", axis.moves, "another motion, or a [saw] table for it"
        elif axis.spindle not in numbers and "spindles" not in left_behind:
            yield f"{key}.spindle", axis.spindle, f"the number of a spindle: {known}"
        elif axis.moves not in ACROSS:
            yield f"{key}.moves", axis.moves, f"{' or '.join(ACROSS)}, which move a spindle"


def _tool_faults(machine: Machine) -> Iterator[Fault]:
    faces = {spindle.face for spindle in machine.spindles}
    for index, tools in enumerate(machine.tools):
        if machine.spindles and not faces.intersection(tools.faces):
            expected = f"a face that has a spindle: {', '.join(sorted(faces))}"
            yield f"tools.{index}.faces", list(tools.faces), expected


def _carrier_faults(machine: Machine) -> Iterator[Fault]:
    """Bodies that an axis in degrees carries along, or one in millimetres turns."""
    turning = {axis.name for axis in machine.axes if axis.moves == "angle"}
    for index, body in enumerate(machine.bodies):
        for field, carrier in zip(("x", "y", "z"), body.carriers, strict=False):
            if signed(carrier)[0] in turning:
                yield f"bodies.{index}.{field}", carrier, "an axis in millimetres"
        if body.turn and signed(body.turn)[0] not in turning:
            yield f"bodies.{index}.turn", body.turn, "an axis in degrees, which moves the angle"


def _look_faults(machine: Machine) -> Iterator[Fault]:
    torch = machine.torch
    if torch is None:
        return
    for name in torch.settings:
        if name not in torch.colours:
            known = ", ".join(torch.colours)
            yield f"torch.settings.{name}", name, f"a key of torch.colours: {known}"
    for name in torch.settled:
        if name not in torch.colours:
            known = ", ".join(torch.colours)
            yield "torch.settled", name, f"a key of torch.colours: {known}"


# --- name faults ----------------------------------------------------------------------------------

# Checks of what a machine's keys name: axes, faces, sections, suffixes.


#: DSTV codes of sections.
SECTION_CODES = ("I", "U", "L", "M", "RO", "RU", "C", "T", "B", "SO")
_SUFFIX = re.compile(r"\.[A-Za-z0-9_-]{1,16}")


def name_faults(machine: Machine) -> Iterator[Fault]:
    """Each key that names something unknown, or the same thing twice."""
    if not _SUFFIX.fullmatch(machine.suffix):
        yield "suffix", machine.suffix, "a dot and letters or digits, such as .gcode"
    known = ", ".join(SECTION_CODES)
    for code in machine.sections:
        if code not in SECTION_CODES:
            yield f"sections.{code}", code, f"a DSTV code of a section: {known}"
    if machine.layout is not None:
        layout = machine.layout
        for code in layout.profiles:
            if code not in SECTION_CODES:
                yield "layout.profiles", code, f"DSTV codes of sections: {known}"
        if layout.max_bar is not None and layout.min_bar > layout.max_bar:
            yield "layout.min_bar", layout.min_bar, f"at most layout.max_bar, {layout.max_bar:g}"
    for index, pair in enumerate(machine.pairs):
        if pair.faces[0] == pair.faces[1]:
            yield f"pairs.{index}.faces", list(pair.faces), "two faces"
    yield from _spindle_faults(machine)
    yield from _moved_faults(machine)


def _spindle_faults(machine: Machine) -> Iterator[Fault]:
    """Spindles for one face, of which one would never run, and numbers that two of them have."""
    faces: dict[str, str] = {}
    for index, spindle in enumerate(machine.spindles):
        if spindle.face in faces:
            expected = f"another face than that of {faces[spindle.face]!r}"
            yield f"spindles.{index}.face", spindle.face, expected
        faces[spindle.face] = spindle.name
    stations: list[tuple[str, Spindle | Pair]] = []
    stations += [(f"spindles.{index}", station) for index, station in enumerate(machine.spindles)]
    stations += [(f"pairs.{index}", station) for index, station in enumerate(machine.pairs)]
    numbers: dict[int, str] = {}
    for key, station in stations:
        if station.number in numbers:
            expected = f"another number than that of {numbers[station.number]!r}"
            yield f"{key}.number", station.number, expected
        numbers[station.number] = station.name


def _moved_faults(machine: Machine) -> Iterator[Fault]:
    seen: set[tuple[str, int | None]] = set()
    for index, axis in enumerate(machine.axes):
        moved = axis.moves, axis.spindle
        if moved in seen:
            whose = "" if axis.spindle is None else f" of spindle {axis.spindle}"
            yield f"axes.{index}.moves", axis.moves, f"one axis that moves {axis.moves}{whose}"
        seen.add(moved)


# --- marking faults -------------------------------------------------------------------------------

# Checks of a stamp or printer: what it has, and the word that tells it a text.


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
