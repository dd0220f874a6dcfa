"""End planes that say once more what the angles and the length of a part give."""

from math import radians, tan

import pytest
from msgspec.structs import replace

from beamcam.checks.bars.orientations import orientations
from beamcam.checks.bars.pieces import ends_of
from beamcam.errors import Diagnostic, PlanError
from beamcam.machine import load
from beamcam.machine.machine import saw_of
from beamcam.model.part import EndCuts, EndPlane, Part, Profile
from beamcam.model.section import corners
from beamcam.pipeline import RefusedProgram, post
from beamcam.planning.beam import plan_bar
from beamcam.planning.operations import outlines
from beamcam.planning.turning import TURNS, turned
from beamcam.readers import read
from tests.runs import part as dstv
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


@pytest.mark.parametrize(("at", "way"), [("start", 1.0), ("end", -1.0)])
def test_a_plane_within_the_part_is_refused_and_one_beyond_takes_nothing(
    at: str, way: float
) -> None:
    with pytest.raises(PlanError, match="plan-other"):
        post([leaned(BEAM, at, 0.3 * way)], PUSHER)
    plan = post([leaned(BEAM, at, -0.3 * way)], PUSHER).plan
    assert "plan-plane-nothing" in {said.code for said in plan.remarks}


def test_the_read_back_finds_a_plane_that_the_planner_takes_for_the_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(outlines, "SAME_PLANE", 1.0)
    with pytest.raises(RefusedProgram, match="the end plane"):
        post([leaned(BEAM, "end", -0.3)], PUSHER)


@pytest.mark.parametrize("profile", PROFILES, ids=lambda profile: profile.code)
def test_a_plane_turns_with_its_part(profile: Profile) -> None:
    """In each orientation that its section allows it is an end still."""
    for at in ("start", "end"):
        for one in orientations(leaned(profile, at)):
            (plane,) = (f for f in one.features if isinstance(f, EndPlane))
            end = ends_of(one, saw_of(PUSHER))[plane.normal[0] > 0]
            for y, z in corners(one.profile):
                assert plane.x(y, z) == pytest.approx(end.x(y, z), abs=1e-6)


# --- lines of the angles --------------------------------------------------------------------------


PLACES = ("web start", "web end", "flange start", "flange end")
FIRST = 19  #: line of the file that `runs.part` writes the first angle in, a comment above it


def file_with(length: float = 2000.0, **angles: float) -> tuple[str, dict[str, int]]:
    """A DSTV file with angles in its header, by their places; and the line of each."""
    rows = dstv("A", length).splitlines()
    lines = {place: FIRST + k for k, place in enumerate(PLACES)}
    for name, angle in angles.items():
        rows[lines[name.replace("_", " ")] - 1] = f"  {angle:g}"
    return "\n".join(rows) + "\n", lines


def said_of(text: str) -> tuple[Diagnostic, ...]:
    (one,) = read(text.encode(), "a.nc1").parts
    try:
        return plan_bar([one], load("beamline")).remarks
    except PlanError as error:
        return tuple(error.diagnostics)


@pytest.mark.parametrize(
    ("place", "angle", "code"),
    [
        ("web_start", 65.0, "plan-saw-angle"),
        ("web_end", -50.0, "plan-saw-angle"),
        ("flange_start", 20.0, "plan-flange-cut"),
        ("flange_end", -20.0, "plan-flange-cut"),
        ("web_end", 0.05, "plan-cut-noise"),
        ("flange_end", 0.05, "plan-cut-noise"),
    ],
)
def test_an_angle_is_named_as_in_the_file_with_its_own_line(
    place: str, angle: float, code: str
) -> None:
    text, lines = file_with(**{place: angle})
    (said,) = (one for one in said_of(text) if one.code == code)
    assert said.source.line == lines[place.replace("_", " ")]
    assert f"found a cut of {angle:g}" in said.message or f" cut of {angle:g} " in said.message


def test_ends_that_cross_are_told_at_the_angle_of_the_end() -> None:
    text, lines = file_with(100.0, web_start=-45.0, web_end=45.0)
    crossing = [one for one in said_of(text) if one.code == "plan-cuts-cross"]
    assert [one.source.line for one in crossing] == [lines["web end"]]


def test_the_lines_go_with_the_angles_when_the_part_is_turned() -> None:
    text, lines = file_with(web_start=10.0, web_end=20.0, flange_start=3.0, flange_end=4.0)
    (one,) = read(text.encode(), "a.nc1").parts
    of_angle = dict(zip((10.0, 20.0, 3.0, 4.0), lines.values(), strict=True))
    for turn in TURNS:
        after = turned(one, turn)
        cuts = after.cuts
        angles = (cuts.web_start, cuts.web_end, cuts.flange_start, cuts.flange_end)
        assert after.cut_lines == tuple(of_angle[abs(angle)] for angle in angles)
