"""Strokes, feeds and texts of the beam line: what the plan says, in machine coordinates."""

from math import pi

import pytest

from beamcam.emitters import gcode
from beamcam.machine import load
from beamcam.model.part import EndCuts, Feature, Slot
from beamcam.model.program import BeginPart, Comment, DrillCycle, PathCycle, SawStroke, StartBar
from beamcam.motion.beam import beam_program
from beamcam.planning.beam import plan_bar, plan_oriented
from tests.unit.planning.shop import CHANNEL, SOURCE, hole, part


def cycles(*features: Feature, machine: str = "beamline-pusher") -> list[DrillCycle]:
    loaded = load(machine)
    program = beam_program(plan_bar([part(*features)], loaded), loaded, "J")
    return [c for c in program.commands if isinstance(c, DrillCycle)]


def test_a_web_hole_goes_through_web_breakthrough_and_tip() -> None:
    (cycle,) = cycles(hole(500, 100), machine="beamline")
    web = (150 - 7.1) / 2
    assert (cycle.stroke.spindle, cycle.stroke.diameter, cycle.stroke.kind) == (2, 18.0, "drill")
    assert cycle.x == pytest.approx(778.56 + 20 + 500)
    assert cycle.stroke.retract == (50.0, -5.0)
    assert cycle.stroke.approach == (50.0, pytest.approx(web - 5))
    assert cycle.stroke.bottom == (50.0, pytest.approx(web + 7.1 + 2 + 9 / 1.664279))
    assert cycle.stroke.speed_rpm == pytest.approx(25000 / (pi * 18))


def test_a_flange_hole_strokes_along_y() -> None:
    (cycle,) = cycles(hole(500, 40, 18, "u"), machine="beamline")
    assert cycle.stroke.retract == (-5.0, pytest.approx(148.6))
    assert cycle.stroke.bottom[0] == pytest.approx(10.7 + 2 + 9 / 1.664279)


def test_a_blind_hole_counts_to_the_full_diameter() -> None:
    (cycle,) = cycles(hole(500, 40, 18, "u", depth=6.0, kind="blind"))
    assert cycle.stroke.bottom[0] == pytest.approx(6 + 9 / 1.664279)


def test_tools_but_drills_go_as_deep_as_their_point() -> None:
    sink = hole(500, 40, 20, "u", kind="countersink", depth=4.0, angle=90.0)
    drill, cone = cycles(hole(500, 40, 12, "u"), sink)
    assert (drill.stroke.kind, cone.stroke.kind) == ("drill", "countersink")
    assert cone.stroke.bottom[0] == pytest.approx(10.0)
    (mark,) = cycles(hole(500, 40, 0, "u", kind="mark"))
    assert (mark.stroke.kind, mark.stroke.bottom[0], mark.stroke.speed_rpm) == ("punch", 1.0, 0.0)


def test_a_tap_is_fed_by_its_pitch() -> None:
    _, tap = cycles(hole(500, diameter=16, kind="thread"))
    assert (tap.stroke.kind, tap.stroke.pitch) == ("tap", 2.0)
    assert tap.stroke.feed_mm_min == pytest.approx(2 * tap.stroke.speed_rpm)


def test_a_path_keeps_its_depth_and_moves_bar_and_spindle() -> None:
    loaded = load("beamline-pusher")
    plan = plan_bar([part(Slot("v", 500, 150, 20, 40, 0, 0, SOURCE))], loaded)
    program = beam_program(plan, loaded, "J")
    (path,) = (c for c in program.commands if isinstance(c, PathCycle))
    assert (path.kind, path.spindle, path.diameter) == ("mill", 2, 20.0)
    assert [p.x for p in path.points] == [535.0, 495.0, 535.0]
    assert {p.bottom for p in path.points} == {(0.0, (150 - 7.1) / 2 + 7.1 + 2)}


def test_the_program_says_what_the_operator_has_to_do() -> None:
    loaded = load("beamline")
    features = [hole(400 + 100 * i, diameter=12 + i) for i in range(7)]
    plan = plan_oriented([part(*features, cuts=EndCuts(web_end=-50.0))], loaded, turn=True)
    comments = [c.text for c in beam_program(plan, loaded, "J").commands if isinstance(c, Comment)]
    turn = plan.pieces[0].turn
    assert turn != "as given"
    assert comments[0] == f"part 1, P1: {turn}"
    assert len(comments) == 1 + len(plan.reloads) == 3
    load_ = plan.reloads[0]
    assert load_.out is not None
    assert comments[1] == f"web station {load_.station}: {load_.tool.name} for {load_.out.name}"


def test_commands_follow_the_plan() -> None:
    loaded = load("beamline-pusher")
    plan = plan_bar([part(hole(500), cuts=EndCuts(flange_end=20.0))], loaded)
    start, begin, trim, drill, mitre, wedge = beam_program(plan, loaded, "J").commands
    assert start == StartBar(1, 150.0, 300.0)
    assert begin == BeginPart("PART 1 BEGINS: P1")
    assert isinstance(trim, SawStroke) or isinstance(drill, SawStroke)
    assert isinstance(mitre, SawStroke)
    assert mitre.tilt == pytest.approx(20.0)
    assert isinstance(wedge, SawStroke)


def blocks(*features: Feature, machine: str = "beamline-pusher") -> list[str]:
    loaded = load(machine)
    plan = plan_bar([part(*features, profile=CHANNEL)], loaded)
    text = gcode.emit(beam_program(plan, loaded, "J"), loaded)
    return [line.split(" ", 1)[1] if line.startswith("N") else line for line in text.splitlines()]


@pytest.mark.parametrize(
    ("feature", "expected"),
    [
        (
            hole(500, 60, 16, kind="thread"),
            ["M45 K2 L16", "M46 K2", "G00 X515 Y40 Z-5", "G00 X515 Y40 Z61.5", "M03 K159", "M08",
             "G01 X515 Y40 Z77 F5.305", "M04 K159", "G01 X515 Y40 Z61.5 F5.305", "G00 X515 Y40 Z-5",
             "M09", "M05"],
        ),
        (
            hole(500, 60, 0, kind="mark"),
            ["M48 K2 L3", "G00 X515 Y40 Z-5", "G00 X515 Y40 Z61.5", "G01 X515 Y40 Z67.5 F33.333",
             "G00 X515 Y40 Z-5"],
        ),
        (
            Slot("v", 500, 60, 20, 40, 0, 0, SOURCE),
            ["M49 K2 L20", "G00 X535 Y40 Z-5", "G00 X535 Y40 Z61.5", "M03 K1432", "M08",
             "G01 X535 Y40 Z77 F3.581", "G01 X495 Y40 Z77 F3.581", "G01 X535 Y40 Z77 F3.581",
             "G00 X535 Y40 Z-5", "M09", "M05"],
        ),
    ],
)  # fmt: skip
def test_words_of_each_kind(feature: Feature, expected: list[str]) -> None:
    text = blocks(feature)
    at = text.index(expected[0])
    assert text[at : at + len(expected)] == expected


def test_the_tilt_is_a_word_of_the_saw() -> None:
    loaded = load("beamline-pusher")
    plan = plan_bar([part(cuts=EndCuts(web_end=10.0, flange_end=20.0))], loaded)
    text = gcode.emit(beam_program(plan, loaded, "J"), loaded)
    # tan(tilt) = tan(20) cos(10)
    assert "M42 K100 L19.72 F1.333" in text
    assert "M42 K90 L0 F1.333" in text
