"""The C header: the rows of the binary form as an array, and macros that take one apart."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from beamcam.controllers.step_table import rules
from beamcam.controllers.step_table.rows import BLOCK_ROWS, Rows, Stream, shown, unpacked
from beamcam.machine.tables import Stepper

ROW = b"0x%08xu,\n"
ROW_BYTES = len(ROW % 0)
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
    """The rows of a C header. Raises TableFault."""
    first, *more = _frame(stepper)
    while (line := stream.take_line(first)) != first.encode():
        if not (line.startswith(b"/* ") and line.find(b"*/") == len(line) - 2):
            raise stream.fault(shown(line), f"a comment or {first}", stream.line - 1, rules.HEAD)
    for expected in more:
        line = stream.take_line(expected)
        if line != expected.encode():
            raise stream.fault(repr(shown(line)), repr(expected), stream.line - 1, rules.HEAD)
    clock_us = 0
    while data := stream.take(BLOCK_ROWS * ROW_BYTES):
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
    for end_line in _END:
        line = stream.take_line(repr(end_line.decode()))
        if line != end_line:
            raise stream.fault(repr(shown(line)), repr(end_line.decode()), stream.line - 1)
    if more_bytes := stream.take(1):
        raise stream.fault(f"{shown(more_bytes)!r} behind #endif", "the end of the table")


def _numbers(data: bytes, stream: Stream) -> NDArray[np.uint32]:
    """The numbers of some rows."""
    whole = len(data) // ROW_BYTES
    signs = np.frombuffer(data[: whole * ROW_BYTES], dtype=np.uint8).reshape(-1, ROW_BYTES)
    sample = np.frombuffer(ROW % 0, dtype=np.uint8)
    nibbles = _NIBBLES[signs[:, 2:10]]
    good = (signs[:, [0, 1, 10, 11, 12]] == sample[[0, 1, 10, 11, 12]]).all(axis=1)
    good &= (nibbles < 16).all(axis=1)
    bad = whole if good.all() else int(np.argmin(good))
    if bad * ROW_BYTES < len(data):
        found = repr(shown(data[bad * ROW_BYTES :][:ROW_BYTES]))
        raise stream.fault(found, "as 0x0000a1b2u,", stream.line + bad)
    pairs = nibbles[:, ::2] << 4 | nibbles[:, 1::2]
    return np.ascontiguousarray(pairs).view(">u4").ravel().astype(np.uint32)
