"""The blocks of a DSTV file: which lines are codes, which are rows, which are comments."""

from collections.abc import Sequence

from beamcam.readers.dstv import rules
from beamcam.readers.dstv.tokens import CODES, Block, Log

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
