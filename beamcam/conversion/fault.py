"""A value that a record does not take."""

from collections.abc import Callable, Iterable
from typing import Any, Literal

Path = tuple[str | int, ...]
Hook = Callable[[Any, Any], Any]  #: type and value: the value as that type, or ValueError


class Fault(ValueError):
    """A value that a record does not take."""

    def __init__(
        self,
        kind: Literal["unknown", "missing", "type", "value"],
        path: Path,
        found: object,
        expected: str,
        known: tuple[str, ...] = (),
    ) -> None:
        super().__init__(kind, path, found, expected)
        self.kind = kind
        self.path = path  #: keys and indices from the top; of a missing key its own
        self.found = found
        self.expected = expected
        self.known = known  #: of an unknown key, those that there are


def nearest(word: str, known: Iterable[str]) -> str:
    """The known word most like `word`, as a suggestion; all of them where none is like it."""
    from difflib import get_close_matches

    names = sorted(known)
    close = get_close_matches(word, names, 1, 0.6)
    return repr(close[0]) if close else "one of " + ", ".join(names)
