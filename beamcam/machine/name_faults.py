"""Checks of what a machine's keys name: axes, faces, sections, suffixes."""

import re
from collections.abc import Iterator

from beamcam.machine.drill import Pair, Spindle
from beamcam.machine.machine import Machine

NameFault = tuple[str, object, str]  #: dotted key, what was found, what was expected

#: DSTV codes of sections.
SECTION_CODES = ("I", "U", "L", "M", "RO", "RU", "C", "T", "B", "SO")
_SUFFIX = re.compile(r"\.[A-Za-z0-9_-]{1,16}")


def name_faults(machine: Machine) -> Iterator[NameFault]:
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
    yield from _axis_faults(machine)


def _spindle_faults(machine: Machine) -> Iterator[NameFault]:
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


def _axis_faults(machine: Machine) -> Iterator[NameFault]:
    seen: set[tuple[str, int | None]] = set()
    for index, axis in enumerate(machine.axes):
        moved = axis.moves, axis.spindle
        if moved in seen:
            whose = "" if axis.spindle is None else f" of spindle {axis.spindle}"
            yield f"axes.{index}.moves", axis.moves, f"one axis that moves {axis.moves}{whose}"
        seen.add(moved)
