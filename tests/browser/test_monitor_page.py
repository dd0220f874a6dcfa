"""The page of `beamcam monitor` in a browser: axes of a controller on the loopback, moving."""

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest

from beamcam.machine import Machine, load
from beamcam.pipeline import read_file
from beamcam.simulation.modbus import register_count
from beamcam.simulation.program import simulate_program
from beamcam.simulation.trace import State, TraceRow, trace_rows
from tests.browser.conftest import Browser
from tests.conftest import ROOT
from tests.runs import call, wait_until

pytest.importorskip("pymodbus", reason="the extra beamcam[modbus] is not installed")

from beamcam.simulation.modbus import send
from tests.unit.simulation.server import Server

HOST = "127.0.0.1"
DSTV = ROOT / "samples" / "dstv"


@contextmanager
def monitored(machine: Machine, axes: int, *words: str) -> Iterator[tuple[Server, str]]:
    """A controller, and the address of the page that shows it."""
    with Server(1) as free:
        port = free.port
    with Server(register_count(machine.modbus, axes)) as controller:
        send([TraceRow(0.0, 0, (0.0,) * axes, State())], machine.modbus, HOST, controller.port)
        command = ["monitor", f"{HOST}:{controller.port}", "--page", f"{HOST}:{port}", *words]
        process = subprocess.Popen(
            [sys.executable, "-m", "beamcam", *command, "--every", "0.02"],
            stderr=subprocess.PIPE, env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True,
        )  # fmt: skip
        try:
            assert process.stderr is not None
            assert "Ctrl-C ends it" in process.stderr.readline()
            yield controller, f"http://{HOST}:{port}/"
        finally:
            process.kill()
            process.communicate()


def positions(browser: Browser) -> list[float]:
    """What the table of the axes shows."""
    rows = browser.run(
        "return [...document.querySelectorAll('.axes data')].map((e) => Number(e.value))"
    )
    return [float(v) for v in rows]


def wait_for(browser: Browser, wanted: Sequence[float], slack: float) -> None:
    """Until the page shows positions."""
    wait_until(lambda: positions(browser) == pytest.approx(wanted, abs=slack))


def drawing(browser: Browser, view: str) -> str:
    """A view as an image."""
    return str(browser.run(
        "return document.querySelector(`canvas[data-view=${arguments[0]}]`).toDataURL()", view
    ))  # fmt: skip


def test_a_cell_is_drawn_while_it_moves(browser: Browser) -> None:
    machine = load("beamline")
    rows = [
        TraceRow(0.03 * k, 5 + k, (1000.0 + 10 * k, *(a + k / 2 for a in range(8))),
                 State(2, 18.0, 1, True))
        for k in range(9)
    ]  # fmt: skip
    with monitored(machine, 9, "--part", str(DSTV / "beam.nc1")) as (controller, page):
        browser.open(page)
        on_page = iter(rows)

        def until_shown(_: float) -> None:
            wait_for(browser, next(on_page).positions, 1e-9)

        assert send(rows, machine.modbus, HOST, controller.port, 1.0, until_shown) == len(rows)
        wait_for(browser, rows[-1].positions, 1e-9)
        assert browser.text("state") == "spindle 2, tool 18 mm, turning, coolant"
        assert browser.text("line") == f"block {rows[-1].line}"
        assert browser.run("return Sheet.model.section.height") == 300.0
        browser.run("const u = document.getElementById('unit'); u.value = 'inch';"
                    "u.dispatchEvent(new Event('change'))")  # fmt: skip
        assert browser.text("axis-0") == f"{rows[-1].positions[0] / 25.4:.4f}"
        assert positions(browser)[0] == rows[-1].positions[0]
        drawn = {drawing(browser, view) for view in ("above", "side", "space")}
        assert len(drawn) == 3
        assert min(map(len, drawn)) > 3000
        assert browser.complaints == []
        asked = browser.requests
        assert page in asked
        assert set(asked) == {page, f"{page}axes"}


def test_a_table_has_its_program_under_the_head(browser: Browser, tmp_path: Path) -> None:
    program = tmp_path / "gusset.ngc"
    call("post", DSTV / "gusset.nc1", "-o", program, status=0)
    machine = load("plate-linuxcnc")
    parts = read_file(str(DSTV / "gusset.nc1")).parts
    trace = simulate_program(program.read_bytes(), machine, parts=parts).trace
    rows = [row for row in trace_rows(trace, 1.0) if row.state.process]
    with monitored(machine, 2, "--program", str(program)) as (controller, page):
        browser.open(page, 390)
        for row in rows[5:30:8]:
            send([row], machine.modbus, HOST, controller.port)
            wait_for(browser, row.positions, 1e-3)
            assert browser.text("state") == "tool on"
            now = browser.run("return document.querySelector('#listing .now').dataset.line")
            assert now == str(row.line)
        low, high = trace.positions.min(axis=0), trace.positions.max(axis=0)
        box = browser.run("return Sheet.model.box")
        assert [edge[1] for edge in box] == pytest.approx(high, abs=1e-3)
        assert all(edge[0] >= at for edge, at in zip(box, low, strict=True))
        before = drawing(browser, "table")
        browser.click("#whole")
        assert drawing(browser, "table") != before
        assert browser.run("return document.documentElement.scrollWidth") <= 390
        assert browser.complaints == []
        assert set(browser.requests) == {page, f"{page}axes"}
