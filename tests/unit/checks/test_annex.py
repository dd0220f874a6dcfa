"""The program that really ran, interpreted whole: every figure of it, and nothing left over."""

from itertools import pairwise

import pytest

from beamcam.checks.bars.stations import Bore, Cut
from beamcam.machine import load
from tests.conftest import BEAM_CELL
from tests.unit.checks.programs import interpret

FILE = BEAM_CELL / "annex-a.gcode"
pytestmark = pytest.mark.third_party

CUTS = (
    (69.1, 15.0), (215.4, 5.03), (217.3, 0.0),  # the first part's, and the second's start
    (7457.9, 5.03), (7493.1, 0.0), (7495.9, 15.01), (7644.1, 0.0),
)  # fmt: skip
#: X, Y of the program, diameter; in the order of the program
WEB = (
    *((960.3, y, 22.0) for y in (18.0, -52.0, -122.0)),
    (1040.7, -77.8, 22.0), (1046.8, -8.0, 22.0), (1052.9, 61.7, 22.0),
    *((x, y, 24.0) for x in (3632.7, 3772.7) for y in (100.1, -99.9)),
    *((x, -9.8, 24.0) for x in (4022.7, 4522.7, 5022.7, 5522.7)),
    *((x, -9.9, 14.0) for x in (6103.4, 6703.4, 7303.4, 7903.4)),
    *((8387.1, y, 22.0) for y in (18.0, -52.0, -122.0)),
)  # fmt: skip
FLANGE_PAIRS = (6103.4, 6703.4, 7303.4, 7903.4)


def test_the_program_makes_what_its_blocks_say_and_nothing_else() -> None:
    made = interpret(FILE.read_text("utf-8"), load("beamline-annex"), FILE.name)
    assert dict(made.section) == {"height": 380.0, "section": 3.0}
    assert [(c.x, c.angle) for c in made.cuts] == list(CUTS)
    web = [b for b in made.bores if b.face == "v"]
    assert [(b.x, pytest.approx(190 - b.y), b.diameter) for b in web] == list(WEB)
    # 15 holes in the web of the long part, 3 + 3 in the webs of the two short ones.
    assert len(web) == 15 + 3 + 3
    assert {b.stroke for b in web} == {150.0}
    flanges = [b for b in made.bores if b.face != "v"]
    assert sorted((b.x, b.face) for b in flanges) == [(x, f) for x in FLANGE_PAIRS for f in "ou"]
    assert {(b.spindle, b.diameter, b.stroke, round(b.y, 6)) for b in flanges} == {
        (13, 14.0, 190.0, 50.0)
    }
    # 25 drill cycles: 15 of the web and 4 pairs for the long part, 3 and 3 for the short ones.
    assert len({b.line for b in made.bores}) == 15 + 4 + 6
    assert made.paths == ()
    assert len(made.order) == len(CUTS) + 21 + 8


def test_each_block_has_its_part_in_what_is_made() -> None:
    """Lines of cuts and strokes stand where the table of the program puts them."""
    made = interpret(FILE.read_text("utf-8"), load("beamline-annex"))
    order = [op.line - 1 for op in made.order if isinstance(op, Cut | Bore)]  # block numbers
    cuts = [c.line - 1 for c in made.cuts]
    assert cuts == [5, 7, 9, 171, 173, 175, 177]
    assert order == sorted(order)
    strokes = sorted({b.line - 1 for b in made.bores})
    assert strokes[0] == 14
    assert all(b - a == 8 for a, b in pairwise(strokes) if b - a < 16)
