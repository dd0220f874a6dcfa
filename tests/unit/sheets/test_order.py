"""What lies in a contour that was cut before: boxes looked at together, and one by one."""

import tracemalloc

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import Struct

from beamcam.checks.sheets import order
from tests.conftest import examples


class Cut(Struct):
    """As much of a traced stroke as its order is judged by."""

    box: tuple[float, float, float, float]
    middle: tuple[float, float]
    ring: tuple[int, ...] = (0,)  #: open without one
    contour: None = None

    @property
    def goes_round(self) -> bool:
        return bool(self.ring)


places = st.integers(0, 12).map(float)
boxes = st.tuples(places, places, places, places).map(
    lambda p: (min(p[0], p[2]), min(p[1], p[3]), max(p[0], p[2]), max(p[1], p[3]))
)
cuts = st.builds(Cut, boxes, st.tuples(places, places), st.sampled_from([(0,), (0,), ()]))


def in_box(of: list[Cut], inner: list[int], ring: int) -> list[tuple[int, int]]:
    """In the place of `_within`: the box is the contour."""
    return [(k, ring) for k in inner]


@pytest.mark.parametrize("at_once", [1, 7, order.AT_ONCE])
@settings(max_examples=examples(150), deadline=None)
@given(found=st.lists(cuts, max_size=30))
def test_pairs_are_those_that_are_found_one_by_one(at_once: int, found: list[Cut]) -> None:
    expected = [
        (inner, ring)
        for inner, cut in enumerate(found)
        for ring, around in enumerate(found[:inner])
        if around.ring
        and around.box[0] <= cut.middle[0] <= around.box[2]
        and around.box[1] <= cut.middle[1] <= around.box[3]
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(order, "_within", in_box)
        patch.setattr(order, "AT_ONCE", at_once)
        assert order._inside_of_earlier(found) == expected  # type: ignore[arg-type]


def test_rows_as_wide_as_the_sheet_take_memory_by_their_number_not_by_their_pairs() -> None:
    peaks = []
    for count in (1000, 4000):
        rows = [Cut((0.0, 10.0 * k, 1000.0, 10.0 * k + 8), (500.0, 10.0 * k)) for k in range(count)]
        tracemalloc.start()
        assert order._inside_of_earlier(rows) == []  # type: ignore[arg-type]
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 6 * peaks[0]  # four times as many rows, sixteen times as many pairs
