"""The table that planner and read-back have of the same curves."""

import numpy as np
import pytest

from beamcam.geometry.arrays import CurveTable, table_of
from beamcam.geometry.curves import Arc, Bezier, Line

CURVES = (
    Line((0.0, 0.0), (10.0, 5.0)), Arc((3.0, 4.0), 2.0, 0.0, 90.0),
    Bezier(((0.0, 0.0), (10.0, 20.0), (30.0, 10.0))),
)  # fmt: skip


@pytest.mark.parametrize("name", ["lines", "arcs", "ends", "hulls"])
def test_what_one_of_them_has_of_it_the_other_cannot_change(name: str) -> None:
    numbers = getattr(table_of(CURVES), name)
    with pytest.raises(ValueError, match="read-only"):
        numbers += 1.0
    assert np.array_equal(numbers, getattr(CurveTable(CURVES), name))


def test_it_is_that_of_these_objects_and_not_of_equal_ones() -> None:
    """0.0 and -0.0 are equal, and are written otherwise."""
    assert table_of(CURVES) is table_of((*CURVES,))
    other = (Line((-0.0, 0.0), (10.0, 5.0)), *CURVES[1:])
    assert other == CURVES
    assert table_of(other) is not table_of(CURVES)
    assert table_of(CURVES[:2]) is not table_of(CURVES)
