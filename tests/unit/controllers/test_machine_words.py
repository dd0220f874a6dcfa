"""Words of machine files, tried on their controllers: what none would take is told at its line."""

from pathlib import Path

import pytest

import beamcam
from beamcam.arguments import load_machine
from beamcam.controllers import table_events
from beamcam.controllers.machine_words import word_faults
from beamcam.errors import MachineError
from beamcam.machine import load, shipped
from tests.conftest import SAMPLES
from tests.runs import call

DRILL = [
    "M40 K{spindle} L{diameter}", "G00 X{x} Y{y} Z{z}", "G00 X{x} Y{near_y} Z{near_z}",
    "M03 K{speed}", "M08", "G01 X{x} Y{bottom_y} Z{bottom_z} F{feed}", "G00 X{x} Y{y} Z{z}",
    "M09", "M05",
]  # fmt: skip


def drill(old: str, *new: str) -> str:
    """The template of a stroke with one line changed."""
    at = DRILL.index(old)
    return f"drill = {[*DRILL[:at], *new, *DRILL[at + 1 :]]}"


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_machine_passes(name: str) -> None:
    assert word_faults(load(name)) == ()


#: What is laid over the words of a machine, and what is said of it.
BAD = [
    ("beamline", "saw = ['G00 X{x}', 'M2.5 K{angle}']",
     "in 'words.saw', found 'M2.5'; expected a whole number behind M"),
    ("beamline", "saw = ['G-99 X{x}', 'M42 K{angle}']",
     "in 'words.saw', found 'G-99'; expected a whole number behind G"),
    ("beamline", "saw = ['G10 X{x}', 'M42 K{angle}']",
     "in 'words.saw', found G10; expected G00 to G04, G06, G08, G09, G40 to G42"),
    ("beamline", "saw = ['G00 X{x} (left']", "expected a comment that begins and ends on its line"),
    ("beamline", "saw = ['G00 X{x}']", "in 'words.saw', found no cut; expected an M word with {an"),
    ("beamline", "footer = ['%']",
     "in 'words.footer', found the end of the program; expected"),
    ("beamline", "header = ['% {job}', 'G43']", "in 'words.header', found G43"),
    ("beamline", "comment = '; {text}'", "in 'words.comment', found ';'"),
    ("beamline", "change = ['M03 K{spindle}']",
     "in 'words.change', found M03 for change; expected another word, as that one stands for on"),
    ("beamline", "header = ['M44 K{width} L{height}', 'M44 K{section}']",
     "in 'words.header', found M44 for section (section); expected another word, as that"),
    ("beamline", drill("M09", "M90"), "in 'words.drill', found the coolant left on; expected M09"),
    ("beamline", drill("M05", "M50"), "in 'words.drill', found the spindle left turning"),
    ("beamline", drill("M03 K{speed}"), "in 'words.drill', found a feed with the spindle at rest"),
    ("beamline", drill(DRILL[5]), "in 'words.drill', found no feed into the steel"),
    ("beamline", drill(DRILL[0]), "in 'words.drill', found no choice of a spindle"),
    ("beamline", drill(DRILL[5], DRILL[5].removesuffix(" F{feed}")),
     "in 'words.drill', found a feed without an F word; expected F{feed}, as other templates have"),
    ("beamline", "saw = ['G01 X{x}', 'M42 K{angle}']",
     "in 'words.saw', found a feed without an F word; expected F{feed}"),
    ("beamline", f"drill = {[*DRILL[:6], *DRILL[7:]]}",
     "in 'words.drill', found the spindle stopped in the steel"),
    ("beamline", f"drill = {[*DRILL[:3], *DRILL[4:6], *DRILL[7:8]]}", "in 'words.drill'"),
    ("beamline", f"drill = {DRILL[:4] + ['M50'] * 65 + DRILL[4:]}", "found 65 M words in a row"),
    ("beamline-pusher", "scribe_end = []", "template"),
    ("beamline-pusher", "mill_end = ['M09', 'M05']",
     "in 'words.mill_end', found the spindle stopped in the steel"),
    ("beamline-pusher", "punch = ['M48 K{spindle}', 'G01 Y{bottom_y} Z{bottom_z} F{feed}']",
     "in 'words.punch', found the tool left in the steel; expected a move to {y} and {z}"),
    ("plate-linuxcnc", "mark_on = ['M32 P1', 'F{feed}']",
     "in 'words.mark_on', found M32, which beamcam does not know; expected codes.M32"),
    ("plate-linuxcnc", "arc_cw = ['G30 X{x} Y{y} I{i} J{j}']",
     "in 'words.arc_cw', found G30, which beamcam does not know; expected none"),
    ("plate-linuxcnc", "header = ['%', '({job})', 'G21 G17 G90 G91.1 G40', 'G64 P0.01']",
     "in 'words.header', found a move before G94; expected it to be set at the beginning"),
    ("plate-linuxcnc", "footer = ['G0 X0 Y0', '%']",
     "in 'words.footer', found the end of the program"),
    ("plate-linuxcnc", "footer = ['G0 X0 Y-9', 'M2', '%']",
     "in 'words.footer', found a move to X 0, Y -9; expected one within the table of 3000 x 1500"),
    ("plate-linuxcnc", "feed = ['(MSG,x)']", "in 'words.feed', found no move; expected one to {x}"),
    ("plate-linuxcnc", "cut_on = ['', 'G4 P{pierce}', 'F{feed}']",
     "in 'words.cut_on', found no M word; expected one that switches the tool on"),
    ("plate-linuxcnc", "left = ['G43.3 D{kerf}']", "in 'words.left', found G43.3"),
    ("beamline", 'footer = ["M30\\nG77", "%"]',
     "in 'words.footer', found a block behind the end of the program"),
    ("laser-grbl", "cut_on = ['M62 P1']", "in 'words.cut_on', found M62"),
    ("laser-grbl", f"comment = '({{text}} {'x' * 80})'", "expected at most 79 characters"),
    ("plate-codesys", "parabola = ['G07 X{x} Y{y} I{i} J{j}']",
     "in 'words.parabola', found G07; expected G00 to G04, G06, G08, G09, G40 to G42"),
    ("plate-codesys", "modal = ['F{feed}', 'Q{acceleration}']",
     "in 'words.modal', found Q behind G01"),
    ("plate-codesys", "cut_on = ['M03', 'G04 P{pierce}']", "in 'words.cut_on', found G04"),
    ("plate-linuxcnc", "feed = ['G0 X{x} Y{y}']",
     "in 'words.feed', found a traverse; expected a move at the feed, such as G1"),
    ("plate-linuxcnc", "mark_on = ['M3 $1 S1', 'x{feed}']",
     "in 'words.mark_on', found a move to X 600, Y 0; expected the tool switched where it stands"),
    ("table-simotion", "[triggers]\naxes = ['answer', 'AxisY']",
     "in 'triggers', found the name answer twice; expected it once"),
]  # fmt: skip


def written(tmp_path: Path, base: str, words: str) -> Path:
    path = tmp_path / "mine.toml"
    table = words if words.startswith("[t") else f"# the words\n[words]\n{words}"
    path.write_text(f'base = "{base}"\n{table}\n')
    return path


@pytest.mark.parametrize(("base", "words", "said"), BAD)
def test_what_a_controller_does_not_take_is_a_fault_of_the_file(
    base: str, words: str, said: str, tmp_path: Path
) -> None:
    path = written(tmp_path, base, words)
    with pytest.raises(MachineError) as caught:
        load_machine(str(path))
    (first, *_) = caught.value.diagnostics
    assert said in first.message
    assert first.source.file == str(path)
    assert first.source.line in (2, 4) or "'triggers'" in said


@pytest.mark.parametrize("name", ["plate-linuxcnc", "laser-grbl"])
def test_an_m_word_of_400_digits_is_told(name: str) -> None:
    _, said = table_events(f"M{'9' * 400}\n", load(name), "long.ngc")
    assert any("expected a number of a few digits" in one.message for one in said)


#: A shop's own words, which mean nothing to beamcam but are the machine's.
OWN = [
    ("beamline", "footer = ['M81', 'G04 T2', 'M30', '%']"),
    ("beamline", drill("M08", "M77 Q{speed}", "M08", "(cooled) M78")),
    ("beamline", "header = ['% {job}', '(hall 2)', 'M71', 'M44 K{width} L{height}', "
     "'M43 K{section}']"),
    ("beamline", "change = ['M00']"),
    ("plate-codesys", "cut_on = ['M103 K2', 'G04 T{pierce}']\ncut_off = ['M105']"),
    ("plate-linuxcnc", "cut_on = ['M3 S{power} (arc)', 'G4 P{pierce}', 'F{feed}']"),
    ("plate-linuxcnc", "parabola = []\nleft = []\nright = []\nstraight = []"),
    ("plate-linuxcnc", "feed = ['G1 X{x:>9} Y{y:>9}']"),
    ("laser-grbl", "cut_on = ['M3 S{power}', 'F{feed}']"),
]  # fmt: skip


@pytest.mark.parametrize(("base", "words"), OWN)
def test_words_of_a_shop_pass(base: str, words: str, tmp_path: Path) -> None:
    assert word_faults(load_machine(str(written(tmp_path, base, words)))) == ()


def test_the_line_is_that_of_the_word(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    lines = "".join(f'    "{line}",\n' for line in DRILL)
    path.write_text(f'base = "beamline"\n\n[words]\ndrill = [\n{lines}]\n'.replace("M09", "M9.9"))
    with pytest.raises(MachineError) as caught:
        load_machine(str(path))
    assert [(d.code, d.source.line) for d in caught.value.diagnostics] == [("machine-word", 12)]


def test_commands_and_library_say_so(tmp_path: Path) -> None:
    path, sample = written(tmp_path, *BAD[0][:2]), SAMPLES / "dstv" / "channel.nc1"
    out = tmp_path / "o.gcode"
    for words in (
        ["machines", "show", str(path)],
        ["post", str(sample), "--machine", str(path), "-o", str(out)],
        ["plan", str(sample), "--machine", str(path)],
    ):
        result = call(*words, status=1)
        assert "error machine-word: in 'words.saw', found 'M2.5'" in result.stderr
    assert not out.exists()
    with pytest.raises(MachineError, match=r"in 'words.saw', found 'M2\.5'"):
        beamcam.post(beamcam.read(sample).parts, path)
