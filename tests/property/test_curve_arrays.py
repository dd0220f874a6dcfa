"""Laws of what is asked of many curves at once: each curve by itself says the same."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.arrays import CurveTable, cubics_of, first_equal, near_pairs
from beamcam.geometry.curves import Arc, Bezier, BSpline, NewtonCurve, bezier_pieces, join_boxes
from beamcam.model.part import extent
from beamcam.planning.contours.running_back import TURNED_RAD, chords_of, may_go_round
from tests.conftest import examples
from tests.property.curve_strategies import arcs, beziers, ellipses, lines, newton_curves, splines

curves = st.lists(
    st.one_of(lines(), arcs, ellipses(), beziers(), splines(), newton_curves()),
    min_size=1,
    max_size=5,
)


@settings(max_examples=examples(50), deadline=None)
@given(curves)
def test_ends_are_those_of_the_curves(found):
    for row, curve in zip(CurveTable(found).ends.tolist(), found, strict=True):
        assert row == pytest.approx([*curve.start, *curve.end], abs=1e-9)


@settings(max_examples=examples(50), deadline=None)
@given(curves)
def test_hulls_lie_around_the_curves(found):
    for hull, curve in zip(CurveTable(found).hulls.tolist(), found, strict=True):
        box, slack = curve.bbox, 1e-9 * (1 + max(map(abs, hull)))
        assert hull[0] <= box[0] + slack
        assert hull[1] <= box[1] + slack
        assert box[2] <= hull[2] + slack
        assert box[3] <= hull[3] + slack


@settings(max_examples=examples(60), deadline=None)
@given(curves)
def test_the_box_of_all_is_around_the_boxes_of_each(found):
    assert extent(found) == join_boxes([curve.bbox for curve in found])


@settings(max_examples=examples(60), deadline=None)
@given(curves)
def test_cubics_are_the_pieces_to_the_last_bit(found):
    control, owner, others = cubics_of(found)
    expected, left = [], []
    for k, curve in enumerate(found):
        free = isinstance(curve, Bezier | BSpline | NewtonCurve)
        pieces = bezier_pieces(curve) if free else ()
        weighted = isinstance(curve, BSpline) and curve.weights is not None
        if pieces and not weighted and all(p.weights is None and p.degree == 3 for p in pieces):
            expected += [(k, piece.points) for piece in pieces]
        else:
            left.append(k)
    assert others == left
    assert owner.tolist() == [k for k, _ in expected]
    assert [tuple(map(tuple, c)) for c in control.tolist()] == [points for _, points in expected]


@settings(max_examples=examples(60), deadline=None)
@given(splines())
def test_ends_of_splines_are_those_of_their_pieces(spline):
    assert spline.start == spline.pieces()[0].start
    assert spline.end == spline.pieces()[-1].end


def test_ends_of_arcs_are_exact_on_the_axes():
    arc = Arc((0.1, 0.2), 0.7, -90.0, 450.0)
    assert CurveTable([arc, Arc((1.0, 2.0), 3.0, 180.0, -360.0)]).ends.tolist() == [
        [*arc.start, *arc.end],
        [-2.0, 2.0, -2.0, 2.0],
    ]


places = st.tuples(st.integers(-30, 30), st.integers(-9, 9))


@settings(max_examples=examples(60), deadline=None)
@given(st.lists(places, max_size=25), st.sampled_from((0.1, 0.3, 1.0)))
def test_near_points_are_found_and_no_others(found, reach):
    points = np.array(found, dtype=np.float64).reshape(-1, 2) / 10
    expected = [
        (a, b)
        for a, b in itertools.combinations(range(len(points)), 2)
        if np.hypot(*(points[a] - points[b])) <= reach
    ]
    assert list(zip(*(v.tolist() for v in near_pairs(points, reach)), strict=True)) == expected


def test_near_points_of_a_wide_drawing():
    points = np.array([(0.0, 0.0), (1e9, 1e9), (1e9, 1e9 + 5e-4), (-1e9, 3.0)])
    assert [v.tolist() for v in near_pairs(points, 1e-3)] == [[1], [2]]


def test_a_reach_of_nothing_is_refused():
    with pytest.raises(ValueError, match="above 0"):
        near_pairs(np.zeros((3, 2)), 0.0)


@given(st.lists(st.tuples(st.sampled_from([-1.0, -0.0, 0.0, 0.1, 1e300]), st.integers(0, 2))))
def test_first_equal(values: list[tuple[float, int]]) -> None:
    rows = np.array(values, dtype=np.float64).reshape(-1, 2)
    assert first_equal(rows).tolist() == [values.index(value) for value in values]


@settings(max_examples=examples(60), deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.5, 20.0), st.floats(-1.0, 1.5)), min_size=6, max_size=40),
    st.lists(st.one_of(beziers(), splines()), max_size=1),
)
def test_chords_turn_no_farther_than_control_polygons(sides, more):
    lengths, turns = np.array(sides).T
    ways = np.cumsum(turns)
    at = np.cumsum(lengths[:, None] * np.column_stack((np.cos(ways), np.sin(ways))), axis=0)
    hulls = [at[k : k + 4].tolist() for k in range(0, len(at) - 3, 3)]
    found = [*(Bezier(tuple(map(tuple, hull))) for hull in hulls), *more]
    _, steps, _ = chords_of(found)
    ahead = np.unwrap(np.arctan2(*steps.T[::-1]))
    assert may_go_round([found]) or np.ptp(ahead) <= TURNED_RAD
