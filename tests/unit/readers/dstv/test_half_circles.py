"""Half circles whose radius and points were rounded to two decimals apart from each other."""

from math import cos, pi, radians, sin, tan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, signed_area
from beamcam.readers.dstv import read
from tests.unit.readers.dstv.test_oddities import text

PLATE = {7: "PL10*300", 8: "B"}


def contours_of(*rows: str):
    reading = read(text(*rows, changes=PLATE).encode(), "p.nc1")
    assert "dstv-arc-stretched" not in [d.code for d in reading.diagnostics]
    return reading.parts[0].contours


def row(x: float, y: float, radius: float = 0.0) -> str:
    return f"  v {x:.2f}u {y:.2f} {radius:.2f}"


hundredths = st.integers(600, 28000).map(lambda n: n / 100)


@given(hundredths, st.sampled_from([0.0, 0.003, 0.005, 0.007]), st.booleans())
def test_a_slot_keeps_its_round_ends(wide: float, off: float, up: bool) -> None:
    """Its radius is the half of its width, rounded up or down."""
    radius, y = wide / 2 + (0.0049 if up else 0.0), 10.0 + off
    (slot,) = contours_of(
        "IK", row(400, y), row(300, y, -radius), row(300, y + wide), row(400, y + wide, -radius),
        row(400, y),
    )  # fmt: skip
    assert abs(signed_area(slot.curves)) == pytest.approx(
        100 * wide + pi * wide * wide / 4, rel=0.002
    )


@given(hundredths, st.sampled_from([0.0, 0.005]))
def test_a_circle_is_round(wide: float, off: float) -> None:
    radius = wide / 2 + 0.0049
    (circle,) = contours_of(
        "IK", row(300, 150 + off, -radius), row(300 + wide, 150 + off, -radius),
        row(300, 150 + off),
    )  # fmt: skip
    assert abs(signed_area(circle.curves)) == pytest.approx(pi * wide * wide / 4, rel=0.003)


@given(st.integers(10, 60), st.floats(3.0, 15.0))
def test_a_lug_with_slanted_sides_keeps_its_arc(radius: int, slant: float) -> None:
    """An arc that its sides run on tangent to is no half circle, however near to one."""
    turn = radians(slant)
    x, y = radius * cos(turn), 250 + radius * sin(turn)
    foot = x + y * tan(turn)
    (lug,) = contours_of(
        "AK", row(500 - foot, 0), row(500 + foot, 0), row(500 + x, y, radius), row(500 - x, y),
        row(500 - foot, 0),
    )  # fmt: skip
    (arc,) = [c for c in lug.curves if isinstance(c, Arc)]
    assert arc.centre[1] == pytest.approx(250, abs=0.1)
