"""Torch and holder against the bar: what the read-back says of moves, and the bodies by hand."""

from math import cos, radians, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import MultiPoint

from beamcam.checks.coping.collisions import HOLDER, SLACK, collision_faults
from beamcam.checks.coping.section import CoperSection, TubeSection
from beamcam.checks.coping.strokes import TipMove
from beamcam.machine import load
from beamcam.model.part import Profile

TILTS = load("coper-tilt-linuxcnc").coper
TURNS = load("tube-linuxcnc").coper
SECTIONS = (
    CoperSection(Profile("I", "IPE300", 300.0, 150.0, 7.1, 10.7, 15.0)),
    CoperSection(Profile("U", "UPN200", 200.0, 75.0, 8.5, 11.5, 11.5)),
    CoperSection(Profile("L", "L100*80*10", 100.0, 80.0, 10.0, 10.0, 12.0)),
    TubeSection(Profile("M", "RHS120*80*5", 120.0, 80.0, 5.0, 5.0, 10.0), 10.0),
    TubeSection(Profile("RO", "CHS168.3*8", 168.3, 168.3, 8.0, 8.0), 0.0),
)
PLACES = st.floats(-150.0, 350.0)


def bodies(y, z, a_deg, b_deg, coper):
    """Torch and holder as what lies between their four corners, their tip at a place."""
    a, b = radians(a_deg), radians(abs(b_deg))
    long = coper.torch_length * cos(b)
    for first, last, wide in (
        (-coper.torch_width / 2 * sin(b), long, coper.torch_width),
        (long - coper.head_width / 2 * sin(b), long + HOLDER, coper.head_width),
    ):
        yield [
            (y - sin(a) * far + cos(a) * side, z + cos(a) * far + sin(a) * side)
            for far in (first, last) for side in (-wide / 2, wide / 2)
        ]  # fmt: skip


@settings(max_examples=300, deadline=None)
@given(
    st.sampled_from(SECTIONS), PLACES, PLACES, PLACES, PLACES,
    st.sampled_from((-90.0, 0.0, 30.0, 90.0)), st.sampled_from((0.0, 30.0)),
)  # fmt: skip
def test_straight_moves_are_as_near_as_the_bodies_between_their_ends(
    section, y0, z0, y1, z1, a_deg, b_deg
):
    """What a body sweeps between two places is the hull of both, however a bound comes first."""
    is_tube = isinstance(section, TubeSection)
    coper, b_deg = (TURNS, 0.0) if is_tube else (TILTS, b_deg)
    way = TipMove(7, (0.0, y0, z0), (0.0, y1, z1), (a_deg, a_deg), (b_deg, b_deg))
    a = radians(a_deg) if is_tube else 0.0
    seen = [(y * cos(a) - z * sin(a), y * sin(a) + z * cos(a)) for y, z in ((y0, z0), (y1, z1))]
    pairs = zip(*(bodies(*place, a_deg, b_deg, coper) for place in seen), strict=True)
    gap = min(
        section.steel.distance(MultiPoint([*one, *other]).convex_hull) for one, other in pairs
    )
    if abs(gap - (coper.play - SLACK)) > 0.01:
        strikes = [said.code for said in collision_faults([way], section, coper, "p")]
        assert strikes == ["verify-coping-strikes"] * (gap < coper.play - SLACK)


@pytest.mark.parametrize(("high", "strikes"), [(60.2, True), (60.8, False)])
def test_corners_of_a_tube_that_turns_sweep_a_circle(high, strikes):
    """Their middles lie 40 and 30 mm off the axis, 10 mm round: 50 + 10 mm, and 0.5 to play."""
    section = TubeSection(Profile("M", "RHS100*80*5", 100.0, 80.0, 5.0, 5.0, 10.0), 10.0)
    way = TipMove(3, (0.0, 0.0, high), (0.0, 0.0, high), (90.0, 0.0))
    assert bool([*collision_faults([way], section, TURNS, "p")]) == strikes


def test_no_moves_meet_nothing():
    assert [*collision_faults([], SECTIONS[0], TILTS, "p")] == []
