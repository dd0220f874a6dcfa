"""The page of a controller: its axes drawn while they move, as the playback draws them."""

from collections.abc import Mapping
from typing import Any

from msgspec import Struct

from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.pictures.program import ReadProgram, bar_made, table_made
from beamcam.setup_sheet.html import page_script, shown, static_text
from beamcam.setup_sheet.page import (
    UNIT_CHOICE,
    axis_table,
    canvases,
    data_script,
    document_head,
    program_data,
)
from beamcam.setup_sheet.playback import NO_SECTION, bar_made_data, cell_data, path_data
from beamcam.simulate.bars import cell_axes
from beamcam.simulate.trace import State, TraceAxis, head_axes
from beamcam.version import __version__

UNKNOWN = (
    "The section is not known: a dashed one of {height:g} x {width:g} mm stands for it. "
    "--part or --program of beamcam monitor says it."
)


class KnownWork(Struct, frozen=True):
    """What is known of the work besides the axes that the controller shows."""

    profile: Profile | None = None  #: of the bar
    program: ReadProgram | None = None  #: that the controller runs


def axes_of(machine: Machine) -> tuple[TraceAxis, ...]:
    """The axes that a controller shows, in the order of its registers."""
    return cell_axes(machine) if machine.stock == "beam" else head_axes(machine)


def monitor_data(machine: Machine, every_s: float, work: KnownWork) -> dict[str, Any]:
    """Data of the machine and of the work for the page's script. Raises VerifyError."""
    axes = [{"name": a.name, "unit": a.unit, "min": a.min, "max": a.max} for a in axes_of(machine)]
    state = {name: getattr(State(), name) for name in State.__struct_fields__}
    data = {"kind": "table", "axes": axes, "every": round(1000 * every_s), "state": state}
    if machine.stock != "beam":
        return data | {"path": path_data(table_made(work.program)) if work.program else []}
    if work.program is not None:
        return data | bar_made_data(bar_made(work.program))
    length = machine.layout.default_bar if machine.layout else 0.0
    cell = cell_data(machine, work.profile or NO_SECTION, length)
    ends = {"kind": "rest", "mark": "", "start": [0.0] * 4, "end": [length] * 4}
    pieces = {"pieces": [ends], "cuts": [], "bores": [], "trails": []}
    return data | cell | pieces


def monitor_page(machine: Machine, every_s: float, address: str, work: KnownWork) -> str:
    """The page; it asks only where it came from, for `axes`. Raises VerifyError."""
    views = {"above": "The cell from above", "side": "The cell from the side",
             "space": "The cell in space; drag or arrow keys turn it"}  # fmt: skip
    if machine.stock != "beam":
        views = {"table": "The head over its table"}
    head = document_head(f"{machine.name} at {address}").replace(
        "default-src 'none'; ", "default-src 'none'; connect-src 'self'; "
    )
    data = monitor_data(machine, every_s, work)
    listing, program = "", ""
    if work.program is not None:
        listing = '<div id="listing" role="listbox" tabindex="0" aria-label="Program"></div>'
        program = data_script("program", program_data(work.program.data))
    return (
        f'<!doctype html>\n<html lang="en" data-unit="mm">\n{head}<body><main>\n'
        f'<div class="top"><h1>{shown(machine.name)} at {shown(address)}</h1>{UNIT_CHOICE}</div>\n'
        '<div id="link" class="verdict" role="status">Not connected yet.</div>\n'
        f"{_work_said(work, data.get('section'))}"
        f'<section class="playback"><div class="stage"><div>{canvases(views)}'
        '<div class="controls"><label><input type="checkbox" id="whole"> '
        f"{'whole length' if machine.stock == 'beam' else 'whole table'}</label></div></div>"
        '<div><div id="state"></div><div id="line"></div>'
        f"{axis_table(axes_of(machine))}{listing}</div></div></section>\n"
        f"</main><footer>beamcam {__version__}</footer>\n"
        f"{data_script('monitor', data)}{program}"
        f"<script>{page_script()}\n{static_text('monitor.js')}</script></body></html>\n"
    )


def _work_said(work: KnownWork, section: Mapping[str, Any] | None) -> str:
    """What is drawn besides the machine, in sentences."""
    said = ""
    if work.program is not None:
        name, sha256 = shown(work.program.name), work.program.sha256
        said = f"<p>Program {name}, SHA-256 <code>{sha256}</code></p>\n"
    if section and section["assumed"]:
        said += f"<p>{UNKNOWN.format(**section)}</p>\n"
    return said
