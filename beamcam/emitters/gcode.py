"""G-code of a saw and drilling line: the machine's word templates, filled in and numbered.

Most cycles are like one before but for their X, in this program or in another one. The text of
a cycle is therefore kept in pieces between its X, so that another X joins them:

    M40 K2 L18 / G00 X| Y15 Z-5 / G00 X| Y15 Z66.45 / M03 / ... / M05
"""

from collections.abc import Iterable, Iterator
from itertools import groupby
from string import Formatter

from beamcam.emitters.numbers import number
from beamcam.machine.known import Kept, OncePerMachine
from beamcam.machine.machine import Machine, NumberFormat
from beamcam.machine.words import Words
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
NO_BLOCK = ("%", "(")  #: how lines begin that are no blocks and get no number
KINDS = ("drill", "tap", "countersink", "punch")
MOST_CYCLES = 2048  #: of each kind that are kept
_X = "\0"

Cycles = dict[str, Kept[tuple[object, ...], list[str]]]


def _no_cycles(machine: Machine) -> Cycles:
    """An empty table for each kind of cycle whose template only names values, with no width."""
    templates = {kind: getattr(machine.words, kind) for kind in KINDS}
    return {
        kind: Kept(MOST_CYCLES)
        for kind, template in templates.items()
        if not any(how or kept for line in template for *_, how, kept in Formatter().parse(line))
    }


_cycles_of = OncePerMachine(_no_cycles)


def emit(program: Program, machine: Machine) -> str:
    """The text of a program, with a newline at its end."""
    blocks: Iterable[str] = _blocks(program, machine)
    if machine.format.number_blocks:
        blocks = _numbered(blocks)
    return "\n".join(blocks) + "\n"


def _numbered(blocks: Iterable[str]) -> Iterator[str]:
    """Blocks with N1, N2, ... but for the lines that are not blocks (`%`) and comments."""
    count = 0
    for is_plain, run in groupby(blocks, _is_plain):
        lines = "\n".join(run).split("\n")
        if is_plain:
            yield "\n".join([f"N{n} {line}" for n, line in enumerate(lines, count + 1)])
            count += len(lines)
            continue
        for line in lines:
            if line.startswith(NO_BLOCK):
                yield line
            else:
                count += 1
                yield f"N{count} {line}"


def _is_plain(text: str) -> bool:
    """Whether all lines of a text are blocks for sure."""
    return "%" not in text and "(" not in text


def _blocks(program: Program, machine: Machine) -> Iterator[str]:
    """Blocks, and whole cycles in one."""
    words, form = machine.words, machine.format
    cycles = _cycles_of(machine)
    started = False
    for command in program.commands:
        if isinstance(command, DrillCycle):
            yield _cycle(command, cycles, words, form)
            continue
        match command:
            case SawStroke():
                values = {
                    "x": number(command.x, form.length_decimals),
                    "angle": number(command.angle, form.angle_decimals),
                    "tilt": number(command.tilt, form.angle_decimals),
                    "feed": _feed(command.feed_mm_min, form),
                }
                yield from (line.format_map(values) for line in words.saw)
            case StartBar():
                values = {
                    "job": program.job,
                    "section": str(command.section),
                    "width": number(command.width, form.length_decimals),
                    "height": number(command.height, form.length_decimals),
                }
                yield from (line.format_map(values) for line in words.header)
                started = True
            case PathCycle():
                yield from _path_blocks(command, words, form)
            case Comment():
                yield words.comment.format(text=command.text)
    if started:
        yield from words.footer


def _cycle(command: DrillCycle, cycles: Cycles, words: Words, form: NumberFormat) -> str:
    """The text of a cycle."""
    x = number(command.x, form.length_decimals)
    template = getattr(words, command.kind)
    known = cycles.get(command.kind)
    if known is None:
        values = {**_drill_values(command, form), "x": x}
        return "\n".join(line.format_map(values) for line in template)
    key = (
        command.spindle, command.diameter, command.start, command.near, command.bottom,
        command.feed_mm_min, command.speed_rpm, command.pitch,
    )  # fmt: skip
    pieces = known.get(key)
    if pieces is None:
        values = _drill_values(command, form)
        text = "\n".join(line.format_map(values) for line in template)
        pieces = known.keep(key, text.split(_X))
    return x.join(pieces)


def _drill_values(command: DrillCycle, form: NumberFormat) -> dict[str, str]:
    """What stands in the braces of a cycle, a mark for X."""
    values = _point_values(PathPoint(command.x, command.start, command.near, command.bottom), form)
    values["x"] = _X
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
