"""Pages from templates, whose texts are escaped wherever they stand.

A page fetches nothing: scripts and styles are laid into it as they stand in the package.
"""

from importlib.resources import files
from typing import TYPE_CHECKING, Any

from beamcam.caches import cached
from beamcam.model.plan import clock
from beamcam.plain_text import terminal_text
from beamcam.version import __version__

if TYPE_CHECKING:
    from jinja2 import Environment, Template
    from markupsafe import Markup


def template(room: str, name: str) -> "Template":
    """A page of a room ("reports", "setup_sheet") by its name."""
    return _environment(room).get_template(f"{name}.html")


@cached("pages.templates")
def _environment(room: str) -> "Environment":
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader(f"beamcam.{room}", "templates"), autoescape=True, trim_blocks=True,
        lstrip_blocks=True, keep_trailing_newline=True, undefined=StrictUndefined,
        finalize=_shown,
    )  # fmt: skip
    made.globals["version"] = __version__
    made.filters["clock"] = clock
    return made


def _shown(value: Any) -> Any:
    """A value as it stands on a page: of a text no character that steers a terminal or a line."""
    from markupsafe import Markup

    if isinstance(value, str) and not isinstance(value, Markup):
        return terminal_text(value)
    return "" if value is None else value


def as_it_stands(text: str) -> "Markup":
    """What is HTML, a style or a script by itself already."""
    from markupsafe import Markup

    return Markup(text)


def static_text(room: str, name: str) -> "Markup":
    """A script or a style of a room, as it stands in the package."""
    path = files(f"beamcam.{room}").joinpath("static", name)
    return as_it_stands(path.read_text(encoding="utf-8"))
