"""The text of a DSTV file: its alphabet, lines and blocks, and the numbers of a row."""

import re
from collections.abc import Sequence

from msgspec import Struct, field

from beamcam.errors import Diagnostic, Rule, Source
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.readers import ENCODING
from beamcam.readers.dstv import rules

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
    """Diagnostics of one file, and the account of its lines: each is in the part or reported."""

    file: str
    diagnostics: list[Diagnostic] = field(default_factory=list)
    data_lines: list[int] = field(default_factory=list)
    taken: list[int] = field(default_factory=list)  #: lines whose content is in the part
    left_out: list[int] = field(default_factory=list)  #: lines that a diagnostic elsewhere counts

    @property
    def reported(self) -> set[int]:
        """Lines that a diagnostic names or counts."""
        return {d.source.line or 0 for d in self.diagnostics} | {*self.left_out}

    @property
    def lost(self) -> list[int]:
        """Data lines that are neither in the part nor in a diagnostic; always empty."""
        return sorted({*self.data_lines} - {*self.taken} - self.reported)

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
    if "\r" in text:  # twice before a line's end: sent twice as text
        text = text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace("\r", "\n")
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
        log.add(rules.DECIMAL_COMMA, line, found=text, value=value)
    # float also takes underscores between digits, nan and inf, which no file means as numbers
    if "_" in text or not -LARGEST < value < LARGEST:
        raise RowError(text)
    return value


def numbers(tokens: list[str], line: int, log: Log) -> list[float]:
    """All of `tokens` as numbers. Raises RowError if one is not a number."""
    return [required_number(token, line, log) for token in tokens]


Loose = tuple[int, str]  #: line and text of a comment

#: Blocks whose rows are texts, where two stars may stand for themselves.
_TEXT_CODES = frozenset({"SI", "IN", *(f"S{digit}" for digit in range(10))})


def split_blocks(
    lines: Sequence[str], texts: Sequence[str], start: int, log: Log
) -> tuple[list[Block], list[Loose], int]:
    """The blocks behind the header, the comments between, and the line of EN (0 if none).

    `texts` are the lines without the blanks around them, `start` the index behind the header.
    """
    blocks: list[Block] = []
    comments: list[Loose] = []
    end = 0
    for number, text in enumerate(texts[start:], start + 1):
        if "**" in text:
            if text[:2] == "**":
                comments.append((number, text[2:]))
                continue
            if text[2:].lstrip()[:2] == "**" and text[:2].upper() in CODES:
                log.add(rules.COMMENT_INLINE, number)
                comments.append((number - 1, text[2:].lstrip()[2:]))
                text = text[:2]
        code = _code(text, lines[number - 1], number, log) if len(text) == 2 and not end else None
        if code == "EN":
            end = number
        elif code is not None:
            blocks.append(Block(code, number, [], []))
        elif text and end:
            log.add(rules.AFTER_EN, number, found=text)
        elif text:
            if not blocks:
                blocks.append(Block("", number, [], []))
            if "**" in text and blocks[-1].code not in _TEXT_CODES:
                text, comment = (part.strip() for part in text.split("**", 1))
                log.add(rules.COMMENT_INLINE, number)
                comments.append((number - 1, comment))
            blocks[-1].rows.append(text)
            blocks[-1].numbers.append(number)
    if not end:
        last = max((i for i, line in enumerate(lines, 1) if line.strip()), default=1)
        log.add(rules.NO_EN, last)
    return blocks, comments, end


def _code(text: str, line: str, number: int, log: Log) -> str | None:
    """The block code that a line of two characters is; None if it is data."""
    if text in CODES:
        if line[0] in " \t":
            log.add(rules.CODE_INDENT, number, block=text)
        return text
    if not text.isascii() or not text[0].isalpha() or not text.isalnum():
        return None
    if text.upper() in CODES:
        log.add(rules.CODE_CASE, number, found=text, block=text.upper())
        return text.upper()
    return text if text.isupper() and line[0] not in " \t" else None


# --- encoding -------------------------------------------------------------------------------------

# The alphabet of a DSTV file: what it says itself, what is asked for, or what its letters suggest.
#
# The standard allows ASCII only. Old files have the alphabet of the system that wrote them, and
# nothing in them names it; the letters do:
#
#     c1 e0 eb ea e0    Windows-1251: a word of letters above 0xBF only       Балка
#     Tr 84 ger         code page 850: letters from 0x80 to 0x9F inside words  Träger
#     Tr e4 ger         Latin-1: single letters above 0xBF inside words        Träger


_WORD = re.compile(rb"[A-Za-z\x80-\xff]+")
_CYRILLIC = re.compile(rb"[\xc0-\xff\xa8\xb8]{2,}")  #: a word of them; A8 and B8 are the letter io
#: Those that Windows has typographic quotes and apostrophes for inside words are left out.
_DOS_LETTERS = frozenset(range(0x80, 0x9E)) - {0x91, 0x92, 0x9C}
_BOM = b"\xef\xbb\xbf"
NAMES = {"latin-1": "Latin-1", "cp1251": "Windows-1251 (Cyrillic)", "cp850": "code page 850 (DOS)"}


def decode(data: bytes) -> tuple[str, str | None]:
    """The text of a file, and the name of its encoding where it is not ASCII; never fails."""
    if data.isascii():
        return data.decode("ascii"), None
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace"), "UTF-16"
    try:
        return data.decode("utf-8-sig"), "UTF-8"
    except UnicodeDecodeError:
        name = guessed(data)
        return data.removeprefix(_BOM).decode(name, "replace"), NAMES[name]


def decode_as(data: bytes, encoding: str, log: Log) -> str:
    """The text of a file in an encoding that the user names, with an error where it is none."""
    try:
        return data.decode(encoding)
    except UnicodeError as error:
        line = 1 + data.count(b"\n", 0, getattr(error, "start", 0))
        log.add(ENCODING, line, encoding=encoding)
        return data.decode(encoding, "replace")


def guessed(data: bytes) -> str:
    """The encoding that the letters of a text suggest, where it is neither ASCII nor UTF-8."""
    words = [word for word in _WORD.findall(data) if not word.isascii()]
    odd = sum(sum(sign >= 0x80 for sign in word) for word in words)
    cyrillic = sum(len(word) for word in words if _CYRILLIC.fullmatch(word))
    mixed = (word for word in words if any(sign < 0x80 for sign in word))
    dos = sum(sum(sign in _DOS_LETTERS for sign in word) for word in mixed)
    if 2 * cyrillic > odd:
        return "cp1251"
    return "cp850" if 2 * dos > odd else "latin-1"
