"""Motion: ramps, profiles and the times of the cell, by the formulas of uniform acceleration."""

from math import sqrt

import pytest

from beamcam.machine import load
from beamcam.model.cell_motion import CellMotion, ramp
from beamcam.motion.velocity_profile import profile_to_velocity


def test_a_trapezoid_and_a_triangle() -> None:
    """1000 mm at 333.3 mm/s and 500 mm/s2: d / v + v / a; 100 mm: 2 sqrt(d / a), no cruise."""
    long = ramp(333.3 / 1000, 500 / 1000)
    assert long.duration_s == pytest.approx(1000 / 333.3 + 333.3 / 500)
    assert long.speed == pytest.approx(0.3333)
    short = ramp(333.3 / 100, 500 / 100)
    assert short.duration_s == pytest.approx(2 * sqrt(100 / 500))
    assert (short.cruise_s, short.share(short.duration_s / 2)) == (0.0, pytest.approx(0.5))
    # After 0.4 s 500 x 0.16 / 2 = 40 mm are done.
    assert long.share(0.4) == pytest.approx(0.04)
    assert long.share(long.duration_s - 0.4) == pytest.approx(0.96)


def test_jerk_rounds_the_ramp() -> None:
    """v 100, a 500, j 5000 over 1000: a / j = 0.1 s, so the ramp takes v / a + a / j = 0.3 s."""
    rounded = ramp(0.1, 0.5, 5.0)
    assert rounded.jerk_s == pytest.approx(0.1)
    assert rounded.rise_s == pytest.approx(0.3)
    assert rounded.duration_s == pytest.approx(10 + 0.3)
    # 5000 x 0.001 / 6 = 0.8333 mm in the first 0.1 s
    assert rounded.share(0.1) == pytest.approx(0.0008333333)


def test_the_profile_of_the_linear_guide() -> None:
    """1000 rpm in 100 s with a jerk of 50 %: 25, 50 and 25 s, 13.33 rpm/s; 166.7, 833.3, 1000."""
    profile = profile_to_velocity(1000.0, 100.0, 50.0)
    assert [phase.duration_s for phase in profile.phases] == pytest.approx([25, 50, 25])
    times = [25.0, 75.0, 100.0]
    assert profile.sample(times)[1].tolist() == pytest.approx([166.6667, 833.3333, 1000], rel=1e-6)
    assert float(profile.sample(50.0)[2]) == pytest.approx(13.33333, rel=1e-6)
    # 13.33 / 25 rpm/s2 over 12.5 s: 0.5333 x 12.5^3 / 6
    assert float(profile.sample(12.5)[0]) == pytest.approx(173.6111, rel=1e-6)
    assert float(profile.sample(100.0)[0]) == pytest.approx(50000)


def test_the_times_of_the_cell() -> None:
    cell = CellMotion(load("beamline"), 150.0)
    # Another spindle 0.5 s and a new tool 8 s; the same again nothing; a pair waits once.
    assert cell.choose(2, "drill", 22.0) == 8.5
    assert cell.choose(2, "drill", 22.0) == 0.0
    assert cell.choose(13, "drill", 18.0) == 8.5
    assert cell.choose(1, "drill", 18.0) == 0.5
    # Half of the time of a spindle to start it.
    assert cell.switch(True) == 0.75
    # The stop over 1000 mm, at 333.3 mm/s and 500 mm/s2.
    assert cell.move({"X": 1000.0}, 1000.0, None).duration_s == pytest.approx(3.6669, abs=1e-4)
    # A feed of 60 mm/min over 10 mm is 10 s, and the ramp of 1 mm/s at 1000 mm/s2 is nothing.
    cell.move({"Y": 0.0}, 5.0, None)
    assert cell.move({"Y": 10.0}, 10.0, 60.0).duration_s == pytest.approx(10.001, abs=1e-4)


def test_the_times_of_a_cut() -> None:
    """Turning 15 degrees at 6 deg/s and 12 deg/s2 takes 2.5 + 0.5 s; clamping 6 s; then the blade
    goes 150 and twice 5 through at 2500 mm/min, 41.667 mm/s, 100 mm/s2: 160 / 41.667 + 0.41667.
    """
    legs = [*CellMotion(load("beamline"), 150.0).cut(15.0, 0.0, None)]
    assert [(round(leg.duration_s, 3), work) for leg, work in legs] == [
        (3.0, False), (6.0, True), (4.257, True), (4.257, False),
    ]  # fmt: skip
