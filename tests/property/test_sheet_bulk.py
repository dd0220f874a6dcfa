"""What the read-back of tables does in bulk is what it would do one by one."""

from itertools import pairwise
from math import atan2, cos, hypot, pi, radians, sin
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import astuple
from numpy.typing import NDArray

from beamcam.checks.sheets.toolpaths import Toolpaths
from beamcam.checks.sheets.work import widest_gap
from beamcam.controllers import table_events
from beamcam.controllers.codesys import arc_fault as codesys_fault
from beamcam.controllers.events import TableEvent
from beamcam.controllers.moves import sure_arcs
from beamcam.controllers.rs274.variants import VARIANTS
from beamcam.controllers.track import scan
from beamcam.geometry.curves import Arc, Bezier, BSpline, Curve, Line
from beamcam.machine import load
from tests.conftest import examples

numbers = st.decimals(-9999, 9999, places=4).map(lambda d: f"{d.normalize():f}")


@given(st.lists(st.tuples(st.integers(0, 1), numbers, numbers), min_size=2, max_size=30))
def test_numbers_are_read_as_python_reads_them(rows: list[tuple[int, str, str]]) -> None:
    text = "".join(f"G{motion} X{x} Y{y}\n" for motion, x, y in rows) + "M2\n"
    plain, others, lines = scan(text)
    assert lines == len(rows) + 1
    # The first move and the last line are left to be read one by one.
    assert [line for line, _ in others] == [1, len(rows) + 1]
    assert plain.motion.tolist() == [motion for motion, _, _ in rows[1:]]
    assert plain.end.tolist() == [[float(x), float(y)] for _, x, y in rows[1:]]


LINES = [
    "G1 X1 Y2", "G0 X-1.5 Y.5", "G2 X1 Y1 I1 J1", "N7 G03 X1 Y1 I0 J-1 F600", "G1 X1", "G1 X1 Y2 ",
    "G1  X1 Y2", "g1 X1 Y2", "G1X1Y2", "G1 X1 Y2 (a)", "", "%", "M3 S1", "G1 X1.2.3 Y1", "G1 X. Y1",
    "G1 X+ Y1", "G4 P1", "G1 X1 Y2 I1 J1", "G2 X1 Y1", "G1.5 X1 Y1", "N1.5 G1 X1 Y1", "(a X1",
    "G1 X1 Y2 Z3", "G1 Y1 X2", "N1 G1 X1 Y1", "X1 Y1", "\xe9", "G1 X1.00000000000000001 Y0",
    "G1 X1 Y1 F5", "G4 X1 Y1",
]  # fmt: skip
PLAIN = {
    "G1 X1 Y2", "G2 X1 Y1 I1 J1", "N7 G03 X1 Y1 I0 J-1 F600", "N1 G1 X1 Y1", "G1 X1 Y1 F5",
    "G0 X-1.5 Y.5",
}  # fmt: skip


@given(st.lists(st.sampled_from(LINES), min_size=1, max_size=30))
def test_each_line_is_plain_or_odd(lines: list[str]) -> None:
    lines = ["G1 X0 Y0", *lines, "M2"]
    moves, others, _ = scan("\n".join(lines) + "\n")
    plain = [k for k, line in enumerate(lines, 1) if line in PLAIN and k > 1]
    assert moves.line.tolist() == plain
    rest = [k for k in range(1, len(lines) + 1) if k not in plain]
    assert others == [(k, lines[k - 1]) for k in rest]


def unlike(text: str, machine: str, random: Random) -> str:
    """The same program in other words, so that no block is plain."""
    lines = []
    for line in text.split("\n"):
        other = random.choice([line.lower(), line + " ", line.replace(" ", "  "), line + " (a)"])
        if machine != "plate-codesys":
            other = random.choice([other, line.replace(" ", ""), f" {line}"])
        lines.append(other if line.strip("%") else line)
    return "\n".join(lines)


def walk(machine: str, random: Random) -> str:
    """A program that goes anywhere, with modes that change and moves that are none."""
    head = {"plate-codesys": "G90\nG99", "plate-linuxcnc": "G21 G17 G90 G91.1 G40 G94"}
    lines = [head.get(machine, "G21 G17 G90 G94"), "G0 X0 Y0"]
    for _ in range(80):
        x, y, r, a = random.randint(-90, 90), random.randint(-90, 90), random.random() * 9, 0.3
        kind = random.randrange(10)
        feed = random.choice(["", "", f" F{random.randint(1, 900)}"])
        if kind < 5:
            lines.append(f"G{1 if feed else kind % 2} X{x} Y{y / 8}{feed}")
        elif kind < 8:
            i, j = r * cos(a * x), r * sin(a * x)
            lines.append(f"G0{kind % 2 + 2} X{x} Y{y} I{i:.3f} J{j:.3f}{feed}")
            lines.append(f"G1 X{x} Y{y}")
            lines.append(f"G0{kind % 2 + 2} X{x + 2 * round(i, 3)} Y{y} I{i:.3f} J0{feed}")
        else:
            lines.append(random.choice(["M5", "G91", "G90", "", "(a)", "M3", "G1 X5 Y5 Y6"]))
    return "\n".join([*lines, random.choice(["M2\nG1 X1 Y1", "M2", "G1 X1 Y1"]), ""])


def flat(event: TableEvent) -> list[object]:
    """All numbers and words of an event."""
    found: list[object] = [type(event).__name__]
    for value in astuple(event):
        if isinstance(value, Arc):
            found += [*value.centre, value.radius, value.sweep_deg % 360.0]
        else:
            found += value if isinstance(value, tuple) else [value]
    rounded = [round(v, 6) if isinstance(v, float) else v for v in found]
    return [None if v != v else v for v in rounded]


@pytest.mark.parametrize("name", ["plate-codesys", "plate-linuxcnc", "laser-grbl"])
def test_plain_blocks_say_what_others_say(name: str) -> None:
    """However a block is written, the same events follow, and the same faults on the same lines."""
    machine = load(name)
    legs = faults = 0
    for seed in range(30):
        random = Random(seed)
        text = walk(name, random)
        events, said = table_events(text, machine)
        others, more = table_events(unlike(text, name, random), machine)
        assert [flat(e) for e in events] == [flat(e) for e in others]
        assert sorted((d.source.line or 0, d.code) for d in said) == sorted(
            (d.source.line or 0, d.code) for d in more
        )
        legs, faults = legs + len(events), faults + len(said)
    assert legs > 1000
    assert faults > 50


@settings(max_examples=examples(500))
@given(*[st.floats(-50, 50)] * 4, st.floats(0.01, 100), st.floats(-0.02, 0.02), st.booleans())
def test_no_controller_refuses_a_sure_arc(
    x: float, y: float, u: float, v: float, radius: float, off: float, clockwise: bool
) -> None:
    start, angle = (x, y), atan2(v, u)
    centre = (x - radius, y)
    end = (centre[0] + (radius + off) * cos(angle), centre[1] + (radius + off) * sin(angle))
    ends = (np.array([p]) for p in (start, end, centre))
    one, other, middle = ends
    if sure_arcs(one, other, middle, 0.005)[0]:
        assert VARIANTS["grbl"].arc_fault(start, end, centre, clockwise) is None
        assert VARIANTS["linuxcnc"].arc_fault(start, end, centre, clockwise) is None
    if sure_arcs(one, other, middle, 2 * 2**0.5 * 1e-3)[0]:
        assert codesys_fault(start, end, centre, 1e-3) is None


def test_most_arcs_are_sure() -> None:
    """Arcs whose numbers are rounded to 0.001 mm need not be asked about."""
    random = np.random.default_rng(1)
    centre, radius = random.uniform(-500, 500, (5000, 2)), random.uniform(1, 200, 5000)
    first, last = random.uniform(0, 2 * pi, (2, 5000))
    start, end = (
        np.round(centre + radius[:, None] * np.column_stack((np.cos(a), np.sin(a))), 3)
        for a in (first, last)
    )
    assert sure_arcs(start, end, np.round(centre, 3), 0.005).mean() > 0.98


def random_curves(random: Random, count: int) -> list[Curve]:
    found: list[Curve] = []
    for _ in range(count):
        a, b = ((random.uniform(0, 60), random.uniform(0, 60)) for _ in range(2))
        if random.random() < 0.5:
            found.append(Line(a, b))
        else:
            sweep = random.choice([360.0, -360.0, random.uniform(-359, 359) or 1.0])
            found.append(Arc(a, random.uniform(0.1, 20), random.uniform(0, 360), sweep))
    return found


def distance(curve: Curve, p: tuple[float, float]) -> float:
    """How far a point is from a line or an arc, by the book."""
    if isinstance(curve, Arc):
        cx, cy = curve.centre
        turn = (atan2(p[1] - cy, p[0] - cx) - radians(curve.start_deg)) * (
            1 if curve.sweep_deg > 0 else -1
        )
        if turn % (2 * pi) <= abs(radians(curve.sweep_deg)):
            return abs(hypot(p[0] - cx, p[1] - cy) - curve.radius)
        return min(hypot(p[0] - e[0], p[1] - e[1]) for e in (curve.start, curve.end))
    (ax, ay), (bx, by) = curve.start, curve.end
    dx, dy = bx - ax, by - ay
    t = max(0.0, min(1.0, ((p[0] - ax) * dx + (p[1] - ay) * dy) / (dx * dx + dy * dy)))
    return hypot(p[0] - ax - t * dx, p[1] - ay - t * dy)


@pytest.mark.parametrize("seed", range(12))
def test_what_is_near_is_found(seed: int) -> None:
    """The pairs of the grid are those of all points with all curves."""
    random = Random(seed)
    curves = random_curves(random, 40)
    points = [(random.uniform(-5, 65), random.uniform(-5, 65)) for _ in range(200)]
    reach = random.choice([0.05, 1.0, 7.0])
    pairs = Toolpaths(curves, 0.01).near(np.array(points), reach)
    found = dict(
        zip(zip(pairs.point.tolist(), pairs.element.tolist(), strict=True), pairs.away, strict=True)
    )
    for i, point in enumerate(points):
        for k, curve in enumerate(curves):
            away = distance(curve, point)
            if abs(away - reach) > 1e-9:
                assert ((i, k) in found) == (away < reach)
            if (i, k) in found:
                assert found[i, k] == pytest.approx(away, abs=1e-9)
    away, who = Toolpaths(curves, 0.01).nearest(np.array(points))
    for i, point in enumerate(points):
        every = [distance(curve, point) for curve in curves]
        assert away[i] == pytest.approx(min(every), abs=1e-9)
        assert every[who[i]] == pytest.approx(min(every), abs=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_what_was_moved_is_near_where_it_lies_now(seed: int) -> None:
    """Curves with a grid, moved, against all distances; spikes have more than one size of cells."""
    random = Random(seed)
    spikes: list[Curve] = [Line((0.3 * k, 0.0), (0.3 * k + 0.1, 14.0)) for k in range(60)]
    curves = [*spikes, *random_curves(random, 20)]
    reach = random.choice([0.05, 0.5])
    x, y = random.uniform(-900, 900), random.uniform(-900, 900)
    points = [(random.uniform(-2, 20), random.uniform(-2, 16)) for _ in range(150)]
    still = Toolpaths(curves, 0.01)
    still.near(np.array(points), reach)
    pairs = still.moved((x, y)).near(np.add(points, (x, y)), reach)
    near = dict(
        zip(zip(pairs.point.tolist(), pairs.element.tolist(), strict=True), pairs.away, strict=True)
    )
    for i, point in enumerate(points):
        for k, curve in enumerate(curves):
            away = distance(curve, point)
            if abs(away - reach) > 1e-9:
                assert ((i, k) in near) == (away < reach)
            if (i, k) in near:
                assert near[i, k] == pytest.approx(away, abs=1e-9)


near_places = st.tuples(st.integers(-30, 30), st.integers(-30, 30))


@given(st.lists(near_places, max_size=30), st.sampled_from([0.0, 0.05, 0.1, 0.3]))
def test_the_widest_gap_is_that_of_all_pairs(places: list[tuple[int, int]], reach: float) -> None:
    points = np.array(places, dtype=np.float64).reshape(-1, 2) / 37
    each = [hypot(*(a - b)) for a in points for b in points]
    expected = max((apart for apart in each if apart <= reach), default=0.0)
    assert widest_gap(points, reach) == pytest.approx(expected, abs=1e-12)


coordinates = st.floats(-50, 50)


@st.composite
def splines(draw: st.DrawFn) -> BSpline:
    """Splines of any degree, even and uneven, clamped or not."""
    degree = draw(st.integers(1, 5))
    control = draw(
        st.lists(st.tuples(coordinates, coordinates), min_size=degree + 1, max_size=degree + 8)
    )
    size = len(control) + degree
    steps = draw(st.lists(st.floats(0.2, 3), min_size=size, max_size=size))
    knots = np.concatenate(([0.0], np.cumsum(steps)))
    if draw(st.booleans()):
        knots[: degree + 1], knots[-degree - 1 :] = knots[degree], knots[-degree - 1]
    return BSpline(degree, tuple(control), tuple(knots.tolist()))


free_curves = st.one_of(
    splines(),
    st.lists(st.tuples(coordinates, coordinates), min_size=2, max_size=5).map(
        lambda points: Bezier(tuple(points))
    ),
)


@settings(max_examples=examples(60), deadline=None)
@given(st.lists(free_curves, min_size=1, max_size=3))
def test_what_splines_are_drawn_with(curves: list[BSpline | Bezier]) -> None:
    """No place of a curve is farther from its arcs and chords than it may be, nor one of these."""
    drawn = Toolpaths(curves, 0.01)
    for k, curve in enumerate(curves):
        one = Toolpaths([curve], 0.01)
        assert drawn.lengths[k] == pytest.approx(one.lengths[0])
        assert one.starts[0] == pytest.approx(curve.start, abs=1e-8)
        assert one.ends[0] == pytest.approx(curve.end, abs=1e-8)
        ends, starts = one.elements.end[:-1], one.elements.start[1:]
        assert np.hypot(*(starts - ends).T).max(initial=0.0) <= 1e-8
        fine = np.array([curve.point(i / 600) for i in range(601)])
        away, _ = one.nearest(fine[::5])
        assert away.max() <= 0.01 + 1e-9
        element, share, _ = one.samples(one.lengths[0] / 90 + 1e-6)
        places = one.elements.places(element, share)
        back, _ = Toolpaths(_lines_through(fine), 0.01).nearest(places)
        assert back.max() <= 0.01 + _max_sagitta(fine) + 1e-9


def _lines_through(points: NDArray[np.float64]) -> list[Curve]:
    rows = list(map(tuple, points.tolist()))
    return [Line(a, b) for a, b in pairwise(rows)]


def _max_sagitta(points: NDArray[np.float64]) -> float:
    """How far a curve is from the chords between points of equal steps on it at most.

    An eighth of a second difference where it is smooth, half of one where it has a corner.
    """
    second = points[2:] - 2 * points[1:-1] + points[:-2]
    return float(np.hypot(*second.T).max()) / 2


def test_a_cusp_is_drawn_to_its_tip() -> None:
    cusp = Bezier(((0.0, 0.0), (10.0, 10.0), (0.0, 10.0), (10.0, 0.0)))
    tip = np.array([[5.0, 7.5]])
    assert Toolpaths([cusp], 0.0025).nearest(tip)[0][0] <= 0.0025
