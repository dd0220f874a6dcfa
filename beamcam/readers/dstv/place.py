"""Where the rows of a block lie: what each inherits from the row before."""

from collections.abc import Callable, Iterator
from typing import TypeVar

from msgspec import Struct

from beamcam.errors import Rule, Severity
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.tokens import (
    EDGES,
    Block,
    Log,
    RowError,
    required_number,
    tokenise,
)

Item = TypeVar("Item")
RowReader = Callable[[str, int, "Place"], Item]  #: of a row, its line, and where it lies

FACE_LETTERS = frozenset("vouh")


class Place(Struct):
    """Face and reference letter of the rows of a block, each inherited from the row before."""

    log: Log
    plate: bool
    face: str  #: "" where no row has named one; of a block on a plane its name, which stays
    edge: str = ""

    def take(self, tokens: list[str], line: int) -> list[str]:
        """`tokens` without the face that they may begin with.

        Where no row named one it is v on a plate; on other sections RowError is raised.
        """
        if tokens and tokens[0] in FACE_LETTERS:
            if len(self.face) < 2:
                self.face = tokens[0]
            return tokens[1:]
        found = " ".join(tokens)
        if found[:1].isalpha() or not (self.face or self.plate):
            self.log.add(rules.FACE, line, found=found)
            raise RowError(found)
        if not self.face:
            self.log.add(rules.FACE_ASSUMED, line)
            self.face = "v"
        return tokens

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
        x = required_number(tokens[0], line, self.log)
        letter = tokens[1] if tokens[1].isalpha() else ""
        if letter:
            self.refer(letter, line)
            del tokens[1]
            if len(tokens) < least + 2:
                raise RowError(row)
        y = required_number(tokens[1], line, self.log)
        return x, letter, y, tokens[2:]


def rows_of(
    block: Block, place: Place, read: RowReader[Item], rule: Rule
) -> Iterator[tuple[int, Item]]:
    """The line of each row, and what `read` makes of it.

    Rows that `read` has no explanation for (RowError) are told by `rule`, unless an error says
    already what is wrong with them.
    """
    log = place.log
    for line, row in zip(block.numbers, block.rows, strict=True):
        before = len(log.diagnostics)
        try:
            item = read(row, line, place)
        except RowError:
            if not any(d.severity is Severity.ERROR for d in log.diagnostics[before:]):
                log.add(rule, line, found=row)
            continue
        yield line, item


def features_of(
    block: Block, place: Place, read: RowReader[Item | None], rule: Rule
) -> Iterator[Item]:
    """What `read` makes of the rows, whose lines are taken; rows that make nothing are not."""
    for line, item in rows_of(block, place, read, rule):
        if item is not None:
            place.log.taken.append(line)
            yield item
