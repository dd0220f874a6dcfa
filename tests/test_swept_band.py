"""The measure from outside sees what a cutter does wrong, in programs that are changed by hand."""

import re
from pathlib import Path

import pytest

from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.pipeline import post, read_file
from tests.dxf_text import arc, circle, drawing, line, polyline
from tests.rs274 import needs_rs274
from tests.swept_band import Refused, measure

pytestmark = needs_rs274
KERF = 1.5  #: of plate-linuxcnc on 6 mm, which it takes where a drawing says nothing
SQUARE = [(0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0)]
CUT = polyline(SQUARE) + circle(20, 20, 8)


def posted(tmp_path: Path, entities: str) -> tuple[Path, Path]:
    """The program that cuts some entities, and their drawing."""
    dxf, program = tmp_path / "drawing.dxf", tmp_path / "program.ngc"
    dxf.write_bytes(drawing(entities))
    machine = with_torch(load("plate-linuxcnc"), allow_open=True)
    program.write_text(post(read_file(str(dxf)).parts, machine).text)
    return program, dxf


def faults(program: Path, dxf: Path) -> list[str]:
    return list(measure(program, dxf, KERF).faults())


def test_right(tmp_path: Path) -> None:
    open_line = line(80, 0, 90, 10)
    half = arc(80, 30, 5, 0, 180) + line(75, 30, 85, 30)
    assert faults(*posted(tmp_path, CUT + open_line + half)) == []


def test_shifted(tmp_path: Path) -> None:
    """Everything 0.1 mm to the right: the band is in the part at one side, off it at the other."""
    program, dxf = posted(tmp_path, CUT)
    text = re.sub(r"X(\S+)", lambda m: f"X{float(m[1]) + 0.1:.4f}", program.read_text())
    program.write_text(text)
    found = "\n".join(faults(program, dxf))
    assert "mm into the part" in found
    assert "mm uncut" in found


def test_other_side(tmp_path: Path) -> None:
    """A disc is cut out beside its contour, a hole of the same contour too wide by the kerf."""
    disc, _ = posted(tmp_path, circle(20, 20, 8))
    cut = measure(disc, tmp_path / "drawing.dxf", KERF)
    assert cut.into_part() <= 0.03
    sheet = cut.drawn._replace(rings=[*cut.drawn.rings, cut.drawn.rings[0].envelope.buffer(20)])
    assert cut._replace(drawn=sheet).into_part() > KERF - 0.03  # its lead reaches farther


@pytest.mark.parametrize(
    ("stroke", "found"), [(0, "mm uncut"), (1, "parts not free")], ids=["hole", "outline"]
)
def test_left_out(tmp_path: Path, stroke: int, found: str) -> None:
    program, dxf = posted(tmp_path, CUT)
    measured = measure(program, dxf, KERF)
    assert len(measured.strokes) == 2
    rest = [s for k, s in enumerate(measured.strokes) if k != stroke]
    assert found in "\n".join(measured._replace(strokes=rest).faults())


def test_twice(tmp_path: Path) -> None:
    measured = measure(*posted(tmp_path, CUT), KERF)
    doubled = measured._replace(strokes=[*measured.strokes, measured.strokes[0]])
    assert any("cut twice" in fault for fault in doubled.faults())


def test_pierced_in_the_part(tmp_path: Path) -> None:
    measured = measure(*posted(tmp_path, CUT), KERF)
    swapped = measured._replace(strokes=[s.reverse() for s in measured.strokes])
    assert measured.pierced(0.03) == swapped.pierced(0.03) == 0
    inside = measured.strokes[1].centroid.buffer(5).exterior
    assert measured._replace(strokes=[inside]).pierced(0.03) == 1


def test_narrow_slot(tmp_path: Path) -> None:
    """A slot of 0.5 mm has no room for the beam, which passes its mouth."""
    notched = [*SQUARE[:2], (60.0, 20.0), (40.0, 20.0), (40.0, 20.5), (60.0, 20.5), *SQUARE[2:]]
    whole, dxf = posted(tmp_path, polyline(SQUARE))
    dxf.write_bytes(drawing(polyline(notched)))
    assert any("narrow place" in fault for fault in faults(whole, dxf))


def test_bridge(tmp_path: Path) -> None:
    """A stroke that ends 2 mm before it closes leaves the part in the sheet."""
    measured = measure(*posted(tmp_path, polyline(SQUARE)), KERF)
    (stroke,) = measured.strokes
    gap = stroke.interpolate(stroke.length / 2).buffer(1 + KERF / 2)
    rest = list(stroke.difference(gap).geoms)
    assert measured._replace(strokes=rest).joined(0.03) == 1


def test_refused_by_the_interpreter(tmp_path: Path) -> None:
    program, dxf = posted(tmp_path, CUT)
    program.write_text(program.read_text().replace("G64 P0.01", "G64 P0.01 G99.9"))
    with pytest.raises(Refused, match="Unknown g code used"):
        measure(program, dxf, KERF)
