"""Openings beside their plate: refused by the plan, and told by the read-back without it."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.plates import beside_faults
from beamcam.errors import VerifyError
from beamcam.model.part import Contour, Hole, Part, Slot
from beamcam.pipeline import post
from beamcam.planning.contours.outline import off_plate
from tests.unit.sheets.parts import S, box, contour, plate, table


def cut_out(x: float, y: float, wide: float, high: float) -> Contour:
    return replace(contour(box(x, y, wide, high), None), kind="inner")


OUTLINE = contour(box(0, 0, 200, 100), None)


@given(
    st.floats(-80.0, 280.0), st.floats(-80.0, 180.0), st.sampled_from(["hole", "slot", "cut-out"]),
    st.integers(0, 2),
)  # fmt: skip
def test_what_has_no_place_on_the_plate_is_told(x: float, y: float, kind: str, own: int) -> None:
    """With its outline never, once or twice; by boxes, and near the edge it is not asked."""
    opening, reach = {
        "hole": (Hole("v", x, y, 20.0, S), (10.0, 10.0)),
        "slot": (Slot("v", x, y, 20.0, 30.0, 0.0, 0.0, S), (25.0, 10.0)),
        "cut-out": (cut_out(x - 15, y - 10, 30, 20), (15.0, 10.0)),
    }[kind]
    part = plate(opening, *[OUTLINE] * own)
    off = max(-x, x - 200.0) - reach[0], max(-y, y - 100.0) - reach[1]
    for said in (off_plate(part, 0.1), beside_faults([part])):
        codes = [*said]
        if max(off) > 0.0:
            assert codes, (x, y)
        elif max(off) < -10.0:
            assert not codes, (x, y)


@pytest.mark.parametrize("opening", [
    Hole("v", 300, 50, 18.0, S), Slot("v", -60, 50, 18.0, 20.0, 0.0, 0.0, S),
    cut_out(240, 20, 40, 40),
])  # fmt: skip
@pytest.mark.parametrize("machine", ["plate-linuxcnc", "table-simotion"])
def test_a_plan_that_cuts_it_is_not_sound(
    opening: Any, machine: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("beamcam.planning.sheet.off_plate", lambda *_: ())
    part: Part = plate(opening)
    with pytest.raises(VerifyError, match="verify-sheet-beside"):
        post((part,), table(machine))
    post((plate(Hole("v", 100, 50, 18.0, S)),), table(machine))
