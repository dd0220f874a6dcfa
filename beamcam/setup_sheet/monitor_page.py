"""The page of a controller: its axes drawn while they move, as the playback draws them."""

from typing import Any

from beamcam import __version__
from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.setup_sheet.html import shown
from beamcam.setup_sheet.page import data_script, document_head
from beamcam.setup_sheet.playback import cell_data
from beamcam.setup_sheet.static_files import page_script, static_text
from beamcam.simulate.bars import cell_axes
from beamcam.simulate.state import State
from beamcam.simulate.trace import TraceAxis, head_axes

#: Dimensions drawn for an unknown bar.
PLAIN = Profile("B", "bar", 300.0, 100.0, 10.0, 10.0, 0.0)


def axes_of(machine: Machine) -> tuple[TraceAxis, ...]:
    """The axes that a controller shows, in the order of its registers."""
    return cell_axes(machine) if machine.stock == "beam" else head_axes(machine)


def monitor_data(machine: Machine, every_s: float) -> dict[str, Any]:
    """Machine data for the page's script."""
    axes = [{"name": a.name, "unit": a.unit, "min": a.min, "max": a.max} for a in axes_of(machine)]
    names = State.__struct_fields__
    state = {name: getattr(State(), name) for name in names}
    data = {"kind": "table", "axes": axes, "every": round(1000 * every_s), "state": state}
    if machine.stock != "beam":
        return data
    length = machine.layout.default_bar if machine.layout else 0.0
    cell = cell_data(machine, PLAIN, length)
    ends = {"kind": "rest", "mark": "", "start": [0.0] * 4, "end": [length] * 4}
    return data | cell | {"pieces": [ends], "cuts": [], "bores": [], "trails": []}


def monitor_page(machine: Machine, every_s: float, address: str) -> str:
    """The page; it asks only where it came from, for `axes`."""
    views = {"above": "The cell from above", "side": "The cell from the side",
             "space": "The cell in space; drag or arrow keys turn it"}  # fmt: skip
    if machine.stock != "beam":
        views = {"table": "The head over its table"}
    canvases = "".join(
        f'<canvas data-view="{name}" role="img" aria-label="{label}"'
        f"{' tabindex=0' if name == 'space' else ''}></canvas>"
        for name, label in views.items()
    )
    rows = "".join(
        f'<tr><th scope="row">{shown(axis.name)}</th><td class="n"><data id="axis-{k}" value="0">'
        f"0</data></td><td>{axis.unit}</td></tr>"
        for k, axis in enumerate(axes_of(machine))
    )
    head = document_head(f"{machine.name} at {address}").replace(
        "default-src 'none'; ", "default-src 'none'; connect-src 'self'; "
    )
    return (
        f'<!doctype html>\n<html lang="en" data-unit="mm">\n{head}<body><main>\n'
        f"<h1>{shown(machine.name)} at {shown(address)}</h1>\n"
        '<div id="link" class="verdict" role="status">Not connected yet.</div>\n'
        f'<section class="playback"><div class="stage"><div>{canvases}</div>'
        '<div><div id="state"></div><div id="line"></div>'
        f'<table class="axes"><tbody>{rows}</tbody></table></div></div></section>\n'
        f"</main><footer>beamcam {__version__}</footer>\n"
        f"{data_script('monitor', monitor_data(machine, every_s))}"
        f"<script>{page_script()}\n{static_text('monitor.js')}</script></body></html>\n"
    )
