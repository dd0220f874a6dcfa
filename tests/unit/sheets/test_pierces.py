"""Where the torch pierces: as far from the part as the hole that it burns is wide, by figures."""

import re
from math import dist

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import VerifyError
from beamcam.machine import Machine
from beamcam.model.part import Part
from beamcam.pipeline import post
from beamcam.planning.contours import kerf
from tests.conftest import examples
from tests.unit.sheets.parts import box, circle, contour, drawing, lines, table

WINDOW = drawing(contour(box(0, 0, 200, 100)), contour(box(60, 30, 40, 30), line=2))
#: A row of 6 mm has a kerf of 1.5 mm and a lead of 3 mm.
RADIUS, HALF_KERF = 1.5, 0.75
PIERCED = re.compile(r"G0 X(\S+) Y(\S+)\nM3 S1")


def pierced(text: str) -> list[tuple[float, float]]:
    """Places in the part's own numbers; the table lays it 10 mm from its corner."""
    return [(float(x) - 10.0, float(y) - 10.0) for x, y in PIERCED.findall(text)]


def codes(text: str, part: Part, machine: Machine) -> list[str]:
    return [said.code for said in verify_sheet(text, (part,), machine)]


@pytest.mark.parametrize("lead", ["arc", "line"])
def test_it_pierces_clear_of_the_part(lead: str) -> None:
    """From the middle of the window's long side, 3 mm of lead into it."""
    (x, y), _ = pierced(post((WINDOW,), table(lead=lead)).text)
    assert y - 30 >= RADIUS
    assert 60 + RADIUS <= x <= 100 - RADIUS


@pytest.mark.parametrize(("share", "is_refused"), [(1.0, False), (0.5, False), (0.2, True)])
def test_a_lead_shorter_than_its_room_is_refused(
    share: float, is_refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lines of 3, 1.5 and 0.6 mm end 3.75, 2.25 and 1.35 mm from the part."""
    monkeypatch.setattr(kerf, "SHARES", (share,))
    machine = table(lead="line", lead_in=3.0)
    if not is_refused:
        assert post((WINDOW,), machine).text
        return
    with pytest.raises(VerifyError) as refused:
        post((WINDOW,), machine)
    assert {d.code for d in refused.value.diagnostics} == {"verify-sheet-pierce"}
    assert "1.350 mm from the contour" in str(refused.value.diagnostics[0])


def test_a_lead_that_is_left_out_is_refused() -> None:
    machine = table()
    text = post((WINDOW,), machine).text
    assert codes(text, WINDOW, machine) == []
    led = re.sub(r"G0 X\S+ Y\S+(\nM3 S1\n.*\n.*\n)G3 (X\S+ Y\S+) .*\n", r"G0 \2\1", text, count=1)
    assert led != text
    assert codes(led, WINDOW, machine) == ["verify-sheet-pierce"]


def test_where_there_is_no_room_it_pierces_nearer() -> None:
    """A slit of 3 mm has 0.75 mm on either side of the path along its middle."""
    slit = drawing(contour(box(0, 0, 200, 100)), contour(box(60, 30, 40, 3.0), line=2))
    machine = table(lead="line")
    posted = post((slit,), machine)
    (_, y), _ = pierced(posted.text)
    assert HALF_KERF <= y - 30 <= 3.0 - HALF_KERF
    assert "plan-lead" in {said.code for said in posted.remarks}
    assert codes(posted.text, slit, machine) == []


def test_a_wider_pierce_asks_for_more_room() -> None:
    """With a pierce of 8 mm a hole of 14 has room for 4 mm off its wall, one of 6 has not."""
    for diameter, room in ((14.0, True), (6.0, False)):
        part = drawing(contour(box(0, 0, 200, 100)), contour(circle(50, 50, diameter), line=2))
        machine = table(lead="line", lead_in=5.0, min_hole=0.0, min_hole_share=0.0)
        torch = machine.needed(machine.torch, "torch")
        rows = tuple(replace(row, pierce_width=8.0) for row in torch.rows)
        machine = replace(machine, torch=replace(torch, rows=rows))
        place, _ = pierced(post((part,), machine).text)
        assert (diameter / 2 - dist(place, (50.0, 50.0)) >= 4.0) == room


@settings(max_examples=examples(60), deadline=None)
@given(diameter=st.floats(1.52, 8.0), lead_in=st.floats(0.3, 8.0), lead_out=st.floats(0.0, 4.0))
def test_a_lead_round_the_middle_of_a_hole_is_no_lead(
    diameter: float, lead_in: float, lead_out: float
) -> None:
    """A quarter circle of the path's own radius lies on it: another one is taken, or none."""
    part = drawing(contour(box(0, 0, 60, 60)), contour(circle(30, 30, diameter), line=2))
    machine = table(lead_in=lead_in, lead_out=lead_out, min_hole=0.0, min_hole_share=0.0)
    text = post((part,), machine).text
    assert isinstance(text, str)
    away = dist(pierced(text)[0], (30.0, 30.0))
    path = diameter / 2 - HALF_KERF
    assert away <= path - 0.03 or away == pytest.approx(path, abs=2e-3)


def test_room_is_where_the_waste_of_its_own_contour_is() -> None:
    """The drawn start lies in the corner between a part and the side of one it touches, which is
    nearer to the path than the part's own corner: 0.75 mm, where that is 0.75 sqrt(2) mm away."""
    corner = lines((50, 20), (50, 100), (100, 100), (100, 20))
    part = drawing(contour(corner), contour(box(0, 0, 50, 120), line=2))
    posted = post((part,), table(common_cuts=True, start="drawn"))
    assert "plan-lead" in {said.code for said in posted.remarks}
    (x, y), *_ = pierced(posted.text)
    assert (x, y) == pytest.approx((50.0 + HALF_KERF, 20.0 - HALF_KERF))
