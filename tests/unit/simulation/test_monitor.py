"""The page of a controller on this machine's loopback, and its end by Ctrl-C."""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any
from urllib.request import urlopen

import pytest

from beamcam.commands.monitor import Reader
from beamcam.simulation.trace import State, TraceRow
from tests.conftest import ROOT
from tests.runs import call, interrupted, wait_until
from tests.unit.checks.programs import BEAM

pytest.importorskip("pymodbus", reason="the extra beamcam[modbus] is not installed")

from beamcam.simulation.modbus import send
from tests.unit.simulation.server import Server

LOOPBACK = "127.0.0.1"


def row(place: float) -> TraceRow:
    return TraceRow(0.0, 7, (place, *[1.5] * 8), State(2, 22.0, 1))


def free_port() -> int:
    with Server(1) as free:
        return free.port


def shown(page: int) -> dict[str, Any]:
    with urlopen(f"http://{LOOPBACK}:{page}/axes") as answer:
        return dict(json.load(answer))


def test_the_page_follows_a_controller_until_ctrl_c() -> None:
    page = free_port()
    with Server(15) as controller:
        send([row(1000.0)], BEAM.modbus, LOOPBACK, controller.port)
        words = [f"{LOOPBACK}:{controller.port}", "--page", f"{LOOPBACK}:{page}", "--every", "0.02"]
        process = subprocess.Popen(
            [sys.executable, "-m", "beamcam", "monitor", *words], stderr=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True,
        )  # fmt: skip
        try:
            assert process.stderr is not None
            assert f"http://{LOOPBACK}:{page}/" in process.stderr.readline()
            with urlopen(f"http://{LOOPBACK}:{page}/") as answer:
                html = answer.read().decode()
            assert html.count('id="axis-') == 9
            assert "http://" not in html.replace("http://www.w3.org", "")
            assert shown(page)["positions"][:2] == [1000.0, 1.5]
            send([row(1234.0)], BEAM.modbus, LOOPBACK, controller.port)
            wait_until(lambda: shown(page)["positions"][0] == 1234.0, process)
            said = shown(page)
            assert (said["line"], said["state"]["spindle"], said["fault"]) == (7, 2, "")
            interrupted(process)
        finally:
            process.kill()
            process.communicate()


def test_no_controller_and_a_page_that_is_taken() -> None:
    done = call("monitor", f"{LOOPBACK}:{free_port()}", status=1)
    assert "error monitor-controller: found no connection" in done.stderr
    with Server(15) as controller:
        at = f"{LOOPBACK}:{controller.port}"
        done = call("monitor", at, "--page", at)
    assert done.exit_code == 1
    assert "error simulate-port: found" in done.stderr


def test_a_lost_connection_is_told_and_tried_again() -> None:
    with Server(15) as controller:
        port = controller.port
        send([row(1000.0)], BEAM.modbus, LOOPBACK, port)
        reader = Reader((LOOPBACK, port), BEAM, 9, 0.02)
        reader.read_first()
        threading.Thread(target=reader.run, daemon=True).start()

    def said(wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        found: list[dict[str, Any]] = []

        def has_come() -> bool:
            found.append(dict(json.loads(reader.as_json())))
            return wanted(found[-1])

        wait_until(has_come)
        return found[-1]

    lost = said(lambda last: bool(last["fault"]))
    assert "expected a controller that shows its axes" in lost["fault"]
    assert lost["positions"][0] == 1000.0
    with Server(15, port):
        send([row(1234.0)], BEAM.modbus, LOOPBACK, port)
        assert said(lambda last: not last["fault"])["reads"] > lost["reads"]
        said(lambda last: last["positions"][0] == 1234.0)
