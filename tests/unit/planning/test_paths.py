"""Paths of mills and scribes: the pocket they leave, and how close their chords are."""

from itertools import pairwise
from math import cos, dist, hypot, pi, radians, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Bezier, Line
from beamcam.model.part import Contour, Slot
from beamcam.model.plan import DrillOp, PathOp
from beamcam.planning.operations.marks import line_points
from beamcam.planning.operations.slot import pocket_path
from tests.conftest import examples
from tests.unit.planning.shop import SOURCE, hole, part, plan

TOLERANCE = 0.02


def from_pocket(x: float, y: float, size: tuple[float, float], diameter: float) -> float:
    """How far a place lies outside of a rounded rectangle about 0, 0; negative inside."""
    dx, dy = max(0.0, abs(x) - size[0] / 2), max(0.0, abs(y) - size[1] / 2)
    if dx or dy:
        return hypot(dx, dy) - diameter / 2
    return max(abs(x) - size[0] / 2, abs(y) - size[1] / 2) - diameter / 2


@settings(max_examples=examples(200), deadline=None)
@given(
    st.tuples(st.sampled_from((0.0, 20.0, 41.5)), st.sampled_from((0.0, 0.0, 15.0))),
    st.sampled_from((0.0, 90.0, 30.0, -45.0)),
    st.floats(20, 60),
    st.sampled_from((8.0, 16.0, 20.0)),
    st.booleans(),
)
def test_the_mill_leaves_the_pocket(
    size: tuple[float, float], angle: float, diameter: float, mill: float, blind: bool
) -> None:
    """The mill's edge reaches the pocket's edge all round, and nowhere goes beyond it."""
    points = pocket_path((500.0, 100.0), size, angle, diameter, mill, TOLERANCE, blind)
    assert points[0] == pytest.approx(points[-1], abs=1e-9)
    assert points[0][0] == pytest.approx(max(p[0] for p in points), abs=diameter)
    c, s = cos(radians(angle)), sin(radians(angle))
    own = [((x - 500) * c + (y - 100) * s, (y - 100) * c - (x - 500) * s) for x, y in points]
    assert max(from_pocket(x, y, size, diameter) for x, y in own) <= -mill / 2 + 1e-6
    # Every place of the edge has the mill within the tolerance.
    for k in range(48):
        t = 2 * pi * k / 48
        edge = (
            (1 if cos(t) >= 0 else -1) * size[0] / 2 + diameter / 2 * cos(t),
            (1 if sin(t) >= 0 else -1) * size[1] / 2 + diameter / 2 * sin(t),
        )
        assert to_path(edge, own) <= mill / 2 + TOLERANCE + 1e-6
    if blind:
        # No island is left: a grid of places inside is under the mill somewhere.
        for i in range(-6, 7):
            for j in range(-6, 7):
                x, y = i / 6 * (size[0] + diameter) / 2, j / 6 * (size[1] + diameter) / 2
                if from_pocket(x, y, size, diameter) <= 0:
                    assert to_path((x, y), own) <= mill / 2 + TOLERANCE + 1e-6


def to_path(place: tuple[float, float], path: list[tuple[float, float]]) -> float:
    """Distance of a place from a polyline."""
    best = min(hypot(place[0] - x, place[1] - y) for x, y in path)
    for (ax, ay), (bx, by) in pairwise(path):
        dx, dy = bx - ax, by - ay
        square = dx * dx + dy * dy
        if square:
            t = min(1.0, max(0.0, ((place[0] - ax) * dx + (place[1] - ay) * dy) / square))
            best = min(best, hypot(place[0] - ax - t * dx, place[1] - ay - t * dy))
    return best


def test_a_slot_is_drilled_at_both_ends_and_milled() -> None:
    found = plan(part(Slot("v", 500, 150, 22.0, 40.0, 0.0, 0.0, SOURCE)))
    ops = [op for op in found.operations if isinstance(op, DrillOp | PathOp)]
    assert [op.tool.name for op in ops] == ["drill 22", "drill 22", "mill 20"]
    assert [op.x for op in ops] == [495.0, 535.0, 535.0]
    mill = ops[2]
    assert isinstance(mill, PathOp)
    assert mill.reasons == ("slot-mill",)
    assert mill.path[0] == mill.path[-1] == (535.0, 150.0)
    assert {op.features for op in ops} == {((0, 0),)}
    assert [o.by for o in found.outcomes] == ["mill"]


def test_a_slot_as_wide_as_the_mill_is_one_line_to_and_fro() -> None:
    found = plan(part(Slot("v", 500, 150, 20.0, 40.0, 0.0, 90.0, SOURCE)))
    (mill,) = (op for op in found.operations if isinstance(op, PathOp))
    low, high = (515.0, 130.0), (515.0, 170.0)
    assert [tuple(round(v, 9) for v in point) for point in mill.path] == [high, low, high]


def test_a_rectangle_is_milled_with_a_mill_for_its_corners() -> None:
    found = plan(part(Slot("v", 500, 150, 16.0, 40.0, 30.0, 0.0, SOURCE)))
    ops = [op for op in found.operations if isinstance(op, DrillOp | PathOp)]
    assert [op.tool.name for op in ops] == ["mill 16"]
    assert sum(dist(a, b) for a, b in pairwise(ops[0].path)) >= 140.0  # type: ignore[union-attr]


def test_a_hole_larger_than_any_drill_is_milled_round() -> None:
    found = plan(part(hole(500, diameter=80)))
    (mill,) = (op for op in found.operations if isinstance(op, PathOp))
    assert (mill.tool.name, mill.reasons) == ("mill 20", ("mill-circle",))
    radii = [hypot(x - 515, y - 150) for x, y in mill.path[1:-1]]
    assert max(radii) == pytest.approx(30.0)
    assert min(radii) == pytest.approx(30.0)


def test_a_blind_pocket_is_cleared_to_its_middle() -> None:
    found = plan(part(hole(500, diameter=80, kind="blind", depth=4.0)))
    (mill,) = (op for op in found.operations if isinstance(op, PathOp))
    assert mill.depth == 4.0
    assert min(hypot(x - 515, y - 150) for x, y in mill.path[1:-1]) <= 10.0


def test_a_line_is_scribed_from_its_nearer_end() -> None:
    chain = (Line((700, 50), (600, 50)), Line((600, 50), (600, 90)))
    found = plan(part(Contour("v", "open", chain, SOURCE, "powder", False)))
    (scribe,) = (op for op in found.operations if isinstance(op, PathOp))
    assert (scribe.tool.kind, scribe.depth) == ("scribe", 0.3)
    assert scribe.path == ((615.0, 90.0), (615.0, 50.0), (715.0, 50.0))


@settings(max_examples=examples(100), deadline=None)
@given(st.floats(2, 400), st.floats(-180, 180), st.floats(20, 360), st.booleans())
def test_chords_keep_the_tolerance(
    radius: float, start: float, sweep: float, clockwise: bool
) -> None:
    arc = Arc((0.0, 0.0), radius, start, -sweep if clockwise else sweep)
    points = line_points((arc,), TOLERANCE)
    for (ax, ay), (bx, by) in pairwise(points):
        assert radius - hypot((ax + bx) / 2, (ay + by) / 2) <= TOLERANCE


def test_chords_of_a_free_curve_keep_the_tolerance() -> None:
    wave = Bezier(((0.0, 0.0), (40.0, 80.0), (60.0, -80.0), (100.0, 0.0)))
    points = list(line_points((wave,), TOLERANCE))
    off = max(to_path(wave.point(k / 1000), points) for k in range(1001))
    assert 0 < off <= TOLERANCE
