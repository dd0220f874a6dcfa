"""Repeated curves are taken away, and what was taken is said."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.cleaning import Removed, Why, remove_repetitions, uncovered
from beamcam.geometry.curves import Arc, Bezier, Line
from beamcam.geometry.plane import distance
from tests.conftest import examples
from tests.property.curve_strategies import curves


@settings(max_examples=examples(80), deadline=None)
@given(st.lists(curves, min_size=1, max_size=5, unique_by=lambda c: c.bbox), st.integers(0, 2**32))
def test_copies_are_removed_and_cleaning_twice_changes_nothing(originals, seed):
    once = remove_repetitions(originals, 1e-3)
    dice = random.Random(seed)
    copies = [dice.choice([c, c.reversed()]) for c in originals]
    both = remove_repetitions([*originals, *copies], 1e-3)
    assert both.curves == once.curves
    assert len(both.curves) + len(both.removed) == 2 * len(originals)
    again = remove_repetitions(both.curves, 1e-3)
    assert again.curves == both.curves
    assert again.removed == ()


@settings(max_examples=examples(100), deadline=None)
@given(st.lists(st.tuples(st.integers(0, 40), st.integers(1, 15)), min_size=1, max_size=8))
def test_overlapping_stretches_of_a_line_cover_the_same_ground(stretches):
    lines = [Line((0.6 * a, 0.8 * a), (0.6 * (a + n), 0.8 * (a + n))) for a, n in stretches]
    result = remove_repetitions(lines, 1e-3)
    covered = set()
    for a, n in stretches:
        covered |= set(range(a, a + n))
    assert sum(c.length for c in result.curves) == pytest.approx(len(covered))
    assert len(result.curves) + len(result.removed) == len(lines)


def test_what_was_removed_is_said():
    curves = [
        Line((0, 0), (10, 0)),
        Line((10, 0), (0, 0)),
        Line((5, 0.0004), (15, 0)),
        Line((15, 0), (20, 0)),
        Arc((0, 0), 5, 0, 360),
        Arc((0, 0), 5, 90, -360),
        Bezier(((0, 0), (1, 5), (2, 0))),
        Bezier(((2, 0), (1, 5), (0, 0))),
    ]
    result = remove_repetitions(curves, 1e-3)
    assert result.removed == (
        Removed(1, 0, Why.DUPLICATE),
        Removed(2, 0, Why.OVERLAP),
        Removed(5, 4, Why.DUPLICATE),
        Removed(7, 6, Why.DUPLICATE),
    )
    assert result.indices == (0, 3, 4, 6)
    assert result.curves[0] == Line((0, 0), (15, 0))


@pytest.mark.parametrize(
    ("a", "b", "merged"),
    [
        (Arc((0, 0), 5, 0, 90), Arc((0, 0), 5, 45, 90), (0, 135)),
        (Arc((0, 0), 5, 0, 90), Arc((0, 0), 5, 135, -90), (0, 135)),
        (Arc((0, 0), 5, 90, -90), Arc((0, 0), 5, 45, 90), (135, -135)),
        (Arc((0, 0), 5, 350, 30), Arc((0, 0), 5, 10, 30), (350, 50)),
        (Arc((0, 0), 5, 10, 30), Arc((0, 0), 5, 350, 30), (-10, 50)),
        (Arc((0, 0), 5, 0, 200), Arc((0, 0), 5, 180, 200), (0, 360)),
        (Arc((0, 0), 5, 0, 360), Arc((0, 0), 5, 45, 90), (0, 360)),
    ],
)
def test_overlapping_arcs_of_a_circle_become_one(a, b, merged):
    (arc,) = remove_repetitions([a, b], 1e-3).curves
    assert (arc.start_deg, arc.sweep_deg) == pytest.approx(merged)


@pytest.mark.parametrize(
    "pair",
    [
        (Arc((0, 0), 5, 0, 90), Arc((0, 0), 5, 90, 90)),
        (Arc((0, 0), 5, 0, 90), Arc((0, 0), 5.1, 0, 90)),
        (Line((0, 0), (5, 0)), Line((5, 0), (9, 0))),
        (Line((0, 0), (5, 0)), Line((2, 0), (2, 5))),
        (Line((0, 0), (5, 0)), Line((0, 0.1), (5, 0.1))),
    ],
)
def test_what_only_touches_stays(pair):
    result = remove_repetitions(pair, 1e-3)
    assert result.curves == pair
    assert result.removed == ()


def test_edges_of_two_contours_are_not_merged():
    along, beside = Line((0, 0), (10, 0)), Line((5, 0), (15, 0))
    assert len(remove_repetitions((along, beside), 1e-3).curves) == 1
    goes_on = Line((5, 0), (5, 9))
    assert remove_repetitions((along, beside, goes_on), 1e-3).removed == ()
    assert remove_repetitions((along, beside), 1e-3, (goes_on,)).removed == ()


stretches = st.lists(st.tuples(st.integers(0, 40), st.integers(1, 15)), min_size=1, max_size=6)


@settings(max_examples=examples(80), deadline=None)
@given(stretches, st.booleans(), st.booleans())
def test_what_is_not_covered_is_what_no_cover_has(covers, turned, is_arc):
    def stretch(a, n):
        if is_arc:
            return Arc((1, 2), 50, 7.0 * a, 7.0 * n)
        return Line((0.6 * a, 0.8 * a), (0.6 * (a + n), 0.8 * (a + n)))

    whole = stretch(10, 25)
    others = [stretch(a, n) for a, n in covers]
    rest = uncovered(whole, [c.reversed() if turned else c for c in others], 1e-3)
    round_ = 360 / 7 if is_arc else 1000  # so many steps lead back to a place
    for place in (k + 0.5 for k in range(10, 35)):
        covered = any((place - a) % round_ < n for a, n in covers)
        assert covered != any(_holds(c, stretch(place, 1).start) for c in rest)


def _holds(curve, point):
    """Whether a curve of more than half a step comes near a point."""
    count = max(2, round(4 * curve.length))
    return any(distance(curve.point(k / count), point) < 0.2 for k in range(count + 1))


def test_a_tolerance_of_nothing_is_refused():
    with pytest.raises(ValueError, match="tolerance must be above 0, found 0"):
        remove_repetitions([], 0.0)
