"""Which part lies where on a bar, and turned how, is found in the program."""

import re

from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.bars import verify
from beamcam.checks.bars.orientations import ROTATIONS, orientations, rotated
from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.model.part import EndCuts, Hole, Part
from beamcam.model.plan import SawOp
from beamcam.pipeline import post
from beamcam.planning.turning import TURNS, alike, lies, turned
from tests.conftest import examples
from tests.strategies import CHANNEL, SOURCE, bars, parts

MACHINE = load("beamline")


def same(one: Part, other: Part) -> bool:
    return alike(one, other)


def determinant(rows: tuple[tuple[float, ...], ...]) -> float:
    (a, b, c), (d, e, f), (g, h, i) = rows
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def test_eight_rotations_and_no_mirror() -> None:
    assert len(set(ROTATIONS)) == 8
    assert {determinant(r) for r in ROTATIONS} == {1.0}


@settings(max_examples=examples(100), deadline=None)
@given(parts())
def test_the_ways_a_part_may_lie_are_those_of_the_planner(part: Part) -> None:
    """Both are written apart: rotations of places here, maps of each face there."""
    mine, theirs = (
        list(orientations(part)),
        [turned(part, t) for t in TURNS if lies(part.profile, t)],
    )
    assert len(mine) == len(theirs)
    for lying in theirs:
        assert any(same(one, lying) for one in mine)


@settings(max_examples=examples(100), deadline=None)
@given(parts(), st.sampled_from(ROTATIONS))
def test_turned_four_times_a_part_is_itself(part: Part, rotation: object) -> None:
    lying = part
    for _ in range(4):
        lying = rotated(lying, rotation)  # type: ignore[arg-type]
    assert same(lying, part)


def channel(length: float, x: float, cuts: EndCuts | None = None) -> Part:
    holes = (Hole("v", x, 50.0, 18.0, SOURCE), Hole("o", 400.0, 45.0, 14.0, SOURCE))
    return Part("A", CHANNEL, length, SOURCE, cuts=cuts or EndCuts(), features=holes)


@settings(max_examples=examples(40), deadline=None)
@given(
    st.lists(
        st.builds(
            channel,
            st.sampled_from((1500.0, 1800.0)),
            st.sampled_from((100.0, 130.0, 200.0)),
            st.builds(EndCuts, st.sampled_from((0.0, 20.0, -15.0)), st.sampled_from((0.0, 20.0))),
        ),
        min_size=1,
        max_size=4,
    )
)
def test_any_order_and_any_turn_is_found(given_parts: list[Part]) -> None:
    try:
        text = post(given_parts, MACHINE, bar=12000.0, order="best", turn=True).text
    except PlanError:
        assume(False)
    first, *rest = given_parts
    hole, *others = first.features
    moved = replace(first, features=(replace(hole, x=first.length / 2 + 33.0), *others))
    assert verify(text, [*rest, first], MACHINE, order="best", turn=True) == ()
    assert verify(text, [*rest, moved], MACHINE, order="best", turn=True) != ()


def test_a_mirrored_part_is_another_one() -> None:
    part = channel(1500.0, 100.0)
    twin = replace(part, features=tuple(replace(f, x=1500.0 - f.x) for f in part.holes))
    text = post([part], MACHINE, turn=True).text
    assert verify(text, [part], MACHINE, turn=True) == ()
    assert verify(text, [twin], MACHINE, turn=True) != ()


def test_the_order_that_was_asked_for_counts() -> None:
    long, short = channel(1800.0, 100.0), channel(1500.0, 100.0)
    text = post([long, short], MACHINE, bar=6000.0).text
    assert verify(text, [long, short], MACHINE) == ()
    assert verify(text, [short, long], MACHINE) != ()
    assert verify(text, [short, long], MACHINE, order="best") == ()


# --- the stop -------------------------------------------------------------------------------------


MACHINES = ("beamline", "beamline-annex")


def stop_positions(text: str) -> list[float]:
    """Every X that a program sends the stop to, in order."""
    return [float(x) for x in re.findall(r"^N\d+ G0[01] X(-?[\d.]+)", text, re.MULTILINE)]


@settings(max_examples=examples(150), deadline=None)
@given(bars())
def test_the_stop_never_moves_back(parts: list[Part]) -> None:
    for name in MACHINES:
        positions = stop_positions(post(parts, load(name)).text)
        assert positions
        assert positions == sorted(positions)


@settings(max_examples=examples(100), deadline=None)
@given(bars())
def test_every_feature_has_one_outcome_and_every_part_two_ends(parts: list[Part]) -> None:
    plan = post(parts, load("beamline")).plan
    features = [(p, f) for p, part in enumerate(parts) for f in range(len(part.features))]
    assert sorted(o.feature for o in plan.outcomes) == features
    drilled = [r for op in plan.operations if not isinstance(op, SawOp) for r in op.features]
    assert sorted(drilled) == features
    for index, part in enumerate(parts):
        angles = [
            op.angle for op in plan.operations if isinstance(op, SawOp) and index in op.pieces
        ]
        assert len(angles) >= 2
        skew = {a for a in (part.cuts.web_start, part.cuts.web_end) if a}
        assert skew <= set(angles)


@settings(max_examples=examples(100), deadline=None)
@given(bars())
def test_the_stretches_of_a_bar_add_up(parts: list[Part]) -> None:
    bar = post(parts, load("beamline"), bar=18000.0).plan.bar
    assert abs(bar.total - bar.length) < 1e-3
    assert bar.length == 18000.0


@settings(max_examples=examples(60), deadline=None)
@given(bars())
def test_numbers_are_plain(parts: list[Part]) -> None:
    """No exponent, no `-0`, no trailing zeros behind a point."""
    text = post(parts, load("beamline")).text
    for number in re.findall(r"\b[A-Z](-?[\d.]+(?:[eE][-+]?\d+)?)", text):
        assert re.fullmatch(r"-?\d+(\.\d*[1-9])?", number), number
        assert number != "-0"
