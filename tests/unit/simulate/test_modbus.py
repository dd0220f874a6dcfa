"""A trace on a real Modbus TCP server on this machine's loopback."""

import asyncio
import struct
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from beamcam.cli import main
from beamcam.errors import VerifyError
from beamcam.simulate.course import Row, State, rows
from beamcam.simulate.modbus import registers, send
from tests.unit.simulate.programs import course_of
from tests.unit.verify.programs import BEAM, PART, PROGRAM

pymodbus = pytest.importorskip("pymodbus", reason="the extra beamcam[modbus] is not installed")

from pymodbus.client import ModbusTcpClient  # noqa: E402
from pymodbus.datastore import (  # noqa: E402
    ModbusSequentialDataBlock,
    ModbusServerContext,
)
from pymodbus.server import ModbusTcpServer  # noqa: E402

AXES = len(BEAM.axes)
SIZE = 2 * AXES + 6


class Server:
    """A Modbus TCP server in a thread of its own, on a port that the system chooses."""

    def __init__(self, size: int) -> None:
        from pymodbus.datastore import ModbusDeviceContext

        self.block = ModbusSequentialDataBlock(1, [0] * size)
        self.context = ModbusServerContext(ModbusDeviceContext(hr=self.block), single=True)
        self.loop = asyncio.new_event_loop()
        self.ready = threading.Event()
        self.port = 0
        self.thread = threading.Thread(target=self._serve, daemon=True)

    def _serve(self) -> None:
        asyncio.set_event_loop(self.loop)
        self.loop.run_until_complete(self._start())
        self.loop.run_forever()

    async def _start(self) -> None:
        self.server = ModbusTcpServer(self.context, address=("127.0.0.1", 0))
        await self.server.listen()
        self.port = self.server.transport.sockets[0].getsockname()[1]
        self.ready.set()

    def __enter__(self) -> "Server":
        self.thread.start()
        assert self.ready.wait(10)
        return self

    def __exit__(self, *_: object) -> None:
        asyncio.run_coroutine_threadsafe(self.server.shutdown(), self.loop).result(10)
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join(10)
        self.loop.close()


@pytest.fixture
def server() -> Iterator[Server]:
    with Server(SIZE) as running:
        yield running


def read_back(port: int) -> list[int]:
    client = ModbusTcpClient("127.0.0.1", port=port)
    assert client.connect()
    try:
        return list(client.read_holding_registers(0, count=SIZE).registers)
    finally:
        client.close()


def course() -> list[Row]:
    return list(rows(course_of(PROGRAM, BEAM, PART.profile)))


def test_the_registers_of_a_row() -> None:
    row = Row(1.0, 70000, (1098.56, -5.0), State(13, 17.46, -1, True, False))
    words = registers(row)
    assert struct.unpack(">2f", struct.pack(">4H", *words[:4])) == pytest.approx((1098.56, -5.0))
    assert words[4:] == [13, 1746, 65535, 1, 0, 70000 & 0xFFFF]


def test_every_row_reaches_the_server(server: Server) -> None:
    trace = course()
    assert send(trace, "127.0.0.1", server.port) == len(trace)
    assert read_back(server.port) == registers(trace[-1])


def test_each_row_alone_reaches_the_server(server: Server) -> None:
    for row in course()[::9]:
        assert send([row], "127.0.0.1", server.port) == 1
        words = read_back(server.port)
        positions = struct.unpack(f">{AXES}f", struct.pack(f">{2 * AXES}H", *words[: 2 * AXES]))
        assert positions == pytest.approx(row.positions, abs=1e-3)


def test_the_pace_is_kept_by_sleeping(server: Server) -> None:
    slept: list[float] = []
    trace = course()
    send(trace, "127.0.0.1", server.port, 0.5, slept.append)
    assert sum(slept) == pytest.approx(trace[-1].time_s / 2)


def test_no_server() -> None:
    with Server(SIZE) as gone:
        port = gone.port
    with pytest.raises(VerifyError) as caught:
        send(course(), "127.0.0.1", port)
    assert str(caught.value) == (
        f"127.0.0.1:{port}: error verify-modbus: found no connection; "
        "expected a Modbus TCP server that takes the registers"
    )


def test_a_server_with_too_few_registers() -> None:
    with (
        Server(10) as small,
        pytest.raises(VerifyError, match="error verify-modbus: found the answer"),
    ):
        send(course(), "127.0.0.1", small.port)


def test_the_command_sends(server: Server, tmp_path: Path) -> None:
    path = tmp_path / "a.gcode"
    path.write_text(PROGRAM, "utf-8")
    address = f"127.0.0.1:{server.port}"
    done = CliRunner().invoke(main, ["simulate", str(path), "--modbus", address, "--every", "1s"])
    assert done.exit_code == 0, done.stderr
    assert f"rows sent to {address}" in done.stderr
    assert read_back(server.port)[2 * AXES] == 13
