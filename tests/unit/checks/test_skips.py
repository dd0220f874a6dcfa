"""Features that lie where no tool comes: the read-back names the same ones as the planner."""

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from beamcam.checks.bars.ability import repeats
from beamcam.checks.bars.targets import is_same
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.errors import PlanError, Source
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.machine.machine import Machine, drill_of
from beamcam.model.part import Contour, EndCuts, Face, Hole, Part, Profile, Slot
from beamcam.pipeline import post
from beamcam.planning.beam import plan_bar
from tests.conftest import examples
from tests.unit.checks.programs import skippable
from tests.unit.planning.shop import BEAM, hole, part

SOURCE = Source("p.nc1", 20)
MACHINES = tuple(map(load, ("beamline", "beamline-annex", "beamline-pusher")))
PROFILES = (
    BEAM,
    Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5),
    Profile("L", "L100X10", 100.0, 100.0, 10.0, 10.0, 12.0),
    Profile("M", "RHS100X5", 100.0, 100.0, 5.0, 5.0, 8.0),
)
FACES = st.sampled_from("vouh")
#: Around both flanges and edges, and in the middle.
SHARES = st.sampled_from((-0.05, 0.02, 0.06, 0.1, 0.15, 0.5, 0.85, 0.9, 0.94, 0.98, 1.05))
NAMES = ("off-face", "reach")


@st.composite
def parts(draw: st.DrawFn) -> Part:
    profile = draw(st.sampled_from(PROFILES))
    features: list[Hole | Slot] = []
    for k in range(draw(st.integers(1, 4))):
        face = draw(FACES)
        x = 200.0 + 300 * k + draw(st.sampled_from((0.0, 0.0, 5000.0)))
        y = round(profile.face_width(face) * draw(SHARES), 2)
        if draw(st.booleans()):
            features.append(Hole(face, x, y, 14.0, SOURCE))
        else:
            angle = draw(st.sampled_from((0.0, 30.0, 90.0)))
            features.append(Slot(face, x, y, 18.0, 30.0, 0.0, angle, SOURCE))
    return part(*features, profile=profile)


@settings(deadline=None, max_examples=examples(200))
@given(parts(), st.sampled_from(MACHINES), st.sets(st.sampled_from(NAMES), min_size=1))
def test_what_is_left_out_for_its_place_may_be(
    made: Part, machine: Machine, names: set[str]
) -> None:
    try:
        plan = plan_bar((made,), machine, skips=tuple(names))
    except PlanError as error:
        event(", ".join(sorted({said.code for said in error.diagnostics})))
        return
    skipped = {o.feature for o in plan.outcomes if o.how == "skipped"}
    event("some left out" if skipped else "all made")
    assert skippable((made,), machine, tuple(names)) == skipped


@pytest.mark.parametrize(("y", "names", "left"), [
    (150.0, NAMES, set()),
    (15.0, ("reach",), {(0, 0)}),
    (15.0, ("off-face",), set()),
    (-5.0, ("off-face",), {(0, 0)}),
    (-5.0, ("reach",), set()),
])  # fmt: skip
def test_a_place_has_one_name(y: float, names: tuple[str, ...], left: set[object]) -> None:
    assert skippable((part(hole(500, y)),), MACHINES[0], names) == left


def test_a_slot_is_where_its_corners_are() -> None:
    # An IPE 300: the flange ends at 10.7, so 29 clears it by itself, and its lower end does not.
    slot = Slot("v", 500.0, 29.0, 18.0, 30.0, 0.0, 90.0, SOURCE)
    machine = load("beamline-pusher")
    assert skippable((part(slot),), machine, ("reach",)) == {(0, 0)}
    assert skippable((part(slot),), machine, ("off-face",)) == frozenset()


@pytest.mark.parametrize("face", ["h", "o", "u"])
def test_a_hole_of_another_wall_is_no_repeat(face: Face) -> None:
    """The walls of a tube have holes of their own, also those that lie behind each other."""
    tube = Profile("M", "RHS120*80*5", 120.0, 80.0, 5.0, 5.0, 7.5)
    behind = Hole(face, 500.0, 60.0, 14.0, Source("p.nc1", 21))
    made = part(Hole("v", 500.0, 60.0, 14.0, SOURCE), behind, profile=tube)
    posted = post((made,), load("beamline-pusher"), skips=("face",))
    left = [said.source for said in posted.remarks if said.code == "plan-left-out"]
    assert left in ([], [behind.source])
    assert {g for _, g in skippable((made,), load("beamline-pusher"), ("face",))} <= {1}


def test_the_outline_of_a_tube_lies_on_the_wall_of_its_face() -> None:
    """A cut skew through the width of a tube leaves each web an end of its own."""
    tube = Profile("M", "RHS120*80*5", 120.0, 80.0, 5.0, 5.0, 7.5)
    corners = ((60.0, 0.0), (1000.0, 0.0), (1000.0, 120.0), (0.0, 120.0), (60.0, 3.0))
    sides = zip(corners, (*corners[1:], corners[0]), strict=True)
    outline = Contour("v", "outer", tuple(Line(a, b) for a, b in sides), SOURCE)
    cuts = EndCuts(web_start=14.7, flange_start=26.565)
    part = Part("T", tube, 1000.0, SOURCE, features=(outline,), cuts=cuts)
    posted = post([part], load("beamline-pusher"), skips=("cope",))
    assert [o.by for o in posted.plan.outcomes] == ["plan-cope"]


@given(st.data())
def test_holes_written_again_are_left_out_with_the_first(data: st.DataObject) -> None:
    """Each with each, which takes too long for thousands."""
    place = st.sampled_from((100.0, 100.005, 100.02, 140.0))
    one = st.builds(hole, place, place, st.sampled_from((18.0, 22.0)))
    holes = data.draw(st.lists(one, min_size=1, max_size=8))
    left = data.draw(st.sets(st.integers(0, len(holes) - 1)))
    machine = MACHINES[0]
    shop = ToolCatalogue(machine, drill_of(machine))
    made = part(*holes)
    again = {
        g for g in range(len(holes)) for f in left if is_same(holes[g], holes[f], shop.twice)
    }  # fmt: skip
    assert {*repeats(left, made, shop)} | left == again | left
