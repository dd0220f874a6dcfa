"""What an axis does not come to: the planner refuses just what the read-back would."""

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.bars import verify
from beamcam.errors import PlanError
from beamcam.geometry.curves import Arc, Line
from beamcam.machine import load
from beamcam.machine.machine import ControlledAxis, Machine
from beamcam.machine.stations import Formula
from beamcam.model.part import Contour, EndCuts, Face, Feature, Hole, HoleKind, Part, Profile, Slot
from beamcam.model.plan import DrillOp
from beamcam.pipeline import post
from beamcam.planning.axis_limits import fixed_faces
from beamcam.planning.beam import plan_bar, plan_oriented
from tests.conftest import examples
from tests.unit.checks.programs import skippable
from tests.unit.planning.shop import ANGLE, BEAM, SOURCE, TUBE, hole, part, pusher

MACHINES = tuple(map(load, ("beamline-pusher", "beamline-pusher", "beamline", "beamline-annex")))
LIMITS = {"plan-axis", "plan-stop"}
OPPOSITE: dict[str, Face] = {"o": "u", "u": "o"}


def narrowed(machine: Machine, name: str, **limits: float | None) -> Machine:
    """The machine with other limits of one axis."""
    assert name in {axis.name for axis in machine.axes}
    axes = tuple(replace(a, **limits) if a.name == name else a for a in machine.axes)  # type: ignore[arg-type]
    return replace(machine, axes=axes)


def unlimited(machine: Machine) -> Machine:
    """The machine with axes that come to any place."""
    return replace(machine, axes=tuple(replace(a, min=None, max=None) for a in machine.axes))


def codes(parts: tuple[Part, ...], machine: Machine) -> set[str]:
    try:
        plan_bar(parts, machine)
    except PlanError as error:
        return {d.code for d in error.diagnostics} - {"plan-turn-helps"}
    return set()


@st.composite
def features(draw: st.DrawFn, profile: Profile, min_x: float) -> Feature:
    face = draw(st.sampled_from("vou"))
    share = draw(st.sampled_from((0.05, 0.1, 0.2, 0.45, 0.5, 0.6, 0.9, 0.95)))
    x = min_x + draw(st.sampled_from((0.0, 45.0, 480.0)))
    y = round(profile.face_width(face) * share, 2)
    kind = draw(st.sampled_from(("hole", "hole", "large", "blind", "thread", "slot", "line")))
    if kind == "slot":
        angle = draw(st.sampled_from((0.0, 30.0, 90.0)))
        height = draw(st.sampled_from((0.0, 0.0, 12.0)))
        return Slot(face, x, y, 18.0, 30.0, height, angle, SOURCE)
    if kind == "line":
        curves = (Line((x, y), (x + 50, y + 5)), Arc((x + 50, y), 5.0, 90.0, 200.0))
        return Contour(face, "open", curves, SOURCE, "mark", False)
    if kind == "thread":
        return hole(x, y, 16.0, face, kind="thread", depth=draw(st.sampled_from((None, 2.0))))
    depth = 4.0 if kind == "blind" else None
    return hole(x, y, 60.0 if kind == "large" else 14.0, face, depth=depth,
                kind="blind" if kind == "blind" else "through")  # fmt: skip


@st.composite
def parts(draw: st.DrawFn) -> Part:
    profile = draw(st.sampled_from((BEAM, ANGLE, TUBE)))
    count = draw(st.integers(1, 3))
    made = [draw(features(profile, 15.0 + 700 * k)) for k in range(count)]
    twins = [replace(f, face=OPPOSITE[f.face]) for f in made if f.face in OPPOSITE]
    return part(*made, *(twin for twin in twins if draw(st.booleans())), profile=profile)


@st.composite
def machines(draw: st.DrawFn) -> Machine:
    """A machine with narrower axes, on the grid of its numbers and off it."""
    machine = draw(st.sampled_from(MACHINES))
    axes: list[ControlledAxis] = []
    for axis in machine.axes:
        least, greatest = axis.min, axis.max
        if axis.moves in "YZ" and draw(st.booleans()):
            least = draw(st.sampled_from((-100.0, -30.0, -5.0, 0.02, None)))
            greatest = draw(st.sampled_from((25.0, 90.06, 150.0, None)))
        elif axis.moves == "X":
            least, greatest = draw(st.sampled_from(((None, None), (0.0, None), (0.0, 1300.0))))
        axes.append(replace(axis, min=least, max=greatest))
    return replace(machine, axes=tuple(axes))


@settings(deadline=None, max_examples=examples(150))
@given(parts(), machines())
def test_it_is_refused_what_the_read_back_would_refuse(made: Part, machine: Machine) -> None:
    free = unlimited(machine)
    others = codes((made,), free)
    if others:
        event("refused for another reason")
        return
    text = post((made,), free, bar=6000.0).text
    said = {d.code for d in verify(text, (made,), machine, bar=6000.0)}
    assert said <= {"verify-limit"}
    found = codes((made,), machine)
    assert found <= LIMITS
    assert bool(found) == bool(said)
    event(", ".join(sorted(found)) or "made")


@settings(deadline=None, max_examples=examples(150))
@given(parts(), machines())
def test_what_is_left_out_for_an_axis_may_be(made: Part, machine: Machine) -> None:
    try:
        plan = plan_bar((made,), machine, skips=("axis",))
    except PlanError:
        return
    skipped = {o.feature for o in plan.outcomes if o.how == "skipped"}
    event("some left out" if skipped else "all made")
    assert skippable((made,), machine, ("axis",)) == skipped
    assert post((made,), machine, skips=("axis",)).plan == plan


@pytest.mark.parametrize(("name", "limits", "feature", "text"), [
    ("left drill horizontal", {"max": 14.0}, hole(500, 50, 14, "o"),
     "found a hole of diameter 14 on face o that takes the left drill horizontal to 16.906; "
     "expected -20 to 14"),
    ("left drill horizontal", {"min": None, "max": 14.0}, hole(500, 50, 14, "o"),
     "found a hole of diameter 14 on face o that takes the left drill horizontal to 16.906; "
     "expected at most 14"),
    ("top drill vertical", {"min": 0.0, "max": None}, hole(500),
     "found a hole of diameter 18 on face v that takes the top drill vertical to -5.000; "
     "expected at least 0"),
    ("top drill horizontal", {"min": -60.0}, Slot("v", 500, 200, 18, 30, 0, 90, SOURCE),
     "found a slot of width 18 on face v that takes the top drill horizontal to -66.000; "
     "expected -60 to 500"),
])  # fmt: skip
def test_the_axis_is_named(
    name: str, limits: dict[str, float | None], feature: Feature, text: str
) -> None:
    with pytest.raises(PlanError) as caught:
        plan_bar((part(feature),), narrowed(pusher(), name, **limits))
    assert text in [d.message for d in caught.value.diagnostics]


@pytest.mark.parametrize("skips", [(), ("axis",)])
def test_a_pair_that_one_spindle_does_not_reach_is_two_holes(skips: tuple[str, ...]) -> None:
    flanges = part(hole(500, 50, 14, "o"), hole(500, 50, 14, "u"))
    machine = narrowed(pusher(), "right drill vertical", max=100.0)
    if not skips:
        with pytest.raises(PlanError) as caught:
            plan_bar((flanges,), machine)
        (said,) = (d for d in caught.value.diagnostics if d.code == "plan-axis")
        assert said.message.startswith("found a hole of diameter 14 on face u")
        assert "right drill vertical to 138.600; expected -320 to 100" in said.message
    else:
        plan = post((flanges,), machine, skips=skips).plan
        assert [(o.feature, o.how) for o in plan.outcomes] == [
            ((0, 0), "made"),
            ((0, 1), "skipped"),
        ]


def test_a_pair_within_reach_of_both_spindles_is_one_stroke() -> None:
    flanges = part(hole(500, 50, 14, "o"), hole(500, 50, 14, "u"))
    operations = plan_bar((flanges,), pusher()).operations
    assert [op.faces for op in operations if isinstance(op, DrillOp)] == [("o", "u")]


def test_a_cut_that_the_bar_cannot_be_brought_to() -> None:
    long = part(length=5000.0)
    with pytest.raises(PlanError) as caught:
        plan_bar((long,), narrowed(load("beamline"), "stop", max=4000.0))
    (said,) = caught.value.diagnostics
    assert said.message == ("found a cut of P1 that takes the stop to 5022.020; expected 0 to 4000")


def test_an_axis_that_belongs_to_one_spindle_and_moves_along_the_bar() -> None:
    """Only what that spindle does is held against it."""
    own = ControlledAxis("left drill along", "X", 300.0, 1000.0, spindle=1, max=1000.0)
    machine = replace(pusher(), axes=(*pusher().axes, own))
    assert codes((part(hole(2000)),), machine) == set()
    assert codes((part(hole(2000, 50, 14, "o")),), machine) == {"plan-stop"}


def test_the_saw_turns_as_far_as_its_axis() -> None:
    mitred = part(cuts=EndCuts(web_end=40.0))
    machine = load("beamline")
    assert codes((mitred,), machine) == set()
    assert codes((mitred,), narrowed(machine, "saw rotation", max=30.0)) == {"plan-saw-angle"}


def test_another_way_of_lying_helps() -> None:
    """Turned half about its length the hole comes to the other flange and the other edge."""
    made = part(hole(500, 20, 14, "o"))
    machine = narrowed(load("beamline"), "left drill vertical", max=100.0)
    with pytest.raises(PlanError) as caught:
        plan_oriented((made,), machine)
    assert [d.code for d in caught.value.diagnostics] == ["plan-axis", "plan-turn-helps"]
    assert plan_oriented((made,), machine, turn=True).pieces[0].turn != "as given"


@pytest.mark.parametrize("machine", ["beamline", "beamline-annex"])
def test_what_repeats_a_hole_that_is_left_out_may_be_left_out_too(machine: str) -> None:
    twice = part(hole(500, diameter=65), hole(500.005, diameter=65), hole(500.5, diameter=65))
    plan = plan_bar((twice,), load(machine), skips=("tool",))
    assert {o.how for o in plan.outcomes} == {"skipped"}
    assert skippable((twice,), load(machine), ("tool",)) == {(0, 0), (0, 1), (0, 2)}


def test_a_line_in_the_way_of_a_flange_may_be_left_out() -> None:
    low, high = (
        Contour("v", "open", (Line((100, y), (200, 150)),), SOURCE, "mark", False)
        for y in (10.0, 11.0)
    )
    made, machine = part(low, high), pusher()
    plan = plan_bar((made,), machine, skips=("reach",))
    assert [(o.feature, o.how) for o in plan.outcomes] == [((0, 0), "skipped"), ((0, 1), "made")]
    assert skippable((made,), machine, ("reach",)) == {(0, 0)}
    assert post((made,), machine, skips=("reach",)).plan == plan


# --- strokes that are the same for every hole -----------------------------------------------------


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
