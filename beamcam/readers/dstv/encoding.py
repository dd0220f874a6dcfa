"""The alphabet of a DSTV file: what it says itself, what is asked for, or what its letters suggest.

The standard allows ASCII only. Old files have the alphabet of the system that wrote them, and
nothing in them names it; the letters do:

    c1 e0 eb ea e0    Windows-1251: a word of letters above 0xBF only       Балка
    Tr 84 ger         code page 850: letters from 0x80 to 0x9F inside words  Träger
    Tr e4 ger         Latin-1: single letters above 0xBF inside words        Träger
"""

import re

from beamcam.errors import Diagnostic, Source
from beamcam.readers.rules import ENCODING

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


def decode_as(data: bytes, encoding: str, file: str) -> tuple[str, Diagnostic | None]:
    """The text of a file in the encoding that is asked for; what is wrong where it is none."""
    try:
        return data.decode(encoding), None
    except UnicodeError:
        line = 1 + data.count(b"\n", 0, _first_odd(data, encoding))
        return data.decode(encoding, "replace"), ENCODING.at(Source(file, line), encoding=encoding)


def guessed(data: bytes) -> str:
    """The encoding that the letters of a text suggest, where it is neither ASCII nor UTF-8."""
    words = [word for word in _WORD.findall(data) if not word.isascii()]
    odd = sum(sum(sign >= 0x80 for sign in word) for word in words)
    cyrillic = sum(len(word) for word in words if _CYRILLIC.fullmatch(word))
    dos = sum(
        sum(sign in _DOS_LETTERS for sign in word) for word in words if _has_plain_letters(word)
    )
    if 2 * cyrillic > odd:
        return "cp1251"
    return "cp850" if 2 * dos > odd else "latin-1"


def _has_plain_letters(word: bytes) -> bool:
    return any(sign < 0x80 for sign in word)


def _first_odd(data: bytes, encoding: str) -> int:
    """Position of the first bytes that are invalid in the encoding."""
    try:
        data.decode(encoding)
    except UnicodeDecodeError as error:
        return error.start
    except UnicodeError:
        pass
    return 0
