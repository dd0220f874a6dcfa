"""Moved rings against the slow way: every place measured, and the covered area compared."""

from itertools import pairwise
from math import cos, dist, pi, radians, sin
from random import Random

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.arc_fitting import fit_chains
from beamcam.geometry.arrays import CurveTable, signed_areas
from beamcam.geometry.curves import Arc, Bezier, BSpline, Line, arc_through, signed_area
from beamcam.geometry.flat_offset import flat_offset
from beamcam.geometry.offset import Offset, Vanished, offset_chains, raw_offsets
from beamcam.geometry.polylines import points_at
from tests.conftest import examples
from tests.distances import distances
from tests.rings import polygon_of

TOLERANCE = 0.008


def star(random, count, size):
    turns = [2 * pi * (k + random.uniform(-0.3, 0.3)) / count for k in range(count)]
    return [(r * cos(t), r * sin(t)) for t in turns for r in [size * random.uniform(0.4, 1)]]


def ring_of(random, kind):
    """A ring of lines, of lines and arcs, or of the arcs that stand for a spline."""
    corners = star(random, random.randint(4, 9), random.uniform(4, 40))
    sides = list(zip(corners, corners[1:] + corners[:1], strict=True))
    if kind == "lines":
        ring = tuple(Line(a, b) for a, b in sides)
    elif kind == "arcs":
        ring = tuple(
            Line(a, b)
            if random.random() < 0.5
            else arc_through(a, b, random.choice((-1, 1)) * dist(a, b) * random.uniform(0.55, 3))
            for a, b in sides
        )
    else:
        control = tuple(corners + corners[:3])
        knots = tuple(float(k) for k in range(len(control) + 4))
        (ring,) = fit_chains(((BSpline(3, control, knots),),), TOLERANCE)
    turned = random.random() < 0.5
    return tuple(c.reversed() for c in reversed(ring)) if turned else ring


@settings(max_examples=examples(40), deadline=None)
@given(
    st.integers(0, 10**6),
    st.sampled_from(("lines", "arcs", "spline")),
    st.sampled_from((-5.0, -0.75, -0.3, 0.3, 0.75, 5.0)),
)
def test_no_place_is_nearer_than_it_shall_be_and_nothing_is_left_uncovered(seed, kind, amount):
    ring = ring_of(Random(seed), kind)
    before = shapely.Polygon(polygon_of(ring, 128))
    if not before.is_valid:
        return
    moved = offset_chains((ring,), (amount,), TOLERANCE)[0]
    truth = before.buffer(amount, quad_segs=64)
    if isinstance(moved, Vanished):
        assert truth.area <= 0.05 * before.length
        return
    share = np.linspace(0, 1, 33)
    points = np.concatenate([points_at(c, share) for chain in moved.chains for c in chain])
    away = shapely.distance(shapely.points(points), before.exterior)
    assert away.min() >= abs(amount) - TOLERANCE
    if moved.exact:
        (chain,) = moved.chains
        assert away.min() >= abs(amount) - TOLERANCE / 4
        after = shapely.Polygon(polygon_of(chain, 64))
        assert after.is_valid
        assert (signed_area(chain) > 0) == (signed_area(ring) > 0)
        lost = truth.difference(after) if amount > 0 else after.difference(truth)
        assert lost.area <= TOLERANCE * after.length
        ends = [*chain[1:], chain[0]]
        assert all(dist(a.end, b.start) <= 1e-4 for a, b in zip(chain, ends, strict=True))


@settings(max_examples=examples(20), deadline=None)
@given(st.lists(st.integers(0, 10**6), min_size=1, max_size=6))
def test_many_rings_are_moved_as_each_by_itself(seeds):
    rings = [ring_of(Random(s), ("lines", "arcs", "spline")[s % 3]) for s in seeds]
    amounts = [0.4 if s % 2 else -0.4 for s in seeds]
    together = offset_chains(rings, amounts, TOLERANCE)
    assert together == [
        offset_chains((ring,), (a,), TOLERANCE)[0] for ring, a in zip(rings, amounts, strict=True)
    ]
    assert signed_areas(rings) == pytest.approx([signed_area(r) for r in rings], abs=1e-7)


def lines(*corners):
    return tuple(Line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))


#: Two chambers joined by a neck that is 1 wide.
WAIST = lines(
    (0.0, 0.0), (10.0, 0.0), (10.0, 4.5), (20.0, 4.5), (20.0, 0.0), (30.0, 0.0),
    (30.0, 10.0), (20.0, 10.0), (20.0, 5.5), (10.0, 5.5), (10.0, 10.0), (0.0, 10.0),
)  # fmt: skip


def test_a_ring_that_crosses_itself_is_not_taken():
    (raw,) = raw_offsets([WAIST], np.array([-1.0]), CurveTable(WAIST))
    assert raw is not None
    moved = offset_chains((WAIST,), (-1.0,), TOLERANCE)[0]
    assert isinstance(moved, Offset)
    assert not moved.exact
    assert len(moved.chains) == 2


@pytest.mark.parametrize(
    "chain",
    [
        (Bezier(((0.0, 0.0), (4.0, 9.0), (9.0, 0.0))), Line((9.0, 0.0), (0.0, 0.0))),
        (Arc((0.0, 0.0), 3.0, 0.0, 360.0),),
        (Arc((0.0, 0.0), 9.0, 0.0, 180.0),),
    ],
    ids=["no-arc", "vanishes", "not-a-ring"],
)
def test_what_has_no_raw_offset(chain):
    assert raw_offsets([chain], np.array([-5.0]), CurveTable(chain)) == [None]


def test_a_corner_between_arcs_that_closes_is_cut_where_they_meet():
    lens = (arc_through((0.0, 0.0), (10.0, 0.0), 8.0), arc_through((10.0, 0.0), (0.0, 0.0), 8.0))
    (raw,) = raw_offsets([lens], np.array([-1.0]), CurveTable(lens))
    assert raw is not None
    assert [arc.radius for arc in raw] == [7.0, 7.0]
    # The circles of radius 7 about (5, +-sqrt(39)) meet on the x axis.
    reach = (49 - 39) ** 0.5
    assert raw[0].start == pytest.approx((5 - reach, 0.0), abs=1e-9)
    assert raw[0].end == pytest.approx((5 + reach, 0.0), abs=1e-9)


@settings(max_examples=examples(20), deadline=None)
@given(st.floats(5.0, 30.0), st.floats(2.0, 20.0), st.floats(0.1, 2.0), st.floats(0.2, 2.0))
def test_a_line_that_vanishes_between_arcs_is_not_prolonged(radius, past_deg, share, amount):
    """Two arcs go past their outermost points; between them is a line, too short to be moved."""
    step = share * amount * radians(past_deg) / 2
    sweep = 180.0 + 2 * past_deg
    below = -2 * radius * sin(radians(past_deg)) - step
    upper = Arc((0.0, 0.0), radius, -past_deg, sweep)
    lower = Arc((0.0, below), radius, 180.0 - past_deg, sweep)
    ring = (upper, Line(upper.end, lower.start), lower, Line(lower.end, upper.start))
    (moved,) = offset_chains((ring,), (amount,), TOLERANCE)
    assert isinstance(moved, Offset)
    dense = [shapely.LineString(points_at(c, np.linspace(0, 1, 400))) for c in ring]
    path = np.concatenate([points_at(c, np.linspace(0, 1, 400)) for c in moved.chains[0]])
    away = distances(path, shapely.MultiLineString(dense))
    assert away.min() > amount - 2 * TOLERANCE


def test_whole_numbers_are_numbers_too():
    control = ((0, 0), (20, 30), (40, -20), (60, 20), (80, 0))
    knots = (0, 0, 0, 0, 1, 2, 2, 2, 2)
    spline = BSpline(3, control, knots)
    exact = BSpline(3, tuple((float(x), float(y)) for x, y in control), tuple(map(float, knots)))
    assert fit_chains(((spline,),), 0.01) == fit_chains(((exact,),), 0.01)


@settings(max_examples=examples(20), deadline=None)
@given(st.integers(0, 10**6), st.sampled_from((0.003, 0.02, 0.1)))
def test_fitted_splines_keep_their_tolerance_and_their_ends(seed, tolerance):
    random = Random(seed)
    control = tuple((random.uniform(0, 90), random.uniform(0, 90)) for _ in range(7))
    spline = BSpline(3, control, tuple(float(k) for k in range(11)))
    (chain,) = fit_chains(((spline,),), tolerance)
    assert dist(chain[0].start, spline.start) <= 1e-9
    assert dist(chain[-1].end, spline.end) <= 1e-9
    for a, b in pairwise(chain):
        assert dist(a.end, b.start) <= 1e-6
    dense = points_at(spline, np.linspace(0, 1, 1500))
    fine = np.concatenate([points_at(c, np.linspace(0, 1, 65)) for c in chain])
    away = distances(dense, shapely.LineString(fine))
    sag = max((c.length / 64) ** 2 / (8 * c.radius) for c in chain if isinstance(c, Arc))
    assert away.max() <= tolerance + sag + 1e-9


def test_a_corner_of_short_sides_keeps_its_distance() -> None:
    """GEOS leaves out where the long sides beside such a corner meet."""
    hook = Bezier(((39.7156, 105.4907), (46.0012, 89.5194), (60.9998, 52.7587), (60.6676, 52.2532)))
    rest = [(60.6676, 52.2532), (126.1086, 54.4197), (170.715, 91.8247), (76.6331, 163.7838)]
    sides = tuple(Line(a, b) for a, b in pairwise([*rest, hook.start]))
    chain = fit_chains([(hook, *sides)], 0.008)[0]
    (moved,) = flat_offset(chain, -0.95, 0.008)
    shares = np.linspace(0.0, 1.0, 401)
    ring = shapely.LinearRing(np.concatenate([points_at(c, shares) for c in chain]))
    away = distances(np.concatenate([points_at(c, shares) for c in moved]), ring)
    assert away.min() > 0.93
    assert away.max() < 0.97
