"""A trace sent to a Modbus TCP server, as the cell's controller would show itself.

Holding registers from 0 on, most significant first:

    0 .. 2n-1     the n axes, two registers each: IEEE 754 single, mm or degrees
    2n            spindle that is chosen          2n + 3   coolant, 0 or 1
    2n + 1        tool diameter in 0.01 mm        2n + 4   sawing, 0 or 1
    2n + 2        turning: 0, 1 or 65535 (-1)     2n + 5   line of the program

Needs pymodbus: `pip install beamcam[modbus]`.
"""

import struct
import time
from collections.abc import Callable, Iterable
from typing import Any

from beamcam.errors import Source, VerifyError
from beamcam.simulate import rules
from beamcam.simulate.course import Row


def registers(row: Row) -> list[int]:
    """A row as 16-bit words."""
    words: list[int] = []
    for position in row.positions:
        words += struct.unpack(">HH", struct.pack(">f", position))
    state = row.state
    return [
        *words, state.spindle & 0xFFFF, min(round(state.diameter * 100), 0xFFFF),
        state.turning & 0xFFFF, int(state.coolant), int(state.sawing), row.line & 0xFFFF,
    ]  # fmt: skip


def send(
    rows: Iterable[Row],
    host: str,
    port: int,
    pace: float = 0.0,
    sleep: Callable[[float], None] = time.sleep,
) -> int:
    """Write every row to the server and return how many there were.

    `pace` is how many seconds of the wall one second of the cell takes; 0 sends at once. Raises
    VerifyError if the server cannot be reached or refuses, or if pymodbus is not installed.
    """
    place = Source(f"{host}:{port}")
    try:
        from pymodbus import ModbusException
        from pymodbus.client import ModbusTcpClient
    except ImportError as error:
        raise VerifyError(
            rules.MODBUS.at(place, found="no pymodbus (pip install beamcam[modbus])")
        ) from error
    client: Any = ModbusTcpClient(host, port=port)
    if not client.connect():
        raise VerifyError(rules.MODBUS.at(place, found="no connection"))
    count, before = 0, 0.0
    try:
        for row in rows:
            if pace and row.time_s > before:
                sleep((row.time_s - before) * pace)
            before = row.time_s
            answer = client.write_registers(0, registers(row))
            if answer.isError():
                raise VerifyError(rules.MODBUS.at(place, found=f"the answer {answer}"))
            count += 1
    except ModbusException as error:
        raise VerifyError(rules.MODBUS.at(place, found=str(error))) from error
    finally:
        client.close()
    return count
