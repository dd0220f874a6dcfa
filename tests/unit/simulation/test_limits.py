"""Limits, reach and collisions of a run, and what an encoder reads of it."""

import json
from math import floor, hypot
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.cli import main
from beamcam.controllers.simotion.trial import trial
from beamcam.errors import MachineError
from beamcam.machine import load
from beamcam.machine.machine import MachineBox
from beamcam.machine.stations import Formula
from beamcam.simulation.cell_trace import bar_trace, cell_axes
from beamcam.simulation.encoder import Encoder, precision, stair_times
from beamcam.simulation.limits import run_warnings, strikes
from beamcam.simulation.program import simulate_program
from beamcam.simulation.text import table_rows
from beamcam.simulation.trace import State, Trace, TraceAxis, TraceBuilder
from tests.conftest import BEAM_CELL, SAMPLES
from tests.runs import call
from tests.unit.checks.programs import BEAM, PART, PROGRAM
from tests.unit.simulation.programs import course_of

SECTION = {"height": 200.0, "width": 100.0}


def moved(*places: tuple[float, ...], axes: tuple[TraceAxis, ...]) -> Trace:
    """A second of even motion to each place."""
    builder = TraceBuilder(axes, places[0])
    for line, place in enumerate(places[1:], 1):
        builder.add([1.0], [place], (1.0, 1.0), line, State())
    return builder.trace()


def box(name: str, low: tuple[float, ...], high: tuple[float, ...], **on: str) -> MachineBox:
    texts = [tuple(Formula(str(v)) for v in corner) for corner in (low, high)]
    return MachineBox(name, *texts, **on)  # type: ignore[arg-type]


def test_a_program_of_the_cell_keeps_within_it() -> None:
    trace = bar_trace(course_of(PROGRAM, BEAM, PART.profile), BEAM)
    assert run_warnings(trace, BEAM, SECTION, "a") == ()


def test_an_axis_beyond_its_limit_is_told_once_for_each_excursion() -> None:
    axes = (TraceAxis("X", "mm", 0.0, 10.0),)
    trace = moved((0.0,), (12.0,), (15.0,), (5.0,), (-1.0,), axes=axes)
    said = run_warnings(trace, replace(BEAM, bodies=()), {}, "a.gcode")
    assert [str(one) for one in said] == [
        "a.gcode:1: warning simulate-limit: at 1.00 s found X at 15.000 mm; expected 0 to 10",
        "a.gcode:4: warning simulate-limit: at 4.00 s found X at -1.000 mm; expected 0 to 10",
    ]
    (off,) = run_warnings(trace, replace(load("table-simotion"), bodies=()), {}, "a.st")[:1]
    assert off.code == "simulate-reach"


def test_a_section_that_the_saw_does_not_reach_across() -> None:
    trace = bar_trace(course_of(PROGRAM, BEAM, PART.profile), BEAM)
    said = run_warnings(trace, BEAM, {"height": 1100.0, "width": 100.0}, "a.gcode")
    reach = [one for one in said if one.code == "simulate-reach"]
    assert len(reach) == 2
    assert "found saw at 1100 x 100 mm; expected at most 1010 x 500 at 0.00 deg" in str(reach[0])


@given(st.floats(-40.0, 40.0), st.floats(-170.0, 170.0))
def test_bodies_strike_where_a_polygon_says_so(x: float, turn: float) -> None:
    from shapely import affinity
    from shapely.geometry import box as rectangle

    bodies = (
        box("blade", (-2, -30, 0), (2, 30, 10), turn="A"), box("stop", (0, -5, 5), (10, 5, 20)),
    )  # fmt: skip
    bodies = (bodies[0], replace(bodies[1], x="X"))
    axes = (TraceAxis("X"), TraceAxis("A", "deg"))
    trace = moved((x, turn), (x, turn), axes=axes)
    blade = affinity.rotate(rectangle(-2, -30, 2, 30), turn, origin=(0, 0))
    stop = rectangle(x, -5, x + 10, 5)
    area = blade.intersection(stop).area
    found = strikes(trace, replace(BEAM, bodies=bodies), SECTION)
    if area > 1e-6 or area == 0.0:
        assert bool(found) == (area > 0.0)


def test_a_strike_has_its_time_its_block_and_its_depth() -> None:
    bodies = (box("head", (0, 0, 0), (10, 10, 10), x="X"), box("clamp", (50, 0, 0), (60, 10, 10)))
    trace = moved((0.0,), (20.0,), (45.0,), (0.0,), axes=(TraceAxis("X"),))
    (said,) = run_warnings(trace, replace(BEAM, bodies=bodies), SECTION, "a.gcode")
    assert str(said) == (
        "a.gcode:2: warning simulate-collision: at 1.84 s found head and clamp overlapping "
        "by 5.0 mm, until 2.09 s; expected them apart"
    )
    assert strikes(trace, replace(BEAM, bodies=()), SECTION) == ()


@pytest.mark.parametrize(
    ("name", "spindle", "left", "right", "meet"),
    [
        ("beamline-annex", 13, 100.0, 100.0, True),  # each to the middle of 200
        ("beamline-annex", 13, 99.9, 100.0, False),
        ("beamline", 13, 100.0, 100.0, True),
        ("beamline", 13, 60.0, 140.0, True),  # beyond the middle from one side
        ("beamline", 13, 25.0, 25.0, False),  # through two flanges
        ("beamline", 1, 100.0, 100.0, False),  # not at once: the right one has been left there
    ],
)
def test_tips_that_meet_in_the_middle(
    name: str, spindle: int, left: float, right: float, meet: bool
) -> None:
    machine = replace(load(name), bodies=())
    axes = cell_axes(machine)
    columns = [
        next(k for k, axis in enumerate(machine.axes) if axis.name == f"{side} drill horizontal")
        for side in ("left", "right")
    ]
    builder = TraceBuilder(axes, [axis.park for axis in machine.axes])
    for line, depths in enumerate(((0.0, 0.0), (left, right), (0.0, 0.0), (left, right)), 1):
        place = [axis.park for axis in machine.axes]
        for column, depth in zip(columns, depths, strict=True):
            place[column] = depth
        builder.add([1.0], [place], (1.0, 1.0), line, State(spindle=spindle))
    said = run_warnings(builder.trace(), machine, SECTION, "a.gcode")
    expected = [
        f"a.gcode:{line}: warning simulate-tips: at {line}.00 s found the tips of left drill "
        f"horizontal and right drill horizontal {left:g} and {right:g} mm deep from faces 200 mm "
        "apart; expected them not to meet"
        for line in (2, 4)
    ]
    assert [str(one) for one in said] == (expected if meet else [])


@pytest.mark.third_party
def test_the_annex_drills_to_the_middle_of_its_section() -> None:
    """Y190 of 380 from both sides, four times, in its blocks 133, 141, 157 and 181."""
    machine = load("beamline-annex")
    text = (BEAM_CELL / "annex-a.gcode").read_text()
    done = simulate_program(text, machine)
    said = run_warnings(done.trace, machine, done.section, "annex")
    tips = [one for one in said if one.code == "simulate-tips"]
    blocks = [text.splitlines()[(one.source.line or 0) - 1].split()[0] for one in tips]
    assert blocks == ["N134", "N142", "N158", "N182"]
    assert all("190 and 190 mm deep from faces 380 mm apart" in one.message for one in tips)


@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("bodies.0.x", 'bodies = [{ name = "a", min = [0,0,0], max = [1,1,1], x = "none" }]'),
        ("bodies.0.min", 'bodies = [{ name = "a", min = ["depth",0,0], max = [1,1,1] }]'),
        ("bodies.1.name", "bodies = [" + '{ name = "a", min = [0,0,0], max = [1,1,1] },' * 2 + "]"),
        ("modbus.scales", "modbus = { scales = [1, 2] }"),
        ("modbus.first", "modbus = { first = 65530 }"),
    ],
)
def test_keys_that_contradict_others(tmp_path: Path, key: str, text: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f'base = "beamline"\n{text}\n')
    with pytest.raises(MachineError, match=f"error machine-value: .*{key}"):
        load(str(path))


@given(
    st.lists(st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0)), min_size=2, max_size=5),
    st.sampled_from([0.127, 0.5, 3.0]),
)
def test_the_staircase_is_the_floor_of_the_way(
    places: list[tuple[float, float]], count: float
) -> None:
    encoder = Encoder(1000, 1000 * count)
    trace = moved(*places, axes=(TraceAxis("X"), TraceAxis("Y")))
    rows = list(table_rows(trace, load("plate-codesys"), None, encoder))
    times = stair_times(trace, encoder)
    for a, b, row in zip(times, times[1:], rows, strict=False):
        if b - a < 1e-6:
            continue
        for share in (0.01, 0.5, 0.99):
            at = trace.at([a + share * (b - a)])[0]
            for k in (0, 1):
                assert row[3 + k] == pytest.approx(
                    floor(at[k] / count + 1e-6) * count, abs=1e-3
                ) or row[3 + k] == pytest.approx(floor(at[k] / count - 1e-6) * count, abs=1e-3)


def test_the_study_of_a_path() -> None:
    encoder = Encoder(512, 65.0)
    c = encoder.count
    assert c == pytest.approx(0.127, abs=1e-4)
    trace = moved((0.0, 0.0), (1.5 * c, 0.0), (1.5 * c, 0.25 * c), axes=(
        TraceAxis("X"), TraceAxis("Y")))  # fmt: skip
    study = precision(trace, encoder)
    assert (study.corners, study.worst_line, study.moves, study.lost_moves) == (1, 1, 2, 1)
    assert study.max_corner_error == pytest.approx(0.5 * c)
    assert study.smallest_step == pytest.approx(0.25 * c)


@pytest.mark.parametrize(
    ("quadrature", "centred", "count", "read"),
    [
        (False, False, 0.126953125, (0.126953125, -0.25390625)),
        (False, True, 0.126953125, (0.25390625, -0.126953125)),
        (True, False, 0.03173828125, (0.1904296875, -0.19042968750)),
        (True, True, 0.03173828125, (0.1904296875, -0.1904296875)),
    ],
)
def test_an_encoder_of_512_or_2048_counts_floored_or_centred(
    quadrature: bool, centred: bool, count: float, read: tuple[float, float]
) -> None:
    """65 / 512 and 65 / 2048 mm, exact in binary; of 0.2 and of -0.18 mm by hand: 1.575 and -1.418
    counts of the first, 6.302 and -5.671 of the second."""
    encoder = Encoder(512, 65.0, quadrature, centred)
    assert encoder.count == count
    trace = moved((0.2, -0.18), (0.2, -0.18), axes=(TraceAxis("X"), TraceAxis("Y")))
    assert encoder.read(trace, trace.positions)[0].tolist() == list(read)
    own = load("table-simotion").triggers
    assert own is not None
    own = replace(own, quadrature=quadrature, counted="centre" if centred else "floor")
    assert (own.count, own.read(0.2), own.read(-0.18)) == (count, *read)
    trace = moved((-1.0, 0.0), (1.0, 0.0), axes=(TraceAxis("X"), TraceAxis("Y")))
    off = trace.at(stair_times(trace, encoder)[1:-1])[:, 0] / count
    assert np.allclose((off + (0.5 if centred else 0.0)) % 1.0 % 0.9999999, 0.0, atol=1e-6)


def test_the_machine_s_own_encoder_is_read_and_said(tmp_path: Path) -> None:
    own, shield = tmp_path / "mine.toml", SAMPLES / "json" / "shield.json"
    own.write_text('base = "table-simotion"\n[triggers]\nquadrature = true\ncounted = "centre"\n')
    program, run = str(tmp_path / "s.st"), CliRunner().invoke
    made = run(main, ["post", str(shield), "--machine", str(own), "-o", program])
    assert made.exit_code == 0, made.output
    page, data = tmp_path / "s.html", tmp_path / "s.json"
    words = ["simulate", program, "--machine", str(own), "--encoder", "machine", "-o"]
    done = run(main, [*words, str(page)])
    assert "one count of the encoder is 0.0317 mm" in done.stderr
    told = "2048 counts in 65 mm (quadrature of 512), the nearest count read"
    assert told in page.read_text()
    assert run(main, [*words, str(data)]).exit_code == 0
    found = json.loads(data.read_text())["encoder"]
    assert (found["counts_per_turn"], found["quadrature"], found["centred"]) == (2048, True, True)
    assert found["max_corner_error"] <= hypot(0.0159, 0.0159)
    same = [*words[:4], "--encoder", "512x4/65/centre", "-o", str(tmp_path / "same.json")]
    assert run(main, same).exit_code == 0
    assert (tmp_path / "same.json").read_text() == data.read_text()


def test_a_machine_without_an_encoder_has_none_of_its_own(tmp_path: Path) -> None:
    program = tmp_path / "p.gcode"
    program.write_text(PROGRAM)
    words = ["simulate", str(program), "--machine", "beamline", "--encoder", "machine", "-o", "-"]
    done = call(*words, status=2)
    assert "the file of beamline says nothing of encoders" in done.stderr


@pytest.mark.parametrize(
    ("window", "quadrature", "counted", "works"),
    [
        (0.26, False, "floor", True), (0.05, False, "floor", False),
        (0.05, True, "floor", True), (0.05, True, "centre", True),
        (0.01, True, "centre", False),
    ],
)  # fmt: skip
def test_the_trial_of_a_table_is_read_in_counts_of_its_encoder(
    window: float, quadrature: bool, counted: Literal["floor", "centre"], works: bool
) -> None:
    """A line from X 1 to 4: 1 mm is read as 0.889 in counts of 65 / 512, 0.984 of 65 / 2048."""
    machine = load("table-simotion")
    assert machine.triggers is not None
    own = replace(machine.triggers, arrival_window=window, quadrature=quadrature, counted=counted)
    assert (trial(replace(machine, triggers=own)) == ()) == works


def test_the_command_for_a_table_and_its_encoder(tmp_path: Path) -> None:
    program, out = tmp_path / "s.st", tmp_path / "s.json"
    shield = Path(__file__).resolve().parents[3] / "samples" / "json" / "shield.json"
    run = CliRunner().invoke
    words = ["post", str(shield), "--machine", "table-simotion", "-o", str(program)]
    assert run(main, words).exit_code == 0
    words = ["simulate", str(program), "-o", str(out), "--encoder", "512/65", "--every", "1s"]
    done = run(main, words)
    assert done.exit_code == 0
    assert "note simulate-precision: one count of the encoder is 0.1270 mm" in done.stderr
    data = json.loads(out.read_text())
    assert data["columns"][:5] == ["time_s", "AxisX", "AxisY", "AxisX read", "AxisY read"]
    off = np.array([[row[1] - row[3], row[2] - row[4]] for row in data["rows"]])
    assert np.all((off >= -1e-3) & (off < 0.128))
    assert data["encoder"]["max_corner_error"] <= hypot(0.127, 0.127)
    assert run(main, [*words[:-4], "--encoder", "512"]).exit_code == 2


def test_a_file_with_axes_of_its_own_takes_no_bodies_from_its_base(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        'base = "beamline"\n[[axes]]\nname = "X"\nmoves = "X"\nspeed = 9\nacceleration = 9\n'
    )
    mine = load(str(path))
    assert (mine.bodies, mine.modbus.scales) == ((), ())
