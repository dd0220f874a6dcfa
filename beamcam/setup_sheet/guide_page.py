"""The velocity profile of an axis as a page: the carriage on its guide under the curve."""

from beamcam.geometry.velocity_profile import VelocityProfile
from beamcam.pictures.profile import profile_scene, sample_times
from beamcam.pictures.svg import inline_svg
from beamcam.report.velocity_profile import VelocityUnit
from beamcam.setup_sheet.page import data_script, document_head, playback_section
from beamcam.setup_sheet.playback import trace_data
from beamcam.setup_sheet.static_files import page_script
from beamcam.simulate.state import State
from beamcam.simulate.trace import Trace, TraceAxis, TraceBuilder
from beamcam.version import __version__

DIGITS = 6


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
    """The page; it fetches nothing, and the same profile gives the same bytes."""
    trace = profile_trace(profile, unit)
    times = sample_times(profile)
    rows = zip(times.tolist(), profile.velocity(times).tolist(), strict=True)
    data = {
        "kind": "guide",
        "trace": trace_data(trace),
        "labels": unit.labels(),
        "samples": [[round(t, DIGITS), round(v, DIGITS)] for t, v in rows],
    }
    views = {"guide": "The carriage on its guide, under the profile of its velocity"}
    return (
        f'<!doctype html>\n<html lang="en" data-unit="mm">\n{document_head("velocity profile")}'
        "<body><main>\n<h1>Velocity profile</h1>\n"
        f"{playback_section(trace.axes, views, listing=False, whole=False)}"
        '<section class="pictures"><h2>The profile</h2><div class="picture" role="group" '
        f'tabindex="0" aria-label="profile">{inline_svg(profile_scene(profile, unit))}</div>'
        f"</section>\n</main><footer>beamcam {__version__}</footer>\n"
        f"{data_script('playback', data)}<script>{page_script()}</script></body></html>\n"
    )
