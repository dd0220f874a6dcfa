"""Traces of every kind of machine: the planned time, no jump, where the program says."""

import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.controllers.step_table import Stream, binary_rows
from beamcam.errors import VerifyError
from beamcam.machine import Machine, load
from beamcam.pipeline import Posted, post, read_file
from beamcam.simulation.cell_trace import bar_trace
from beamcam.simulation.program import simulate_program
from beamcam.simulation.trace import Trace, share_of, trace_rows
from tests.conftest import SAMPLES
from tests.unit.checks.programs import BEAM, PART, PROGRAM
from tests.unit.simulation.programs import course_of

TABLES = [
    ("dstv/gusset.nc1", "plate-codesys"),
    ("dstv/gusset.nc1", "plate-linuxcnc"),
    ("dstv/gusset.nc1", "plate-oxyfuel"),
    ("dstv/gusset.nc1", "plate-qtplasmac"),
    ("json/curves.json", "laser-grbl"),
    ("json/shield.json", "table-simotion"),
    ("json/shield.json", "table-plcopen"),
]
STEPS = "json/shield-small.json"


def posted(sample: str, machine: Machine, style: str | None = None) -> Posted:
    return post(read_file(str(SAMPLES / sample)).parts, machine, style=style)


def traced(made: Posted, machine: Machine, style: str = "") -> Trace:
    return simulate_program(b"".join(made.pieces()), machine, style=style).trace


def speeds(trace: Trace) -> tuple[np.ndarray, np.ndarray]:
    """Velocities of the axes at the beginning and at the end of each interval."""
    ways = np.diff(trace.positions, axis=0)
    rates = trace.slopes / np.diff(trace.time_s)[:, None]
    return ways * rates[:, :1], ways * rates[:, 1:]


@pytest.mark.parametrize(("sample", "name"), TABLES)
def test_a_table_takes_the_time_that_the_plan_tells(sample: str, name: str) -> None:
    machine = load(name)
    made = posted(sample, machine)
    trace = traced(made, machine)
    time = made.time(machine)
    # The emitter rounds coordinates and feeds.
    assert trace.duration_s == pytest.approx(sum(time.operations) + time.home_s, rel=2e-4)
    assert trace.positions[-1] == pytest.approx([0.0, 0.0])
    assert {state.process for state in trace.states} >= {"", "cut"}
    assert np.all(np.diff(trace.time_s) >= 0.0)
    assert np.all(trace.positions >= -1e-6)


@pytest.mark.parametrize(("sample", "name"), TABLES[:3])
def test_no_axis_is_faster_than_its_limit(sample: str, name: str) -> None:
    machine = load(name)
    trace = traced(posted(sample, machine), machine)
    limits = [axis.speed for axis in machine.axes]
    for found in speeds(trace):
        assert np.all(np.abs(found) <= np.array(limits) * (1 + 1e-6))


def test_a_table_stands_where_its_tool_is_switched() -> None:
    machine = load("plate-codesys")
    trace = traced(posted("dstv/gusset.nc1", machine), machine)
    before, after = speeds(trace)
    switched = np.flatnonzero(np.diff(trace.state)) + 1
    assert len(switched) >= 10
    assert np.abs(before[switched]) == pytest.approx(0.0, abs=1e-6)
    assert np.abs(after[switched - 1]) == pytest.approx(0.0, abs=1e-3)


def test_a_bar_s_trace_is_its_course() -> None:
    course = course_of(PROGRAM, BEAM, PART.profile)
    trace = bar_trace(course, BEAM)
    for part in course:
        times = part.begin_s + part.duration_s * np.linspace(0.05, 0.95, 7)
        if part.duration_s:
            wanted = [part.at(t) for t in times]
            assert trace.at(times) == pytest.approx(np.array(wanted), abs=1e-6)
    assert trace.axes[7].unit == "deg"


@pytest.mark.parametrize("form", [".steps", ".bin", ".h"])
def test_a_step_table_s_trace_keeps_near_to_each_row(form: str) -> None:
    machine = load("laser-stepper")
    made = posted(STEPS, machine, form)
    trace = traced(made, machine, form)
    assert machine.stepper is not None
    step = machine.stepper.step
    again = posted(STEPS, machine, ".bin")
    here, words = np.zeros(2), [0, 0]
    times, places = [], []
    for rows in binary_rows(Stream(again.pieces(), "x"), machine.stepper):
        for t, *both in zip(rows.time_us, rows.x, rows.y, strict=True):
            for axis in (0, 1):
                turn = (int(both[axis]) - words[axis]) % 4
                here[axis] += {0: 0, 1: step, 3: -step}[turn]
                words[axis] = int(both[axis])
            times.append(t / 1e6)
            places.append(here.copy())
    # A step of thinning, and up to one that the row itself jumps.
    assert np.max(np.abs(trace.at(times) - np.array(places))) <= 2 * step + 1e-9
    assert trace.duration_s == pytest.approx(times[-1])
    assert [s.process for s in trace.states] == ["", "cut"]


def test_a_velocity_table_runs_as_its_rows_say() -> None:
    machine = load("laser-stepper")
    trace = traced(posted(STEPS, machine, ".csv"), machine, ".csv")
    before, after = speeds(trace)
    assert before == pytest.approx(after)
    assert np.hypot(*before[1]) == pytest.approx(4.0, abs=1e-3)


def test_rows_come_by_knot_or_by_time() -> None:
    machine = load("plate-linuxcnc")
    trace = traced(posted("dstv/gusset.nc1", machine), machine)
    knots = list(trace_rows(trace))
    assert len(knots) == len(trace.line) + 1
    assert knots[0].line == 0
    assert all(a.time_s <= b.time_s for a, b in pairwise(knots))
    even = list(trace_rows(trace, 0.5))
    assert [row.time_s for row in even] == pytest.approx(np.arange(len(even)) * 0.5)
    assert even[-1].time_s >= trace.duration_s > even[-2].time_s
    assert even[-1].positions == pytest.approx(trace.positions[-1])
    with pytest.raises(ValueError, match="every_s"):
        next(trace_rows(trace, 0.0))


@pytest.mark.parametrize(("name", "style"), [("plate-codesys", ""), ("table-simotion", ""),
                                             ("laser-stepper", ".bin")])  # fmt: skip
def test_a_program_that_cannot_be_understood_is_refused(name: str, style: str) -> None:
    with pytest.raises(VerifyError):
        simulate_program("G01 X!", load(name), style=style)


def test_a_section_of_negative_width_has_no_time() -> None:
    machine = load("beamline")
    text = posted("dstv/channel.nc1", machine).text
    wrong = text.replace("M44 K75", "M44 K-75")
    assert wrong != text
    with pytest.raises(VerifyError) as refused:
        simulate_program(wrong, machine)
    assert refused.value.diagnostics[-1].code == "simulate-endless"


@pytest.mark.parametrize(("sample", "name"), TABLES[-2:])
@pytest.mark.parametrize("speed", ["0.0", "-2.0"])
def test_a_head_that_never_arrives_is_refused(sample: str, name: str, speed: str) -> None:
    machine = load(name)
    text = posted(sample, machine).text
    wrong = re.sub(r"(speed := (?:LREAL#)?)2\.0\)", rf"\g<1>{speed})", text, count=1)
    assert wrong != text
    with pytest.raises(VerifyError) as refused:
        simulate_program(wrong, machine)
    assert [one.code for one in refused.value.diagnostics] == ["st-speed"]


@given(
    st.floats(0.0, 3.0), st.floats(0.0, 3.0),
    st.lists(st.floats(0.0, 1.0), min_size=1, max_size=5),
)  # fmt: skip
def test_the_share_has_its_ends_and_slopes(a: float, b: float, at: list[float]) -> None:
    first, last = np.array(a), np.array(b)
    assert share_of(np.array([0.0, 1.0]), first, last) == pytest.approx([0.0, 1.0], abs=1e-12)
    h = 1e-6
    edge = share_of(np.array([h, 1.0 - h]), first, last)
    assert edge[0] / h == pytest.approx(a, abs=1e-4)
    assert (1.0 - edge[1]) / h == pytest.approx(b, abs=1e-4)
    assert share_of(np.array(at), np.array(1.0), np.array(1.0)) == pytest.approx(at)
