"""What answers for each word of a program: the codes that refuse it, and where it does no harm.

A module that has such rows names them in `OWNERS`, by stock and controller; the events that the
controllers make of a program have rows of their own. `tests/test_owners.py` takes the words that an
interpreter knows from the interpreter itself: one without a row fails, and so does a row without
its word. `beamcam codes --words` prints them all.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Literal

from msgspec import Struct

#: What a program is written for, or the events that are made of it.
Language = Literal[
    "codesys", "linuxcnc", "grbl", "mach3", "simotion", "plcopen", "stepper", "events"
]
Stock = Literal["beam", "sheet", "profile"]


class Owner(Struct, frozen=True):
    """Who answers for words, or for what they carry."""

    words: tuple[str, ...]  #: `G41`, the role of an M word of the machine file, or an event
    carries: tuple[str, ...] = ()  #: letters, placeholders or fields; none: the words themselves
    refused_by: tuple[
        str, ...
    ] = ()  #: codes of messages, those that begin alike as `verify-hole-*`
    harmless: str = ""  #: why, wherever none of them refuses it


Rows = Mapping[tuple[Stock, Language], tuple[Owner, ...]]
Vocabulary = Mapping[str, frozenset[str]]  #: words, each with what it may carry


def unowned(vocabulary: Vocabulary, rows: Iterable[Owner]) -> tuple[str, ...]:
    """What has no row, and what has two."""
    owned = Counter(_items(rows))
    known = {(word, letter) for word, letters in vocabulary.items() for letter in ("", *letters)}
    wrong = {item for item in known if not owned[item]} | {i for i in owned if owned[i] > 1}
    return tuple(sorted(" ".join(item).strip() for item in wrong))


def unknown(vocabularies: Collection[Vocabulary], rows: Iterable[Owner]) -> tuple[str, ...]:
    """What has a row, though none of the languages has such a word."""
    known = {
        (word, letter)
        for vocabulary in vocabularies
        for word, letters in vocabulary.items()
        for letter in ("", *letters)
    }
    return tuple(sorted(" ".join(item).strip() for item in {*_items(rows)} - known))


def _items(rows: Iterable[Owner]) -> Iterator[tuple[str, str]]:
    """Each word of the rows with each thing that it carries, "" for the word itself."""
    for row in rows:
        for word in row.words:
            for letter in row.carries or ("",):
                yield word, letter


def owner_of(word: str, letter: str, rows: Iterable[Owner]) -> Owner:
    """The row of a word, or of what it carries. Raises KeyError where there is none."""
    for row in rows:
        if word in row.words and (letter in row.carries if letter else not row.carries):
            return row
    raise KeyError(f"{word} {letter}".strip())
