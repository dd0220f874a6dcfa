"""G-code of a saw and drilling line: the machine's word templates, filled in and numbered."""

from collections.abc import Iterable, Iterator

from beamcam.emitters.numbers import number
from beamcam.machine.machine import Machine, NumberFormat, Words
from beamcam.model.program import (
    Comment,
    DrillCycle,
    PathCycle,
    PathPoint,
    Program,
    SawStroke,
    StartBar,
)

SECONDS_PER_MINUTE = 60


def emit(program: Program, machine: Machine) -> str:
    """The text of a program, with a newline at its end."""
    blocks = _blocks(program, machine)
    if machine.format.number_blocks:
        blocks = _numbered(blocks)
    return "\n".join(blocks) + "\n"


def _numbered(blocks: Iterable[str]) -> Iterator[str]:
    """Blocks with N1, N2, ... but for the lines that are not blocks (`%`) and comments."""
    count = 0
    for block in blocks:
        if block.startswith(("%", "(")):
            yield block
        else:
            count += 1
            yield f"N{count} {block}"


def _blocks(program: Program, machine: Machine) -> Iterator[str]:
    words, form = machine.words, machine.format
    started = False
    for command in program.commands:
        match command:
            case StartBar():
                values = {
                    "job": program.job,
                    "section": str(command.section),
                    "width": number(command.width, form.length_decimals),
                    "height": number(command.height, form.length_decimals),
                }
                yield from (line.format_map(values) for line in words.header)
                started = True
            case SawStroke():
                values = {
                    "x": number(command.x, form.length_decimals),
                    "angle": number(command.angle, form.angle_decimals),
                    "tilt": number(command.tilt, form.angle_decimals),
                    "feed": _feed(command.feed_mm_min, form),
                }
                yield from (line.format_map(values) for line in words.saw)
            case DrillCycle():
                values = _drill_values(command, form)
                yield from (line.format_map(values) for line in getattr(words, command.kind))
            case PathCycle():
                yield from _path_blocks(command, words, form)
            case Comment():
                yield words.comment.format(text=command.text)
    if started:
        yield from words.footer


def _drill_values(command: DrillCycle, form: NumberFormat) -> dict[str, str]:
    point = PathPoint(command.x, command.start, command.near, command.bottom)
    values = _point_values(point, form)
    values["spindle"] = str(command.spindle)
    values["diameter"] = number(command.diameter, 3)
    values["feed"] = _feed(command.feed_mm_min, form)
    values["speed"] = number(command.speed_rpm, 0)
    values["pitch"] = number(command.pitch, 3)
    return values


def _path_blocks(command: PathCycle, words: Words, form: NumberFormat) -> Iterator[str]:
    """The words of a mill or scribe: down at the first point, to each other one, and up."""
    down, along, up = (getattr(words, command.kind + end) for end in ("", "_to", "_end"))
    values = {
        "spindle": str(command.spindle),
        "diameter": number(command.diameter, 3),
        "feed": _feed(command.feed_mm_min, form),
        "speed": number(command.speed_rpm, 0),
    }
    for index, point in enumerate(command.points):
        values.update(_point_values(point, form))
        yield from (line.format_map(values) for line in (along if index else down))
    yield from (line.format_map(values) for line in up)


def _point_values(point: PathPoint, form: NumberFormat) -> dict[str, str]:
    def length(value: float) -> str:
        return number(value, form.length_decimals)

    (y, z), (near_y, near_z) = map(length, point.start), map(length, point.near)
    bottom_y, bottom_z = map(length, point.bottom)
    return {
        "x": length(point.x),
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
