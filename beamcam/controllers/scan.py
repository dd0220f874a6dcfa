"""The blocks of a text that are plain moves, all at once; every other block is left to be read.

    G1 X10 Y-5.5                     a letter and a number each, one space between them
    N12 G03 X0 Y0 I-5 J0 F600        block number, and feed behind, where they are said

Such blocks say all that there is to their move but the feed that goes on, so that their numbers
can be read as arrays. A block that differs in anything is not touched here.
"""

import re
from collections.abc import Sequence
from string import ascii_uppercase

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.geometry.array_types import Counts, Flags, Floats

LONGEST_NUMBER = 15  #: characters; how far a controller counts is a matter for its interpreter

_OTHER, _DIGIT, _DOT, _SIGN, _LETTER, _SPACE, _NEWLINE = range(7)
_KINDS = bytes(
    _DIGIT if c in "0123456789" else _DOT if c == "." else _SIGN if c in "+-"
    else _LETTER if c in ascii_uppercase else _SPACE if c == " " else _NEWLINE if c == "\n"
    else _OTHER
    for c in map(chr, range(256))
)  # fmt: skip
#: What may stand behind a character of each kind in a block of plain words.
_FOLLOWERS = {
    _LETTER: (_DIGIT, _DOT, _SIGN), _SIGN: (_DIGIT, _DOT), _DOT: (_DIGIT,),
    _DIGIT: (_DIGIT, _DOT, _SPACE, _NEWLINE), _SPACE: (_LETTER,), _NEWLINE: (_LETTER,),
}  # fmt: skip
#: Whether two kinds may follow one another, at 8 * first + second.
_PAIRS = bytes(k % 8 not in _FOLLOWERS.get(k // 8, ()) for k in range(256))
_TWO_DOTS = re.compile(rb"\.[0-9]*\.")


class PlainMoves(Struct, frozen=True):
    """The plain moves of a text, in its order; numbers that are not said are nan."""

    line: Counts  #: from 1
    motion: Counts  #: 0 to 3, as behind G
    end: Floats  #: X and Y, (n, 2)
    centre: Floats  #: I and J, (n, 2)
    feed: Floats  #: F


class Scan(Struct, frozen=True):
    """A text taken apart."""

    plain: PlainMoves
    odd: list[tuple[int, str]]  #: the other lines, by their number from 1
    lines: int


class _Words(Struct):
    """The words of all good lines, one after the other."""

    letter: NDArray[np.uint8]
    value: Floats
    whole: Flags  #: whether the number is digits and no more
    first: Counts  #: word of each line
    count: Counts  #: of the words of each line


def scan(
    text: str,
    longest: int | None = None,
    traverse_with_feed: bool = True,
    motions: Sequence[int] = range(4),
) -> Scan:
    """Takes a text apart; empty lines at its end do not count.

    Odd as well are lines longer than `longest`, moves whose motion is not in `motions`, and, where
    it is not allowed, a traverse with a feed. The first plain move and the last line always count
    as odd, so that the beginning and the end of a program are interpreted one by one.
    """
    text = text.rstrip("\n") + "\n"
    data = text.encode("ascii", "replace")
    kinds = data.translate(_KINDS)
    ends = np.flatnonzero(np.frombuffer(data, dtype=np.uint8) == ord("\n"))
    good = _good_lines(data, kinds, ends)
    if longest is not None:
        good &= np.diff(ends, prepend=-1) - 1 <= longest
    good[-1] = False
    plain, taken = _plain_moves(_words(data, kinds, ends, good), traverse_with_feed, motions)
    begins = np.concatenate(([0], ends[:-1] + 1))
    odd = np.flatnonzero(~taken)
    bounds = zip(*(a.tolist() for a in (odd + 1, begins[odd], ends[odd])), strict=True)
    return Scan(plain, [(k, text[a:b]) for k, a, b in bounds], len(ends))


def _good_lines(data: bytes, kinds: bytes, ends: Counts) -> Flags:
    """Which lines are letters with a number each and one space between them."""
    kind = np.frombuffer(kinds, dtype=np.uint8)
    pairs = np.left_shift(kind[:-1], 3)
    pairs |= kind[1:]
    wrong = np.flatnonzero(np.frombuffer(pairs.tobytes().translate(_PAIRS), dtype=np.bool_))
    if b"\2\2" in kinds.translate(None, bytes([_DIGIT])):
        twice = [found.start() for found in _TWO_DOTS.finditer(data)]
        wrong = np.concatenate((wrong, np.array(twice, dtype=np.int64)))
    good = np.ones(len(ends), dtype=bool)
    good[0] = kind[0] == _LETTER
    # What may not stand behind the end of a line is the fault of the next one.
    good[np.searchsorted(ends, wrong + (kind[wrong] == _NEWLINE))] = False
    letters = np.flatnonzero(kind == _LETTER)
    long = letters[np.diff(letters, append=len(kind)) > LONGEST_NUMBER + 2]
    good[np.searchsorted(ends, long)] = False
    return good


def _words(data: bytes, kinds: bytes, ends: Counts, good: Flags) -> _Words:
    """The letters and numbers of the good lines."""
    characters = np.frombuffer(data, dtype=np.uint8)
    kind = np.frombuffer(kinds, dtype=np.uint8)
    sizes = np.diff(ends, prepend=-1)
    is_letter = kind == _LETTER
    numbers = np.where(np.repeat(good, sizes) & ~is_letter, characters, ord(" "))
    letters = np.flatnonzero(is_letter)
    count = np.diff(np.searchsorted(letters, ends), prepend=0)
    letters = letters[np.repeat(good, count)]
    count[~good] = 0
    value = np.fromstring(numbers.tobytes().decode("ascii"), sep=" ")
    # A number without sign and dot: as many digits as there is room up to the next word.
    marks = np.flatnonzero((kind == _DOT) | (kind == _SIGN))
    whole = np.ones(len(letters), dtype=bool)
    owner = np.searchsorted(letters, marks) - 1
    whole[owner[owner >= 0]] = False
    return _Words(characters.take(letters), value, whole, np.cumsum(count) - count, count)


def _plain_moves(
    words: _Words, traverse_with_feed: bool, motions: Sequence[int]
) -> tuple[PlainMoves, Flags]:
    """The plain moves among the good lines but for the first, and which lines they are."""
    letter = np.concatenate((words.letter, np.zeros(8, dtype=np.uint8)))
    line = np.flatnonzero(words.count >= 3)
    at, rest = words.first[line], words.count[line]

    def has(name: str, at: Counts, rest: Counts) -> Flags:
        """Which lines, with so many words left, have a letter at a word."""
        found: Flags = (letter.take(at) == ord(name)) & (rest > 0)
        return found

    numbered = has("N", at, rest)
    right = ~numbered | words.whole.take(at)
    at, rest = at + numbered, rest - numbered
    right &= has("G", at, rest) & has("X", at + 1, rest - 1) & has("Y", at + 2, rest - 2)
    motion = words.value.take(at)
    right &= words.whole.take(at) & np.any([motion == known for known in motions], axis=0)
    centred = has("I", at + 3, rest - 3) & has("J", at + 4, rest - 4)
    right &= centred == (motion >= 2)
    behind = at + 3 + 2 * centred
    fed = has("F", behind, at + rest - behind)
    right &= at + rest == behind + fed
    if not traverse_with_feed:
        right &= ~fed | (motion > 0)
    right &= np.cumsum(right) > 1
    line, at, motion = line[right], at[right], motion[right]
    centred, behind, fed = centred[right], behind[right], fed[right]
    taken = np.zeros(len(words.count), dtype=bool)
    taken[line] = True
    end = np.column_stack((words.value.take(at + 1), words.value.take(at + 2)))
    centre = np.full((len(line), 2), np.nan)
    centre[centred, 0] = words.value.take(at[centred] + 3)
    centre[centred, 1] = words.value.take(at[centred] + 4)
    feed = np.full(len(line), np.nan)
    feed[fed] = words.value.take(behind[fed])
    return PlainMoves(line + 1, motion.astype(np.int64), end, centre, feed), taken
