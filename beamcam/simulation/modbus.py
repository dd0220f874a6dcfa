"""A client of Modbus TCP: a trace sent to a server, or what a controller shows.

Which register has what: `registers`. Needs pymodbus: `pip install beamcam[modbus]`.
"""

import asyncio
import logging
import struct
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any, Self

from msgspec import Struct

from beamcam.errors import Rule, Source, VerifyError
from beamcam.machine.machine import Modbus
from beamcam.simulation import MODBUS, PORT, REGISTER
from beamcam.simulation.trace import State, Trace, TraceRow
from beamcam.system import LOOK_S, NEVER, EndRequest

# --- registers: positions of axes as a controller shows them, and back ----------------------------

# Registers from `modbus.first` on, axis after axis; of two registers which comes first is
# `word_order`:
#
#     int16    one an axis, signed, counts of the axis' scale; output k is axis k
#     int32    two an axis, signed, counts of the axis' scale
#     float    two an axis, IEEE 754 single, mm or degrees
#
# With `states` six more follow: spindle that is chosen, tool diameter in 0.01 mm, turning (0, 1 or
# 65535 for -1), coolant and sawing or the tool of a table (0 or 1), line of the program.


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
    words: list[int] = []
    for k, position in enumerate(row.positions):
        if modbus.values == "float":
            data = struct.pack(">f", position)
        else:
            counts = round(position / modbus.scale_of(k))
            data = counts.to_bytes(2 * modbus.words, "big", signed=True)
        own = struct.unpack(f">{len(data) // 2}H", data)
        words += own[::-1] if modbus.word_order == "low-first" else own
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
    positions: tuple[float, ...] = ()
    for k in range(axes):
        own = words[k * each : (k + 1) * each]
        own = own[::-1] if modbus.word_order == "low-first" else own
        data = struct.pack(f">{each}H", *own)
        if modbus.values == "float":
            positions += struct.unpack(">f", data)
        else:
            positions += (int.from_bytes(data, "big", signed=True) * modbus.scale_of(k),)
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
                REGISTER.at(
                    source, axis=axis.name, found=f"{furthest:g}",
                    expected=f"at most {most * scale:g}", scale=f"{scale:g}",
                )
            )  # fmt: skip


TIMEOUT_S = 0.8  #: that an answer may take, so that Ctrl-C ends a command within a second
MAX_READ = 125  #: registers in one answer, by the standard


class Client:
    """A connection to a Modbus TCP server. Raises VerifyError with its rule for whatever fails."""

    def __init__(self, host: str, port: int, rule: Rule = MODBUS) -> None:
        self._place, self._rule = Source(f"{host}:{port}"), rule
        try:
            from pymodbus import ModbusException
            from pymodbus.client import ModbusTcpClient
        except ImportError as error:
            raise self._failed("no pymodbus (pip install beamcam[modbus])") from error
        # What the library would log stands in the message of the error.
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)
        self._fault = ModbusException
        self._client: Any = ModbusTcpClient(host, port=port, timeout=TIMEOUT_S, retries=0)

    def __enter__(self) -> Self:
        if not self._client.connect():
            raise self._failed("no connection")
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()

    def write(self, address: int, words: list[int]) -> None:
        """Write holding registers."""
        self._asked(lambda: self._client.write_registers(address, words))

    def read(self, address: int, count: int) -> list[int]:
        """Read holding registers."""
        values: list[int] = []
        while len(values) < count:
            at, many = address + len(values), min(MAX_READ, count - len(values))
            answer = self._asked(partial(self._client.read_holding_registers, at, count=many))
            values += answer.registers
        return values

    def _asked(self, call: Callable[[], Any]) -> Any:
        try:
            answer = call()
        except self._fault as error:
            raise self._failed(str(error)) from error
        if answer.isError():
            raise self._failed(f"the answer {answer}")
        return answer

    def _failed(self, found: str) -> VerifyError:
        return VerifyError(self._rule.at(self._place, found=found))


def send(
    rows: Iterable[TraceRow], modbus: Modbus, host: str, port: int, pace: float = 0.0,
    sleep: Callable[[float], None] = time.sleep,
) -> int:  # fmt: skip
    """Write every row to the server and return how many there were.

    `pace` is how many seconds of the wall one second of the machine takes; 0 sends at once. Raises
    VerifyError if the server cannot be reached or refuses, or if pymodbus is not installed.
    """
    count, before = 0, 0.0
    with Client(host, port) as client:
        for row in rows:
            if pace and row.time_s > before:
                sleep((row.time_s - before) * pace)
            before = row.time_s
            client.write(modbus.first, registers(row, modbus))
            count += 1
    return count


def axes_shown(client: Client, modbus: Modbus, axes: int) -> Shown:
    """The current axis positions of a controller. Raises VerifyError."""
    return shown(client.read(modbus.first, register_count(modbus, axes)), modbus, axes)


# --- a Modbus TCP server that shows a trace as the machine's controller would ---------------------

# Which register has what: `registers`; the same stand as holding and as input registers. Needs
# pymodbus: `pip install beamcam[modbus]`.


ANY_DEVICE = 0  #: the server answers whatever unit is addressed


def serve(
    rows: Iterable[TraceRow], modbus: Modbus, host: str, port: int, pace: float = 1.0,
    ready: Callable[[str, int], None] = lambda host, port: None, is_held: bool = True,
    interrupt: EndRequest = NEVER,
) -> None:  # fmt: skip
    """Show every row when it is due; if `is_held`, the last one until `interrupt` asks for the end.

    `pace` is how many seconds of the wall one second of the machine takes; `ready` is called with
    the address when the server answers. Raises VerifyError if it cannot listen there, or if
    pymodbus is not installed.
    """
    waiting = iter(rows)
    first = next(waiting, None)
    if first is not None:
        words = registers(first, modbus)
        asyncio.run(_serve(words, waiting, modbus, host, port, pace, ready, is_held, interrupt))


async def _serve(
    words: list[int], rows: Iterator[TraceRow], modbus: Modbus, host: str, port: int, pace: float,
    ready: Callable[[str, int], None], is_held: bool, end: EndRequest,
) -> None:  # fmt: skip
    place = Source(f"{host}:{port}")
    server = _server(modbus, words, host, port, place)
    try:
        try:
            await server.listen()
        except OSError as error:
            raise VerifyError(PORT.at(place, found=error.strerror or error)) from error
        if server.transport is None:
            raise VerifyError(PORT.at(place, found="a port that is taken"))
        ready(host, server.transport.sockets[0].getsockname()[1])
        loop = asyncio.get_running_loop()
        begun = loop.time()
        for row in rows:
            due = begun + row.time_s * pace
            await asyncio.sleep(0)
            while not end and (left := due - loop.time()) > 0:
                await asyncio.sleep(min(left, LOOK_S))
            if end:
                return
            words[:] = registers(row, modbus)
        while is_held and not end:
            await asyncio.sleep(LOOK_S)
    finally:
        await server.shutdown()


def _server(modbus: Modbus, words: list[int], host: str, port: int, place: Source) -> Any:
    """A server that does not listen yet; it shows what stands in `words` when it is asked."""
    try:
        from pymodbus.constants import ExcCodes
        from pymodbus.server import ModbusTcpServer
        from pymodbus.simulator import DataType, SimData, SimDevice
    except ImportError as error:
        found = "no pymodbus of 3.16 or later (pip install beamcam[modbus])"
        raise VerifyError(PORT.at(place, found=found)) from error

    # What the library would log stands in the message of the error.
    logging.getLogger("pymodbus").setLevel(logging.CRITICAL)

    async def show(
        function: int, start: int, address: int, count: int, shown: list[int], written: object
    ) -> ExcCodes | None:
        if written is not None:
            return ExcCodes.ILLEGAL_FUNCTION  # axes are moved by the program alone
        at = modbus.first - start
        shown[at : at + len(words)] = words
        return None

    block = SimData(modbus.first, values=list(words), datatype=DataType.REGISTERS)
    return ModbusTcpServer(SimDevice(ANY_DEVICE, block, action=show), address=(host, port))
