"""A part that fits on its sheet only if it is turned: turned and told, and read back so."""

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from tests.conftest import examples
from tests.unit.sheets.parts import box, circle, contour, drawing, lines

SHEET = (3000.0, 1500.0)


def sheet_of(name: str = "plate-linuxcnc", **values: object):  # type: ignore[no-untyped-def]
    return with_torch(load(name), thickness=3.0, sheet_size=SHEET, **values)  # type: ignore[arg-type]


LONG = drawing(
    contour(lines((0, 0), (1125, 0), (1125, 2870), (300, 2870), (0, 2000))),
    contour(circle(200, 400, 120), line=2), thickness=3.0,
)  # fmt: skip


@settings(max_examples=examples(30), deadline=None)
@given(width=st.integers(200, 3200), height=st.integers(200, 3200))
def test_it_is_turned_if_it_fits_so_only(width: int, height: int) -> None:
    part = drawing(contour(box(5, 7, width, height)), thickness=3.0)
    machine = sheet_of(kerf=0.0, lead="none", margin=0.0)
    as_drawn = width <= SHEET[0] and height <= SHEET[1]
    turned = height <= SHEET[0] and width <= SHEET[1]
    if not (as_drawn or turned):
        with pytest.raises(PlanError, match="plan-sheet-size"):
            post((part,), machine)
        return
    posted = post((part,), machine)
    codes = [d.code for d in posted.remarks]
    assert ("plan-sheet-turned" in codes) == (not as_drawn)
    (op,) = posted.plan.operations
    points = [c.start for c in op.passes[0].curves]
    x0, y0, x1, y1 = shapely.MultiPoint(points).bounds
    size = (width, height) if as_drawn else (height, width)
    assert (x1 - x0, y1 - y0) == pytest.approx(size)


def test_a_quarter_turn_counter_clockwise() -> None:
    """The hole at 200, 400 comes to lie 400 from the right end and 200 from below."""
    posted = post((LONG,), sheet_of(margin=10.0))
    hole = posted.plan.operations[0]
    ((cx, cy),) = {(round(c.centre[0], 6), round(c.centre[1], 6)) for c in hole.passes[0].curves}
    assert (cx, cy) == pytest.approx((2480, 210))


@pytest.mark.parametrize("values", [
    {"place": "drawn"}, {"rotate": 180.0}, {"mirror": "x"}, {"copies": (2, 1)},
])  # fmt: skip
def test_what_is_asked_to_lie_somehow_is_not(values: dict[str, object]) -> None:
    with pytest.raises(PlanError, match=r"plan-sheet-(size|place)"):
        post((LONG,), sheet_of(**values))


def test_what_is_ignored_takes_no_room() -> None:
    """A frame that is not cut, larger than the sheet, does not turn the part in it."""
    frame = replace(contour(box(-20, -20, 1400, 2950), line=9), colour="#00ff00", process="cut")
    part = replace(LONG, features=(contour(box(0, 0, 2000, 900)), frame))
    machine = with_torch(sheet_of(), {"lime": "ignore"})
    posted = post((part,), machine)
    assert "plan-sheet-turned" not in [d.code for d in posted.remarks]


def test_a_program_of_the_part_as_drawn_is_refused() -> None:
    """On a larger table it lies as it is drawn; on this one it would not fit."""
    machine = sheet_of()
    larger = with_torch(load("plate-linuxcnc"), thickness=3.0, length=4000.0, width=4000.0)
    text = post((LONG,), larger).text
    assert read_back(text, Request((LONG,), machine))
    assert not read_back(post((LONG,), machine).text, Request((LONG,), machine))
