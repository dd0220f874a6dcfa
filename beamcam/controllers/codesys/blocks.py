"""A program's text as blocks of words, by the syntax of CODESYS SoftMotion CNC (DIN 66025).

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

from beamcam.caches import cached

#: Letters that the controller's help describes; a machine file may use more in its templates.
LETTERS = frozenset("NGMXYZABCPQUVWDEFHIJKLORT")
_WHOLE = frozenset("NGMH")
BRAKING = "E-"  #: how `read_block` calls an E with a negative value, which may stand beside E
NUMBER = r"[+-]?(?:[0-9]{1,15}(?:\.[0-9]{0,15})?|\.[0-9]{1,15})"  # no controller counts further
_WORD = re.compile(rf"([A-Z])({NUMBER})")
_COMMENT = re.compile(r"\([^()]*\)")


class Block(Struct, frozen=True, gc=False):
    """One block, whatever its number."""

    command: str  #: "G", "M", or "" where the last travel command goes on
    number: int
    words: dict[str, float]  #: the others


class Fault(Struct, frozen=True):
    """A syntax error in a block."""

    found: str
    expected: str


class Word(Struct, frozen=True, gc=False):
    """One word, wherever it stands."""

    letter: str
    name: str  #: the letter, or `BRAKING`
    value: float
    is_whole: bool  #: whether its number is digits and no more


def read_block(text: str, letters: Set[str] = LETTERS) -> Block | Fault | None:
    """The words of a line; None where there is nothing in it.

    `letters` are the addresses that the controller knows.
    """
    if not text.isascii():
        text = "".join(c if c.isascii() else "\N{REPLACEMENT CHARACTER}" for c in text)
    bare = text.upper()
    if "(" in bare or ")" in bare:
        bare = _COMMENT.sub(" ", bare)
        if "(" in bare or ")" in bare:
            return Fault(
                text.strip(), "a comment that begins and ends on its line, none in another"
            )
    command, number = "", 0
    words: dict[str, float] = {}
    for index, said in enumerate(bare.split()):
        word = _read_word(said)
        if word is None:
            if not index and said.startswith("/"):
                expected = "a block that always runs; `/` leaves that to a switch"
                return Fault(text.strip(), expected)
            return Fault(said, "a letter and a number, set off by spaces")
        letter = word.letter
        if letter not in letters:
            return Fault(said, "a word that the controller knows")
        if letter in _WHOLE and not word.is_whole:
            return Fault(said, f"a whole number behind {letter}")
        if letter not in "GMN":
            if word.name in words:
                return Fault(said, f"{word.name} once in a block")
            words[word.name] = word.value
        elif letter == "N":
            if index:
                return Fault(said, "the block number at the beginning")
        elif command:
            stands = f"{command}{number} stands there already"
            return Fault(said, f"one command a block, {stands}")
        elif words:
            return Fault(said, "the command before the other words")
        else:
            command, number = letter, int(word.value)
    return Block(command, number, words) if command or words else None


@cached("codesys.words")
def _read_word(text: str) -> Word | None:
    """A letter and a number; None for anything else."""
    match = _WORD.fullmatch(text)
    if match is None:
        return None
    letter, digits = match.groups()
    value = float(digits)
    name = BRAKING if letter == "E" and value < 0.0 else letter
    return Word(letter, name, value, digits.isdigit())
