"""Waste that no beam reaches: the depth of corners by hand, and what is no corner."""

from math import radians, sin, tan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.geometry.curves import Line
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Part
from beamcam.pipeline import post
from tests.conftest import examples
from tests.unit.sheets.parts import contour, drawing

PLATE = load("plate-linuxcnc")


def kerf(mm: float) -> Machine:
    return with_torch(PLATE, None, mm)


def plate(*top: tuple[float, float]) -> Part:
    """A plate of 80 x 40 whose upper edge goes by some places, from right to left."""
    places = [(0.0, 0.0), (80.0, 0.0), (80.0, 40.0), *top, (0.0, 40.0)]
    ends = zip(places, [*places[1:], places[0]], strict=True)
    return drawing(contour(tuple(Line(a, b) for a, b in ends)), thickness=8.0)


@settings(max_examples=examples(12), deadline=None)
@given(angle=st.floats(20.0, 36.0), half=st.floats(0.3, 1.2), lean=st.floats(-10.0, 10.0))
def test_a_corner_is_as_deep_as_its_angle_says(angle: float, half: float, lean: float) -> None:
    """A disc of radius r touches both sides of an angle a at r / sin(a / 2) from its tip."""
    right, left = (40.0 + 25.0 * tan(radians(lean + side * angle / 2)) for side in (1, -1))
    part = plate((right, 40.0), (40.0, 15.0), (left, 40.0))
    posted = post([part], kerf(2 * half))
    (said,) = verify_sheet(posted.text, [part], kerf(2 * half))
    assert "warning verify-sheet-left: found " in str(said)
    assert float(said["found"]) == pytest.approx(half / sin(radians(angle / 2)) - half, abs=2e-3)
    assert (said["x"], said["y"]) == ("40.000", "15.000")


NARROW = {
    "slot": ((40.4, 40.0), (40.4, 20.0), (39.6, 20.0), (39.6, 40.0)),
    "hole": ((40.1, 40.0), (40.1, 30.0), (44.0, 26.0), (40.0, 22.0), (36.0, 26.0), (39.9, 30.0),
             (39.9, 40.0)),
    "bottle": ((40.5, 40.0), (40.5, 38.0), (45.0, 20.0), (35.0, 20.0), (39.5, 38.0), (39.5, 40.0)),
}  # fmt: skip


@pytest.mark.parametrize("what", NARROW)
def test_what_is_too_narrow_for_the_beam_is_no_corner(what: str) -> None:
    """A path along the edge alone touches both sides of its mouth, and leaves the rest uncut."""
    posted = post([plate()], kerf(1.5))
    said = verify_sheet(posted.text, [plate(*NARROW[what])], kerf(1.5))
    assert {one.code for one in said} == {"verify-sheet-missing"}


def test_the_beam_has_to_come_to_a_corner() -> None:
    """A notch narrower than the beam is a corner, if the path dips into its mouth."""
    notched = plate((40.5, 40.0), (40.0, 39.0), (39.5, 40.0))
    assert not verify_sheet(post([notched], kerf(1.5)).text, [notched], kerf(1.5))
    said = verify_sheet(post([plate()], kerf(1.5)).text, [notched], kerf(1.5))
    assert {one.code for one in said} == {"verify-sheet-missing"}
