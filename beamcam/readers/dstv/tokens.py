"""Text, lines and numbers of a DSTV file: what every block needs."""

import re

from msgspec import Struct, field

from beamcam.errors import Diagnostic, Rule, Source
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.readers.dstv.rules import DECIMAL_COMMA

PLAIN_CODES = ("ST", "EN", "BO", "SI", "AK", "IK", "PU", "KO", "SC", "TO", "UE", "PR", "KA", "IN")
PLANE_CODES = tuple(letter + digit for letter in "EBSAIPK" for digit in "0123456789")
CODES = frozenset(PLAIN_CODES + PLANE_CODES)

EDGES = ("u", "o", "s")  #: reference letters of x
_SHOWN = 80  #: characters of a row that a message shows
LARGEST = MAX_COORDINATE  #: keeps nan and inf out too

# DSTV NC, page 5: a change from digit to letter or back separates as a blank does.
# Blanks are taken with the token behind them: a search would try each of them for a token.
_TOKEN = re.compile(r"\s*([A-Za-z]|[+-]?[0-9]+[.,]?[0-9]*|[+-]?[.,][0-9]+|\S)", re.ASCII)
_COMMA = re.compile(r"[+-]?(?:[0-9]+,[0-9]*|,[0-9]+)", re.ASCII)


class RowError(ValueError):
    """A row that no rule of its block explains."""


class Log(Struct):
    """Diagnostics of one file, and the lines of it that were used."""

    file: str
    diagnostics: list[Diagnostic] = field(default_factory=list)
    taken: list[int] = field(default_factory=list)  #: lines whose content is in the part
    left_out: list[int] = field(default_factory=list)  #: lines that a diagnostic elsewhere counts

    def add(self, rule: Rule, line: int, **values: object) -> None:
        """Say `rule` of a line, with what was found cut to a length that can be read."""
        found = values.get("found")
        if isinstance(found, str) and len(found) > _SHOWN:
            values["found"] = found[: _SHOWN - 3] + "..."
        self.diagnostics.append(rule.at(Source(self.file, line), **values))


class Block(Struct):
    """A block code and its rows, stripped; `numbers` are the lines of the rows."""

    code: str
    line: int
    rows: list[str]
    numbers: list[int]


def split_lines(text: str) -> list[str]:
    """The lines of a text, whatever ends them; a DOS end mark (Ctrl-Z) ends the text.

    `str.splitlines` would also split at characters that code pages use for letters.
    """
    if "\x1a" in text:
        text = text.rstrip("\x1a\r\n")
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.split("\n")


def tokenise(row: str) -> list[str]:
    """Numbers and single letters of a row; glued ones are separated.

    >>> tokenise("v100.00u100.00s18.0")
    ['v', '100.00', 'u', '100.00', 's', '18.0']
    """
    return _TOKEN.findall(row)


def number(text: str, line: int, log: Log) -> float | None:
    """As `required_number`; None if `text` is no number."""
    try:
        return required_number(text, line, log)
    except RowError:
        return None


def required_number(text: str, line: int, log: Log) -> float:
    """The number that `text` writes, a decimal comma with a warning.

    Raises RowError if it is not a number.
    """
    try:
        value = float(text)
    except ValueError:
        if not _COMMA.fullmatch(text):
            raise RowError(text) from None
        value = float(text.replace(",", "."))
        log.add(DECIMAL_COMMA, line, found=text, value=value)
    # float also takes underscores between digits, nan and inf, which no file means as numbers
    if "_" in text or not -LARGEST < value < LARGEST:
        raise RowError(text)
    return value


def numbers(tokens: list[str], line: int, log: Log) -> list[float]:
    """All of `tokens` as numbers. Raises RowError if one is not a number."""
    return [required_number(token, line, log) for token in tokens]
