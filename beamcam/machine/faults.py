"""Checks of a machine's stations, tools and templates: keys that contradict each other, and those
out of the range in which programs can be written and read back.
"""

import re
from collections.abc import Iterator
from string import Formatter
from typing import Any

from msgspec import Struct

from beamcam.conversion import nearest
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.machine.bodies import body_faults
from beamcam.machine.machine import Machine
from beamcam.machine.stations import FLAT_DEG, Drill, Saw, Spindle, ToolSet, inch_size
from beamcam.machine.words import PART_NAMES, WORD_NAMES

Fault = tuple[str, object, str]  #: dotted key, what was found, what was expected

#: mm that ends may gape, a path be off and two holes lie apart that are one: beyond that a hole is
#: no hole any more.
MAX_SLACK = 1.0
#: mm/min; feeds are written to 0.001 mm/s or mm/min, so that each is within 3 % of the machine's.
MIN_FEED_MM_MIN = 1.0
MIN_FEED_PER_TURN = 0.001  #: mm
MIN_PATH_TOLERANCE = 0.001  #: mm of chords from their curve, finer than a mill cuts
MIN_SPEED_RPM = 1.0  #: which programs say to 1
#: Kinds of tools whose speed or feed comes from `drill.cutting`.
TURNING = ("drill", "tap", "countersink", "mill", "punch", "scribe")
#: Kinds of tools that follow a path, for which the bar has to move forward and back.
ALONG_A_PATH = ("mill", "scribe")


def tool_faults(machine: Machine) -> Iterator[Fault]:
    """Each key that contradicts another."""
    saw, drill, layout = machine.saw, machine.drill, machine.layout
    if saw and drill and layout:
        if layout.order == "saw-drill" and drill.x < saw.x:
            yield "drill.x", drill.x, "at least saw.x, since the bar reaches the saw first"
        if layout.order == "drill-saw" and drill.x > saw.x:
            yield "drill.x", drill.x, "at most saw.x, since the bar reaches the drill first"
    if saw and saw.min_angle > saw.max_angle:
        yield "saw.min_angle", saw.min_angle, "at most saw.max_angle"
    if saw and saw.min_tilt > saw.max_tilt:
        yield "saw.min_tilt", saw.min_tilt, "at most saw.max_tilt"
    if saw and saw.min_tilt != saw.max_tilt and not carries(machine.words.saw, "tilt"):
        yield "words.saw", list(machine.words.saw), "a word with {tilt}, since the blade tilts"
    if saw:
        yield from _square_faults(saw, machine)
    if drill is None and machine.stock == "beam" and machine.tools:
        yield "tools", len(machine.tools), "none, or a [drill] table for them"
    for index, axis in enumerate(machine.axes):
        if axis.min is not None and axis.max is not None and axis.min > axis.max:
            yield f"axes.{index}.min", axis.min, "at most max"
    for index, tools in enumerate(machine.tools):
        yield from _set_faults(f"tools.{index}", tools)
        for word in words_of(tools.kind):
            if not getattr(machine.words, word):
                yield f"words.{word}", [], f"a template, since there are tools of kind {tools.kind}"
        if tools.kind in ALONG_A_PATH and layout and layout.order == "saw-drill":
            yield f"tools.{index}.kind", tools.kind, "a tool for strokes, since X only grows"
        if (
            tools.kind in TURNING
            and drill
            and not any(row.kind == tools.kind for row in drill.cutting)
        ):
            yield "drill.cutting", tools.kind, f"a row with kind = {tools.kind!r}"


def _square_faults(saw: Saw, machine: Machine) -> Iterator[Fault]:
    """Each limit that keeps the saw from a square cut, which every bar needs."""
    for key, limit, square in (
        ("min_angle", saw.min_angle, saw.zero_angle), ("min_tilt", saw.min_tilt, 0.0),
    ):  # fmt: skip
        if limit > square:
            yield f"saw.{key}", limit, f"at most {square:g}, the square cut"
    for key, limit, square in (
        ("max_angle", saw.max_angle, saw.zero_angle), ("max_tilt", saw.max_tilt, 0.0),
    ):  # fmt: skip
        if limit < square:
            yield f"saw.{key}", limit, f"at least {square:g}, the square cut"
    for index, axis in enumerate(machine.axes):
        if axis.moves == "angle" and axis.spindle is None:
            if axis.min is not None and axis.min > saw.zero_angle:
                yield f"axes.{index}.min", axis.min, f"at most {saw.zero_angle:g}, the square cut"
            if axis.max is not None and axis.max < saw.zero_angle:
                yield f"axes.{index}.max", axis.max, f"at least {saw.zero_angle:g}, the square cut"


#: Controllers that run a saw and drilling line; a cutting table may have any.
_OF_LINES = ("codesys", "linuxcnc")


def number_faults(machine: Machine) -> Iterator[Fault]:
    """A controller of another kind of machine, tools without a number or a peck of their words."""
    if machine.stock == "beam" and machine.controller not in _OF_LINES:
        yield "controller", machine.controller, f"{' or '.join(_OF_LINES)}, which run a line"
    for index, tools in enumerate(machine.tools):
        key = f"tools.{index}.numbers"
        if tools.numbers and len(tools.numbers) != len(tools.sizes):
            yield key, list(tools.numbers), f"{len(tools.sizes)}, one for each diameter"
        if not tools.numbers and carries(getattr(machine.words, tools.kind), "tool"):
            yield key, [], f"one for each diameter, since words.{tools.kind} has {{tool}}"
        yield from _peck_faults(f"tools.{index}.max_peck", tools, machine)
    numbers = [number for tools in machine.tools for number in tools.numbers]
    if len(numbers) != len(set(numbers)):
        yield "tools", sorted(n for n in set(numbers) if numbers.count(n) > 1), "a number once"


def _peck_faults(key: str, tools: ToolSet, machine: Machine) -> Iterator[Fault]:
    """A depth fed at a time that the words do not write, and one that they lack."""
    pecks = carries(getattr(machine.words, tools.kind), "peck")
    if tools.max_peck and tools.kind != "drill":
        yield key, tools.max_peck, "no such key, only drills are drawn back on their way"
    elif tools.max_peck and not pecks:
        expected = f"a word with {{peck}} in words.{tools.kind}, which feeds to the depth at once"
        yield key, tools.max_peck, expected
    elif pecks and not tools.max_peck:
        yield key, tools.max_peck, f"a depth above 0, since words.{tools.kind} has {{peck}}"


def carries(template: tuple[str, ...], name: str) -> bool:
    """Whether a template says a value."""
    return any("{" + name + "}" in line for line in template)


def words_of(kind: str) -> tuple[str, ...]:
    """The templates of a kind of tool, in the order of its work."""
    return (kind, f"{kind}_to", f"{kind}_end") if kind in ALONG_A_PATH else (kind,)


def _set_faults(key: str, tools: ToolSet) -> Iterator[Fault]:
    for index, text in enumerate(tools.inches):
        try:
            inch_size(text)
        except ValueError:
            yield f"{key}.inches.{index}", text, "inches such as '13/16' or '1 1/16'"
            return
    if not all(size > 0 for size in tools.sizes):
        yield f"{key}.diameters", list(tools.sizes), "diameters above 0"
    if not tools.sizes:
        yield f"{key}.diameters", [], "at least one diameter"
    if tools.point_deg > FLAT_DEG:
        yield f"{key}.point_deg", tools.point_deg, "at most 180, which is flat"
    if tools.kind == "tap":
        for name, values in (("pitches", tools.pitches), ("pre_drills", tools.pre_drills)):
            if len(values) != len(tools.sizes):
                yield f"{key}.{name}", list(values), f"{len(tools.sizes)}, one for each diameter"
            elif not all(value > 0 for value in values):
                yield f"{key}.{name}", list(values), "sizes above 0"
        for size, before in zip(tools.sizes, tools.pre_drills, strict=False):
            if before >= size:
                yield f"{key}.pre_drills", before, f"less than the thread's {size:g}"


def spindle_faults(machine: Machine) -> Iterator[Fault]:
    """Spindles that lack a drill or their own axis, and pairs that lack a spindle."""
    faces = {spindle.face for spindle in machine.spindles}
    for index, pair in enumerate(machine.pairs):
        if not faces.issuperset(pair.faces):
            yield f"pairs.{index}.faces", list(pair.faces), "faces that have a spindle"
    for index, spindle in enumerate(machine.spindles):
        if spindle.across.axis == spindle.stroke.axis:
            yield f"spindles.{index}.stroke.axis", spindle.stroke.axis, "another axis"
        if not _follows_y(spindle):
            expected = "arithmetic with y, so that each y of a face has its own place"
            yield f"spindles.{index}.across.position", str(spindle.across.position), expected
        elif machine.drill is None:
            yield f"spindles.{index}", spindle.name, "a [drill] table for it"
        elif _drawn_back(machine, spindle) < 0.0:
            expected = "a place outside of the bar, where the tool is drawn back"
            yield f"spindles.{index}.stroke.retract", spindle.stroke.retract, expected


def _follows_y(spindle: Spindle) -> bool:
    """Whether a spindle moves across with the holes' y, by as much at every place."""
    bar = {**_SAMPLE_BAR, "depth": 10.0, "tip": 5.0, "clearance": 5.0}
    places = [spindle.across.position({**bar, "y": y}) for y in (10.0, 11.0, 111.0)]
    per_mm = places[1] - places[0]
    return per_mm != 0.0 and abs(places[2] - places[1] - 100.0 * per_mm) < 1e-6


#: A bar on which a spindle has to stand clear; nothing lies beside the face.
_SAMPLE_BAR = {
    "height": 200.0, "width": 100.0, "flange_thickness": 10.0, "web_thickness": 6.0,
    "thickness": 10.0, "face_depth": 0.0, "y": 50.0, "depth": 0.0, "tip": 0.0,
}  # fmt: skip


def _drawn_back(machine: Machine, spindle: Spindle) -> float:
    """Clearance of the tool from the bar between two strokes, in mm; negative inside the bar."""
    values = {**_SAMPLE_BAR, "clearance": machine.drill.clearance if machine.drill else 0.0}
    start, surface = spindle.stroke.retract(values), spindle.stroke.bottom(values)
    deeper = spindle.stroke.bottom({**values, "depth": 1.0})
    if deeper == surface:  # a fixed stroke, from 0 on the bar
        return -start if surface >= start else start
    return surface - start if deeper > surface else start - surface


def pair_faults(machine: Machine) -> Iterator[Fault]:
    """Each formula of a pair's second spindle that is another than the first one's.

    A pair has one block for both, with one place across and one stroke.
    """
    spindles: dict[str, int] = {s.face: index for index, s in enumerate(machine.spindles)}
    for pair in machine.pairs:
        first, index = (spindles[face] for face in pair.faces)
        theirs = _moved_by(machine.spindles[first])
        for key, found in _moved_by(machine.spindles[index]).items():
            if found != theirs[key]:
                expected = f"{theirs[key]!r} as the other spindle of {pair.name!r} has, or no pair"
                yield f"spindles.{index}.{key}", found, expected


def _moved_by(spindle: Spindle) -> dict[str, str]:
    """The axes and formulas of a spindle, by their keys."""
    across, stroke = spindle.across, spindle.stroke
    return {
        "across.axis": across.axis, "across.position": across.position, "stroke.axis": stroke.axis,
        "stroke.retract": stroke.retract, "stroke.approach": stroke.approach or stroke.retract,
        "stroke.bottom": stroke.bottom,
    }  # fmt: skip


def view_faults(machine: Machine) -> Iterator[Fault]:
    """Keys of what is seen of a machine, its bodies and its registers, that contradict others."""
    names = frozenset(axis.name for axis in machine.axes)
    if not names and machine.stock == "sheet":
        lifts = machine.torch is not None and machine.torch.z == "program"
        letters = "XYZ" if lifts else "XY"
        names = frozenset(machine.triggers.all_axes if machine.triggers else letters)
    yield from body_faults(machine.bodies, names)
    modbus, count = machine.modbus, len(names)
    if modbus.scales and len(modbus.scales) != count:
        yield "modbus.scales", len(modbus.scales), f"{count}, one for each axis"
    if modbus.first + count * modbus.words + 6 > 65536:
        yield "modbus.first", modbus.first, "an address whose registers end by 65535"


# --- ranges ---------------------------------------------------------------------------------------

# Numbers with which a program would be one that the read-back refuses: a feed that rounds to 0, or
# a hole that is no hole any more.


def range_faults(machine: Machine) -> Iterator[Fault]:
    """Each number that programs cannot say, or that leaves nothing of the work."""
    if machine.saw is not None:
        yield from feed_faults("saw.feed_mm_min", machine.saw.feed_mm_min)
    if machine.drill is not None:
        yield from _of_drill(machine.drill)
        for name, found, expected in slack_faults(machine.drill):
            yield f"drill.{name}", found, expected


def feed_faults(key: str, found: float) -> Iterator[Fault]:
    """That a feed is slower than programs can say, if it is."""
    if found < MIN_FEED_MM_MIN:
        yield key, found, f"at least {MIN_FEED_MM_MIN:g} mm/min"


def _of_drill(drill: Drill) -> Iterator[Fault]:
    if drill.min_speed_rpm < MIN_SPEED_RPM:
        yield "drill.min_speed_rpm", drill.min_speed_rpm, f"at least {MIN_SPEED_RPM:g}"
    if drill.max_speed_rpm < drill.min_speed_rpm:
        yield "drill.max_speed_rpm", drill.max_speed_rpm, "at least drill.min_speed_rpm"
    yield from feed_faults("drill.max_feed_mm_min", drill.max_feed_mm_min)
    for index, row in enumerate(drill.cutting):
        key = f"drill.cutting.{index}.feed_per_turn"
        if row.feed_per_turn < MIN_FEED_PER_TURN:
            yield key, row.feed_per_turn, f"at least {MIN_FEED_PER_TURN:g} mm"
        if row.feed_per_turn * drill.min_speed_rpm < MIN_FEED_MM_MIN:
            expected = f"{MIN_FEED_MM_MIN / row.feed_per_turn:.3g} or more, for a feed of 1 mm/min"
            yield "drill.min_speed_rpm", drill.min_speed_rpm, f"{expected} by {key}"


def slack_faults(drill: Drill) -> Iterator[Fault]:
    """Each tolerance with which a hole would be no hole any more, by its name in a drill."""
    for name in (
        "merge_tolerance", "same_tool_tolerance", "duplicate_tolerance", "sink_tolerance",
        "path_tolerance",
    ):  # fmt: skip
        if (found := getattr(drill, name)) > MAX_SLACK:
            yield name, found, f"at most {MAX_SLACK:g} mm"
    if drill.path_tolerance < MIN_PATH_TOLERANCE:
        yield "path_tolerance", drill.path_tolerance, f"at least {MIN_PATH_TOLERANCE:g} mm"


# --- templates ------------------------------------------------------------------------------------

# Checks of the templates of a program's blocks.


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


MIN_NUMBER = 1e-6  #: that a key may have, if it is not 0


def leaves(record: Any, key: str = "") -> Iterator[tuple[str, object]]:
    """Dotted key and value of every plain value in a record."""
    if isinstance(record, Struct):
        for name in record.__struct_fields__:
            yield from leaves(getattr(record, name), f"{key}.{name}" if key else name)
    elif isinstance(record, dict):
        for name, value in record.items():
            yield from leaves(value, f"{key}.{name}")
    elif isinstance(record, tuple) and record and not isinstance(record[0], str | float | int):
        for index, value in enumerate(record):
            yield from leaves(value, f"{key}.{index}")
    elif record is not None:
        yield key, list(record) if isinstance(record, tuple) else record


def size_faults(machine: Machine) -> Iterator[tuple[str, object, str]]:
    """Each number that no machine has, and that arithmetic with others would not stand."""
    for key, value in leaves(machine):
        for number in value if isinstance(value, list) else (value,):
            if isinstance(number, int | float) and abs(number) > MAX_COORDINATE:
                yield key, value, f"a number between -{MAX_COORDINATE:g} and {MAX_COORDINATE:g}"
            if isinstance(number, float) and 0.0 < abs(number) < MIN_NUMBER:
                yield key, value, f"0, or a number of at least {MIN_NUMBER:g}"
