"""Laws of the layout with the saw first: the stop gives way and never comes back."""

import re

from hypothesis import given, settings

from beamcam.machine import load
from beamcam.model.part import Part
from beamcam.model.plan import SawOp
from beamcam.pipeline import post
from tests.conftest import examples
from tests.strategies import bars

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
