"""Depths in the steel of what a program makes, against figures worked out by hand."""

from math import radians, tan

import pytest
from msgspec.structs import replace

from beamcam.checks.bars.stations import Bore, MachinedPath
from beamcam.machine import load
from beamcam.model.part import Profile
from beamcam.pictures.features import SteelDepths

WEB = 8.5
CHANNEL = Profile("U", "UPN200", 200.0, 75.0, 11.5, WEB)
#: Of a drill of 18 mm with a point of 118 degrees: 9 mm / tan 59 degrees.
POINT = 9.0 / tan(radians(59.0))


def bore(kind: str, diameter: float, tip: float) -> Bore:
    return Bore(1, "v", 100.0, 50.0, diameter, tip, 1, 100.0, 0.0, kind)


@pytest.mark.parametrize(
    ("kind", "diameter", "tip", "depth"),
    [
        ("drill", 18.0, WEB + POINT, None), ("drill", 18.0, WEB + POINT + 3.0, None),
        ("drill", 18.0, WEB + POINT - 0.5, WEB - 0.5), ("drill", 18.0, 5.0 + POINT, 5.0),
        ("tap", 16.0, WEB + 2.0, None), ("tap", 16.0, 6.0, 6.0), ("punch", 5.0, 1.0, 1.0),
    ],
)  # fmt: skip
def test_a_depth_is_that_of_the_full_diameter(
    kind: str, diameter: float, tip: float, depth: float | None
) -> None:
    one = bore(kind, diameter, tip)
    found = SteelDepths(load("beamline-annex"), CHANNEL, [one]).of(one)
    assert found == (None if depth is None else pytest.approx(depth))


def test_a_sink_is_as_deep_as_its_cone_is_in_the_steel() -> None:
    """A cone of 90 degrees, 30 mm wide at the surface, over a hole of 18 mm: 15 - 9 = 6 mm."""
    machine = load("beamline-pusher")
    drill, sink = bore("drill", 18.0, 30.0), bore("countersink", 32.0, 15.0)
    depths = SteelDepths(machine, CHANNEL, [drill, sink])
    assert depths.of(sink) == pytest.approx(6.0)
    beside = replace(sink, x=130.0)
    assert depths.of(beside) == pytest.approx(15.0)


def test_of_an_unknown_wall_nothing_goes_through() -> None:
    bare = Profile("SO", "", 0.0, 0.0, 0.0, None)
    one = bore("drill", 18.0, 30.0)
    path = MachinedPath(1, "v", "mill", ((0.0, 0.0),), 10.0, 4.0, 12.0, 1, 100.0)
    depths = SteelDepths(load("beamline-annex"), bare, [one])
    assert depths.of(one) == pytest.approx(30.0 - POINT)
    assert depths.of(path) == 12.0
    assert SteelDepths(load("beamline-annex"), CHANNEL, []).of(path) is None
