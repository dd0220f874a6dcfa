"""Wrong keys and values in a machine of one's own: each is told with its file and line."""

import re
from pathlib import Path

import pytest

import beamcam
from beamcam.arguments import load_machine
from beamcam.errors import MachineError
from beamcam.machine import load, shipped
from beamcam.machine.keys import machine_keys
from beamcam.machine.toml import with_present_keys
from tests.conftest import SAMPLES
from tests.runs import call

#: A drill, a saw alone, and a saw and drill; each is a file over the machine before it.
MACHINES = {
    "drill": (SAMPLES / "machines" / "hall-drill.toml").read_text(encoding="utf-8"),
    "saw": 'base = "beamline"\ndrill = false\nspindles = []\npairs = []\ntools = []\n',
    "line": 'base = "beamline"\n',
}
SPINDLE = """
pairs = []
[[spindles]]
name = "a"
number = 1
face = "v"
across = {{ axis = "{axis}", position = "{position}" }}
stroke = {{ axis = "Z", retract = "-clearance", bottom = "face_depth + depth + tip" }}
"""
AXIS = '[[axes]]\nname = "x"\nmoves = "{}"\nspeed = {}\nacceleration = 1\n'
#: What is laid over the machine, and what is said of it.
WRONG = [
    ("sawx = 3", "machine-key: found unknown key 'sawx'; expected 'saw'"),
    ("[[", "machine-toml: found no TOML (Invalid initial character for a key part); expected"),
    ('base = "none-such"', "machine-unknown: found no machine 'none-such'; expected"),
    ("base = 5", "machine-value: found 5 for 'base'; expected a machine's name"),
    ('stock = "sheet"', "error machine-"),
    ('controller = "fanuc"', "machine-value: found 'fanuc' for 'controller'; expected one of"),
    ("layout = false", "machine-missing: found no key 'layout'"),
    ("format = false", "machine-missing: found no key 'format'"),
    ('suffix = "../x"', "machine-value: found '../x' for 'suffix'; expected a dot and letters"),
    ('suffix = ""', "machine-value: found '' for 'suffix'"),
    ('allowed_codes = "G1"', "machine-value: found 'G1' for 'allowed_codes'; expected a list"),
    ('[codes]\nG1 = "none"', "machine-value: found 'G1' for 'codes.G1'; expected another word"),
    ("[sections]\nUU = 2", "machine-value: found 'UU' for 'sections.UU'; expected a DSTV code"),
    ('[layout]\nprofiles = ["Q"]', "machine-value: found 'Q' for 'layout.profiles'; expected"),
    ("[layout]\nmin_bar = 19000", "machine-value: found 19000.0 for 'layout.min_bar'; expected at"),
    ('[layout]\norder = "saw"', "machine-value: found 'saw' for 'layout.order'; expected one of"),
    ("[format]\nlength_decimals = 9", "machine-value: found 9 for 'format.length_decimals'"),
    ("[times]\nsaw_s = nan", "machine-value: found nan for 'times.saw_s'"),
    ('[marks]\ntext = "maybe"', "machine-value: found 'maybe' for 'marks.text'; expected one of"),
    ('[words]\nsaw = "G0"', "machine-value: found 'G0' for 'words.saw'; expected a list"),
    ('[words]\nheader = ["{x}"]', "machine-value: found '{x}' for 'words.header'; expected"),
    (AXIS.format("Q", 1), "machine-value: found 'Q' for 'axes.0.moves'; expected one of"),
    (AXIS.format("X", -1), "machine-value: found -1 for 'axes.0.speed'; expected more than 0"),
    (AXIS.format("X", 1) * 2, "machine-value: found 'X' for 'axes.1.moves'; expected one axis"),
    ('[[tools]]\nkind = "reamer"\ndiameters = [3]', "machine-value: found 'reamer' for"),
    (SPINDLE.format(axis="X", position="y"), "machine-value: found 'X' for"),
    (SPINDLE.format(axis="Y", position="y").replace('"Z"', '"X"'), "machine-value: found 'X' for"),
    (SPINDLE.format(axis="Y", position="y +"), "machine-value: found 'y +' for"),
    (SPINDLE.format(axis="Y", position="yy"), "machine-value: found 'yy' for"),
    (SPINDLE.format(axis="Y", position="y / (y - y)"), "machine-value: found 'y / (y - y)' for"),
    ('[[pairs]]\nname = "p"\nnumber = 9\nfaces = ["v", "v"]', "machine-value: found"),
    (
        SPINDLE.format(axis="Y", position="y") + SPINDLE.format(axis="Y", position="y")[12:],
        "machine-value: found 'v' for 'spindles.1.face'; expected another face than that of 'a'",
    ),
    (
        SPINDLE.format(axis="Y", position="y")
        + SPINDLE.format(axis="Y", position="y")[12:].replace('"v"', '"u"'),
        "machine-value: found 1 for 'spindles.1.number'; expected another number than that of 'a'",
    ),
]


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize(("text", "said"), WRONG, ids=[text.split("\n")[0] for text, _ in WRONG])
def test_what_is_wrong_is_told_with_its_line(
    tmp_path: Path, name: str, text: str, said: str
) -> None:
    (tmp_path / "below.toml").write_text(MACHINES[name])
    own = text if text.startswith("base") else f'base = "below"\n{text}'
    (tmp_path / "own.toml").write_text(own + "\n")
    with pytest.raises(MachineError) as caught:
        load_machine(str(tmp_path / "own.toml"))
    message = str(caught.value)
    assert re.search(r"(own|beamline)\.toml:[1-9]\d*: error machine-", message), message
    assert said in message


# --- keys of former names -------------------------------------------------------------------------


FORMER = """base = "beamline"
[layout]
order = "saw-drill"
least_bar = 1300
[drill]
least_speed_rpm = 160
[[axes]]
name = "stop"
moves = "X"
speed = 100
acceleration = 100
least = 0
greatest = 13000
"""


def _machine(folder: Path, text: str) -> str:
    path = folder / "mine.toml"
    path.write_text(text)
    return str(path)


#: Those that were not called after the least and the greatest.
RENAMED = {
    "drill.same_tool_tolerance": "twin", "times.manual_change_s": "reload_s",
    "stroke.retract": "start", "stroke.approach": "near", "saw.zero_angle": "square",
}  # fmt: skip


def former_name(dotted: str) -> str:
    """A dotted key as it was called in the version before."""
    table, dot, key = dotted.rpartition(".")
    was = re.sub(r"^max(?=_|$)", "greatest", re.sub(r"^min(?=_|$)", "least", key))
    return f"{table}{dot}{RENAMED.get('.'.join(dotted.split('.')[-2:]), was)}"


def test_every_key_that_has_a_former_name_is_read_by_it() -> None:
    """Renaming there and back ends at the key; no two keys of one table share a former name."""
    seen: set[str] = set()
    for key in machine_keys():
        was = former_name(key.name)
        assert with_present_keys(_nested(was))[0] == _nested(key.name)
        assert was not in seen
        seen.add(was)


def _nested(dotted: str) -> dict[str, object]:
    """The tables of a dotted key, with the value 1."""
    value: object = 1
    for word in reversed(dotted.split(".")):
        value = {word: value}
    assert isinstance(value, dict)
    return value


@pytest.mark.parametrize("name", shipped())
def test_shipped_machines_have_no_former_key(name: str) -> None:
    assert load(name).remarks == ()


def test_former_keys_make_the_same_machine_and_are_told(tmp_path: Path) -> None:
    machine = load(_machine(tmp_path, FORMER))
    present = FORMER.replace("least_", "min_").replace("least ", "min ")
    same = load(_machine(tmp_path, present.replace("greatest", "max")))
    assert (machine.layout, machine.drill, machine.axes) == (same.layout, same.drill, same.axes)
    assert (machine.checksum, same.remarks) == (same.checksum, ())
    assert [(d.code, d.source.line) for d in machine.remarks] == [
        ("machine-former-key", 4),
        ("machine-former-key", 6),
        ("machine-former-key", 12),
        ("machine-former-key", 13),
    ]
    assert "found the key 'layout.least_bar' of an older version; expected 'min_bar'" in str(
        machine.remarks[0]
    )


def test_keys_that_changed_their_name_are_told_with_their_place(tmp_path: Path) -> None:
    former = {
        "zero_angle = ": "square = ", "same_tool_tolerance = ": "twin = ",
        "manual_change_s = ": "reload_s = ", "retract = ": "start = ", "approach = ": "near = ",
    }  # fmt: skip
    text = (Path(beamcam.__file__).parent / "machines" / "beamline.toml").read_text()
    for present, was in former.items():
        assert present in text
        text = text.replace(present, was)
    machine, same = load(_machine(tmp_path, text)), load("beamline")
    assert (machine.saw, machine.drill, machine.times) == (same.saw, same.drill, same.times)
    assert (machine.spindles, machine.checksum) == (same.spindles, same.checksum)
    assert len(machine.remarks) == sum(text.count(was) for was in former.values())
    lines = text.splitlines()
    for remark in machine.remarks:
        assert remark.code == "machine-former-key"
        assert remark.source.line is not None
        values = dict(remark.values)
        found = str(values["found"]).rpartition(".")[2]
        assert f"{found} = " in lines[remark.source.line - 1]
        assert former[f"{values['expected']} = "] == f"{found} = "


def test_a_wrong_value_of_a_former_key_is_told_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(MachineError) as caught:
        load(_machine(tmp_path, FORMER.replace("least_bar = 1300", "least_bar = -1")))
    assert caught.value.diagnostics[0].source.line == 4


def test_both_names_of_one_key_are_refused(tmp_path: Path) -> None:
    with pytest.raises(MachineError) as caught:
        load(_machine(tmp_path, FORMER.replace("least_bar", "min_bar = 1\nleast_bar")))
    (said,) = caught.value.diagnostics
    assert (said.code, said.source.line) == ("machine-key-twice", 5)


def test_names_that_the_user_chooses_stay(tmp_path: Path) -> None:
    text = 'base = "laser-grbl"\n[torch.colours]\nleast_one = "cut"\n'
    torch = load(_machine(tmp_path, text)).torch
    assert torch is not None
    assert torch.colours["least_one"] == "cut"


def test_a_command_says_it_once(tmp_path: Path) -> None:
    path = _machine(tmp_path, 'base = "beamline"\n[layout]\nleast_bar = 1300\n')
    part = Path(__file__).parents[3] / "samples" / "dstv" / "M58.nc1"
    part = part if part.exists() else next((part.parents[1]).rglob("*.nc1"))
    out = str(tmp_path / "job.gcode")
    run = call("post", part, "--machine", path, "-o", out)
    assert run.stderr.count("machine-former-key") == 1
    checked = call("machines", "check", path)
    assert (checked.exit_code, checked.stderr.count("machine-former-key")) == (0, 1)
    shown = call("machines", "show", path)
    assert shown.stderr.count("machine-former-key") == 1
    assert "layout.min_bar" in shown.stdout
