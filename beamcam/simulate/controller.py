"""A Modbus TCP server that shows a trace as the machine's controller would.

Which register has what: `registers`; the same stand as holding and as input registers. Needs
pymodbus: `pip install beamcam[modbus]`.
"""

import asyncio
import logging
from collections.abc import Callable, Iterable
from typing import Any

from beamcam.errors import Source, VerifyError
from beamcam.interrupts import LOOK_S, NEVER, Asked
from beamcam.machine.modbus import Modbus
from beamcam.simulate import rules
from beamcam.simulate.registers import registers
from beamcam.simulate.trace import TraceRow

ANY_DEVICE = 0  #: the server answers whatever unit it is asked as


def serve(
    rows: Iterable[TraceRow],
    modbus: Modbus,
    host: str,
    port: int,
    pace: float = 1.0,
    ready: Callable[[str, int], None] = lambda host, port: None,
    is_held: bool = True,
    asked: Asked = NEVER,
) -> None:
    """Show every row when it is due, then the last one until it is `asked` to end, if `is_held`.

    `pace` is how many seconds of the wall one second of the machine takes; `ready` is called with
    the address when the server answers. Raises VerifyError if it cannot listen there, or if
    pymodbus is not installed.
    """
    asyncio.run(_serve(rows, modbus, host, port, pace, ready, is_held, asked))


async def _serve(
    rows: Iterable[TraceRow], modbus: Modbus, host: str, port: int, pace: float,
    ready: Callable[[str, int], None], is_held: bool, asked: Asked,
) -> None:  # fmt: skip
    place = Source(f"{host}:{port}")
    waiting = iter(rows)
    first = next(waiting, None)
    if first is None:
        return
    words = registers(first, modbus)
    server = _server(modbus, words, host, port, place)
    try:
        try:
            await server.listen()
        except OSError as error:
            raise VerifyError(rules.PORT.at(place, found=error.strerror or error)) from error
        if server.transport is None:
            raise VerifyError(rules.PORT.at(place, found="a port that is taken"))
        ready(host, server.transport.sockets[0].getsockname()[1])
        loop = asyncio.get_running_loop()
        begun = loop.time()
        for row in waiting:
            due = begun + row.time_s * pace
            await asyncio.sleep(0)
            while not asked and (left := due - loop.time()) > 0:
                await asyncio.sleep(min(left, LOOK_S))
            if asked:
                return
            words[:] = registers(row, modbus)
        while is_held and not asked:
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
        raise VerifyError(rules.PORT.at(place, found=found)) from error

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
