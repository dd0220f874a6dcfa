"""A passage of a program, and what stands before all of them, interpreted alone.

The machine is at rest then, and neither a place nor a feed of it is known: what a passage does not
name by itself is not a number.
"""

from collections.abc import Sequence
from math import inf, isnan, nan
from typing import NamedTuple

from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.verify.blocks import USUAL, Block, read_blocks
from beamcam.verify.cell import Cell
from beamcam.verify.codesys import run
from beamcam.verify.events import Event, Move
from beamcam.verify.made import Bore, Cut
from beamcam.verify.meaning import Meaning
from beamcam.verify.stations import Choice, Station, limits_of
from beamcam.verify.switches import AXES

#: What an M word of a stroke may do behind the choice of its spindle.
_AT_A_STROKE = frozenset({"on", "off", "coolant-on", "coolant-off", "other"})

Section = tuple[tuple[str, float], ...]  #: what a program says about the bar


class Passage(NamedTuple):
    """What a passage makes, at any X and place across the bar within its reach, on any line."""

    lines: int
    reach: tuple[float, float, float, float]  #: least and greatest X, and place across
    cut: tuple[float, ...] | None  #: what stands behind the X of its cut; None if it strokes
    strokes: tuple[tuple[int, Station, tuple[object, ...]], ...]  #: line from 0, and behind y
    across: str  #: letter of its place across; "" of a cut


class Alone:
    """The interpreter for pieces of one machine's programs."""

    def __init__(self, machine: Machine, meaning: Meaning, most_m_words: int) -> None:
        self._machine, self._meaning, self._most = machine, meaning, most_m_words
        _, self._least, self._greatest = limits_of(machine, "X")

    def section(self, head: str) -> Section | None:
        """What the head of a program says about the bar; None unless it says all, and no more."""
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
        if said or more or cell.said or not complete or len(blocks) > self._most:
            return None
        return tuple(cell.section.items())

    def passage(
        self, bodies: Sequence[str], profile: Profile, choices: dict[int, Choice], section: Section
    ) -> Passage | None:
        """What blocks without their numbers make; None unless they are from rest to rest."""
        if not all(map(USUAL.fullmatch, bodies)):
            return None
        blocks, _ = read_blocks("\n".join(bodies), "", self._meaning.letters)
        is_cut = self._is_cut(blocks)
        if not is_cut and not self._is_stroke(blocks):
            return None
        feed = nan if self._meaning.feeds else 0.0
        events, wrong = run(blocks, "", self._machine.format, feed)
        cell = self._cell(section, choices, profile)
        cell.play(events)
        if wrong or cell.said or not cell.is_at_rest or not cell.order:
            return None
        if is_cut:
            (cut,) = cell.order
            if type(cut) is not Cut or isnan(cut.feed_mm_min):
                return None
            return Passage(len(bodies), (self._least, self._greatest, -inf, inf), cut[2:], (), "")
        return self._strokes(len(bodies), cell, events)

    def _strokes(self, lines: int, cell: Cell, events: Sequence[Event]) -> Passage | None:
        if any(type(event) is Move and any(map(isnan, event.end)) for event in events):
            return None
        stations = cell.choice.stations if cell.choice is not None else ()
        if any(station.surface_per_y for station in stations):
            return None  # it would be another depth at another place across
        by_face = {station.face: station for station in stations}
        strokes = []
        for bore in cell.order:
            if type(bore) is not Bore or isnan(bore.feed_mm_min):
                return None
            station = by_face[bore.face]
            if not station.clear_from <= bore.y <= station.clear_to:
                return None  # a rapid is looked at in another way there
            strokes.append((bore.line - 1, station, bore[4:]))
        if {station.face for _, station, _ in strokes} != by_face.keys():
            return None  # a spindle that strokes in the air may have less room
        return Passage(lines, self._reach(stations), None, tuple(strokes), AXES[stations[0].across])

    def _reach(self, stations: Sequence[Station]) -> tuple[float, float, float, float]:
        """Least and greatest X, and place across the bar, that all of the spindles reach."""
        least_x, greatest_x, least, greatest = self._least, self._greatest, -inf, inf
        for station in stations:
            for index, _, low, high in station.limits:
                if index == 0:
                    least_x, greatest_x = max(least_x, low), min(greatest_x, high)
                elif index == station.across:
                    least, greatest = max(least, low), min(greatest, high)
        return least_x, greatest_x, least, greatest

    def _cell(self, section: Section, choices: dict[int, Choice], profile: Profile | None) -> Cell:
        cell = Cell(self._machine, self._meaning, choices, profile, "")
        cell.section.update(section)
        return cell

    def _is_cut(self, blocks: list[Block]) -> bool:
        """Whether the blocks bring the bar and cut it."""
        if len(blocks) != 2:
            return False
        (_, go, number, words), (_, saws, word, _) = blocks
        brings = go == "G" and number in (0, 1) and "X" in words and words.keys() <= {"X", "F"}
        if number == 1 and self._meaning.feeds and "F" not in words:
            return False
        return brings and saws == "M" and self._role(word) == "saw"

    def _is_stroke(self, blocks: list[Block]) -> bool:
        """Whether the blocks choose a spindle, and then move and switch it and nothing else."""
        if not blocks:
            return False
        (_, first, chosen, _), *others = blocks
        if first != "M" or self._role(chosen) != "choose" or len(blocks) > self._most:
            return False
        return all(
            number in (0, 1) if command == "G" else self._role(number) in _AT_A_STROKE
            for _, command, number, _ in others
        )

    def _role(self, number: int) -> str:
        word = self._meaning.m_words.get(number)
        return "" if word is None else word.role
