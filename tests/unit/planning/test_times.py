"""Times of operations in figures, and what an explanation holds."""

from math import cos, pi, radians

import pytest
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.machine import load
from beamcam.machine.machine import Machine, Times
from beamcam.model.part import Profile
from beamcam.model.plan import Plan
from beamcam.planning.beam import plan_bar, plan_oriented, try_turns
from beamcam.planning.explain import REASONS, explain
from beamcam.planning.times import work_time
from beamcam.planning.turning import TURNS
from tests.unit.planning.shop import CHANNEL, TUBE, hole, part, plan


def test_a_jerk_makes_it_slower() -> None:
    machine = load("beamline")
    jerky = replace(machine, axes=tuple(replace(a, jerk=a.acceleration * 2) for a in machine.axes))
    found = plan_bar([part(hole(500), hole(700))], machine)
    for fast, slow in zip(seconds(found, machine), seconds(found, jerky), strict=True):
        assert slow > fast


def rigid(name: str, **times: float) -> Machine:
    """A machine whose axes take no time to speak of."""
    machine = load(name)
    axes = tuple(replace(a, speed=1e9, acceleration=1e12) for a in machine.axes)
    return replace(machine, axes=axes, times=Times(**times))  # type: ignore[arg-type]


def seconds(found: Plan, machine: Machine) -> list[float]:
    return list(work_time(found, machine).operations)


def test_a_hole_takes_its_stroke_and_its_tool() -> None:
    machine = rigid("beamline", spindle_s=2.0, tool_change_s=10.0, spindle_change_s=1.0)
    found = plan_bar([part(hole(500), hole(700), hole(900, diameter=22), hole(950, 40, 18, "o"))],
                     machine)  # fmt: skip
    trim, first, same, other, flange, parting = seconds(found, machine)
    # Clearance 5, web 7.1, breakthrough 2 and the point of 18 mm: 14.1 + 9 / tan(59 deg).
    feed = 0.25 * 25000 / (pi * 18)
    stroke = (14.1 + 9 / 1.664279) / feed * 60
    assert first == pytest.approx(stroke + 2 + 10 + 1, abs=1e-3)  # and fetches its first tool
    assert same == pytest.approx(stroke + 2, abs=1e-3)
    tip22 = 11 / 1.664279
    assert other == pytest.approx((14.1 + tip22) / (0.25 * 25000 / (pi * 22)) * 60 + 12, abs=1e-3)
    assert flange == pytest.approx((17.7 + 9 / 1.664279) / feed * 60 + 2 + 1 + 10, abs=1e-3)
    assert [trim, parting] == pytest.approx([160 * 60 / 2500] * 2, abs=1e-3)


def test_a_tap_goes_in_and_out_and_a_tilted_cut_takes_longer() -> None:
    machine = rigid("beamline-pusher")
    found = plan_bar([part(hole(500, diameter=16, kind="thread"))], machine)
    drilled, tapped = seconds(found, machine)[:2]
    feed = 8000 / (pi * 16) * 2
    assert tapped == pytest.approx(2 * (5 + 7.1 + 2) / feed * 60, abs=1e-3)
    assert drilled < tapped * 5
    tilted = plan_bar([part(cuts=replace(part().cuts, flange_end=30.0))], machine)
    square, skew, _ = seconds(tilted, machine)
    assert (skew * 80 / 60 - 10) * cos(radians(30)) == pytest.approx(
        square * 80 / 60 - 10, abs=1e-3
    )


def test_tools_changed_by_hand_take_their_time() -> None:
    machine = load("beamline")
    features = [hole(400 + 100 * i, diameter=12 + i) for i in range(7)]
    found = plan_bar([part(*features)], machine)
    time = work_time(found, machine)
    assert time.manual_changes_s == 2 * 90
    assert time.total_s == pytest.approx(sum(time.operations) + 180)


def test_the_way_is_part_of_the_time() -> None:
    near = plan(part(hole(500)), machine="beamline")
    far = plan(part(hole(1500)), machine="beamline")
    machine = load("beamline")
    gained = seconds(far, machine)[1] - seconds(near, machine)[1]
    assert gained == pytest.approx(1000 / 333.3, abs=0.01)


def test_every_operation_is_explained() -> None:
    machine = load("beamline-pusher")
    twin = hole(600.2, 40, 18, "u")
    found = plan(part(hole(500), hole(500, 80), hole(600, 40, 18, "o"), twin, hole(700, 40),
                      hole(700, 90, 22)))  # fmt: skip
    explained = explain(found, machine)
    assert [s.x for s in explained.steps] == [op.x for op in found.operations]
    assert all(s.reasons and all(REASONS[c] == t for c, t in s.reasons) for s in explained.steps)
    assert all(s.sources == ("p.nc1:7",) for s in explained.steps)
    first, second = explained.steps[:2]
    assert [c for c, _ in second.reasons] == ["drill-exact", "place-tool"]
    assert [c for c, _ in first.reasons] == ["drill-exact", "place-x"]
    assert (first.what, first.where) == ("drill 18", "v y 80, part 1") or (
        first.where == "v y 150, part 1"
    )
    flange = next(s for s in explained.steps if s.where.startswith("o "))
    assert flange.rejected == ("both flanges at once (p.nc1:7, feature 4): x 600 and 600.2",)
    changed = [s for s in explained.steps if s.reasons[-1][0] == "place-changes"]
    assert [s.x for s in changed] == [715.0]
    assert explained.total_s == pytest.approx(sum(s.seconds for s in explained.steps))
    assert (explained.back, explained.forward) == (0, found.operations[-1].x)


def test_drills_that_were_as_near_or_further_off_are_named() -> None:
    found = plan(part(hole(500, diameter=26.98)))
    step = explain(found, load("beamline-pusher")).steps[0]
    assert (step.what, step.reasons[0][0]) == ("drill 26.9875", "drill-nearest")
    assert step.rejected == ("drill 27: 0.02 mm off, no nearer",)
    further = plan(part(hole(500, diameter=24.95)), machine="beamline")
    rejected = explain(further, load("beamline")).steps[1].rejected
    assert rejected == ()


def test_a_tap_waits_for_its_drill() -> None:
    found = plan(part(hole(500, diameter=16, kind="thread")))
    steps = explain(found, load("beamline-pusher")).steps
    assert [c for c, _ in steps[1].reasons] == ["tap-thread", "place-after"]


def test_all_eight_ways_are_tried_and_told() -> None:
    channel = part(hole(500, 60), hole(600, 60, face="h", kind="blind", depth=4.0), profile=CHANNEL)
    trials = [*try_turns(channel, load("beamline"), ())]
    assert [t.turn for t in trials] == list(TURNS)
    assert all(t.seconds is None for t in trials)
    assert trials[0].because.startswith("plan-face: found a blind hole on face h")
    assert trials[1].because == "a U does not lie so on the rollers"
    beam = [*try_turns(part(hole(1500)), load("beamline"), ())]
    assert [t.because for t in beam[1:4]] == [
        "", "no different from 'as given'", "no different from 'turned 180 about its length'"
    ]  # fmt: skip


def test_a_hole_from_below_is_made_by_turning_the_part() -> None:
    behind = part(hole(500, 60, face="h", kind="blind", depth=4.0))
    found = plan(behind, machine="beamline", turn=True)
    (piece,) = found.pieces
    assert piece.turn == "turned 180 about its length"
    assert [d.code for d in found.remarks] == ["plan-turned", "plan-blind-point"]
    assert [o.how for o in found.outcomes] == ["made"]
    # By leave it would be left out, but turned it need not be.
    kept = plan(behind, machine="beamline", turn=True, skips=("face",))
    assert [o.how for o in kept.outcomes] == ["made"]
    assert kept.remarks[0].message.endswith("so nothing has to be left out")


def test_a_bar_lies_one_way_for_all_its_parts() -> None:
    """Alone the first would lie as given and the second on its side; a bar cannot do both."""
    machine = load("beamline-pusher")
    flat = part(hole(500, 60), hole(700, 60, face="o"), profile=TUBE)
    below = part(hole(500, 60, face="h"), hole(700, 60, face="v"), profile=TUBE)
    alone = plan_oriented([below], machine, turn=True)
    assert alone.pieces[0].part.profile.height == TUBE.width
    together = plan_oriented([flat, below], machine, turn=True)
    assert {p.part.profile.height for p in together.pieces} == {TUBE.width}
    assert [o.how for o in together.outcomes] == ["made"] * 4
    above = part(hole(500, 60), hole(500, 60, face="h"), hole(500, 60, face="o"),
                 hole(500, 60, face="u"), profile=TUBE)  # fmt: skip
    with pytest.raises(PlanError):
        plan_oriented([above, below], machine, turn=True)


def test_no_part_is_turned_to_where_the_section_is_too_large() -> None:
    """On its side it would be made whole, but the line takes 200 x 120 and not 120 x 200."""
    machine = load("beamline-pusher")
    below = part(hole(500, 60, face="h"), hole(700, 60, face="v"), profile=TUBE)
    assert machine.drill is not None
    narrow = replace(machine, drill=replace(machine.drill, max_width=150.0))
    found = plan_oriented([below], narrow, turn=True, skips=("face",))
    assert found.pieces[0].part.profile.height == TUBE.height
    assert sorted(o.how for o in found.outcomes) == ["made", "skipped"]
    sideways = [t for t in try_turns(below, narrow, ()) if t.turn.swap]
    assert {t.because.partition(":")[0] for t in sideways} == {"plan-section"}


@pytest.mark.parametrize("code", ["Z", "B", "SO"])
def test_a_section_that_the_line_does_not_take_is_refused_before_it_is_turned(code: str) -> None:
    profile = Profile(code, "X", 200.0, 75.0, 2.0, 2.0, 0.0)
    with pytest.raises(PlanError) as refused:
        plan_oriented([part(profile=profile)], load("beamline"), turn=True)
    with pytest.raises(PlanError) as as_given:
        plan_bar([part(profile=profile)], load("beamline"))
    assert refused.value.diagnostics == as_given.value.diagnostics


def test_a_section_too_large_as_given_is_turned() -> None:
    machine = load("beamline-pusher")
    assert machine.drill is not None
    low = replace(machine, drill=replace(machine.drill, max_height=150.0))
    tube = part(hole(500, 60), profile=TUBE)
    with pytest.raises(PlanError) as refused:
        plan_oriented([tube], low)
    said = {d.code: d.message for d in refused.value.diagnostics}
    assert list(said) == ["plan-section", "plan-turn-helps"]
    assert "turned 90 about its length" in said["plan-turn-helps"]
    found = plan_oriented([tube], low, turn=True)
    assert found.pieces[0].part.profile.height == TUBE.width


def test_axes_that_the_file_does_not_have_are_usual_ones() -> None:
    machine = load("beamline")
    bare = replace(machine, axes=())
    found = plan_bar([part(hole(500), hole(900, 40, 18, "o"))], machine)
    for known, assumed in zip(seconds(found, machine), seconds(found, bare), strict=True):
        assert assumed == pytest.approx(known, rel=0.5)
        assert assumed > 0
