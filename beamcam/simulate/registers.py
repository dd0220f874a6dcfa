"""The positions of axes as registers of a controller, and back.

Registers from `modbus.first` on, axis after axis; of two registers which comes first is
`word_order`:

    int16    one an axis, signed, counts of the axis' scale; output k is axis k
    int32    two an axis, signed, counts of the axis' scale
    float    two an axis, IEEE 754 single, mm or degrees

With `states` six more follow: spindle that is chosen, tool diameter in 0.01 mm, turning (0, 1 or
65535 for -1), coolant and sawing or the tool of a table (0 or 1), line of the program.
"""

import struct
from collections.abc import Sequence

from msgspec import Struct

from beamcam.errors import Source, VerifyError
from beamcam.machine.modbus import Modbus
from beamcam.simulate import rules
from beamcam.simulate.state import State
from beamcam.simulate.trace import Trace, TraceRow

STATES = 6  #: registers of what is switched on, and of the line
WORD = 0xFFFF
_BITS = {"int16": 16, "int32": 32}


class Shown(Struct, frozen=True):
    """The values that a controller publishes."""

    positions: tuple[float, ...]
    state: State = State()
    line: int = 0  #: modulo 65536


def register_count(modbus: Modbus, axes: int) -> int:
    """Registers in all, without those before the first."""
    return axes * modbus.words + (STATES if modbus.states else 0)


def registers(row: TraceRow, modbus: Modbus) -> list[int]:
    """A row as 16-bit words. Raises OverflowError for a position beyond its register."""
    words = [w for k, at in enumerate(row.positions) for w in _words(at, modbus, k)]
    if not modbus.states:
        return words
    state = row.state
    return [
        *words, state.spindle & WORD, min(round(state.diameter * 100), WORD), state.turning & WORD,
        int(state.coolant), int(state.sawing or bool(state.process)), row.line & WORD,
    ]  # fmt: skip


def shown(words: Sequence[int], modbus: Modbus, axes: int) -> Shown:
    """The register values of a number of axes."""
    each = modbus.words
    positions = tuple(_position(words[k * each : (k + 1) * each], modbus, k) for k in range(axes))
    if not modbus.states:
        return Shown(positions)
    spindle, diameter, turning, coolant, sawing, line = words[axes * each : axes * each + STATES]
    state = State(
        spindle, diameter / 100, turning - 0x10000 if turning > 0x7FFF else turning,
        bool(coolant), bool(sawing),
    )  # fmt: skip
    return Shown(positions, state, line)


def check_range(trace: Trace, modbus: Modbus, source: Source) -> None:
    """Raises VerifyError where a position of a trace is beyond its register."""
    if modbus.values == "float":
        return
    most = 2 ** (_BITS[modbus.values] - 1) - 1
    for k, axis in enumerate(trace.axes):
        scale = modbus.scale_of(k)
        furthest = float(max(trace.positions[:, k], key=abs))
        if abs(furthest) / scale > most:
            raise VerifyError(
                rules.REGISTER.at(
                    source, axis=axis.name, found=f"{furthest:g}",
                    expected=f"at most {most * scale:g}", scale=f"{scale:g}",
                )
            )  # fmt: skip


def _words(position: float, modbus: Modbus, axis: int) -> list[int]:
    if modbus.values == "float":
        data = struct.pack(">f", position)
    else:
        counts = round(position / modbus.scale_of(axis))
        data = counts.to_bytes(2 * modbus.words, "big", signed=True)
    words = list(struct.unpack(f">{len(data) // 2}H", data))
    return words[::-1] if modbus.word_order == "low-first" else words


def _position(words: Sequence[int], modbus: Modbus, axis: int) -> float:
    ordered = words[::-1] if modbus.word_order == "low-first" else words
    data = struct.pack(f">{len(words)}H", *ordered)
    if modbus.values == "float":
        (value,) = struct.unpack(">f", data)
        return float(value)
    return int.from_bytes(data, "big", signed=True) * modbus.scale_of(axis)
