"""G-code: what every program begins with, its numbers, and the words of a saw and drilling line,
filled in.

The head is comments that say what a program is, for people and for `verify`.

    BEAMCAM 2 MACHINE beamline 5e57509a            form, machine, checksum of its file
    ALLOWED TO BE LEFT OUT: cope, slot             kinds that --allow-skips named
    LEFT OUT: 2 slot                               what is missing, by count
    LEFT TO THE HAND: 3                            features left for manual work
    PROGRAM 2 OF 3                                 of a job of several
    SECTION UPN200 GRADE S235JR                    of a sheet SHEET 10 GRADE S235JR
    BAR 12000                                      or BAR 1532.086 AS NEEDED
    PART 1 AT 20 LENGTH 1500 MARK M58 DRAWING 12 ORDER 7

A part that needs more than a line goes on in another, with its number; texts are cut at 40
characters. `checks.head` reads all of it.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from string import Formatter
from typing import Any

from msgspec import Struct

from beamcam.caches import BoundedCache, PerObject
from beamcam.controllers import longest_line
from beamcam.machine.machine import Machine, NumberFormat, names_in
from beamcam.machine.stations import ToolNumbers, tool_numbers
from beamcam.machine.words import PART_NAMES
from beamcam.model.plan import AnyPlan, Piece, Plan, SheetPlan
from beamcam.model.program import (
    BeginPart,
    ChangeTool,
    Comment,
    DrillCycle,
    OfPart,
    PathCycle,
    PathPoint,
    PrintText,
    Program,
    SawStroke,
    SpindleStroke,
    StartBar,
)
from beamcam.model.request import Job
from beamcam.plain_text import MAX_COMMENT, comment_text, one_word, outside_text

SECONDS_PER_MINUTE = 60

Values = dict[str, str]  #: a placeholder of a template


class Template(Struct, frozen=True):
    """The lines of a word, and the names that they carry."""

    text: str
    names: frozenset[str]
    of_part: frozenset[str]  #: those of them that tell of the part or the job
    of_command: tuple[tuple[str, Callable[[Any, NumberFormat], str]], ...]  #: of what is to be done


class Templates(Struct, frozen=True):
    """The words of a machine, ready to be filled in."""

    form: NumberFormat
    numbers: ToolNumbers
    comment: str
    room: int  #: characters that a comment may have
    words: dict[str, Template]  #: those that have lines
    strokes: BoundedCache[SpindleStroke, str]  #: the lines of each, but for X and data of the part


def _templates(machine: Machine) -> Templates:
    words, templates = machine.words, {}
    for name in words.__struct_fields__:
        lines = getattr(words, name)
        if lines and name != "comment":
            names = names_in(words, (name,))
            of_command = tuple((name, of) for name, of in _OF_COMMAND.items() if name in names)
            templates[name] = Template("\n".join(lines), names, names & PART_NAMES, of_command)
    strokes: BoundedCache[SpindleStroke, str] = BoundedCache("emitters.strokes")
    return Templates(
        machine.format, tool_numbers(machine.tools), words.comment, comment_room(machine),
        templates,
        strokes,
    )  # fmt: skip


templates_of = PerObject("emitters.machines", _templates)


def emit(program: Program, machine: Machine) -> str:
    """The text of a program, with a newline at its end."""
    text = "\n".join(_blocks(program, templates_of(machine))) + "\n"
    return numbered(text) if machine.format.number_blocks else text


def _blocks(program: Program, templates: Templates) -> Iterator[str]:
    """Blocks, and whole cycles and cuts in one."""
    words, form, strokes = templates.words, templates.form, templates.strokes
    started, about = False, program.about
    for command in program.commands:
        match command:
            case DrillCycle(stroke=stroke):
                word = words[stroke.kind]
                lines = strokes.get(stroke) or strokes.keep(
                    stroke, _stroke_lines(stroke, word, templates)
                )
                values = {"x": number(command.x, form.length_decimals)}
                for name in word.of_part:
                    values[name] = outside_text(about.get(name, ""))
                yield lines.format_map(values)
            case SawStroke() if "saw" in words:
                values = _values(command, words["saw"], templates)
                values["x"] = number(command.x, form.length_decimals)
                yield _filled(words["saw"], values, about)
            case StartBar():
                started = True
                if "header" in words:
                    values = _values(command, words["header"], templates)
                    values["job"] = outside_text(program.job)[: templates.room]
                    yield _filled(words["header"], values, about)
            case OfPart():
                about = {**program.about, **command.about}
            case PathCycle():
                yield from _path_blocks(command, templates, about)
            case PrintText():
                values = _values(command, words[command.kind], templates)
                values["x"] = number(command.x, form.length_decimals)
                values["y"] = number(command.y, form.length_decimals)
                yield _filled(words[command.kind], values, about)
            case ChangeTool() if "change" in words:
                values = _values(command, words["change"], templates)
                yield _filled(words["change"], values, about)
            case Comment() | BeginPart():
                text = comment_text(command.text)[: templates.room]
                yield templates.comment.format(text=text)
    if started and "footer" in words:
        yield words["footer"].text


def _filled(word: Template, values: Values, about: Mapping[str, str]) -> str:
    """A word with its values and what is known of the part; nothing for what is not."""
    of_part = {name: outside_text(about.get(name, "")) for name in word.of_part}
    return word.text.format_map({**values, **of_part})


def _stroke_lines(stroke: SpindleStroke, word: Template, templates: Templates) -> str:
    """The lines of a stroke, wherever it is: a template of X and of data of the part."""
    values = {**_place_values(stroke, word, templates.form), **_values(stroke, word, templates)}
    lines = ""
    for text, name, form, _ in Formatter().parse(word.text):
        lines += text.replace("{", "{{").replace("}", "}}")
        if name is not None:
            place = f"{{{name}:{form}}}"
            lines += place.format_map(values) if name in values else place
    return lines


def _feed(command: SawStroke | SpindleStroke | PathCycle, form: NumberFormat) -> str:
    factor = SECONDS_PER_MINUTE if form.feed_unit == "mm/s" else 1
    return number(command.feed_mm_min / factor, 3)


#: Where a place's coordinate stands: above it, where the approach ends, and at work.
_PLACES = {
    "y": ("retract", 0), "z": ("retract", 1), "near_y": ("approach", 0), "near_z": ("approach", 1),
    "bottom_y": ("bottom", 0), "bottom_z": ("bottom", 1),
}  # fmt: skip
#: What a word may say of a stroke, path, cut, text or change, and of the bar, besides its place.
_OF_COMMAND: dict[str, Callable[[Any, NumberFormat], str]] = {
    "tool_name": lambda of, _: comment_text(of.tool_name),
    "text": lambda of, _: comment_text(of.text),
    "string": lambda of, _: str(of.text),
    **{name: lambda of, _, name=name: str(getattr(of, name))  # type: ignore[misc]
       for name in ("station", "spindle", "section", "face")},
    **{name: lambda of, form, name=name: number(getattr(of, name), form.length_decimals)  # type: ignore[misc]
       for name in ("width", "height", "peck")},
    **{name: lambda of, form, name=name: number(getattr(of, name), form.angle_decimals)  # type: ignore[misc]
       for name in ("angle", "tilt")},
    "diameter": lambda of, _: number(of.diameter, 3),
    "feed": _feed,
    "speed": lambda of, _: number(of.speed_rpm, 0),
    "pitch": lambda of, _: number(of.pitch, 3),
}  # fmt: skip


def _values(command: Any, word: Template, templates: Templates) -> Values:
    """What a word says of a command besides its place."""
    values = {name: of(command, templates.form) for name, of in word.of_command}
    if "tool" in word.names:
        values["tool"] = str(templates.numbers.get((command.kind, command.diameter), ""))
    return values


def _place_values(point: PathPoint | SpindleStroke, word: Template, form: NumberFormat) -> Values:
    """Y and Z of a place, as far as a word says them."""
    return {
        name: number(getattr(point, at)[axis], form.length_decimals)
        for name, (at, axis) in _PLACES.items()
        if name in word.names
    }


def _path_blocks(
    command: PathCycle, templates: Templates, about: Mapping[str, str]
) -> Iterator[str]:
    """The words of a mill or scribe: down at the first point, to each other one, and up."""
    first, *others = command.points
    steps = [(command.kind, first), *((command.kind + "_to", point) for point in others)]
    for name, point in (*steps, (command.kind + "_end", command.points[-1])):
        word = templates.words.get(name)
        if word is not None:
            values = _values(command, word, templates)
            values |= _place_values(point, word, templates.form)
            values["x"] = number(point.x, templates.form.length_decimals)
            yield _filled(word, values, about)


_FIXED = tuple(f"%.{decimals}f" for decimals in range(10))  #: by the decimals


def number(value: float, decimals: int) -> str:
    """`value` with at most `decimals` places: no trailing zeros, no `-0`, never an exponent."""
    text = _FIXED[decimals] % value  # half the time of an f-string's
    if decimals:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def numbered(text: str) -> str:
    """A program with N1, N2, ... before each block; lines with `%` and comments are none."""
    *lines, last = text.split("\n")
    n = 0
    blocks = [line if line[:1] in {"%", "("} else f"N{(n := n + 1)} {line}" for line in lines]
    return "\n".join([*blocks, last])


# --- head -----------------------------------------------------------------------------------------


FORM = 2  #: of a program and its head; a change that a reader has to know of counts it up
NOT_READ_BACK = "NOT VERIFIED: THIS PROGRAM WAS NOT READ BACK"
KINDS_A_LINE = 4  #: of those that may be left out, so that no comment is too long for a controller
DECIMALS = 3  #: of lengths, at least
NUMBER_ROOM = 10  #: characters that a block's number may take
MAX_TEXT = 40  #: characters of a mark, drawing, order, section or grade


def comment_room(machine: Machine) -> int:
    """Characters that a comment of a machine's programs may have."""
    longest = longest_line(machine)
    if longest is None:
        return MAX_COMMENT
    signs = len(machine.words.comment.format(text=""))
    if machine.format.number_blocks:
        signs += NUMBER_ROOM
    return min(MAX_COMMENT, longest - signs)


def head_lines(
    job: Job, plan: AnyPlan, left_out: Mapping[str, int], manual_work: int
) -> Iterator[str]:
    """The lines of a program's head.

    `left_out` are the features that it leaves out, by their kinds; `manual_work` is the number of
    marks left for manual work.
    """
    machine = job.machine
    yield f"BEAMCAM {FORM} MACHINE {one_word(machine.name)} {machine.checksum}".rstrip()
    kinds = sorted(job.request.skips)
    for at in range(0, len(kinds), KINDS_A_LINE):
        yield f"ALLOWED TO BE LEFT OUT: {', '.join(kinds[at : at + KINDS_A_LINE])}"
    missing = [f"{left_out[kind]} {kind}" for kind in sorted(left_out)]
    for at in range(0, len(missing), KINDS_A_LINE):
        yield f"LEFT OUT: {', '.join(missing[at : at + KINDS_A_LINE])}"
    if manual_work:
        yield f"LEFT TO THE HAND: {manual_work}"
    if not job.request.verified:
        yield NOT_READ_BACK
    if job.of > 1:
        yield f"PROGRAM {job.number} OF {job.of}"
    for by in sorted({piece.part.ends_by for piece in plan.pieces} - {""}):
        yield f"ENDS BY THE {by.upper()} OF THE FILE"
    yield from _stock_lines(job, plan)
    room = comment_room(machine)
    for index, piece in enumerate(plan.pieces, 1):
        yield from _part_lines(index, piece, machine, room)


def _stock_lines(job: Job, plan: AnyPlan) -> Iterator[str]:
    """Section or sheet, grade, and the length of the bar."""
    machine = job.machine
    parts = [piece.part for piece in plan.pieces]
    if isinstance(plan, SheetPlan):
        what = f"SHEET {_mm(plan.thickness, machine)}"
    else:
        what = f"SECTION {_joined([part.profile.name or part.profile.code for part in parts])}"
    grades = _joined([part.grade for part in parts])
    yield f"{what} GRADE {grades}" if grades else what
    if isinstance(plan, Plan) and machine.saw is not None:
        as_needed = " AS NEEDED" if job.bar is None else ""
        yield f"BAR {_mm(plan.bar.length, machine)}{as_needed}"


def _joined(texts: Sequence[str]) -> str:
    return outside_text("+".join(dict.fromkeys(text for text in texts if text)))[:MAX_TEXT]


def _part_lines(index: int, piece: Piece, machine: Machine, room: int) -> Iterator[str]:
    """Where a part lies, how large it is and what it is called: one line, or several if need be."""
    begin = line = f"PART {index}"
    for field in _fields(piece, machine):
        if len(line) + 1 + len(field) > room:
            yield line
            line = begin
        line = f"{line} {field}"
    yield line


def _fields(piece: Piece, machine: Machine) -> Iterator[str]:
    part = piece.part
    length = _mm(part.length, machine)
    if machine.stock != "sheet":
        yield f"AT {_mm(piece.start, machine)} LENGTH {length}"
    else:
        x, y = piece.place
        yield f"AT {_mm(x, machine)} {_mm(y, machine)}"
        yield f"SIZE {length} {_mm(part.profile.height, machine)}"
    for key, text in (("MARK", part.mark), ("DRAWING", part.drawing), ("ORDER", part.order)):
        if text:
            yield f"{key} {outside_text(text)[:MAX_TEXT]}"


def _mm(length: float, machine: Machine) -> str:
    return number(length, max(DECIMALS, machine.format.length_decimals))
