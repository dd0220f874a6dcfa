"""Every word of a controller, with usual and absurd values, in every state of bar programs.

Each is put as a block of its own behind the first line of each state (which tool is chosen, whether
it turns and is cooled, whether it is out, before the steel or in it) of the programs of all shipped
lines. What comes of it is read twice: by the read-back, and by a few lines here that share nothing
with it. What is not refused has to leave all that is made as it was, and the row of the word has to
say why; what is refused has to be refused by a code of its row.
"""

import re
from collections import Counter
from collections.abc import Iterator
from fnmatch import fnmatchcase
from itertools import groupby

import pytest
from msgspec import Struct

from beamcam.checks.bars import verify
from beamcam.commands import codes
from beamcam.controllers import interpreter_of
from beamcam.controllers.dialect import DOCUMENTED, dialect_of
from beamcam.errors import Severity
from beamcam.machine import Machine, load
from beamcam.model.part import Part
from beamcam.pipeline import post
from benchmarks.liars import PROFILES, parts
from tests.owners import owner_of

BAR = 6000.0
ROWS = codes.all_owners()["beam", "codesys"]
ABSURD = (-1.0, 0.0, 1e6)
WEB = PROFILES[0].face_depth("v")
#: Of so many blocks of each state one is tried on each line; the exhaustive tests try more.
FEW = {"beamline": 11, "beamline-annex": 12, "beamline-pusher": 40}
MANY = {"beamline": 1, "beamline-annex": 1, "beamline-pusher": 2}


class Program(Struct, frozen=True):
    machine: Machine
    parts: tuple[Part, ...]
    lines: tuple[str, ...]


class Words(Struct, frozen=True):
    """A block to put in, and whose row answers for it."""

    block: str
    word: str
    carries: str = ""


def program(name: str) -> Program:
    machine = load(name)
    made = parts(name, PROFILES[0])
    text = post(made, machine, bar=BAR).text
    assert isinstance(text, str)
    return Program(machine, made, tuple(re.sub(r"(?m)^N\d+ ", "", text).splitlines()))


# What a program makes, told in the simplest way


class Modal(Struct):
    """What holds from block to block."""

    at: dict[str, float]
    choice: tuple[str, ...] = ()
    pitch: str = ""
    turning: str = ""
    cooling: str = ""
    absolute: bool = True
    motion: str = ""

    @property
    def depth(self) -> str:
        """Where the stroke stands: a web lies behind its flanges, which begin at 0."""
        web = self.choice and self.choice[0].startswith("K2")
        stroke = self.at.get("Z" if web else "Y", -1.0)
        return "out" if stroke <= 0.0 else "near" if web and stroke <= WEB else "in"


def walk(lines: tuple[str, ...]) -> Iterator[tuple[Modal, tuple[object, ...] | None]]:
    """The state behind each line, and what the line makes."""
    now = Modal({})
    for line in lines:
        words = re.sub(r"\(.*?\)", "", line).split()
        made: tuple[object, ...] | None = None
        command = words[0] if words else ""
        if re.fullmatch(r"M4[05789]|M50", command):
            now.choice, now.pitch = (*_figures(words[1:]), command), ""
        elif command == "M46" and now.choice and now.choice[-1] == "M45":
            (now.pitch,) = _figures(words[1:])
        elif command in ("M03", "M04", "M05"):
            now.turning = "" if command == "M05" else " ".join(words)
        elif command in ("M08", "M09", "M07"):
            now.cooling = "" if command == "M09" else command
        elif command in ("M41", "M42"):
            made = ("cut", now.at.get("X"), *_figures(words))
        elif command in ("M43", "M44"):
            made = ("section", *_figures(words))
        elif command in ("G90", "G91"):
            now.absolute = command == "G90"
        elif command in ("G00", "G01"):
            now.motion = command
            values = {w[0]: float(w[1:]) for w in words[1:] if w[0] in "XYZ"}
            before = dict(now.at)
            for letter, value in values.items():
                now.at[letter] = value if now.absolute else value + now.at.get(letter, 0.0)
            if now.at != before and now.motion == "G01" and now.depth == "in":
                feed = [w for w in words if w[0] == "F"]
                place = sorted(now.at.items())
                turns = now.turning[:3]  # any speed within the cutting data will do
                made = (now.choice, now.pitch, turns, now.cooling, *place, *feed)
        yield now, made


def _figures(words: list[str]) -> tuple[str, ...]:
    """Words however their figures are written."""
    return tuple(f"{word[0]}{float(word[1:]):g}" for word in words)


def makes(lines: tuple[str, ...]) -> list[tuple[object, ...]]:
    """All that is made, and what is said of the section, which may be said again.

    Of a mill's path its corners count: within the slot it may go where it likes.
    """
    found = [made for _, made in walk(lines) if made is not None]
    sections = {made for made in found if made[0] == "section"}
    rest: list[tuple[object, ...]] = []
    for milled, group in groupby((m for m in found if m not in sections), _is_milled):
        run = list(group)
        places = [dict(made[4:7]) for made in run] if milled else []  # type: ignore[arg-type]
        box = [(min(p[a] for p in places), max(p[a] for p in places)) for a in "XYZ" if places]
        rest += [("milled", *box)] if milled else run
    return [*sorted(sections, key=str), *rest]


def _is_milled(made: tuple[object, ...]) -> bool:
    return isinstance(made[0], tuple) and "M49" in made[0]


def states(lines: tuple[str, ...]) -> Iterator[tuple[int, Modal]]:
    """The first line behind which each state holds, with what holds there."""
    seen = set()
    done = 0
    for index, (now, made) in enumerate(walk(lines)):
        done += made is not None
        kind = now.choice[-1] if now.choice else ""
        first = (bool(done), index > len(lines) - 6)
        key = (kind, now.turning[:3], now.cooling, now.depth, now.motion, bool(now.at), first)
        if key not in seen:
            seen.add(key)
            at = dict(now.at)
            yield (
                index,
                Modal(at, now.choice, now.pitch, now.turning, now.cooling, motion=now.motion),
            )


# The words


def blocks(machine: Machine, now: Modal) -> Iterator[Words]:
    """Every word that the controller knows, with usual and absurd values."""
    at = {letter: now.at.get(letter, 100.0) for letter in "XYZ"}
    here = " ".join(f"{letter}{value:f}" for letter, value in at.items())
    for code, letters in sorted(interpreter_of(machine, "").vocabulary().items()):
        if not re.fullmatch(r"G\d+", code):
            continue
        number = f"G{int(code[1:]):02}"
        if letters.isdisjoint("XYZ"):
            yield Words(number, code)
            for letter in sorted(letters):
                for value in (0.5, 2.0, *ABSURD):
                    yield Words(f"{number} {letter}{value:f}", code, letter)
            continue
        yield Words(number, code)
        curve = "" if letters.isdisjoint("IJ") else " I5 J0"
        yield Words(f"{number} {here}{curve} F100", code)
        for letter in sorted(letters & set("XYZ")):
            for value in (at[letter], at[letter] + 0.5, *ABSURD):
                yield Words(f"{number} {letter}{value:f}{curve}", code, letter)
        for letter in sorted(letters - set("XYZ")):
            for value in (1.5, 900.0, *ABSURD):
                said = f"E{-abs(value):f}" if letter == "E-" else f"{letter}{value:f}"
                yield Words(f"{number} X{at['X']:f} {said}", code, letter)
    yield Words("M02", "M2")
    yield from m_blocks(machine, now)


def m_blocks(machine: Machine, now: Modal) -> Iterator[Words]:
    """The machine's M words: as the program has them where it is, and each value another one."""
    usual = {
        "spindle": 2.0, "diameter": 14.0, "speed": 568.0, "angle": 0.0, "tilt": 0.0, "feed": 1.3,
        "section": 1.0, "width": 150.0, "height": 300.0, "pitch": 1.75,
    }  # fmt: skip
    for word, field in zip(now.choice, ("spindle", "diameter"), strict=False):
        usual[field] = float(word[1:])
    if now.turning and " K" in now.turning:
        usual["speed"] = float(now.turning.split(" K")[1])
    if machine.saw is not None:
        usual["angle"] = machine.saw.zero_angle
    for number, word in sorted(dialect_of(machine).m_words.items()):
        name = f"M{number}" if number in DOCUMENTED else word.role
        said = {letter: usual[field] for letter, field in word.fields}
        yield Words(_block(number, said), name)
        for letter, field in word.fields:
            for value in (usual[field] + 1.0, usual[field] + 0.5, *ABSURD):
                yield Words(_block(number, {**said, letter: value}), name, f"{{{field}}}")


def _block(number: int, said: dict[str, float]) -> str:
    return " ".join((f"M{number:02}", *(f"{letter}{value:.6f}" for letter, value in said.items())))


# What becomes of them


Row = tuple[str, str]  #: a word, and what it carries


class Tried(Struct):
    """What became of the words in one line's programs."""

    odd: list[tuple[str, str, str]]  #: line, block and what is odd about it
    passed: Counter[Row]
    refused: Counter[Row]


def tried(program: Program, every: int) -> Tried:
    """Every block in every state. Of a long program each state gets one in `every` of them, but
    each where the program begins: G91 does no harm there alone, before G90."""
    before = makes(program.lines)
    found = Tried([], Counter(), Counter())
    for turn, (index, now) in enumerate(states(program.lines)):
        step = every if index else 1
        for words in [*blocks(program.machine, now)][turn % step :: step]:
            lines = (*program.lines[: index + 1], words.block, *program.lines[index + 1 :])
            text = "\n".join(lines) + "\n"
            row = owner_of(words.word, words.carries, ROWS)
            # A block in front of the last line of the head parts the program from what it says.
            refusing = {*row.refused_by, *owner_of(words.word, "", ROWS).refused_by, "verify-head"}
            said = verify(text, program.parts, program.machine, bar=BAR)
            errors = {d.code for d in said if d.severity is Severity.ERROR}
            wrong = ""
            if errors:
                found.refused[words.word, words.carries] += 1
                if not any(fnmatchcase(code, p) for code in errors for p in refusing):
                    wrong = f"refused by {', '.join(sorted(errors))}"
            else:
                found.passed[words.word, words.carries] += 1
                wrong = "" if row.harmless else "passes, and its row does not say why"
                if makes(lines) != before:
                    wrong = "passes, and makes something else"
            if wrong:
                found.odd.append((f"{index + 1} {program.lines[index]}", words.block, wrong))
    return found


@pytest.mark.parametrize(
    ("lines", "refused", "passed"),
    [(FEW, 650, 100), pytest.param(MANY, 8000, 1000, marks=pytest.mark.exhaustive)],
)
def test_every_word_in_every_state_is_refused_or_harmless(
    lines: dict[str, int], refused: int, passed: int
) -> None:
    """Nor does a row give a reason that nothing needs, or name a code that never comes."""
    all_tried = {name: tried(program(name), every) for name, every in lines.items()}
    assert {name: found.odd for name, found in all_tried.items() if found.odd} == {}
    assert sum(found.refused.total() for found in all_tried.values()) > refused
    assert sum(found.passed.total() for found in all_tried.values()) > passed
    assert wrong_rows(all_tried) == set()


def wrong_rows(all_tried: dict[str, Tried]) -> set[tuple[object, ...]]:
    """Rows that say harmless where nothing passed, or name codes where nothing was refused."""
    passed = {row for found in all_tried.values() for row in found.passed}
    refused = {row for found in all_tried.values() for row in found.refused}
    wrong: set[tuple[object, ...]] = set()
    for word, carries in passed | refused:
        row = owner_of(word, carries, ROWS)
        alike = {(w, c) for w in row.words for c in row.carries or ("",)}
        if bool(row.harmless) == alike.isdisjoint(passed):
            wrong.add((row.words, row.carries, "harmless"))
        if bool(row.refused_by) == alike.isdisjoint(refused):
            wrong.add((row.words, row.carries, "refused_by"))
    return wrong


def test_the_reading_here_sees_what_is_made() -> None:
    lines = program("beamline-pusher").lines
    assert len(makes(lines)) > 20
    assert len(list(states(lines))) > 30
    fed = next(i for i, line in enumerate(lines) if line.startswith("G01"))
    assert makes((*lines[:fed], *lines[fed + 1 :])) != makes(lines)
