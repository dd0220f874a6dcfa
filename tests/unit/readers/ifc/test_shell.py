"""Shells in arrays: what they hold, where they are cut, which way they run."""

from math import cos, pi, radians, sin
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon, box, union_all

from beamcam.readers.ifc.region import pieces_of, region_within
from beamcam.readers.ifc.shell import (
    Shell,
    broadest_normal,
    extent,
    longest_direction,
    section,
    shell,
)
from beamcam.readers.ifc.space import IDENTITY, Frame, Vec, cross, dot, unit
from tests.conftest import examples

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
Ring = list[Vec]


def hollows(shape: Any) -> int:
    """How many hollows a region has, without those that are no more than a line."""
    return sum(Polygon(r).area > 1e-9 for piece in pieces_of(shape) for r in piece.interiors)


def shell_by(faces: list[list[Ring]]) -> Shell:
    rings = [ring for face in faces for ring in face]
    numbers = [k for k, face in enumerate(faces) for _ in face]
    points = np.array([p for ring in rings for p in ring])
    return shell(points, [len(ring) for ring in rings], numbers)


def prism(outline: list[tuple[float, float]], low: float, high: float) -> list[list[Ring]]:
    """The faces of an outline (counter-clockwise in x and y) pushed along z, turned outwards."""
    sides = [
        [[(*a, low), (*b, low), (*b, high), (*a, high)]]
        for a, b in zip(outline, outline[1:] + outline[:1], strict=True)
    ]
    return [[[(*p, low) for p in reversed(outline)]], [[(*p, high) for p in outline]], *sides]


def block(x: float, y: float, z: float, at: Vec = (0.0, 0.0, 0.0)) -> list[list[Ring]]:
    a, b, c = at
    return prism([(a, b), (a + x, b), (a + x, b + y), (a, b + y)], c, c + z)


def drilled(radius: float, corners: int) -> list[list[Ring]]:
    """A block of 100 by 60 by 10 with a round hole of so many corners."""
    round_ = [
        (50 + radius * cos(2 * pi * i / corners), 30 + radius * sin(2 * pi * i / corners))
        for i in range(corners)
    ]
    faces = block(100, 60, 10)
    walls = prism(round_[::-1], 0, 10)
    for face, low in zip(faces[:2], (0.0, 10.0), strict=True):
        face.append([(*p, low) for p in round_])
    return faces + walls[2:]


lengths = st.floats(1.0, 900.0)
turns = st.floats(-180.0, 180.0)


@st.composite
def frames(draw: Any) -> Frame:
    """Somewhere and turned any way."""
    a, b = radians(draw(turns)), radians(draw(turns))
    x = (cos(a) * cos(b), sin(a) * cos(b), sin(b))
    y = unit(cross(Z, x)) if abs(x[2]) < 0.99 else unit(cross(X, x))
    return Frame((draw(turns), draw(turns), draw(turns)), x, y, cross(x, y))


@settings(max_examples=examples(60), deadline=None)
@given(lengths, lengths, lengths, frames(), st.floats(0.01, 0.99))
def test_a_block_is_one_wherever_it_stands(
    x: float, y: float, z: float, frame: Frame, share: float
) -> None:
    there = shell_by(block(x, y, z)).moved(frame)
    assert there.volume == pytest.approx(x * y * z, rel=1e-9)
    low, high = extent(there, frame.x)
    assert high - low == pytest.approx(x, abs=1e-9)
    at = frame.point((share * x, 0.0, 0.0))
    assert section(there, at, frame.x, frame.y, frame.z).area == pytest.approx(y * z, rel=1e-9)
    back = there.moved(frame.inverse())
    assert np.abs(back.points - shell_by(block(x, y, z)).points).max() < 1e-9
    along, most = longest_direction(there), max(x, y, z)
    near = [way for way, value in ((frame.x, x), (frame.y, y), (frame.z, z)) if value == most]
    assert max(abs(dot(along, way)) for way in near) > 1 - 1e-6


@settings(max_examples=examples(40), deadline=None)
@given(st.floats(5.0, 25.0), st.integers(5, 40), frames())
def test_hollows_are_taken_off_whichever_way_they_run(
    radius: float, corners: int, frame: Frame
) -> None:
    hole = corners / 2 * radius**2 * sin(2 * pi / corners)
    there = shell_by(drilled(radius, corners)).moved(frame)
    assert there.volume == pytest.approx((6000 - hole) * 10, rel=1e-9)
    assert sorted(there.areas)[-2:] == pytest.approx([6000 - hole] * 2, rel=1e-9)
    shape = section(there, frame.point((0.0, 0.0, 5.0)), frame.z, frame.x, frame.y)
    assert shape.area == pytest.approx(6000 - hole, rel=1e-6)
    assert hollows(shape) == 1
    assert abs(dot(broadest_normal(there), frame.z)) > 1 - 1e-9


def test_a_shell_with_a_gap_or_a_turned_face_has_no_volume() -> None:
    faces = block(30, 20, 10)
    assert shell_by(faces).volume == pytest.approx(6000)
    assert shell_by(faces[1:]).volume is None
    assert shell_by([[faces[0][0][::-1]], *faces[1:]]).volume is None


def test_what_is_no_face_is_left_out() -> None:
    """Corners that repeat, rings of two corners, faces without an area."""
    faces = block(30, 20, 10)
    first = faces[0][0]
    repeated: list[list[Ring]] = [[[first[0], *first, first[-1]]], *faces[1:]]
    line: list[Ring] = [[(0.0, 0.0, 0.0), (5.0, 0.0, 0.0), (9.0, 0.0, 0.0)]]
    stroke: list[Ring] = [[(0.0, 0.0, 0.0), (5.0, 0.0, 0.0), (5.0, 0.0, 0.0)]]
    found = shell_by([line, *repeated[:3], stroke, *repeated[3:], line])
    plain = shell_by(faces)
    assert found.count == plain.count == 6
    assert found.points.tolist() == plain.points.tolist()
    assert found.area_normals.tolist() == plain.area_normals.tolist()
    assert found.volume == plain.volume
    assert shell_by([line, stroke]).count == 0


def test_where_boxes_touch_there_is_no_wall() -> None:
    """Faces that lie twice on each other vanish, and a vertex on the plane is just above it."""
    both = shell_by(block(10, 10, 10) + block(10, 10, 10, (10.0, 0.0, 0.0)))
    assert both.volume == pytest.approx(2000)
    for height in (0.1, 5.0, 10.0):
        assert section(both, (0.0, 0.0, height), Z, X, Y).equals(box(0, 0, 20, 10))
    for height in (-0.1, 0.0, 10.1):
        assert section(both, (0.0, 0.0, height), Z, X, Y).is_empty


def test_the_box_of_a_shell() -> None:
    assert shell_by(block(3, 2, 1, (5.0, 6.0, 7.0))).box == ((5.0, 6.0, 7.0), (8.0, 8.0, 8.0))
    assert shell_by(block(3, 2, 1)).moved(IDENTITY).box == ((0.0, 0.0, 0.0), (3.0, 2.0, 1.0))


def lines_of(*polygons: Any) -> Any:
    found = [
        (a, b)
        for polygon in polygons
        for ring in (polygon.exterior, *polygon.interiors)
        for a, b in zip(ring.coords[:-1], ring.coords[1:], strict=True)
    ]
    return np.array(found)


@settings(max_examples=examples(60), deadline=None)
@given(st.lists(st.tuples(*[st.integers(0, 12)] * 4), min_size=1, max_size=6))
def test_regions_that_overlap_are_inside_an_odd_number_of_times(
    corners: list[tuple[int, int, int, int]],
) -> None:
    """As many crossings as there are boxes around a place; equal boxes take each other away."""
    boxes = [box(x, y, x + w + 1, y + h + 1) for x, y, w, h in corners]
    wanted = union_all([])
    for one in boxes:
        wanted = wanted.symmetric_difference(one)
    found = region_within(lines_of(*boxes))
    assert found.symmetric_difference(wanted).area < 1e-9


def test_a_hollow_that_is_no_more_than_a_line_does_not_count() -> None:
    room = [(10, 10), (20, 10), (15, 20)]
    line = [(30, 10), (30.000004, 10), (30, 10.000004)]
    assert hollows(Polygon(box(0, 0, 50, 50).exterior, [room, line])) == 1
    assert hollows(union_all([box(0, 0, 5, 5), box(9, 9, 12, 12)])) == 0


def test_the_first_of_equal_directions_is_taken() -> None:
    """So that a cube lies the same way on every run."""
    cube = shell_by(block(7, 7, 7))
    first = cube.points[0] - cube.points[3]
    assert longest_direction(cube) == tuple(first / 7)
    assert broadest_normal(cube) == pytest.approx((0.0, 0.0, -1.0))
