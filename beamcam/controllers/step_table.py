"""The rows of a step table, from each of the forms that hold them.

    .steps   a row is a line of 20 signs
    .bin     a head of 32 bytes, a row is 4 bytes
    .h       the same 4 bytes as a number in an array of C

All come in blocks of rows, so that a table of any length takes no memory.
"""

import re
import struct
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beamcam.errors import Rule, Source, VerifyError, error
from beamcam.geometry.array_types import Counts
from beamcam.machine.tables import Stepper

# fmt: off

ROW = error("steps-row",
    "found {found}; expected {expected}",
    "The micro-controller would stop there, or read something else.")
HEAD = error("steps-head",
    "found {found} in the head of the table; expected {expected}",
    "The table is for motors or lead screws that this machine does not have.")
# fmt: on

BLOCK_ROWS = 1 << 16
COLUMNS = "time_us,x,y,laser"
ROW_BYTES = 21  #: 12 digits, 3 commas, 2 + 2 + 1 bits and the end of the line
_FIRST_LINE = re.compile(rb"# beamcam/(\w+)/1 job [\w.-]+ step (\d+(?:\.\d+)?) mm")
_HEAD = struct.Struct("<8sIIIIII")  #: magic, own size, step in nm, words
_MAGIC = b"BCSTEPS1"
_NM = 1e6  #: nanometres in a millimetre


class Rows(NamedTuple):
    """Some rows of a table."""

    first: int  #: line of the first of them
    time_us: Counts
    x: Counts  #: words
    y: Counts
    laser: Counts


class Stream:
    """Bytes that come piece by piece, taken by lines or by numbers of bytes."""

    def __init__(self, pieces: Iterable[bytes], name: str) -> None:
        self._pieces = iter(pieces)
        self._rest, self._at = b"", 0
        self.name, self.line = name, 1

    def fault(
        self, found: str, expected: str, line: int | None = None, rule: Rule = ROW
    ) -> VerifyError:
        """The fault at a line, or at the next one."""
        source = Source(self.name, self.line if line is None else line)
        return VerifyError(rule.at(source, found=found, expected=expected))

    def _fill(self, size: int) -> int:
        """How many bytes there are, of `size` that are asked for."""
        while len(self._rest) - self._at < size:
            piece = next(self._pieces, None)
            if piece is None:
                break
            self._rest, self._at = self._rest[self._at :] + piece, 0
        return min(size, len(self._rest) - self._at)

    def take(self, size: int) -> bytes:
        """The next bytes, `size` of them unless the table ends."""
        size = self._fill(size)
        data = self._rest[self._at : self._at + size]
        self._at += size
        return data

    def give_back(self, data: bytes) -> None:
        """Put bytes back that belong to what comes."""
        self._rest, self._at = data + self._rest[self._at :], 0

    def take_line(self, expected: str) -> bytes:
        """The next line without its end, of either kind."""
        size = 256
        while True:
            there = self._fill(size)
            end = self._rest.find(b"\n", self._at, self._at + there)
            if end >= 0:
                break
            if there < size:
                text = repr(shown(self._rest[self._at :])) if there else "the end of the table"
                raise self.fault(text, expected)
            size *= 2
        line = self._rest[self._at : end]
        self._at = end + 1
        self.line += 1
        return line.removesuffix(b"\r")

    def take_head(self, form: str, columns: str, step: float) -> None:
        """The comments and the line of columns, by which it is a table in that form and step."""
        while (line := self.take_line(columns)) != columns.encode():
            if not line.startswith(b"#"):
                raise self.fault(shown(line), columns, self.line - 1)
            if line.startswith(b"# beamcam/"):
                match = _FIRST_LINE.fullmatch(line)
                if match is None or (match[1].decode(), float(match[2])) != (form, step):
                    expected = f"# beamcam/{form}/1 job JOB step {step:g} mm"
                    raise self.fault(shown(line), expected, self.line - 1, HEAD)


def shown(data: bytes) -> str:
    """Bytes as a message shows them."""
    return data[:40].decode("ascii", "replace")


def text_rows(stream: Stream, stepper: Stepper) -> Iterator[Rows]:
    """The rows of the text form. Raises VerifyError."""
    stream.take_head("steps", COLUMNS, stepper.step)
    while data := stream.take(BLOCK_ROWS * ROW_BYTES):
        if len(data) % ROW_BYTES:
            whole = len(data) // ROW_BYTES
            found = repr(shown(data[whole * ROW_BYTES :]))
            raise stream.fault(found, "rows of 20 characters", stream.line + whole)
        rows = _text_block(data, stream)
        yield rows
        stream.line += len(rows.x)


def _text_block(data: bytes, stream: Stream) -> Rows:
    signs = np.frombuffer(data, dtype=np.uint8).reshape(-1, ROW_BYTES)
    fixed = (signs[:, [12, 15, 18]] == ord(",")).all(axis=1) & (signs[:, 20] == ord("\n"))
    figures = signs[:, [*range(12), 13, 14, 16, 17, 19]].astype(np.int64) - ord("0")
    good = fixed & (figures >= 0).all(axis=1) & (figures[:, :12] <= 9).all(axis=1)
    good &= (figures[:, 12:] <= 1).all(axis=1)
    if not good.all():
        bad = int(np.argmin(good))
        found = repr(shown(signs[bad].tobytes()))
        raise stream.fault(found, "as 000000001234,01,10,1", stream.line + bad)
    time = figures[:, :12] @ (10 ** np.arange(11, -1, -1))
    x, y = 2 * figures[:, 12] + figures[:, 13], 2 * figures[:, 14] + figures[:, 15]
    return Rows(stream.line, time, x, y, figures[:, 16])


def binary_rows(stream: Stream, stepper: Stepper) -> Iterator[Rows]:
    """The rows of the binary form, which are counted from 1. Raises VerifyError."""
    data = stream.take(_HEAD.size)
    if not data.startswith(_MAGIC) or len(data) < _HEAD.size:
        raise stream.fault(repr(shown(data[:8])), f"{_MAGIC.decode()} and a head of 32 bytes")
    _, *head = _HEAD.unpack(data)
    expected = [_HEAD.size, round(stepper.step * _NM), *(int(w, 2) for w in stepper.sequence)]
    if head != expected:
        raise stream.fault(str(head), f"size, step in nm and words {expected}", rule=HEAD)
    clock_us = 0
    while data := stream.take(BLOCK_ROWS * 4):
        if len(data) % 4:
            raise stream.fault(f"{len(data) % 4} bytes at the end", "rows of 4")
        rows = unpacked(np.frombuffer(data, dtype="<u4"), stream.line, clock_us)
        clock_us = int(rows.time_us[-1])
        yield rows
        stream.line += len(rows.x)


def unpacked(packed: NDArray[np.uint32], first: int, clock_us: int) -> Rows:
    """Rows of the binary form: the time since the row before, laser, word of Y, word of X."""
    numbers = packed.astype(np.int64)
    time = clock_us + np.cumsum(numbers >> 5)
    return Rows(first, time, numbers & 3, numbers >> 2 & 3, numbers >> 4 & 1)


# --- C header: the rows of the binary form as an array, and macros that take one apart ------------

_NUMBER = b"0x%08xu,\n"
_NUMBER_BYTES = len(_NUMBER % 0)
_END = (b"};", b"", b"#endif")
_NIBBLES = np.full(256, 255, dtype=np.uint8)
_NIBBLES[np.frombuffer(b"0123456789abcdef", dtype=np.uint8)] = np.arange(16)


def _frame(stepper: Stepper) -> list[str]:
    """The lines between the comments and the array; docs/step-tables.md lists them."""
    return [
        "#ifndef BEAMCAM_STEPS_H", "#define BEAMCAM_STEPS_H", "#include <stdint.h>", "",
        f"#define BEAMCAM_STEP_NM {round(stepper.step * 1e6)}u",
        "#define BEAMCAM_X(row) ((row) & 3u)",
        "#define BEAMCAM_Y(row) (((row) >> 2) & 3u)",
        "#define BEAMCAM_LASER(row) (((row) >> 4) & 1u)",
        "#define BEAMCAM_WAIT_US(row) ((row) >> 5)",
        "#define BEAMCAM_STEPS (sizeof beamcam_steps / sizeof beamcam_steps[0])", "",
        "static const uint32_t beamcam_steps[] = {",
    ]  # fmt: skip


def header_rows(stream: Stream, stepper: Stepper) -> Iterator[Rows]:
    """The rows of a C header. Raises VerifyError."""
    first, *more = _frame(stepper)
    while (line := stream.take_line(first)) != first.encode():
        if not (line.startswith(b"/* ") and line.find(b"*/") == len(line) - 2):
            raise stream.fault(shown(line), f"a comment or {first}", stream.line - 1, HEAD)
    for expected in more:
        line = stream.take_line(expected)
        if line != expected.encode():
            raise stream.fault(repr(shown(line)), repr(expected), stream.line - 1, HEAD)
    clock_us = 0
    while data := stream.take(BLOCK_ROWS * _NUMBER_BYTES):
        end = data.find(b"}")
        if end >= 0:
            stream.give_back(data[end:])
            data = data[:end]
        if data:
            rows = unpacked(_numbers(data, stream), stream.line, clock_us)
            clock_us = int(rows.time_us[-1])
            yield rows
            stream.line += len(rows.x)
        if end >= 0:
            break
    for last in _END:
        line = stream.take_line(repr(last.decode()))
        if line != last:
            raise stream.fault(repr(shown(line)), repr(last.decode()), stream.line - 1)
    if more_bytes := stream.take(1):
        raise stream.fault(f"{shown(more_bytes)!r} behind #endif", "the end of the table")


def _numbers(data: bytes, stream: Stream) -> NDArray[np.uint32]:
    whole = len(data) // _NUMBER_BYTES
    signs = np.frombuffer(data[: whole * _NUMBER_BYTES], dtype=np.uint8).reshape(-1, _NUMBER_BYTES)
    sample = np.frombuffer(_NUMBER % 0, dtype=np.uint8)
    nibbles = _NIBBLES[signs[:, 2:10]]
    good = (signs[:, [0, 1, 10, 11, 12]] == sample[[0, 1, 10, 11, 12]]).all(axis=1)
    good &= (nibbles < 16).all(axis=1)
    bad = whole if good.all() else int(np.argmin(good))
    if bad * _NUMBER_BYTES < len(data):
        found = repr(shown(data[bad * _NUMBER_BYTES :][:_NUMBER_BYTES]))
        raise stream.fault(found, "as 0x0000a1b2u,", stream.line + bad)
    pairs = nibbles[:, ::2] << 4 | nibbles[:, 1::2]
    return np.ascontiguousarray(pairs).view(">u4").ravel().astype(np.uint32)
