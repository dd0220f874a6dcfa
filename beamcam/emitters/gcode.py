"""G-code of a saw and drilling line: the machine's word templates, filled in and numbered."""

from collections.abc import Iterable, Iterator, Mapping

from beamcam.emitters.numbers import number
from beamcam.machine.machine import Machine, NumberFormat
from beamcam.machine.tools import ToolNumbers, tool_numbers
from beamcam.machine.words import Words
from beamcam.model.part_data import PART_DATA
from beamcam.model.program import (
    ChangeTool,
    Comment,
    DrillCycle,
    OfPart,
    PathCycle,
    PathPoint,
    Program,
    SawStroke,
    SpindleStroke,
    StartBar,
    TellText,
)
from beamcam.plain_text import comment_text

SECONDS_PER_MINUTE = 60
NO_BLOCK = ("%", "(")  #: how lines begin that are no blocks and get no number

Values = dict[str, str]  #: a placeholder of a template


def emit(program: Program, machine: Machine) -> str:
    """The text of a program, with a newline at its end."""
    blocks: Iterable[str] = _blocks(program, machine)
    if machine.format.number_blocks:
        blocks = _numbered(blocks)
    return "\n".join(blocks) + "\n"


def _numbered(blocks: Iterable[str]) -> Iterator[str]:
    """Blocks with N1, N2, ... but for the lines that are not blocks (`%`) and comments."""
    count = 0
    for line in "\n".join(blocks).split("\n"):
        if line.startswith(NO_BLOCK):
            yield line
        else:
            count += 1
            yield f"N{count} {line}"


def _blocks(program: Program, machine: Machine) -> Iterator[str]:
    """Blocks, and whole cycles and cuts in one."""
    words, form = machine.words, machine.format
    numbers = tool_numbers(machine.tools)
    strokes: dict[SpindleStroke, Values] = {}  #: most strokes are like one before, at another X
    started, of_part = False, _texts(program.about)
    for command in program.commands:
        match command:
            case DrillCycle(stroke=stroke):
                if stroke not in strokes:
                    strokes[stroke] = _stroke_values(stroke, form, numbers)
                x = number(command.x, form.length_decimals)
                yield _filled(getattr(words, stroke.kind), {**of_part, **strokes[stroke], "x": x})
            case SawStroke() if words.saw:
                yield _cut(command, words, form, of_part)
            case StartBar():
                started = True
                if words.header:
                    yield _header(program, command, words, form)
            case OfPart():
                of_part = _texts({**program.about, **command.about})
            case PathCycle():
                yield from _path_blocks(command, words, form, numbers, of_part)
            case TellText():
                values = {**of_part, **_text_values(command, form)}
                yield _filled(getattr(words, command.kind), values)
            case ChangeTool() if words.change:
                yield _change(command, words)
            case Comment():
                yield words.comment.format(text=comment_text(command.text))
    if started:
        yield from words.footer


def _header(program: Program, command: StartBar, words: Words, form: NumberFormat) -> str:
    """The text before the work."""
    values = {
        **_texts(program.about),
        "job": comment_text(program.job),
        "section": str(command.section),
        "width": number(command.width, form.length_decimals),
        "height": number(command.height, form.length_decimals),
    }
    return _filled(words.header, values)


def _texts(about: Mapping[str, str]) -> Values:
    """What is known of a part, and nothing for what is not."""
    known = {name: comment_text(text) for name, text in about.items()}
    return {**dict.fromkeys(PART_DATA, ""), **known}


def _cut(command: SawStroke, words: Words, form: NumberFormat, of_part: Values) -> str:
    """The text of a cut."""
    values = _cut_values(command, number(command.x, form.length_decimals), form)
    return _filled(words.saw, {**of_part, **values})


def _change(command: ChangeTool, words: Words) -> str:
    """The stop for a manual tool change."""
    values = {
        "spindle": str(command.spindle),
        "station": str(command.station),
        "diameter": number(command.diameter, 3),
        "text": comment_text(command.text),
    }
    return _filled(words.change, values)


def _filled(template: Iterable[str], values: Values) -> str:
    return "\n".join(template).format_map(values)


def _text_values(command: TellText, form: NumberFormat) -> Values:
    return {
        "string": command.text,
        "x": number(command.x, form.length_decimals),
        "y": number(command.y, form.length_decimals),
        "height": number(command.height, form.length_decimals),
        "angle": number(command.angle, form.angle_decimals),
        "face": str(command.face),
    }


def _cut_values(command: SawStroke, x: str, form: NumberFormat) -> Values:
    return {
        "x": x,
        "angle": number(command.angle, form.angle_decimals),
        "tilt": number(command.tilt, form.angle_decimals),
        "feed": _feed(command.feed_mm_min, form),
    }


def _stroke_values(stroke: SpindleStroke, form: NumberFormat, numbers: ToolNumbers) -> Values:
    return {
        **_place_values(stroke, form),
        "tool": _tool(stroke.kind, stroke.diameter, numbers),
        "tool_name": comment_text(stroke.tool_name),
        "station": str(stroke.station),
        "spindle": str(stroke.spindle),
        "diameter": number(stroke.diameter, 3),
        "feed": _feed(stroke.feed_mm_min, form),
        "speed": number(stroke.speed_rpm, 0),
        "pitch": number(stroke.pitch, 3),
        "peck": number(stroke.peck, form.length_decimals),
    }


def _tool(kind: str, diameter: float, numbers: ToolNumbers) -> str:
    """The machine's number of a tool; "" where its tools have no numbers."""
    found = numbers.get((kind, diameter))
    return "" if found is None else str(found)


def _path_blocks(
    command: PathCycle, words: Words, form: NumberFormat, numbers: ToolNumbers, of_part: Values
) -> Iterator[str]:
    """The words of a mill or scribe: down at the first point, to each other one, and up."""
    down, along, up = (getattr(words, command.kind + end) for end in ("", "_to", "_end"))
    values = {
        **of_part,
        "spindle": str(command.spindle),
        "tool": _tool(command.kind, command.diameter, numbers),
        "tool_name": comment_text(command.tool_name),
        "station": str(command.station),
        "diameter": number(command.diameter, 3),
        "feed": _feed(command.feed_mm_min, form),
        "speed": number(command.speed_rpm, 0),
    }
    for index, point in enumerate(command.points):
        values["x"] = number(point.x, form.length_decimals)
        values.update(_place_values(point, form))
        yield from (line.format_map(values) for line in (along if index else down))
    yield from (line.format_map(values) for line in up)


def _place_values(point: PathPoint | SpindleStroke, form: NumberFormat) -> Values:
    """Y and Z above a place, where the approach ends and at work."""

    def length(value: float) -> str:
        return number(value, form.length_decimals)

    (y, z), (near_y, near_z) = map(length, point.start), map(length, point.near)
    bottom_y, bottom_z = map(length, point.bottom)
    return {
        "y": y,
        "z": z,
        "near_y": near_y,
        "near_z": near_z,
        "bottom_y": bottom_y,
        "bottom_z": bottom_z,
    }


def _feed(feed_mm_min: float, form: NumberFormat) -> str:
    factor = SECONDS_PER_MINUTE if form.feed_unit == "mm/s" else 1
    return number(feed_mm_min / factor, 3)
