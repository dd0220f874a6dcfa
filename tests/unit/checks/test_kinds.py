"""Threads, sinks, punches, slots and scribed lines, in programs written by hand."""

from math import cos, hypot, pi, sin

import pytest
from msgspec.structs import replace

from beamcam.checks.bars import verify
from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Line
from beamcam.machine import load
from beamcam.model.part import Contour, Feature, Hole, Part, Slot
from tests.unit.checks.programs import IPE200

PUSHER = load("beamline-pusher")
assert PUSHER.drill is not None
#: Slots are milled from the full steel: order stands in `test_sequence`.
MILLS = replace(PUSHER, drill=replace(PUSHER.drill, slots="mill"))
PLACE = Source("P2.nc1", 40)

# The blade is 1.6 thick and counts 90 degrees as square; the part starts at bar x 15 and the
# saw stands 1250 behind the drills, so a hole at x 300 is at X 315 and the cuts at 1264.2 and
# 1250 + 15 + 1000 + 0.8.
FRAME = """\
% P2
G90
M44 K100 L200
M43 K1
{work}G00 X1264.2
M42 K90 L0 F1.333
G00 X2265.8
M42 K90 L0 F1.333
M30
%
"""
APPROACH = "G00 X{x} Y{y} Z-5\nG00 X{x} Y{y} Z42.2\n"
OFF = "M09\nM05\n"
SPEEDS_M_MIN = {"M40": 25, "M45": 8, "M47": 18, "M49": 90}  #: of the cutting data, by the tool


def on(choice: str) -> str:
    """The words that start a spindle: n = 1000 v / (pi d)."""
    tool = choice.split("\n")[0]
    turns = 1000 * SPEEDS_M_MIN[tool[:3]] / (pi * float(tool.split("L")[1]))
    return f"M03 K{turns:.0f}\nM08\n"


def stroke(choice: str, x: float, y: float, z: float, feed: float, turns: bool = True) -> str:
    """A stroke on the web: its surface is at Z 47.2, and Y counts from its middle downwards."""
    place = {"x": f"{x:g}", "y": f"{100 - y:g}"}
    down = f"G01 X{x:g} Y{100 - y:g} Z{z:.3f} F{feed}\nG00 X{x:g} Y{100 - y:g} Z-5\n"
    begin, end = (on(choice), OFF) if turns else ("", "")
    return f"{choice}\n{APPROACH.format(**place)}{begin}{down}{end}"


def tapped(x: float, y: float, z: float, pitch: str = "1.75") -> str:
    place = {"x": f"{x:g}", "y": f"{100 - y:g}"}
    at = f"X{x:g} Y{100 - y:g}"
    return (
        f"M45 K2 L12\nM46 K{pitch}\n{APPROACH.format(**place)}{on('M45 K2 L12')}"
        f"G01 {at} Z{z} F6.189\nM04 K212\n"
        f"G01 {at} Z42.2 F6.189\nG00 {at} Z-5\n{OFF}"
    )


def led(choice: str, points: list[tuple[float, float]], z: float, feed: float, turns: bool) -> str:
    """A tool led along points of the web."""
    (x, y), *rest = points
    text = f"{choice}\n{APPROACH.format(x=f'{x:.3f}', y=f'{100 - y:.3f}')}"
    text += on(choice) if turns else ""
    for px, py in points:
        text += f"G01 X{px:.3f} Y{100 - py:.3f} Z{z:.3f} F{feed}\n"
    px, py = rest[-1]
    return text + f"G00 X{px:.3f} Y{100 - py:.3f} Z-5\n{OFF if turns else ''}"


def messages(work: str, *features: Feature) -> list[str]:
    piece = Part("P2", IPE200, 1000.0, Source("P2.nc1", 1), features=features)
    text = FRAME.format(work=work)
    machine = MILLS if Slot in map(type, features) else PUSHER
    return [str(d) for d in verify(text, (piece,), machine, (), "P2.gcode", bar=6000.0)]


def web(kind: str, diameter: float, depth: float | None = None, angle: float | None = None) -> Hole:
    return Hole("v", 300.0, 80.0, diameter, PLACE, depth, kind, angle)  # type: ignore[arg-type]


# A 10.2 drill has a point of 3.064, so it is through the 5.6 mm of the web from 8.664 on.
PRE = stroke("M40 K2 L10.2", 315, 80, 47.2 + 5.6 + 2 + 3.064, 2.6)
THREAD = web("thread", 12.0)
# The tap's point is one of 118 degrees too where the machine says nothing else.
TAP = tapped(315, 80, 56.8)


def test_a_thread_is_a_drilled_hole_and_a_tap() -> None:
    assert messages(PRE + TAP, THREAD) == []


def test_a_thread_without_its_tap() -> None:
    assert messages(PRE, THREAD) == [
        "P2.nc1:40: error verify-hole-missing: found no thread M12 on face v of P2 at x 300, "
        "y 80; expected one at X 315"
    ]


def test_a_thread_without_its_drill() -> None:
    assert messages(TAP, THREAD) == [
        "P2.gcode:11: error verify-order: found a tap 12 on face v at X 315, y 80 before the "
        "drill; expected the drill first",
        "P2.nc1:40: error verify-hole-missing: found no hole before the thread M12 on face v of "
        "P2 at x 300, y 80; expected one at X 315",
    ]


def test_a_thread_of_another_pitch() -> None:
    fine = tapped(315, 80, 56.8, pitch="1.5").replace("F6.189", "F5.305")
    assert messages(PRE + fine, THREAD) == [
        "P2.gcode:20: error verify-tool: found a tap of pitch 1.5 for the thread M12 on face v of "
        "P2 at x 300, y 80; expected pitch 1.75"
    ]


def test_a_tap_has_to_be_screwed_out() -> None:
    stuck = TAP.replace("M04 K212\n", "")
    assert [m.split("; ")[0] for m in messages(PRE + stuck, THREAD)] == [
        "P2.gcode:21: error verify-turn: found a feed into the material with M03"
    ]


def test_a_drill_that_turns_as_a_tap_does_on_its_way_out() -> None:
    wrong = stroke("M40 K2 L22", 315, 80, 47.2 + 5.6 + 2 + 6.609, 1.507).replace("M03", "M04")
    assert messages(wrong, web("through", 22.0)) == [
        "P2.gcode:10: error verify-turn: found a feed into the material with M04; expected M03"
    ]


def test_a_drill_in_place_of_the_tap() -> None:
    second = stroke("M40 K2 L12", 315, 80, 47.2 + 5.6 + 2 + 3.605, 2.21)
    assert {m.split(": ")[1] for m in messages(PRE + second, THREAD)} == {
        "error verify-hole-extra", "error verify-hole-missing",
    }  # fmt: skip


SUNK = (web("through", 14.0), web("countersink", 20.0, None, 90.0))
THROUGH_14 = stroke("M40 K2 L14", 315, 80, 47.2 + 5.6 + 2 + 4.206, 1.895)
SINK_FEED = 0.573  # 18 m/min at 20 mm, 0.12 mm a turn


@pytest.mark.parametrize(("depth", "said"), [
    (10.0, []),  # a cone of 90 degrees is 20 wide where its tip is 10 deep
    (8.0, ["P2.gcode:19: error verify-depth: found the countersink 20 on face v of P2 at x 300, "
           "y 80 made 8.000 mm deep; expected 10.000"]),
])  # fmt: skip
def test_a_countersink_is_as_wide_as_its_cone_is_deep(depth: float, said: list[str]) -> None:
    sink = stroke("M47 K2 L20", 315, 80, 47.2 + depth, SINK_FEED)
    assert messages(THROUGH_14 + sink, *SUNK) == said


def test_a_punch_mark_is_made_with_the_spindle_standing() -> None:
    mark = web("mark", 0.0, 0.0)
    punched = stroke("M48 K2 L3", 315, 80, 48.2, 33.333, turns=False)
    assert messages(punched, mark) == []
    assert messages("", mark) == [
        "P2.nc1:40: error verify-hole-missing: found no punch mark on face v of P2 at x 300, "
        "y 80; expected one at X 315"
    ]


def test_a_punch_mark_is_as_deep_as_the_part_says() -> None:
    mark = web("mark", 0.0, 1.5)
    assert messages(stroke("M48 K2 L3", 315, 80, 48.7, 33.333, turns=False), mark) == []
    (said,) = messages(stroke("M48 K2 L3", 315, 80, 48.2, 33.333, turns=False), mark)
    assert "punch mark on face v of P2 at x 300, y 80 made 1.000 mm deep; expected 1.500" in said


SLOT = Slot("v", 300.0, 80.0, 18.0, 30.0, 0.0, 0.0, PLACE)
MILL_FEED = 4.476  # 90 m/min at 16 mm, 0.15 mm a turn


def ring(radius: float, half: float = 15.0, shift: float = 0.0) -> list[tuple[float, float]]:
    """The path of a mill round a slot 30 long, from the middle of its right end."""
    right = [(half + radius * cos(t), radius * sin(t)) for t in _angles(-pi / 2, pi / 2)]
    left = [(-half + radius * cos(t), radius * sin(t)) for t in _angles(pi / 2, 3 * pi / 2)]
    points = [(half, 0.0), *right, *left, right[0], (half, 0.0)]
    return [(315 + x + shift, 80 + y) for x, y in points]


def _angles(start: float, end: float) -> list[float]:
    return [start + (end - start) * i / 48 for i in range(49)]


def slot(path: list[tuple[float, float]], z: float = 47.2 + 7.6, choice: str = "M49 K2 L16") -> str:
    return led(choice, path, z, MILL_FEED, True)


def test_a_slot_is_milled_round() -> None:
    assert messages(slot(ring(1.0)), SLOT) == []


def test_the_ends_of_a_slot_may_be_drilled_before() -> None:
    ends = "".join(stroke("M40 K2 L18", x, 80, 47.2 + 5.6 + 2 + 5.408, 1.842) for x in (300, 330))
    assert messages(ends + slot(ring(1.0)), SLOT) == []


@pytest.mark.parametrize(("path", "off"), [
    (ring(1.5), "0.500"),  # cut too wide
    (ring(0.5), "0.500"),  # not cleared
    (ring(1.0, shift=2.0), "2.000"),
    (ring(1.0, half=10.0), "5.000"),
    (ring(1.0)[:60], "2.000"),  # only one side of it
])  # fmt: skip
def test_a_slot_that_is_not_the_parts(path: list[tuple[float, float]], off: str) -> None:
    said = messages(slot(path), SLOT)
    assert len(said) == 1
    assert said[0] == (
        f"P2.gcode:10: error verify-path: found the path of the slot 48 x 18 of P2 {off} mm off; "
        "expected it within 0.022 mm"
    )


def test_a_slot_of_the_wrong_depth_and_tool() -> None:
    assert messages(slot(ring(1.0), 47.2 + 4), SLOT) == [
        "P2.gcode:10: error verify-depth: found the slot 48 x 18 on face v of P2 at x 300, y 80 "
        "made 4.000 mm deep; expected at least 5.600"
    ]
    wide = slot(ring(0.5), choice="M49 K2 L17")
    assert messages(wide, SLOT) == [
        "P2.gcode:5: error verify-no-tool: found a mill 17 chosen; expected a tool that the shop "
        "has, the nearest is 16",
        "P2.gcode:10: error verify-tool: found a mill 17 for the slot 48 x 18 on face v of P2 at "
        "x 300, y 80; expected one of 8, 12, 16, 20",
    ]


def test_of_two_slots_about_one_middle_each_has_its_path() -> None:
    """As of a long hole across a round one: the paths are told apart by their sizes."""
    wide = replace(SLOT, diameter=30.0, length=10.0)
    paths = [slot(ring(7.0, 5.0)), slot(ring(1.0))]
    for made in (paths, paths[::-1]):
        for wanted in ((SLOT, wide), (wide, SLOT)):
            assert messages("".join(made), *wanted) == []
    (said,) = messages(slot(ring(6.5, 5.0)) + paths[1], SLOT, wide)
    assert "found the path of the slot 40 x 30 of P2 0.500 mm off" in said


def test_a_slot_twice_and_none() -> None:
    once = slot(ring(1.0))
    assert messages(once + once, SLOT) == [
        "P2.gcode:119: error verify-path-extra: found a path of a mill on face v from X 330, y 80; "
        "expected none there"
    ]
    assert messages("", SLOT) == [
        "P2.nc1:40: error verify-not-made: found nothing that makes the slot 48 x 18 of P2; "
        "expected it to be made, or skipped by name"
    ]


def test_a_blind_slot_has_to_be_cleared_inside() -> None:
    blind = replace(SLOT, diameter=40.0, depth=3.0)
    outer = ring(12.0)
    assert "verify-path" in messages(slot(outer, 50.2), blind)[0]
    inner = outer + [p for r in (6.0, 1.0) for p in ring(r)]
    assert messages(slot(inner, 50.2), blind) == []


def test_a_rapid_move_along_a_slot_is_none() -> None:
    text = slot(ring(1.0)).replace("G01 X331", "G00 X331", 1)
    said = messages(text, SLOT)
    assert any("verify-sideways" in m for m in said)


LINE = Contour("v", "open", (Line((200.0, 50.0), (260.0, 90.0)), Arc((260.0, 100.0), 10.0, 270.0, 90.0)), PLACE, "mark", False)  # fmt: skip  # noqa: E501


def test_a_line_is_scribed_along_its_curves() -> None:
    arc = [LINE.curves[1].point(i / 20) for i in range(1, 21)]
    path = [(15 + x, y) for x, y in ((200.0, 50.0), (260.0, 90.0), *arc)]
    scribe = led("M50 K2 L1", path, 47.5, 66.667, False)
    assert messages(scribe, LINE) == []
    back = led("M50 K2 L1", path[::-1], 47.5, 66.667, False)
    assert [m for m in messages(back, LINE) if "verify-path" in m] == []
    short = led("M50 K2 L1", path[:-3], 47.5, 66.667, False)
    missing = hypot(path[-1][0] - path[-4][0], path[-1][1] - path[-4][1])
    (said,) = messages(short, LINE)
    head, _, tail = said.partition(" P2 ")
    assert head == "P2.gcode:8: error verify-path: found the path of the line to mark of"
    off, _, expected = tail.partition(" mm off; ")
    assert float(off) == pytest.approx(missing, abs=0.002)
    assert expected == "expected it within 0.022 mm"


@pytest.mark.parametrize(
    ("compound", "angle", "tilt", "said"),
    [
        (True, 80, 20, None),
        (True, 80, 70, "found the tilt of the blade, turned to 80, at 70; expected -65 to 65"),
        (False, 90, 20, None),
        (False, 89.96, 20, None),
        (False, 80, 0, None),
        (False, 80, 20, "found the tilt of the blade, turned to 80, at 20; expected 0 to 0"),
    ],
)
def test_a_blade_that_turns_and_tilts_at_once(
    compound: bool, angle: float, tilt: float, said: str | None
) -> None:
    """Only a saw that is said to do both in one cut may be told to."""
    assert PUSHER.saw is not None
    machine = replace(PUSHER, saw=replace(PUSHER.saw, compound=compound))
    text = FRAME.format(work="").replace("M42 K90 L0", f"M42 K{angle:g} L{tilt:g}", 1)
    found = [str(d) for d in verify(text, (), machine, (), "P2.gcode") if d.code == "verify-limit"]
    assert [one.partition("verify-limit: ")[2] for one in found] == ([said] if said else [])
