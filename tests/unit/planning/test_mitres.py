"""Ends that a saw makes which turns and tilts to both sides: mitres, steep ends, flats, rounds."""

import pytest

from beamcam.errors import Source
from beamcam.machine import load
from beamcam.model.part import EndCuts, Feature, Hole, Part, Profile
from beamcam.model.plan import SawOp
from beamcam.pipeline import post

AT = Source("p.nc1")
IPE300 = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
TUBE = Profile("M", "RHS100*5", 100.0, 100.0, 5.0, 5.0, 10.0)
ROUND = Profile("RO", "CHS100*5", 100.0, 100.0, 5.0, 5.0)
FLAT = Profile("B", "FL50*5", 50.0, 0.0, 0.0, 5.0)


@pytest.mark.parametrize(("profile", "length", "cuts", "sawn"), [
    # A flange mitre at both ends: the blade tilts one way and the other.
    (IPE300, 2000.0, EndCuts(flange_start=-45.0, flange_end=45.0), [(90.0, -45.0), (90.0, 45.0)]),
    (IPE300, 2000.0, EndCuts(web_start=60.8, web_end=-60.8), [(150.8, 0.0), (29.2, 0.0)]),
    (TUBE, 2000.0, EndCuts(web_start=60.8, flange_end=-45.0), [(150.8, 0.0), (90.0, -45.0)]),
    (ROUND, 2000.0, EndCuts(web_start=60.8), [(150.8, 0.0)]),
    (Profile("RU", "RD50", 50.0, 50.0, 0.0, 0.0), 700.0, EndCuts(web_end=45.0), [(135.0, 0.0)]),
    (FLAT, 9980.0, EndCuts(), []),
    (FLAT, 1000.0, EndCuts(web_start=45.0), [(135.0, 0.0)]),
])  # fmt: skip
def test_ends_are_sawn_and_read_back(
    profile: Profile, length: float, cuts: EndCuts, sawn: list[tuple[float, float]]
) -> None:
    holes: tuple[Feature, ...] = ()
    if profile.code in ("I", "M", "B"):
        holes = (Hole("v", length / 2, profile.height / 2, 14.0, AT),)
    part = Part("P1", profile, length, AT, features=holes, cuts=cuts)
    plan = post((part,), load("beamline-pusher")).plan
    found = [(round(op.angle, 6), op.tilt) for op in plan.operations if isinstance(op, SawOp)]
    assert [one for one in found if one != (90.0, 0.0)] == [pytest.approx(one) for one in sawn]
