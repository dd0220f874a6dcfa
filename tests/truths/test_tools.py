"""Tools: points, inch sizes, threads, speeds and feeds, by hand and by the tables of the trade."""

import pytest

from beamcam.machine import load
from beamcam.machine.stations import Tool, ToolSet, inch_size, speed_and_feed, tool_numbers
from beamcam.model.cycles import PECKING, cycle_moves

#: Point of a drill: radius / tan(half the angle). tan 59 = 1.664279, tan 67.5 = 2.414214.
POINTS = [
    (118.0, 22.0, 6.60947), (118.0, 18.0, 5.40775), (118.0, 40.0, 12.01721),
    (135.0, 20.0, 4.14214), (90.0, 20.0, 10.0), (60.0, 20.0, 17.32051), (180.0, 20.0, 0.0),
]  # fmt: skip


@pytest.mark.parametrize(("angle", "diameter", "tip"), POINTS)
def test_the_point_of_a_drill(angle: float, diameter: float, tip: float) -> None:
    assert Tool("drill", diameter, angle).tip == pytest.approx(tip, abs=1e-5)
    assert Tool("drill", diameter).point_deg == 118.0


#: An inch is 25.4 mm, so 1/16 is 1.5875.
INCHES = {
    "9/16": 14.2875, "11/16": 17.4625, "13/16": 20.6375, "15/16": 23.8125, "1 1/16": 26.9875,
    "1 3/16": 30.1625, "1 5/16": 33.3375, "1": 25.4,
}  # fmt: skip


@pytest.mark.parametrize("text", INCHES)
def test_sizes_in_inches(text: str) -> None:
    assert inch_size(text) == pytest.approx(INCHES[text], abs=1e-9)


def test_a_set_of_tools_has_its_inch_sizes_behind_the_others() -> None:
    drills = ToolSet("drill", (14.0, 18.0), ("13/16",), numbers=(4, 5, 6))
    assert drills.sizes == (14.0, 18.0, 20.6375)
    assert tool_numbers([drills]) == {
        ("drill", 14.0): 4, ("drill", 18.0): 5, ("drill", 20.6375): 6,
    }  # fmt: skip


#: Kind, diameter, material, grade: rpm = 1000 v / (pi d) and feed in mm/min, by the rows of the
#: machine file (mild steel 30 m/min and 0.28, S355 25 and 0.25, stainless 12 and 0.18, ...).
CUTTING = [
    # 25000 / (pi 22) = 361.72; x 0.25
    (Tool("drill", 22.0), "S355J2", 361.716, 90.429),
    # 30000 / (pi 18) = 530.52; x 0.28
    (Tool("drill", 18.0), "S235JR", 530.516, 148.545),
    (Tool("drill", 20.0), "1.4301", 190.986, 34.3775),
    (Tool("drill", 20.0), "S460N", 238.732, 42.972),
    # carbide on S355: 80000 / (pi 20) = 1273.24; x 0.26
    (Tool("drill", 20.0, tool_material="carbide"), "S355J2", 1273.240, 331.042),
    # a grade that no row names, as S355
    (Tool("drill", 22.0), "", 361.716, 90.429),
    # 30000 / (pi 3) = 3183: the spindle turns 2500 at most; x 0.16
    (Tool("drill", 3.0), "S235JR", 2500.0, 400.0),
    # 15000 / (pi 40) = 119: the spindle turns 150 at least; x 0.25
    (Tool("drill", 40.0), "S460N", 150.0, 37.5),
    # a tap is fed by its pitch: 8000 / (pi 12) = 212.21; x 1.75
    (Tool("tap", 12.0, pitch=1.75), "S235JR", 212.207, 371.362),
    # 90000 / (pi 16) = 1790.49; x 0.15
    (Tool("mill", 16.0, 180.0), "S235JR", 1790.493, 268.574),
    # 18000 / (pi 20) = 286.48; x 0.12
    (Tool("countersink", 20.0, 90.0), "S235JR", 286.479, 34.3775),
    # they do not turn: 4 and 2 m/min
    (Tool("scribe", 1.0, 90.0), "S235JR", 0.0, 4000.0),
    (Tool("punch", 3.0, 90.0), "S235JR", 0.0, 2000.0),
]


@pytest.mark.parametrize(("tool", "grade", "rpm", "feed"), CUTTING)
def test_speed_and_feed(tool: Tool, grade: str, rpm: float, feed: float) -> None:
    drill = load("beamline").drill
    assert drill is not None
    assert speed_and_feed(tool, drill, grade) == pytest.approx((rpm, feed), rel=1e-5)


#: ISO 261: the pitch of coarse threads; the drill before it is the diameter less the pitch, in
#: the sizes of ISO 2306.
THREADS = {
    6: (1.0, 5.0), 8: (1.25, 6.8), 10: (1.5, 8.5), 12: (1.75, 10.2), 16: (2.0, 14.0),
    20: (2.5, 17.5), 24: (3.0, 21.0), 30: (3.5, 26.5),
}  # fmt: skip


def test_threads() -> None:
    (taps,) = (tools for tools in load("beamline-pusher").tools if tools.kind == "tap")
    rows = zip(taps.sizes, taps.pitches, taps.pre_drills, strict=True)
    assert {size: (pitch, drill) for size, pitch, drill in rows} == THREADS
    assert taps.hand == "right"
    for size, (pitch, drill) in THREADS.items():
        assert abs(size - pitch - drill) <= 0.06


def test_what_the_shop_calls_its_tools() -> None:
    assert Tool("tap", 12.0, pitch=1.75).name == "tap M12 x 1.75"
    assert Tool("tap", 12.0, pitch=1.75, hand="left").name == "tap M12 x 1.75 left"
    assert Tool("countersink", 20.0, 90.0).name == "countersink 20 at 90 deg"
    assert Tool("drill", 20.64).name == "drill 20.64"


def test_pecking_by_hand() -> None:
    """G83 from 5 above to 25 deep, 10 at a time: out to R each time, and back to 0.254 above."""
    assert set(PECKING) == {83, 73}
    moves = list(cycle_moves((0.0, 0.0, 5.0), (10.0, 20.0), -25.0, 5.0, 5.0, 5.0, 83, 10.0))
    assert [(m.rapid, *m.end) for m in moves] == [
        (True, 10, 20, 5), (False, 10, 20, -5), (True, 10, 20, 5),
        (True, 10, 20, pytest.approx(-4.746)), (False, 10, 20, -15), (True, 10, 20, 5),
        (True, 10, 20, pytest.approx(-14.746)), (False, 10, 20, -25), (True, 10, 20, 5),
    ]  # fmt: skip
    chips = list(cycle_moves((10.0, 20.0, 5.0), (10.0, 20.0), -15.0, 5.0, 5.0, 5.0, 73, 10.0))
    assert [(m.rapid, m.end[2]) for m in chips] == [
        (False, -5), (True, pytest.approx(-4.746)), (False, -15), (True, 5),
    ]  # fmt: skip
