"""A part that was turned is told from one that was mirrored or changed."""

from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.model.part import Part
from beamcam.planning.turning import TURNS, turned
from beamcam.verify.lying import ROTATIONS, is_turned
from tests.strategies import parts


def determinant(rows: tuple[tuple[float, ...], ...]) -> float:
    (a, b, c), (d, e, f), (g, h, i) = rows
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def test_eight_rotations_and_no_mirror() -> None:
    assert len(set(ROTATIONS)) == 8
    assert {determinant(r) for r in ROTATIONS} == {1.0}


@settings(max_examples=150, deadline=None)
@given(parts(), st.sampled_from(TURNS))
def test_every_turn_is_accepted(part: Part, turn: object) -> None:
    assert is_turned(part, turned(part, turn))


@settings(max_examples=150, deadline=None)
@given(parts(), st.sampled_from(TURNS), st.floats(1.0, 9.0))
def test_a_hole_that_moved_is_seen(part: Part, turn: object, by: float) -> None:
    from msgspec.structs import replace

    if not part.features:
        return
    lying = turned(part, turn)
    first, *rest = lying.features
    moved = replace(lying, features=(replace(first, x=first.x + by), *rest))
    assert not is_turned(part, moved)


def test_the_mirrored_twin_is_refused() -> None:
    from msgspec.structs import replace

    from beamcam.model.part import Hole
    from tests.strategies import CHANNEL, SOURCE

    holes = (Hole("v", 100.0, 50.0, 18.0, SOURCE), Hole("o", 400.0, 45.0, 14.0, SOURCE))
    part = Part("A", CHANNEL, 1500.0, SOURCE, features=holes)
    twin = replace(part, features=(replace(holes[0], x=1400.0), replace(holes[1], x=1100.0)))
    assert not any(is_turned(twin, turned(part, turn)) for turn in TURNS)
