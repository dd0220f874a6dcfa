"""The interpreter of CODESYS SoftMotion CNC, for cells and for tables.

    G00 G01 X Y Z F        traverse and feed, F per second or per minute as the machine file says
    G02 G03 X Y I J, or R  arc, I and J from its start (G99) or absolute (G98)
    G06 G08 G09            parabola and ellipse (`curves`)
    E, E-                  acceleration to run up and to brake, mm/s2 whatever F is in
    G04 T, G75             dwell; wait until all that was read is done
    G41 G42 D, G40         beside the contour by the radius D, on it again
    G51 G52 D, G50         corners cut D from where they are, by a spline or an arc; no more
    G54 X Y Z, G55, G53    places count from there; from so much further on; from zero again
    G90 G91                X, Y and Z are absolute, or count from the last place

A block without a command repeats the last travel command. Refused: G56, which counts places from
where the axes stand, and subprograms, M98 and M99, which lie in files of their own. Source: CODESYS
online help, "CNC: DIN 66025", "Preprocessing" and "Shifting the Coordinate System".
"""

import re
from collections.abc import Callable, Sequence
from math import sqrt

from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import BoundedCache, PerObject
from beamcam.controllers.codesys import (
    BRAKING,
    CodesysBlock,
    CodesysFault,
    Lexer,
    arc_fault,
    curve_of,
)
from beamcam.controllers.dialect import DOCUMENTED, M_QUEUE, Dialect, event_of, with_number
from beamcam.controllers.events import (
    Acceleration,
    Blending,
    Compensation,
    Curve,
    FeedShare,
    Pause,
    Side,
    Switch,
)
from beamcam.controllers.interpreter import Interpreter, Words
from beamcam.geometry.plane import Point
from beamcam.machine.machine import CodeMeaning, meaning_of, shown_code
from beamcam.model.cycles import BREAK_CHIPS, DRILL, DRILL_AND_DWELL, OWN_LETTERS, PECK

M_WORDS_IN_A_ROW = 64  #: SMC_DEC_OUTQUEUE_RAN_EMPTY
ENDS = (2, 30)
#: The cycles that a machine's file may name, by what it calls them.
_CYCLES: dict[CodeMeaning, int] = {
    "drill-cycle": DRILL, "drill-cycle-dwell": DRILL_AND_DWELL,
    "drill-cycle-peck": PECK, "drill-cycle-chips": BREAK_CHIPS,
}  # fmt: skip
_KNOWN_G = frozenset(
    (0, 1, 2, 3, 4, 6, 8, 9, 40, 41, 42, 50, 51, 52, 53, 54, 55, 75, 90, 91, 98, 99)
)
_KNOWN = "G00 to G04, G06, G08, G09, G40 to G42, G50 to G55, G75, G90, G91, G98 or G99"
_FED = frozenset("FE") | {BRAKING}
_TRAVEL = {
    0: frozenset("F"), 1: _FED, 2: _FED | set("IJR"), 3: _FED | set("IJR"),
    6: _FED | set("IJ"), 8: _FED | set("IJKR"), 9: _FED | set("IJKR"),
}  # fmt: skip
#: The letters that each travel command takes, by the axes; a table's G00 takes no F.
_LETTERS = {
    axes: {motion: own | set(axes) for motion, own in _TRAVEL.items()} | without_feed
    for axes, without_feed in (("XYZ", {}), ("XY", {0: frozenset("XY")}))
}
_SIDES: dict[int, Side] = {40: "on", 41: "left", 42: "right"}
_HERE = 56  #: places count from where the axes stand
_SUBPROGRAMS = (98, 99)  #: M words of a call and of a subprogram's end
_NUMBERED = re.compile(r"[GM](\d+)(?![.\d])")  #: a key of [codes]
_LINE_BEGINS = re.compile(r"\nN[0-9]+ |\n")


#: What of the interpreter carries a block out at a line, the number of its G or M, its words.
_Instruction = tuple["Callable[[Codesys, int, int, Words], None]", int, Words]


class _Language(Struct, frozen=True):
    """What follows from a machine's dialect, whatever the program is."""

    lexer: Lexer
    known: BoundedCache[str, _Instruction]  #: by the texts of their blocks
    letters: dict[int, frozenset[str]]  #: that each travel command takes
    m_words: frozenset[int]  #: of the machine's own, which carry nothing
    g_words: dict[int, CodeMeaning]  #: of the machine's own
    subprograms: frozenset[int]  #: M words, as far as they are not the machine's own


def _language(dialect: Dialect) -> _Language:
    own = {
        (code[0], int(match[1])): meaning
        for code, meaning in dialect.codes.items()
        if (match := _NUMBERED.match(code))
    }
    return _Language(
        Lexer(dialect.letters),
        BoundedCache("codesys.blocks"),
        _LETTERS[dialect.axes],
        frozenset(number for letter, number in own if letter == "M"),
        {number: meaning for (letter, number), meaning in own.items() if letter == "G"},
        frozenset(n for n in _SUBPROGRAMS if n not in dialect.m_words and ("M", n) not in own),
    )


_language_of = PerObject("controllers.blocks", _language)


class Codesys(Interpreter):
    """The state of the controller between two blocks."""

    controller = "CODESYS"
    fed_traverse = False

    def __init__(self, dialect: Dialect, name: str) -> None:
        super().__init__(dialect, name)
        self.arc_slack = 2 * sqrt(2) * dialect.resolution
        self.arc_fault = lambda a, b, centre, _: arc_fault(a, b, centre, dialect.resolution)
        self._language = _language_of(dialect)
        self._begun = False  #: whether a block was carried out
        self._absolute_centre = False
        self._shift: dict[str, float] = {}  #: of places that are programmed, by axis; empty: none
        self._cuts_corners = False
        #: A cell's programs may count on G90 as the default, those of a table have to say it.
        self._counting_said = dialect.stock == "beam"

    def _is_simple(self) -> bool:
        plain = self._counting_said and not self._absolute_centre and not self._shift
        return plain and super()._is_simple()

    def knows(self, code: str) -> bool:
        return code in self._dialect.codes or code in {f"G{number}" for number in _KNOWN_G}

    def vocabulary(self) -> dict[str, frozenset[str]]:
        words = {f"G{number}": frozenset[str]() for number in _KNOWN_G}
        words |= {f"G{number}": frozenset("D") for number in (*_SIDES, 51, 52)}
        words |= {f"G{number}": frozenset(self._dialect.axes) for number in (54, 55)}
        words |= {f"M{number}": frozenset[str]() for number in (*DOCUMENTED, *_SUBPROGRAMS)}
        words[f"G{_HERE}"] = frozenset()
        words |= {f"G{number}": own for number, own in self._language.letters.items()}
        words |= {"G4": frozenset("T")} | {f"M{number}": frozenset() for number in ENDS}
        return words | self._words_of_the_file()

    def lines_of(self, text: str) -> list[str]:
        """The lines of a text without their block numbers, which count for nothing."""
        return _LINE_BEGINS.split("\n" + text)[1:]

    def lines(self, texts: Sequence[str], first: int = 1) -> None:
        known = self._language.known
        for line, text in enumerate(texts, first):
            instruction = known.get(text) or self._read(line, text)
            if instruction is None or (self._over and self.is_over(line)):
                continue
            self._begun = True
            carry_out, number, words = instruction
            carry_out(self, line, number, words)

    def _read(self, line: int, body: str) -> _Instruction | None:
        """A block that is not known; None for a text or no block, and with a message if invalid."""
        dialect, language = self._dialect, self._language
        if dialect.text_word is not None and self._is_text(line, body):
            return None
        block = language.lexer.block(body)
        if not isinstance(block, CodesysBlock):
            if block is not None:
                self._syntax(line, body, block)
            return None
        if dialect.allowed and block.command:
            code = f"{block.command}{block.number}"
            if not dialect.is_allowed(code):
                self._wrong(line, shown_code(code), dialect.shown_allowed())
                return None
        carry_out = _what_carries_out(block, language)
        return language.known.keep(body, (carry_out, block.number, block.words))

    def _syntax(self, line: int, body: str, fault: CodesysFault) -> None:
        """Says what is wrong with a line, unless it is the name of the program."""
        if body.lstrip().startswith("%"):
            if not self._begun or line in (1, self._last):
                return
            fault = CodesysFault(body.strip(), "% on the first or the last line only")
        self._say(line, self._rules.syntax, found=fault.found, expected=fault.expected)

    def _m_word(self, line: int, number: int, words: Words) -> None:
        self._wait(line)
        self._event(Switch(line, number, words))

    def _own_m_word(self, line: int, number: int, words: Words) -> None:
        """An M word of the machine's own, which does what its file says."""
        known = meaning_of(self._dialect.codes, f"M{number}", words)
        if known is None:  # another one is known by what it carries
            self._m_word(line, number, words)
            return
        self._wait(line)
        value = with_number(known[1], words)
        if value is None:
            self._wrong(line, f"M{number:02} without a number", "P or Q, as codes says")
        elif known[1] == "none":
            if words and known[0] == f"M{number}":
                self._wrong(line, f"{min(words)} behind M{number:02}", "no word there")
        else:
            event = event_of(number, known[1], dict(words), value)
            if isinstance(event, FeedShare):
                self._share = event.share
            self._event(replace(event, line=line))

    def _last_block(self, line: int, number: int, words: Words) -> None:
        self._wait(line)
        self._over = True
        self._event(Switch(line, number, words))

    def _subprogram(self, line: int, number: int, words: Words) -> None:
        """A call of a subprogram, or its end: neither stands in a program that is whole."""
        expected = "its blocks here; no program that beamcam writes calls a subprogram"
        self._wrong(line, f"M{number:02}, a subprogram", expected)

    def _wait(self, line: int) -> None:
        """Counts an M word or a dwell, which wait in one queue until a move or G75."""
        self._row += 1
        if self._row == M_WORDS_IN_A_ROW + 1:
            self._say(line, M_QUEUE, found=self._row, expected=M_WORDS_IN_A_ROW)

    def _setting(self, line: int, number: int, words: Words) -> None:
        unexpected = set(words)
        if number in _SIDES:
            unexpected -= {"D"}
            self._event(Compensation(line, _SIDES[number], words.get("D", 0.0)))
        elif number in (90, 91):
            self._absolute, self._counting_said = number == 90, True
        elif number in (98, 99):
            self._absolute_centre = number == 98
        elif number == 75:
            self._row = 0
        elif number == _HERE:
            expected = "G54 with the place; no program that beamcam writes counts from where it is"
            self._wrong(line, "G56, places that count from where the axes stand", expected)
            return
        else:
            self._wrong(line, f"G{number:02}", _KNOWN)
        if unexpected:
            self._wrong(line, f"{min(unexpected)} behind G{number:02}", "no word there")

    def _dwell(self, line: int, number: int, words: Words) -> None:
        self._wait(line)
        if words.keys() == {"T"}:
            self._event(Pause(line, words["T"]))
        else:
            self._wrong(line, "G04", "T with seconds")

    def _cut_corners(self, line: int, number: int, words: Words) -> None:
        """Corners are cut D before and behind them (G51 by a spline, G52 by an arc), or no more.

        What is cut off lies within D of the path.
        """
        own = {50: set[str]()}.get(number, {"D"})
        if words.keys() != own or words.get("D", 0.0) < 0.0:
            expected = "D, 0 or more, the way to the corner" if own else "no word there"
            self._wrong(line, f"G{number} {' '.join(sorted(words))}".strip(), expected)
        elif number != 50 or self._cuts_corners:
            self._cuts_corners = number != 50
            self._event(Blending(line, words.get("D", 0.0)))

    def _move_zero(self, line: int, number: int, words: Words) -> None:
        """Places count from where the axes are called X, Y and Z (G54), so much further on (G55),
        or from zero again (G53)."""
        axes = self._dialect.axes
        if number == 53 and not words:
            self._shift = {}
        elif number == 54 and words.keys() == set(axes):
            self._shift = dict(words) if any(words.values()) else {}
        elif number == 55 and words and words.keys() <= set(axes):
            moved = {a: self._shift.get(a, 0.0) + words.get(a, 0.0) for a in axes}
            self._shift = moved if any(moved.values()) else {}
        else:
            letters = " ".join(axes)
            expected = {53: "no word there", 54: letters, 55: f"some of {letters}"}[number]
            self._wrong(line, f"G{number} {' '.join(sorted(words))}".strip(), expected)

    def _shifted(self, words: Words, heights: str = "Z") -> Words:
        """Words with their absolute places as the machine counts them; `heights` count as Z."""
        shift = self._shift
        if not shift or not self._absolute:
            return words
        own = {**shift, **dict.fromkeys(heights, shift.get("Z", 0.0))}
        return {letter: value + own.get(letter, 0.0) for letter, value in words.items()}

    def _go_on(self, line: int, _: int, words: Words) -> None:
        if self._cycle is not None:
            self._drilled(line, words)
        else:
            self._carry_out(line, self._motion, words)

    def _own_code(self, line: int, number: int, words: Words) -> None:
        """A G word of the machine's own, which means what its file says."""
        meaning = self._language.g_words[number]
        if meaning in _CYCLES:
            self._drilling = _CYCLES[meaning]
            self._drilled(line, words)
            return
        if meaning == "end-cycle":
            self._cycle = None
        if words:
            self._wrong(line, f"{min(words)} behind G{number:02}", "no word there")

    def _drilled(self, line: int, words: Words) -> None:
        unexpected = words.keys() - set("XYZRF" + OWN_LETTERS[self._drilling])
        if unexpected:
            self._wrong(line, f"{min(unexpected)} behind a drilling cycle", "no such word there")
        fed = "F" in words
        if fed:
            self._feed = words["F"]
        place = {letter: value for letter, value in words.items() if letter != "F"}
        self._drill(line, self._drilling, self._shifted(place, "ZR"), fed)

    def _carry_out(self, line: int, motion: int, words: Words) -> None:
        self._motion = motion
        self._cycle = None
        if motion < 0:
            self._wrong(line, "words without a command", "G or M")
            return
        letters = self._language.letters[motion]
        if not letters.issuperset(words):
            unexpected = min(words.keys() - letters)
            self._wrong(line, f"{unexpected} behind G{motion:02}", "no such word there")
        fed = "F" in words
        if fed:
            self._feed = words["F"]
        if "E" in words:
            self._event(Acceleration(line, False, words["E"]))
        if BRAKING in words:
            self._event(Acceleration(line, True, -words[BRAKING]))
        if not self._counting_said:
            self._say(line, self._rules.setting, found="G90")
            self._counting_said = True
        self._go(line, motion, self._shifted(words) if self._shift else words, fed)

    def curve(self, motion: int, start: Point, end: Point, words: Words) -> Curve | str:
        zero = self._shift.get("X", 0.0), self._shift.get("Y", 0.0)
        origin = zero if self._absolute_centre else start
        return curve_of(motion, start, end, words, origin, self._dialect.resolution)


def _what_carries_out(
    block: CodesysBlock, language: _Language
) -> Callable[[Codesys, int, int, Words], None]:
    if block.command == "M":
        if block.number in language.m_words:
            return Codesys._own_m_word
        if block.number in language.subprograms:
            return Codesys._subprogram
        return Codesys._last_block if block.number in ENDS else Codesys._m_word
    if not block.command:
        return Codesys._go_on
    if block.number in _TRAVEL:
        return Codesys._carry_out
    if block.number in language.g_words:
        return Codesys._own_code
    return _SETTINGS.get(block.number, Codesys._setting)


_SETTINGS = {
    4: Codesys._dwell, **dict.fromkeys((50, 51, 52), Codesys._cut_corners),
    **dict.fromkeys((53, 54, 55), Codesys._move_zero),
}  # fmt: skip
