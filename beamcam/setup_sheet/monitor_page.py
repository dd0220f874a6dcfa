"""The page of a controller: its axes drawn while they move, as the playback draws them."""

from typing import Any

from msgspec import Struct

from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.pictures.program import ReadProgram, bar_made, table_made
from beamcam.setup_sheet.html import page
from beamcam.setup_sheet.page import program_data
from beamcam.setup_sheet.playback import NO_SECTION, bar_made_data, cell_data, path_data
from beamcam.simulate.course import cell_axes
from beamcam.simulate.trace import State, TraceAxis, head_axes


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
    data = monitor_data(machine, every_s, work)
    section = data.get("section")
    return page(
        "monitor", title=f"{machine.name} at {address}", unit="mm", program=work.program,
        assumed=section if section and section["assumed"] else None, views=views,
        is_bar=machine.stock == "beam", axes=axes_of(machine), monitor=data,
        text=program_data(work.program.data) if work.program is not None else None,
    )  # fmt: skip
