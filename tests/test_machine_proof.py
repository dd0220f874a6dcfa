"""Machine files are proved by a small part: what their words make of it is read back."""

from collections.abc import Iterator
from pathlib import Path
from zlib import crc32

import pytest
from msgspec.structs import replace

from beamcam.arguments import load_machine, load_tested
from beamcam.errors import MachineError
from beamcam.machine import load
from beamcam.machine.load import SHIPPED, _checked, files_of_machine, is_proved, shipped
from beamcam.machine.proved import PROVED
from beamcam.self_test import proof_faults
from tests.conftest import ROOT, Golden

TABLE = ROOT / "beamcam" / "machine" / "proved.py"
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


@pytest.fixture
def unproved(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """As if no machine were known to be proved."""
    with monkeypatch.context() as patch:
        for name in tuple(PROVED):
            patch.delitem(PROVED, name)
        _checked.cache_clear()  # type: ignore[attr-defined]
        yield
    _checked.cache_clear()  # type: ignore[attr-defined]


@pytest.mark.usefixtures("unproved")
@pytest.mark.parametrize("name", shipped())
def test_the_shipped_machines_are_proved(name: str) -> None:
    assert proof_faults(load_machine(name)) == ()


def test_what_is_proved_is_known_by_its_text(golden: Golden) -> None:
    """A shipped file that was edited where it is installed is checked like one's own."""
    rows = []
    for name in shipped():
        texts = "".join(file.text for file in files_of_machine(name))
        rows.append(f'    "{name}": "{crc32(texts.encode()):08x}",\n')
    text = TABLE.read_text(encoding="utf-8")
    head, _, _ = text.partition("PROVED = {\n")
    golden.check(TABLE, f"{head}PROVED = {{\n{''.join(rows)}}}\n")


def test_an_edited_file_is_not_proved(tmp_path: Path) -> None:
    path = tmp_path / "beamline.toml"
    text = (SHIPPED / "beamline.toml").read_text(encoding="utf-8")
    path.write_text(text, encoding="utf-8")
    assert is_proved(files_of_machine(str(path)))
    path.write_text(text.replace("kerf = 4.04", "kerf = 4.05"), encoding="utf-8")
    assert not is_proved(files_of_machine(str(path)))


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
