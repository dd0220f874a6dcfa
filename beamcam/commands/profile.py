"""`beamcam profile`: the velocity profile of an axis, as a table or a picture."""

import os.path
from math import inf, isfinite
from typing import TYPE_CHECKING

import click

from beamcam.commands import options
from beamcam.commands.common import PICTURES, Console, write
from beamcam.commands.value_types import KINDS, Number, expected
from beamcam.files import FilesRead

if TYPE_CHECKING:
    from beamcam.motion.velocity_profile import VelocityProfile

MOST_ROWS = 1_000_000
NUMBER = Number()


def points_of(
    _context: click.Context, _option: click.Parameter, text: str | None
) -> tuple[tuple[float, float], ...]:
    """The (time, velocity) points of a text such as `0:0,10:500`."""
    if text is None:
        return ()
    points = []
    for pair in text.split(","):
        time, colon, velocity = pair.partition(":")
        try:
            point = float(time), float(velocity)
            if not all(map(isfinite, point)):
                raise ValueError(pair)
            points.append(point)
        except ValueError:
            raise click.BadParameter(
                f"found {pair!r}; expected TIME:VELOCITY,TIME:VELOCITY,..."
            ) from None
        if not colon:
            raise click.BadParameter(f"found {pair!r}; expected TIME:VELOCITY")
    return tuple(points)


def profile_of(
    velocity: float | None, acceleration: float | None, distance: float | None, time: float | None,
    jerk: float, cruise: float, points: tuple[tuple[float, float], ...], max_jerk: float | None,
) -> "VelocityProfile":  # fmt: skip
    """The profile that the options ask for. Raises ValueError where they do not fit together."""
    from beamcam.motion import velocity_profile as profiles

    if points:
        return profiles.profile_through(points, jerk)
    if time is None:
        if distance is None or velocity is None or acceleration is None:
            raise ValueError(
                "give --time with one of --velocity, --acceleration, --distance; or --points; or, "
                "for the fastest profile, --distance, --velocity and --acceleration"
            )
        limits = profiles.AxisLimits(velocity, acceleration, max_jerk or inf)
        return profiles.fastest_profile(distance, limits)
    given = [v for v in (velocity, acceleration, distance) if v is not None]
    if len(given) != 1:
        raise ValueError("with --time give one of --velocity, --acceleration and --distance")
    if velocity is not None:
        return profiles.profile_to_velocity(velocity, time, jerk)
    if acceleration is not None:
        return profiles.profile_by_acceleration(acceleration, time, jerk)
    return profiles.profile_over_distance(given[0], time, jerk, cruise)


@click.command("profile")
@options.output(".csv, .svg, .png, .pdf, or .html with playback; - is a table.")
@click.option("--velocity", type=NUMBER, help="To reach, or the limit of the fastest profile.")
@click.option("--acceleration", type=NUMBER, help="Maximum acceleration, or its limit.")
@click.option("--distance", type=NUMBER, help="To travel from rest to rest.")
@click.option("--time", type=NUMBER, help="Of the ramp, or of the whole distance; seconds.")
@click.option("--jerk", type=NUMBER, default=50.0, show_default=True, help="Rounded part, percent.")
@click.option("--cruise", type=NUMBER, default=0.0, help="Seconds at full velocity, in --time.")
@click.option("--points", callback=points_of, help="TIME:VELOCITY,... joined by ramps.")
@click.option(
    "--max-jerk",
    "--greatest-jerk",
    "max_jerk",
    type=NUMBER,
    help="Limit of the fastest profile; none if absent.",
)
@click.option("--step", type=NUMBER, help="Seconds between rows; a 200th of the time if absent.")
@click.option(
    "--unit",
    type=click.Choice(["rpm", "mm/s"]),
    help="Unit of velocities; positions are in revolutions or mm. rpm needs --pulses.",
)
@click.option("--pulses", type=int, help="Encoder pulses per revolution: adds Hz and rpm columns.")
@click.option("--travel", type=NUMBER, help="Travel per revolution in mm, with --pulses.")
@options.verbosity
def command(
    output: str, velocity: float | None, acceleration: float | None, distance: float | None,
    time: float | None, jerk: float, cruise: float, points: tuple[tuple[float, float], ...],
    max_jerk: float | None, step: float | None, unit: str | None, pulses: int | None,
    travel: float | None, console: Console,
) -> None:  # fmt: skip
    """Write the velocity profile of an axis, as a table or a picture.

    A ramp is an S-curve of which --jerk percent are rounded: 0 is a trapezoid, 100 has no
    constant stretch. Without --time the profile is the fastest within the limits.

    Velocities are mm/s and positions mm; with --unit rpm, or --pulses without --travel, velocities
    are rpm, accelerations rpm/s and positions and --distance revolutions.

    \b
    beamcam profile --velocity 1000 --time 100 --jerk 50 --pulses 120 -o ramp.csv
    beamcam profile --unit rpm --distance 25 --time 4 -o turns.csv
    beamcam profile --distance 500 --time 4 --jerk 100 -o move.svg
    beamcam profile --points 0:0,2:300,5:300,6:0 -o job.html
    beamcam profile --distance 500 --velocity 200 --acceleration 800 --max-jerk 9000 -o -
    """
    from beamcam.reports.velocity_profile import MM_S, RPM, Encoder, profile_table

    suffix = os.path.splitext(output)[1].lower()
    try:
        if travel is not None and pulses is None:
            raise ValueError("--travel goes with --pulses, the encoder's pulses a revolution")
        in_turns = unit == "rpm" or (unit is None and pulses is not None and travel is None)
        if unit is not None and pulses is not None and (travel is None) is not in_turns:
            raise ValueError(
                "--travel goes with --unit mm/s; rpm are revolutions already"
                if in_turns
                else "with --unit mm/s the encoder needs --travel, its way of a revolution"
            )
        shown = RPM if in_turns else MM_S
        way = None if distance is None else distance * shown.seconds
        profile = profile_of(velocity, acceleration, way, time, jerk, cruise, points, max_jerk)
        encoder = None if pulses is None else Encoder(pulses, travel)
        data: str | bytes
        if suffix not in ("", *KINDS["profile"]):
            raise ValueError(expected(output, "profile"))
        if suffix in PICTURES:
            from beamcam.pictures.formats import picture
            from beamcam.pictures.graphs import profile_scene

            data = picture([profile_scene(profile, shown)], suffix)
        elif suffix == ".html":
            from beamcam.setup_sheet.study_page import guide_page

            data = guide_page(profile, shown)
        else:
            step = step or profile.duration_s / 200
            if profile.duration_s > MOST_ROWS * step:  # than memory holds
                raise ValueError(
                    f"found a step of {step:g} s; expected {profile.duration_s / MOST_ROWS:g} s or "
                    f"more, for at most {MOST_ROWS:,} rows"
                )
            rows = profile_table(profile, step, encoder, shown)
            lines = [",".join(f"{value:.9g}" for value in row) for row in rows.rows.tolist()]
            data = "\n".join([",".join(rows.columns), *lines]) + "\n"
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    console.did(f"profile of {profile.duration_s:g} s")
    write(output, data, console, FilesRead(()))
