"""Lines that lack a station, or are of another controller: each posts, and is read back."""

import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from beamcam.errors import PlanError, VerifyError, errors_in
from beamcam.machine import Machine, load
from beamcam.model.part import Part
from beamcam.model.request import Request
from beamcam.pipeline import NOT_MADE, Posted, post, read_back
from beamcam.readers import read
from beamcam.simulation.program import simulate_program
from tests.conftest import SAMPLES, examples
from tests.rs274 import interpreted, needs_rs274
from tests.runs import call, part

#: One vertical spindle, other words, a drill cycle, tool numbers, part data; on LinuxCNC.
VERTICAL = """
base = "beamline"
title = "one vertical spindle"
controller = "linuxcnc"
suffix = ".ngc"
pairs = []

[format]
feed_unit = "mm/min"
number_blocks = false

[[spindles]]
name = "vertical"
number = 1
face = "v"
stations = 3
across = { axis = "Y", position = "y" }

[spindles.stroke]
axis = "Z"
retract = "clearance"
approach = "clearance - face_depth"
bottom = "-(face_depth + depth + tip)"

[words]
header = ["%", "({mark} {profile} {grade} L{length} N{quantity})", "G17 G21 G40 G90 G91.1 G94 G98"]
saw = ["G0 X{x}", "M101 P{angle} Q{feed}"]
drill = [
    "M06 T{tool}", "G0 X{x} Y{y} Z{z}", "M03 S{speed}", "M08",
    "G81 X{x} Y{y} Z{bottom_z} R{near_z} F{feed}", "G80", "M09", "M05",
]
change = ["M00"]
footer = ["M30", "%"]

[[axes]]
name = "stop"
moves = "X"
speed = 300
acceleration = 500

[[tools]]
kind = "drill"
diameters = [14, 18, 22]
numbers = [1, 2, 3]
"""
NO_SAW = "saw = false\n[layout]\nmin_bar = 0\nmin_bar_left = 0\n"
LINES = {
    "saw-and-vertical": VERTICAL,
    "vertical": VERTICAL.replace("\npairs", '\nsaw = false\npairs').replace(
        "[format]", "[layout]\nmin_bar = 0\nmin_bar_left = 0\nfront_trim = 0\n\n[format]"
    ),
    "three-spindles": 'base = "beamline"\n' + NO_SAW,
    "saw": 'base = "beamline"\ndrill = false\nspindles = []\npairs = []\ntools = []\n',
    "web-only": 'base = "beamline"\npairs = []\n' + (
        '[[spindles]]\nname = "web"\nnumber = 2\nface = "v"\nstations = 5\n'
        'across = { axis = "Y", position = "height / 2 - y" }\n'
        'stroke = { axis = "Z", retract = "-clearance", approach = "face_depth - clearance", '
        'bottom = "face_depth + depth + tip" }\n'
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def lines(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Machine]:
    folder = tmp_path_factory.mktemp("lines")
    for name, text in LINES.items():
        (folder / f"{name}.toml").write_text(text)
    return {name: load(str(folder / f"{name}.toml")) for name in LINES}


def parts_of(text: str) -> tuple[Part, ...]:
    reading = read(text.encode(), "a.nc1")
    assert not reading.refused, reading.diagnostics
    return reading.parts


def wrong(program: str, parts: tuple[Part, ...], machine: Machine) -> list[str]:
    found = read_back(program, Request(parts, machine))
    return [said.code for said in errors_in(found)]


PLAIN = part("A").replace("BO\n  v  100.00u   60.00    18.00\n", "")


def made(lines: dict[str, Machine], name: str, text: str) -> Posted:
    return post(parts_of(text), lines[name])


@pytest.mark.parametrize("name", [name for name in LINES if name != "saw"])
def test_a_hole_is_drilled_and_read_back(lines: dict[str, Machine], name: str) -> None:
    text = part("A")
    posted = made(lines, name, text)
    parts, machine = parts_of(text), lines[name]
    assert wrong(posted.text, parts, machine) == []
    # What is asked for is not what is made, once it is asked for elsewhere.
    moved = parts_of(text.replace("  100.00u", "  130.00u"))
    assert wrong(posted.text, moved, machine)
    comes_cut = any(said.code == "plan-comes-cut" for said in posted.remarks)
    assert comes_cut == (machine.saw is None)
    assert posted.time(machine).total_s > 0


def test_a_saw_alone(lines: dict[str, Machine]) -> None:
    posted = made(lines, "saw", PLAIN)
    assert wrong(posted.text, parts_of(PLAIN), lines["saw"]) == []
    assert "M40" not in posted.text
    with pytest.raises(PlanError, match=r"plan-face: .*; expected none, as the machine"):
        made(lines, "saw", part("A"))
    skipped = post(parts_of(part("A")), lines["saw"], skips=("face",))
    assert {remark.code for remark in skipped.remarks} & {*NOT_MADE}


def test_a_line_without_a_saw_takes_one_part_that_is_cut(lines: dict[str, Machine]) -> None:
    for name in ("vertical", "three-spindles"):
        with pytest.raises(PlanError, match="plan-no-saw: found 2 parts for one bar; expected one"):
            post(parts_of(part("A")) * 2, lines[name])
        program = made(lines, name, part("A")).text
        found = read_back(program, Request(parts_of(part("A")) * 2, lines[name]))
        assert [str(said).partition(": error ")[2] for said in errors_in(found)] == [
            "verify-no-saw: found the part A beside another one; expected one part, the machine "
            "has no saw"
        ]
    sawn = made(lines, "saw-and-vertical", part("A")).text
    cut = re.sub(r"BEAMCAM.*", "", sawn)
    assert "verify-cut-extra" in wrong(cut, parts_of(part("A")), lines["vertical"])


def test_a_part_that_the_line_cannot_hold(lines: dict[str, Machine]) -> None:
    with pytest.raises(PlanError, match="plan-bar-long"):
        made(lines, "vertical", part("A", length=18500.0))
    short = Path(str(SAMPLES)) / "dstv" / "tie.nc1"
    assert post(read(short.read_bytes(), "t.nc1").parts, lines["vertical"]).text


@settings(
    max_examples=examples(25),
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    holes=st.lists(
        st.tuples(st.integers(40, 1900), st.sampled_from([50, 100, 150]),
                  st.sampled_from([14, 18, 22])),
        min_size=1, max_size=6, unique_by=lambda hole: (hole[0] // 60, hole[1]),
    ),
    name=st.sampled_from(["vertical", "saw-and-vertical", "three-spindles", "web-only"]),
)  # fmt: skip
def test_random_holes_are_made_and_a_hole_less_is_found(
    lines: dict[str, Machine], holes: list[tuple[int, int, int]], name: str
) -> None:
    places = sorted({(x // 60 * 60 + 20, y): d for x, y, d in holes}.items())
    rows = "".join(f"  v  {x:.2f}u  {y:.2f}  {d:.2f}\n" for (x, y), d in places)
    text = PLAIN.replace("EN\n", f"BO\n{rows}EN\n")
    parts = parts_of(text)
    try:
        posted = post(parts, lines[name])
    except VerifyError as error:
        raise AssertionError(str(error)) from error
    assert wrong(posted.text, parts, lines[name]) == []
    fewer = PLAIN.replace("EN\n", f"BO\n{rows.splitlines()[0]}\nEN\n")
    if len(places) > 1:
        assert wrong(posted.text, parts_of(fewer), lines[name])


@pytest.mark.parametrize("name", ["three-spindles", "saw", "web-only", "hall-drill"])
def test_its_simulation_takes_as_long_as_its_plan(lines: dict[str, Machine], name: str) -> None:
    """Cycles and spindles chosen by the number of a tool alone are timed as blocks are."""
    text = PLAIN if name == "saw" else part("A")
    hall = SAMPLES / "machines" / "hall-drill.toml"
    parts, machine = parts_of(text), lines.get(name) or load(str(hall))
    posted = post(parts, machine)
    trace = simulate_program(posted.text, machine, parts=parts).trace
    planned = posted.time(machine).total_s
    assert trace.duration_s == pytest.approx(planned, abs=0.01)
    if name != "saw":  # each hole takes the time of its stroke at least
        holes = len([*parts[0].holes])
        assert planned > 3.0 * holes


@needs_rs274
def test_linuxcnc_runs_the_program_of_a_vertical_spindle(
    lines: dict[str, Machine], tmp_path: Path
) -> None:
    """rs274 feeds to each hole's bottom, and stands nowhere else in the steel."""
    text = PLAIN.replace("EN\n", "BO\n  v  100.00u  60.00  18.00\n  v  700.00u  90.00  22.00\nEN\n")
    posted = made(lines, "vertical", text)
    assert "(A UPN200 S235JR L2000 N1)" in posted.text
    assert re.findall(r"M06 T(\d)", posted.text) == ["2", "3"]
    program = tmp_path / "a.ngc"
    program.write_text(posted.text)
    tools = "".join(f"T{n} P{n} Z0 D1\n" for n in (1, 2, 3))
    done = interpreted(program, tools=tools)
    fed = re.findall(r"STRAIGHT_FEED\(([^)]*)\)", done.stdout)
    places = [tuple(map(float, row.split(",")[:3])) for row in fed]
    drill = lines["vertical"].drill
    assert drill is not None
    assert [(x - drill.x, y) for x, y, _ in places] == [(100.0, 60.0), (700.0, 90.0)]
    assert all(z < -60.0 for _, _, z in places)


@pytest.mark.parametrize("name", LINES)
def test_no_command_ends_in_a_traceback(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.toml").write_text(LINES[name])
    Path("a.nc1").write_text(PLAIN if name == "saw" else part("A"))
    suffix = load("m.toml").suffix
    program = f"a{suffix}"
    on = ("--machine", "m.toml")
    assert call("machines", "show", "./m.toml").exit_code == 0
    assert call("post", "a.nc1", "-o", program, *on).exit_code == 0
    assert call("verify", program, "--against", "a.nc1", *on).exit_code == 0
    assert call("verify", program, *on).exit_code == 0
    assert call("plan", "a.nc1", *on).exit_code == 0
    assert call("plan", "a.nc1", "--turn", *on).exit_code == 0
    assert call("simulate", program, "-o", "a.csv", *on).exit_code == 0
    assert call("plot", program, "-o", "a.svg", *on).exit_code == 0
    assert call("diff", program, program, *on).exit_code == 0
    assert call("batch", "a.nc1", "-o", "out", *on).exit_code == 0
    assert call("check", "out").exit_code == 0
    recovered = call("recover", program, "--profile", "UPN200", "-o", "b.nc1", *on)
    if load("m.toml").saw is None:
        assert "error recover-no-piece" in recovered.stderr
    else:
        assert recovered.exit_code == 0
    assert call("post", "a.nc1", "-o", program, "--quantity", "file", *on).exit_code == 0
    assert call("list", "a.nc1", "-o", "-", *on).exit_code in (0, 2)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("saw = false\ndrill = false\nspindles = []\npairs = []\ntools = []\n",
         "error machine-missing: found no key 'saw'"),
        ("drill = false\n", "expected a [drill] table for it"),
        ("drill = false\nspindles = []\npairs = []\n", "found 1 for 'tools'; expected none, or a"),
        ("layout = false\n", "error machine-missing: found no key 'layout'"),
        ('spindles = []\npairs = []\n', ""),
        ('controller = "linuxcnc"\n', "error machine-word"),
        ('controller = "grbl"\n', "found 'grbl' for 'controller'; expected"),
        ('controller = "simotion"\n', "found 'simotion' for 'controller'; expected"),
        ('controller = "stepper"\n', "found 'stepper' for 'controller'; expected"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_its_key(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "m.toml").write_text(f'base = "beamline"\n{text}')
    done = call("machines", "show", tmp_path / "m.toml")
    assert said in done.stderr
    assert done.exit_code == (1 if said else 0)
    (tmp_path / "a.nc1").write_text(PLAIN)
    done = call("post", tmp_path / "a.nc1", "-o", "-", "--machine", tmp_path / "m.toml")
    assert done.exit_code == (1 if said else 0)


@pytest.mark.parametrize(
    ("position", "is_one"),
    [("y", True), ("height / 2 - y", True), ("-2 * y + 3", True), ("3", False), ("y * y", False),
     ("height / 2", False)],
)  # fmt: skip
def test_a_spindle_follows_the_holes_across(tmp_path: Path, position: str, is_one: bool) -> None:
    text = LINES["web-only"].replace("height / 2 - y", position)
    (tmp_path / "m.toml").write_text(text)
    done = call("machines", "show", tmp_path / "m.toml")
    assert done.exit_code == (0 if is_one else 1)
    if not is_one:
        assert f"found '{position}' for 'spindles.0.across.position'; expected arithmetic" in (
            done.stderr
        )
