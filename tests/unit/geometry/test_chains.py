"""Curves joined to chains: laws over shuffled drawings, and tables."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.chains import Gap, join_curves
from beamcam.geometry.curves import Arc, Bezier, Line, signed_area
from tests.conftest import examples

SQUARE = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]


def ring(corners):
    return [Line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]


def moved(curve, x):
    return curve.transformed(((1, 0, x), (0, 1, 0)))


@settings(max_examples=examples(100), deadline=None)
@given(st.integers(0, 2**32), st.integers(1, 6), st.floats(0, 0.009))
def test_shuffled_and_turned_curves_find_their_rings_again(seed, rings, noise):
    dice = random.Random(seed)
    curves = []
    for k in range(rings):
        for line in ring(SQUARE):
            jitter = [dice.uniform(-noise / 3, noise / 3) for _ in range(2)]
            line = Line((line.start[0] + jitter[0], line.start[1] + jitter[1]), line.end)
            curves.append(moved(dice.choice([line, line.reversed()]), 20 * k))
    dice.shuffle(curves)
    result = join_curves(curves, 0.01)
    assert len(result.chains) == rings
    assert (result.junctions, result.gaps, result.dropped) == ((), (), ())
    members = sorted(m for chain in result.chains for m in chain.members)
    assert members == list(range(len(curves)))
    for chain in result.chains:
        assert chain.closed
        assert abs(signed_area(chain.curves)) == pytest.approx(100, abs=0.5)
        for a, b in zip(chain.curves, chain.curves[1:] + chain.curves[:1], strict=True):
            assert a.end == pytest.approx(b.start, abs=1e-9)


def test_an_open_chain_keeps_the_direction_of_its_first_curve():
    curves = [Line((5, 0), (6, 0)), Line((5, 0), (4, 0)), Line((7, 1), (6, 0))]
    (chain,) = join_curves(curves, 0.01).chains
    assert chain.members == (1, 0, 2)
    assert [c.start for c in chain.curves] == [(4, 0), (5, 0), (6, 0)]
    assert chain.curves[-1].end == (7, 1)
    assert not chain.closed


def test_three_ends_in_one_place_are_a_junction():
    curves = [Line((0, 0), (1, 0)), Line((0, 0), (0, 1)), Line((0, 0), (-1, 0))]
    result = join_curves(curves, 0.01)
    assert len(result.chains) == 3
    (junction,) = result.junctions
    assert (junction.point, junction.members) == ((0, 0), (0, 1, 2))
    assert not junction.in_ring


def test_a_gap_beyond_the_tolerance_is_reported_and_left_open():
    curves = ring(SQUARE)
    curves[1] = Line((10.0, 0.05), (10.0, 10.0))
    result = join_curves(curves, 0.01)
    (chain,) = result.chains
    assert not chain.closed
    (gap,) = result.gaps
    assert isinstance(gap, Gap)
    assert gap.width == pytest.approx(0.05)
    assert set(gap.members) == {0, 1}
    assert join_curves(curves, 0.004).gaps == ()


def test_ends_of_arcs_are_bridged_and_those_of_lines_moved():
    a, b = Arc((0, 0), 1, 0, 180), Arc((0, -0.004), 1, 180, 180)
    (chain,) = join_curves([a, b], 0.01).chains
    assert chain.closed
    assert chain.members == (0, -1, 1, -1)
    assert chain.curves[1] == Line(a.end, b.start)
    line = Line((-1.003, 0), (-5, 0))
    (open_chain,) = join_curves([a, line], 0.01).chains
    assert open_chain.curves == (a, Line(a.end, (-5, 0)))
    cubic = Bezier(((-1.003, 0), (-2, 1), (-3, 1), (-5, 0)))
    (open_chain,) = join_curves([a, cubic], 0.01).chains
    assert open_chain.curves[1].start == a.end


def test_circles_and_curves_that_nearly_close_are_rings():
    circle = Arc((0, 0), 5, 0, 360)
    loop = Bezier(((20, 0), (30, 10), (30, -10), (20, 0.005)))
    result = join_curves([circle, loop], 0.01)
    assert [c.closed for c in result.chains] == [True, True]
    assert result.chains[1].curves[0].end == pytest.approx((20, 0))


def test_specks_are_dropped_and_do_not_make_junctions():
    curves = [*ring(SQUARE), Line((10.0, 0.0), (10.003, 0.0))]
    result = join_curves(curves, 0.01)
    assert result.dropped == (4,)
    assert result.chains[0].closed
    assert result.junctions == ()


def test_ends_in_neighbouring_cells_are_found():
    for x in (0.0, 0.0099, 0.01, -0.0001, 123.4567):
        curves = [Line((x, 5), (x, 1)), Line((x + 0.0099, 1), (x + 9, 1))]
        assert len(join_curves(curves, 0.01).chains) == 1


def test_a_tolerance_of_nothing_is_refused():
    with pytest.raises(ValueError, match="tolerance must be above 0, found 0"):
        join_curves([], 0.0)


def test_a_contour_of_curves_shorter_than_the_tolerance_stays_whole():
    corners = [(0.02 * k, 0.0) for k in range(50)] + [(1.0, 1.0), (0.0, 1.0)]
    (chain,) = join_curves(ring(corners), 0.05).chains
    assert chain.closed
    assert len(chain.curves) == len(corners)


def test_a_branch_leaves_the_contour_closed():
    branch = [Line((10, 0), (15, -5)), Line((15, -5), (20, -5))]
    result = join_curves([*branch, *ring(SQUARE)], 0.01)
    assert [c.closed for c in result.chains] == [False, True]
    assert result.junctions == ()


def test_rings_that_touch_in_a_corner_are_told_apart():
    other = [moved(line, 10) for line in ring(SQUARE)]
    other = [line.transformed(((1, 0, 0), (0, 1, 10))) for line in other]
    result = join_curves([*ring(SQUARE), *other], 0.01)
    assert [c.closed for c in result.chains] == [True, True]
    assert result.junctions == ()


def test_ways_that_lead_back_in_two_manners_are_junctions_of_rings():
    result = join_curves([*ring(SQUARE), Line((0, 0), (10, 10))], 0.01)
    assert [j.in_ring for j in result.junctions] == [True, True]
    assert not any(chain.closed for chain in result.chains)


def test_lines_that_leave_a_corner_open_are_prolonged_to_it():
    curves = ring(SQUARE)
    curves[0] = Line((0.0, 0.0), (9.97, 0.0))
    curves[1] = Line((10.0, 0.02), (10.0, 10.0))
    (chain,) = join_curves(curves, 0.05).chains
    assert chain.closed
    assert sorted(c.end for c in chain.curves) == [pytest.approx(p) for p in sorted(SQUARE)]


def test_a_gap_beside_a_line_is_bridged():
    curves = [Line((0, 0), (10, 0)), Line((10.01, 0.03), (20, 0.03))]
    (chain,) = join_curves(curves, 0.05).chains
    assert chain.curves == (curves[0], Line((10, 0), (10.01, 0.03)), curves[1])
