"""Strokes that are the same for every hole: the planner refuses what they do not make."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.bars import skippable, verify
from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.machine.words import Formula
from beamcam.model.part import Hole, HoleKind, Part, Profile
from beamcam.pipeline import post
from beamcam.planning.axis_limits import fixed_faces
from beamcam.planning.beam import plan_bar
from tests.conftest import examples
from tests.unit.planning.shop import BEAM, hole, part, pusher

ANNEX = load("beamline-annex")
PROFILES = (
    BEAM,
    Profile("I", "HEB400", 400.0, 300.0, 24.0, 13.5, 27.0),
    Profile("I", "HEB280", 280.0, 280.0, 18.0, 10.5, 24.0),
    Profile("U", "U50", 50.0, 38.0, 7.0, 5.0, 7.0),
    Profile("U", "UPN300", 300.0, 100.0, 16.0, 10.0, 16.0),
)


def fixed(machine: Machine, *faces: str) -> Machine:
    """The machine with one stroke of 60 for all holes on some faces."""
    spindles = tuple(
        replace(s, stroke=replace(s.stroke, bottom=Formula("60"))) if s.face in faces else s
        for s in machine.spindles
    )
    return replace(machine, spindles=spindles)


def test_which_strokes_follow_the_depth() -> None:
    assert fixed_faces(ANNEX) == {"v", "o", "u"}
    assert fixed_faces(load("beamline")) == frozenset()  # `face_depth` alone is no depth
    assert fixed_faces(fixed(load("beamline"), "v")) == {"v"}


@settings(deadline=None, max_examples=examples(150))
@given(
    st.sampled_from(PROFILES), st.sampled_from("vou"), st.sampled_from((9.0, 14.0, 22.0, 40.0)),
    st.sampled_from(("through", "through", "blind")), st.integers(30, 70).map(lambda n: n / 100),
)  # fmt: skip
def test_what_is_planned_reaches_and_what_does_not_is_told(
    profile: Profile, face: str, diameter: float, kind: HoleKind, share: float
) -> None:
    y = round(profile.face_width(face) * share, 1)
    depth = 4.0 if kind == "blind" else None
    made = part(hole(500, y, diameter, face, kind=kind, depth=depth), profile=profile)
    left = skippable((made,), ANNEX, ("stroke",))
    try:
        text = post((made,), ANNEX, verified=False).text
    except PlanError as error:
        codes = {d.code for d in error.diagnostics} - {"plan-turn-helps"}
        assert len(codes) == 1
        assert codes <= {"plan-stroke", "plan-reach", "plan-wall", "plan-fillet", "plan-off-part"}
        assert left or codes != {"plan-stroke"}
        return
    assert not left
    assert verify(text, (made,), ANNEX) == ()


def test_all_that_belongs_to_a_hole_is_left_out_with_it() -> None:
    machine = fixed(pusher(), "v")
    thread = hole(500, diameter=16, kind="thread", depth=None)
    pair = (hole(900, 40, 14, "o"), hole(900, 40, 14, "u"))
    made = part(thread, *pair, hole(1200, 40, 14, "u"))
    plan = plan_bar((made,), machine, skips=("stroke",))
    assert [(o.feature[1], o.how) for o in plan.outcomes] == [
        (0, "skipped"), (1, "made"), (2, "merged"), (3, "made"),
    ]  # fmt: skip
    assert skippable((made,), machine, ("stroke",)) == {(0, 0)}
    posted = post((made,), machine, skips=("stroke",))
    assert "M45" not in posted.text  # nor the tap in the hole that is not there


@pytest.mark.parametrize(("feature", "what"), [
    (hole(500, diameter=60), "a hole of diameter 60"),
    (hole(500, diameter=0, kind="mark"), "a centre point"),
])  # fmt: skip
def test_other_tools_than_drills_have_to_come_to_their_depth(feature: Hole, what: str) -> None:
    made: Part = part(feature)
    with pytest.raises(PlanError) as caught:
        plan_bar((made,), fixed(pusher(), "v"))
    first = caught.value.diagnostics[0]
    assert first.code == "plan-stroke"
    assert what in first.message
