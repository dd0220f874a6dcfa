"""Contours that do not quite close: joined or cut open, what is planned is what is read back."""

from itertools import pairwise

import pytest

from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Contour
from beamcam.pipeline import post
from tests.unit.sheets.parts import contour, drawing


def ring(gap: float) -> Contour:
    """A rectangle whose last side ends short of its first corner."""
    corners = ((0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0), (0.0, gap))
    return contour(tuple(Line(a, b) for a, b in pairwise(corners)))


@pytest.mark.parametrize("gap", [0.0, 0.004, 0.006, 0.02, 0.04, 0.2])
@pytest.mark.parametrize(
    ("name", "style"),
    [
        ("laser-stepper", ".bin"), ("laser-stepper", ".csv"), ("table-simotion", "chain"),
        ("table-plcopen", "table"),
        ("laser-grbl", None), ("plate-linuxcnc", None), ("plate-codesys", None),
    ],
)  # fmt: skip
def test_a_gap_of_any_size(name: str, style: str | None, gap: float) -> None:
    machine = with_torch(load(name), thickness=3.0, kerf=0.0, lead="none", place="corner")
    posted = post((drawing(ring(gap), thickness=3.0),), machine, style=style)
    assert machine.torch is not None
    closed = gap <= machine.torch.gap
    assert ("plan-open-cut" in {d.code for d in posted.remarks}) is not closed
