"""What all pages of this room share: their templates, scripts, styles and pictures."""

from beamcam.pictures.scene import SPEED_COLOURS, css
from beamcam.pictures.svg import inline_svg
from beamcam.reports.run import as_message, message_line
from beamcam.reports.templates import as_it_stands, static_text, template
from beamcam.setup_sheet.playback import as_script

SCRIPTS = (
    "sha256", "numbers", "trace", "canvas", "gestures", "cell", "table", "guide", "listing",
    "mesh", "solid", "sheet",
)  # fmt: skip


def page(name: str, **values: object) -> str:
    """A page by its template; the same values give the same bytes.

    Templates get the values, and as functions `style`, `script` (of all pages, and of one by its
    name), `data`, `picture` and `message`.
    """
    return template("setup_sheet", name).render(
        values, style=_style, script=_script, picture=lambda s: as_it_stands(inline_svg(s)),
        data=lambda value: as_it_stands(as_script(value)),
        message=lambda said: message_line(as_message(said)),
    )  # fmt: skip


def _script(name: str = "") -> object:
    """A script by its name; without one all that move things, in their order."""
    if name:
        return static_text("setup_sheet", f"{name}.js")
    parts = "\n".join(static_text("setup_sheet", f"{one}.js") for one in SCRIPTS)
    return as_it_stands(f'"use strict";\n{parts}')


def _style() -> object:
    """The style of a page and of the pictures in it, in the light and in the dark."""
    light = "".join(f"--speed-{k}:{c};" for k, (c, _) in enumerate(SPEED_COLOURS))
    dark = "".join(f"--speed-{k}:{d};" for k, (_, d) in enumerate(SPEED_COLOURS))
    return as_it_stands(
        f"{static_text('setup_sheet', 'page.css')}:root{{{light}}}"
        f"svg text{{font-family:system-ui,sans-serif}}{css('svg ')}\n"
        f"@media screen and (prefers-color-scheme: dark){{:root{{{dark}}}{css('svg ', dark=True)}}}"
    )
