"""A coper's program for a setup sheet: the way of the torch over the surface of the bar, unrolled.

y   o   height + (width - Z)      the flange above v, its edge beside v at the height
    v   Y                         the web from the front
    u   -(width - Z)              the flange below
of a tube that turns the way round its surface, from the middle of its lowest line towards v
"""

import numpy as np
from msgspec.structs import replace

from beamcam.geometry.array_types import Floats
from beamcam.machine.coper import Coper
from beamcam.model.part import Part
from beamcam.pictures.coper import CoperProgram, part_of, strokes_of
from beamcam.pictures.table import TableMade
from beamcam.setup_sheet.operations import Operation, table_operations
from beamcam.simulate.trace import Trace, TraceAxis
from beamcam.verify.coping.tube import tube_section, unrolled_pipe

ROUND = TraceAxis("round the bar", "mm", has_encoder=False)


def coper_made(program: CoperProgram, trace: Trace) -> TableMade:
    """The way of the torch as that of a head over a table: along the bar, and round it.

    Raises VerifyError where the section is not known.
    """
    machine = program.machine
    coper = machine.needed(machine.coper, "coper")
    round_bar = _round(trace.positions, unrolled_pipe(part_of(program)), coper)
    positions = np.insert(trace.positions, 1, round_bar, axis=1)
    axes = (trace.axes[0], ROUND, *trace.axes[1:])
    return TableMade(
        replace(trace, axes=axes, positions=positions), machine, program.name, program.sha256
    )


def _round(positions: Floats, part: Part, coper: Coper) -> Floats:
    """Where the torch is round the bar at each knot, mm."""
    profile = part.profile
    _, y, z, a_deg, *tilts = positions.T
    if coper.a_unit == "mm":
        around: Floats = a_deg.copy()
        return around
    if coper.turns == "bar":
        place = tube_section(part, coper).place
        found: Floats = np.array([place(*row)[0] for row in positions[:, 1:].tolist()])
        return found
    a, pivot = np.radians(a_deg), coper.pivot
    if tilts:
        pivot = pivot * np.cos(np.radians(tilts[0]))
    tip_y, tip_z = y + pivot * np.sin(a), z - pivot * np.cos(a)
    beside = profile.width - tip_z
    found = np.select(
        [a_deg < -45.0, a_deg > 45.0], [profile.height + beside, -beside], default=tip_y
    )
    return found


def coper_operations(program: CoperProgram, made: TableMade) -> tuple[Operation, ...]:
    """The cuts with the faces that they are on; X is the machine's."""
    part = part_of(program)
    strokes = strokes_of(program, part)
    is_round = part.profile.code == "RO" or unrolled_pipe(part) is not part
    return tuple(
        replace(op, what="cut" if is_round else f"cut on face {stroke.face}", y=None)
        for op, stroke in zip(table_operations(made), strokes, strict=True)
    )
