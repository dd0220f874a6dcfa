"""Tables for stepping motors: velocities as CSV, steps as text, as bytes and as a C header.

All forms come piece by piece, so that a table of any length takes no memory; rows are formatted
by arrays. The formats are described in docs/step-tables.md.
"""

import struct
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from beamcam.emitters.cutting import DIGITS
from beamcam.emitters.gcode import number
from beamcam.machine.machine import Machine
from beamcam.model.program import LASER_BIT, StepRows, StepTable
from beamcam.plain_text import comment_text, one_word

MAGIC = b"BCSTEPS1"
HEADER = struct.Struct("<8sIIIIII")  #: magic, own size, step in nm, words 0 to 3
TIME_SHIFT = 5  #: of a packed row: the bits lie below, the time since the last row above
MAX_WAIT_US = (1 << (32 - TIME_SHIFT)) - 1
BLOCK_ROWS = 1 << 16
STRETCHES_PER_PIECE = 4096

_HEX = np.frombuffer(b"".join(b"%04x" % k for k in range(65536)), dtype="V4")


def emit(table: StepTable, machine: Machine) -> str:
    """The step table as one text."""
    return b"".join(as_text(table)).decode("ascii")


def as_text(table: StepTable) -> Iterator[bytes]:
    """One row a step event: time in microseconds, word of X, word of Y, laser."""
    yield ("\n".join(_head(table, "steps", "time_us,x,y,laser")) + "\n").encode("ascii")
    bits = (f",{k >> 1 & 1}{k & 1},{k >> 3 & 1}{k >> 2 & 1},{k >> LASER_BIT}\n" for k in range(32))
    tails = np.frombuffer("".join(bits).encode("ascii"), dtype="V9")
    row = np.dtype([("a", "V4"), ("b", "V4"), ("c", "V4"), ("tail", "V9")])
    for rows in _blocks(table):
        text = np.empty(len(rows.time_us), dtype=row)
        high, low = np.divmod(rows.time_us, 10000)
        text["c"] = DIGITS.take(low)
        high, low = np.divmod(high, 10000)
        text["b"] = DIGITS.take(low)
        text["a"] = DIGITS.take(high)
        text["tail"] = tails.take(rows.bits)
        yield text.tobytes()


def _head(table: StepTable, form: str, columns: str) -> list[str]:
    """The comments and the line of columns of a table."""
    head = [f"# beamcam/{form}/1 job {one_word(table.job)} step {number(table.step, 6)} mm"]
    return [*head, *(f"# {comment_text(remark)}" for remark in table.remarks), columns]


def as_bytes(table: StepTable) -> Iterator[bytes]:
    """A header, and 4 bytes a row: the time since the last row, and the words."""
    words = [int(word, 2) for word in table.sequence]
    yield HEADER.pack(MAGIC, HEADER.size, round(table.step * 1e6), *words)
    for packed in _packed(table):
        yield packed.tobytes()


def as_header(table: StepTable) -> Iterator[bytes]:
    """The rows of the binary form as an array of C."""
    head = [f"/* beamcam/steps/1 job {one_word(table.job)} */"]
    head += [f"/* {comment_text(remark)} */" for remark in table.remarks]
    head += [
        "#ifndef BEAMCAM_STEPS_H", "#define BEAMCAM_STEPS_H", "#include <stdint.h>", "",
        f"#define BEAMCAM_STEP_NM {round(table.step * 1e6)}u",
        "#define BEAMCAM_X(row) ((row) & 3u)",
        "#define BEAMCAM_Y(row) (((row) >> 2) & 3u)",
        "#define BEAMCAM_LASER(row) (((row) >> 4) & 1u)",
        "#define BEAMCAM_WAIT_US(row) ((row) >> 5)",
        "#define BEAMCAM_STEPS (sizeof beamcam_steps / sizeof beamcam_steps[0])", "",
        "static const uint32_t beamcam_steps[] = {",
    ]  # fmt: skip
    yield ("\n".join(head) + "\n").encode("ascii")
    line = np.dtype([("x", "V2"), ("a", "V4"), ("b", "V4"), ("end", "V3")])
    for packed in _packed(table):
        text = np.empty(len(packed), dtype=line)
        text["x"] = np.frombuffer(b"0x", dtype="V2")[0]
        text["a"] = _HEX.take(packed >> 16)
        text["b"] = _HEX.take(packed & 0xFFFF)
        text["end"] = np.frombuffer(b"u,\n", dtype="V3")[0]
        yield text.tobytes()
    yield b"};\n\n#endif\n"


def as_velocities(table: StepTable) -> Iterator[bytes]:
    """One row a segment: end point, velocity vector, laser, steps and frequency of each axis."""
    columns = "x,y,velocity_x,velocity_y,laser,steps_x,steps_y,hz_x,hz_y"
    lines = _head(table, "velocities", columns)
    for s in table.segments():
        lines.append(
            f"{number(s.x, 4)},{number(s.y, 4)},{number(s.velocity_x, 4)},"
            f"{number(s.velocity_y, 4)},{int(s.laser)},{s.steps_x},{s.steps_y},"
            f"{number(s.hz_x, 2)},{number(s.hz_y, 2)}"
        )
        if len(lines) >= STRETCHES_PER_PIECE:
            yield ("\n".join(lines) + "\n").encode("ascii")
            lines = []
    if lines:
        yield ("\n".join(lines) + "\n").encode("ascii")


#: By the suffix of the output.
FORMS = {".steps": as_text, ".csv": as_velocities, ".bin": as_bytes, ".h": as_header}


def _blocks(table: StepTable) -> Iterator[StepRows]:
    """The rows in blocks that are worth the work of an array each."""
    held: list[StepRows] = []
    count = 0
    for rows in table.rows():
        held.append(rows)
        count += len(rows.time_us)
        if count >= BLOCK_ROWS:
            yield StepRows(*map(np.concatenate, zip(*held, strict=True)))
            held, count = [], 0
    if held:
        yield StepRows(*map(np.concatenate, zip(*held, strict=True)))


def _packed(table: StepTable) -> Iterator[NDArray[np.uint32]]:
    """Rows of 32 bits; a wait that is too long for one is spread over rows of the same words."""
    last_us, last_bits = 0, 0
    for rows in _blocks(table):
        times, bits = rows
        waits = np.empty_like(times)
        waits[0] = times[0] - last_us
        np.subtract(times[1:], times[:-1], out=waits[1:])
        if times[-1] - last_us > MAX_WAIT_US < int(waits.max()):
            before = np.append(np.uint8(last_bits), bits[:-1])
            extra = waits // (MAX_WAIT_US + 1)
            where = np.repeat(np.arange(len(waits)), extra)
            waits = np.insert(waits - extra * MAX_WAIT_US, where, np.full(len(where), MAX_WAIT_US))
            bits = np.insert(bits, where, before[where])
        last_us, last_bits = int(times[-1]), int(rows.bits[-1])
        packed = waits.astype("<u4")
        packed <<= np.uint32(TIME_SHIFT)
        packed |= bits
        yield packed
