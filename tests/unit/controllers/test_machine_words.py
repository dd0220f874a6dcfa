"""Words of machine files, tried on their controllers: what none would take is told at its line."""

from pathlib import Path

import pytest
from click.testing import CliRunner

import beamcam
from beamcam.cli import main
from beamcam.controllers import table_events
from beamcam.controllers.machine_words import load_machine, word_faults
from beamcam.errors import MachineError
from beamcam.machine import load, shipped
from tests.conftest import SAMPLES

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
     "found 'M2.5' in 'words.saw'; expected a whole number behind M"),
    ("beamline", "saw = ['G-99 X{x}', 'M42 K{angle}']",
     "found 'G-99' in 'words.saw'; expected a whole number behind G"),
    ("beamline", "saw = ['G10 X{x}', 'M42 K{angle}']",
     "found G10 in 'words.saw'; expected G00 to G04, G06, G08, G09, G40 to G42"),
    ("beamline", "saw = ['G00 X{x} (left']", "expected a comment that begins and ends on its line"),
    ("beamline", "saw = ['G00 X{x}']", "found no cut in 'words.saw'; expected an M word with {ang"),
    ("beamline", "footer = ['%']",
     "found the end of the program in 'words.footer'; expected"),
    ("beamline", "header = ['% {job}', 'G43']", "found G43 in 'words.header'"),
    ("beamline", "comment = '; {text}'", "found ';' in 'words.comment'"),
    ("beamline", "change = ['M03 K{spindle}']",
     "found M03 for change in 'words.change'; expected another word, as that one stands for on"),
    ("beamline", "header = ['M44 K{width} L{height}', 'M44 K{section}']",
     "found M44 for section (section) in 'words.header'; expected another word, as that"),
    ("beamline", drill("M09", "M90"), "found the coolant left on in 'words.drill'; expected M09"),
    ("beamline", drill("M05", "M50"), "found the spindle left turning in 'words.drill'"),
    ("beamline", drill("M03 K{speed}"), "found a feed with the spindle at rest in 'words.drill'"),
    ("beamline", drill(DRILL[5]), "found no feed into the steel in 'words.drill'"),
    ("beamline", drill(DRILL[0]), "found no choice of a spindle in 'words.drill'"),
    ("beamline", drill(DRILL[5], DRILL[5].removesuffix(" F{feed}")),
     "found a feed without an F word in 'words.drill'; expected F{feed}, as other templates have"),
    ("beamline", "saw = ['G01 X{x}', 'M42 K{angle}']",
     "found a feed without an F word in 'words.saw'; expected F{feed}"),
    ("beamline", f"drill = {[*DRILL[:6], *DRILL[7:]]}",
     "found the spindle stopped in the steel in 'words.drill'"),
    ("beamline", f"drill = {[*DRILL[:3], *DRILL[4:6], *DRILL[7:8]]}", "in 'words.drill'"),
    ("beamline", f"drill = {DRILL[:4] + ['M50'] * 65 + DRILL[4:]}", "found 65 M words in a row"),
    ("beamline-pusher", "scribe_end = []", "template"),
    ("beamline-pusher", "mill_end = ['M09', 'M05']",
     "found the spindle stopped in the steel in 'words.mill_end'"),
    ("beamline-pusher", "punch = ['M48 K{spindle}', 'G01 Y{bottom_y} Z{bottom_z} F{feed}']",
     "found the tool left in the steel in 'words.punch'; expected a move to {y} and {z}"),
    ("plate-linuxcnc", "mark_on = ['M32 P1', 'F{feed}']",
     "found M32 in 'words.mark_on'; expected an M word that LinuxCNC knows: M2, M3, M4, M5"),
    ("plate-linuxcnc", "arc_cw = ['G30 X{x} Y{y} I{i} J{j}']",
     "found G30 in 'words.arc_cw'; expected a G word that LinuxCNC knows here: G0, G1, G2, G3, G4"),
    ("plate-linuxcnc", "header = ['%', '({job})', 'G21 G17 G90 G91.1 G40', 'G64 P0.01']",
     "found a move before G94 in 'words.header'; expected it to be set at the beginning"),
    ("plate-linuxcnc", "footer = ['G0 X0 Y0', '%']",
     "found the end of the program in 'words.footer'"),
    ("plate-linuxcnc", "footer = ['G0 X0 Y-9', 'M2', '%']",
     "found a move to X 0, Y -9 in 'words.footer'; expected one within the table of 3000 x 1500"),
    ("plate-linuxcnc", "feed = ['(MSG,x)']", "found no move in 'words.feed'; expected one to {x}"),
    ("plate-linuxcnc", "cut_on = ['', 'G4 P{pierce}', 'F{feed}']",
     "found no M word in 'words.cut_on'; expected one that switches the tool on"),
    ("plate-linuxcnc", "left = ['G43.1 D{kerf}']", "found G43.1 in 'words.left'"),
    ("beamline", 'footer = ["M30\\nG77", "%"]',
     "found a block behind the end of the program in 'words.footer'"),
    ("laser-grbl", "cut_on = ['M62 P1']", "found M62 in 'words.cut_on'; expected an M word"),
    ("laser-grbl", f"comment = '({{text}} {'x' * 80})'", "expected at most 79 characters"),
    ("plate-codesys", "parabola = ['G07 X{x} Y{y} I{i} J{j}']",
     "found G07 in 'words.parabola'; expected G00 to G04, G06, G08, G09, G40 to G42"),
    ("plate-codesys", "modal = ['F{feed}', 'Q{acceleration}']",
     "found Q behind G01 in 'words.modal'"),
    ("plate-codesys", "cut_on = ['M03', 'G04 P{pierce}']", "found G04 in 'words.cut_on'"),
    ("plate-linuxcnc", "feed = ['G0 X{x} Y{y}']",
     "found a traverse in 'words.feed'; expected a move at the feed, such as G1"),
    ("plate-linuxcnc", "mark_on = ['M3 $1 S1', 'x{feed}']",
     "found a move to X 600, Y 0 in 'words.mark_on'; expected the tool switched where it stands"),
    ("table-simotion", "[triggers]\nmax_late_s = 0.0001",
     "found fault 4 in 'triggers'; expected work to its end"),
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
        result = CliRunner().invoke(main, words)
        assert result.exit_code == 1, result.output
        assert "error machine-word: found 'M2.5' in 'words.saw'" in result.stderr
    assert not out.exists()
    with pytest.raises(MachineError, match=r"found 'M2\.5' in"):
        beamcam.post(beamcam.read(sample).parts, path)
