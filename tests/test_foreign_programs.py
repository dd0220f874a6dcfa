"""Programs written in the manner of other posts, verified against their drawing.

The plate of `tests/foreign`: 120 x 80 with a hole of 30 mm and a window of 30 x 20, its lower left
corner at 20, 20. Each program has a machine file that says what is its own: how it is begun, what
its words mean, and which letters are not beamcam's matter.
"""

import re
from pathlib import Path

import pytest
from click.testing import Result

from tests.conftest import ROOT
from tests.rs274 import INI, interpreted, needs_rs274
from tests.runs import call

FOREIGN = ROOT / "tests" / "foreign"
PROGRAMS = {
    "sheetcam.ngc": (), "qtplasmac.ngc": (), "freecad.ngc": (), "fusion.ngc": (), "hand.ngc": (),
    "lightburn.gc": ("--material", "wood"),
}  # fmt: skip
_FEED = re.compile(r"(STRAIGHT|ARC)_FEED\(([^)]*)\)")


def verify(program: Path, name: str, machine: Path | None = None) -> Result:
    stem = name.partition(".")[0]
    return call(
        "verify", program, "--against", FOREIGN / "plate.dxf", "--map", "CUT=cut",
        "--thickness", "3",
        "--machine", machine or FOREIGN / f"{stem}.toml", *PROGRAMS[name],
    )  # fmt: skip


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_of_another_post_is_verified(name: str) -> None:
    done = verify(FOREIGN / name, name)
    assert done.exit_code == 0, done.stderr
    assert "error" not in done.stderr
    assert "warning" not in done.stderr


#: What a wrong program has in place of the right one, and the code that it is refused by.
WRONG = {
    "sheetcam.ngc": [
        ("X124.4000\nY69.4000", "X125.4000\nY69.4000", "verify-sheet-"),
        ("M05\nG00 Z12.0000\nX110.0000", "G00 Z12.0000\nX110.0000", "verify-sheet-rapid"),
        ("G00 Z12.0000\nX60.0000", "G00 W12.0000\nX60.0000", "verify-sheet-word"),
    ],
    "qtplasmac.ngc": [
        ("G3 X74.4 Y60 I-14.4 J0", "G2 X74.4 Y60 I-14.4 J0", "verify-sheet-direction"),
        ("M5 $0\nG0 X110", "G0 X110", "verify-sheet-rapid"),
        ("G64 P0.01", "G64 P5", "verify-sheet-corner"),
    ],
    "freecad.ngc": [
        ("G1 X95.600 Y69.400\n", "", "verify-sheet-"),
        ("G43 H1", "G55", "verify-sheet-word"),
        ("G21\n", "", "verify-sheet-setting"),
    ],
    "fusion.ngc": [
        ("N220 G53 G0 Z0.", "N220 G53 G0 X0. Z0.", "verify-sheet-word"),
        ("N150 M3 S1\n", "N150 M3 S1\nM0\n", "verify-sheet-tool"),
        ("F5200.\nN75", "F4200.\nN75", "verify-sheet-feed"),
    ],
    "hand.ngc": [
        ("y100.6", "y100", "verify-sheet-"),
        ("m5\nm0", "m0", "verify-sheet-tool"),
        ("g40 g64", "g92 x0 g64", "verify-sheet-word"),
    ],
    "lightburn.gc": [
        ("G1 X95S900F900", "G1 X95S700F900", "verify-sheet-tool"),
        ("\nM4\n", "\nM3\n", "verify-sheet-tool"),
        ("G0 X125Y70", "G1 X125Y70", "verify-sheet-"),
    ],
}


@pytest.mark.parametrize(
    ("name", "old", "new", "code"),
    [(name, *case) for name, cases in WRONG.items() for case in cases],
)
def test_a_wrong_one_is_refused(name: str, old: str, new: str, code: str, tmp_path: Path) -> None:
    text = (FOREIGN / name).read_text()
    assert text.count(old) == 1
    path = tmp_path / name
    path.write_text(text.replace(old, new))
    done = verify(path, name)
    assert done.exit_code == 1
    assert f"error {code}" in done.stderr


def test_what_is_unknown_is_named_once_with_the_line_that_explains_it(tmp_path: Path) -> None:
    """The file that explains nothing: each word once, and the line of each makes it known."""
    bare = tmp_path / "bare.toml"
    own = (FOREIGN / "qtplasmac.toml").read_text()
    bare.write_text(re.sub(r"\[codes\]\n(.*\n)*?\n", "", own))
    done = verify(FOREIGN / "qtplasmac.ngc", "qtplasmac.ngc", bare)
    said = [line for line in done.stderr.splitlines() if "beamcam does not know" in line]
    lines = [re.search(r'expected codes\.(\w+) = "none"', line)[1] for line in said]  # type: ignore[index]
    assert lines == ["G97", "M190", "M66"]
    bare.write_text(bare.read_text() + "[codes]\n" + "".join(f'{w} = "none"\n' for w in lines))
    assert verify(FOREIGN / "qtplasmac.ngc", "qtplasmac.ngc", bare).exit_code == 0


def test_letters_of_axes_are_explained_too(tmp_path: Path) -> None:
    bare = tmp_path / "bare.toml"
    bare.write_text((FOREIGN / "sheetcam.toml").read_text().replace('[codes]\nZ = "none"\n', ""))
    done = verify(FOREIGN / "sheetcam.ngc", "sheetcam.ngc", bare)
    assert done.exit_code == 1
    (line,) = [line for line in done.stderr.splitlines() if "does not know" in line]
    assert 'found Z, which beamcam does not know; expected codes.Z = "none"' in line
    assert 'or torch.z = "program", where the program moves the torch up and down' in line


@pytest.mark.parametrize("code", ["G92", "G52", "G10", "G28"])
def test_what_shifts_places_cannot_be_explained_away(code: str, tmp_path: Path) -> None:
    path = tmp_path / "hand.ngc"
    path.write_text((FOREIGN / "hand.ngc").read_text().replace("g40 g64", f"{code} g40 g64"))
    done = verify(path, "hand.ngc")
    assert f"found {code}, which beamcam does not know; expected none, it shifts" in done.stderr


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ('startup_code = "G17 G187"', "in 'startup_code', found G187, which beamcam does not know"),
        ('startup_code = "T="', "in 'startup_code'"),
        ('[codes]\nX = "none"', "found 'X' for 'codes.X'"),
        ('[codes]\nM30 = "none"', "found 'M30' for 'codes.M30'"),
    ],
)
def test_a_file_that_explains_what_it_may_not(line: str, found: str, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text(f'base = "plate-linuxcnc"\n{line}\n')
    done = verify(FOREIGN / "hand.ngc", "hand.ngc", own)
    assert done.exit_code == 1
    assert found in done.stderr


@needs_rs274
@pytest.mark.parametrize("name", [name for name in PROGRAMS if name.endswith(".ngc")])
def test_linuxcnc_runs_them_to_the_same_corners(name: str, tmp_path: Path) -> None:
    """The words of a user's own (M100 to M199) and inputs are not there where it runs alone."""
    text = re.sub(r"(?m)^M(190|66) .*\n", "", (FOREIGN / name).read_text())
    path = tmp_path / name
    path.write_text(text)
    done = interpreted(path, ini=INI.replace("[RS274NGC]\n", "[RS274NGC]\nRS274NGC_STARTUP_CODE = "
                                             "G17 G21 G40 G90 G91.1 G94\n"),
                       tools="T1 P1 D1.2\n")  # fmt: skip
    assert done.returncode == 0, done.stderr
    ends = set()
    for kind, values in _FEED.findall(done.stdout):
        numbers = [float(value) for value in values.split(",")]
        ends.add((round(numbers[0], 1), round(numbers[1], 1)))
        assert kind in ("STRAIGHT", "ARC")
    for corner in ((124.4, 50.6), (124.4, 69.4), (95.6, 69.4), (95.6, 50.6), (74.4, 60.0)):
        assert corner in ends
