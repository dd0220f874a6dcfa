"""Corners of rectangular tubes whose header has no radius, by the weight."""

from math import pi

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from beamcam.model.part import Profile
from beamcam.readers.dstv.header import corner_by_weight


def shs(height: float, width: float, wall: float, radius: float = 0.0) -> Profile:
    return Profile("M", "RHS", height, width, wall, wall, radius)


@pytest.mark.parametrize(
    ("sizes", "weight", "radius"),
    [
        ((100.0, 100.0, 6.0), 17.0, 12.0), ((120.0, 80.0, 5.0), 14.4, 10.0),  # EN 10219-2
        ((150.0, 150.0, 8.0), 34.0, 20.0), ((100.0, 100.0, 5.0), 14.7, 7.5),  # EN 10210-2, hot
    ],
)  # fmt: skip
def test_corners_of_tubes_of_the_standards(
    sizes: tuple[float, float, float], weight: float, radius: float
) -> None:
    """Tables of the standards have the weight to a tenth, and corners of 2, 2.5 and 1.5 walls: a
    tenth of 14.7 kg/m is 0.7 mm of such a corner."""
    assert corner_by_weight(shs(*sizes), weight) == pytest.approx(radius, abs=2.0)


@given(
    st.floats(40, 400), st.floats(40, 400), st.floats(2.5, 12.5), st.floats(1.1, 3.3)
)  # fmt: skip
def test_the_weight_has_the_corners_back(
    height: float, width: float, wall: float, share: float
) -> None:
    radius = share * wall
    assume(2 * radius <= min(height, width))
    inner = radius - wall
    area = height * width - (height - 2 * wall) * (width - 2 * wall)
    area -= (4 - pi) * (radius * radius - inner * inner)
    weight = round(7.85e-3 * area, 3)
    assert corner_by_weight(shs(height, width, wall), weight) == pytest.approx(radius, abs=0.1)
    assert corner_by_weight(shs(height, width, wall, wall), weight) is None  # it says so itself
    sharp = 7.85e-3 * (height * width - (height - 2 * wall) * (width - 2 * wall))
    assert corner_by_weight(shs(height, width, wall), sharp) is None
    assert corner_by_weight(shs(height, width, wall), 0.9 * weight) != pytest.approx(radius)
