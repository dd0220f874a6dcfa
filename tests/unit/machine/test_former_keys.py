"""Keys of the version before: read, told with their present name, never two values for one key."""

from pathlib import Path

import pytest

import beamcam
from beamcam.errors import MachineError
from beamcam.machine import load, shipped
from beamcam.machine.keys import machine_keys
from beamcam.machine.overlay import former_name, with_present_keys
from tests.runs import call

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
