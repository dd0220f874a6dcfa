"""A trigger program taken apart: its fixed part, compared byte by byte, and what is the job's own.

The fixed part is shipped and proved by itself, see `trial`; what differs from job to job is read by
`job`.
"""

import re

from msgspec import Struct

from beamcam.controllers.simotion import rules
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.machine.runtime import STYLES, runtime_of

UNIT = re.compile(r"\(\* ===== UNIT (\w+) ===== \*\)")
_REMARK = re.compile(r"\(\* (?:(?!\*\)|\(\*).)+ \*\)")
_BOUNDARY = "(* ----- Runtime ----- *)"
_ARRAY = "        triggerActive : ARRAY ["

Line = tuple[int, str]  #: number in the program, and text


class JobText(Struct, frozen=True):
    """The lines of a program that are the job's own."""

    style: str
    declarations: tuple[Line, ...]
    operations: tuple[Line, ...]
    data: tuple[Line, ...]  #: of all units of set-points


class Unreadable(Exception):
    """A deviation from the fixed part of every program."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(str(diagnostic))
        self.diagnostic = diagnostic


def job_of(text: str, machine: Machine, name: str = "program") -> JobText:
    """The job's own lines. Raises Unreadable where the fixed part differs."""
    return _Frame(text.replace("\r\n", "\n").split("\n"), machine, name).read()


class _Frame:
    def __init__(self, lines: list[str], machine: Machine, name: str) -> None:
        self.lines, self.machine, self.name, self.at = lines, machine, name, 0

    def read(self) -> JobText:
        if not UNIT.fullmatch(self.lines[0]):
            raise self.syntax(self.lines[0], "(* ===== UNIT name ===== *)")
        self.at = 1
        head = runtime_of(self.machine, STYLES[0]).head
        first = head.partition("\n")[0]
        for line in self.lines[1:]:
            if line == first or not _REMARK.fullmatch(line):
                break
            self.at += 1
        self.fixed(head)
        declarations = self.own()
        chained = any(text.startswith(_ARRAY) for _, text in declarations)
        runtime = runtime_of(self.machine, "chain" if chained else "table")
        self.fixed(runtime.middle)
        operations = self.own()
        self.fixed(runtime.end)
        data = tuple(enumerate(self.lines[self.at :], self.at + 1))
        return JobText("chain" if chained else "table", declarations, operations, data)

    def fixed(self, expected: str) -> None:
        """Take the lines of a fixed piece. Raises Unreadable at the first that is another."""
        for wanted in expected.split("\n")[:-1]:
            ended = self.at + 1 >= len(self.lines)  # what follows its last line end is a line too
            found = "the end of the program" if ended else self.lines[self.at]
            if found != wanted:
                source = Source(self.name, self.at + 1)
                said = rules.RUNTIME.at(source, found=found.strip(), expected=wanted.strip())
                raise Unreadable(said)
            self.at += 1

    def own(self) -> tuple[Line, ...]:
        """The lines up to the next fixed piece, which begins with a comment of its own."""
        start = self.at
        while self.at < len(self.lines) and self.lines[self.at].strip() != _BOUNDARY:
            self.at += 1
        if self.at == len(self.lines):
            source = Source(self.name, self.at)
            found = "the end of the program"
            raise Unreadable(rules.RUNTIME.at(source, found=found, expected=_BOUNDARY))
        return tuple(enumerate(self.lines[start : self.at], start + 1))

    def syntax(self, found: str, expected: str) -> Unreadable:
        source = Source(self.name, self.at + 1)
        return Unreadable(rules.SYNTAX.at(source, found=found, expected=expected))
