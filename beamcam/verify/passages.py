"""What recurs from program to program is interpreted once: the passages of a program.

Most of a program is a few passages over and over, at another X each time:

    M40 K2 L18               choose a spindle and its tool; nothing turns, every tool is drawn back
    G00 X2400.06 Y15 Z-5     go there, by X, Y and Z
    ...                      stroke
    M05                      and everything is at rest again

    G01 X6184.02 F41.667     bring the bar
    M42 K0                   cut

A passage that finds everything at rest and leaves it so, and that names by itself each place, feed
and tool that it uses, makes the same whatever stands before it, at whatever X, and at whatever
place across the bar that the spindle reaches freely. So its text without block numbers, with marks
in the place of its one X and its one place across, says what it makes. The interpreter is asked
once for each such text, alone, from a machine at rest of which neither place nor feed is known:
what would depend on them is not a number and no passage.

What is said between two passages is looked at for every program: the stop's limits and that it
never goes back. Any program that is not all of such passages, or with which anything is wrong, is
left to the interpreter as a whole, which knows what to say.
"""

import re
from itertools import pairwise
from math import inf, isnan, nan
from typing import NamedTuple

from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.verify.blocks import NUMBER, USUAL, Block, read_blocks
from beamcam.verify.cell import Cell
from beamcam.verify.codesys import run
from beamcam.verify.events import Move
from beamcam.verify.made import Bore, Cut, Made, made_in_order
from beamcam.verify.meaning import Meaning
from beamcam.verify.stations import Choice, Station, limits_of
from beamcam.verify.switches import AXES, EPSILON

MOST_KNOWN = 4096  #: passages that are kept, some 1 KB each
MOST_BARS = 256  #: heads of programs that are kept
MOST_M_WORDS = 16  #: in a row, so that no three of them run the controller out of its queue
_X_MARK, _ACROSS_MARK = "\0", "\1"
_X = re.compile(rf" X({NUMBER})[ \n]")
_PLACES = {letter: re.compile(rf" {letter}({NUMBER})[ \n]") for letter in "YZ"}
_BLOCK_NUMBER = re.compile(r"\nN[0-9]+ ")
_END = re.compile(r"\nM30(?:\n%)?\n*")
#: What an M word of a stroke may do behind the choice of its spindle.
_AT_A_STROKE = frozenset({"on", "off", "coolant-on", "coolant-off", "other"})


class Passage(NamedTuple):
    """What a passage makes, at any X, across the bar and on any line: one cut, or bores."""

    lines: int
    cut: tuple[object, ...]  #: of a cut what stands behind its X; () is none
    stations: tuple[Station, ...]  #: of a stroke
    bores: tuple[tuple[int, Station, tuple[object, ...]], ...]  #: line from 0, and behind y


Section = tuple[tuple[str, float], ...]  #: what a program says about the bar


class Bar(NamedTuple):
    """What passages are read on."""

    profile: Profile
    choices: dict[int, Choice]
    section: Section
    across: dict[str, re.Pattern[str] | None]  #: place across the bar, by the choosing block
    known: dict[str, Passage | None]  #: by text; None is no passage


class Passages:
    """The passages of one machine's programs; it keeps what it has read."""

    def __init__(self, machine: Machine, meaning: Meaning) -> None:
        self._machine, self._meaning = machine, meaning
        words = meaning.m_words
        self._choosing = [f"\nM{n:02} " for n, word in words.items() if word.role == "choose"]
        self._sawing = [f"\nM{n:02} " for n, word in words.items() if word.role == "saw"]
        self._ends = words[30].role == "end" and not words[30].fields
        _, self._least, self._greatest = limits_of(machine, "X")
        self._never_back = machine.layout is not None and machine.layout.order == "saw-drill"
        self._heads: dict[tuple[str, Profile], Bar | None] = {}
        self._bars: dict[tuple[Section, Profile], Bar] = {}
        self._count = 0

    def made(self, text: str, profile: Profile, choices: dict[int, Choice]) -> Made | None:
        """What a program makes on a bar of `profile`, if nothing in it is wrong by itself.

        None says nothing about the program but that the interpreter has to be asked.
        """
        if (
            _X_MARK in text
            or _ACROSS_MARK in text
            or not self._ends
            or (not self._meaning.feeds and "F" in text)
        ):
            return None
        bare = _BLOCK_NUMBER.sub("\n", "\n" + text)
        places = self._places(bare)
        if len(places) < 2 or not _END.fullmatch(bare, places[-1]):
            return None
        bar = self._bar(bare[1 : places[0]], profile, choices)
        if bar is None:
            return None
        order = self._order(bare, places, bar)
        return None if order is None else made_in_order(bar.section, order)

    def _order(self, bare: str, places: list[int], bar: Bar) -> list[Cut | Bore] | None:
        """What the passages between `places` make, one after another; None if that is not known."""
        order: list[Cut | Bore] = []
        line = bare.count("\n", 0, places[0] + 1)
        before = furthest = -inf
        still = 0
        for begin, end in pairwise(places):
            said = bare[begin + 1 : end + 1]
            found = _X.search(said)
            if found is None:
                return None
            word, x = found[0], float(found[1])
            if not self._least <= x <= self._greatest:
                return None
            if self._never_back and x < furthest - EPSILON:
                return None
            shape = said.replace(word, _X_MARK + word[-1])
            first = said[: said.find("\n")]
            pattern = bar.across[first] if first in bar.across else self._across(first, bar)
            across = nan
            if pattern is not None and (found := pattern.search(said)) is not None:
                word, across = found[0][:-1], float(found[1])
                shape = shape.replace(word + " ", _ACROSS_MARK + " ")
                shape = shape.replace(word + "\n", _ACROSS_MARK + "\n")
            passage = bar.known[shape] if shape in bar.known else self._read(said, shape, bar)
            if passage is None:
                return None
            lines, cut, stations, bores = passage
            for station in stations:
                if not _is_free(station, x, across):
                    return None
            if cut:
                # Where nothing moves between cuts their M words follow one another.
                still = still + 1 if x == before else 0
                if still > MOST_M_WORDS:
                    return None
                order.append(Cut(line + lines - 1, x, *cut))  # type: ignore[arg-type]
            for at, station, behind in bores:
                y = station.y(across)
                order.append(Bore(line + at, station.face, x, y, *behind))  # type: ignore[arg-type]
            line += lines
            before = x
            if x > furthest:
                furthest = x
        return order

    def _places(self, bare: str) -> list[int]:
        """Where passages begin, by the line's end before it, and where the end of all does.

        It need not be right: what is no passage will not be taken for one.
        """
        places = []
        for word in self._choosing:
            at = bare.find(word)
            while at >= 0:
                places.append(at)
                at = bare.find(word, at + 1)
        for word in self._sawing:  # the line before brings the bar
            at = bare.find(word)
            while at > 0:
                places.append(bare.rfind("\n", 0, at))
                at = bare.find(word, at + 1)
        places.append(bare.rfind("\nM30"))
        places.sort()
        return places if places[0] >= 0 else []

    def _bar(self, head: str, profile: Profile, choices: dict[int, Choice]) -> Bar | None:
        """What stands before the first passage, if it says what the bar is and nothing else."""
        key = head, profile
        if key in self._heads:
            return self._heads[key]
        if len(self._heads) >= MOST_BARS:
            self._forget()
        section = self._section(head)
        bar = None
        if section is not None:
            bar = self._bars.setdefault((section, profile), Bar(profile, choices, section, {}, {}))
        self._heads[key] = bar
        return bar

    def _forget(self) -> None:
        for bar in self._bars.values():
            bar.known.clear()
        self._heads.clear()
        self._bars.clear()
        self._count = 0

    def _section(self, head: str) -> Section | None:
        if "%" in head[1:]:
            return None
        words = self._meaning.m_words
        blocks, said = read_blocks(head, "", self._meaning.letters)
        for _, command, number, _ in blocks:
            describes = command == "M" and number in words and words[number].role == "section"
            if not describes and (command, number) != ("G", 90):
                return None
        cell = self._cell((), {}, None)
        events, more = run(blocks, "", self._machine.format)
        cell.play(events)
        complete = self._meaning.section_fields <= cell.section.keys()
        if said or more or cell.said or not complete or len(blocks) > MOST_M_WORDS:
            return None
        return tuple(cell.section.items())

    def _cell(self, section: Section, choices: dict[int, Choice], profile: Profile | None) -> Cell:
        cell = Cell(self._machine, self._meaning, choices, profile, "")
        cell.section.update(section)
        return cell

    def _read(self, said: str, shape: str, bar: Bar) -> Passage | None:
        """Read a passage and keep what it makes under `shape`; None if it is none."""
        if self._count >= MOST_KNOWN:
            for other in self._bars.values():
                other.known.clear()
                other.across.clear()
            self._count = 0
        self._count += 1
        passage = None if "X" in shape else self._alone(said, bar)
        if passage is not None and passage.stations:
            letter = AXES[passage.stations[0].across]
            if letter in shape or _ACROSS_MARK not in shape:  # more places across than one
                passage = None
        bar.known[shape] = passage
        return passage

    def _across(self, first: str, bar: Bar) -> re.Pattern[str] | None:
        """How the place across the bar is written behind a block that chooses a spindle."""
        cell = self._cell(bar.section, bar.choices, bar.profile)
        blocks, _ = read_blocks(first, "", self._meaning.letters)
        if self._is_stroke(blocks):
            cell.play(run(blocks, "", self._machine.format)[0])
        letter = "" if cell.choice is None else AXES[cell.choice.stations[0].across]
        bar.across[first] = pattern = _PLACES.get(letter)
        return pattern

    def _alone(self, said: str, bar: Bar) -> Passage | None:
        """What a text of one X makes, alone; None unless it is from rest to rest and clean."""
        lines = said.removesuffix("\n").split("\n")
        if not all(map(USUAL.fullmatch, lines)):
            return None
        blocks, _ = read_blocks(said, "", self._meaning.letters)
        is_cut = self._is_cut(blocks)
        if not is_cut and not self._is_stroke(blocks):
            return None
        feed = nan if self._meaning.feeds else 0.0
        events, wrong = run(blocks, "", self._machine.format, feed)
        cell = self._cell(bar.section, bar.choices, bar.profile)
        cell.play(events)
        if wrong or cell.said or not cell.is_at_rest or not cell.order:
            return None
        if is_cut:
            (cut,) = cell.order
            unknown = type(cut) is not Cut or isnan(cut.feed_mm_min)
            return None if unknown else Passage(len(lines), cut[2:], (), ())
        if any(type(event) is Move and any(map(isnan, event.end)) for event in events):
            return None
        stations = cell.choice.stations if cell.choice is not None else ()
        by_face = {station.face: station for station in stations}
        bores = []
        for bore in cell.order:
            if type(bore) is not Bore or isnan(bore.feed_mm_min):
                return None
            station = by_face[bore.face]
            if not station.clear_from <= bore.y <= station.clear_to:
                return None  # a rapid is looked at in another way there
            bores.append((bore.line - 1, station, bore[4:]))
        return Passage(len(lines), (), stations, tuple(bores))

    def _is_cut(self, blocks: list[Block]) -> bool:
        """Whether the blocks bring the bar and cut it."""
        if len(blocks) != 2:
            return False
        (_, go, number, words), (_, saws, word, _) = blocks
        brings = go == "G" and number in (0, 1) and "X" in words and words.keys() <= {"X", "F"}
        return brings and saws == "M" and self._role(word) == "saw"

    def _is_stroke(self, blocks: list[Block]) -> bool:
        """Whether the blocks choose a spindle, and then move and switch it and nothing else."""
        if not blocks:
            return False
        (_, first, chosen, _), *others = blocks
        if first != "M" or self._role(chosen) != "choose" or len(blocks) > MOST_M_WORDS:
            return False
        return all(
            number in (0, 1) if command == "G" else self._role(number) in _AT_A_STROKE
            for _, command, number, _ in others
        )

    def _role(self, number: int) -> str:
        word = self._meaning.m_words.get(number)
        return "" if word is None else word.role


def _is_free(station: Station, x: float, across: float) -> bool:
    """Whether a spindle may stand at a place, with nothing but its face below."""
    if not station.clear_from <= station.y(across) <= station.clear_to:
        return False
    for index, _, least, greatest in station.limits:
        at = across if index == station.across else x if index == 0 else least
        if not least <= at <= greatest:
            return False
    return True
