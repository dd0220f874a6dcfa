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

from beamcam.controllers import rules
from beamcam.errors import Diagnostic, Source

#: Letters that the controller's help describes; a machine file may use more in its templates.
LETTERS = frozenset("NGMXYZABCPQUVWDEFHIJKLORT")
_WHOLE = frozenset("NGMH")
BRAKING = "E-"  #: how `read_blocks` calls an E with a negative value, which may stand beside E
NUMBER = r"[+-]?(?:[0-9]{1,15}(?:\.[0-9]{0,15})?|\.[0-9]{1,15})"  # no controller counts further
_WORD = re.compile(rf"([A-Z])({NUMBER})")
_COMMENT = re.compile(r"\([^()]*\)")
# What nearly every block of a program looks like; anything else takes the slower way below.
USUAL = re.compile(
    rf"([GM])([0-9]{{1,15}})(?: X({NUMBER}))?(?: Y({NUMBER}))?(?: Z({NUMBER}))?"
    rf"(?: F({NUMBER}))?(?: K({NUMBER}))?(?: L({NUMBER}))?"
    rf"(?(6)|(?: F({NUMBER}))?)"  # one F: of a move before K, of a cut behind it
)


#: Line (from 1), command ("G", "M", or "" where the last travel command goes on), its number, and
#: the other words. A plain tuple, because every run of `post` makes thousands of them.
Block = tuple[int, str, int, dict[str, float]]

_Body = tuple[str, int, dict[str, float]]
_BODIES = re.compile(r"^(?:N[0-9]+ )?(.*)$", re.MULTILINE)


def read_blocks(
    text: str, name: str, letters: Set[str] = LETTERS
) -> tuple[list[Block], list[Diagnostic]]:
    """The blocks of a program called `name`, and what is wrong with its syntax.

    `letters` are the addresses that the controller knows.
    """
    last = text.rstrip().count("\n") + 1
    blocks: list[Block] = []
    said: list[Diagnostic] = []
    known: dict[str, _Body] = {}  # programs say the same thing over and over
    for number, body in enumerate(_BODIES.findall(text), 1):
        parsed = known.get(body)
        if parsed is None:
            usual = USUAL.fullmatch(body)
            if usual is not None:
                known[body] = parsed = _usual(usual)
            else:
                found = _unusual(body, Source(name, number), not blocks or number == last, letters)
                if isinstance(found, Diagnostic):
                    said.append(found)
                    continue
                if found is None:
                    continue
                parsed = found
        blocks.append((number, *parsed))
    return blocks, said


def _unusual(
    body: str, place: Source, outermost: bool, letters: Set[str]
) -> _Body | Diagnostic | None:
    """As `_any_body`, and `%` on the first or the last line."""
    if not body.lstrip().startswith("%"):
        return _any_body(body, place, letters)
    if outermost:
        return None
    expected = "% on the first or the last line only"
    return rules.SYNTAX.at(place, found=body.strip(), expected=expected)


def _usual(match: re.Match[str]) -> _Body:
    command, number, x, y, z, f, k, second, last = match.groups()
    words: dict[str, float] = {}
    if x is not None:
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
    return command, int(number), words


def _any_body(raw: str, place: Source, letters: Set[str]) -> _Body | Diagnostic | None:
    """The body of any block; None where the line has none; what is wrong with it."""

    def wrong(found: str, expected: str) -> Diagnostic:
        return rules.SYNTAX.at(place, found=found, expected=expected)

    if not raw.isascii():
        raw = "".join(c if ord(c) < 128 else "\N{REPLACEMENT CHARACTER}" for c in raw)
    bare = _COMMENT.sub(" ", raw).upper()
    if "(" in bare or ")" in bare:
        return wrong(raw.strip(), "a comment that begins and ends on its line, none in another")
    if bare.lstrip().startswith("/"):
        return wrong(raw.strip(), "a block that always runs; `/` leaves that to a switch")
    command, number = "", 0
    words: dict[str, float] = {}
    for index, word in enumerate(bare.split()):
        match = _WORD.fullmatch(word)
        if match is None:
            return wrong(word, "a letter and a number, set off by spaces")
        letter, digits = match.groups()
        if letter not in letters:
            return wrong(word, "a word that the controller knows")
        if letter in _WHOLE and not digits.isdigit():
            return wrong(word, f"a whole number behind {letter}")
        if letter == "N":
            if index:
                return wrong(word, "the block number at the beginning")
        elif letter in "GM":
            if command:
                return wrong(word, f"one command a block, {command}{number} stands there already")
            if words:
                return wrong(word, "the command before the other words")
            command, number = letter, int(digits)
        else:
            value = float(digits)
            if letter == "E" and value < 0.0:
                letter = BRAKING
            if letter in words:
                return wrong(word, f"{letter} once in a block")
            words[letter] = value
    if not command and not words:
        return None
    return command, number, words
