"""Kerf offset: laws over random rings, and tables."""

from math import pi, sqrt

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, EllipseArc, Line, signed_area
from beamcam.geometry.flat_offset import refit_ring
from beamcam.geometry.offset import Offset, Vanished, intersections, offset_chains
from beamcam.geometry.polylines import points_at
from tests.conftest import examples
from tests.rings import polygon_of


def ring(*corners):
    return tuple(Line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))


SQUARE = ring((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0))
CIRCLE = (Arc((3.0, 4.0), 5.0, 30.0, 360.0),)
#: A plate with a slot from its edge, ended by a half circle.
SLOTTED = (
    Line((0, 0), (40, 0)), Line((40, 0), (40, 30)), Line((40, 30), (23, 30)),
    Line((23, 30), (23, 10)), Arc((20, 10), 3, 0, -180), Line((17, 10), (17, 30)),
    Line((17, 30), (0, 30)), Line((0, 30), (0, 0)),
)  # fmt: skip
#: The rounded rectangle of the two-axis table.
ROUNDED = (
    Line((20, 10), (40, 10)), Arc((40, 20), 10, -90, 90), Line((50, 20), (50, 40)),
    Arc((40, 40), 10, 0, 90), Line((40, 50), (20, 50)), Arc((20, 40), 10, 90, 90),
    Line((10, 40), (10, 20)), Arc((20, 20), 10, 180, 90),
)  # fmt: skip


@st.composite
def star_rings(draw):
    dice = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(3, 12))
    turn = (np.arange(count) + dice.uniform(-0.3, 0.3, count)) * 2 * np.pi / count
    reach = dice.uniform(15, 60, count)
    points = [
        (float(r * np.cos(t)), float(r * np.sin(t))) for t, r in zip(turn, reach, strict=True)
    ]
    chain = ring(*points)
    return chain if draw(st.booleans()) else tuple(c.reversed() for c in reversed(chain))


def offset_chain(chain, amount):
    return offset_chains((chain,), (amount,))[0]


def distances(chains, original):
    share = np.linspace(0, 1, 41)
    points = np.concatenate([points_at(c, share) for chain in chains for c in chain])
    border = shapely.Polygon(polygon_of(original, 512)).exterior
    return shapely.distance(shapely.points(points), border)


@settings(max_examples=examples(120), deadline=None)
@given(
    st.one_of(star_rings(), st.sampled_from([SQUARE, CIRCLE, SLOTTED, ROUNDED])),
    st.sampled_from([-4.0, -1.0, -0.1, 0.1, 1.0, 4.0]),
)
def test_moved_rings_keep_their_distance_and_direction(chain, amount):
    result = offset_chain(chain, amount)
    polygon = shapely.Polygon(polygon_of(chain, 512))
    expected = polygon.buffer(amount, join_style="mitre", mitre_limit=2.5, quad_segs=256)
    if isinstance(result, Vanished):
        assert expected.area <= 0.5
        return
    away = distances(result.chains, chain)
    assert np.min(away) >= abs(amount) - 0.006
    assert np.max(away) <= 2.5 * abs(amount) + 0.006
    for moved in result.chains:
        for a, b in zip(moved, moved[1:] + moved[:1], strict=True):
            assert a.end == pytest.approx(b.start, abs=1e-7)
    outer = max(result.chains, key=lambda c: abs(signed_area(c)))
    assert signed_area(outer) * signed_area(chain) > 0
    # Rounded corners against bevelled ones: no more than half a circle in all apart.
    found = abs(sum(signed_area(moved) for moved in result.chains))
    slack = 8 * amount * amount + 0.01 * polygon.length
    assert found == pytest.approx(expected.area, abs=slack)


@pytest.mark.parametrize("amount", [2.0, -2.0])
def test_a_circle_changes_its_radius(amount):
    for chain in (CIRCLE, (CIRCLE[0].reversed(),)):
        result = offset_chain(chain, amount)
        assert result.exact
        assert result.chains[0][0].radius == 5 + amount
        assert result.chains[0][0].sweep_deg == chain[0].sweep_deg


def test_a_square_keeps_its_corners():
    (grown,) = offset_chain(SQUARE, 1.0).chains
    assert signed_area(grown) == pytest.approx(144)
    (shrunk,) = offset_chain(SQUARE, -1.0).chains
    assert shrunk == ring((1, 1), (9, 1), (9, 9), (1, 9))


def test_a_sharp_corner_is_rounded():
    needle = ring((0.0, 0.0), (50.0, 2.0), (0.0, 4.0))
    (moved,) = offset_chain(needle, 1.0).chains
    (arc,) = [c for c in moved if isinstance(c, Arc)]
    assert (arc.centre, arc.radius) == (pytest.approx((50, 2)), pytest.approx(1.0))


def test_smooth_joints_stay_smooth_and_exact():
    for amount in (1.0, -1.0):
        result = offset_chain(ROUNDED, amount)
        assert result.exact
        (moved,) = result.chains
        assert [type(c) for c in moved] == [type(c) for c in ROUNDED]
        assert {c.radius for c in moved if isinstance(c, Arc)} == {10 + amount}
        length = sum(c.length for c in ROUNDED)
        grown = signed_area(moved) - signed_area(ROUNDED)
        assert grown == pytest.approx(amount * length + pi * amount**2)


def test_a_slot_that_closes_is_found_and_arcs_come_back():
    result = offset_chain(SLOTTED, 3.5)
    assert not result.exact
    outer = max(result.chains, key=lambda c: abs(signed_area(c)))
    assert signed_area(outer) == pytest.approx(47 * 37, rel=0.02)
    narrow = offset_chain(SLOTTED, 2.0)
    (moved,) = narrow.chains
    assert narrow.exact
    assert [c.radius for c in moved if isinstance(c, Arc)] == [1.0]


def test_two_halves_of_a_waist():
    right = [(0, 0), (20, 0), (20, 10), (11, 10), (11, 20), (20, 20), (20, 30)]
    left = [(0, 30), (0, 20), (9, 20), (9, 10), (0, 10)]
    waist = ring(*((float(x), float(y)) for x, y in right + left))
    result = offset_chain(waist, -1.5)
    assert not result.exact
    assert len(result.chains) == 2


@pytest.mark.parametrize(("chain", "amount"), [(SQUARE, -5.5), (CIRCLE, -5.0), (CIRCLE, -7.0)])
def test_what_vanishes_is_said(chain, amount):
    result = offset_chain(chain, amount)
    assert isinstance(result, Vanished)
    assert result.area == pytest.approx(abs(signed_area(chain)))
    assert result.amount == amount


def test_an_ellipse_comes_back_as_arcs():
    ellipse = (EllipseArc((0, 0), (30, 0), 0.6, 0, 360),)
    result = offset_chain(ellipse, 2.0)
    assert not result.exact
    (moved,) = result.chains
    assert any(isinstance(c, Arc) for c in moved)
    assert np.max(np.abs(distances([moved], ellipse) - 2.0)) <= 0.006


def test_nothing_to_move():
    assert offset_chain(SQUARE, 0.0) == Offset((SQUARE,), (100.0,), True)


def test_intersections():
    assert intersections(Line((0, 0), (1, 0)), Line((0, 1), (1, 1))) == []
    assert intersections(Line((0, 0), (1, 0)), Line((5, 1), (5, 2))) == [(5, 0)]
    across = intersections(Arc((0, 0), 5, 0, 90), Line((3, -9), (3, 9)))
    assert sorted(across) == [pytest.approx((3, -4)), pytest.approx((3, 4))]
    both = intersections(Arc((0, 0), 1, 0, 90), Arc((1, 0), 1, 0, 90))
    assert sorted(both) == [pytest.approx((0.5, -sqrt(0.75))), pytest.approx((0.5, sqrt(0.75)))]
    assert intersections(Arc((0, 0), 1, 0, 90), Arc((9, 0), 1, 0, 90)) == []
    assert intersections(Arc((0, 0), 1, 0, 90), Line((0, 3), (1, 3))) == []


def test_refitted_circles_are_a_few_arcs():
    points = [(float(x), float(y)) for x, y in points_at(CIRCLE[0], np.linspace(0, 1, 200))[:-1]]
    arcs = refit_ring(points, 0.001)
    assert len(arcs) <= 4
    assert all(isinstance(a, Arc) and a.radius == pytest.approx(5, abs=1e-6) for a in arcs)
    assert refit_ring([(0, 0), (5, 0), (10, 0), (10, 10), (0, 10)], 0.01)[0].length >= 10


@pytest.mark.parametrize(
    ("chain", "message"),
    [
        ((), "only a closed chain"),
        (SQUARE[:3], "only a closed chain"),
        (ring((0.0, 0.0), (5.0, 0.0)), "without area has no outside"),
    ],
)
def test_what_has_no_outside_is_refused(chain, message):
    with pytest.raises(ValueError, match=message):
        offset_chain(chain, 1.0)
