"""The moves that are found for many curves at once are those that each curve has by itself."""

from math import radians
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.geometry.curves import Arc, Bezier, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine import load
from beamcam.model.program import ArcFeed, Feed, Movement
from beamcam.motion.arcs import Numbers, arc_feeds
from beamcam.motion.sheet import Pen
from beamcam.motion.sure import sure_moves

#: Coordinates that lie on the written steps, between two of them, or anywhere.
coordinates = st.one_of(
    st.integers(-2000, 2000).map(lambda n: n / 100),
    st.integers(-20_000_000, 20_000_000).map(lambda n: n * 5e-5),
    st.floats(-1e4, 1e4),
    st.floats(-1e9, 1e9),
)
points = st.tuples(coordinates, coordinates)
angles = st.one_of(st.sampled_from([0.0, 90.0, 180.0, 270.0]), st.floats(-360.0, 360.0))
sweeps = st.one_of(st.sampled_from([90.0, 180.0, 360.0]), st.floats(1e-3, 360.0))
radii = st.one_of(st.floats(1e-4, 1e5), st.integers(1, 10_000).map(lambda n: n * 5e-4))
arcs = st.builds(
    lambda centre, radius, start, sweep, side: Arc(centre, radius, start, side * sweep),
    points, radii, angles, sweeps, st.sampled_from([-1.0, 1.0]),
)  # fmt: skip
lines = st.builds(Line, points, points)
free = st.builds(lambda a, b, c: Bezier((a, b, c)), points, points, points)
chains = st.lists(
    st.lists(st.one_of(lines, arcs, free), min_size=1, max_size=6), min_size=1, max_size=4
)
MACHINES = ("plate-linuxcnc", "plate-codesys", "laser-grbl")


def moves_alone(here: Point, curve: Curve, numbers: Numbers) -> list[Movement]:
    """What is written for a line or an arc that is followed from `here`."""
    if isinstance(curve, Arc):
        return arc_feeds(here, curve, numbers)
    end = numbers.at(curve.end)
    return [] if end == here else [Feed(*end)]


def disagreements(found: list[list[Curve]], numbers: Numbers) -> tuple[int, int]:
    """How many moves are sure, and how many of these are others than each curve's own."""
    sure = wrong = 0
    for chain, moves in zip(found, sure_moves(found, numbers), strict=True):
        here = numbers.at(chain[0].start)
        for curve, move in zip(chain, moves, strict=True):
            if move is not None:
                sure += 1
                alone = moves_alone(here, curve, numbers)
                wrong += repr([move]) != repr(alone)  # -0.0 is another number here
            here = numbers.at(curve.end)
    return sure, wrong


@pytest.mark.parametrize("machine", MACHINES)
@settings(max_examples=150, deadline=None)
@given(found=chains)
def test_a_sure_move_is_the_curves_own(machine: str, found: list[list[Curve]]) -> None:
    assert disagreements(found, Pen(load(machine)).numbers)[1] == 0


@pytest.mark.parametrize("machine", MACHINES)
def test_nearly_all_moves_of_a_drawing_are_sure(machine: str) -> None:
    random, numbers = Random(machine), Pen(load(machine)).numbers
    found: list[list[Curve]] = []
    for _ in range(300):
        chain: list[Curve] = []
        here = (random.uniform(0, 1000), random.uniform(0, 1000))
        for _ in range(20):
            if random.random() < 0.5:
                there = (here[0] + random.uniform(1, 9), here[1] + random.uniform(1, 9))
                chain.append(Line(here, there))
            else:
                radius, start = random.uniform(3, 90), random.uniform(0, 360)
                begin = Arc((0.0, 0.0), radius, start, 1.0).start
                centre = (here[0] - begin[0], here[1] - begin[1])
                chain.append(Arc(centre, radius, start, random.uniform(-170, 170)))
            here = chain[-1].end
        found.append(chain)
    sure, wrong = disagreements(found, numbers)
    assert (sure > 0.99 * 6000, wrong) == (True, 0)


def test_what_rounding_decides_is_not_sure() -> None:
    numbers = Pen(load("plate-linuxcnc")).numbers
    half = numbers.step / 2
    on_a_half = Line((0.0, 0.0), (5 + half, 1.0))
    after_it = Line(on_a_half.end, (9.0, 9.0))
    # The centre of a half circle lies on half a step if its ends lie an odd number of steps apart.
    turn = Arc((9.0 + half, 9.0), 1 + half, 180.0, -180.0)
    ((first, second, third, fourth),) = sure_moves([[on_a_half, after_it, turn, after_it]], numbers)
    assert (first, second, third) == (None, None, None)
    assert fourth == Feed(9.0, 9.0)


def test_an_arc_at_a_limit_is_not_sure() -> None:
    numbers = Pen(load("plate-linuxcnc")).numbers
    flat_rad = (8 * numbers.step / 2 / 10.0) ** 0.5
    flat, bent = (Arc((0.0, 0.0), 10.0, 0.0, share * flat_rad / radians(1)) for share in (1.0, 2.0))
    assert list(sure_moves([[flat]], numbers)) == [[None]]
    ((move,),) = sure_moves([[bent]], numbers)
    assert isinstance(move, ArcFeed)


def test_no_chains_have_no_moves() -> None:
    assert list(sure_moves([], Pen(load("plate-linuxcnc")).numbers)) == []
