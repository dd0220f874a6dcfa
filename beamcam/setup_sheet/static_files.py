"""The scripts and the styles of a page, as they stand in the package."""

from importlib.resources import files

from beamcam.pictures.styles import SPEED_COLOURS, css

SCRIPTS = (
    "sha256", "numbers", "trace", "canvas", "gestures", "cell", "table", "guide", "listing",
    "mesh", "solid", "sheet",
)  # fmt: skip


def static_text(name: str) -> str:
    """Content of a file beside this one."""
    return files("beamcam.setup_sheet").joinpath("static", name).read_text(encoding="utf-8")


def page_script() -> str:
    """All scripts as one, in their order."""
    parts = "\n".join(static_text(f"{name}.js") for name in SCRIPTS)
    return f'"use strict";\n{parts}'


def page_style() -> str:
    """The style of the page and of the pictures in it, in the light and in the dark."""
    light = "".join(f"--speed-{k}:{c};" for k, (c, _) in enumerate(SPEED_COLOURS))
    dark = "".join(f"--speed-{k}:{d};" for k, (_, d) in enumerate(SPEED_COLOURS))
    return (
        f"{static_text('page.css')}:root{{{light}}}svg text{{font-family:system-ui,sans-serif}}"
        f"{css('svg ')}\n@media screen and (prefers-color-scheme: dark){{:root{{{dark}}}"
        f"{css('svg ', dark=True)}}}"
    )
