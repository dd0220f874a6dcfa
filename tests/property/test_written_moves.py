"""Lines and arcs in written numbers, many chains at once."""

from decimal import ROUND_HALF_EVEN, Decimal
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from beamcam.controllers.interpreter import arc_of
from beamcam.emitters.cutting import lines
from beamcam.emitters.gcode import number
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.program import ArcFeed, Feed, Movement, Program, ToolOn, Traverse
from beamcam.motion.arcs import Numbers, paths_along
from beamcam.motion.sheet import Pen
from tests.conftest import examples
from tests.unit.sheets.parts import NESTED, table

#: Coordinates that lie on the written steps, between two of them, or anywhere.
coordinates = st.one_of(
    st.integers(-2000, 2000).map(lambda n: n / 100),
    st.integers(-20_000_000, 20_000_000).map(lambda n: n * 5e-5),
    st.floats(-1e4, 1e4),
)
points = st.tuples(coordinates, coordinates)
angles = st.one_of(st.sampled_from([0.0, 90.0, 180.0, 270.0]), st.floats(-360.0, 360.0))
sweeps = st.one_of(st.sampled_from([90.0, 180.0, 360.0]), st.floats(1e-3, 360.0))
radii = st.one_of(st.floats(1e-4, 1e4), st.integers(1, 10_000).map(lambda n: n * 5e-4))
arcs = st.builds(
    lambda centre, radius, start, sweep, side: Arc(centre, radius, start, side * sweep),
    points, radii, angles, sweeps, st.sampled_from([-1.0, 1.0]),
)  # fmt: skip
chains = st.lists(
    st.lists(st.one_of(st.builds(Line, points, points), arcs), min_size=1, max_size=6),
    min_size=1, max_size=4,
)  # fmt: skip
MACHINES = ("plate-linuxcnc", "plate-codesys", "laser-grbl")


def no_word(here: object, curve: Curve) -> list[Movement]:
    raise AssertionError("lines and arcs only")


def numbers_of(machine: str) -> Numbers:
    return Pen(load(machine)).numbers


@settings(max_examples=examples(300), deadline=None)
@given(st.lists(coordinates, min_size=2, max_size=20), st.integers(0, 4))
def test_numbers_are_rounded_by_their_exact_decimals(values: list[float], decimals: int) -> None:
    numbers = Numbers(decimals, 3, 0.01, 0.005, 0.01, 1e5)
    step = Decimal(1).scaleb(-decimals)
    exact = [float(Decimal(v).quantize(step, ROUND_HALF_EVEN)) + 0.0 for v in values]
    found = numbers.rounded(np.array(values)).tolist()
    assert list(map(repr, found)) == list(map(repr, exact))  # -0.0 is another number here


@pytest.mark.parametrize("machine", MACHINES)
@settings(max_examples=examples(50), deadline=None)
@given(found=chains)
def test_each_curve_is_followed_to_its_end(machine: str, found: list[list[Curve]]) -> None:
    """In the order of the chain, and nothing between that lies nowhere near it."""
    numbers = numbers_of(machine)
    paths = list(paths_along(found, numbers, no_word))
    assert len(paths) == len(found)
    for chain, path in zip(found, paths, strict=True):
        ends = [path.start, *((m.x, m.y) for m in path.moves)]
        assert all(a != b for a, b in pairwise(ends)) or any(
            isinstance(m, ArcFeed) for m in path.moves
        )
        at = 0
        assert path.start == pytest.approx(chain[0].start, abs=0.6 * numbers.step)
        for curve in chain:
            near = [
                k
                for k, (x, y) in enumerate(ends)
                if k >= at
                and abs(x - curve.end[0]) <= 0.6 * numbers.step
                and abs(y - curve.end[1]) <= 0.6 * numbers.step
            ]
            assert near, (curve, ends)
            at = near[0]


@pytest.mark.parametrize("machine", MACHINES)
@settings(max_examples=examples(50), deadline=None)
@given(found=chains)
def test_chains_do_not_look_at_one_another(machine: str, found: list[list[Curve]]) -> None:
    numbers = numbers_of(machine)
    together = [path.moves for path in paths_along(found, numbers, no_word)]
    alone = [next(paths_along([chain], numbers, no_word)).moves for chain in found]
    assert list(map(repr, together)) == list(map(repr, alone))


def test_a_circle_is_two_halves_about_one_centre() -> None:
    numbers = numbers_of("plate-linuxcnc")
    (path,) = paths_along([[Arc((5.0, 6.0), 3.0, 90.0, -360.0)]], numbers, no_word)
    assert path.moves == [
        ArcFeed(5.0, 3.0, 0.0, -3.0, True), ArcFeed(5.0, 9.0, 0.0, 3.0, True)
    ]  # fmt: skip
    one = arc_of(path.start, (5.0, 3.0), (5.0, 6.0), True)
    assert one.sweep_deg == pytest.approx(-180.0)


def test_an_arc_too_flat_to_tell_is_a_line() -> None:
    numbers = numbers_of("plate-linuxcnc")
    flat = Arc((0.0, 0.0), 1000.0, 0.0, 0.02)
    (path,) = paths_along([[flat]], numbers, no_word)
    assert path.moves == [Feed(*numbers.at(flat.end))]


def test_no_chains_have_no_moves() -> None:
    assert list(paths_along([], numbers_of("plate-linuxcnc"), no_word)) == []


# --- numbers --------------------------------------------------------------------------------------


values = st.one_of(
    st.floats(-1e4, 1e4),
    st.floats(-2e8, 2e8),
    st.integers(-(10**7), 10**7).map(lambda k: k / 1000),
    st.integers(-(10**6), 10**6).map(lambda k: k / 2000),  # middles between two steps
    st.sampled_from([0.0, -0.0, -0.0004, 9999.9999, 10000.0, 99999999.0, 1e-9, 0.0005, 2.5]),
)


@given(st.lists(st.tuples(values, values), min_size=1, max_size=30), st.integers(0, 6))
@example([(99999999.99996, -1.0)], 4)
def test_lines_are_those_of_each_number(rows: list[tuple[float, float]], decimals: int) -> None:
    columns = dict(zip("xy", np.array(rows).T, strict=True))
    expected = [f"G1 X{number(x, decimals)} Y{number(y, decimals)}\n" for x, y in rows]
    assert lines("G1 X{x} Y{y}", columns, decimals) == "".join(expected)


@pytest.mark.parametrize("template", ["{y}", "é {x}{y} {x}", "A{x}{{B}}"])
def test_any_template(template: str) -> None:
    columns = {"x": np.array([1.5, -2.0]), "y": np.array([0.25, 12345.678])}
    rows = [("1.5", "0.25"), ("-2", "12345.678")]
    expected = "".join(template.format(x=x, y=y) + "\n" for x, y in rows)
    assert lines(template, columns, 3) == expected


def test_no_rows() -> None:
    assert lines("X{x}", {"x": np.zeros(0)}, 3) == ""


def machine_with(**words: tuple[str, ...]) -> Machine:
    from msgspec.structs import replace

    machine = load("plate-linuxcnc")
    return replace(machine, words=replace(machine.words, **words))


def test_templates_of_several_blocks_with_a_feed() -> None:
    """The feed that holds stands in every block that asks for it."""
    from beamcam.emitters.cutting import emit

    machine = machine_with(
        feed=("F{feed}", "G1 X{x} Y{y}"), arc_ccw=("G3 X{x} Y{y} I{i} J{j} F{feed}",), footer=()
    )
    on = [ToolOn("cut", feed, 1.0, 0.5, NESTED.source) for feed in (600.0, 900.0)]
    program = Program(
        "A",
        (Traverse(1, 2), on[0], Feed(3, 4), Feed(5, 6), on[1], Feed(7, 8),
         ArcFeed(9, 8, 1, 0, False)),
    )  # fmt: skip
    assert emit(program, machine).split("\n") == [
        "G0 X1 Y2", "M3 S1", "G4 P0.5", "F600", "F600", "G1 X3 Y4", "F600", "G1 X5 Y6",
        "M3 S1", "G4 P0.5", "F900", "F900", "G1 X7 Y8", "G3 X9 Y8 I1 J0 F900", "",
    ]  # fmt: skip


def test_blocks_are_numbered_one_by_one() -> None:
    from beamcam.pipeline import post

    text = post((NESTED,), table("plate-codesys")).text
    blocks = [line for line in text.splitlines() if not line.startswith(("%", "("))]
    assert [line.split()[0] for line in blocks] == [f"N{k}" for k in range(1, len(blocks) + 1)]
