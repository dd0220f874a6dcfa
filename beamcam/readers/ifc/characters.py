"""The characters of a text as an array, and what is found at many places of it at once."""

import numpy as np
from numpy.typing import NDArray

Codes = NDArray[np.uint8]  #: the characters of a text, one byte each, and a margin
Places = NDArray[np.int64]  #: of characters in a text
Truths = NDArray[np.bool_]  #: one for each place, or for each code
Words = NDArray[np.uint64]  #: eight characters as one number

MOST_DIGITS = 18  #: of a number that fits 64 bits
STRETCH = 1 << 18  #: characters that are looked at together, so that they stay in the cache
_WIDE = 8  #: characters in a word
_FACTOR = np.uint64(0x9E37_79B9_7F4A_7C15)  #: 2**64 over the golden ratio (Knuth, TAOCP 6.4)

_NONE: Places = np.empty(0, np.int64)
BLANK: Truths = np.isin(np.arange(256), [*b"\t\n\v\f\r\x1c\x1d\x1e\x1f \x85\xa0"])


def codes_of(text: str) -> Codes:
    """A byte for each character; a question mark stands for those that Latin-1 has not."""
    return np.frombuffer(text.encode("latin-1", "replace") + bytes(_WIDE), np.uint8)


def holds(codes: Codes, pair: bytes) -> bool:
    """Whether two characters stand side by side somewhere."""
    return bool(((codes[:-1] == pair[0]) & (codes[1:] == pair[1])).any())


def places_of(codes: Codes, signs: bytes) -> Places:
    """The places of all characters that are one of the signs."""
    found = []
    for start in range(0, len(codes), STRETCH):
        some = codes[start : start + STRETCH]
        there = np.zeros(len(some), bool)
        for sign in signs:
            there |= some == sign
        found.append(np.flatnonzero(there) + start)
    return np.concatenate([_NONE, *found])


def past_blanks(codes: Codes, at: Places) -> Places:
    """The places moved on to the first character that is not blank."""
    while (more := BLANK[codes[at]]).any():
        at = at + more
    return at


def back_over_blanks(codes: Codes, at: Places) -> Places:
    """The places moved back until the character before them is not blank."""
    while (more := BLANK[codes[at - 1]]).any():
        at = at - more
    return at


def numbers_at(codes: Codes, at: Places) -> tuple[Places, Places]:
    """The whole numbers that begin at the places, and the places behind them.

    A number has MOST_DIGITS at most; what follows them is left where it is.
    """
    numbers = np.zeros(len(at), np.int64)
    for _ in range(MOST_DIGITS):
        digits = codes[at] - np.uint8(ord("0"))  # what is below wraps round, to 200 and more
        more = digits < 10
        if not more.any():
            break
        numbers = np.where(more, numbers * 10 + digits, numbers)
        at = at + more
    return numbers, at


def same_word(codes: Codes, first: Places, last: Places) -> bool:
    """Whether the same word, all of it in Latin-1, goes from each first place up to its last."""
    length = last[0] - first[0]
    if (last - first != length).any():
        return False
    word = codes[first[0] : last[0]].tolist()
    # A question mark stands for any character that Latin-1 has not.
    return ord("?") not in word and all(
        (codes[first + k] == code).all() for k, code in enumerate(word)
    )


def words_before(codes: Codes, at: Places, size: int = _WIDE) -> Words:
    """The `size` characters before each place, of which there are 8 at most, as one number."""
    return _words(codes)[at - _WIDE] >> np.uint64(8 * (_WIDE - size))


def hashes(codes: Codes, first: Places, last: Places) -> Words:
    """A number for each of the words from `first` up to `last`.

    Words that differ have different numbers, but for one pair in 2**64.
    """
    words = _words(codes)
    lengths = last - first
    found = np.zeros(len(first), np.uint64)
    longer: Places | slice = slice(None)
    for done in range(0, int(lengths.max(initial=0)), _WIDE):
        # Eight characters at a time from the right; what stands before the word is shifted out.
        if done:
            longer = np.flatnonzero(lengths > done)
        before = 8 * np.maximum(_WIDE + done - lengths[longer], 0).astype(np.uint64)
        found[longer] = found[longer] * _FACTOR + (words[last[longer] - done - _WIDE] >> before)
    return found


def _words(codes: Codes) -> Words:
    """The eight characters from each place on as one number, the last of them the highest."""
    return np.ndarray((len(codes) - _WIDE + 1,), "<u8", codes, strides=(1,))
