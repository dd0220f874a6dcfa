"""Tables of velocity profiles."""

import numpy as np
import pytest
from click.testing import CliRunner

from beamcam.cli import main
from beamcam.motion.velocity_profile import profile_to_velocity
from beamcam.reports.velocity_profile import RPM, Encoder, profile_table

GUIDE = profile_to_velocity(1000.0, 100.0, 50.0)


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


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: profile_table(GUIDE, 0), "step of a table must be above 0 s, found 0"),
        (lambda: Encoder(0), "pulses and travel above 0"),
    ],
)
def test_what_is_no_table_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
