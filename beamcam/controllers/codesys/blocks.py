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
# What nearly every block of a program looks like; anything else takes the slower way below.
USUAL = re.compile(
    rf"([GM])([0-9]{{1,15}})(?: X({NUMBER}))?(?: Y({NUMBER}))?(?: Z({NUMBER}))?"
    rf"(?: F({NUMBER}))?(?: K({NUMBER}))?(?: L({NUMBER}))?"
    rf"(?(6)|(?: F({NUMBER}))?)"  # one F: of a move before K, of a cut behind it
)


class Block(Struct, frozen=True, gc=False):
    """One block, whatever its number."""

    command: str  #: "G", "M", or "" where the last travel command goes on
    number: int
    words: dict[str, float]  #: the others


class Fault(Struct, frozen=True):
    """A syntax error in a block."""

    found: str
    expected: str


@cached("codesys.blocks")
def read_block(text: str, letters: frozenset[str] = LETTERS) -> Block | Fault | None:
    """A line without its block number; None where there is nothing in it.

    `letters` are the addresses that the controller knows.
    """
    usual = USUAL.fullmatch(text)
    return _any_block(text, letters) if usual is None else _usual(usual)


def _usual(match: re.Match[str]) -> Block:
    command, number, x, y, z, f, k, second, last = match.groups()
    words: dict[str, float] = {}
    if x is not None:  # one by one: a loop takes twice as long
        words["X"] = float(x)
    if y is not None:
        words["Y"] = float(y)
    if z is not None:
        words["Z"] = float(z)
    if f is not None:
        words["F"] = float(f)
    if k is not None:
        words["K"] = float(k)
    if second is not None:
        words["L"] = float(second)
    if last is not None:
        words["F"] = float(last)
    return Block(command, int(number), words)


def _any_block(raw: str, letters: Set[str]) -> Block | Fault | None:
    if not raw.isascii():
        raw = "".join(c if ord(c) < 128 else "\N{REPLACEMENT CHARACTER}" for c in raw)
    bare = _COMMENT.sub(" ", raw).upper()
    if "(" in bare or ")" in bare:
        expected = "a comment that begins and ends on its line, none in another"
        return Fault(raw.strip(), expected)
    if bare.lstrip().startswith("/"):
        return Fault(raw.strip(), "a block that always runs; `/` leaves that to a switch")
    command, number = "", 0
    words: dict[str, float] = {}
    for index, word in enumerate(bare.split()):
        match = _WORD.fullmatch(word)
        if match is None:
            return Fault(word, "a letter and a number, set off by spaces")
        letter, digits = match.groups()
        wrong = _out_of_place(letter, digits, index, Block(command, number, words), letters)
        if wrong:
            return Fault(word, wrong)
        if letter in "GM":
            command, number = letter, int(digits)
        elif letter != "N":
            value = float(digits)
            name = BRAKING if letter == "E" and value < 0.0 else letter
            if name in words:
                return Fault(word, f"{name} once in a block")
            words[name] = value
    return Block(command, number, words) if command or words else None


def _out_of_place(
    letter: str, digits: str, index: int, before: Block, letters: Set[str]
) -> str | None:
    """What a word should have been instead, behind those `before` it."""
    if letter not in letters:
        return "a word that the controller knows"
    if letter in _WHOLE and not digits.isdigit():
        return f"a whole number behind {letter}"
    if letter == "N" and index:
        return "the block number at the beginning"
    if letter in "GM" and before.command:
        return f"one command a block, {before.command}{before.number} stands there already"
    if letter in "GM" and before.words:
        return "the command before the other words"
    return None
