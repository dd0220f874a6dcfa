"""Traces of each kind of machine as CSV and as JSON, and what leaves a table is warned of."""

import csv
import io
import json
import re
from pathlib import Path

import msgspec
import pytest

from beamcam.machine import Machine, load
from beamcam.pipeline import post, read_file
from beamcam.simulation.program import simulate_program
from beamcam.simulation.text import csv_text, json_data
from tests.runs import call

SAMPLES = Path(__file__).resolve().parents[3] / "samples"
JOBS = [
    ("dstv/channel.nc1", "beamline"), ("dstv/channel.nc1", "beamline-pusher"),
    ("dstv/gusset.nc1", "plate-linuxcnc"), ("dstv/gusset.nc1", "plate-codesys"),
    ("json/curves.json", "laser-grbl"), ("json/shield-small.json", "laser-stepper"),
    ("json/shield.json", "table-simotion"),
    ("json/shield.json", "table-plcopen"),
]  # fmt: skip


def program_of(sample: str, machine: Machine) -> bytes:
    return b"".join(post(read_file(str(SAMPLES / sample)).parts, machine).pieces())


@pytest.mark.parametrize(("sample", "name"), JOBS)
@pytest.mark.parametrize("every", [None, 0.5])
def test_both_forms_say_the_same(sample: str, name: str, every: float | None) -> None:
    machine = load(name)
    trace = simulate_program(program_of(sample, machine), machine, style=machine.suffix).trace
    head, *lines = csv.reader(io.StringIO(csv_text(trace, machine, every)))
    data = json.loads(msgspec.json.encode(json_data(trace, machine, every, None, ())))
    assert data["columns"] == head
    assert [axis["name"] for axis in data["axes"]] == head[1 : 1 + len(trace.axes)]
    assert len(lines) == len(data["rows"]) > 10
    count = 1 + len(trace.axes)
    for line, row in zip(lines, data["rows"], strict=True):
        assert [float(cell) for cell in line[:count]] == pytest.approx(row[:count], abs=6e-5)
        assert int(line[-1]) == row[-1]
    assert float(lines[-1][0]) == pytest.approx(trace.duration_s, abs=every or 1e-4)
    assert data["duration_s"] == pytest.approx(trace.duration_s, abs=1e-6)


@pytest.mark.parametrize(("sample", "name", "found"), [
    ("dstv/gusset.nc1", "plate-linuxcnc", "found bridge at 3500.000 mm; expected 0 to 3000"),
    ("json/curves.json", "laser-grbl", "found bridge at 3500.000 mm; expected 0 to 800"),
])  # fmt: skip
def test_a_head_that_leaves_its_table_is_warned_of(
    tmp_path: Path, sample: str, name: str, found: str
) -> None:
    text = program_of(sample, load(name)).decode()
    *_, move = re.finditer(r"G0 X0 Y0", text)  # the way home
    path = tmp_path / f"job{load(name).suffix}"
    path.write_text(f"{text[: move.start()]}G0 X3500 Y0{text[move.end() :]}")
    line = text[: move.start()].count("\n") + 1
    words = ["simulate", str(path), "--machine", name, "-o", str(tmp_path / "t.csv")]
    done = call(*words)
    assert done.exit_code == 0, done.output
    (said,) = [row for row in done.stderr.splitlines() if "simulate-" in row]
    assert re.search(rf":{line}: warning simulate-\w+: at [\d.]+ s {found}$", said), said
