"""Slots that meet holes or other slots, or leave too little steel between them.

A slot is its core, a line or a rectangle, widened by half its width; a hole is a core of one point.
Keyholes are meant, so that what meets is told and not refused.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from math import hypot

from beamcam.errors import Diagnostic
from beamcam.geometry.plane import Point, unit_vector
from beamcam.machine.machine import Drill
from beamcam.model.part import Hole, Slot
from beamcam.planning.jobs import slot_ends
from beamcam.planning.operations import rules
from beamcam.planning.operations.hole_pairs import TOLERANCE

Shape = tuple[int, Hole | Slot]  #: index of the feature, on the face that it is made from


def judge_slots(shapes: Sequence[Shape], drill: Drill) -> Iterator[tuple[int, Diagnostic]]:
    """For each slot or hole that is too near an earlier one its index, and a warning."""
    for (_, one), (f, other) in combinations(sorted(shapes, key=lambda shape: shape[0]), 2):
        if one.face != other.face or not (isinstance(one, Slot) or isinstance(other, Slot)):
            continue
        left = core_distance(one, other) - (one.diameter + other.diameter) / 2
        if left < drill.min_edge_distance - TOLERANCE:
            yield f, rules.NEAR_EDGE.at(
                other.source, what=_named(other), x=f"{other.x:g}", y=f"{other.y:g}",
                face=other.face, apart=f"{max(left, 0.0):.3g}",
                where=f"{_named(one)} of {one.source}", expected=f"{drill.min_edge_distance:g}",
            )  # fmt: skip


def core_distance(one: Hole | Slot, other: Hole | Slot) -> float:
    """Distance between the cores of two shapes; 0 where they cross."""
    mine, theirs = _corners(one), _corners(other)
    if any(_cross(a, b) for a in _edges(mine) for b in _edges(theirs)):
        return 0.0
    return min(
        *(_from_core(other, corner) for corner in mine),
        *(_from_core(one, corner) for corner in theirs),
    )


def _corners(shape: Hole | Slot) -> tuple[Point, ...]:
    """The corners of a core, in order around it."""
    if isinstance(shape, Hole):
        return ((shape.x, shape.y),)
    found = slot_ends(shape)
    return (found[0], found[1], found[3], found[2]) if len(found) == 4 else found


def _edges(corners: tuple[Point, ...]) -> list[tuple[Point, Point]]:
    if len(corners) < 2:
        return []
    return list(zip(corners, (*corners[1:], corners[0]), strict=True))


def _from_core(shape: Hole | Slot, at: Point) -> float:
    """Distance of a point from the core of a shape; 0 inside."""
    dx, dy = at[0] - shape.x, at[1] - shape.y
    if isinstance(shape, Hole):
        return hypot(dx, dy)
    c, s = unit_vector(shape.angle)
    u, v = abs(c * dx + s * dy), abs(c * dy - s * dx)
    return hypot(max(u - shape.length / 2, 0.0), max(v - shape.height / 2, 0.0))


def _cross(one: tuple[Point, Point], other: tuple[Point, Point]) -> bool:
    """Whether two straight lines cross, their ends not counted."""

    def side(a: Point, b: Point, p: Point) -> float:
        return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])

    (a, b), (c, d) = one, other
    return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0


def _named(shape: Hole | Slot) -> str:
    if isinstance(shape, Slot):
        return f"a slot of width {shape.diameter:g}"
    return f"a hole of diameter {shape.diameter:g}"
