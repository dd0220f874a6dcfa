"""Canned cycles of drilling: as rs274 of LinuxCNC makes them, and on CODESYS as a file says."""

import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from beamcam.arguments import load_machine
from beamcam.controllers import cell_events, table_events
from beamcam.controllers.events import Move, Pause
from beamcam.errors import MachineError, errors_in
from beamcam.machine import Machine, load
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from beamcam.readers import read
from tests.conftest import SAMPLES, examples
from tests.rs274 import interpreted, needs_rs274
from tests.runs import part

HEAD = "%\nG17 G21 G40 G90 G91.1 G94 G98\nG0 X0 Y0 Z5\nG1 F100 Z4\n"
FOOT = "G80\nM30\n%\n"
_CANON = re.compile(r"(STRAIGHT_TRAVERSE|STRAIGHT_FEED|DWELL)\(([^)]*)\)")

LINUXCNC = """
base = "beamline"
controller = "linuxcnc"
pairs = []
[format]
feed_unit = "mm/min"
number_blocks = false
[[spindles]]
name = "vertical"
number = 1
face = "v"
across = { axis = "Y", position = "y" }
stroke = { axis = "Z", retract = "clearance", bottom = "-(face_depth + depth + tip)" }
[words]
header = ["%", "G17 G21 G40 G90 G91.1 G94 G98"]
saw = ["G0 X{x}", "M101 P{angle} Q{feed}"]
drill = ["M06 T{tool}", "G0 X{x} Y{y} Z{z}", "M03 S{speed}", "G81 X{x} Y{y} Z{bottom_z} R{near_z} F{feed}", "G80", "M05"]
change = ["M00"]
footer = ["M30", "%"]
[[tools]]
kind = "drill"
diameters = [14, 18, 22]
numbers = [1, 2, 3]
"""  # noqa: E501
CODESYS = """
base = "beamline"
[codes]
G54 = "none"
G81 = "drill-cycle"
G82 = "drill-cycle-dwell"
G83 = "drill-cycle-peck"
G73 = "drill-cycle-chips"
G80 = "end-cycle"
M77 = "none"
"""


def machine(folder: Path, text: str) -> Machine:
    path = folder / "mine.toml"
    path.write_text(text)
    return load(str(path))


def made(text: str, on: Machine) -> tuple[list[tuple[bool, tuple[float, ...]]], list[str]]:
    """Each move of a program, rapid or not, with its end; and the codes of what was said."""
    events, said = cell_events(text, on)
    return [(e.rapid, e.end) for e in events if isinstance(e, Move)], [d.code for d in said]


#: The cycles, and what each has of its own.
CYCLES = {"G81": "", "G82": " P0.5", "G83": " Q{}", "G73": " Q{}"}
number = st.integers(-20, 20).map(float)
near = st.integers(-3, 8).map(float)


@st.composite
def programs(draw: st.DrawFn) -> str:
    """Blocks of moves and cycles; R lies above Z, as LinuxCNC wants it."""
    lines = []
    for _ in range(draw(st.integers(1, 6))):
        kind = draw(st.sampled_from(["G0", *CYCLES, "more", "G98", "G99", "G80"]))
        place = f"X{draw(number):g} Y{draw(number):g}"
        if kind == "G0":
            lines.append(f"G80\nG0 {place} Z{draw(st.integers(-2, 9))}")
        elif kind in CYCLES:
            r = draw(near)
            z = r - draw(st.integers(1, 20))
            own = CYCLES[kind].format(draw(st.integers(1, 9)))
            lines.append(f"{kind} {place} Z{z:g} R{r:g}{own} F{draw(st.integers(50, 90))}")
            lines += [f"X{draw(number):g}"] * draw(st.integers(0, 2))
        elif kind != "more":
            lines.append(kind)
    return HEAD + "\n".join(lines) + "\n" + FOOT


@pytest.fixture(scope="module")
def linuxcnc(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    return machine(tmp_path_factory.mktemp("machine"), LINUXCNC)


def stranger(text: str, path: Path) -> list[tuple[bool, tuple[float, ...]]] | None:
    """The moves that rs274 makes of a program; None if it refuses it."""
    path.write_text(text)
    done = interpreted(path)
    if "PROGRAM_END" not in done.stdout:
        return None
    found = []
    for word, values in _CANON.findall(done.stdout):
        if word != "DWELL":
            x, y, z = map(float, values.split(",")[:3])
            found.append((word == "STRAIGHT_TRAVERSE", (x, y, z)))
    return found


def changes(moves: list[tuple[bool, tuple[float, ...]]]) -> list[tuple[bool, tuple[float, ...]]]:
    """Moves without those that go nowhere."""
    found: list[tuple[bool, tuple[float, ...]]] = []
    for move in moves:
        if not found or found[-1][1] != move[1]:
            found.append(move)
    return found


@needs_rs274
@settings(
    max_examples=examples(40),
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(text=programs())
@example(HEAD + "G99\nG0 X0 Y0 Z0\nG81 X0 Y1 Z-2 R-1 F50\nG81 X0 Y0 Z-1 R0 F50\nX1 R1\nX2\n" + FOOT)
@example(HEAD + "G81 X0 Y1 Z5 R6 F50\nG81 X0 Y0 Z4 R5 F50\n" + FOOT)
def test_cycles_are_what_linuxcnc_makes_of_them(
    linuxcnc: Machine, tmp_path: Path, text: str
) -> None:
    expected = stranger(text, tmp_path / "a.ngc")
    moves, said = made(text, linuxcnc)
    if expected is None:
        assert said
        return
    assert said == []
    assert changes(moves)[1:] == changes(expected)[1:], text  # before the first it stands at 0


def test_a_cycle_goes_in_at_its_feed_and_out_in_rapid(linuxcnc: Machine) -> None:
    text = HEAD + "G99 G81 X10 Y20 Z-6 R2 F80\nX30\nG98 X40\n" + FOOT
    moves, said = made(text, linuxcnc)
    assert said == []
    assert moves[2:] == [
        (True, (10, 20, 4)), (True, (10, 20, 2)), (False, (10, 20, -6)), (True, (10, 20, 2)),
        (True, (30, 20, 2)), (False, (30, 20, -6)), (True, (30, 20, 2)),
        (True, (40, 20, 2)), (False, (40, 20, -6)), (True, (40, 20, 4)),
    ]  # fmt: skip
    events, _ = cell_events(text.replace("G81", "G82 P0.3"), linuxcnc)
    assert [e.seconds for e in events if isinstance(e, Pause)] == [0.3, 0.3, 0.3]


@pytest.mark.parametrize(
    "block", ["G81 X1 Y1 Z-3 F50", "G81 X1 Y1 R2 F50", "G81 X1 Y1 Z3 R2 F50",
              "G81 X1 Y1 Z-3 R2 Q1 F50", "G80 X4",
              "G83 X1 Y1 Z-3 R2 F50", "G83 X1 Y1 Z-3 R2 Q-1 F50", "G73 X1 Y1 Z-3 R2 Q0.001 F50",
              "G91\nG81 X1 Y1 Z-3 R2 F50"],
)  # fmt: skip
def test_a_cycle_that_is_none(linuxcnc: Machine, block: str) -> None:
    assert "verify-word" in made(f"{HEAD}{block}\n{FOOT}", linuxcnc)[1]


def test_where_a_cycle_draws_back_to_has_to_be_said(linuxcnc: Machine) -> None:
    text = HEAD.replace(" G98", "") + "G81 X1 Y1 Z-3 R2 F50\nG81 X2\n" + FOOT
    assert made(text, linuxcnc)[1] == ["verify-setting"]


def test_a_table_has_no_cycles() -> None:
    text = "%\nG17 G21 G40 G90 G91.1 G94\nG0 X1 Y1\nG81 X2 Y2 Z-1 R1\nM2\n%\n"
    from beamcam.controllers import table_events

    for name in ("plate-linuxcnc", "laser-grbl"):
        assert table_events(text, load(name))[1]


def test_codesys_takes_the_words_that_its_machine_names(tmp_path: Path) -> None:
    text = "% A\nG90\nG54\nG00 X0 Y0 Z-5\nG81 X10 Y20 Z6 R-2 F80\nX30\nG82 X40 P0.2\nG80\nM30\n%\n"
    moves, said = made(text, machine(tmp_path, CODESYS))
    assert said == []
    assert moves[1:5] == [
        (True, (10, 20, -5)), (True, (10, 20, -2)), (False, (10, 20, 6)), (True, (10, 20, -5)),
    ]  # fmt: skip
    assert [end for rapid, end in moves if not rapid] == [(10, 20, 6), (30, 20, 6), (40, 20, 6)]
    assert "verify-word" in made(text, load("beamline"))[1]
    assert "verify-word" in made(text.replace("R-2", "Q1"), machine(tmp_path, CODESYS))[1]
    assert "verify-word" in made(text.replace("G54", "G54 X1"), machine(tmp_path, CODESYS))[1]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[codes]\nG01 = "none"\n', "found 'G01' for 'codes.G01'; expected another word, as the"),
        ('[codes]\n81 = "drill-cycle"\n', "found '81' for 'codes.81'; expected a G word such as"),
        ('[codes]\nM77 = "drill-cycle"\n', "for 'codes.M77'; expected none, as an M word"),
        ('[codes]\nM30 = "none"\n', "found 'M30' for 'codes.M30'; expected another word, as the"),
        ('[codes]\nG81 = "drill"\n', "found 'drill' for 'codes.G81'; expected one of 'none'"),
        ('[[tools]]\nkind = "drill"\ndiameters = [14, 18]\nnumbers = [1]\n',
         "found [1] for 'tools.0.numbers'; expected 2, one for each diameter"),
        ('[[tools]]\nkind = "drill"\ndiameters = [14, 18]\nnumbers = [4, 4]\n',
         "found [4] for 'tools'; expected a number once"),
        ('[words]\ndrill = ["M40 K{spindle} T{tool}"]\n',
         "found [] for 'tools.0.numbers'; expected one for each diameter, since words.drill has"),
    ],
)  # fmt: skip
def test_words_and_numbers_that_contradict(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(MachineError) as caught:
        machine(tmp_path, f'base = "beamline"\n{text}')
    assert said in str(caught.value)


def test_a_peck_is_fed_and_cleared_until_the_bottom(linuxcnc: Machine, tmp_path: Path) -> None:
    rows = [
        (True, (10, 20, 2)), (False, (10, 20, -1)), (True, (10, 20, 2)), (True, (10, 20, -0.746)),
        (False, (10, 20, -4)), (True, (10, 20, 2)), (True, (10, 20, -3.746)),
        (False, (10, 20, -6)), (True, (10, 20, 4)),
    ]  # fmt: skip
    moves, said = made(HEAD + "G83 X10 Y20 Z-6 R2 Q3 F80\n" + FOOT, linuxcnc)
    assert (moves[3:], said) == (rows, [])
    broken = [row for at, row in enumerate(rows) if at not in (2, 5)]
    assert made(HEAD + "G73 X10 Y20 Z-6 R2 Q3 F80\n" + FOOT, linuxcnc)[0][3:] == broken
    own = machine(tmp_path, CODESYS)
    text = "% A\nG90\nG00 X10 Y20 Z4\nM77\nG83 X10 Y20 Z-6 R2 Q3 F80\nG80\nM30\n%\n"
    moves, said = made(text, own)
    assert (moves[1:], said) == (rows, [])
    assert made(text.replace("M77", "M77 K1"), own)[1] == ["verify-word"]


ALLOWED = (
    'allowed_codes = ["G00", "G01", "G90", "G99", "M03", "M04", "M05", "M06", "M08", "M09", "M30", '
    '"M40", "M42", "M43", "M44"]\n'
)


def test_a_machine_takes_the_words_that_its_file_allows_and_no_other(tmp_path: Path) -> None:
    own = load_own(tmp_path, 'base = "beamline"\n' + ALLOWED)
    parts = read(part("A").encode(), "a.nc1").parts
    posted = post(parts, own)
    assert read_back(posted.text, Request(parts, own)) == ()
    added = posted.text.replace("M05\n", "M05\nG75\n", 1)
    assert read_back(added, Request(parts, load("beamline"))) == ()
    (said,) = read_back(added, Request(parts, own))
    assert "error verify-word: found G75; expected one of allowed_codes: G00, G01, G90" in str(said)
    line = tmp_path / "line.toml"
    line.write_text(LINUXCNC.replace("pairs = []", 'pairs = []\nallowed_codes = ["G00", "M30"]'))
    with pytest.raises(
        MachineError, match=r"in 'words.header', found G17; expected one of allowed_codes"
    ):
        load_machine(str(line))


@pytest.mark.parametrize("line", ['M60 K{face} L{height} P{y} R{angle} "{string}"',
                                  'L{height} P{y} R{angle} K{face} "{string}" M060'])  # fmt: skip
def test_the_word_of_a_stamp_has_to_be_allowed_too(tmp_path: Path, line: str) -> None:
    text = (SAMPLES / "machines" / "beamline-stamp.toml").read_text(encoding="utf-8")
    stamp = next(row for row in text.splitlines() if row.startswith("stamp ="))
    text = text.replace(stamp, f"stamp = ['G00 X{{x}}', '{line}']")
    head, tables = text.split("[marks]", 1)
    with pytest.raises(
        MachineError, match=r"in 'words.stamp', found M60; expected one of allowed_codes: G00, G01"
    ):
        load_own(tmp_path, f"{head}{ALLOWED}[marks]{tables}")
    allowed = ALLOWED.replace('"M44"', '"M44", "M60"')
    own = load_own(tmp_path, f"{head}{allowed}[marks]{tables}")
    parts = read((SAMPLES / "dstv" / "marked.nc1").read_bytes(), "marked.nc1").parts
    posted = post(parts, own)
    assert '"B-12"' in posted.text
    assert errors_in(read_back(posted.text, Request(parts, own))) == ()


def test_a_table_without_arcs_in_its_list_is_refused_them(tmp_path: Path) -> None:
    codes = [
        "G00", "G01", "G04", "G17", "G21", "G40", "G41.1", "G42.1", "G64", "G90",
        "G91.1", "G94", "M02", "M03", "M05", "M30",
    ]  # fmt: skip
    text = f'base = "plate-linuxcnc"\nallowed_codes = {codes}\n'
    with pytest.raises(MachineError, match=r"error machine-word: in 'words.arc_ccw', found G03"):
        load_own(tmp_path, text)
    on = load_own(tmp_path, text + "[words]\narc_cw = []\narc_ccw = []\n")
    head = "%\nG17 G21 G40 G90 G91.1 G94\nG0 X1 Y1\nG1 X2 Y1 F600\n"
    _, said = table_events(head + "G3 X4 Y1 I1 J0\nG1 X5 Y1\nM30\n%\n", on)
    assert [d.code for d in said] == ["verify-sheet-word"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('allowed_codes = ["X1"]\n', "found 'X1' for 'allowed_codes.0'; expected a G or M word"),
        ('allowed_codes = ["G1", "G01"]\n', "found 'G01' for 'allowed_codes.1'; expected each"),
        ('allowed_codes = ["G77"]\n', "machine-word: in 'allowed_codes', found G77; expected"),
        ('allowed_codes = ["M77"]\n', "machine-word: in 'allowed_codes', found M77; expected"),
    ],
)  # fmt: skip
def test_allowed_words_that_mean_nothing(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(MachineError) as caught:
        load_own(tmp_path, f'base = "beamline"\n{text}')
    assert said in str(caught.value)


def load_own(folder: Path, text: str) -> Machine:
    (folder / "own.toml").write_text(text)
    return load_machine(str(folder / "own.toml"))
