"""The blocks of a DSTV file: which lines are codes, which are rows, which are comments."""

import re
from bisect import bisect_right
from collections.abc import Sequence
from itertools import zip_longest

from msgspec import Struct, field

from beamcam.errors import Diagnostic, Source
from beamcam.model.part import Contour, Feature, FileComment, Plane, SectionPoint
from beamcam.readers import ENCODING
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.contours import ContourRows
from beamcam.readers.dstv.tokens import CODES, Block, Log

Loose = tuple[int, str]  #: line and text of a comment

#: Blocks whose rows are texts, where two stars may stand for themselves.
_TEXT_CODES = frozenset({"SI", "IN", *(f"S{digit}" for digit in range(10))})


class BlockContent(Struct):
    """What the blocks of a file give the part."""

    features: list[Feature | ContourRows] = field(default_factory=list)
    planes: list[Plane] = field(default_factory=list)
    section: list[SectionPoint] = field(default_factory=list)
    info: list[tuple[str, str]] = field(default_factory=list)
    tolerance: tuple[float, float] | None = None
    contours: list[ContourRows] = field(default_factory=list)
    plane_names: dict[str, str] = field(default_factory=dict)  #: by digit, the last plane's name


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
        if text[:2] == "**":
            comments.append((number, text[2:]))
            continue
        code = _code(text, lines[number - 1], number, log) if len(text) == 2 and not end else None
        if code == "EN":
            end = number
        elif code is not None:
            blocks.append(Block(code, number, [], []))
        elif text and end:
            log.add(rules.AFTER_EN, number, found=text)
        elif text:
            _add_row(text, number, blocks, comments, log)
    if not end:
        last = max((i for i, line in enumerate(lines, 1) if line.strip()), default=1)
        log.add(rules.NO_EN, last)
    return blocks, comments, end


def _add_row(row: str, number: int, blocks: list[Block], comments: list[Loose], log: Log) -> None:
    """Add a row to the last block, a comment behind it to the comments."""
    if not blocks:
        blocks.append(Block("", number, [], []))
    block = blocks[-1]
    if "**" in row and block.code not in _TEXT_CODES:
        row, comment = (part.strip() for part in row.split("**", 1))
        log.add(rules.COMMENT_INLINE, number)
        comments.append((number - 1, comment))
    block.rows.append(row)
    block.numbers.append(number)


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


# --- comments -------------------------------------------------------------------------------------

# Positions of comments: the object that each precedes, by its line.


Placed = tuple[int, str, str]  #: line, anchor, text
Stop = tuple[int, str]  #: a line that a comment can stand before, and its anchor


def place_comments(
    placed: list[Placed], loose: list[tuple[int, str]], blocks: list[Block], end: int,
    features: Sequence[Feature], content: BlockContent,
) -> tuple[FileComment, ...]:  # fmt: skip
    """All comments of a file with their anchors, in the order in which a writer meets them.

    `placed` have their anchor already; `loose` are lines and texts between the blocks.
    """
    if not loose:
        return tuple(FileComment(text, anchor) for _, anchor, text in placed)
    from beamcam.model.anchors import anchor_key, plane_positions

    stops = _stops(blocks, features, content)
    lines = [line for line, _ in stops]
    comments = list(placed)
    for line, text in loose:
        if end and line > end:
            anchor = "after-end"
        else:
            at = bisect_right(lines, line)
            anchor = stops[at][1] if at < len(stops) else "end"
        comments.append((line, anchor, text))
    positions = plane_positions(content.planes, features)
    comments.sort(key=lambda item: anchor_key(item[1], positions))
    return tuple(FileComment(text, anchor) for _, anchor, text in comments)


def _stops(blocks: list[Block], features: Sequence[Feature], content: BlockContent) -> list[Stop]:
    """Every line that a comment can stand before, in order, with its anchor."""
    things: list[Stop] = []
    rows_of = {rows.line: rows for rows in content.contours}
    for i, feature in enumerate(features):
        line = feature.source.line or 0
        things.append((line, f"feature:{i}"))
        rows = rows_of.get(line)
        if rows is not None and isinstance(feature, Contour):
            things += _row_stops(rows, i)
    block_at = {block.line: block for block in blocks}
    for k, plane in enumerate(content.planes):
        block = block_at[plane.source.line or 0]
        things += [
            (line, f"plane:{k}:{row}" if row else f"plane:{k}")
            for row, line in enumerate(block.numbers[:3])
        ]
    counts = {"PR": 0, "IN": 0}
    for block in blocks:
        if block.code in counts:
            name = "section" if block.code == "PR" else "info"
            for line in block.numbers:
                things.append((line, f"{name}:{counts[block.code]}"))
                counts[block.code] += 1
        elif block.code == "TO" and block.numbers:
            things.append((block.numbers[0], "tolerance"))
    things.sort()
    lines = [line for line, _ in things]
    for block, limit in zip_longest(blocks, [block.line for block in blocks[1:]]):
        at = bisect_right(lines, block.line)
        if at < len(lines) and (limit is None or lines[at] < limit):
            things.append((block.line, "block:" + things[at][1]))
    things.sort()
    return things


def _row_stops(rows: ContourRows, feature: int) -> list[Stop]:
    """The rows of a contour behind its first; of one that was turned round, counted from its end.

    A comment stands between two rows, so that turning round puts it before the other one.
    """
    lines = sorted({*rows.lines, *rows.notch_lines})
    count = len(lines)
    return [
        (line, f"feature:{feature}:{count - row if rows.turned else row}")
        for row, line in enumerate(lines)
        if row
    ]


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
    mixed = (word for word in words if any(sign < 0x80 for sign in word))
    dos = sum(sum(sign in _DOS_LETTERS for sign in word) for word in mixed)
    if 2 * cyrillic > odd:
        return "cp1251"
    return "cp850" if 2 * dos > odd else "latin-1"


def _first_odd(data: bytes, encoding: str) -> int:
    """Position of the first bytes that are invalid in the encoding."""
    try:
        data.decode(encoding)
    except UnicodeDecodeError as error:
        return error.start
    except UnicodeError:
        pass
    return 0
