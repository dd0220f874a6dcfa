"""Registers of a controller, on a real Modbus TCP server on this machine's loopback."""

import os
import subprocess
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import Source, VerifyError
from beamcam.machine.machine import Modbus
from beamcam.simulation.cell_trace import bar_trace
from beamcam.simulation.modbus import check_range, register_count, registers, shown
from beamcam.simulation.trace import State, Trace, TraceAxis, TraceBuilder, TraceRow, trace_rows
from beamcam.system import EndRequest
from tests.conftest import ROOT
from tests.runs import HANG_S, call, interrupted, wait_until
from tests.unit.checks.programs import BEAM, PART, PROGRAM
from tests.unit.simulation.programs import course_of

pymodbus = pytest.importorskip("pymodbus", reason="the extra beamcam[modbus] is not installed")

from pymodbus.client import ModbusTcpClient  # noqa: E402

from beamcam.simulation.modbus import Client, axes_shown, send  # noqa: E402
from tests.unit.simulation.server import Server  # noqa: E402

AXES = len(BEAM.axes)
SIZE = AXES + 6


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with Server(2 * SIZE) as running:
        yield running


def course() -> list[TraceRow]:
    return list(trace_rows(bar_trace(course_of(PROGRAM, BEAM, PART.profile), BEAM)))


MODBUS = st.builds(
    Modbus,
    values=st.sampled_from(["int16", "int32", "float"]),
    scale=st.sampled_from([0.01, 0.1, 1.0]),
    word_order=st.sampled_from(["high-first", "low-first"]),
    states=st.booleans(),
)
STATES = st.builds(
    State, st.integers(0, 13), st.integers(0, 6000).map(lambda d: d / 100), st.integers(-1, 1),
    st.booleans(), st.booleans(),
)  # fmt: skip


@given(MODBUS, st.lists(st.floats(-300.0, 300.0), min_size=1, max_size=9), STATES,
       st.integers(0, 65535))  # fmt: skip
def test_registers_tell_what_was_shown(
    modbus: Modbus, at: list[float], state: State, line: int
) -> None:
    words = registers(TraceRow(0.0, line, tuple(at), state), modbus)
    assert len(words) == register_count(modbus, len(at))
    assert all(0 <= word <= 0xFFFF for word in words)
    found = shown(words, modbus, len(at))
    slack = 1e-4 if modbus.values == "float" else modbus.scale / 2 + 1e-9
    assert found.positions == pytest.approx(at, abs=slack)
    if modbus.states:
        assert (found.state, found.line) == (state, line)


def test_output_k_is_axis_k() -> None:
    row = TraceRow(1.0, 70000, tuple(float(k) for k in range(-1, 8)), State(13, 17.46, -1, True))
    assert registers(row, Modbus()) == [65535, *range(8), 13, 1746, 65535, 1, 0, 70000 & 0xFFFF]
    assert registers(row, BEAM.modbus)[:3] == [65535, 0, 10]


def test_two_registers_in_the_order_that_the_file_says() -> None:
    row = TraceRow(1.0, 1, (1.0, -2.5), State())
    as_floats = Modbus(values="float", states=False)
    assert registers(row, as_floats) == [0x3F80, 0, 0xC020, 0]
    assert registers(row, replace(as_floats, word_order="low-first")) == [0, 0x3F80, 0, 0xC020]
    counts = Modbus(values="int32", scale=0.001, states=False)
    assert registers(row, counts) == [0, 1000, 0xFFFF, 0x10000 - 2500]


def test_a_position_beyond_its_register() -> None:
    builder = TraceBuilder([TraceAxis("X")], [0.0])
    builder.add([1.0], [[-4000.0]], (1.0, 1.0), 1, State())
    trace: Trace = builder.trace()
    with pytest.raises(VerifyError) as caught:
        check_range(trace, Modbus(scale=0.1), Source("m.toml"))
    assert str(caught.value) == (
        "m.toml: error simulate-register: found X at -4000, beyond its register; "
        "expected at most 3276.7 at the scale 0.1"
    )
    for fits in (Modbus(), Modbus(values="int32", scale=0.1), Modbus(values="float")):
        check_range(trace, fits, Source("m.toml"))


def read_back(port: int, count: int = SIZE) -> list[int]:
    with Client("127.0.0.1", port) as client:
        return client.read(0, count)


def test_every_row_reaches_the_server(server: Server) -> None:
    trace = course()
    assert send(trace, BEAM.modbus, "127.0.0.1", server.port) == len(trace)
    assert read_back(server.port) == registers(trace[-1], BEAM.modbus)


@pytest.mark.parametrize("modbus", [Modbus(values="float"), Modbus(values="int32", scale=0.001)])
def test_each_row_alone_reaches_the_server(server: Server, modbus: Modbus) -> None:
    for row in course()[::40]:
        assert send([row], modbus, "127.0.0.1", server.port) == 1
        with Client("127.0.0.1", server.port) as client:
            found = axes_shown(client, modbus, AXES)
        assert found.positions == pytest.approx(row.positions, abs=1e-3)
        assert (found.state, found.line) == (row.state, row.line)


def test_the_pace_is_kept_by_sleeping(server: Server) -> None:
    slept: list[float] = []
    trace = course()
    send(trace, BEAM.modbus, "127.0.0.1", server.port, 0.5, slept.append)
    assert sum(slept) == pytest.approx(trace[-1].time_s / 2)


def test_no_server() -> None:
    with Server(SIZE) as gone:
        port = gone.port
    with pytest.raises(VerifyError) as caught:
        send(course(), BEAM.modbus, "127.0.0.1", port)
    assert str(caught.value) == (
        f"127.0.0.1:{port}: error verify-modbus: found no connection; "
        "expected a Modbus TCP server that takes the registers"
    )


def test_a_server_with_too_few_registers() -> None:
    with (
        Server(10) as small,
        pytest.raises(VerifyError, match="error verify-modbus: found the answer"),
    ):
        send(course(), BEAM.modbus, "127.0.0.1", small.port)


def test_the_command_sends(server: Server, tmp_path: Path) -> None:
    path = tmp_path / "a.gcode"
    path.write_text(PROGRAM, "utf-8")
    address = f"127.0.0.1:{server.port}"
    done = call("simulate", path, "--modbus", address, "--every", "1s", status=0)
    assert f"rows sent to {address}" in done.stderr
    assert read_back(server.port)[AXES] == 13


@contextmanager
def served(rows: Iterable[TraceRow], modbus: Modbus) -> Iterator[int]:
    """The controller in a thread: its port. It ends when it is asked to."""
    from beamcam.simulation.modbus import serve

    ports: list[int] = []
    ready, asked = threading.Event(), EndRequest()

    def tell(_host: str, port: int) -> None:
        ports.append(port)
        ready.set()

    thread = threading.Thread(
        target=serve, args=(rows, modbus, "127.0.0.1", 0, 1.0, tell, True, asked), daemon=True
    )
    thread.start()
    assert ready.wait(HANG_S)
    try:
        yield ports[0]
    finally:
        asked.hear()
        thread.join(HANG_S)
        assert not thread.is_alive()


def test_the_controller_shows_its_axes_while_they_move() -> None:
    def row(k: int) -> TraceRow:
        return TraceRow(k * 0.02, k, (float(k), -k / 2), State(2))

    modbus = Modbus(scale=0.5, first=3)
    seen: list[int] = []
    with served(map(row, range(30_000)), modbus) as port:  # ten minutes
        client = ModbusTcpClient("127.0.0.1", port=port)
        assert client.connect()

        def has_moved() -> bool:
            answer = client.read_input_registers(3, count=8)
            seen.append(shown(answer.registers, modbus, 2).line)
            assert answer.registers == registers(row(seen[-1]), modbus)
            return len(set(seen)) >= 3

        wait_until(has_moved)
        assert client.write_registers(3, [9]).isError()  # nobody moves it from outside
        client.close()
    assert seen == sorted(seen)


@pytest.mark.parametrize("order", ["high-first", "low-first"])
def test_another_library_reads_the_floats_of_the_controller(order: str) -> None:
    """The words of a pair as pymodbus takes them: its "little" begins with the low word."""
    row = TraceRow(0.0, 3, tuple(k + 0.1 for k in range(9)), State())
    modbus = Modbus(values="float", word_order=order, first=10)  # type: ignore[arg-type]
    with served([row], modbus) as port:
        client = ModbusTcpClient("127.0.0.1", port=port)
        assert client.connect()
        for axis, place in enumerate(row.positions):
            answer = client.read_holding_registers(10 + 2 * axis, count=2)
            words = "big" if order == "high-first" else "little"
            found = client.convert_from_registers(answer.registers, client.DATATYPE.FLOAT32, words)
            assert found == pytest.approx(place, abs=1e-6)
        client.close()


def test_the_controller_holds_its_end_until_ctrl_c(tmp_path: Path) -> None:
    (tmp_path / "a.gcode").write_text(PROGRAM, "utf-8")
    with Server(1) as free:
        port = free.port
    words = ["simulate", "a.gcode", "--every", "1s", "--pace", "0", "--serve", f"127.0.0.1:{port}"]
    process = subprocess.Popen(
        [sys.executable, "-m", "beamcam", *words], cwd=tmp_path, stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True,
    )  # fmt: skip
    try:
        assert process.stderr is not None
        while f"at 127.0.0.1:{port}; Ctrl-C ends it" not in (line := process.stderr.readline()):
            assert line, "it ended"
        end = registers(course()[-1], BEAM.modbus)[AXES:]
        wait_until(lambda: read_back(port)[AXES:] == end, process)
        taken = call(words[0], tmp_path / words[1], *words[2:], status=1)
        assert "error simulate-port: found" in taken.stderr
        interrupted(process)
    finally:
        process.kill()
        process.communicate()
