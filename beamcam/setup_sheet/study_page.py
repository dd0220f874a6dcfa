"""Pages of an encoder's study, of two programs compared and of a velocity profile.

Each is one HTML file that fetches nothing; the same values give the same bytes.
"""

from collections.abc import Sequence

from beamcam.diff.pairing import Difference
from beamcam.geometry.velocity_profile import VelocityProfile
from beamcam.pictures.graphs import Study, encoder_scene, profile_scene, sample_times
from beamcam.pictures.overlay import Compared
from beamcam.pictures.scene import Unit
from beamcam.report.velocity_profile import VelocityUnit
from beamcam.setup_sheet.html import page
from beamcam.setup_sheet.playback import trace_data
from beamcam.simulate.trace import State, Trace, TraceAxis, TraceBuilder

MAX_LISTED = 2000  #: differences in the list
DIGITS = 6


def study_page(study: Study) -> str:
    """What an encoder reads of a program: its figures, and the staircase about the worst corner."""
    return page("encoder", title=f"{study.name}: encoder", study=study, scene=encoder_scene(study))


def diff_page(
    names: tuple[str, str],
    pictures: Sequence[Compared],
    differences: Sequence[Difference],
    unit: Unit = "mm",
) -> str:
    """Two parts or programs: counts, pictures with what is to be seen of them, the differences."""
    sums = [sum(getattr(p, how) for p in pictures) for how in ("same", "changed", "gone", "new")]
    return page(
        "diff", title=f"{names[0]} and {names[1]}", unit=unit, names=names, pictures=pictures,
        counts="{} the same, {} changed, {} gone, {} new".format(*sums),
        differences=differences, most=MAX_LISTED,
    )  # fmt: skip


def profile_trace(profile: VelocityProfile, unit: VelocityUnit) -> Trace:
    """The carriage over time, in mm or revolutions; exact, as each phase is of constant jerk."""
    axis = TraceAxis("carriage", "mm" if unit.way == "mm" else "rev")
    builder = TraceBuilder([axis], [0.0])
    for k, phase in enumerate(profile.phases, 1):
        t, v, a, j = phase.duration_s, phase.velocity, phase.acceleration, phase.jerk
        if t <= 0.0:
            continue
        way = t * (v + t * (a / 2 + t * j / 6))
        later = v + t * (a + t * j / 2)
        scale = t / way if way else 0.0
        place = (phase.position + way) / unit.seconds
        builder.add([t], [[place]], (v * scale, later * scale), k, State())
    return builder.trace()


def guide_page(profile: VelocityProfile, unit: VelocityUnit) -> str:
    """The velocity profile of an axis: the carriage on its guide under the curve."""
    trace = profile_trace(profile, unit)
    times = sample_times(profile)
    rows = zip(times.tolist(), profile.velocity(times).tolist(), strict=True)
    data = {
        "kind": "guide",
        "trace": trace_data(trace),
        "labels": unit.labels(),
        "samples": [[round(t, DIGITS), round(v, DIGITS)] for t, v in rows],
    }
    return page(
        "guide", title="velocity profile", unit="mm", axes=trace.axes,
        scene=profile_scene(profile, unit), playback=data,
    )  # fmt: skip
