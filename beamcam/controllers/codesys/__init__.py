"""The lexer of CODESYS SoftMotion CNC: a program's text as blocks of words (DIN 66025).

    N10 G01 X100.5 Y-20 F40      a block: number, one command, then its words
    N20 M40 K13 L14              K and L are the command's parameters
    % JOB    (a comment)         the program's name, and what the controller does not read

    N30 G01 X5 F40 E900 E-800    E runs up, E- brakes

Words are separated by spaces or tabs; case, leading zeros and the block numbers count for
nothing. At most one G or M stands in a block, before its words. All numbers may be real except
those of N, G, M and H. Source: CODESYS online help, "CNC: DIN 66025".
"""

import re
from collections.abc import Set

from msgspec import Struct

from beamcam.caches import BoundedCache

#: Letters that the controller's help describes; a machine file may use more in its templates.
LETTERS = frozenset("NGMXYZABCPQUVWDEFHIJKLORT")
_WHOLE = frozenset("NGMH")
BRAKING = "E-"  #: how a block calls an E with a negative value, which may stand beside E
NUMBER = r"[+-]?(?:[0-9]{1,15}(?:\.[0-9]{0,15})?|\.[0-9]{1,15})"  # no controller counts further
_WORD = re.compile(rf"([A-Z])({NUMBER})")
_COMMENT = re.compile(r"\([^()]*\)")


class CodesysBlock(Struct, frozen=True, gc=False):
    """One block, whatever its number."""

    command: str  #: "G", "M", or "" where the last travel command goes on
    number: int
    words: dict[str, float]  #: the others


class CodesysFault(Struct, frozen=True):
    """A syntax error in a block."""

    found: str
    expected: str


class Word(Struct, frozen=True, gc=False):
    """One word, wherever it stands."""

    name: str  #: its letter, or `BRAKING`
    value: float


class Lexer:
    """Takes lines apart, by the letters of the words that a controller knows."""

    def __init__(self, letters: Set[str] = LETTERS) -> None:
        self._letters = letters
        self._known: BoundedCache[str, Word] = BoundedCache("codesys.words")

    def block(self, text: str) -> CodesysBlock | CodesysFault | None:
        """The words of a line; None where there is nothing in it."""
        if not text.isascii():
            text = "".join(c if c.isascii() else "\N{REPLACEMENT CHARACTER}" for c in text)
        bare = text.upper()
        if "(" in bare or ")" in bare:
            bare = _COMMENT.sub(" ", bare)
            if "(" in bare or ")" in bare:
                expected = "a comment that begins and ends on its line, none in another"
                return CodesysFault(text.strip(), expected)
        command, number = "", 0
        words: dict[str, float] = {}
        for index, said in enumerate(bare.split()):
            word = self._known.get(said) or self._read_word(said)
            if not isinstance(word, Word):
                if not index and said.startswith("/"):
                    expected = "a block that always runs; `/` leaves that to a switch"
                    return CodesysFault(text.strip(), expected)
                return word
            name = word.name
            if name not in "GMN":
                if name in words:
                    return CodesysFault(said, f"{name} once in a block")
                words[name] = word.value
            elif name == "N":
                if index:
                    return CodesysFault(said, "the block number at the beginning")
            elif command:
                stands = f"{command}{number} stands there already"
                return CodesysFault(said, f"one command a block, {stands}")
            elif words:
                return CodesysFault(said, "the command before the other words")
            else:
                command, number = name, int(word.value)
        return CodesysBlock(command, number, words) if command or words else None

    def _read_word(self, text: str) -> Word | CodesysFault:
        """A letter and a number."""
        match = _WORD.fullmatch(text)
        if match is None:
            return CodesysFault(text, "a letter and a number, set off by spaces")
        letter, digits = match.groups()
        if letter not in self._letters:
            return CodesysFault(text, "a word that the controller knows")
        if letter in _WHOLE and not digits.isdigit():
            return CodesysFault(text, f"a whole number behind {letter}")
        value = float(digits)
        name = BRAKING if letter == "E" and value < 0.0 else letter
        return self._known.keep(text, Word(name, value))
