"""Letters: strokes of Hershey's Roman simplex, 21 units a capital, and their size on the steel."""

from pathlib import Path

import pytest

from beamcam import readers
from beamcam.geometry.lettering import body_share, glyph_of, spelled
from beamcam.machine import load
from beamcam.pipeline import post
from tests.beam_cell import Section, run
from tests.conftest import SAMPLES
from tests.rs274 import needs_rs274
from tests.test_rs274 import moves_of

#: Advance and strokes in the font's units, as its tables print them.
PRINTED = {
    "L": (17, [[(4, 21), (4, 0)], [(4, 0), (16, 0)]]),
    "H": (22, [[(4, 21), (4, 0)], [(18, 21), (18, 0)], [(4, 11), (18, 11)]]),
    "I": (8, [[(4, 21), (4, 0)]]),
    "T": (16, [[(8, 21), (8, 0)], [(1, 21), (15, 21)]]),
    "1": (20, [[(6, 17), (8, 18), (11, 21), (11, 0)]]),
    "-": (26, [[(4, 9), (22, 9)]]),
}


@pytest.mark.parametrize("sign", PRINTED)
def test_a_letter(sign: str) -> None:
    advance, strokes = PRINTED[sign]
    glyph = glyph_of(sign)
    assert glyph is not None
    assert glyph.advance == pytest.approx(advance / 21)
    assert len(glyph.strokes) == len(strokes)
    for drawn, printed in zip(glyph.strokes, strokes, strict=True):
        for got, (x, y) in zip(drawn, printed, strict=True):
            assert got == pytest.approx((x / 21, y / 21))


def test_a_capital_is_three_quarters_of_the_body() -> None:
    assert body_share() == 0.75
    assert spelled("B-12", {}).text == "B-12"


def test_a_text_on_a_beam() -> None:
    """B-12 at 300, 140, 10 high: from the baseline at 140 to 150, no wider than 4 letters of 10."""
    text = (SAMPLES / "dstv" / "marked.nc1").read_text()
    parts = readers.read(text.encode(), "marked.nc1").parts
    program = post(parts[:1], load("beamline-pusher")).text
    strokes, _ = run(program, "beamline-pusher", Section("I", 300.0, 150.0, 10.7, 7.1, 15.0))
    lines = [s for s in strokes if s.kind == "scribe" and s.face == "v" and s.places[0][0] < 400]
    xs = [x - 15.0 for s in lines for x, _ in s.places]  # the part begins at 15
    ys = [y for s in lines for _, y in s.places]
    assert (min(ys), max(ys)) == pytest.approx((140.0, 150.0), abs=0.02)
    # B begins 4 units in; advances 21 + 26 + 20, then 2 ends at 17 of its 20: 84 / 21 x 10.
    assert min(xs) - 300.0 == pytest.approx(40 / 21, abs=0.05)
    assert max(xs) - 300.0 == pytest.approx(840 / 21, abs=0.05)
    assert all(stroke.depth == pytest.approx(0.3, abs=0.001) for stroke in lines)


@needs_rs274
def test_a_text_on_a_plate(tmp_path: Path) -> None:
    """Part_7 at 20, 90, 12 high; the plate lies 10 from the corner: P from 100 to 112 at x 30.

    The spine of a P begins 4 units in, and is a capital high: 12 x 4 / 21 = 2.286.
    """
    text = (SAMPLES / "dstv" / "lettered.nc1").read_text()
    parts = readers.read(text.encode(), "lettered.nc1").parts
    path = tmp_path / "lettered.ngc"
    path.write_text(post(parts, load("plate-linuxcnc")).text)
    spine = [v[1] for _, v in moves_of(path) if abs(v[0] - 32.286) < 0.01]
    assert (min(spine), max(spine)) == pytest.approx((100.0, 112.0), abs=0.01)
