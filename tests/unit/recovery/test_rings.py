"""Circles, slots, corners and arcs found in the chords of a border."""

from math import asin, cos, dist, pi, radians, sin

import pytest
from shapely import LineString, Point, Polygon
from shapely.affinity import rotate, translate
from shapely.geometry.polygon import orient

from beamcam.geometry.curves import Arc, Line
from beamcam.recovery.rings import (
    curves_of,
    drilled_of,
    pocket_of,
    round_of,
    rounded_corners,
)

WITHIN = 0.025


def border(shape: Polygon, half_kerf: float = 1.1) -> list[tuple[float, float]]:
    """The border of what a torch leaves of a region that it goes round, the steel inside."""
    path = shape.buffer(half_kerf, 8).exterior
    cut = path.buffer(half_kerf, 16)
    left = shape.buffer(5.0).difference(cut).geoms
    (inside,) = (one for one in left if one.intersects(shape.representative_point()))
    return list(orient(inside).exterior.coords)[:-1]


def opening(shape: Polygon, half_kerf: float = 1.1) -> list[tuple[float, float]]:
    """The border of an opening that a torch goes round inside, the steel on the left."""
    path = shape.buffer(-half_kerf).exterior
    return list(Polygon(path.buffer(half_kerf, 16).exterior).exterior.coords)[:-1]


def ring(x: float, y: float, radius: float, count: int) -> list[tuple[float, float]]:
    turns = [2 * pi * k / count for k in range(count)]
    return [(x + radius * cos(t), y + radius * sin(t)) for t in turns]


@pytest.mark.parametrize(("x", "y", "d"), [(100.0, 50.0, 22.0), (33.3, -4.0, 17.5), (0.0, 0.0, 60)])
def test_a_circle_comes_back_from_its_chords(x: float, y: float, d: float) -> None:
    assert round_of(opening(Polygon(ring(x, y, d / 2, 96))), WITHIN) == (x, y, d)


def test_a_polygon_is_no_circle() -> None:
    assert round_of(ring(0.0, 0.0, 50.0, 12), WITHIN) is None  # 1.7 mm between chord and circle
    assert round_of(ring(0.0, 0.0, 3.0, 6), 5.0) is None


def test_a_hole_of_a_tube_is_the_drills() -> None:
    """r sin t across the tube lies at R asin(r sin t / R) of arc."""
    radius, r = 44.45, 15.0
    drawn = [
        (200 + r * cos(t), 90 + radius * asin(r * sin(t) / radius))
        for t in (2 * pi * k / 120 for k in range(120))
    ]
    assert drilled_of(drawn, radius, WITHIN) == (200.0, 90.0, 30.0)
    assert round_of(drawn, WITHIN) is None
    flat = ring(200.0, 90.0, 15.0, 120)
    assert drilled_of(flat, radius, WITHIN) is None
    around = [(200 + 70 * cos(t), 90 + 70 * sin(t)) for t in (2 * pi * k / 90 for k in range(90))]
    assert drilled_of(around, radius, WITHIN) is None  # it reaches beyond a quarter turn


@pytest.mark.parametrize(
    ("d", "length", "height", "angle"),
    [(18.0, 40.0, 0.0, 0.0), (22.0, 30.0, 0.0, 90.0), (18.0, 25.0, 0.0, -30.0),
     (18.0, 20.0, 10.0, 0.0), (27.5, 60.0, 0.0, 12.5)],
)  # fmt: skip
def test_a_slot_comes_back(d: float, length: float, height: float, angle: float) -> None:
    core = LineString([(-length / 2, 0), (length / 2, 0)])
    if height:
        x, y = length / 2, height / 2
        core = Polygon([(-x, -y), (x, -y), (x, y), (-x, y)])
    shape = translate(rotate(core, angle, origin=(0, 0)).buffer(d / 2, 24), 300.0, 45.5)
    found = pocket_of(opening(shape), WITHIN)
    assert found is not None
    known = (300.0, 45.5, d, length, height, angle)
    assert found == pytest.approx(known, abs=0.01)


def test_what_is_no_slot() -> None:
    box = Polygon([(0, 0), (100, 0), (100, 60), (0, 60)])
    assert pocket_of(opening(box.buffer(-12.0).buffer(12.0, 32)), WITHIN) is None  # a window
    assert pocket_of([(0, 0), (40, 0), (40, 20), (5, 25)], WITHIN) is None
    assert pocket_of(ring(0, 0, 20.0, 96), WITHIN) is None


def test_corners_are_sharp_again_behind_a_kerf() -> None:
    corners = [(0.0, 0.0), (200.0, 0.0), (200.0, 60.0), (160.0, 100.0), (0.0, 100.0)]
    found = curves_of(border(Polygon(corners)), WITHIN)
    assert all(isinstance(curve, Line) for curve in found)
    assert {curve.start for curve in found} == set(corners)
    for before, after in zip(found, (*found[1:], found[0]), strict=True):
        assert before.end == after.start


def test_arcs_come_back_between_the_lines_that_they_touch() -> None:
    """A rectangle with a re-entrant quarter of 12 mm and a convex one of 25 mm."""
    quarter = [(100 - 12 * cos(radians(a)), 60 - 12 * sin(radians(a))) for a in range(91)]
    turned = [(25 - 25 * sin(radians(a)), 75 + 25 * cos(radians(a))) for a in range(91)]
    shape = Polygon([(0, 0), (200, 0), (200, 48), *quarter[::-1], (88, 100), *turned])
    found = curves_of(border(shape), WITHIN)
    arcs = sorted((c for c in found if isinstance(c, Arc)), key=lambda arc: arc.radius)
    assert [arc.radius for arc in arcs] == pytest.approx([12.0, 25.0], abs=1e-9)
    assert [arc.sweep_deg for arc in arcs] == pytest.approx([-90.0, 90.0], abs=0.05)
    assert sum(isinstance(c, Line) for c in found) == 6
    for arc, middle in zip(arcs, ((100.0, 60.0), (25.0, 75.0)), strict=True):
        assert dist(arc.centre, middle) < 0.01
    assert rounded_corners(found, 12.0, WITHIN) == 1
    assert rounded_corners(found, 25.0, WITHIN) == 0  # it turns the other way


def test_everything_lies_within_what_is_said() -> None:
    """A shape of waves: arcs and lines, none farther from the chords than asked for."""
    wave = [(k / 2, 10 + 4 * sin(k / 15)) for k in range(401)]
    shape = Polygon([*wave, (200.0, 80.0), (0.0, 80.0)])
    chords = border(shape)
    found = curves_of(chords, WITHIN)
    assert len(found) < len(chords) / 8
    drawn = Polygon([c.point(k / 40) for c in found for k in range(40)])
    assert max(drawn.exterior.distance(Point(p)) for p in chords) < 2 * WITHIN


def test_what_ends_at_an_edge_ends_with_a_line() -> None:
    """Of an arc that crosses the edge at 30 degrees nothing lies between it and 1 mm off it."""
    arc = [(100 + 50 * cos(radians(a / 2)), -25 + 50 * sin(radians(a / 2))) for a in range(60, 301)]
    ring = [(200.0, 0.0), (200.0, 80.0), (0.0, 80.0), (0.0, 0.0), *arc[::-1]]
    for edges, near in (((), True), ((0.0, 80.0), False)):
        found = curves_of(ring, WITHIN, edges)
        arcs = [curve for curve in found if isinstance(curve, Arc)]
        drawn = [curve.point(k / 200) for curve in arcs for k in range(201)]
        assert any(0.001 < y < 0.99 for _, y in drawn) == near
        outline = Polygon([c.point(k / 40) for c in found for k in range(40)]).exterior
        assert max(outline.distance(Point(p)) for p in ring) < WITHIN


def test_a_small_chamfer_stays() -> None:
    corners = [(0.0, 0.0), (100.0, 0.0), (100.0, 49.8), (99.8, 50.0), (0.0, 50.0)]
    found = curves_of(corners, WITHIN)
    assert len(found) == 5
