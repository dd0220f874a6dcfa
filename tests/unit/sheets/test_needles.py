"""Notches beside a needle of the part, whose tip the beam passes on both sides."""

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from beamcam.errors import PlanError
from beamcam.geometry.curves import Bezier, Curve, Line
from beamcam.model.part import Part
from beamcam.pipeline import post
from beamcam.verify.sheets import verify_sheet
from tests.unit.sheets.parts import contour, drawing, lines, table

MACHINE = table("plate-linuxcnc")


def sheet(curves: tuple[Curve, ...]) -> Part:
    return drawing(contour(curves), thickness=8.0)


def notched(mouth: float, tip: float, depth: float) -> tuple[Curve, ...]:
    """A plate with a V notch in its top, left of a needle that ends as high as the plate."""
    return lines(
        (0, 0), (40, 0), (40, 20), (25 + tip, 20), (25 + tip, 40), (25, 40),
        (25 - mouth / 2, 40 - depth), (25 - mouth, 40), (0, 40),
    )  # fmt: skip


HOOK = (
    Line((10.16, 60.8), (101.6, 60.8)), Line((101.6, 60.8), (101.6, 10.0)),
    Line((101.6, 10.0), (10.16, 10.0)), Line((10.16, 10.0), (10.16, 58.26)),
    Bezier(((10.16, 58.26), (10.16, 59.657), (11.303, 60.8), (10.16, 60.8))),
)  # fmt: skip


@pytest.mark.parametrize("curves", [
    HOOK,
    lines((5, 4.995), (7, 8), (7, 12), (6, 7), (4, 130), (3, 12), (3, 8)),
    notched(1.2, 0.02, 5.0),
], ids=["hook", "shield", "notch"])  # fmt: skip
def test_what_lies_beside_a_needle_passes(curves: tuple[Curve, ...]) -> None:
    post((sheet(curves),), MACHINE)


@settings(deadline=None, max_examples=30)
@given(st.floats(0.3, 4.0), st.floats(0.1, 2.0), st.floats(0.5, 12.0))
def test_a_notch_is_made_or_refused_by_the_planner(mouth: float, tip: float, depth: float) -> None:
    try:
        post((sheet(notched(mouth, tip, depth)),), MACHINE)
    except PlanError as error:
        event(f"refused, {error.diagnostics[0].code}")
        return
    event("made")


@settings(deadline=None, max_examples=8)
@given(st.floats(0.0, 1.0), st.floats(2.5, 8.0), st.floats(0.1, 1.0))
def test_a_notch_that_the_beam_enters_may_not_be_left(
    narrow: float, mouth: float, tip: float
) -> None:
    """The program of the plate with the notch almost closed does not make the one with it open."""
    without = lines(
        (0, 0), (40, 0), (40, 20), (25 + tip, 20), (25 + tip, 40), (25, 40),
        (25 - mouth, 40), (0, 40),
    )  # fmt: skip
    text = post((sheet(without),), MACHINE).text
    part = sheet(notched(mouth, tip, 5.0 + narrow))
    assert "verify-sheet-missing" in {said.code for said in verify_sheet(text, (part,), MACHINE)}
