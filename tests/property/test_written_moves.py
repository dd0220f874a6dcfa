"""Lines and arcs in written numbers, many chains at once."""

from decimal import ROUND_HALF_EVEN, Decimal
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.controllers.interpreter import arc_of
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.machine import load
from beamcam.model.program import ArcFeed, Feed, Movement
from beamcam.motion.arcs import Numbers, paths_along
from beamcam.motion.sheet import Pen
from tests.conftest import examples

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
