"""What CODESYS makes of rounded arcs."""

from math import cos, radians, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.controllers.codesys.curves import arc_fault, radius_centre
from beamcam.controllers.interpreter import sweep_of
from tests.conftest import examples

lengths = st.floats(-500, 500)


def ends(centre: tuple[float, float], radius: float, start: float, sweep: float):  # type: ignore[no-untyped-def]
    a, b = radians(start), radians(start + sweep)
    return (
        (centre[0] + radius * cos(a), centre[1] + radius * sin(a)),
        (centre[0] + radius * cos(b), centre[1] + radius * sin(b)),
    )


@settings(deadline=None, max_examples=examples(300))
@given(lengths, lengths, st.floats(1, 300), st.floats(0, 360), st.floats(10, 350), st.booleans())
def test_an_arc_that_is_large_enough_survives_rounding(
    x: float, y: float, radius: float, start: float, sweep: float, clockwise: bool
) -> None:
    turn = -sweep if clockwise else sweep
    first, last = ends((x, y), radius, start, turn)
    rounded = [(round(a, 3), round(b, 3)) for a, b in (first, last, (x, y))]
    assert arc_fault(*rounded, 0.001) is None
    assert sweep_of(first, last, (x, y), clockwise) == pytest.approx(turn, abs=1e-6)


@settings(deadline=None, max_examples=examples(200))
@given(st.floats(1, 300), st.floats(0, 360), st.floats(5, 175), st.booleans())
def test_the_centre_of_an_arc_by_its_radius(
    radius: float, start: float, sweep: float, clockwise: bool
) -> None:
    turn = -sweep if clockwise else sweep
    first, last = ends((7.0, -3.0), radius, start, turn)
    assert radius_centre(first, last, radius, clockwise) == pytest.approx((7.0, -3.0), abs=1e-6)


def test_a_centre_off_the_bisector() -> None:
    assert arc_fault((0, 0), (10, 0), (5, 5), 0.001) is None
    assert arc_fault((0, 0), (10, 0), (5.01, 5), 0.001) == (
        "whose radii at start and end differ by 0.01414"
    )
    # On a short chord of a large arc the radii hardly differ though the centre is far off.
    assert arc_fault((0, 0), (0.01, 0), (20, 60), 0.05) == (
        "whose centre lies 20 beside the bisector of its chord"
    )
    assert arc_fault((0, 0), (0, 0), (0, 0), 0.001) == "of radius 0"


def test_no_centre_for_an_arc_that_is_none() -> None:
    with pytest.raises(ValueError, match="of radius 4 over a chord of 10"):
        radius_centre((0, 0), (10, 0), 4, True)
