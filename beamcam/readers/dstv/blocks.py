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
    begin = start
    # Codes and empty lines have two characters at most, all others are rows or comments.
    for index in [i for i in range(start, len(texts)) if len(texts[i]) <= 2]:
        _add_rows(texts, begin, index, blocks, comments, end, log)
        begin = index + 1
        text = texts[index]
        if text == "**":
            comments.append((index + 1, ""))
        elif text:
            is_code = len(text) == 2 and not end
            code = _code(text, lines[index], index + 1, log) if is_code else None
            if code == "EN":
                end = index + 1
            elif code is not None:
                blocks.append(Block(code, index + 1, [], []))
            else:
                begin = index
    _add_rows(texts, begin, len(texts), blocks, comments, end, log)
    if not end:
        last = max((i for i, line in enumerate(lines, 1) if line.strip()), default=1)
        log.add(rules.NO_EN, last)
    return blocks, comments, end


def _add_rows(
    texts: Sequence[str], begin: int, stop: int, blocks: list[Block], comments: list[Loose],
    end: int, log: Log,
) -> None:  # fmt: skip
    """Add the lines from index `begin` up to `stop` to the last block, or to the comments."""
    if begin == stop:
        return
    rows = texts[begin:stop]
    if not end and "**" not in "\n".join(rows):
        if not blocks:
            blocks.append(Block("", begin + 1, [], []))
        blocks[-1].rows += rows
        blocks[-1].numbers += range(begin + 1, stop + 1)
        return
    for number, text in enumerate(rows, begin + 1):
        if text[:2] == "**":
            comments.append((number, text[2:]))
            continue
        if end:
            log.add(rules.AFTER_EN, number, found=text)
            continue
        if not blocks:
            blocks.append(Block("", number, [], []))
        row = text
        if "**" in text and blocks[-1].code not in _TEXT_CODES:
            row, comment = (part.strip() for part in text.split("**", 1))
            log.add(rules.COMMENT_INLINE, number)
            comments.append((number - 1, comment))
        blocks[-1].rows.append(row)
        blocks[-1].numbers.append(number)


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
