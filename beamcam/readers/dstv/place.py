"""Where the rows of a block lie: what each inherits from the row before."""

from collections.abc import Callable, Iterator
from typing import TypeVar

from beamcam.errors import Rule, Severity
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.tokens import EDGES, Block, Log, RowError, numbers, tokenise

Item = TypeVar("Item")

FACE_LETTERS = frozenset("vouh")


class Place:
    """Face and reference letter of the rows of a block, each inherited from the row before."""

    __slots__ = ("edge", "face", "fixed", "log", "plate")

    def __init__(self, log: Log, plane: str | None, plate: bool) -> None:
        self.log = log
        self.fixed = plane is not None
        self.face = plane or ""
        self.edge = ""
        self.plate = plate

    def take(self, tokens: list[str], line: int) -> list[str]:
        """`tokens` without the face that they may begin with. Raises RowError if none is known."""
        if tokens and tokens[0] in FACE_LETTERS:
            if not self.fixed:
                self.face = tokens[0]
            return tokens[1:]
        self.need(line, " ".join(tokens))
        return tokens

    def need(self, line: int, found: str) -> None:
        """Assume v on a plate where no row named a face. Raises RowError on other sections."""
        if self.face and not found[:1].isalpha():
            return
        if not self.plate or found[:1].isalpha():
            self.log.add(rules.FACE, line, found=found)
            raise RowError(found)
        self.log.add(rules.FACE_ASSUMED, line)
        self.face = "v"

    def refer(self, letter: str, line: int) -> None:
        """Note the reference letter behind x."""
        if letter in EDGES:
            self.edge = letter
        elif letter in FACE_LETTERS:
            self.log.add(rules.EDGE, line, found=letter)
        else:
            raise RowError(letter)

    def corner(self, row: str, line: int, least: int = 0) -> tuple[float, str, float, list[str]]:
        """x, the letter behind it or "", y, and the tokens that follow, `least` or more.

        Raises RowError for a row that does not begin so.
        """
        tokens = self.take(tokenise(row), line)
        if len(tokens) < least + 2:
            raise RowError(row)
        (x,) = numbers(tokens[:1], line, self.log)
        letter = tokens[1] if tokens[1].isalpha() else ""
        if letter:
            self.refer(letter, line)
        rest = tokens[2:] if letter else tokens[1:]
        if len(rest) < least + 1:
            raise RowError(row)
        (y,) = numbers(rest[:1], line, self.log)
        return x, letter, y, rest[1:]


def rows_of(
    block: Block, log: Log, rule: Rule, read: Callable[[str, int], Item]
) -> Iterator[tuple[int, Item]]:
    """The line of each row, and what `read` makes of the row and its line.

    Rows that `read` has no explanation for (RowError) are told by `rule`, unless an error says
    already what is wrong with them.
    """
    for line, row in zip(block.numbers, block.rows, strict=True):
        before = len(log.diagnostics)
        try:
            item = read(row, line)
        except RowError:
            if not any(d.severity is Severity.ERROR for d in log.diagnostics[before:]):
                log.add(rule, line, found=row)
            continue
        yield line, item


def features_of(
    block: Block, log: Log, rule: Rule, read: Callable[[str, int], Item | None]
) -> Iterator[Item]:
    """What `read` makes of the rows, whose lines are taken; rows that make nothing are not."""
    for line, item in rows_of(block, log, rule, read):
        if item is not None:
            log.taken.append(line)
            yield item
