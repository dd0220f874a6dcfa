"""What an encoder reads of a program, as one HTML file that fetches nothing."""

from collections.abc import Sequence

from beamcam.diff.pairing import Difference
from beamcam.geometry.velocity_profile import VelocityProfile
from beamcam.pictures.encoder import Study, encoder_scene
from beamcam.pictures.overlay import Compared
from beamcam.pictures.profile import profile_scene, sample_times
from beamcam.pictures.scene import Unit
from beamcam.pictures.svg import inline_svg
from beamcam.report.velocity_profile import VelocityUnit
from beamcam.setup_sheet.html import page_script, shown, static_text
from beamcam.setup_sheet.page import data_script, document_head, playback_section
from beamcam.setup_sheet.playback import trace_data
from beamcam.simulate.trace import State, Trace, TraceAxis, TraceBuilder
from beamcam.version import __version__


def study_page(study: Study) -> str:
    """The page: the figures of the study, and the staircase about the worst corner."""
    encoder, scene = study.encoder, encoder_scene(study)
    title = f"{study.name}: encoder"
    rows = "".join(
        f'<tr><th scope="row">{name}</th><td>{shown(value)}</td></tr>'
        for name, value in study.figures()
    )
    return (
        f'<!doctype html>\n<html lang="en">\n{document_head(title)}<body><main>\n'
        f"<h1>{shown(title)}</h1>\n"
        f"<p>{encoder.shown}, on each axis of "
        f"{shown(study.machine)}. An encoder shows the count that the axis has passed last: the "
        "true point lies within a count above what is read.</p>\n"
        f"<table><tbody>{rows}</tbody></table>\n"
        f'<section class="pictures"><div class="picture" role="group" tabindex="0" '
        f'aria-label="{shown(scene.title)}">{inline_svg(scene)}</div></section>\n</main>\n'
        f"<footer>beamcam {__version__}. SHA-256 of {shown(study.name)}: "
        f"<code>{study.sha256}</code></footer></body></html>\n"
    )


# --- diff page ------------------------------------------------------------------------------------

# Two parts or two programs compared, as one HTML file that fetches nothing.


MAX_LISTED = 2000  #: differences in the list
SHOWN = (("same", "what is the same"), ("gone", "A"), ("new", "B"), ("moved", "arrows"))


def diff_page(
    names: tuple[str, str],
    pictures: Sequence[Compared],
    differences: Sequence[Difference],
    unit: Unit = "mm",
) -> str:
    """The page: counts, pictures with what is to be seen of them, the differences in words."""
    title = f"{names[0]} and {names[1]}"
    sums = [sum(getattr(p, how) for p in pictures) for how in ("same", "changed", "gone", "new")]
    counts = "{} the same, {} changed, {} gone, {} new".format(*sums)
    choices = "".join(
        f'<label><input type="checkbox" checked data-shows="{style}"> {text}</label>'
        for style, text in SHOWN
    )
    drawn = "".join(
        f'<div class="picture" role="group" tabindex="0" aria-label="{shown(p.scene.title)}">'
        f"{inline_svg(p.scene)}</div>\n"
        for p in pictures
    )
    listed = "".join(f"<li>{shown(d.text)}</li>" for d in differences[:MAX_LISTED])
    more = len(differences) - MAX_LISTED
    rest = f"<p>{more} more differences are not listed.</p>" if more > 0 else ""
    said = f"<ol>{listed}</ol>{rest}" if listed else "<p>They mean the same.</p>"
    verdict = "wrong" if differences else "made"
    noun = "difference" if len(differences) == 1 else "differences"
    return (
        f'<!doctype html>\n<html lang="en" data-unit="{unit}">\n{document_head(title)}'
        f"<body><main>\n<h1>A: {shown(names[0])}<br>B: {shown(names[1])}</h1>\n"
        f'<p class="verdict {verdict}">{len(differences)} {noun}; {counts}</p>\n'
        f'<div class="controls">Show {choices}</div>\n'
        f'<section class="pictures">{drawn}</section>\n<h2>Differences</h2>{said}\n</main>\n'
        f"<footer>beamcam {__version__}</footer>\n"
        f'<script>"use strict";\n{static_text("shows.js")}</script></body></html>\n'
    )


# --- guide page -----------------------------------------------------------------------------------

# The velocity profile of an axis as a page: the carriage on its guide under the curve.


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
