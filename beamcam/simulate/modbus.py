"""A client of Modbus TCP: a trace sent to a server, or what a controller shows.

Which register has what: `registers`. Needs pymodbus: `pip install beamcam[modbus]`.
"""

import logging
import time
from collections.abc import Callable, Iterable
from functools import partial
from types import TracebackType
from typing import Any, Self

from beamcam.errors import Rule, Source, VerifyError
from beamcam.machine.modbus import Modbus
from beamcam.simulate import rules
from beamcam.simulate.registers import Shown, register_count, registers, shown
from beamcam.simulate.trace import TraceRow

TIMEOUT_S = 0.8  #: that an answer may take, so that Ctrl-C ends a command within a second
MAX_READ = 125  #: registers in one answer, by the standard


class Client:
    """A connection to a Modbus TCP server. Raises VerifyError with its rule for whatever fails."""

    def __init__(self, host: str, port: int, rule: Rule = rules.MODBUS) -> None:
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

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._client.close()

    def write(self, address: int, words: list[int]) -> None:
        """Write holding registers."""
        self._asked(lambda: self._client.write_registers(address, words))

    def read(self, address: int, count: int) -> list[int]:
        """Read holding registers."""
        found: list[int] = []
        while len(found) < count:
            at, many = address + len(found), min(MAX_READ, count - len(found))
            answer = self._asked(partial(self._client.read_holding_registers, at, count=many))
            found += answer.registers
        return found

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
    rows: Iterable[TraceRow],
    modbus: Modbus,
    host: str,
    port: int,
    pace: float = 0.0,
    sleep: Callable[[float], None] = time.sleep,
) -> int:
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
