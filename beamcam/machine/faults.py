"""Checks of a machine's stations, tools and templates: keys that contradict each other, and those
with which no program could be written and read back.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from operator import attrgetter
from string import Formatter
from typing import Any

from msgspec import Struct

from beamcam.conversion import compile_expression, nearest
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.machine.machine import SECTION_NAMES, Machine, MachineBox, signed
from beamcam.machine.stations import Saw, Spindle, ToolSet, inch_size
from beamcam.machine.words import PART_NAMES, WORD_NAMES

#: Dotted key and what was expected; what was found, where that is not the value of the key.
Fault = tuple[str, str] | tuple[str, str, object]

#: Kinds of tools whose speed or feed comes from `drill.cutting`.
TURNING = ("drill", "tap", "countersink", "mill", "punch", "scribe")
#: Kinds of tools that follow a path, for which the bar has to move forward and back.
ALONG_A_PATH = ("mill", "scribe")


def with_found(faults: Iterable[Fault], machine: Machine) -> Iterator[tuple[str, object, str]]:
    """Key, what was found and what was expected of each fault."""
    for key, expected, *own in faults:
        found: Any = machine
        for word in () if own else key.split("."):
            if isinstance(found, tuple):
                found = found[int(word)]
            else:
                found = found[word] if isinstance(found, Mapping) else getattr(found, word)
        found = own[0] if own else found
        yield key, list(found) if isinstance(found, tuple) else found, expected


def repeats(values: Iterable[object]) -> Iterator[tuple[int, int]]:
    """The index of each value that was there before, and of where it was first."""
    first: dict[object, int] = {}
    for index, value in enumerate(values):
        if first.setdefault(value, index) != index:
            yield index, first[value]


def tool_faults(machine: Machine) -> Iterator[Fault]:
    """Each key of the saw, the drill and the tools that contradicts another."""
    saw, drill, layout, marks = machine.saw, machine.drill, machine.layout, machine.marks
    for key, x, why in (
        ("drill.x", drill.x if drill else None, "since the bar reaches the drill first"),
        ("marks.x", marks.x if marks.is_told else None, "or the part is cut off before"),
    ):
        if saw and layout and x is not None:
            if layout.order == "saw-drill" and x < saw.x:
                yield key, "at least saw.x, since the bar reaches the saw first"
            if layout.order == "drill-saw" and x > saw.x:
                yield key, f"at most saw.x, {why}"
    for index, axis in enumerate(machine.axes):
        if axis.limits[0] > axis.limits[1]:
            yield f"axes.{index}.min", "at most max"
    if saw:
        yield from _saw_faults(saw, machine)
    if drill is None and machine.stock == "beam" and machine.tools:
        yield "tools", "none, or a [drill] table for them", len(machine.tools)
    if drill and drill.max_speed_rpm < drill.min_speed_rpm:
        yield "drill.max_speed_rpm", "at least drill.min_speed_rpm"
    for index, row in enumerate(drill.cutting if drill else ()):
        # A slower feed would be one of a program that rounds to 0.
        if drill and row.feed_per_turn * drill.min_speed_rpm < 1.0:
            expected = f"{1.0 / row.feed_per_turn:.3g} or more, for a feed of 1 mm/min"
            yield "drill.min_speed_rpm", f"{expected} by drill.cutting.{index}.feed_per_turn"
    for index, tools in enumerate(machine.tools):
        yield from _set_faults(f"tools.{index}", tools)
        for word in words_of(tools.kind):
            if not getattr(machine.words, word):
                yield f"words.{word}", f"a template, since there are tools of kind {tools.kind}"
        if tools.kind in ALONG_A_PATH and layout and layout.order == "saw-drill":
            yield f"tools.{index}.kind", "a tool for strokes, since X only grows"
        rows = drill.cutting if drill else ()
        if tools.kind in TURNING and drill and all(row.kind != tools.kind for row in rows):
            yield "drill.cutting", f"a row with kind = {tools.kind!r}", tools.kind


def _saw_faults(saw: Saw, machine: Machine) -> Iterator[Fault]:
    """Limits that leave no angle, or keep the saw from a square cut, which every bar needs."""
    for name, square in (("angle", saw.zero_angle), ("tilt", 0.0)):
        least, most = getattr(saw, f"min_{name}"), getattr(saw, f"max_{name}")
        if least > most:
            yield f"saw.min_{name}", f"at most saw.max_{name}"
        if least > square:
            yield f"saw.min_{name}", f"at most {square:g}, the square cut"
        if most < square:
            yield f"saw.max_{name}", f"at least {square:g}, the square cut"
    if saw.min_tilt != saw.max_tilt and not carries(machine.words.saw, "tilt"):
        yield "words.saw", "a word with {tilt}, since the blade tilts"
    for index, axis in enumerate(machine.axes):
        if axis.moves == "angle" and axis.spindle is None:
            if axis.limits[0] > saw.zero_angle:
                yield f"axes.{index}.min", f"at most {saw.zero_angle:g}, the square cut"
            if axis.limits[1] < saw.zero_angle:
                yield f"axes.{index}.max", f"at least {saw.zero_angle:g}, the square cut"


#: Controllers that run a saw and drilling line; a cutting table may have any.
_OF_LINES = ("codesys", "linuxcnc")


def number_faults(machine: Machine) -> Iterator[Fault]:
    """A controller of another kind of machine, tools without a number or a peck of their words."""
    if machine.stock == "beam" and machine.controller not in _OF_LINES:
        yield "controller", f"{' or '.join(_OF_LINES)}, which run a line"
    for index, tools in enumerate(machine.tools):
        key, word = f"tools.{index}", f"words.{tools.kind}"
        template = getattr(machine.words, tools.kind)
        if tools.numbers and len(tools.numbers) != len(tools.sizes):
            yield f"{key}.numbers", f"{len(tools.sizes)}, one for each diameter"
        if not tools.numbers and carries(template, "tool"):
            yield f"{key}.numbers", f"one for each diameter, since {word} has {{tool}}"
        if tools.max_peck and tools.kind != "drill":
            expected = "no such key, only drills are drawn back on their way"
            yield f"{key}.max_peck", expected
        elif tools.max_peck and not carries(template, "peck"):
            expected = f"a word with {{peck}} in {word}, which feeds to the depth at once"
            yield f"{key}.max_peck", expected
        elif carries(template, "peck") and not tools.max_peck:
            yield f"{key}.max_peck", f"a depth above 0, since {word} has {{peck}}"
    numbers = [number for tools in machine.tools for number in tools.numbers]
    if twice := sorted({numbers[index] for index, _ in repeats(numbers)}):
        yield "tools", "a number once", twice


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
            yield f"{key}.inches.{index}", "inches such as '13/16' or '1 1/16'"
            return
    if not tools.sizes:
        yield f"{key}.diameters", "at least one diameter"
    if tools.kind == "tap":
        for name in ("pitches", "pre_drills"):
            if len(getattr(tools, name)) != len(tools.sizes):
                yield f"{key}.{name}", f"{len(tools.sizes)}, one for each diameter"
        for size, before in zip(tools.sizes, tools.pre_drills, strict=False):
            if before >= size:
                yield f"{key}.pre_drills", f"less than the thread's {size:g}", before


#: A bar on which a spindle has to stand clear; nothing lies beside the face.
_SAMPLE_BAR = {
    "height": 200.0, "width": 100.0, "flange_thickness": 10.0, "web_thickness": 6.0,
    "thickness": 10.0, "face_depth": 0.0, "y": 50.0, "depth": 0.0, "tip": 0.0,
}  # fmt: skip


def spindle_faults(machine: Machine) -> Iterator[Fault]:
    """Spindles without a drill or their own axis, and pairs without a spindle."""
    faces = {spindle.face for spindle in machine.spindles}
    for index, pair in enumerate(machine.pairs):
        if not faces.issuperset(pair.faces):
            yield f"pairs.{index}.faces", "faces that have a spindle"
    bar = {**_SAMPLE_BAR, "depth": 10.0, "tip": 5.0, "clearance": 5.0}
    for index, spindle in enumerate(machine.spindles):
        key = f"spindles.{index}"
        if spindle.across.axis == spindle.stroke.axis:
            yield f"{key}.stroke.axis", "another axis"
        # It moves across with the holes' y, by as much at every place.
        a, b, c = (spindle.across.position({**bar, "y": y}) for y in (10.0, 11.0, 111.0))
        if a == b or abs(c - b - 100.0 * (b - a)) >= 1e-6:
            expected = "arithmetic with y, so that each y of a face has its own place"
            yield f"{key}.across.position", expected
        elif machine.drill is None:
            yield key, "a [drill] table for it", spindle.name
        elif _drawn_back(spindle, machine.drill.clearance) < 0.0:
            expected = "a place outside of the bar, where the tool is drawn back"
            yield f"{key}.stroke.retract", expected


def _drawn_back(spindle: Spindle, clearance: float) -> float:
    """Clearance of the tool from the bar between two strokes, in mm; negative inside the bar."""
    values = {**_SAMPLE_BAR, "clearance": clearance}
    start, surface = spindle.stroke.retract(values), spindle.stroke.bottom(values)
    deeper = spindle.stroke.bottom({**values, "depth": 1.0})
    if deeper == surface:  # a fixed stroke, from 0 on the bar
        return -start if surface >= start else start
    return surface - start if deeper > surface else start - surface


#: Axes and formulas of a spindle.
_MOTION = ("across.axis", "across.position", "stroke.axis", "stroke.retract", "stroke.approach",
           "stroke.bottom")  # fmt: skip


def pair_faults(machine: Machine) -> Iterator[Fault]:
    """Each formula of a pair's second spindle that is another than the first one's.

    A pair has one block for both, with one place across and one stroke.
    """
    spindles: dict[str, int] = {s.face: index for index, s in enumerate(machine.spindles)}
    for pair in machine.pairs:
        both = [machine.spindles[spindles[face]] for face in pair.faces]
        for key in _MOTION:
            first, second = (attrgetter(key)(one) or one.stroke.retract for one in both)
            if first != second:
                expected = f"{first!r} as the other spindle of {pair.name!r} has, or no pair"
                yield f"spindles.{spindles[pair.faces[1]]}.{key}", expected, second


def view_faults(machine: Machine) -> Iterator[Fault]:
    """Keys of what is seen of a machine, its bodies and its registers, that contradict others."""
    names = frozenset(axis.name for axis in machine.axes)
    if not names and machine.stock == "sheet":
        lifts = machine.torch is not None and machine.torch.z == "program"
        letters = "XYZ" if lifts else "XY"
        names = frozenset(machine.triggers.all_axes if machine.triggers else letters)
    for index, _ in repeats(body.name for body in machine.bodies):
        yield f"bodies.{index}.name", "a name once"
    for index, body in enumerate(machine.bodies):
        yield from _body_faults(f"bodies.{index}", body, names)
    modbus, count = machine.modbus, len(names)
    if modbus.scales and len(modbus.scales) != count:
        yield "modbus.scales", f"{count}, one for each axis", len(modbus.scales)
    if modbus.first + count * modbus.words + 6 > 65536:
        yield "modbus.first", "an address whose registers end by 65535"


def _body_faults(key: str, body: MachineBox, axes: frozenset[str]) -> Iterator[Fault]:
    """Carriers that are no axes, and corners that are no arithmetic over a section."""
    for field, carrier in zip(("x", "y", "z", "turn"), body.carriers, strict=True):
        if carrier and signed(carrier)[0] not in axes:
            yield f"{key}.{field}", f"an axis: {', '.join(sorted(axes))}"
    for field, formulas in (("min", body.min), ("max", body.max), ("pivot", body.pivot or ())):
        for formula in formulas:
            try:
                compile_expression(formula, SECTION_NAMES)
            except ValueError:
                expected = f"arithmetic over {', '.join(SECTION_NAMES)}"
                yield f"{key}.{field}", expected, str(formula)


# --- templates ------------------------------------------------------------------------------------

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

    Decimals are those of [format], so that a program is read back as it was rounded. Data of a part
    in a table's program stand in comments: as figures nothing would say which is right.
    """
    for key, names in WORD_NAMES.items():
        if key == "header":
            names = names - _NOT_SAID[machine.stock]
        elif machine.stock == "sheet":
            names = names - {"z", "a", "inverse"} if key in ("traverse", "feed") else names
        template = getattr(machine.words, key)
        for line in (template,) if isinstance(template, str) else template:
            for found, expected in _line_faults(line, names):
                yield f"words.{key}", expected, found
            if machine.stock != "beam" and key != "header":
                for _, name, _, _ in Formatter().parse(_COMMENT.sub("", line)):
                    if name in PART_NAMES:
                        yield f"words.{key}", "it in a comment, between ( and )", "{" + name + "}"


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


def size_faults(machine: Machine) -> Iterator[Fault]:
    """Each number that no machine has, and that arithmetic with others would not stand."""
    for key, value in leaves(machine):
        for number in value if isinstance(value, list) else (value,):
            if isinstance(number, int | float) and abs(number) > MAX_COORDINATE:
                expected = f"a number between -{MAX_COORDINATE:g} and {MAX_COORDINATE:g}"
                yield key, expected, value
            if isinstance(number, float) and 0.0 < abs(number) < MIN_NUMBER:
                yield key, f"0, or a number of at least {MIN_NUMBER:g}", value
