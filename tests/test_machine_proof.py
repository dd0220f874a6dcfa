"""Machine files are proved by a small part: what their words make of it is read back."""

from pathlib import Path

import pytest
from msgspec.structs import replace

from beamcam.arguments import load_tested
from beamcam.errors import MachineError
from beamcam.machine import load
from beamcam.machine.load import SHIPPED, shipped
from beamcam.self_test import proof_faults

#: A machine, a word of its file and another that stands there, the key and what is found.
WRONG = [
    ("beamline-annex", '"M44 K{height}', '"M44{height}', "words.header", "found M44"),
    ("beamline-annex", '"G90", "M44', '"M03", "M44', "words.header", "a spindle that starts"),
    ("beamline-annex", "G01 X{x} Y{y} Z{z}", "(MSG,x)", "words.saw", "the spindle turning"),
    ("beamline-annex", "G01 X{x} Y{y} Z{z}", "G01 X{x} Y{z} Z{z}", "words.saw", "drawn back"),
    ("beamline-annex", '"G01 X{x}", "M41', '"", "M41', "words.saw", "found a cut"),
    ("beamline", '"G00 X{x}", "M42', '"G01 X{x}", "M42', "words.saw", "without a feed"),
    ("plate-linuxcnc", 'comment = "({text})"', 'comment = ""', "words.comment", "found ''"),
    ("beamline", 'comment = "({text})"', 'comment = "(made here)"', "words.comment", "made here"),
    ("plate-linuxcnc", '"G0 X0 Y0", "M2"', '"G1 X0 Y0", "M2"', "words.footer", "the tool off"),
    ("plate-linuxcnc", '"G0 X0 Y0", "M2"', '"G90 X0 Y0", "M2"', "words.footer", "an arc"),
]


@pytest.mark.parametrize("name", shipped())
def test_the_shipped_machines_are_proved(name: str) -> None:
    assert proof_faults(load(name)) == ()


@pytest.mark.parametrize(("name", "old", "new", "key", "said"), WRONG)
def test_words_that_no_program_could_have(
    name: str, old: str, new: str, key: str, said: str, tmp_path: Path
) -> None:
    text = (SHIPPED / f"{name}.toml").read_text()
    assert old in text
    path = tmp_path / "mine.toml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(MachineError) as raised:
        load_tested(str(path))
    (one,) = raised.value.diagnostics
    assert (one.code, one.source.file) == ("machine-word", str(path))
    assert f"in {key!r}" in one.message
    assert said in one.message


def test_a_machine_that_makes_no_such_part_is_not_refused_for_it() -> None:
    machine = load("beamline")
    assert machine.saw is not None
    assert proof_faults(replace(machine, saw=replace(machine.saw, max_height=1.0))) == ()


@pytest.mark.parametrize("name", ["plate-codesys", "plate-linuxcnc"])
def test_leads_of_a_machine_without_small_arcs_are_chords(name: str) -> None:
    """The first of them lies on the contour, and is no overcut."""
    machine = load(name)
    assert machine.torch is not None
    assert proof_faults(replace(machine, torch=replace(machine.torch, min_radius=5.0))) == ()
