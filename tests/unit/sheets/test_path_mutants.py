"""Programs of needles, slots and touching corners with a path that is off by a little."""

import re

import pytest

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import errors_in
from beamcam.geometry.curves import Curve
from beamcam.model.part import Part
from beamcam.pipeline import post
from tests.conftest import sampled
from tests.unit.sheets.notches import Notch
from tests.unit.sheets.parts import contour, drawing, lines, table
from tests.unit.sheets.test_touching import STAIRS, code

MACHINE = table("plate-linuxcnc")
TOLERANCE = 0.02
HALF_KERF = 0.95


def leaning(wide: float, high: float, lean: float) -> Part:
    """A plate with a needle that leans over its edge."""
    curves: tuple[Curve, ...] = lines(
        (0, 0), (40, 0), (40, 30), (20 + wide / 2, 30), (20 + lean * high, 30 + high),
        (20 - wide / 2, 30), (0, 30),
    )  # fmt: skip
    return drawing(contour(curves), thickness=8.0)


DRAWINGS = {
    "V": Notch(2.5, 1.5, 0.3).part(),
    "arcs": Notch(3.0, 3.0, 0.1, "arcs", 0.08).part(),
    "curves": Notch(3.0, 3.0, 0.1, "curves", 0.08, mirrored=True).part(),
    "hole": Notch(2.0, 1.0, 0.06, "arcs", 0.05, is_hole=True).part(),
    "leans": leaning(0.05, 5.0, 0.7),
    "corners": code(STAIRS),
}


def moved(text: str, x: float, y: float) -> str:
    """The program with all of its paths so far aside."""

    def aside(found: re.Match[str]) -> str:
        return f"X{float(found[1]) + x:.4f} Y{float(found[2]) + y:.4f}"

    return re.sub(r"X(\S+) Y(\S+)", aside, text)


@pytest.mark.parametrize("name", sampled(DRAWINGS, 2))
def test_a_path_that_is_off_is_refused(name: str) -> None:
    part = DRAWINGS[name]
    text = post((part,), MACHINE).text
    first = re.findall(r"^G0 X\S+ Y\S+\nM3(?:.|\n)*?M5\n", text, re.M)[-1]
    wrong = [text.replace(first, ""), text.replace(first, first * 2)]
    for by in (2 * TOLERANCE, HALF_KERF):
        wrong += [moved(text, by, 0.0), moved(text, -by, 0.0), moved(text, 0.0, by)]
    for k, program in enumerate(wrong):
        assert errors_in(verify_sheet(program, (part,), MACHINE)), k


@pytest.mark.parametrize("name", sampled(DRAWINGS, 2))
def test_a_path_that_leaves_out_a_corner_is_refused(name: str) -> None:
    """Each move in its turn is left out, so that the next one runs straight through what it
    went round."""
    part = DRAWINGS[name]
    rows = post((part,), MACHINE).text.splitlines(keepends=True)
    feeds = [k for k, row in enumerate(rows) if row.startswith(("G1 ", "G2 ", "G3 "))]
    cuts = [k for k in feeds if not rows[k - 1].startswith("F") and rows[k + 1] != "M5\n"]
    accepted = []
    for k in cuts[1:-1]:
        x, y = re.findall(r"[XY](\S+)", rows[k])[:2]
        a, b = re.findall(r"[XY](\S+)", rows[k - 1])[:2]
        if abs(float(x) - float(a)) + abs(float(y) - float(b)) < 0.2:
            continue  # a short move, which what follows may be as well without
        without = "".join([*rows[:k], *rows[k + 1 :]])
        if not errors_in(verify_sheet(without, (part,), MACHINE)):
            accepted.append(rows[k])
    assert not accepted
