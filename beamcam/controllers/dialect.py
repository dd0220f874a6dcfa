"""The dialect of a machine: its axes and numbers, what its own words mean, and rules for all words.

The word templates of a machine say it: the M word that carries `{angle}` saws, the one that
carries `{spindle}` chooses a spindle, those that carry `{section}`, `{width}` or `{height}`
describe the bar. All other M words mean what the controller's documentation says, and only
those that stand in a template are words of the machine.

What the words of a table's own do, as `[codes]` of its file says: events of them.

M64 P2     codes.M64P2 = "thc off"         an Output
M67 E3 Q60 codes.M67E3 = "feed share"      a FeedShare
M7         codes.M7 = "torch on"           a Switch, which starts the tool
"""

import re
from bisect import bisect_left
from collections.abc import Iterable, Mapping
from typing import Literal, get_args

from msgspec import Struct

from beamcam.caches import PerObject
from beamcam.controllers.events import FeedShare, Material, Other, Output, Switch
from beamcam.errors import Rule, Severity, error
from beamcam.machine.machine import (
    CARRYING,
    CodeMeaning,
    Machine,
    plain_code,
    plain_key,
    shown_code,
)
from beamcam.machine.stations import tool_numbers
from beamcam.machine.torch import Torch, TorchProcess

#: Letters that the help of CODESYS describes; a machine file may use more in its templates.
LETTERS = frozenset("NGMXYZABCPQUVWDEFHIJKLORT")
NUMBER = r"[+-]?(?:[0-9]{1,15}(?:\.[0-9]{0,15})?|\.[0-9]{1,15})"  # no controller counts further

# fmt: off

_E = Severity.ERROR

SYNTAX = error("verify-syntax",
    "found {found!r}; expected {expected}",
    "The controller would stop at that block, or read something else than was meant.")
WORD = error("verify-word",
    "found {found}; expected {expected}",
    "What the read-back does not know it cannot vouch for, so it refuses the program.")
M_QUEUE = error("verify-m-queue",
    "found {found} M words in a row; expected at most {expected}",
    "CODESYS runs out of its queue (SMC_DEC_OUTQUEUE_RAN_EMPTY); a G75 before resets the count.")
ARC = error("verify-arc",
    "found an arc {found}; expected one that start, end and centre agree on",
    "CODESYS silently replaces an inconsistent arc by a straight line.")
SETTING = error("verify-setting",
    "found a move before {found}; expected it to be set at the beginning",
    "Units, plane and the way of counting are what the last program left, if this one is silent.")
END = error("verify-end",
    "found {found}; expected M30 once, as the last command",
    "A program that was cut off in the middle looks like a whole one up to its last line.")
SHEET_SYNTAX = Rule("verify-sheet-syntax", _E, SYNTAX.message, SYNTAX.reason)
SHEET_WORD = Rule("verify-sheet-word", _E, WORD.message, WORD.reason)
SHEET_ARC = error("verify-sheet-arc",
    "found an arc {found}; expected one that {controller} reads as meant",
    "Controllers refuse an arc whose ends and centre disagree, or make a line or a circle of it.")
SHEET_SETTING = Rule("verify-sheet-setting", _E, SETTING.message, SETTING.reason)
SHEET_END = Rule(
    "verify-sheet-end",
    _E,
    "found {found}; expected M2 or M30 once, as the last command, the tool off",
    END.reason,
)


class ProgramRules(Struct, frozen=True):
    """The rules of all controllers' programs, as they are called for one kind of stock."""

    syntax: Rule
    word: Rule
    arc: Rule
    setting: Rule
    end: Rule


_BARS = ProgramRules(SYNTAX, WORD, ARC, SETTING, END)
#: A profile that is coped is a bar.
BY_STOCK: dict[Literal["beam", "sheet", "profile"], ProgramRules] = {
    "beam": _BARS,
    "profile": _BARS,
    "sheet": ProgramRules(SHEET_SYNTAX, SHEET_WORD, SHEET_ARC, SHEET_SETTING, SHEET_END),
}
SHEET_RULES = (SHEET_SYNTAX, SHEET_WORD, SHEET_ARC, SHEET_SETTING, SHEET_END)

# fmt: on


Role = Literal[
    "saw", "choose", "section", "on", "coolant-on", "coolant-off", "off", "end", "change", "other"
]

#: M words of the controller (DIN 66025); the rest of its range is the machine's own.
DOCUMENTED: dict[int, Role] = {
    2: "end", 3: "on", 4: "on", 5: "off", 7: "coolant-on", 8: "coolant-on", 9: "coolant-off",
    30: "end",
}  # fmt: skip
WRITTEN = 0.0006  #: mm; diameters are written to 0.001
_SAYS: dict[str, Role] = {
    "angle": "saw", "spindle": "choose", "tool": "choose", "section": "section", "width": "section",
    "height": "section",
}  # fmt: skip
_COMMAND = re.compile(r"\s*([GM])0*(\d+)\b")
_WORD = re.compile(r"(?<![A-Z])([GM])0*(\d+(?:\.\d)?)")  #: of a line, wherever it stands
FIELD = re.compile(r"\b([A-Z])\{(\w+)\}")  #: letter and name of a word with a figure
MAGIC = re.compile(r"\(\s*o\s*=")  #: how a comment begins that QtPlasmaC takes a material from
TELLS = "{string}"  #: in the line that tells a text
_PLACEHOLDER = re.compile(r"([^{}]+)|\{(\w+)[^}]*\}")  #: plain text, or the name in braces


#: Tools that work along a path, so that the bar and the spindle move while they are in it.
ALONG_A_PATH = ("mill", "scribe")


class Cycle(Struct, frozen=True):
    """The machine's cycle for one kind of tool, from the template of that name."""

    kind: str
    turns: int  #: the M word that starts the spindle, 0 if it does not turn
    cools: bool
    along: bool  #: whether it works along a path
    feeds: bool  #: whether its move into the material has its own feed


class MWord(Struct, frozen=True):
    """One M word of a machine."""

    role: Role
    fields: tuple[tuple[str, str], ...]  #: letter and what it carries
    cycle: Cycle | None = None  #: of the tool that it chooses, of a choosing word


class TextWord(Struct, frozen=True):
    """The line by which a stamp or printer is told a text."""

    kind: str  #: of the unit
    pattern: re.Pattern[str]  #: of the line; its groups are named by what they carry
    codes: tuple[str, ...]  #: its G and M words, without leading zeros


class Dialect(Struct, frozen=True):
    """The dialect of a machine's programs."""

    stock: Literal["beam", "sheet", "profile"]
    axes: str  #: letters of the axes that its programs move
    resolution: float  #: the step of its lengths
    per_minute: float  #: what makes mm/min of an F word
    rules: ProgramRules
    m_words: dict[int, MWord]
    letters: frozenset[str]  #: addresses that its programs may use
    section_fields: frozenset[str]  #: what a program has to say about its bar
    feeds: bool  #: whether its programs carry feeds
    changes: bool  #: whether they stop for manual tool changes
    sizes: tuple[float, ...]  #: diameters of the shop's tools
    codes: Mapping[str, CodeMeaning]  #: words of the machine's own, without leading zeros
    allowed: frozenset[str]  #: all words that its controller takes; empty: no list of them
    numbered: Mapping[int, tuple[str, float]]  #: number of a tool -> its kind and size
    cycles: Mapping[str, Cycle]  #: how it works with each kind of tool
    only_spindle: int | None  #: that needs no choice, as there is no other
    text_word: TextWord | None = None  #: where a stamp or printer letters
    startup: str = ""  #: block that runs before each program
    laser_mode: bool = False  #: whether S holds from feed to feed, and traverses are dark
    dwell_s: float = 1.0  #: what makes seconds of what a dwell says
    lifting: Torch | None = None  #: of a table whose programs move Z
    shares: bool = False  #: whether a table's head has several tools, each at its own place
    magic: bool = False  #: whether a comment may give the cutting data of a material
    materials: Mapping[float, float] = {}  #: feed in mm/min by the number of a row

    def size(self, diameter: float) -> float:
        """The shop's tool that a diameter means: programs write three decimals of an inch size."""
        at = bisect_left(self.sizes, diameter - WRITTEN)
        is_smaller = at < len(self.sizes) and self.sizes[at] < diameter + WRITTEN
        return self.sizes[at] if is_smaller else diameter

    def is_allowed(self, code: str) -> bool:
        """Whether the controller of the machine takes a word, `G1` or `M30`."""
        return not self.allowed or code in self.allowed

    def shown_allowed(self) -> str:
        """The words that it takes, for messages."""
        codes = sorted(self.allowed, key=lambda code: (code[0], float(code[1:])))
        return "one of allowed_codes: " + ", ".join(map(shown_code, codes))

    def shown(self) -> str:
        """Its M words, for messages."""
        return ", ".join(f"M{n:02}" for n in sorted(self.m_words))


def _dialect_of(machine: Machine) -> Dialect:
    m_words, letters, feeding, cycles = _own_words(machine)
    names = {name for w in m_words.values() if w.role == "section" for _, name in w.fields}
    # RS274 counts in mm/min (G94), whatever the templates of a machine are filled with.
    by_second = machine.controller == "codesys" and machine.format.feed_unit == "mm/s"
    torch = machine.torch
    tilting = "B" if machine.coper is not None and machine.coper.tilt else ""
    return Dialect(
        stock=machine.stock,
        axes={"beam": "XYZ", "sheet": "XY", "profile": "XYZA"}[machine.stock] + tilting,
        resolution=machine.format.resolution, per_minute=60.0 if by_second else 1.0,
        rules=BY_STOCK[machine.stock], m_words=m_words, letters=letters,
        section_fields=frozenset(names), feeds=feeding,
        changes=any(word.role == "change" for word in m_words.values()),
        sizes=tuple(sorted({d for tools in machine.tools for d in tools.sizes})),
        codes={plain_key(code): meaning for code, meaning in machine.codes.items()},
        allowed=frozenset(plain_code(code) or code for code in machine.allowed_codes),
        numbered={number: tool for tool, number in tool_numbers(machine.tools).items()},
        cycles=cycles,
        only_spindle=machine.spindles[0].number if len(machine.spindles) == 1 else None,
        text_word=_text_word(machine), startup=machine.startup_code,
        laser_mode=torch is not None and torch.laser_mode,
        dwell_s=0.001 if machine.format.dwell_unit == "ms" else 1.0,
        lifting=torch if torch is not None and torch.z == "program" else None,
        shares=any(getattr(machine.words, f"choose_{p}") for p in get_args(TorchProcess)),
        magic=any(MAGIC.match(line) for line in machine.words.material),
        materials={float(r.number): r.feed_mm_min for r in torch.rows} if torch else {},
    )  # fmt: skip


def _text_word(machine: Machine) -> TextWord | None:
    """The line that tells a text to a machine's stamp or printer, with its figures as groups."""
    if not machine.marks.is_told:
        return None
    template = getattr(machine.words, machine.marks.unit)
    line = next(line for line in template if TELLS in line)
    closing = re.escape(line.partition(TELLS)[2][0])
    pattern = "".join(
        (f"(?P<string>[^{closing}]*)" if name == "string" else rf"\s*(?P<{name}>{NUMBER})\s*")
        if name
        else r"\s+".join(map(re.escape, re.split(r"\s+", text)))
        for text, name in _PLACEHOLDER.findall(line)
    )
    words = _WORD.findall(_PLACEHOLDER.sub(r"\1 ", line))
    codes = tuple(f"{letter}{number}" for letter, number in words)
    return TextWord(machine.marks.unit, re.compile(pattern), codes)


def _own_words(machine: Machine) -> tuple[dict[int, MWord], frozenset[str], bool, dict[str, Cycle]]:
    """The M words of the templates, the letters of all words, whether any carries a feed, and how
    the machine works with each kind of tool."""
    m_words: dict[int, MWord] = {30: MWord("end", ())}
    letters = set(LETTERS)
    feeding = False
    cycles: dict[str, Cycle] = {}
    for name in machine.words.__struct_fields__:
        lines = getattr(machine.words, name)
        if not isinstance(lines, tuple):
            continue  # the form of a comment
        heads = [int(m[2]) for line in lines if (m := _COMMAND.match(line)) and m[1] == "M"]
        does = {number: DOCUMENTED.get(number, "other") for number in heads}
        turns = next((number for number, role in does.items() if role == "on"), 0)
        feeds = any("{feed}" in line for line in lines)
        along, cools = name in ALONG_A_PATH, "coolant-on" in does.values()
        cycle = cycles[name] = Cycle(name, turns, cools, along, feeds)
        for line in lines:
            if TELLS in line:
                continue  # a word by itself: see `TextWord`
            carried = tuple(FIELD.findall(line))
            letters.update(letter for letter, _ in carried)
            feeding = feeding or any(field == "feed" for _, field in carried)
            number, role = role_of(line, name == "change")
            if number is None:
                continue
            before = m_words.get(number, MWord(role, ()))
            fields_ = tuple(dict.fromkeys((*before.fields, *carried)))
            chooses = cycle if role == "choose" and before.cycle is None else before.cycle
            m_words[number] = MWord(role, fields_, chooses)
    return m_words, frozenset(letters), feeding, cycles


#: The dialect of a machine, read off its file.
dialect_of = PerObject("controllers.dialects", _dialect_of)


def role_of(line: str, changes: bool = False) -> tuple[int | None, Role]:
    """The M word that a line of a template begins with, and what it does; None if it has none.

    `changes` says that the line belongs to a manual tool change.
    """
    match = _COMMAND.match(line)
    if match is None or match[1] != "M":
        return None, "other"
    number = int(match[2])
    documented = DOCUMENTED.get(number, "other")
    carried = (field for _, field in FIELD.findall(line))
    role = next((_SAYS[field] for field in carried if field in _SAYS), documented)
    return number, "change" if changes else role


#: What moves the torch or calls its place, for which its height has to be known.
HEAD_ACTIONS = frozenset({"height", "touch off"})
#: What starts and stops a tool.
TOOL_ON = frozenset({"torch on", "cutting oxygen on"})
TOOL_OFF = frozenset({"torch off", "cutting oxygen off"})
#: M words that neither move a table's head nor switch its tool: coolant and air, overrides.
IDLE_SWITCHES = frozenset({7, 8, 9, 48, 49, 50, 51, 52, 53})
#: M words that stop the program until the operator goes on.
STOPS = frozenset({0, 1, 6, 60})
_WITH_MOVE = frozenset({62, 63, 67})  #: M words that act as the next move begins
_LETTERS = frozenset("PQEKLHD$")


def carried(values: dict[str, float], more: Iterable[str] = ()) -> dict[str, float]:
    """What an M word carries, taken out of the values of its block."""
    own = sorted(values.keys() & (_LETTERS | frozenset(more)))
    return {letter: values.pop(letter) for letter in own}


def with_number(meaning: CodeMeaning, values: Mapping[str, float]) -> float | None:
    """The number that a meaning needs, 0 of one that needs none; None where it is missing."""
    if meaning not in CARRYING:
        return 0.0
    return values.get("Q", values.get("P"))


def event_of(number: int, meaning: CodeMeaning, values: dict[str, float], value: float) -> Other:
    """The event of an M word, its line 0."""
    if meaning in TOOL_ON or meaning in TOOL_OFF:
        return Switch(0, number, values, meaning)
    if meaning == "feed share":
        return FeedShare(0, value / 100.0 if 0.0 < value < 100.0 else 1.0)
    if meaning == "material":
        return Material(0, {"number": value})
    name, _, state = meaning.rpartition(" ")
    if name == "output" and "P" in values:
        name = f"output {values['P']:g}"
    return Output(0, name, state == "on", number in _WITH_MOVE)


def tool_words(switches: Iterable[Switch], on: bool) -> list[Switch]:
    """Those of the M words of a template that start or stop the tool.

    What `[codes]` says comes first, then M3, M4 and M5, then what is no coolant and no override.
    """
    each = list(switches)
    says = [e for e in each if e.does in (TOOL_ON if on else TOOL_OFF)]
    turns = [e for e in each if not e.does and e.number in ((3, 4) if on else (5,))]
    others = [e for e in each if not e.does and e.number not in IDLE_SWITCHES | STOPS]
    return says or turns or others or [e for e in each if not e.does and e.number not in STOPS]
