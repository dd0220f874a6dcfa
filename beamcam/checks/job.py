"""The programs of a job against its request: the head of each, their pieces together, and what
may be missing.

The head of a program records how it was made and what it is:

    (BEAMCAM 2 MACHINE beamline 5f3a9c2e)        version of the form, machine, checksum of its file
    (ALLOWED TO BE LEFT OUT: cope, slot)         the kinds that --allow-skips named, if any
    (LEFT OUT: 2 slot)                           what is missing, by count, if anything
    (LEFT TO THE HAND: 2)                        features left for manual work, if any
    (PROGRAM 2 OF 3)                             of a job of several
    (SECTION UPN200 GRADE S235JR)                of a sheet (SHEET 10 GRADE S235JR)
    (BAR 12000)                                  or (BAR 1532.086 AS NEEDED): so long at least
    (PART 1 AT 20 LENGTH 1500 MARK M58 DRAWING 12 ORDER 7)

It is read whatever signs a controller has for comments, and written nowhere in this package. The
lines follow each other, all between the signs of the first one; what stands elsewhere in a program
is no head. A program whose head differs from the request, or from what the program does, is
refused. Nothing in a head excuses a program but the kinds that may be left out, which
`verify` takes from it where no others are named.

Pieces are counted from the parts and quantities of the request; which share of them a program
holds is the planner's word, and is only believed where all shares together are the request.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

from msgspec import Struct

from beamcam.checks.rules import LEFT_OUT, MANUAL_WORK, PIECE_ORDER, PIECES, STOCK_BAR
from beamcam.errors import Diagnostic, Source, error, warning
from beamcam.machine.machine import Machine
from beamcam.model.description import description
from beamcam.model.part import Feature, Part, TextMark
from beamcam.model.request import Job, Request, policy_on
from beamcam.plain_text import outside_text

VERSION = 2  #: newest form that is known
STOCK_FORM = 2  #: the first form that says the stock and the parts
MOST_BEFORE = 65_536  #: characters of a program before its head
MOST_LINES = 20_000  #: of the head itself, more than the pieces of any program
ROUNDED = 0.0011  #: mm that lengths in a head are rounded to, and as much for a second rounding
MAX_TEXT = 40  #: characters of a text in a head

_MADE = re.compile(
    r"^([^\n]*?)BEAMCAM ([0-9]{1,6}) MACHINE ([A-Za-z0-9._-]+)(?: ([0-9a-f]{8})\b)?([^\n]*)$",
    re.MULTILINE,
)
_NUMBERED = re.compile(r"N[0-9]+\s+")
_MM = r"(-?[0-9]{1,9}(?:\.[0-9]{1,6})?)"
_ALLOWED = re.compile(r"ALLOWED TO BE LEFT OUT: ([a-z-]+(?:, [a-z-]+)*)")
_LEFT_OUT = re.compile(r"LEFT OUT: ([0-9]{1,9} [a-z-]+(?:, [0-9]{1,9} [a-z-]+)*)")
#: What a line of a head states: the first of each form counts.
_STATEMENTS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], dict[str, Any]]], ...] = (
    (re.compile(r"LEFT TO THE HAND: ([0-9]{1,9})"), lambda m: {"manual_work": int(m[1])}),
    (re.compile(r"PROGRAM ([0-9]{1,6}) OF ([0-9]{1,6})"),
     lambda m: {"program": (int(m[1]), int(m[2]))}),
    (re.compile(r"(?:SECTION|SHEET) (.*?)(?: GRADE (.*))?"),
     lambda m: {"stock": m[1], "grade": m[2] or ""}),
    (re.compile(rf"BAR {_MM}( AS NEEDED)?"),
     lambda m: {"bar": float(m[1]), "as_needed": bool(m[2])}),
)  # fmt: skip
_PART = re.compile(r"PART ([0-9]{1,6}) ((?:AT|SIZE|MARK|DRAWING|ORDER) .*)")
_FIGURES = re.compile(rf"AT {_MM}(?: LENGTH {_MM}| {_MM} SIZE {_MM} {_MM})(?: (.*))?")

HEAD = error("verify-head",
    "found {found} in the head of the program; expected {expected}",
    "The head says which kinds of features may be missing, how many marks are left for manual "
    "work, for which machine file the program was made, the bar, and where its parts lie. A wrong "
    "head would mislead a later check, and the operator who loads the bar.")  # fmt: skip
HEAD_TEXT = warning("verify-head-text",
    "found {found} in the head of the program; expected {expected}",
    "The program may have been made for a part of the same shape with another mark, drawing, "
    "order, section or grade. It cuts what it was held against, but says another "
    "name.")  # fmt: skip
HEAD_BAR = error("verify-head-bar",
    "found a program for a bar of {found} mm in its head; expected {expected} mm, as --bar says",
    "The program was laid out for the bar that its head names. Load that one, or post the parts "
    "again for the bar that there is.")  # fmt: skip
NEWER = warning("verify-head-newer",
    "found a program of form {found}; expected {expected} at most, this beamcam is older",
    "A newer beamcam may say things in a program that this one does not look for.")  # fmt: skip
MACHINE_CHANGED = warning("verify-machine-changed",
    "found a program for the machine {found}; the machine file is now {expected}",
    "The machine's file has changed since the program was made: offsets, tools or limits may be "
    "others. Post the part again.")  # fmt: skip


class HeadPart(Struct, frozen=True):
    """A part as a head tells of it; lengths in mm."""

    at: tuple[float, ...]  #: x on the bar, or x and y on the sheet, of its x 0, y 0
    size: tuple[float, ...]  #: length; of a plate and width
    texts: str = ""  #: `MARK M58 DRAWING 12 ORDER 7`


class Head(Struct, frozen=True):
    """The head of a program."""

    version: int
    machine: str
    checksum: str  #: "" where the machine did not come from a file
    allowed: tuple[str, ...]  #: kinds of features that may be left out, sorted
    manual_work: int = 0  #: marks left for manual work
    left_out: int = 0  #: features that are missing
    program: tuple[int, int] = (1, 1)  #: its number, and of how many
    stock: str = ""  #: the section, or the thickness of the sheet
    grade: str = ""
    bar: float | None = None  #: length, mm
    as_needed: bool = False  #: whether a longer bar does as well
    parts: tuple[HeadPart, ...] = ()


def head_of(text: str) -> Head | None:
    """The head of a program; None for one without a head, such as a handwritten one."""
    made = _MADE.search(text, 0, MOST_BEFORE)
    if made is None:
        return None
    kinds: set[str] = set()
    values: dict[str, Any] = {}
    parts: dict[str, str] = {}
    for line in _lines(text, made):
        if match := _ALLOWED.fullmatch(line):
            kinds.update(match[1].split(", "))
        elif match := _LEFT_OUT.fullmatch(line):
            counts = [int(one.split()[0]) for one in match[1].split(", ")]
            values["left_out"] = values.get("left_out", 0) + sum(counts)
        elif match := _PART.fullmatch(line):
            parts[match[1]] = f"{parts[match[1]]} {match[2]}" if match[1] in parts else match[2]
        else:
            for pattern, read in _STATEMENTS:
                if match := pattern.fullmatch(line):
                    values = read(match) | values
    in_order = [*parts] == [str(number) for number in range(1, len(parts) + 1)]
    stated = []
    for value in parts.values() if in_order else ():
        figures = _FIGURES.fullmatch(value)
        if figures is None:  # without a place
            stated.append(HeadPart((), (), value))
            continue
        x, length, y, long, wide, texts = figures.groups()
        at = (float(x),) if y is None else (float(x), float(y))
        size = (float(length),) if y is None else (float(long), float(wide))
        stated.append(HeadPart(at, size, texts or ""))
    return Head(
        int(made[2]), made[3], made[4] or "", tuple(sorted(kinds)), parts=tuple(stated), **values
    )


def _lines(text: str, made: re.Match[str]) -> Iterator[str]:
    """The texts of the comments behind the first line of a head, as far as they go."""
    begin, end = _NUMBERED.sub("", made[1], count=1), made[5].rstrip("\r")
    if begin == "(":
        end = ")"  # another comment may stand behind it
    at = made.end() + 1
    for _ in range(MOST_LINES):
        stop = text.find("\n", at)
        line = text[at : len(text) if stop < 0 else stop].rstrip("\r")
        if not line.startswith(begin):
            line = _NUMBERED.sub("", line, count=1)
        if not (line.startswith(begin) and line.endswith(end) and stop >= 0):
            return
        value = line[len(begin) : len(line) - len(end)]
        yield value.partition(end)[0] if end else value
        at = stop + 1


def head_faults(
    head: Head | None, job: Job, bar: float | None, left_out: int, manual_work: int
) -> Iterator[Diagnostic]:
    """All differences of a head from the job and from the read-back of the program.

    `bar` is the length that the head has to name, if it has to name one. `left_out` are the
    features that the read-back found missing, `manual_work` the marks left for manual work.
    """
    source, machine, allowed = Source(job.request.name), job.machine, job.request.skips
    kinds = ", ".join(sorted(allowed)) or "none"
    if head is None:
        yield HEAD.at(source, found="no head", expected=f"one that allows {kinds}")
        return
    bars, lengths = ("no bar", "a bar"), ("a bar of one length", "a bar as needed")
    form = "the form {} and the checksum {}"
    for found, expected in (
        (f"a head that allows {', '.join(head.allowed) or 'none'}", f"a head that allows {kinds}"),
        (f"{head.manual_work} left for manual work", f"{manual_work} left for manual work"),
        (f"{head.left_out} left out", f"{left_out} left out"),
        ("program {} of {}".format(*head.program), f"program {job.number} of {job.of}"),
        (form.format(head.version, head.checksum or "none"),
         form.format(VERSION, machine.checksum or "none")),
        (bars[head.bar is not None], bars[bar is not None]),
        (lengths[head.as_needed], lengths[bar is not None and job.bar is None]),
    ):  # fmt: skip
        if found != expected:
            yield HEAD.at(source, found=found, expected=expected)
            return
    if bar is not None and head.bar is not None and abs(head.bar - bar) > ROUNDED:
        yield HEAD.at(source, found=f"a bar of {head.bar:.3f}", expected=f"{bar:.3f}")


def head_remarks(head: Head | None, machine: Machine, name: str) -> Iterator[Diagnostic]:
    """A warning where a program was made by a newer beamcam, or for another machine file."""
    if head is None:
        return
    if head.version > VERSION:
        yield NEWER.at(Source(name), found=head.version, expected=VERSION)
    if head.checksum and machine.checksum and head.checksum != machine.checksum:
        found, expected = f"{head.machine} {head.checksum}", f"{machine.name} {machine.checksum}"
        yield MACHINE_CHANGED.at(Source(name), found=found, expected=expected)


def other_bar(head: Head | None, bar: float | None, name: str) -> Iterator[Diagnostic]:
    """An error where the head names another bar than the user; a longer one than needed is none."""
    if head is None or head.bar is None or bar is None:
        return
    if bar < head.bar - ROUNDED or (bar > head.bar + ROUNDED and not head.as_needed):
        yield HEAD_BAR.at(Source(name), found=f"{head.bar:g}", expected=f"{bar:g}")


def stock_faults(
    head: Head, parts: Sequence[Part], sheet: float | None, machine: Machine, name: str
) -> Iterator[Diagnostic]:
    """What a head says otherwise of the stock: the section, or the thickness of a sheet in mm."""
    if head.version < STOCK_FORM:
        return
    source = Source(name)
    if machine.saw is not None and machine.stock == "beam" and head.bar is None:
        yield HEAD.at(source, found="no bar", expected="the length of the bar")
    if sheet is not None:
        if not head.stock.replace(".", "", 1).isdigit() or abs(float(head.stock) - sheet) > ROUNDED:
            yield HEAD.at(source, found=f"a sheet of {head.stock or 'nothing'}", expected=sheet)
    elif head.stock != (of := _joined(part.profile.name or part.profile.code for part in parts)):
        yield HEAD_TEXT.at(source, found=f"the section {head.stock or 'none'}", expected=of)
    grades = _joined(part.grade for part in parts)
    if head.grade != grades:
        found = f"the grade {head.grade or 'none'}"
        yield HEAD_TEXT.at(source, found=found, expected=grades or "none")


def _joined(texts: Iterable[str]) -> str:
    return outside_text("+".join(dict.fromkeys(text for text in texts if text)))[:MAX_TEXT]


def part_faults(
    head: Head, lie: Sequence[tuple[Part, tuple[float, ...]]], slack: float, free: bool, name: str
) -> Iterator[Diagnostic]:
    """What a head says otherwise of the parts, which lie as the program was found to make them.

    Each part is given with x on the bar, or x and y on the sheet, of its x 0, y 0; places may
    differ by `slack`. Where the order is `free`, parts of one shape may have changed places.
    """
    if head.version < STOCK_FORM:
        return
    source = Source(name)
    if len(head.parts) != len(lie):
        yield HEAD.at(source, found=f"{len(head.parts)} part(s)", expected=len(lie))
        return
    for number, (stated, (part, at)) in enumerate(zip(head.parts, lie, strict=True), 1):
        size = (part.length,) if len(at) == 1 else (part.length, part.profile.height)
        if not (_near(stated.at, at, slack) and _near(stated.size, size, ROUNDED)):
            found, expected = (
                f"at {_shown(a, ' ')}, {_shown(b, ' x ')} mm" if a else "nowhere"
                for a, b in ((stated.at, stated.size), (at, size))
            )
            yield HEAD.at(source, found=f"part {number} {found}", expected=expected)
    stated_texts = [stated.texts for stated in head.parts]
    expected_texts = []
    for part, _ in lie:
        named = (("MARK", part.mark), ("DRAWING", part.drawing), ("ORDER", part.order))
        texts = [f"{key} {outside_text(text)[:MAX_TEXT]}" for key, text in named if text]
        expected_texts.append(" ".join(texts))
    if free:
        stated_texts, expected_texts = sorted(stated_texts), sorted(expected_texts)
    for one, expected in zip(stated_texts, expected_texts, strict=True):
        if one != expected:
            found = f"a part {one}" if one else "a part without a name"
            yield HEAD_TEXT.at(source, found=found.strip(), expected=expected or "no name")


def _near(stated: Sequence[float], actual: Sequence[float], slack: float) -> bool:
    return len(stated) == len(actual) and all(
        abs(a - b) <= slack + ROUNDED for a, b in zip(stated, actual, strict=True)
    )


def _shown(values: Sequence[float], between: str) -> str:
    return between.join(f"{value:.3f}" for value in values)


# --- pieces ---------------------------------------------------------------------------------------


SLACK = 1e-6  #: mm between a bar in store and the one that a program is for


def pieces_asked(request: Request) -> Counter[int]:
    """How many pieces of each part the programs have to make, by its place in the request.

    A line without a saw is fed one cut piece at a time and runs the program for each of them.
    """
    quantity, machine = request.quantity, request.machine
    alone = quantity is None or (machine.stock == "beam" and machine.saw is None)
    counts: Counter[int] = Counter()
    for place, part in enumerate(request.parts):
        counts[place] = 1 if alone else part.quantity if quantity == "file" else int(quantity or 0)
    return counts


def job_faults(request: Request, jobs: Sequence[Job]) -> tuple[Diagnostic, ...]:
    """What the programs of a request make too often or too seldom, in another order, or from a bar
    that is not in store."""
    counts, parts = pieces_asked(request), request.parts
    diagnostics: list[Diagnostic] = []
    made = Counter(place for job in jobs for place in job.pieces)
    for place in sorted(counts.keys() | made.keys()):
        if made[place] != counts[place]:
            part = parts[place] if 0 <= place < len(parts) else None
            source, mark = (part.source, part.mark) if part else (Source(request.name), "")
            diagnostics.append(
                PIECES.at(source, found=made[place], mark=mark or "a part", expected=counts[place])
            )
    for job in jobs:
        for before, after in pairwise(job.pieces):
            if after < before:
                first, then = parts[before], parts[after]
                diagnostics.append(PIECE_ORDER.at(then.source, found=then.mark, before=first.mark))
    remnants = [*request.remnants]  # each is there once
    sawn = request.machine.saw is not None  # a part that comes in cut is a bar by itself
    for job in jobs:
        bar = job.bar
        if bar is None and not (request.stock and sawn):
            continue
        once = [one for one in remnants if bar is not None and abs(bar - one) <= SLACK]
        if once:
            remnants.remove(once[0])
        elif bar is None or all(abs(bar - one) > SLACK for one in request.stock):
            found = "any length" if bar is None else f"{bar:g} mm"
            there = [*request.stock, *remnants]
            lengths = " or ".join(f"{one:g} mm" for one in there) or "one of any length"
            source = Source(request.name)
            diagnostics.append(STOCK_BAR.at(source, found=found, expected=lengths))
    return tuple(diagnostics)


# --- missing --------------------------------------------------------------------------------------

# Features that a program leaves out, or leaves for manual work, reported one by one.


def left_out(part: Part, features: Iterable[int]) -> Iterator[Diagnostic]:
    """A warning for each of the features of a part, by their indices, that a program leaves out."""
    for index in sorted(features):
        feature = part.features[index]
        yield LEFT_OUT.at(feature.source, what=description(feature), mark=part.mark)


def is_manual_work(feature: Feature, machine: Machine) -> bool:
    """Whether a feature is not the machine's work."""
    policy = policy_on(feature, machine.marks)
    if policy == "make" and isinstance(feature, TextMark):
        return machine.marks.unit == "none"
    return policy == "list"


def left_to_manual_work(part: Part, machine: Machine) -> Iterator[Diagnostic]:
    """A warning for each feature of a part that is not the machine's work."""
    for feature in part.features:
        if is_manual_work(feature, machine):
            yield manual_work(feature, part, machine)


def manual_work(feature: Feature, part: Part, machine: Machine) -> Diagnostic:
    """The remark that a feature is left for manual work."""
    return MANUAL_WORK.at(
        feature.source, what=description(feature), mark=part.mark, machine=machine.name
    )
