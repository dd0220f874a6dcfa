"""Emitters: programs and tables as text. Here what all of them print: numbers, and the head.

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

from collections.abc import Iterator, Mapping, Sequence
from itertools import count

from beamcam.controllers import longest_line
from beamcam.machine.machine import Machine
from beamcam.model.plan import AnyPlan, Piece, Plan, SheetPlan
from beamcam.model.request import Job
from beamcam.plain_text import MAX_COMMENT, one_word, outside_text


def number(value: float, decimals: int) -> str:
    """`value` with at most `decimals` places: no trailing zeros, no `-0`, never an exponent."""
    text = "%.*f" % (decimals, value)  # noqa: UP031  half the time of an f-string's
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def numbered(text: str) -> str:
    """A program with N1, N2, ... before each block; lines with `%` and comments are none."""
    *lines, last = text.split("\n")
    numbers = count(1)
    blocks = [line if line.startswith(("%", "(")) else f"N{next(numbers)} {line}" for line in lines]
    return "\n".join([*blocks, last])


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
