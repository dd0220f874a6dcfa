"""What programs make, kind by kind, and every message of `beamcam recover`."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from msgspec.structs import replace

from beamcam import readers
from beamcam.cli import main
from beamcam.comparison.parts import diff_parts
from beamcam.errors import Source
from beamcam.geometry.curves import Line
from beamcam.machine import Machine, load
from beamcam.model.part import Contour, EndCuts, Feature, Hole, Part, Slot
from beamcam.pipeline import post
from beamcam.recovery import KnownStock, recover, with_marks
from beamcam.recovery.rules import (
    CATALOGUE,
    CROWDED,
    FACES,
    FITTED,
    KERF,
    NO_PIECE,
    PATH,
    PROFILE,
    SHEET,
)
from tests.conftest import SAMPLES
from tests.strategies import BEAM
from tests.unit.sheets.parts import box, circle, contour, drawing, table

S = Source("p.nc1", 1)
SINK = (Hole("v", 400, 150, 14, S), Hole("v", 400, 150, 25, S, None, "countersink", 90.0))
LINES = (Line((900.0, 100.0), (1000.0, 100.0)), Line((1000.0, 100.0), (1000.0, 180.0)))


def bar(*features: Feature, length: float = 1500.0, cuts: EndCuts = EndCuts()) -> Part:  # noqa: B008
    return Part("P", BEAM, length, S, features=features, cuts=cuts)


def shape(part: Part) -> list[Feature]:
    """The features of a part wherever they stand."""
    return [replace(f, source=S) for f in part.features]


def work(text: str) -> list[str]:
    """The blocks of a program, without comments: no block says what its part is called."""
    return [line for line in text.splitlines() if not line.startswith("(")]


@pytest.mark.parametrize(
    "features",
    [
        (Hole("v", 300, 150, 12, S, None, "thread"),),
        (Hole("v", 300, 150, 12, S, 4.0, "blind"),),
        (Hole("o", 500, 30, 16, S), Hole("u", 500, 30, 16, S)),
        SINK,
        (Hole("v", 600, 150, 3.0, S, None, "mark"),),
        (Hole("v", 800, 150, 60, S),),
        (Contour("v", "open", LINES, S, "punch", False),),
        (Slot("v", 1150, 150, 18, 30, 0, 30, S),),
        (Slot("v", 1150, 150, 22, 60, 40, 0, S, 3.0, "blind"),),
    ],
    ids=["thread", "blind", "pair", "sink", "punch mark", "milled", "line", "slot", "pocket"],
)
def test_each_kind_comes_back_as_it_was(features: tuple[Feature, ...]) -> None:
    machine = load("beamline-pusher")
    text = post((bar(*features),), machine).text
    found = recover(text, machine, "p", KnownStock(BEAM))
    assert found.diagnostics == ()
    (part,) = found.parts
    assert shape(part) == list(features)
    assert part.length == 1500.0
    assert work(post((part,), machine).text) == work(text)


@pytest.mark.parametrize("name", ["beamline", "beamline-annex", "beamline-pusher"])
@pytest.mark.parametrize("sample", ["beam", "channel", "strut"])
def test_samples_come_back(name: str, sample: str) -> None:
    path = SAMPLES / "dstv" / f"{sample}.nc1"
    (part,) = readers.read(path.read_bytes(), str(path)).parts
    machine = load(name)
    text = post((part,), machine).text
    (made,) = recover(text, machine, "p", KnownStock(part.profile, part.grade)).parts
    assert work(post((made,), machine).text) == work(text)


def test_equal_pieces_are_one_part_with_their_number() -> None:
    machine = load("beamline")
    mitred = bar(Hole("v", 700, 150, 18, S), cuts=EndCuts(30.0, -20.0))
    text = post((bar(), mitred, bar()), machine, bar=12000.0).text
    parts = with_marks(recover(text, machine, "p", KnownStock(BEAM)).parts, "M")
    assert [(p.mark, p.quantity) for p in parts] == [("M-1", 2), ("M-2", 1)]
    assert parts[1].cuts == mitred.cuts


def codes(text: str, machine: Machine, stock: KnownStock = KnownStock()) -> list[str]:  # noqa: B008
    found = recover(text, machine, "p", stock)
    return [d.code for d in found.diagnostics]


def test_a_section_is_found_in_the_catalogue_or_asked_for() -> None:
    pusher, annex = load("beamline-pusher"), load("beamline-annex")
    part = bar(Hole("v", 300, 150, 18, S))
    assert codes(post((part,), pusher).text, pusher) == [CATALOGUE.code]
    odd = replace(part, profile=replace(BEAM, height=297.0))
    flanged = replace(odd, features=())
    assert codes(post((flanged,), pusher).text, pusher) == [PROFILE.code]
    assert codes(post((part,), annex).text, annex) == [PROFILE.code, FACES.code]


def test_a_bar_without_two_cuts_makes_no_part() -> None:
    machine = load("beamline")
    text = post((bar(),), machine).text
    lines = text.splitlines()
    last = max(k for k, line in enumerate(lines) if "M42" in line)
    short = "\n".join([*lines[: last - 1], *lines[last + 1 :]]) + "\n"
    assert NO_PIECE.code in codes(short, machine, KnownStock(BEAM))


def test_a_path_that_is_no_feature_is_refused() -> None:
    machine = load("beamline-pusher")
    text = post((bar(Slot("v", 750, 150, 18, 60, 0, 0, S)),), machine).text
    lines = text.splitlines()
    feeds = [k for k, line in enumerate(lines) if "G01" in line and "Y" in line and "F" in line]
    bent = [k for k in feeds if any(f"X{x}" in lines[k] for x in _xs(lines, feeds)[-1:])]
    k = bent[0]
    words = [w if not w.startswith("Y") else f"Y{float(w[1:]) + 25:g}" for w in lines[k].split()]
    lines[k] = " ".join(words)
    found = recover("\n".join(lines) + "\n", machine, "p", KnownStock(BEAM))
    assert found.parts == ()
    assert PATH.code in [d.code for d in found.diagnostics]


def _xs(lines: list[str], rows: list[int]) -> list[str]:
    xs = {w[1:] for k in rows for w in lines[k].split() if w.startswith("X")}
    return sorted(xs, key=float)


def test_a_broken_program_is_refused_with_the_messages_of_the_read_back() -> None:
    machine = load("beamline")
    text = post((bar(Hole("v", 300, 150, 18, S)),), machine).text.replace(" M09\n", " M99\n")
    found = recover(text, machine, "p", KnownStock(BEAM))
    assert found.parts == ()
    assert any(d.code.startswith("verify-") for d in found.diagnostics)


def test_another_machine_than_the_head_names_is_said_first() -> None:
    text = post((bar(),), load("beamline")).text
    found = recover(text, load("plate-linuxcnc"), "p")
    assert found.parts == ()
    assert [d.code for d in found.diagnostics][:2] == [
        "verify-machine-changed",
        "verify-sheet-syntax",
    ]
    assert "found a program for the machine beamline" in found.diagnostics[0].message


def test_a_sheet_needs_its_thickness() -> None:
    machine = table("plate-linuxcnc", thickness=6.0)
    text = post((drawing(contour(box(0, 0, 60, 40))),), machine).text
    other = table("plate-linuxcnc", thickness=300.0)
    assert codes(text, other, KnownStock(has_thickness=True)) == [SHEET.code]
    assert codes(text, machine) == []


@pytest.mark.parametrize("thickness", [3.0, 12.0, 20.0])
def test_a_thickness_that_nobody_says_is_the_programs(thickness: float) -> None:
    machine = table("plate-linuxcnc", thickness=thickness)
    outline, hole = contour(box(0, 0, 260, 140)), contour(circle(130, 70, 60))
    text = post((drawing(outline, hole, thickness=thickness),), machine).text
    shipped = table("plate-linuxcnc")
    found = recover(text, shipped, "p")
    assert [d.code for d in found.diagnostics] == [FITTED.code]
    (part,) = found.parts
    assert part.profile.web_thickness is not None
    assert part.profile.web_thickness >= thickness
    again = post((part,), shipped).text
    assert re.findall("^[FM].*", again, re.M) == re.findall("^[FM].*", text, re.M)
    wrong = recover(text, shipped, "p", KnownStock(has_thickness=True))
    assert wrong.parts == ()


def test_a_path_without_room_for_the_kerf_is_refused() -> None:
    plain = table("plate-linuxcnc", thickness=6.0, kerf_by="none", lead="none", min_hole=0.1)
    text = post((drawing(contour(circle(5, 5, 0.6))),), plain).text
    machine = table("plate-linuxcnc", thickness=6.0)
    assert KERF.code in codes(text, machine)


@pytest.mark.parametrize("turns_in_one", [True, False])
def test_a_circle_cut_200_times_is_refused(turns_in_one: bool) -> None:
    machine = table("plate-linuxcnc", thickness=6.0, lead="none")
    text = post((drawing(contour(circle(50, 50, 20))),), machine).text
    begin, end = re.search("^G0.*?^M5[^\\n]*\\n", text, re.M | re.S).span()  # type: ignore[union-attr]
    stroke = text[begin:end]
    many = stroke * 200
    if turns_in_one:
        ring = "".join(re.findall("^G[23].*\\n", stroke, re.M))
        assert stroke.count(ring) == 1
        many = stroke.replace(ring, ring * 200)
    assert codes(text[:begin] + many + text[end:], machine) == [CROWDED.code]


@pytest.mark.parametrize("kerf_by", ["none", "offset", "machine"])
def test_a_sheet_comes_back_without_leads_and_kerf(kerf_by: str) -> None:
    part = drawing(contour(box(0, 0, 200, 100)), contour(circle(60, 50, 70)))
    machine = table("plate-linuxcnc", thickness=6.0, kerf_by=kerf_by)
    text = post((part,), machine).text
    found = recover(text, machine, "p")
    assert found.diagnostics == ()
    (made,) = found.parts
    kinds = {c.kind: c for c in made.contours}
    assert (made.length, made.profile.height) == pytest.approx((200.0, 100.0), abs=1e-3)
    assert [type(c) for c in kinds["outer"].curves] == [Line] * 4
    assert sum(c.length for c in kinds["inner"].curves) == pytest.approx(219.911, abs=0.02)
    assert post((made,), machine).text.splitlines()[:5] == text.splitlines()[:5]


def test_bridges_are_closed() -> None:
    part = drawing(contour(box(0, 0, 200, 100)))
    machine = table("plate-linuxcnc", thickness=6.0, tabs=3)
    text = post((part,), machine).text
    (made,) = recover(text, machine, "p").parts
    assert [c.closed for c in made.contours] == [True]
    assert post((made,), machine).text.count("M3") == text.count("M3") == 4


# The command


def call(*words: str) -> tuple[int, str]:
    done = CliRunner().invoke(main, words)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, done.stderr


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    assert call("post", str(SAMPLES / "dstv" / "channel.nc1"), "-o", "c.gcode")[0] == 0
    return "c.gcode"


@pytest.mark.parametrize("suffix", [".nc1", ".json"])
def test_what_is_written_is_the_part(program: str, suffix: str) -> None:
    sample = SAMPLES / "dstv" / "channel.nc1"
    assert call("recover", program, "--profile", str(sample), "-o", f"part{suffix}") == (0, "")
    again = readers.read(Path(f"part{suffix}").read_bytes(), f"part{suffix}")
    assert [p.mark for p in again.parts] == ["part"]
    machine = load("beamline")
    (part,) = readers.read(sample.read_bytes(), "s.nc1").parts
    old, new = post((part,), machine), post(again.parts, machine)
    assert work(new.text) == work(old.text)
    assert not [d for d in diff_parts((part,), again.parts) if d.text.startswith("cut")]


def test_a_drawing_and_a_folder(program: str) -> None:
    assert call("recover", program, "--profile", "UPN200", "-o", "part.dxf")[0] == 0
    assert b"SECTION" in Path("part.dxf").read_bytes()
    assert call("recover", program, "--profile", "UPN200", "-o", "parts/")[0] == 0
    assert [p.name for p in Path("parts").iterdir()] == ["c.nc1"]


def test_a_section_that_nobody_knows(program: str) -> None:
    code, said = call("recover", program, "--profile", "XYZ1", "-o", "part.nc1")
    assert code == 1
    assert "XYZ1: error recover-no-section: found 'XYZ1' for the section" in said
    assert not Path("part.nc1").exists()


def test_under_strict_a_warning_refuses(program: str) -> None:
    text = Path(program).read_text().replace("M44 K75 L200", "M44 K75 L201")
    Path(program).write_text(text)
    code, said = call("recover", program, "-o", "part.nc1", "--strict")
    assert code == 1
    assert "error recover-profile: found a section U of 201 x 75 mm" in said
    assert not Path("part.nc1").exists()


def test_a_machine_of_triggers_is_wrong_usage(program: str) -> None:
    words = ("recover", program, "--machine", "table-simotion", "-o", "part.nc1")
    code, said = call(*words)
    assert code == 2
    assert "expected one for bars, or a table that runs G-code" in said
