"""Planner and checker join the curves of a drawing by one definition, each in its own way."""

from collections.abc import Sequence
from math import cos, pi, sin

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.checks.sheets.joining import rings_of
from beamcam.checks.sheets.toolpaths import Toolpaths
from beamcam.geometry.chains import join_curves
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point

GAP = 0.05
CELL = 20.0
COLUMNS, ROWS = 4, 3

#: How far an end is off its place: written with three or more decimals, or drawn carelessly.
offsets = st.tuples(
    st.sampled_from([0.0, 0.0, 0.0, 0.0004, 0.003, 0.02, 0.045, 0.06, 0.09]), st.integers(0, 11)
)
corners = st.tuples(st.integers(0, COLUMNS - 1), st.integers(0, ROWS - 1))


def off(corner: tuple[int, int], by: tuple[float, int]) -> Point:
    away, turn = by[0], by[1] * pi / 6
    return corner[0] * CELL + away * cos(turn), corner[1] * CELL + away * sin(turn)


@st.composite
def nets(draw: st.DrawFn) -> list[Curve]:
    """Sides of the cells of a net, twigs, loops and specks at its corners, in any order."""
    found: list[Curve] = []
    sides = st.tuples(corners, st.sampled_from([(1, 0), (0, 1)]))
    for (x, y), (right, up) in draw(st.lists(sides, max_size=17, unique=True)):
        ends = [off((x, y), draw(offsets)), off((x + right, y + up), draw(offsets))]
        found.append(Line(*ends[:: draw(st.sampled_from([1, -1]))]))
    kinds = st.sampled_from(["twig", "loop", "speck"])
    for kind, corner in draw(st.lists(st.tuples(kinds, corners), max_size=3)):
        start, end = (off(corner, draw(offsets)) for _ in range(2))
        tip = (corner[0] * CELL + 5, corner[1] * CELL + 8)
        if kind == "speck":
            found += [Line(start, end)] if start != end else []
        else:
            found.append(Line(start, tip))
        if kind == "loop":
            far = (tip[0] + 3, tip[1])
            found += [Line(tip, far), Line(far, end)]
    return draw(st.permutations(found))


def planned(curves: Sequence[Curve]) -> set[frozenset[int]]:
    """The closed chains of the planner that are larger than the gap."""
    chains = join_curves(curves, GAP).chains
    return {frozenset(m for m in chain.members if m >= 0) for chain in chains if chain.closed}


def checked(curves: Sequence[Curve]) -> set[frozenset[int]]:
    """The closed contours of the checker, those of specks left out."""
    rings = rings_of(Toolpaths(list(curves), 0.002).whole(0.002), range(len(curves)), GAP)
    members = [[k for k, _ in ring] for ring in rings]
    return {
        frozenset(ring)
        for ring in members
        if np.hypot(*np.ptp([p for k in ring for p in (curves[k].start, curves[k].end)], axis=0))
        > GAP * (1 + 1e-6)
    }


@settings(deadline=None)
@given(nets())
def test_planner_and_checker_close_the_same(curves: list[Curve]) -> None:
    specks = {
        k
        for k, curve in enumerate(curves)
        if np.hypot(curve.end[0] - curve.start[0], curve.end[1] - curve.start[1]) <= 1e-3
    }
    assert {ring - specks for ring in planned(curves)} == checked(curves)


def test_a_twig_within_the_gap_of_a_corner_is_no_part_of_it() -> None:
    corner = [Line((0, 0), (9, 0)), Line((9, 0), (9, 9)), Line((9, 9), (0, 0))]
    twig = Line((9.03, 0), (12, -4))
    assert planned([*corner, twig]) == checked([*corner, twig]) == {frozenset({0, 1, 2})}


def test_a_ring_with_arrowheads_between_its_sides() -> None:
    """The arrowheads close, each upon the corner that it stands on; the sides go on past them."""
    square = [(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (0.0, 20.0)]
    curves: list[Curve] = [Line(a, b) for a, b in zip(square, square[1:] + square[:1], strict=True)]
    for x, y in square[:2]:
        curves += [
            Line((x, y), (x + 2, y - 4)), Line((x + 2, y - 4), (x - 2, y - 4)),
            Line((x - 2, y - 4), (x, y)),
        ]  # fmt: skip
    expected = {frozenset(range(4)), frozenset({4, 5, 6}), frozenset({7, 8, 9})}
    assert planned(curves) == checked(curves) == expected


def test_a_loop_that_a_twig_ends_on_hangs_on_a_tail() -> None:
    """Without the twig the loop leads back to its place, without the loop the tail to nowhere."""
    loop = [Line((0, 0), (5, 5)), Line((5, 5), (-5, 5)), Line((-5, 5), (0, 0))]
    curves: list[Curve] = [*loop, Line((5, 5), (9, 9)), Line((0, 0), (0, -9))]
    assert planned(curves) == checked(curves) == {frozenset({0, 1, 2})}
    assert join_curves(curves, GAP).junctions == ()


def test_lines_of_a_hatch_are_not_joined() -> None:
    """Their ends lie nearer to one another than the gap, in a row."""
    hatch: list[Curve] = [
        Line((0.032 * k, 0.032 * k), (3 - 0.032 * k, 0.032 * k)) for k in range(1, 47)
    ]
    assert checked(hatch) == planned(hatch) == set()
    assert [chain.members for chain in join_curves(hatch, GAP).chains] == [(k,) for k in range(46)]
