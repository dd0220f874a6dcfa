"""Pages of an encoder's study, of two programs compared and of a velocity profile.

Each is one HTML file that fetches nothing; the same values give the same bytes.
"""

from collections.abc import Sequence
from typing import Any

from msgspec import Struct

from beamcam.comparison.pairing import Difference
from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.motion.velocity_profile import VelocityProfile
from beamcam.pictures import ReadProgram
from beamcam.pictures.graphs import Study, encoder_scene, profile_scene, sample_times
from beamcam.pictures.overlay import Overlay
from beamcam.pictures.program import bar_made, table_made
from beamcam.reports.velocity_profile import VelocityUnit
from beamcam.setup_sheet.page import page, program_data
from beamcam.setup_sheet.playback import NO_SECTION, bar_made_data, cell_data, path_data, trace_data
from beamcam.simulation.cell_trace import cell_axes
from beamcam.simulation.trace import State, Trace, TraceAxis, TraceBuilder, head_axes

MAX_LISTED = 2000  #: differences in the list
DIGITS = 6


def study_page(study: Study) -> str:
    """What an encoder reads of a program: its figures, and the staircase about the worst corner."""
    return page("encoder", title=f"{study.name}: encoder", study=study, scene=encoder_scene(study))


def diff_page(
    names: tuple[str, str], pictures: Sequence[Overlay], differences: Sequence[Difference]
) -> str:
    """Two parts or programs: counts, pictures with what is to be seen of them, the differences."""
    sums = [sum(getattr(p, how) for p in pictures) for how in ("same", "changed", "gone", "new")]
    return page(
        "diff", title=f"{names[0]} and {names[1]}", unit="mm", names=names, pictures=pictures,
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
    rows = zip(times.tolist(), profile.sample(times)[1].tolist(), strict=True)
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
