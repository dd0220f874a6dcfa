"""Programs for QtPlasmaC: its own filter takes every line, and rs274 makes the moves of each."""

import re
from pathlib import Path

import pytest

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.machine import load
from beamcam.pipeline import post
from tests.conftest import SAMPLES, sampled
from tests.qtplasmac import filtered, needs_filter
from tests.rs274 import INI, interpreted, needs_rs274
from tests.runs import call
from tests.unit.sheets.parts import NESTED

#: Samples that a plasma table makes.
PLATES = (
    "dstv/gusset.nc1", "dstv/lettered.nc1", "dstv/plate.nc1", "dxf/plate.dxf", "dxf/layers.dxf",
    "dxf/gasket-inch.dxf", "json/cam.json", "json/curves.json", "svg/corel-x6.svg",
)  # fmt: skip
TOOLS = "T1 P1 X40 Y-20 Z0 D1 ;scribe\n"
MOVE = re.compile(r"^[Gg][0123](?=\s*[XxYy])")


def posted(sample: str, tmp_path: Path, machine: str = "plate-qtplasmac") -> Path:
    out = tmp_path / "program.ngc"
    words = ["post", str(SAMPLES / sample), "--machine", machine, "-o", str(out)]
    drawn = sample.startswith(("dxf", "svg"))
    call(*words, *(["--thickness", "3"] if drawn else []), status=0)
    return out


def moves(text: str) -> list[str]:
    """The blocks of moves in X and Y, without blanks."""
    return [
        line.replace(" ", "").casefold() for line in text.splitlines() if MOVE.match(line)
    ]  # fmt: skip


@needs_filter
@pytest.mark.parametrize("sample", sampled(PLATES, 2))
def test_the_filter_of_the_controller_takes_every_line(sample: str, tmp_path: Path) -> None:
    program = posted(sample, tmp_path)
    before = program.read_text()
    done = filtered(program, tmp_path / "filter")
    lines = before.splitlines()
    # It tells that a scribe moves faster than the torch cuts; nothing else is odd to it.
    marked = [k for k, line in enumerate(lines, 1) if line.startswith("M3 $1")]
    assert set(done.faults) <= {k + 1 for k in marked}
    assert "end program" not in done.text
    assert moves(done.text) == moves(before)
    assert "m190 p1000000\nm66 p3 l3 q1\n" in done.text  # the comment became a material
    assert len(re.findall(r"^m3\$0s1$", done.text, re.MULTILINE)) == before.count("M3 $0 S1")


@needs_filter
def test_the_filter_sees_what_is_wrong(tmp_path: Path) -> None:
    """That it passes the programs above says something."""
    program = posted("dstv/gusset.nc1", tmp_path)
    sound = filtered(program, tmp_path / "filter")
    text = program.read_text()
    for old, new in (
        ("G0 X50 Y150\n", ""), ("(o=0,", "(o=1,"), ("F2300", "F1300"), ("pd=0.5", "pd=x"),
    ):  # fmt: skip
        assert old in text
        program.write_text(text.replace(old, new, 1))
        broken = filtered(program, tmp_path / "filter")
        assert set(broken.faults) > set(sound.faults), old


@needs_rs274
@pytest.mark.parametrize("sample", PLATES)
def test_rs274_takes_every_program(sample: str, tmp_path: Path) -> None:
    program = posted(sample, tmp_path)
    done = interpreted(program, ini=INI, tools=TOOLS)
    assert "error" not in (done.stdout + done.stderr).casefold(), done.stderr
    text = program.read_text()
    feeds = len([m for m in moves(text) if not m.startswith("g0")])
    assert len(re.findall(r"(?:STRAIGHT|ARC)_FEED\(", done.stdout)) >= feeds
    assert "PROGRAM_END" in done.stdout


@needs_rs274
def test_the_scribe_is_brought_to_its_line_by_its_own_offset(tmp_path: Path) -> None:
    """rs274 changes to tool 1 and its offset before the traverse to a mark, and back likewise."""
    program = posted("dstv/gusset.nc1", tmp_path)
    said = interpreted(program, ini=INI, tools=TOOLS).stdout
    steps = re.findall(
        r"(CHANGE_TOOL|USE_TOOL_LENGTH_OFFSET|STRAIGHT_TRAVERSE|START_SPINDLE_\w+\(\d\))", said
    )
    assert steps[:8] == [
        "CHANGE_TOOL", "USE_TOOL_LENGTH_OFFSET", "STRAIGHT_TRAVERSE",
        "START_SPINDLE_CLOCKWISE(1)", "CHANGE_TOOL", "USE_TOOL_LENGTH_OFFSET",
        "STRAIGHT_TRAVERSE", "START_SPINDLE_CLOCKWISE(0)",
    ]  # fmt: skip


#: What a wrong program has in place of the right one, and the code that refuses it.
MUTANTS = [
    ("ph=3.8", "ph=2.8", "verify-sheet-material"),
    ("fr=2300", "fr=2000", "verify-sheet-material"),
    ("ca=45", "ca=85", "verify-sheet-material"),
    ("kw=1.5", "kw=1.2", "verify-sheet-material"),
    (", ph=3.8", "", "verify-sheet-word"),
    ("pd=0.5", "pd=x", "verify-sheet-word"),
    ("(o=0, ", "(plain, ", "verify-sheet-material"),
    ("T0 M6\nG43 H0\n", "", "verify-sheet-output"),
    ("T1 M6\nG43 H0\n", "", "verify-sheet-output"),
    ("T1 M6\nG43 H0\nG0 X{scribe}\nM3 $1", "G0 X{scribe}\nT1 M6\nG43 H0\nM3 $1",
     "verify-sheet-word"),
    ("M3 $0 S1\nF2300\nG", "M3 $0 S1\nF2300\nM62 P2\nG", "verify-sheet-thc"),
    ("M67 E3 Q60\nM62 P2\n", "M67 E3 Q60\n", "verify-sheet-thc"),
    ("M67 E3 Q60\nM62 P2\n", "M62 P2\n", "verify-sheet-hole-feed"),
    ("M67 E3 Q60\nM62 P2\n", "M67 E3 Q40\nM62 P2\n", "verify-sheet-feed"),
    ("M67 E3 Q0\nM63 P2\nM5 $0\n", "M67 E3 Q0\nM5 $0\n", "verify-sheet-thc"),
    ("M67 E3 Q0\nM63 P2\nM5 $0\n", "M63 P2\nM5 $0\n", "verify-sheet-hole-feed"),
    ("M67 E3 Q60\nM62 P2\n", "", "verify-sheet-hole-feed"),
    ("M68 E3 Q0\nM65 P2\nG0", "M68 E3 Q0\nM64 P2\nG0", "verify-sheet-thc"),
    ("M68 E3 Q0\nM65 P2\nG0", "M68 E3 Q60\nM65 P2\nG0", "verify-sheet-output"),
    ("M68 E3 Q0\nM52", "M68 E3 Q60\nM52", ""),
    ("M52 P1\nM68 E3 Q0", "M52 P1\nM68 E3 Q60", "verify-sheet-feed"),
    ("M3 $0 S1\nF2300\nG", "M3 $0 S1\nF2300\nM67 E3 Q50\nG", "verify-sheet-feed"),
    ("M3 $0 S1\n", "M3 $0 S1\nM64 P7\n", "verify-sheet-tool"),
    ("M3 $0 S1\n", "#<pierce-only>=1\nM3 $0 S1\n", "verify-sheet-word"),
    ("M3 $0 S1\n", "#<holes>=2\nM3 $0 S1\n", "verify-sheet-word"),
    ("M3 $0 S1\n", "o<lift> call [3]\nM3 $0 S1\n", "verify-sheet-word"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "code"), sampled(MUTANTS, 2))
def test_what_differs_from_the_row_is_refused(old: str, new: str, code: str) -> None:
    machine = load("plate-qtplasmac")
    text = post((NESTED,), machine).text
    assert isinstance(text, str)
    assert not verify_sheet(text, (NESTED,), machine)
    scribe = re.search(r"G0 X(\S+ Y\S+)\nM3 \$1", text)
    assert scribe is not None
    old, new = (one.replace("{scribe}", scribe[1]) for one in (old, new))
    if not code:
        assert old not in text
        return
    assert old in text
    said = verify_sheet(text.replace(old, new, 1), (NESTED,), machine)
    assert code in {one.code for one in said}, said


#: The same program as another post or hand would have it.
RIGHT = [
    ("M65 P2\nG0 X0", "M63 P2\nG0 X0"),
    ("M3 $0 S1\nF2300\n", "M3 $0 S1\nF#<_hal[plasmac.cut-feed-rate]>\n"),
    ("G64 P0.1\n", "G64 P0.1\n#<holes>=0\n"),
    ("M3 $0 S1\n", "M62 P2\nM63 P2\nM3 $0 S1\n"),
    ("M68 E3 Q0\nM65 P2\nG0", "M68 E3 Q100\nM65 P2\nG0"),
]


@pytest.mark.parametrize(("old", "new"), RIGHT)
def test_what_means_the_same_is_taken(old: str, new: str) -> None:
    machine = load("plate-qtplasmac")
    text = post((NESTED,), machine).text
    assert isinstance(text, str)
    assert old in text
    assert not verify_sheet(text.replace(old, new), (NESTED,), machine)


def test_corners_are_slow_without_the_height_control(tmp_path: Path) -> None:
    """The words of the share stand within the contour, before and behind each corner."""
    path = tmp_path / "mine.toml"
    path.write_text(
        'base = "plate-qtplasmac"\n[torch]\n'
        "rows = [{process = 'cut', material = 'mild steel', up_to = 12, feed_mm_min = 2000, "
        "kerf = 1.5, corner_share = 0.5, corner_distance = 4}, "
        "{process = 'mark', up_to = 12, feed_mm_min = 3000}]\n"
    )
    machine = load(str(path))
    text = post((NESTED,), machine).text
    assert isinstance(text, str)
    assert text.count("M67 E3 Q50\nM62 P2\n") == text.count("M67 E3 Q0\nM63 P2\n") == 8
    slow = text.index("M67 E3 Q50\nM62 P2\n")
    held = text[:slow] + text[slow:].replace("M62 P2\n", "", 1)
    assert "verify-sheet-thc" in {one.code for one in verify_sheet(held, (NESTED,), machine)}


def test_a_material_may_be_chosen_by_its_number(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        'base = "plate-qtplasmac"\n[torch]\n'
        "rows = [{process = 'cut', material = 'mild steel', up_to = 12, feed_mm_min = 2000, "
        "kerf = 1.5, number = 5}, {process = 'mark', up_to = 12, feed_mm_min = 3000}]\n"
        '[words]\nmaterial = ["M190 P{number}", "M66 P3 L3 Q1"]\n'
        'cut_on = ["M3 $0 S1", "F{feed}"]\n'
    )
    machine = load(str(path))
    text = post((NESTED,), machine).text
    assert isinstance(text, str)
    assert text.count("M190 P5\nM66 P3 L3 Q1\n") == 1
    said = verify_sheet(text.replace("M190 P5", "M190 P4"), (NESTED,), machine)
    assert {one.code for one in said} == {"verify-sheet-material"}
    assert "number 4; expected 5" in said[0].message


DARK = """base = "plate-qtplasmac"
[torch]
overcut = 4
lead_out = 0
[words]
close = ["M62 P3"]
cut_off = ["M5 $0", "M65 P3"]
"""


def test_the_overcut_is_run_with_the_arc_out(tmp_path: Path) -> None:
    """The blocks behind M62 P3 lie on the contour that is cut already, 4 mm long."""
    path = tmp_path / "mine.toml"
    path.write_text(DARK)
    machine = load(str(path))
    text = post((NESTED,), machine).text
    assert isinstance(text, str)
    assert text.count("M62 P3\n") == text.count("M65 P3\n") == text.count("M3 $0") == 4
    assert not verify_sheet(text, (NESTED,), machine)
    last = text.rindex("M62 P3\n")
    before, behind = text[:last].splitlines(), text[last:].splitlines()
    moved = [line for line in behind[: behind.index("M5 $0")] if line.startswith("G")]
    ends = [re.search(r"X(\S+) Y(\S+)", line) for line in (before[-1], *moved)]
    (ax, ay), (bx, by) = ((float(m[1]), float(m[2])) for m in (ends[0], ends[-1]) if m)
    assert abs(ax - bx) + abs(ay - by) == pytest.approx(4.0, abs=1e-3)  # along an edge of the box
    for old, new, code in (
        ("M62 P3\n", "", "verify-sheet-dark"), ("M65 P3\n", "", "verify-sheet-output"),
        ("M3 $0 S1\n", "M62 P3\nM3 $0 S1\n", "verify-sheet-output"),
    ):  # fmt: skip
        said = verify_sheet(text.replace(old, new, 1), (NESTED,), machine)
        assert code in {one.code for one in said}, (old, said)
    lines = text.splitlines()
    k = lines.index("M62 P3")
    early = [*lines[: k - 1], lines[k], lines[k - 1], *lines[k + 1 :]]
    said = verify_sheet("\n".join(early), (NESTED,), machine)
    assert "verify-sheet-dark" in {one.code for one in said}
    no_end = text[: text.rindex("M65 P3\n")] + text[text.rindex("M65 P3\n") + 7 :]
    assert "verify-sheet-output" in {d.code for d in verify_sheet(no_end, (NESTED,), machine)}


@needs_filter
def test_the_filter_takes_an_overcut_with_the_arc_out(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(DARK)
    program = posted("dstv/gusset.nc1", tmp_path, str(path))
    done = filtered(program, tmp_path / "filter")
    assert moves(done.text) == moves(program.read_text())
    assert done.text.count("m62p3") == program.read_text().count("M62 P3")
