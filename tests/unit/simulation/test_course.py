"""The axes over time: continuous, within their limits, and where the program says."""

import csv
import io
import json
import re
from itertools import pairwise
from math import inf, sqrt
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import MachineError
from beamcam.machine import Machine, load
from beamcam.model.cell_motion import ramp
from beamcam.pipeline import post, read_file
from beamcam.simulation.cell_trace import MotionSegment, bar_trace
from beamcam.simulation.program import simulate_program
from beamcam.simulation.text import csv_text, json_data
from beamcam.simulation.trace import trace_rows
from tests.conftest import SAMPLES
from tests.runs import call
from tests.unit.checks.programs import ANNEX, BEAM, PART, PROGRAM
from tests.unit.simulation.programs import course_of

AXES = {a.name: i for i, a in enumerate(BEAM.axes)}


@pytest.fixture(scope="module")
def course() -> tuple[MotionSegment, ...]:
    return course_of(PROGRAM, BEAM, PART.profile)


def test_the_axes_stand_in_the_order_of_the_registers() -> None:
    assert [a.name for a in BEAM.axes] == [
        "stop", "left drill vertical", "left drill horizontal", "top drill horizontal",
        "top drill vertical", "right drill vertical", "right drill horizontal", "saw rotation",
        "saw vertical",
    ]  # fmt: skip


def test_stretches_follow_one_another_without_a_jump(course: tuple[MotionSegment, ...]) -> None:
    for a, b in pairwise(course):
        assert b.begin_s == pytest.approx(a.begin_s + a.duration_s)
        assert b.start == a.end
    for part in course:
        assert part.at(part.begin_s) == pytest.approx(part.start)
        assert part.at(part.begin_s + part.duration_s) == pytest.approx(part.end)


def test_the_axes_are_where_the_program_says(course: tuple[MotionSegment, ...]) -> None:
    by_line = {part.line: part for part in course}
    bottom = by_line[12].end
    assert bottom[AXES["stop"]] == 1098.56
    assert bottom[AXES["top drill horizontal"]] == 20
    assert bottom[AXES["top drill vertical"]] == 61.409
    assert bottom[AXES["left drill horizontal"]] == -5
    pair = by_line[20].end
    assert pair[AXES["left drill horizontal"]] == pair[AXES["right drill horizontal"]] == 14.706
    assert pair[AXES["left drill vertical"]] == pair[AXES["right drill vertical"]] == 158.6
    assert pair[AXES["top drill vertical"]] == -5


def test_what_is_switched_on(course: tuple[MotionSegment, ...]) -> None:
    drilling = next(p for p in course if p.line == 12).state
    assert (drilling.spindle, drilling.diameter, drilling.turning) == (2, 22.0, 1)
    assert drilling.coolant
    sawing = [p for p in course if p.line == 6]
    assert [p.state.sawing for p in sawing] == [False, True, True, False]
    assert (
        max(p.end[AXES["saw vertical"]] for p in sawing) == 110
    )  # its width, and clearance on both sides
    assert course[-1].state.turning == 0


def test_a_feed_takes_its_time(course: tuple[MotionSegment, ...]) -> None:
    (stroke,) = (p for p in course if p.line == 12)
    way, feed = 61.409 - 42.2, 90.42 / 60
    assert stroke.duration_s == pytest.approx(way / feed, rel=0.01)
    assert stroke.duration_s >= way / feed


@pytest.mark.parametrize("step", [0.01, 0.013])
def test_no_axis_beyond_its_speed(course: tuple[MotionSegment, ...], step: float) -> None:
    sampled = list(trace_rows(bar_trace(course, BEAM), step))
    for a, b in pairwise(sampled):
        assert b.time_s - a.time_s == pytest.approx(step)
        for axis, x, y in zip(BEAM.axes, a.positions, b.positions, strict=True):
            assert abs(y - x) <= axis.speed * step + 1e-9
    for a, b, c in zip(sampled, sampled[1:], sampled[2:], strict=False):
        for axis, x, y, z in zip(BEAM.axes, a.positions, b.positions, c.positions, strict=True):
            # Between two stretches an axis may slow down and speed up within one step.
            assert abs(x - 2 * y + z) <= 2 * axis.acceleration * step * step + 1e-9
    assert sampled[-1].positions == pytest.approx(course[-1].end)


limits = st.floats(0.01, 50)
jerks = st.one_of(st.just(inf), st.floats(0.01, 500))


@given(limits, limits, jerks)
def test_a_ramp_is_whole_symmetrical_and_within_its_limits(v: float, a: float, j: float) -> None:
    done = ramp(v, a, j)
    takes = done.duration_s
    assert done.share(0.0) == 0.0
    assert done.share(takes) == done.share(takes + 1) == 1.0
    step = takes / 2000
    shares = np.array([done.share(k * step) for k in range(2001)])
    assert shares + shares[::-1] == pytest.approx(1.0)
    speeds = np.diff(shares) / step
    assert speeds.min() >= -1e-9
    assert speeds.max() <= v * (1 + 1e-6)
    gains = np.diff(speeds) / step
    assert np.abs(gains).max() <= a * (1 + 1e-5)
    # Third differences of rounded numbers: 1e-16 over the step to the third.
    assert np.abs(np.diff(gains) / step).max() <= j * (1 + 1e-4) + 1e-14 / step**3


@given(limits, limits)
def test_without_a_jerk_it_is_a_trapezoid(v: float, a: float) -> None:
    takes = 2 * sqrt(1 / a) if v * v >= a else 1 / v + v / a
    assert ramp(v, a).duration_s == pytest.approx(takes)
    assert ramp(v, a, 1e9).duration_s == pytest.approx(takes, abs=1e-3)


@pytest.mark.parametrize(
    ("limits_of", "takes"),
    [
        ((1.0, 1.0, inf), 2.0),  # a triangle that just reaches its speed
        ((0.5, 1.0, inf), 2.5),
        ((10.0, 10.0, 32.0), 4 * 0.25),  # jerk alone: 2 j t^3 = 1 at t = 0.25
        ((1.0, 2.0, 4.0), 2.0),  # a/j = v/a = 0.5 s: up in 1 s over half of the way
        ((0.5, 2.0, 8.0), 2.5),  # speed before acceleration: sqrt(v/j) = 0.25 s, then 1.5 s of 0.5
    ],
)
def test_how_long_a_way_takes(limits_of: tuple[float, float, float], takes: float) -> None:
    assert ramp(*limits_of).duration_s == pytest.approx(takes)


def test_an_axis_with_a_jerk_takes_longer(course: tuple[MotionSegment, ...]) -> None:
    axes = tuple(replace(axis, jerk=2 * axis.acceleration) for axis in BEAM.axes)
    gentle = replace(BEAM, axes=axes)
    slow = course_of(PROGRAM, gentle, PART.profile)
    assert [part.end for part in slow] == [part.end for part in course]
    assert all(a.duration_s >= b.duration_s for a, b in zip(slow, course, strict=True))
    moved = next(k for k, part in enumerate(course) if part.ramp.speed > 0.0)
    assert slow[moved].duration_s > course[moved].duration_s


def test_the_csv_has_a_row_for_every_event(course: tuple[MotionSegment, ...]) -> None:
    trace = bar_trace(course, BEAM)
    lines = csv_text(trace, BEAM).splitlines()
    assert lines[0] == (
        "time_s,stop,left drill vertical,left drill horizontal,top drill horizontal,"
        "top drill vertical,right drill vertical,right drill horizontal,saw rotation,saw vertical,"
        "spindle,diameter,turning,coolant,sawing,line"
    )
    assert lines[1] == "0.0000,0.000,0.000,-5.000,0.000,-5.000,0.000,-5.000,0.000,0.000,0,0,0,0,0,0"
    assert len(lines) == len(trace.line) + 2
    seen = {int(line.rsplit(",", 1)[1]) for line in lines[1:]}
    assert seen == {0, *(part.line for part in course if part.duration_s)}
    assert any(",2,22,1,1,0," in line for line in lines)
    assert csv_text(trace, BEAM, 1.0).splitlines()[2].startswith("1.0000,")
    assert "-0.000" not in "".join(lines)


def test_a_machine_without_axes() -> None:
    from msgspec.structs import replace

    bare = replace(ANNEX, axes=())
    with pytest.raises(MachineError, match="machine-missing: found no key 'axes'"):
        course_of(PROGRAM, bare)


@pytest.mark.parametrize("feed", ["F-41.667", "F0"])
def test_a_blade_without_a_feed_of_its_own_takes_the_saws(feed: str) -> None:
    """The read-back refuses such a cut; a trace of it is finite all the same."""
    sound = PROGRAM
    cut = next(line for line in sound.splitlines() if " M42 " in f" {line} ")
    changed = sound.replace(cut, f"{cut.partition(' F')[0]} {feed}")
    own, other = (bar_trace(course_of(p, BEAM, PART.profile), BEAM) for p in (sound, changed))
    assert np.isfinite(other.time_s).all()
    assert other.time_s[-1] == pytest.approx(own.time_s[-1], rel=0.2)


# --- traces as files ------------------------------------------------------------------------------


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
    done = call(*words, status=0)
    (said,) = [row for row in done.stderr.splitlines() if "simulate-" in row]
    assert re.search(rf":{line}: warning simulate-\w+: at [\d.]+ s {found}$", said), said
