"""A block of RS274/NGC by itself, without modal state.

Written from the "G-Code Overview" of the LinuxCNC documentation and the grbl 1.1 wiki.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import inf

from msgspec import Struct

from beamcam.controllers.dialect import HEAD_ACTIONS, Dialect, carried, event_of, with_number
from beamcam.controllers.events import Blending, Compensation, Other, Pause, Side, Switch
from beamcam.geometry.plane import Point
from beamcam.machine.machine import OTHER_LETTERS, key_for, meaning_of, shown_code
from beamcam.model.cycles import DRILLING, END

_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)"
_WORD = re.compile(rf"([A-Z$])({_NUMBER})")
_COMMENT = re.compile(r"\([^()]*\)|;.*")

MOTIONS = {"G0": 0, "G1": 1, "G2": 2, "G3": 3}
#: Canned cycles, and their end, of a controller that knows them.
CYCLES = {f"G{number}": number for number in (END, *DRILLING)}
MOTIONS_AND_CYCLES = MOTIONS | CYCLES
ENDS = (2, 30)
#: G words that shift or leave the places that a program names.
SHIFTS = ("G10", "G28", "G28.1", "G30", "G30.1", "G52", "G68", "G92", "G92.3", "G43", "G43.1")
#: Those of a tool's length, which shift Z where a table's program moves it.
LENGTHS = ("G43", "G43.1")
#: Letters of a block that belong to its move, whatever else stands in it.
MOVING = frozenset("XYZIJRF")
LARGEST = 1e15  #: of any number; controllers count no further
MAX_NUMBER = 1e9  #: of an M word, which has three digits at most


class Variant(Struct, frozen=True):
    """Syntax that a controller of the family accepts, and its handling of arcs."""

    name: str
    percent: bool  #: whether % stands alone on the first and the last line
    longest_line: int  #: characters
    settings: frozenset[str]  #: G words that need no more than to be there
    needed: tuple[str, ...]  #: those that a program has to say before it moves
    switches: dict[int, frozenset[str]]  #: M words and the letters that belong to them
    own_switches: range  #: M words that a machine may give a meaning, and
    own_letters: frozenset[str]  #: what they may carry
    cycles: bool  #: whether it knows canned cycles, and where they draw back to by G98 and G99
    blends: bool  #: whether it passes corners at a distance that programs say
    sides: dict[str, Side]  #: G words of cutter compensation
    #: G words that do nothing to the places of a table in X and Y, and what they carry.
    idle: dict[str, frozenset[str]]
    #: G words that choose an offset of the workpiece; the controller alone knows where it is.
    offsets: frozenset[str]
    #: M words that neither move a table nor switch its tool, and what they carry.
    idle_switches: dict[int, frozenset[str]]
    #: G words that go down in Z until the torch touches, of a table whose programs move Z.
    probes: frozenset[str]
    named: bool  #: whether it knows values and subroutines by names, `#<holes>=1`, `o<probe> call`
    arc_fault: Callable[[Point, Point, Point, bool], str | None]  #: start, end, centre, clockwise

    @property
    def g_words(self) -> frozenset[str]:
        """All G words that it knows."""
        others = {*self.settings, *self.sides, "G4", "G40", "G90", "G91"}
        return frozenset({*MOTIONS, *others, *(("G98", "G99", *CYCLES) if self.cycles else ())})


#: What a block does to a table's head before its move, and the number for it: "height" and
#: "touch off" as in `[codes]`; "zero" and "kept zero" call the place of Z (G92, G10 L20); "take
#: back" undoes that (G92.1); "tool" prepares one (T), "offset" takes places as those of one, 0 for
#: the one in the head (G43), "offset off" as the torch's (G49).
Action = tuple[str, float]


class Block(Struct, frozen=True, gc=False):
    """The content of a block, without modal state."""

    syntax: str = ""  #: what was expected, where it is not a block
    faults: tuple[tuple[str, str], ...] = ()  #: what is wrong with its words, found and expected
    unknown: tuple[tuple[str, str], ...] = ()  #: words without a meaning here, likewise
    feed: float | None = None
    speed: float | None = None  #: of a table's tool, apart from the word that starts it
    events: tuple[Other, ...] = ()  #: before its move; their lines are 0
    settings: tuple[str, ...] = ()
    actions: tuple[Action, ...] = ()  #: before its move
    probe: bool = False  #: whether its move ends where the torch touches
    motion: int | None = None
    values: dict[str, float] = {}  #: of the words that are left for the move
    end: int | None = None  #: the M word that ends the program
    blank: bool = False
    percent: bool = False


class Grammar:
    """What a variant and the dialect of a machine make of words."""

    def __init__(
        self, variant: Variant, switches: Mapping[int, frozenset[str]], dialect: Dialect
    ) -> None:
        """`switches` are the M words with their letters; the dialect knows the machine's own."""
        self.variant, self.switches, self.dialect = variant, switches, dialect
        self.motions = MOTIONS_AND_CYCLES if variant.cycles else MOTIONS
        self.is_table = dialect.stock == "sheet"
        self.lifts = dialect.lifting is not None  #: whether its programs move Z
        self.probes = variant.probes if self.lifts else frozenset[str]()
        self.acting = frozenset("GMN") | dialect.codes.keys()  #: letters that carry no value


def read_block(text: str, grammar: Grammar) -> Block:
    """What the words of a block say."""
    if "(" in text or ";" in text or ")" in text:
        text = _COMMENT.sub(" ", text)
        if "(" in text or ")" in text:
            return Block("a comment that begins and ends on its line")
    squeezed = "".join(text.upper().split())
    if squeezed == "%":
        return Block(percent=True)
    parts = _WORD.split(squeezed)  # what is before a word, its letter, its number, and so on
    if any(parts[::3]):
        return Block("letters with a number each")
    return _Words(parts, grammar).block() if len(parts) > 1 else Block(blank=True)


class _Words:
    """The words of a block, sorted by what they do."""

    def __init__(self, parts: list[str], grammar: Grammar) -> None:
        self._grammar = grammar
        self._actions: list[Action] = []
        self._foreign = False  #: whether a G or M word is not known
        self._faults: list[tuple[str, str]] = []
        self._unknown: list[tuple[str, str]] = []
        self._codes: list[str] = []
        self._m_words: list[int] = []
        self._values: dict[str, float] = {}
        values, acting = self._values, grammar.acting
        for place in range(1, len(parts), 3):
            letter, value = parts[place], float(parts[place + 1])
            if letter in acting or letter in values or abs(value) >= LARGEST:
                self._take(letter, parts[place + 1], value, place == 1)
            else:
                values[letter] = value

    def _take(self, letter: str, digits: str, value: float, first: bool) -> None:
        """A word that is no value of the block, or a wrong one."""
        if letter == "M":
            if value > MAX_NUMBER:
                self._wrong(f"M{digits}", "a number of a few digits")
                return
            self._m_words.append(int(value))
            if value != int(value):
                self._wrong(f"M{digits}", "a whole number")
        elif abs(value) >= LARGEST:
            self._wrong(f"{letter}{digits[:20]}", "a number of at most 15 digits")
        elif letter == "G":
            self._codes.append(f"G{value:g}")
        elif letter == "N":
            if not first:
                self._wrong(f"N{digits}", "it at the beginning of a block")
        elif letter in self._values:
            self._wrong(f"{letter} twice in a block", "it once")

    def _forbid(self, code: str) -> None:
        self._wrong(shown_code(code), self._grammar.dialect.shown_allowed())

    def _wrong(self, found: str, expected: str) -> None:
        self._faults.append((found, expected))

    def _unexplained(self, word: str, key: str = "") -> None:
        """A word that nothing gives a meaning, with the line that would."""
        key, is_table = key or word, self._grammar.is_table
        expected = f'codes.{key} = "none" in the machine file, if it neither moves nor switches'
        if is_table and word[0] == "M":
            expected += ', or what it does, such as "thc off"'
        if is_table and word == "Z":
            expected += ', or torch.z = "program", where the program moves the torch up and down'
        if word in SHIFTS:
            expected = "none, it shifts the places of all that follows"
        shown = f"{word} {key.removeprefix(word)}".strip()
        self._foreign = self._foreign or (is_table and word not in OTHER_LETTERS)
        self._unknown.append((f"{shown}, which beamcam does not know", expected))

    def block(self) -> Block:
        """What they say."""
        grammar, values = self._grammar, self._values
        is_allowed = grammar.dialect.is_allowed
        feed, speed = values.pop("F", None), None
        motions: list[int] = []
        probes: list[str] = []
        settings: list[str] = []
        ends: list[int] = []
        for code in self._codes:
            if not is_allowed(code):
                self._forbid(code)
            if code in grammar.motions:
                motions.append(grammar.motions[code])
            else:
                (probes if code in grammar.probes else settings).append(code)
        for number in self._m_words:
            if not is_allowed(f"M{number}"):
                self._forbid(f"M{number}")
            if number in ENDS:
                ends.append(number)
        events: list[Other] = []
        for number in self._m_words:
            events += self._m_events(number)
        for code in settings:
            events += self._setting(code)
        if grammar.is_table:
            speed = values.pop("S", None)
            self._of_table(settings)
        if self._foreign and not motions and not probes:
            values.clear()  # they belong to the word that is not known
        if len(motions) + len(probes) > 1:
            self._wrong("two motions in a block", "one")
        if len(ends) > 1:
            self._wrong("two ends of the program in a block", "one")
        return Block(
            faults=tuple(self._faults), unknown=tuple(self._unknown), feed=feed, speed=speed,
            events=tuple(events), settings=tuple(settings), actions=tuple(self._actions),
            probe=bool(probes), motion=motions[-1] if motions else None, values=values,
            end=ends[0] if ends else None,
        )  # fmt: skip

    def _of_table(self, settings: Sequence[str]) -> None:
        """The tool that is prepared, and the letters of axes that a table does not move."""
        values = self._values
        if "T" in values:
            self._actions.insert(0, ("tool", values.pop("T")))
        stand_alone = not self._unknown  # else they belong to the word that is not known
        others = OTHER_LETTERS - {"Z"} if self._grammar.lifts else OTHER_LETTERS
        for letter in sorted(values.keys() & others):
            del values[letter]
            if stand_alone:
                self._unexplained(letter)
        if "G53" in settings and values.keys() & set("XY"):
            expected = "places on the sheet; where those of the machine are is not known"
            self._wrong("G53 with X or Y", expected)

    def _m_events(self, number: int) -> Iterator[Other]:
        grammar, values = self._grammar, self._values
        if number in ENDS:
            return
        known = meaning_of(grammar.dialect.codes, f"M{number}", values)
        letters = grammar.switches.get(number)
        if known is not None and known[1] == "none":
            for letter in values.keys() - MOVING:
                del values[letter]
        elif known is not None:
            own = carried(values, grammar.variant.switches.get(number, ()))
            value = with_number(known[1], own)
            if value is None:
                expected = "P or Q, as codes says that it carries one"
                self._wrong(f"M{number} without a number", expected)
            elif known[1] in HEAD_ACTIONS:
                self._actions.append((known[1], value))
            else:
                yield event_of(number, known[1], own, value)
        elif letters is not None:
            yield Switch(0, number, {k: values.pop(k) for k in sorted(letters & values.keys())})
        elif grammar.is_table:
            self._unexplained(f"M{number}", key_for(f"M{number}", values))
            carried(values)
        else:
            self._unexplained(f"M{number}")

    def _zero(self, code: str) -> bool:
        """Whether a G word calls the place of Z, or takes that back, and no other place."""
        values = self._values
        if not self._grammar.lifts or values.keys() & set("XY"):
            return False
        if code in ("G92.1", "G92.2"):
            self._actions.append(("take back", 0.0))
            return True
        kept = code == "G10" and values.get("L") == 20.0
        if "Z" not in values or not (kept or code == "G92"):
            return False
        if kept:
            # P0 is the offset that holds, P1 that of G54.
            del values["L"]
            system = values.pop("P", -1.0)
            if system not in (0.0, 1.0):
                return False
            self._actions.append(("system", system))
        self._actions.append(("kept zero" if kept else "zero", values.pop("Z")))
        return True

    def _setting(self, code: str) -> Iterator[Other]:
        """What a G word does that is no motion."""
        values, grammar = self._values, self._grammar
        variant, dialect, is_table = grammar.variant, grammar.dialect, grammar.is_table
        if code == "G4":
            if "P" in values:
                yield Pause(0, values.pop("P") * dialect.dwell_s)
            else:
                unit = "seconds" if dialect.dwell_s == 1.0 else "milliseconds"
                self._wrong("G4", f"P with {unit}")
        elif code in variant.sides:
            yield Compensation(0, variant.sides[code], values.pop("D", 0.0) / 2)
        elif code == "G40":
            yield Compensation(0, "on", 0.0)
        elif code == "G64" and variant.blends:
            # Q is the reach of its filter of short lines; without P, or with 0, no limit holds.
            off = values.pop("P", 0.0)
            yield Blending(0, max(off, values.pop("Q", off)) if off > 0.0 else inf)
        elif code in ("G61", "G61.1") and variant.blends:
            yield Blending(0, 0.0)
        elif (
            (code in ("G98", "G99") and variant.cycles)
            or dialect.codes.get(code) == "none"
            or self._zero(code)
        ):
            return
        elif grammar.lifts and code in LENGTHS:
            self._unexplained(code)
            carried(values, "Z")
        elif is_table and code in variant.idle:
            if code in ("G43", "G49"):
                action = "offset" if code == "G43" else "offset off"
                self._actions.append((action, values.get("H", 0.0)))
            for letter in variant.idle[code] & values.keys():
                del values[letter]
        elif (is_table and code in variant.offsets) or (
            code == "G93" and dialect.stock == "profile"
        ):
            return
        elif code not in ("G90", "G91") and code not in variant.settings:
            self._unexplained(code)
