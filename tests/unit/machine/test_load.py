"""Machine files: what is refused, and where values come from."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from beamcam.arguments import load_tested
from beamcam.conversion import Fault, converted
from beamcam.errors import MachineError
from beamcam.machine import load, shipped, words
from beamcam.machine.keys import settings
from beamcam.machine.load import files_of_machine, merged
from beamcam.machine.machine import MachineFile
from beamcam.machine.stations import Formula, as_formula
from beamcam.machine.toml import line_of
from beamcam.model.plan import DrillOp
from beamcam.planning.beam import plan_bar
from tests.conftest import rules_of
from tests.unit.planning.shop import hole, part


def spindle(position: str, stroke_axis: str) -> str:
    """A machine with one spindle, which is fed along `stroke_axis`."""
    return (
        'pairs = []\n[[spindles]]\nname = "s"\nnumber = 1\nface = "v"\n'
        f'across = {{ axis = "Y", position = "{position}" }}\n'
        f'stroke = {{ axis = "{stroke_axis}", retract = 0, bottom = 1 }}'
    )


def pair(faces: str) -> str:
    """A machine with one pair of spindles."""
    return f'[[pairs]]\nname = "p"\nnumber = 9\nfaces = {faces}'


#: Both flanges' spindles, of which the left one strokes by formulas of its own.
LEFT_OF_A_PAIR = """
[[spindles]]
name = "left flange"
number = 1
face = "o"
across = {{ axis = "Z", position = "188.6 - y" }}
stroke = {{ axis = "Y", retract = "{start}", bottom = "{bottom}" }}
[[spindles]]
name = "right flange"
number = 3
face = "u"
across = {{ axis = "Z", position = "188.6 - y" }}
stroke = {{ axis = "Y", retract = "-clearance", bottom = "depth + tip" }}
"""

#: The saw's axis alone.
TURNS = "[[axes]]\nname = 'r'\nmoves = 'angle'\nspeed = 6\nacceleration = 12\n"

#: Lines laid over the machine `beamline`, the code they give, and what its message has to say.
BAD = [
    ("kerff = 3", "machine-key", "found unknown key 'kerff'"),
    (
        LEFT_OF_A_PAIR.format(start="-clearance", bottom="60"),
        "machine-value",
        "found 'depth + tip' for 'spindles.1.stroke.bottom'; expected '60' as the other spindle of "
        "'both flanges' has, or no pair",
    ),
    (
        LEFT_OF_A_PAIR.format(start="-9", bottom="depth + tip"),
        "machine-value",
        "found '-clearance' for 'spindles.1.stroke.retract'; expected '-9' as",
    ),
    ("[saw]\nkerff = 3", "machine-key", "found unknown key 'saw.kerff'; expected 'kerf'"),
    ("[saw]\nkerf = '3'", "machine-value", "found '3' for 'saw.kerf'; expected a number"),
    (
        "[[axes]]\nname = 'x'\nmoves = 'X'\nspeed = 1\nacceleration = 1\nmin = 3\nmax = 2",
        "machine-value",
        "found 3.0 for 'axes.0.min'; expected at most max",
    ),
    (
        "base = 'plate-linuxcnc'\n[torch]\ngap = 50",
        "machine-value",
        "found 50 for 'torch.gap'; expected at most 1 mm",
    ),
    (
        "base = 'laser-stepper'\n[torch]\ngap = 0.01",
        "machine-value",
        "found 0.01 for 'torch.gap'; expected 0.0141 or more: the laser would be on while no motor "
        "makes a step of 0.01 mm",
    ),
    (
        "base = 'plate-linuxcnc'\n[[torch.rows]]\nprocess = 'cut'\nup_to = 9\nfeed_mm_min = 9\n"
        "kerf = 0.0005",
        "machine-value",
        "expected 0, or at least 10 steps of 0.0001 mm",
    ),
    (
        "base = 'plate-linuxcnc'\n[torch]\ntolerance = 1e-6",
        "machine-value",
        "found 1e-06 for 'torch.tolerance'; expected at least 0.0001, the step of its numbers",
    ),
    (
        spindle("y", "Z").replace("retract = 0", "retract = 0.5"),
        "machine-value",
        "found '0.5' for 'spindles.0.stroke.retract'; expected a place outside of the bar",
    ),
    (
        spindle("y", "Z")
        .replace("bottom = 1", "bottom = 'depth'")
        .replace("retract = 0", "retract = 9"),
        "machine-value",
        "found '9' for 'spindles.0.stroke.retract'; expected a place outside",
    ),
    ("[saw]\nkerf = nan", "machine-value", "found nan for 'saw.kerf'; expected a finite number"),
    ("[layout]\nfront_trim = inf", "machine-value", "expected a finite number"),
    ("[saw]\nkerf = -1", "machine-value", "found -1 for 'saw.kerf'; expected 0 or more"),
    ("[saw]\npivot = 'v'", "machine-value", "expected one of 'o', 'u'"),
    ("[words]\nsaw = ['M42 K{angel}']", "machine-value", "found '{angel}' for 'words.saw'"),
    ("[words]\nsaw = ['M42 K{angle']", "machine-value", "a template"),
    ("[words]\nsaw = 'M42'", "machine-value", "expected a list"),
    ("[words]\nsaw = ['X{x:>999999999}']", "machine-value", "expected {x}, or with a width of two"),
    ("[words]\nsaw = ['X{x!r}']", "machine-value", "expected {x}, or with a width"),
    ("[words]\nsaw = ['X{x.real}']", "machine-value", "found '{x.real}' for 'words.saw'"),
    ("[saw]\nx = " + "9" * 400, "machine-value", "expected a finite number"),
    ("sections = { I = 0x" + "f" * 4000 + " }", "machine-value", "of at most 18 digits"),
    ("[saw]\nx = " + "9" * 4097, "machine-toml", "more than 4096 characters"),
    ("x = " + "[" * 2000, "machine-toml", "nested more than 16 deep"),
    ("x = " + "[" * 17 + "]" * 17, "machine-toml", "nested more than 16 deep"),
    (".".join("x" * 1000) + " = 1", "machine-toml", "nested more than 16 deep"),
    ("# " + "\n" * 500_000, "machine-toml", "expected at most 500000"),
    ("[saw]\nx = 1979-05-27", "machine-value", "for 'saw.x'; expected a number"),
    ("sections = { I = 1, U = 'x' }", "machine-value", "found 'x' for 'sections.U'"),
    (
        "sections = { I = 1, '' = 1.5 }",
        "machine-value",
        "found 1.5 for 'sections.'; expected a whole",
    ),
    (
        "base = 'laser-stepper'\n[stepper]\npitch = 0",
        "machine-value",
        "found 0 for 'stepper.pitch'",
    ),
    (
        "base = 'laser-grbl'\n[torch]\ntabs = -1",
        "machine-value",
        "'torch.tabs'; expected 0 or more",
    ),
    ("base = 'table-simotion'\n[triggers]\nmax_data = 10", "machine-value", "1024 or more"),
    (spindle("y", "Z") + "\nstations = 0", "machine-value", "'spindles.0.stations'; expected 1 or"),
    ("controller = 'fanuc'", "machine-value", "expected one of"),
    ("[format]\nnumber_blocks = 1", "machine-value", "expected true or false"),
    ("[format]\nlength_decimals = 1.5", "machine-value", "expected a whole number"),
    ("drill = 3", "machine-value", "found 3 for 'drill'; expected a table"),
    ("spindles = 3", "machine-value", "expected a list"),
    (pair("['o', 'h']"), "machine-value", "faces that have a spindle"),
    (pair("['o']"), "machine-value", "a list of 2"),
    (
        "[[tools]]\nkind = 'drill'\ndiameters = [0]",
        "machine-value",
        "diameters.0'; expected more than",
    ),
    (spindle("heigth / 2", "Z"), "machine-value", "'heigth' is not understood"),
    (spindle("y", "Y"), "machine-value", "another axis"),
    ("[[spindles]]\nname = 's'", "machine-missing", "found no key 'spindles.0.number'"),
    ("kerf = = 3", "machine-toml", "found no TOML ("),
    (
        "base = 'beamline-pusher'\n[saw]\nmin_tilt = 16",
        "machine-value",
        "found 16.0 for 'saw.min_tilt'; expected at most 0, the square cut",
    ),
    (
        "base = 'beamline-pusher'\n[saw]\nmin_tilt = -5\nmax_tilt = -1",
        "machine-value",
        "at least 0, the square",
    ),
    ("[saw]\nmin_angle = 1", "machine-value", "at most 0, the square"),
    ("[saw]\nmax_angle = -1", "machine-value", "at least 0, the square cut"),
    (f"{TURNS}max = -1", "machine-value", "at least 0, the square cut"),
    (f"{TURNS}min = 1", "machine-value", "at most 0, the square cut"),
    (
        "base = 'laser-stepper'\n[stepper]\npitch = 0.001",
        "machine-value",
        "found 0.001 for 'stepper.pitch'; expected at least 0.1, steps of 0.0005 mm",
    ),
    (
        "base = 'laser-stepper'\n[stepper]\nmax_hz = 0.02",
        "machine-value",
        "found 0.02 for 'stepper.max_hz'; expected at least",
    ),
    ("[saw]\nfeed_mm_min = 0.9", "machine-value", "expected 1 mm/min or more"),
    ("[saw]\nkerf = 5e-324", "machine-value", "expected 0, or a number of at least 1e-06"),
    ("[drill]\nmin_speed_rpm = 0.5", "machine-value", "'drill.min_speed_rpm'; expected 1 or more"),
    ("[drill]\nmax_speed_rpm = 100", "machine-value", "expected at least drill.min_speed_rpm"),
    ("[drill]\nmax_feed_mm_min = 0.5", "machine-value", "expected 1 mm/min or more"),
    (
        "[drill]\nmin_speed_rpm = 2",
        "machine-value",
        "found 2.0 for 'drill.min_speed_rpm'; expected 10 or more, for a feed of 1 mm/min by",
    ),
    (
        "[[drill.cutting]]\nup_to = 9\nspeed_m_min = 9\nfeed_per_turn = 0.0005",
        "machine-value",
        "found 0.0005 for 'drill.cutting.0.feed_per_turn'; expected 0.001 mm or more",
    ),
    ("[drill]\nmerge_tolerance = 1.5", "machine-value", "expected at most 1 mm"),
    ("[drill]\nduplicate_tolerance = 1.5", "machine-value", "expected at most 1 mm"),
    ("[drill]\ntwin = 1.5", "machine-value", "expected at most 1 mm"),
    ("[[pairs]]\nname = 'p'\nnumber = 3\nfaces = ['o', 'u']", "machine-value", "expected another"),
    ("[drill]\nsink_tolerance = 1.5", "machine-value", "expected at most 1 mm"),
    ("[drill]\npath_tolerance = 1.5", "machine-value", "expected at most 1 mm"),
    ("[drill]\npath_tolerance = 0", "machine-value", "expected 0.001 mm or more"),
    ("base = 'laser-stepper'\nsuffix = '.txt'", "machine-value", "expected one of .steps, .csv,"),
    ("base = 'plate-linuxcnc'\n[torch]\ngap = 1.5", "machine-value", "expected at most 1 mm"),
    ("base = 'plate-linuxcnc'\n[torch]\ngap = 5e-324", "machine-value", "at least 1e-06"),
    ("base = 'plate-linuxcnc'\n[torch]\ncross = 0.05", "machine-value", "0, or at least 1 mm"),
    (
        "base = 'plate-codesys'\n[torch]\nacceleration = 0.5",
        "machine-value",
        "found 0.5 for 'torch.acceleration'; expected at least 1 mm/s2",
    ),
    (
        "base = 'plate-linuxcnc'\n[[torch.rows]]\nprocess = 'mark'\nup_to = 9\nfeed_mm_min = 0.5\n"
        "[[torch.rows]]\nprocess = 'cut'\nup_to = 9\nfeed_mm_min = 5",
        "machine-value",
        "'torch.rows.0.feed_mm_min'; expected 1 mm/min or more",
    ),
    (
        "base = 'table-simotion'\n[triggers]\nstart = '%I0.0'",
        "machine-value",
        "found '%I0.0' for 'triggers'; expected each input, output and axis once",
    ),
    (
        "base = 'table-simotion'\n[triggers]\nacknowledge = '%I0.4'",
        "machine-value",
        "found '%I0.4' for 'triggers'; expected each",
    ),
    (
        "base = 'table-simotion'\n[triggers.outputs]\ncut = 'torch'\nmark = 'Torch'",
        "machine-value",
        "found 'TORCH' for 'triggers'; expected each",
    ),
    (
        "base = 'table-simotion'\n[triggers]\ncycle_s = 0.000025",
        "machine-value",
        "found 2.5e-05 for 'triggers.cycle_s'; expected 0.0005 s or more",
    ),
    ("base = 3", "machine-value", "a machine's name"),
    ("base = 'beamlin'", "machine-unknown", "'beamlin'; expected 'beamline' or the path"),
    ("base = 'mine.toml'", "machine-base", "'mine' among its own bases"),
]


def test_a_table_in_a_list_of_tables_has_its_own_line() -> None:
    text = "[[spindles]]\nname = 'a'\n[[spindles]]\nname = 'b'\n\n[spindles.stroke]\naxis = 'Q'\n"
    assert line_of(text, "spindles.1.stroke.axis") == 7
    assert line_of(text, "spindles.1.stroke.retract") == 6
    assert line_of(text, "spindles.1.number") == 3
    assert line_of(text, "spindles.0.stroke.axis") == 1
    assert line_of("a = 1\n[b.c.d]\ne = 1\n", "b") == 2
    assert line_of("a = 1\n", "b") is None


@pytest.mark.parametrize(("text", "code", "says"), BAD, ids=[b[0][:40] for b in BAD])
def test_refused(tmp_path: Path, text: str, code: str, says: str) -> None:
    path = tmp_path / "mine.toml"
    base = "" if "base =" in text else 'base = "beamline"\n'
    path.write_text(base + text + "\n")
    with pytest.raises(MachineError) as caught:
        load(str(path))
    (said,) = caught.value.diagnostics
    assert said.code == code
    assert says in said.message
    assert "mine.toml" in said.source.file


def test_every_rule_is_shown_above() -> None:
    # in test_former_keys, test_own_machines, test_chart_file and test_machine_words
    others = {
        "machine-former-key", "machine-key-twice", "machine-name-twice", "machine-word",
        "machine-chart",
    }  # fmt: skip
    assert {code for _, code, _ in BAD} | others == {rule.code for rule in rules_of(words)}


def test_message_names_the_line(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('# mine\nbase = "beamline"\n\n[saw]\nx = 0\nkerff = 3\n')
    with pytest.raises(MachineError, match=r"mine\.toml:6: error machine-key"):
        load(str(path))


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b'title = "S\xe4ge"', "machine-toml"),
        ('base = "beamline"'.encode("utf-16"), "the file is UTF-16; save it as UTF-8"),
    ],
)
def test_not_utf8(tmp_path: Path, data: bytes, says: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_bytes(data)
    with pytest.raises(MachineError, match=says):
        load(str(path))


def test_an_editor_of_windows_wrote_it(tmp_path: Path) -> None:
    """A byte order mark and CRLF change neither values nor lines."""
    path = tmp_path / "mine.toml"
    path.write_bytes('\ufeffbase = "beamline"\r\n\r\n[saw]\r\nkerf = 3\r\n'.encode())
    machine = load(str(path))
    assert machine.saw
    assert machine.saw.kerf == 3.0
    assert {str(s.source) for s in settings(str(path)) if s.key == "saw.kerf"} == {f"{path}:4"}
    path = tmp_path / "other.toml"
    path.write_bytes('\ufeffbase = "beamline"\r\n\r\n[saw]\r\nkerf = -3\r\n'.encode())
    with pytest.raises(MachineError, match=r"other\.toml:4: error machine-value: found -3 "):
        load(str(path))


def test_bases_without_end(tmp_path: Path) -> None:
    for k in range(20):
        (tmp_path / f"m{k}.toml").write_text(f'base = "m{k + 1}.toml"\n')
    with pytest.raises(MachineError, match=r"found 'm9\.toml' for 'base'; expected 8 files"):
        load(str(tmp_path / "m0.toml"))


#: A value of another type than that of every key.
OTHERS: tuple[object, ...] = (True, 3, "x", [True], {"x": True}, float("nan"))


@pytest.mark.parametrize("name", ["beamline-annex", "table-simotion", "laser-stepper"])
def test_each_wrong_value_names_its_key(name: str) -> None:
    """Whatever a key of a shipped machine is given instead, the fault is at that key."""
    table, _ = merged(files_of_machine(name))
    for path in tuple(paths_of(table)):
        holder: Any = table
        for step in path[:-1]:
            holder = holder[step]
        right = holder[path[-1]]
        for other in OTHERS:
            if type(right) is type(other) or other == 3:
                continue  # a number may be arithmetic, or a length
            holder[path[-1]] = other
            if other == "x" and path[-1] in ("start", "bottom", "near", "position"):
                continue  # arithmetic may be a text
            with pytest.raises(Fault) as caught:
                converted(table, MachineFile, as_formula)
            assert caught.value.path[: len(path)] == path
        holder[path[-1]] = right


def paths_of(value: object) -> Iterator[tuple[Any, ...]]:
    """The path of each value that is not a table."""
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            below = list(paths_of(item))
            yield from ((key, *path) for path in below) if below else [(key,)]


def test_a_file_lies_over_its_base(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('base = "beamline"\n[saw]\nkerf = 3\n')
    mine, base = load(str(path)), load("beamline")
    assert mine.name == "mine"
    assert mine.saw is not None
    assert base.saw is not None
    assert mine.saw.kerf == 3.0
    assert mine.saw.max_angle == base.saw.max_angle
    assert mine.drill == base.drill
    sources = {s.key: s.source for s in settings(str(path))}
    assert str(sources["saw.kerf"]).endswith("mine.toml:3")
    assert str(sources["drill.x"]).startswith("beamline.toml:")
    assert sources["saw.min_mitre"] is None


@pytest.mark.parametrize("name", shipped())
def test_shipped_machines_load(name: str) -> None:
    machine = load(name)
    assert machine.name == name
    assert machine.title
    keys = [s.key for s in settings(name)]
    assert len(keys) == len(set(keys))


def test_spindles_of_their_own_strokes_are_no_pair_but_two(tmp_path: Path) -> None:
    """Without the pair the same machine is one, and drills the flanges one after the other."""
    path = tmp_path / "m.toml"
    lines = LEFT_OF_A_PAIR.format(start="-clearance", bottom="60")
    path.write_text(f'base = "beamline"\npairs = []\n{lines}')
    made = part(hole(500, 50, 14, "o"), hole(500, 50, 14, "u"))
    operations = plan_bar((made,), load(str(path))).operations
    assert sorted(op.spindle for op in operations if isinstance(op, DrillOp)) == [1, 3]


@pytest.mark.parametrize(
    ("text", "why"),
    [("1 / (height - height)", "division by zero"), ("1e308 * 1e308", "not finite")],
)
def test_a_formula_without_a_value_is_a_fault_of_the_machine(text: str, why: str) -> None:
    formula = as_formula(Formula, text)
    with pytest.raises(MachineError, match="machine-value") as caught:
        formula({"height": 200.0, "y": 1.5})
    (said,) = caught.value.diagnostics
    assert said.message == (
        f"found '{text}' for 'spindles'; expected arithmetic that has a value for height 200, "
        f"y 1.5 ({'float ' if 'zero' in why else ''}{why})"
    )


@pytest.mark.parametrize("name", ["b" * 400, "b" * 400 + ".toml", "x/" * 2000 + "b.toml"])
def test_a_name_that_no_file_can_have(name: str) -> None:
    with pytest.raises(MachineError) as caught:
        load(name)
    assert caught.value.diagnostics[0].code == "machine-unknown"


@pytest.mark.parametrize(("text", "line", "key"), [
    ("[layout]\nmax_bar = 100\n", 3, "layout.min_bar"),
    ("spindles = []\n", 2, "pairs.0.faces"),
    ("title = 'ours'\ndrill = false\n", 3, "spindles.0"),
    ('controller = "linuxcnc"\n', None, "words.change"),
    ('codes = {"G59.1" = "none"}\nspindles = []\n', 3, "pairs.0.faces"),
])  # fmt: skip
def test_a_shipped_file_is_never_blamed_for_what_ones_own_says(
    text: str, line: int | None, key: str, tmp_path: Path
) -> None:
    """The contradiction shows at a key of the base; the fault is in the file that brought it."""
    own = tmp_path / "mine.toml"
    own.write_text(f'base = "beamline"\n{text}', encoding="utf-8")
    with pytest.raises(MachineError) as caught:
        load_tested(str(own))
    said = caught.value.diagnostics[0]
    assert key in said.message
    assert (said.source.file, said.source.line) == (str(own), line)
