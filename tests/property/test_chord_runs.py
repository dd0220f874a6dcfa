"""Arcs for runs of short chords: never farther from them than the tolerance, and fewer."""

from itertools import pairwise
from math import cos, dist, hypot, pi, sin

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from beamcam.geometry import polylines
from beamcam.geometry.curves import Arc, Curve
from beamcam.geometry.polylines import (
    LEAST_ARC,
    LEAST_RUN,
    LONGEST,
    kept_chords,
    longest_arc,
    longest_line,
    refit_runs,
)
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from tests.conftest import examples
from tests.distances import distances
from tests.unit.sheets.parts import box, contour, drawing, lines

Place = tuple[float, float]


def chain(points: list[Place], closed: bool) -> tuple[Curve, ...]:
    return lines(*points, closed=closed)


def cam(count: int, size: float, lobes: int, depth: float) -> list[Place]:
    """Places on a curve without corners."""
    found = []
    for k in range(count):
        a = 2 * pi * k / count
        r = size * (1 + depth * cos(lobes * a))
        found.append((100 + r * cos(a), 100 + r * sin(a)))
    return found


def polyline(curves: tuple[Curve, ...]) -> list[Place]:
    """Places along curves, chords of arcs a tenth of a micrometre off at most."""
    points = [curves[0].start]
    for curve in curves:
        count = 1
        if isinstance(curve, Arc):
            count = max(
                2, int(abs(curve.sweep_deg) / 180 * pi / (8 * 1e-4 / curve.radius) ** 0.5) + 1
            )
        points += [curve.point((k + 1) / count) for k in range(count)]
    return points


def apart(one: list[Place], other: list[Place]) -> float:
    """The Hausdorff distance of two polylines, by a stranger."""
    a, b = (shapely.segmentize(shapely.LineString(points), 0.2) for points in (one, other))
    return max(float(distances(shapely.get_coordinates(x), y).max()) for x, y in ((a, b), (b, a)))


shapes = st.builds(
    cam, st.integers(8, 400), st.floats(2, 80), st.integers(0, 6), st.floats(0, 0.15)
)
jagged = st.lists(st.tuples(st.floats(0, 9), st.floats(0, 9)), min_size=3, max_size=40, unique=True)


@settings(max_examples=examples(150), deadline=None)
@given(points=st.one_of(shapes, jagged), closed=st.booleans(), tolerance=st.floats(0.001, 0.1))
def test_arcs_lie_within_the_tolerance_of_the_chords(
    points: list[Place], closed: bool, tolerance: float
) -> None:
    drawn = chain(points, closed)
    (found,) = refit_runs([drawn], tolerance)
    assert len(found) <= len(drawn)
    assert dist(found[0].start, drawn[0].start) < 1e-6
    assert dist(found[-1].end, drawn[-1].end) < 1e-6
    for a, b in pairwise(found):
        assert dist(a.end, b.start) < 1e-6
    assert apart(polyline(drawn), polyline(found)) <= tolerance + 2e-4
    if closed and len(found) > 2:
        areas = [shapely.Polygon(polyline(some)) for some in (drawn, found)]
        assert abs(areas[0].area - areas[1].area) <= tolerance * areas[0].length + 1e-6


@settings(max_examples=examples(50), deadline=None)
@given(points=jagged, tolerance=st.floats(0.001, 0.1))
def test_long_lines_and_corners_stay(points: list[Place], tolerance: float) -> None:
    """What is no run of short chords is not touched."""
    far = [(x * 10, y * 10) for x, y in points]
    if any(dist(a, b) <= LONGEST for a, b in pairwise([*far, far[0]])):
        return
    unchanged = [chain(far, True), box(0, 0, 2, 2)]
    assert refit_runs(unchanged, tolerance) == unchanged


@settings(max_examples=examples(30), deadline=None)
@given(drawn=st.lists(st.one_of(shapes, jagged), min_size=2, max_size=5))
def test_chains_together_become_what_each_becomes_alone(drawn: list[list[Place]]) -> None:
    chains = [chain(points, False) for points in drawn]
    alone = [refit_runs([one], 0.02)[0] for one in chains]
    assert refit_runs(chains, 0.02) == alone


@settings(max_examples=examples(100), deadline=None)
@given(points=st.one_of(shapes, jagged), tolerance=st.floats(0.001, 0.1))
def test_where_a_chord_is_known_to_stay_nothing_longer_begins(
    points: list[Place], tolerance: float
) -> None:
    assume(len(points) > LEAST_RUN)
    places = np.array(points)
    for at, stays in enumerate(*kept_chords([places], tolerance)):
        arc, _ = longest_arc(places, at, LEAST_ARC, lambda run: polylines._arc_over(run, tolerance))
        line = longest_line(places, at, lambda run: polylines._is_straight(run, tolerance))
        assert not stays or (arc is None and line == at + 1)


def test_sharp_corners_are_known_to_stay_and_a_cam_is_not() -> None:
    zigzag = np.array([(float(k), 2.0 * (k % 2)) for k in range(20)])
    assert all(*kept_chords([zigzag], 0.02))
    (kept,) = kept_chords([np.array(cam(200, 60, 2, 0.1))], 0.02)
    assert not any(kept[:-4])


def test_three_thousand_chords_of_a_cam_are_a_few_arcs() -> None:
    part = drawing(contour(chain(cam(3000, 60, 2, 0.15), True)), thickness=3.0)
    for name, most in (("plate-linuxcnc", 90), ("plate-codesys", 90), ("laser-grbl", 90)):
        machine = with_torch(load(name), thickness=3.0)
        text = post((part,), machine).text
        assert text.count("X") < most


@pytest.mark.parametrize("name", ["plate-linuxcnc", "plate-codesys", "laser-grbl"])
@settings(max_examples=examples(15), deadline=None)
@given(points=shapes)
def test_the_read_back_holds_it_against_the_chords(name: str, points: list[Place]) -> None:
    """None is refused; one whose arcs bulge by three tolerances more is."""
    if min(hypot(x - 100, y - 100) for x, y in points) < 6:
        return
    part = drawing(contour(chain(points, True)), thickness=3.0)
    machine = with_torch(load(name), thickness=3.0)
    text = post((part,), machine).text
    assert not read_back(text, Request((part,), machine))
    off = [1 + 0.05 / hypot(x - 100, y - 100) for x, y in points]
    grown = [
        (100 + (x - 100) * k, 100 + (y - 100) * k) for (x, y), k in zip(points, off, strict=True)
    ]
    other = drawing(contour(chain(grown, True)), thickness=3.0)
    centred = with_torch(machine, place="drawn")
    wrong = post((other,), centred).text
    assert read_back(wrong, Request((part,), centred))
