"""What a machine's own words mean, as its file defines them.

The word templates of a machine say it: the M word that carries `{angle}` saws, the one that
carries `{spindle}` chooses a spindle, those that carry `{section}`, `{width}` or `{height}`
describe the bar. All other M words mean what the controller's documentation says, and only
those that stand in a template are words of the machine.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Literal

from beamcam.machine.machine import Machine
from beamcam.verify.blocks import LETTERS

Role = Literal["saw", "choose", "section", "on", "coolant-on", "coolant-off", "off", "end", "other"]

#: M words of the controller (DIN 66025); the rest of its range is the machine's own.
DOCUMENTED: dict[int, Role] = {
    3: "on", 4: "on", 5: "off", 7: "coolant-on", 8: "coolant-on", 9: "coolant-off", 30: "end",
}  # fmt: skip
_SAYS: dict[str, Role] = {
    "angle": "saw", "spindle": "choose", "section": "section", "width": "section",
    "height": "section",
}  # fmt: skip
_COMMAND = re.compile(r"\s*([GM])0*(\d+)\b")
_FIELD = re.compile(r"\b([A-Z])\{(\w+)\}")


@dataclass(frozen=True, slots=True)
class MWord:
    """One M word of a machine."""

    role: Role
    fields: tuple[tuple[str, str], ...]  #: letter and what it carries


@dataclass(frozen=True, slots=True)
class Meaning:
    """The words of a machine."""

    m_words: dict[int, MWord]
    letters: frozenset[str]  #: addresses that its programs may use
    section_fields: frozenset[str]  #: what a program has to say about its bar
    feeds: bool  #: whether its programs carry feeds
    coolant: bool  #: whether its cycles cool

    def shown(self) -> str:
        """Its M words, for messages."""
        return ", ".join(f"M{n:02}" for n in sorted(self.m_words))


def meaning_of(machine: Machine) -> Meaning:
    """The words of a machine, read off its templates."""
    m_words: dict[int, MWord] = {30: MWord("end", ())}
    letters = set(LETTERS)
    feeds = False
    for line in _templates(machine):
        carried = tuple(_FIELD.findall(line))
        letters.update(letter for letter, _ in carried)
        feeds = feeds or any(name == "feed" for _, name in carried)
        match = _COMMAND.match(line)
        if match is None or match[1] != "M":
            continue
        number = int(match[2])
        role = next((_SAYS[n] for _, n in carried if n in _SAYS), DOCUMENTED.get(number, "other"))
        before = m_words.get(number, MWord(role, ()))
        m_words[number] = MWord(role, tuple(dict.fromkeys((*before.fields, *carried))))
    said = {name for w in m_words.values() if w.role == "section" for _, name in w.fields}
    cools = any(w.role == "coolant-on" for w in m_words.values())
    return Meaning(m_words, frozenset(letters), frozenset(said), feeds, cools)


def _templates(machine: Machine) -> Iterator[str]:
    """Every line of every template but the comment."""
    for field in fields(machine.words):
        value = getattr(machine.words, field.name)
        if isinstance(value, tuple):
            yield from value
