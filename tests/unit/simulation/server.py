"""A Modbus TCP server that takes registers, in a thread of its own."""

import asyncio
import threading

from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from tests.runs import HANG_S


class Server:
    """A server on the loopback, on a port that the system chooses where none is said."""

    def __init__(self, size: int, port: int = 0) -> None:
        block = SimData(0, values=[0] * size, datatype=DataType.REGISTERS)
        self.device = SimDevice(0, block)
        self.loop = asyncio.new_event_loop()
        self.ready = threading.Event()
        self.port = port
        self.thread = threading.Thread(target=self._serve, daemon=True)

    def _serve(self) -> None:
        asyncio.set_event_loop(self.loop)
        self.loop.run_until_complete(self._start())
        self.loop.run_forever()

    async def _start(self) -> None:
        self.server = ModbusTcpServer(self.device, address=("127.0.0.1", self.port))
        await self.server.listen()
        self.port = self.server.transport.sockets[0].getsockname()[1]
        self.ready.set()

    def __enter__(self) -> "Server":
        self.thread.start()
        assert self.ready.wait(HANG_S)
        return self

    def __exit__(self, *_: object) -> None:
        asyncio.run_coroutine_threadsafe(self.server.shutdown(), self.loop).result(HANG_S)
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join(HANG_S)
        self.loop.close()
