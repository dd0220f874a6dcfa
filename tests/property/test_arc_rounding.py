"""Arcs in written numbers: each stays the arc that it was, for every controller."""

from collections.abc import Callable
from math import cos, degrees, dist, log, pi, sin
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.controllers import table_run
from beamcam.controllers.codesys import arc_fault as codesys_fault
from beamcam.controllers.interpreter import arc_of
from beamcam.controllers.rs274.variants import VARIANTS
from beamcam.geometry.curves import Arc, Bezier, EllipseArc
from beamcam.machine import load
from beamcam.model.program import ArcFeed, EllipseFeed, Feed, Movement
from beamcam.motion.arcs import ellipse_feeds, parabola_feed, paths_along
from beamcam.motion.sheet import Pen
from tests.conftest import examples

COUNT = 20_000
SMALLEST, LARGEST = 0.05, 5000.0

Point = tuple[float, float]


def codesys_check(start: Point, end: Point, centre: Point, clockwise: bool) -> str | None:
    return codesys_fault(start, end, centre, 1e-3)


CHECKS: dict[str, Callable[[Point, Point, Point, bool], str | None]] = {
    "plate-codesys": codesys_check,
    "plate-linuxcnc": VARIANTS["linuxcnc"].arc_fault,
    "laser-grbl": VARIANTS["grbl"].arc_fault,
}


def random_arc(random: Random) -> Arc:
    """Radii and sweeps even in their logarithms, so that tiny and flat arcs are among them."""
    radius = SMALLEST * (LARGEST / SMALLEST) ** random.random()
    sweep = 360.0 if random.random() < 0.05 else 10 ** random.uniform(-3, log(360.0, 10))
    centre = (random.uniform(-1000, 1000), random.uniform(-1000, 1000))
    start = random.choice([0.0, 90.0, 180.0, 270.0, random.uniform(0, 360)])
    return Arc(centre, radius, start, random.choice([-1, 1]) * sweep)


def farthest(arc: Arc, start: Point, moves: list[Movement]) -> float:
    """How far the written moves leave the arc, at their ends and in their middles."""
    worst, here = 0.0, start
    for move in moves:
        end = (move.x, move.y)
        middle = ((here[0] + end[0]) / 2, (here[1] + end[1]) / 2)
        if isinstance(move, ArcFeed):
            written = arc_of(here, end, (here[0] + move.i, here[1] + move.j), move.clockwise)
            middle = written.point(0.5)
        for point in (middle, end):
            worst = max(worst, abs(dist(point, arc.centre) - arc.radius))
        here = end
    return worst


@pytest.mark.parametrize("machine", CHECKS)
def test_random_arcs(machine: str) -> None:
    """None beyond its controller's limit, none whose sweep flips, none far from where it was."""
    random = Random(machine)
    numbers = Pen(load(machine)).numbers
    check = CHECKS[machine]
    written = 0
    arcs = [random_arc(random) for _ in range(COUNT)]
    paths = paths_along([(arc,) for arc in arcs], numbers, lambda _, __: [])
    for number, (arc, path) in enumerate(zip(arcs, paths, strict=True)):
        here = start = path.start
        moves = path.moves
        assert start == numbers.at(arc.start)
        for move in moves:
            end = (move.x, move.y)
            if isinstance(move, ArcFeed):
                centre = (here[0] + move.i, here[1] + move.j)
                assert check(here, end, centre, move.clockwise) is None, (arc, move)
                assert move.clockwise == (arc.sweep_deg < 0), (arc, move)
                one = arc_of(here, end, centre, move.clockwise)
                # A step of the numbers, seen from the centre, is what a sweep may be longer.
                blur = degrees(6 * numbers.step / arc.radius)
                assert abs(one.sweep_deg) <= min(180.0, abs(arc.sweep_deg)) + blur, (arc, move)
                written += 1
            here = end
        assert dist(here, arc.end) <= 1.5 * numbers.step or not moves
        if number % 10:
            continue
        assert farthest(arc, start, moves) <= numbers.tolerance + 4 * numbers.step, arc
    assert written > COUNT / 3


def test_the_check_sees_a_flipped_arc() -> None:
    """With the centre rounded and not solved again, some of the same arcs are refused."""
    numbers = Pen(load("plate-codesys")).numbers
    random = Random(7)
    refused = 0
    for _ in range(3000):
        arc = random_arc(random)
        start, end = numbers.at(arc.start), numbers.at(arc.end)
        centre = (round(arc.centre[0], 1), round(arc.centre[1], 1))
        refused += start != end and codesys_check(start, end, centre, False) is not None
    assert refused > 100


finite = st.floats(-500, 500)


@settings(max_examples=examples(300), deadline=None)
@given(finite, finite, st.floats(1, 400), st.floats(0.05, 0.998), st.floats(0, 360),
       st.floats(0, 360), st.floats(5, 360), st.sampled_from([-1, 1]))  # fmt: skip
def test_ellipses_by_their_own_word(
    x: float, y: float, major: float, ratio: float, turn: float, start: float, sweep: float, s: int
) -> None:
    """What the controller solves from the written numbers lies on the ellipse, if it is written."""
    numbers = Pen(load("plate-codesys")).numbers
    axis = (major * cos(turn * pi / 180), major * sin(turn * pi / 180))
    ellipse = EllipseArc((x, y), axis, ratio, start, s * sweep)
    here = numbers.at(ellipse.start)
    moves = ellipse_feeds(here, ellipse, numbers)
    if moves is None:
        return
    words = "\n".join(
        f"G{8 if m.clockwise else 9:02} X{m.x:.3f} Y{m.y:.3f} I{m.i:.3f} J{m.j:.3f} K{m.angle:.4f} "
        f"R{m.ratio:.6f} F10"
        for m in moves
        if isinstance(m, EllipseFeed)
    )
    text = f"G90\nG99\nG00 X{here[0]:.3f} Y{here[1]:.3f}\n{words}\nM30\n"
    done, said = table_run(text, load("plate-codesys"))
    assert not said
    for event in done.events():
        curve = getattr(event, "curve", None)
        if not isinstance(curve, EllipseArc):
            continue
        assert abs(curve.sweep_deg) <= 95.0
        for k in range(9):
            px, py = curve.point(k / 8)
            u = ((px - x) * axis[0] + (py - y) * axis[1]) / major
            v = ((py - y) * axis[0] - (px - x) * axis[1]) / major
            size = ((u / major) ** 2 + (v / (ratio * major)) ** 2) ** 0.5
            assert abs(size - 1) * (u * u + v * v) ** 0.5 <= 12 * numbers.step


@settings(max_examples=examples(300), deadline=None)
@given(finite, finite, finite, finite, finite, finite)
def test_parabolas_by_their_vertex(
    x0: float, y0: float, x1: float, y1: float, x2: float, y2: float
) -> None:
    numbers = Pen(load("plate-codesys")).numbers
    curve = Bezier(((x0, y0), (x1, y1), (x2, y2)))
    here = numbers.at(curve.start)
    for move in parabola_feed(here, curve, numbers):
        if isinstance(move, Feed):
            continue
        i, j = getattr(move, "i", 0.0), getattr(move, "j", 0.0)
        text = (
            f"G90\nG99\nG00 X{here[0]:.3f} Y{here[1]:.3f}\n"
            f"G06 X{move.x:.3f} Y{move.y:.3f} I{i:.3f} J{j:.3f} F1\nM30\n"
        )
        done, said = table_run(text, load("plate-codesys"))
        assert not said
        (back,) = (e.curve for e in done.events() if isinstance(getattr(e, "curve", None), Bezier))
        for k in range(5):
            assert dist(back.point(k / 4), curve.point(k / 4)) <= 5 * numbers.step
