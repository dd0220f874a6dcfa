"""What lies in a contour that was cut before: boxes looked at together, and one by one."""

import tracemalloc
from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets import compare
from beamcam.checks.sheets.region import Region
from tests.conftest import examples

Box = tuple[float, float, float, float]

places = st.integers(0, 12).map(float)
boxes = st.tuples(places, places, st.integers(1, 12), st.integers(1, 12)).map(
    lambda p: (p[0], p[1], p[0] + p[2], p[1] + p[3])
)


def of_boxes(boxes: list[Box]) -> Region:
    """A region of so many contours, one for each cut."""
    return replace(Region.none(0), polygons=np.array([shapely.box(*b) for b in boxes]))


@pytest.mark.parametrize("at_once", [1, 7, compare.AT_ONCE])
@settings(max_examples=examples(150), deadline=None)
@given(found=st.lists(boxes, max_size=30))
def test_pairs_are_those_that_are_found_one_by_one(at_once: int, found: list[Box]) -> None:
    expected = [
        (k, number)
        for (number, outer), (k, inner) in combinations(enumerate(found), 2)
        if inner != outer and outer[0] <= inner[0] and outer[1] <= inner[1]
        and inner[2] <= outer[2] and inner[3] <= outer[3]
    ]  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compare, "AT_ONCE", at_once)
        pairs = compare.inside_of_earlier(range(len(found)), of_boxes(found))
    assert pairs == sorted(expected)


def test_rows_as_wide_as_the_sheet_take_memory_by_their_number_not_by_their_pairs() -> None:
    peaks = []
    for count in (1000, 4000):
        rows = of_boxes([(0.0, 10.0 * k, 1000.0, 10.0 * k + 8) for k in range(count)])
        tracemalloc.start()
        assert compare.inside_of_earlier(range(count), rows) == []
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 6 * peaks[0]  # four times as many rows, sixteen times as many pairs
