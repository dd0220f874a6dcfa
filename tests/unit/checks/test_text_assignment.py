"""Texts that are alike, or parts of one another: which of them is which is told by all together."""

from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.drawn_texts import covering
from beamcam.checks.rules import TEXT_MOVED
from beamcam.checks.text_assignment import cheapest
from beamcam.errors import Source, errors_in
from beamcam.machine import load
from beamcam.model.part import EndCuts, Part, TextMark
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from beamcam.reconcile import other_places, stand_ins
from tests.conftest import examples
from tests.unit.planning.shop import part
from tests.unit.sheets.parts import plate

PLATE, PUSHER = load("plate-linuxcnc"), load("beamline-pusher")
COSTS = st.integers(1, 4).flatmap(
    lambda rows: st.integers(rows, 5).flatmap(
        lambda columns: st.lists(
            st.lists(st.integers(0, 9), min_size=columns, max_size=columns),
            min_size=rows, max_size=rows,
        )
    )
)  # fmt: skip


@given(COSTS)
@settings(max_examples=examples(30))
def test_the_assignment_is_the_cheapest_of_all(costs: list[list[int]]) -> None:
    chosen = cheapest(np.array(costs, dtype=np.float64))
    assert len({*chosen}) == len(costs)
    every = permutations(range(len(costs[0])), len(costs))
    assert sum(row[k] for row, k in zip(costs, chosen, strict=True)) == min(
        sum(row[k] for row, k in zip(costs, one, strict=True)) for one in every
    )


@given(st.sets(st.frozensets(st.integers(0, 9), min_size=1, max_size=4), min_size=1, max_size=7))
@settings(max_examples=examples(30))
def test_the_fewest_pieces_are_left_without_a_text(places: set[frozenset[int]]) -> None:
    chosen = covering([*places])
    assert {*chosen} <= places
    most = max(
        len(frozenset().union(*some))
        for count in range(len(places) + 1)
        for some in combinations(places, count)
        if sum(map(len, some)) == len(frozenset().union(*some))
    )
    assert sum(map(len, chosen)) == len(frozenset().union(*chosen)) == most


def text(
    words: str, x: float, y: float, high: float, line: int = 1, angle: float = 0.0
) -> TextMark:
    return TextMark("v", x, y, angle, high, words, Source("p.nc1", line))


CROWDED = {
    "a dash beside one between letters": (
        text("-", 154.2, -6.2, 76.0, 1, -120.0), text("-", 87.3, 3.1, 27.3, 2),
        text("-", 82.4, 96.2, 36.1, 3, 90.0), text("A", 170.8, 41.9, 64.4, 4),
        text("P-12", 72.0, 100.3, 31.1, 5, 90.0),
    ),
    "a tall one nearer to the place of a small one": (
        text("A", 131.4, 67.7, 73.8, 1, -120.0), text("P-12", 101.9, -2.3, 89.5, 2),
        text("-", 162.2, 75.8, 35.6, 3), text("A", 153.9, 45.8, 18.3, 4, -120.0),
        text("P-12", 47.5, 67.3, 32.2, 5),
    ),
    "each nearer to the place of the other": (
        text("P-12", 29.7, 26.4, 51.0, 1, 90.0), text("P-12", 42.8, 34.4, 49.0, 2),
        text("P-12", 195.3, 93.7, 69.6, 3), text("P-12", 111.9, 65.3, 52.4, 4),
    ),
    "a stroke of two letters that look alike": (
        text("-", 60.0, 20.0, 30.0, 1, 90.0), text("I", 62.0, 20.0, 14.0, 2),
        text("I", 61.0, 30.0, 20.0, 3),
    ),
}  # fmt: skip


@pytest.mark.parametrize("how", CROWDED)
@pytest.mark.parametrize("apart", [0.0, 3.0])
def test_what_is_planned_in_a_crowd_is_read_back(how: str, apart: float) -> None:
    machine = replace(PLATE, marks=replace(PLATE.marks, min_distance=apart))
    asked = plate(*CROWDED[how])
    posted = post([asked], machine)
    assert sum(o.how == "made" for o in posted.plan.outcomes) >= len(CROWDED[how])
    lacking = plate(*CROWDED[how][:-1])
    assert errors_in(read_back(posted.text, Request((lacking,), machine)))


def test_a_text_of_the_next_part_on_a_bar_is_not_taken() -> None:
    """The second has room for as many texts as the first; their end cuts are alike."""
    ends = EndCuts(web_start=15.0, web_end=-15.0)
    asked = [
        replace(text("A1", x, y, 52.0, line, 90.0)) for line, (x, y) in
        enumerate([(55.7, 280.0), (52.3, 247.0), (160.0, 20.0), (-20.0, 100.0)])
    ]  # fmt: skip
    one = part(*asked, length=200.0, cuts=ends)
    posted = post([one, one], PUSHER)
    assert [o.how for o in posted.plan.outcomes].count("made") >= 6


def test_a_part_whose_end_cuts_cross_on_a_face_is_planned_or_refused_by_name() -> None:
    from beamcam.errors import PlanError

    crossed = part(
        text("-", -4.5, 211.0, 63.0), length=80.0, cuts=EndCuts(web_start=15.0, web_end=-19.0)
    )
    with pytest.raises(PlanError, match="plan-cuts-cross"):
        post([crossed], PUSHER)


def moved(one: TextMark, x: float) -> object:
    return TEXT_MOVED.at(
        one.source, text=one.text, x=f"{x:.1f}", y="5.0", height="9.0", wanted_x=f"{one.x:g}",
        wanted_y=f"{one.y:g}", wanted_height=f"{one.height:g}",
    )  # fmt: skip


A, B = text("A", 10.0, 5.0, 9.0, 1), text("A", 60.0, 5.0, 9.0, 2)
TURNED = replace(text("A", 60.0, 5.0, 9.0, 2), angle=90.0)


def test_a_moved_text_is_told_with_both_places() -> None:
    said = "warning verify-text-moved: found the text 'A' at x 12.0, y 5.0, 9.0 mm high; at x 10, "
    assert said in str(moved(A, 12.0))


@pytest.mark.parametrize(
    ("told", "found", "manual_work", "differ"),
    [
        ([(A, 20.0), (B, 30.0)], [(A, 30.0), (B, 20.0)], [], 0),  # alike: either may be either
        ([(A, 20.0), (TURNED, 30.0)], [(A, 30.0), (TURNED, 20.0)], [], 4),
        ([(A, 60.0), (B, 30.0)], [(A, 30.0)], [], 0),  # the one stands where the other is wanted
        ([(A, 20.0)], [(B, 20.0)], [], 2),
        ([(A, 20.0)], [(B, 20.0)], [B.source], 0),  # the other of the two is manual work
        ([(A, 20.0)], [(A, 20.2)], [], 2),
        ([(A, 20.0)], [], [], 1),
        ([], [(A, 20.0)], [], 1),
        ([(A, 10.0)], [], [], 1),  # nothing was moved
    ],
)
def test_places_are_told_as_they_are_found(
    told: list[tuple[TextMark, float]], found: list[tuple[TextMark, float]],
    manual_work: list[Source], differ: int,
) -> None:  # fmt: skip
    asked: Part = plate(*{one.source: one for one, _ in ((A, 0.0), (B, 0.0), *told)}.values())
    said = other_places(
        [moved(*one) for one in told], [moved(*one) for one in found],  # type: ignore[misc]
        stand_ins([asked]), manual_work,
    )  # fmt: skip
    assert len([*said]) == differ
