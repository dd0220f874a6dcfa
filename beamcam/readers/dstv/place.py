"""Where the rows of a block lie: what each inherits from the row before."""

from beamcam.errors import Severity
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.tokens import EDGES, Log, RowError

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


def said_error(log: Log, before: int) -> bool:
    """Whether an error was added to the log behind its first `before` diagnostics."""
    return any(d.severity is Severity.ERROR for d in log.diagnostics[before:])
