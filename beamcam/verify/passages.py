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
place across the bar that the spindle reaches freely. So its words but for its one X and its one
place across say what it makes. The interpreter is asked once for each such text, alone, from a
machine at rest of which neither place nor feed is known (`alone`): what would depend on them is
not a number and no passage.

What is said between two passages is looked at for every program: the stop's limits and that it
never goes back. Any program that is not all of such passages, or with which anything is wrong, is
left to the interpreter as a whole, which knows what to say.
"""

import re
from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from math import inf
from typing import NamedTuple

from beamcam.machine.known import Kept
from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.verify.alone import Alone, Passage, Section
from beamcam.verify.forms import Forms, Words, body_of
from beamcam.verify.made import Bore, Cut, Made
from beamcam.verify.meaning import Meaning
from beamcam.verify.stations import Choice
from beamcam.verify.switches import EPSILON

MOST_KNOWN = 4096  #: passages that are kept, some 1 KB each
MOST_BARS = 256  #: that are kept, and as many heads of programs
MOST_M_WORDS = 16  #: in a row, so that no three of them run the controller out of its queue
_NONE: dict[Words, Passage] = {}
_bore = partial(tuple.__new__, Bore)  # as Bore(*...), in half the time
_END = re.compile(r"(?:N[0-9]+ )?M30(?:\n%)?\n*")


class Bar(NamedTuple):
    """What passages are read on."""

    profile: Profile
    choices: dict[int, Choice]
    section: Section
    known: dict[int, dict[Words, Passage]]  #: by form, and words but for X and place across


class Passages:
    """The passages of one machine's programs; it keeps what it has read."""

    def __init__(self, machine: Machine, meaning: Meaning) -> None:
        self._alone = Alone(machine, meaning, MOST_M_WORDS)
        words = meaning.m_words
        self._choosing = tuple(f"M{n:02} " for n, word in words.items() if word.role == "choose")
        self._sawing = tuple(f"M{n:02} " for n, word in words.items() if word.role == "saw")
        self._ends = words[30].role == "end" and not words[30].fields
        self._feeds = meaning.feeds
        self._never_back = machine.layout is not None and machine.layout.order == "saw-drill"
        self._forget()

    def _forget(self) -> None:
        self._forms = Forms()
        self._heads: Kept[tuple[str, Profile], Bar] = Kept(MOST_BARS)
        self._bars: dict[tuple[Section, Profile], Bar] = {}
        self._count = 0

    def made(self, text: str, profile: Profile, choices: dict[int, Choice]) -> Made | None:
        """What a program makes on a bar of `profile`, if nothing in it is wrong by itself.

        None says nothing about the program but that the interpreter has to be asked.
        """
        if not self._ends or (not self._feeds and "F" in text):
            return None
        made = self._recognised(text, profile)
        if made is None and self._learns(text, profile, choices):
            made = self._recognised(text, profile)
        return made

    def _recognised(self, text: str, profile: Profile) -> Made | None:
        """What a program makes whose head and passages are all known, up to its end."""
        first = self._forms.pattern.search(text)
        if first is None:
            return None
        head = text[: first.start()]
        bar = self._heads.get((head, profile))
        return None if bar is None else self._followed(text, len(head), head.count("\n") + 1, bar)

    def _followed(self, text: str, at: int, line: int, bar: Bar) -> Made | None:
        """What the passages from `at` on make, the first of which begins on `line`."""
        order: list[Cut | Bore] = []
        cuts: list[Cut] = []
        bores: list[Bore] = []
        before = furthest = -inf
        still = 0
        groups, known, match_at = self._forms.groups, bar.known, self._forms.pattern.match
        while (match := match_at(text, at)) is not None:
            at = match.end()
            form = match.lastindex or 0
            words = match.group(*groups[form])
            passage = known.get(form, _NONE).get(words[2:])
            if passage is None:
                return None
            try:
                x, across = float(words[0]), float(words[1])
            except ValueError:  # such as "1.2.3", which the interpreter speaks of
                return None
            lines, reach, cut, strokes, _ = passage
            if not (reach[0] <= x <= reach[1] and reach[2] <= across <= reach[3]):
                return None
            if self._never_back and x < furthest - EPSILON:
                return None
            if cut is not None:
                # Where nothing moves between cuts their M words follow one another.
                still = still + 1 if x == before else 0
                if still > MOST_M_WORDS:
                    return None
                cuts.append(Cut(line + lines - 1, x, *cut))
                order.append(cuts[-1])
            for below, station, tool in strokes:
                y = station.y(across)
                if not station.clear_from <= y <= station.clear_to:
                    return None
                bores.append(_bore((line + below, station.face, x, y, *tool)))
                order.append(bores[-1])
            line += lines
            before = x
            if x > furthest:
                furthest = x
        if _END.fullmatch(text, at) is None:
            return None
        return Made(bar.section, tuple(cuts), tuple(bores), (), tuple(order))

    def _learns(self, text: str, profile: Profile, choices: dict[int, Choice]) -> bool:
        """Read what is not known of a program; whether that was something and all could be read."""
        lines = text.split("\n")
        begins = self._begins([body_of(line) for line in lines])
        if not 2 <= len(begins) <= MOST_KNOWN:
            return False
        if self._count + len(begins) > MOST_KNOWN or self._forms.is_full:
            self._forget()
        head = "".join(f"{line}\n" for line in lines[: begins[0]])
        bar = self._heads.get((head, profile))
        learned = bar is None
        if bar is None and (bar := self._bar(head, profile, choices)) is None:
            return False
        for begin, end in pairwise(begins):
            passage = lines[begin:end]
            if not self._is_known(passage, bar):
                if not self._read(passage, bar):
                    return False
                learned = True
        return learned

    def _bar(self, head: str, profile: Profile, choices: dict[int, Choice]) -> Bar | None:
        """The bar that a head describes, from now on a known one; None if it is no mere head."""
        section = self._alone.section(head)
        if section is None:
            return None
        bar = self._bars.get((section, profile))
        if bar is None:
            if len(self._bars) >= MOST_BARS:
                self._forget()
            bar = self._bars[section, profile] = Bar(profile, choices, section, {})
        return self._heads.keep((head, profile), bar)

    def _begins(self, bodies: Sequence[str]) -> list[int]:
        """Where passages begin, by index of the line, and where the end of all does.

        It need not be right: what is no passage will not be taken for one.
        """
        begins = [i for i, body in enumerate(bodies) if body.startswith(self._choosing)]
        # The line before brings the bar.
        begins += [i - 1 for i, body in enumerate(bodies) if i and body.startswith(self._sawing)]
        begins += [i for i, body in enumerate(bodies) if body == "M30"][-1:]
        return sorted(begins)

    def _is_known(self, lines: Sequence[str], bar: Bar) -> bool:
        """Whether lines are a passage that is known."""
        said = self._forms.said("".join(f"{line}\n" for line in lines))
        return said is not None and said[1][2:] in bar.known.get(said[0], _NONE)

    def _read(self, lines: Sequence[str], bar: Bar) -> bool:
        """Whether lines are a passage, from now on a known one."""
        passage = self._alone.passage(
            [body_of(line) for line in lines], bar.profile, bar.choices, bar.section
        )
        said = None if passage is None else self._forms.learn(lines, passage.across)
        if passage is None or said is None:
            return False
        bar.known.setdefault(said[0], {})[said[1][2:]] = passage
        self._count += 1
        return True
