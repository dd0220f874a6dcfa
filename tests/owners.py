"""Compare rows of owners with the words that an interpreter knows."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping

from beamcam.checks import Owner

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
