"""The third axis, run by an executor of the programs: heights in every cycle, and its faults."""

import re
from math import dist

import pytest

from beamcam.controllers.simotion.cutting_table import BEGIN
from beamcam.emitters import simotion
from tests.conftest import sampled

from . import plant as simulated
from .deeds import (
    alarm,
    break_wire,
    close,
    creep,
    disable,
    displace,
    freeze,
    mend,
    override,
    release,
    reverse,
)
from .plant import (
    CLEARANCE,
    CUT,
    DONE,
    FAULT,
    HOME_HEIGHT,
    HOMING,
    LIFTED,
    PIERCE,
    STOPPED_S,
    STYLES,
    THICKNESS,
    WAITS,
    WORK,
    Deed,
    Plant,
    each_lifted,
    plant,
    small_job,
    small_machine,
    units_of,
)

Z = 2  #: index of the axis
Z_LOW, Z_HIGH = 4, 5  #: its limit switches
Z_WIRES = (7, 8)  #: inputs of theirs
EXACT = 0.06  #: mm of the zero: two cycles of the slow approach, and its stop


def lowered(one: Plant) -> Plant:
    """The same plant, homed, with the torch on and on its way down to cut."""
    one.press_start()
    one.run_while(lambda: not one.tool_on or one.axes[Z].still)
    return one


def cutting(one: Plant) -> Plant:
    """The same plant, homed and cutting its first line."""
    one.press_start()
    one.run_while(lambda: not one.tool_on or max(one.speeds[:Z]) == 0.0)
    return one


# -- heights --------------------------------------------------------------------------------


@pytest.mark.parametrize("style", STYLES)
@each_lifted
def test_the_torch_pierces_and_cuts_at_its_heights(style: str, kind: str) -> None:
    """See also `Plant.observe`: what holds in every cycle of every test."""
    one = plant(style, kind)
    t = one.triggers
    one.press_start()
    seen: list[tuple[float, float, float]] = []  # of ways with the tool off: x, y, height
    while one.value("workState") != DONE and one.clock_s < 60.0:
        before = [axis.position for axis in one.axes]
        one.cycle()
        x, y, z = (axis.position for axis in one.axes)
        if one.value("workState") == WORK and not one.tool_on and dist(before[:2], (x, y)) > 0.0:
            seen.append((x, y, z))
    assert one.diagnostics == []
    assert one.states == [WAITS, HOMING, WORK, DONE]
    assert one.axes[Z].position == pytest.approx(HOME_HEIGHT)
    assert len(seen) > 40
    assert {round(z, 6) for *_, z in seen} == {CLEARANCE + THICKNESS}
    heights, points = one.heights["cut"], one.points["cut"]
    first = points[0]
    pierces = heights[: next(k for k, h in enumerate(heights) if h < PIERCE + THICKNESS)]
    assert {round(h, 9) for h in pierces} == {PIERCE + THICKNESS}
    # The cycles of its time to pierce, and up to three in which what follows is begun.
    in_cycles = len(pierces) / 4
    assert 0.2 / t.cycle_s <= in_cycles <= 0.2 / t.cycle_s + 3
    cuts = [h for h, p in zip(heights, points, strict=True) if dist(p, first) > 1e-9]
    assert len(cuts) > 100
    assert {round(h, 9) for h in cuts} == {CUT + THICKNESS}
    assert heights == sorted(heights, reverse=True), "up with the torch on"
    assert {round(h, 9) for h in one.heights["mark"]} == {CUT + THICKNESS}


@each_lifted
def test_z_is_homed_before_x_and_y_move_again_and_again(kind: str) -> None:
    """A restart behind a fault in mid cut: up first, from wherever the torch was."""
    one = cutting(plant(kind=kind))
    close(1)(one)
    one.cycle()
    assert (one.value("faultNumber"), one.tool_on) == (1, False)
    one.wait(STOPPED_S)
    stood = [axis.place for axis in one.axes]
    mend(one)
    one.press_acknowledge()
    one.cycle()
    one.points.clear()
    one.press_start()
    for _ in range(400):
        if one.axes[Z].place >= one.ends[Z]:
            break
        one.cycle()
        assert [axis.place for axis in one.axes[:2]] == stood[:2]
    one.run_until(DONE)
    again = plant(kind=kind)
    again.press_start()
    again.run_until(DONE)
    assert set(one.places()) == set(again.places()), "the part is begun anew, and made whole"


# -- faults of the axis ---------------------------------------------------------------------


@each_lifted
def test_what_a_bit_tells_of_z_stops_the_torch_in_the_next_cycle(kind: str) -> None:
    """Limit switches, wires and drives, at ten moments of a cut."""
    one = lowered(plant(kind=kind))
    for _ in range(10):
        kept = one.keep()
        for deed, number in (
            (close(Z_LOW), 1), (close(Z_HIGH), 1), (break_wire(Z_WIRES[0]), 1),
            (break_wire(Z_WIRES[1]), 1), (disable(Z), 2), (alarm(Z), 2),
        ):  # fmt: skip
            one.go_back(kept)
            assert one.tool_on
            deed(one)
            one.cycle()
            one.cycle()  # blocks see in the second that a drive has dropped out
            assert (one.value("workState"), one.value("faultNumber")) == (FAULT, number)
            assert not one.tool_on
            one.wait(STOPPED_S)
            assert one.still
        one.go_back(kept)
        one.wait(0.2)


@each_lifted
def test_the_window_of_z_is_its_own(kind: str) -> None:
    """At rest 0.05 mm, where X and Y may be off by 0.26."""
    one = cutting(plant(kind=kind))
    one.wait(0.25)  # what it may trail behind the lift has run down
    kept = one.keep()
    for by, state in ((0.04, WORK), (-0.04, WORK), (0.07, FAULT), (-0.07, FAULT)):
        one.go_back(kept)
        displace(Z, by)(one)
        one.wait(0.1)
        assert (one.value("workState"), one.tool_on) == (state, state == WORK)
        assert one.value("faultNumber") == (7 if state == FAULT else 0)


@each_lifted
def test_a_lift_that_stops_short_is_a_fault(kind: str) -> None:
    one = lowered(plant(kind=kind))
    override(0.0)(one)
    for _ in range(3):
        one.cycle()
    assert (one.value("faultNumber"), one.tool_on) == (4, False)


@each_lifted
def test_a_torch_that_does_not_rise_moves_no_axis(kind: str) -> None:
    """Stuck in the sheet when the cut is done: X and Y stay where they are."""
    one = cutting(plant(kind=kind))
    freeze(Z)(one)
    one.run_while(lambda: one.tool_on)
    stood = [axis.position for axis in one.axes[:2]]
    one.run_until(FAULT, 5.0)
    assert one.value("faultNumber") == 7
    assert [axis.position for axis in one.axes[:2]] == stood
    one.wait(STOPPED_S)
    assert one.still


# -- homing ---------------------------------------------------------------------------------


def z_wrong_by(one: Plant) -> float:
    """How far Z's zero is off: the low switch is at place 0, `overrun` below the supports."""
    return abs(one.axes[Z].origin - one.triggers.overrun)


@pytest.mark.parametrize("kind", sampled(["axes z", "blocks z"], 2))
@pytest.mark.parametrize("what", [close, release])
@pytest.mark.parametrize("cycles", [1, 5, pytest.param(30, marks=pytest.mark.exhaustive)])
def test_a_high_switch_that_lies_for_some_cycles_makes_no_wrong_height(
    kind: str, what: object, cycles: int
) -> None:
    """From every cycle of the homing of Z on, or every third, until X and Y move."""
    one = plant(kind=kind)
    one.press_start()
    found, start = set(), one.axes[0].place
    while one.axes[0].place == start:
        kept = one.keep()
        what(Z_HIGH)(one)  # type: ignore[operator]
        for _ in range(cycles):
            one.cycle()
        mend(one)
        one.run_while(lambda: one.value("workState") == HOMING and one.axes[0].place == start)
        number = one.value("faultNumber")
        found.add(number)
        late = cycles * one.triggers.homing_slow_mm_s * one.triggers.cycle_s
        early = one.triggers.lift_window if cycles > 1 else 0.0
        assert number or z_wrong_by(one) <= EXACT + (late if what is release else early)
        one.go_back(kept)
        for _ in range(1 if cycles == 1 else 3):
            one.cycle()
    assert {0, 8} <= found <= {0, 1, 3, 8}


@each_lifted
def test_what_fails_in_the_homing_of_z_ends_in_its_fault(kind: str) -> None:
    one = plant(kind=kind)
    one.press_start()
    one.wait(0.3)
    kept, start = one.keep(), [axis.place for axis in one.axes[:2]]
    for deed, numbers in (
        (close(Z_LOW), {1}), (release(Z_HIGH), {3, 7}), (disable(Z), {2, 5}), (freeze(Z), {7}),
        (creep(Z, 8.0), {7, 8}), (close(Z_HIGH), {3, 8}),
    ):  # fmt: skip
        one.go_back(kept)
        deed(one)
        one.run_until(FAULT, one.triggers.max_homing_s + 1)
        assert one.value("faultNumber") in numbers
        assert [axis.place for axis in one.axes[:2]] == start, "X and Y never moved"


@each_lifted
@pytest.mark.parametrize("deed", [close(Z_HIGH), break_wire(Z_WIRES[1])])
def test_a_high_switch_that_lies_takes_no_torch_into_the_sheet(kind: str, deed: Deed) -> None:
    """Behind a fault the torch stands at its height to cut; leaving the switch would go down."""
    one = cutting(plant(kind=kind))
    deed(one)
    one.run_until(FAULT, 1.0)
    one.wait(STOPPED_S)
    stood = one.axes[Z].place
    one.press_acknowledge()
    one.wait(0.1)
    one.press_start()
    one.run_until(FAULT, 10.0)
    assert one.value("faultNumber") == 8
    one.wait(STOPPED_S)
    assert stood - one.axes[Z].place <= 2 * one.triggers.lift_window + EXACT < CUT


@each_lifted
def test_a_torch_at_its_high_switch_leaves_it_first(kind: str) -> None:
    """As behind a stop in homing."""
    one = plant(kind=kind)
    one.axes[Z].place = one.ends[Z] + 0.4
    one.press_start()
    one.run_until(DONE)
    assert z_wrong_by(one) <= EXACT


@each_lifted
def test_a_lift_that_runs_down_instead_of_up_is_a_fault(kind: str) -> None:
    one = plant(kind=kind)
    reverse(Z)(one)
    one.press_start()
    one.run_until(FAULT, 2.0)
    assert one.value("faultNumber") == 3
    assert one.axes[Z].place > BEGIN[Z] - 1.0


@each_lifted
def test_z_is_watched_while_x_and_y_home(kind: str) -> None:
    one = plant(kind=kind)
    one.press_start()
    one.run_while(lambda: one.axes[0].still)
    kept = one.keep()
    for deed, number in ((close(Z_LOW), 1), (close(Z_HIGH), 1), (alarm(Z), 2), (disable(Z), 2),
                         (displace(Z, 1.0), 7)):  # fmt: skip
        one.go_back(kept)
        deed(one)
        one.wait(0.1)
        assert (one.value("workState"), one.value("faultNumber")) == (FAULT, number)


@each_lifted
def test_an_error_of_z_before_the_start_is_told(kind: str) -> None:
    one = plant(kind=kind)
    one.cycle()
    alarm(Z)(one)
    one.cycle()
    assert one.value("faultNumber") == 2
    one.press_start()
    assert one.value("workState") == FAULT


# -- mutants of the runtime -----------------------------------------------------------------

NEVER = "FALSE"
MUTANTS = [
    # What stands in the runtime, in lines of any indentation; which word of it, and into what.
    ("IF NOT lifted THEN", "NOT lifted", NEVER),
    ("OR limitZLow OR limitZHigh THEN", "OR limitZLow OR limitZHigh", ""),
    ("ELSIF lifted AND (limitZLow", "lifted AND", "FALSE AND"),
    ("ELSIF lifted AND NOT watchZ.fit", "lifted AND", "FALSE AND"),
    ("OR watchY.strays OR watchZ.strays", "OR watchZ.strays", ""),
    ("OR (watchZ.fit AND watchZ.strays)", "watchZ.strays", NEVER),
    ("window := Z_ARRIVAL_WINDOW", "Z_ARRIVAL_WINDOW", "ARRIVAL_WINDOW"),
    ("lifted := FALSE; elapsed", "FALSE", "lifted"),
    ("IF homeZ.fault <> INT#0 THEN", "homeZ.fault <> INT#0", NEVER),
    ("THEN lifted := TRUE; begins := TRUE;", "begins := TRUE", "begins := FALSE"),
    ("targetZ := z +", "z +", "z -"),
    ("ELSIF NOT met AND (", "NOT met", NEVER),
    ("- targetZ) <= IN_POSITION", "IN_POSITION", "LREAL#100.0"),
    ("OR watchY.faulty OR watchZ.faulty THEN", "OR watchZ.faulty", ""),
]  # fmt: skip
LAWS = (
    lambda kind: test_the_torch_pierces_and_cuts_at_its_heights("chain", kind),
    test_what_a_bit_tells_of_z_stops_the_torch_in_the_next_cycle,
    test_the_window_of_z_is_its_own,
    test_a_lift_that_stops_short_is_a_fault,
    test_z_is_watched_while_x_and_y_home,
    test_what_fails_in_the_homing_of_z_ends_in_its_fault,
    test_z_is_homed_before_x_and_y_move_again_and_again,
    test_an_error_of_z_before_the_start_is_told,
    lambda kind: test_a_high_switch_that_lies_takes_no_torch_into_the_sheet(kind, close(Z_HIGH)),
)
TEXTS = {
    kind: simotion.emit(small_job(kind), small_machine(kind), "chain")
    for kind in ("axes z", "blocks z")
}
#: Of each kind every other one; the exhaustive tests try the others too.
TRIED = [
    pytest.param(kind, *row, marks=[pytest.mark.exhaustive] * ((k + n) % 2))
    for n, kind in enumerate(TEXTS)
    for k, row in enumerate(MUTANTS)
    # A drive that drops out is an error of MC_Power by itself.
    if (kind, row[0]) != ("blocks z", "ELSIF lifted AND NOT watchZ.fit")
]


@pytest.mark.parametrize(("kind", "where", "find", "put"), TRIED)
def test_a_changed_runtime_breaks_a_law(
    kind: str, where: str, find: str, put: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = TEXTS[kind]
    place = re.search(r"\s+".join(map(re.escape, where.split())), text)
    assert place is not None
    changed = text[: place.start()] + place[0].replace(find, put, 1) + text[place.end() :]
    assert changed != text
    units = units_of(changed, small_machine(kind))
    monkeypatch.setattr(simulated, "loaded", lambda *_: units)
    for law in LAWS:
        try:
            law(kind)
        except AssertionError:
            return
    pytest.fail("no law is broken")


def test_every_kind_of_table_is_lifted() -> None:
    assert {small_machine(kind).controller for kind in LIFTED} == {"simotion", "plcopen"}
