"""Profiles whose numbers are known, and their tables and pictures."""

import struct
import xml.etree.ElementTree as ElementTree
import zlib
from math import inf

import numpy as np
import pytest
from click.testing import CliRunner

from beamcam.cli import main
from beamcam.motion.profile import (
    Limits,
    fastest_profile,
    profile_over_distance,
    profile_through,
    profile_to_velocity,
)
from beamcam.motion.profile_report import (
    RPM,
    Encoder,
    profile_png,
    profile_svg,
    profile_table,
)

GUIDE = profile_to_velocity(1000.0, 100.0, 50.0)


def test_the_linear_guide_reaches_1000_rpm_in_100_s():
    assert [p.duration_s for p in GUIDE.phases] == [25, 50, 25]
    assert max(p.acceleration for p in GUIDE.phases) == pytest.approx(40 / 3)
    assert GUIDE.velocity([25, 75, 100]) == pytest.approx([500 / 3, 2500 / 3, 1000])
    assert GUIDE.velocity(100.0) == 1000.0


@pytest.mark.parametrize(("percent", "durations"), [(0, [10]), (100, [5, 5]), (20, [1, 8, 1])])
def test_trapezoid_and_fully_rounded_ramps(percent, durations):
    profile = profile_to_velocity(5.0, 10.0, percent)
    assert [p.duration_s for p in profile.phases] == pytest.approx(durations)
    assert profile.distance == 25


def test_a_triangle_peaks_at_twice_the_mean_velocity():
    profile = profile_over_distance(100.0, 10.0, 0.0)
    assert profile.velocity(5.0) == 20
    assert [p.acceleration for p in profile.phases] == [4, -4]


def test_a_trapezoid_cruises():
    profile = profile_over_distance(100.0, 10.0, 0.0, cruise_s=6.0)
    assert profile.velocity([2.0, 8.0]) == pytest.approx([12.5, 12.5])


def test_points_are_joined_and_equal_ones_are_a_cruise():
    profile = profile_through([(5, 0), (7, 10), (9, 10), (10, 0)], 100.0)
    assert profile.distance == 10 + 20 + 5
    assert profile.acceleration(3.0) == 0
    assert profile.duration_s == 5


@pytest.mark.parametrize(
    ("distance", "jerk", "duration"),
    [
        (1.0, inf, 2 * (1 / 100) ** 0.5),  # triangle: 2 sqrt(s / a)
        (100.0, inf, 100 / 50 + 50 / 100),  # trapezoid: s / v + v / a
        (1000.0, 1000.0, 1000 / 50 + 50 / 100 + 100 / 1000),  # s / v + v / a + a / j
        (0.002, 1000.0, 4 * (0.001 / 1000) ** (1 / 3)),  # jerk alone: (32 s / j)^(1/3)
    ],
)
def test_fastest_from_rest_to_rest(distance, jerk, duration):
    profile = fastest_profile(distance, Limits(50.0, 100.0, jerk))
    assert profile.duration_s == pytest.approx(duration, rel=1e-12)


def test_no_way_at_a_steady_speed_takes_no_time():
    profile = fastest_profile(0.0, Limits(50.0, 100.0), 10.0, 10.0)
    assert (profile.phases, profile.duration_s) == ((), 0.0)
    assert profile.velocity([-1.0, 0.0, 1.0]).tolist() == [10, 10, 10]
    assert profile.position(2.0) == 20


def test_outside_its_time_a_profile_goes_on():
    assert GUIDE.velocity([-5, 105]).tolist() == [0, 1000]
    assert GUIDE.position([-5, 105]).tolist() == [0, 55_000]
    assert GUIDE.acceleration([-5, 105]).tolist() == [0, 0]


def test_table_with_encoder():
    table = profile_table(GUIDE, 30.0, Encoder(120))
    assert table.columns == (
        "t_s", "position", "velocity", "acceleration", "encoder_hz", "encoder_rpm",
    )  # fmt: skip
    assert table.rows[:, 0].tolist() == [0, 30, 60, 90, 100]
    assert table.rows[-1, [1, 2, 4, 5]].tolist() == [50_000, 1000, 2000, 1000]
    assert table.rows[:, 5] == pytest.approx(table.rows[:, 4] * 60 / 120)
    assert profile_table(GUIDE, 25.0).rows.shape == (5, 4)


def test_revolutions():
    """1000 rpm after 100 s are 833.33 revolutions, 50,000 sixtieths of one."""
    table = profile_table(GUIDE, 25.0, Encoder(120), RPM)
    assert table.rows[:, 1] == pytest.approx([0, 23.148148, 162.037037, 439.814815, 833.333333])
    assert table.rows[-1, [2, 3, 4, 5]].tolist() == [1000, 0, 2000, 1000]
    # The way is the sum of what the encoder counts: pulses a second over time.
    fine = profile_table(GUIDE, 0.1, Encoder(120), RPM).rows
    pulses = np.trapezoid(fine[:, 4], fine[:, 0])
    assert pulses / 120 == pytest.approx(833.3333, rel=1e-6)


@pytest.mark.parametrize(
    ("words", "last"),
    [
        ("--velocity 1000 --pulses 120", "100,833.333333,1000,0,2000,1000"),
        ("--velocity 1000 --unit rpm", "100,833.333333,1000,0"),
        ("--velocity 1000 --unit rpm --pulses 120", "100,833.333333,1000,0,2000,1000"),
        ("--velocity 1000", "100,50000,1000,0"),
        ("--velocity 65 --pulses 512 --travel 65", "100,3250,65,0,512,60"),
        ("--velocity 65 --unit mm/s --pulses 512 --travel 65", "100,3250,65,0,512,60"),
        ("--distance 25 --unit rpm", "100,25,0,0"),
    ],
)
def test_units_of_the_command(words, last):
    done = CliRunner().invoke(main, f"profile --time 100 --step 25 -o - {words}".split())
    assert done.exit_code == 0, done.output
    row = [float(v) for v in done.stdout.splitlines()[-1].split(",")]
    assert row == pytest.approx([float(v) for v in last.split(",")], abs=1e-9)


def test_a_distance_in_revolutions_has_its_velocity_in_rpm():
    done = CliRunner().invoke(
        main,
        ["profile", "--unit", "rpm", "--distance", "25", "--time", "4", "--step", "2", "-o", "-"],
    )
    _, _, middle, _ = done.stdout.splitlines()
    assert [float(v) for v in middle.split(",")][:3] == [2, 12.5, 750]  # 2 * 25 / 4 * 60


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--unit mm/s --pulses 120", "with --unit mm/s the encoder needs --travel"),
        ("--unit rpm --pulses 120 --travel 65", "--travel goes with --unit mm/s"),
        ("--travel 65", "--travel goes with --pulses"),
        ("--pulses 120 --travel 0", "an encoder needs pulses and travel above 0"),
        ("--unit inch", "'inch' is not one of"),
    ],
)
def test_units_that_contradict_each_other(words, said):
    done = CliRunner().invoke(main, f"profile --velocity 5 --time 1 -o - {words}".split())
    assert done.exit_code == 2
    assert said in done.output


def test_encoder_on_a_belt():
    hz = Encoder(512, 65.0).hz(np.array([65.0]))
    assert hz == pytest.approx(512)


def test_svg_shows_three_curves():
    root = ElementTree.fromstring(profile_svg(GUIDE))
    name = "{http://www.w3.org/2000/svg}"
    assert len(root.findall(f"{name}polyline")) == 3
    texts = [e.text for e in root.findall(f"{name}text")]
    assert {"velocity, mm/s", "1000", "50000", "13.333", "100 s", "0"} <= set(texts)
    turns = ElementTree.fromstring(profile_svg(GUIDE, unit=RPM))
    shown = {"position, revolutions", "833.33", "velocity, rpm", "acceleration, rpm/s"}
    assert shown <= {e.text for e in turns.iter(f"{name}text")}
    for line in root.findall(f"{name}polyline"):
        points = [tuple(map(float, p.split(","))) for p in line.get("points").split()]
        assert all(0 <= x <= 800 and 0 <= y <= 600 for x, y in points)
    assert profile_svg(GUIDE) == profile_svg(GUIDE)


def test_png_is_a_picture_with_three_colours():
    data = profile_png(GUIDE, 200, 150)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", data[16:24]) == (200, 150)
    at, body = 8, b""
    while at < len(data):
        (size,) = struct.unpack(">I", data[at : at + 4])
        kind, chunk = data[at + 4 : at + 8], data[at + 8 : at + 8 + size]
        assert struct.unpack(">I", data[at + 8 + size : at + 12 + size])[0] == zlib.crc32(
            kind + chunk
        )
        body += chunk if kind == b"IDAT" else b""
        at += 12 + size
    rows = np.frombuffer(zlib.decompress(body), np.uint8).reshape(150, 1 + 3 * 200)
    assert not rows[:, 0].any()
    colours = {tuple(c) for c in rows[:, 1:].reshape(-1, 3).tolist()}
    assert colours == {
        (255, 255, 255), (153, 153, 153), (27, 120, 55), (33, 102, 172), (178, 24, 43),
    }  # fmt: skip


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: profile_to_velocity(1, 0, 50), "time must be above 0 s, found 0"),
        (lambda: profile_to_velocity(1, 1, 101), "jerk must be 0 to 100 %, found 101"),
        (lambda: profile_over_distance(1, 2, 0, 2), "a cruise of 2 s leaves no ramps in 2 s"),
        (lambda: profile_through([(0, 1)], 0), "2 points or more, found 1"),
        (lambda: profile_through([(1, 1), (1, 2)], 0), "times must rise, found 1 s after 1 s"),
        (lambda: Limits(1, 0), "limit of acceleration must be above 0"),
        (
            lambda: fastest_profile(5, Limits(10, 1), 11),
            "between 0 and 10 for a distance of 5, found 11 and 0",
        ),
        (lambda: fastest_profile(-5, Limits(10, 1), 1), "between 0 and -10 for a distance of -5"),
        (
            lambda: fastest_profile(5, Limits(10, 1), 10),
            "a change from 10 to 0 takes 50, found a distance of 5",
        ),
        (lambda: profile_table(GUIDE, 0), "step of a table must be above 0 s, found 0"),
        (lambda: Encoder(0), "pulses and travel above 0"),
    ],
)
def test_what_is_no_profile_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
