"""End planes that say once more what the angles and the length of a part give."""

from math import radians, tan

import pytest
from msgspec.structs import replace

from beamcam.checks.bars.cuts import ends_of
from beamcam.checks.bars.pieces import orientations
from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.machine.machine import saw_of
from beamcam.model.part import EndCuts, EndPlane, Part, Profile
from beamcam.model.section import corners
from beamcam.pipeline import RefusedProgram, post
from beamcam.planning.operations import saw_cut
from tests.unit.planning.shop import ANGLE, BEAM, CHANNEL, SOURCE, TUBE, part

PUSHER = load("beamline-pusher")
WEB, FLANGE = 17.0, 12.0  #: degrees


def leaned(profile: Profile, at: str, off: float = 0.0) -> Part:
    """A part with a compound mitre, and the plane of it, `off` mm along the part."""
    t, s = tan(radians(WEB)), tan(radians(FLANGE))
    leans = [y * t + z * s for y, z in corners(profile)]
    side = -1.0 if at == "start" else 1.0
    x = max(leans) if at == "start" else 3000.0 + min(leans)
    plane = EndPlane((x + off, 0.0, 0.0), (side, side * t, side * s), SOURCE)
    cuts = EndCuts(**{f"web_{at}": WEB, f"flange_{at}": FLANGE})
    return part(plane, profile=profile, cuts=cuts)


PROFILES = (BEAM, CHANNEL, ANGLE, TUBE, replace(TUBE, radius=24.0))


@pytest.mark.parametrize("at", ["start", "end"])
@pytest.mark.parametrize("profile", PROFILES, ids=lambda profile: profile.code)
def test_the_saw_makes_the_plane_that_angles_and_length_give(profile: Profile, at: str) -> None:
    made = post([leaned(profile, at)], PUSHER)
    assert [(o.how, o.by) for o in made.plan.outcomes] == [("made", "saw")]


@pytest.mark.parametrize("at", ["start", "end"])
@pytest.mark.parametrize("off", [-0.3, 0.3])
def test_a_plane_elsewhere_is_refused(off: float, at: str) -> None:
    with pytest.raises(PlanError, match="plan-other"):
        post([leaned(BEAM, at, off)], PUSHER)


def test_the_read_back_finds_a_plane_that_the_planner_takes_for_the_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(saw_cut, "SAME_PLANE", 1.0)
    with pytest.raises(RefusedProgram, match="the end plane"):
        post([leaned(BEAM, "end", 0.3)], PUSHER)


@pytest.mark.parametrize("profile", PROFILES, ids=lambda profile: profile.code)
def test_a_plane_turns_with_its_part(profile: Profile) -> None:
    """In each orientation that its section allows it is an end still."""
    for at in ("start", "end"):
        for one in orientations(leaned(profile, at)):
            (plane,) = (f for f in one.features if isinstance(f, EndPlane))
            end = ends_of(one, saw_of(PUSHER))[plane.normal[0] > 0]
            for y, z in corners(one.profile):
                assert plane.x(y, z) == pytest.approx(end.x(y, z), abs=1e-6)
