"""How far a sound program's bar may differ from its part, from what the machine's file says.

place     a coordinate is written to the output's last decimal: each is off by half a step, a
          hole and the cut that it counts from by a whole one along the bar
pair      two flange holes that are one stroke may lie `merge_tolerance` apart
radius    half of what a drill may be larger or smaller than its hole, and the place
end       the place, and half a step of the angle over the section's size
chords    circles are polygons
"""

from math import hypot, inf, radians, sqrt, tan

from beamcam.machine.machine import Machine
from beamcam.machine.tools import ToolKind
from beamcam.model.part import Part
from beamcam.solid.compare import Bodies, bodies_of
from beamcam.solid.kernel import CHORD
from beamcam.solid.part_solid import Margins

ROUNDING = 1e-4  #: mm of all arithmetic; the kernel merges what is nearer


def bar_bodies(part: Part, machine: Machine) -> Bodies:
    """A part with the voids that a machine's sound program may make at most and at least."""
    drill, saw = machine.drill, machine.saw
    step = machine.format.resolution
    paired = (drill.merge_tolerance * sqrt(2)) if drill and machine.pairs else 0.0
    place = hypot(step, step / 2) + paired + ROUNDING
    path = drill.path_tolerance if drill else 0.0
    sink = drill.sink_tolerance if drill else 0.0
    turn = radians(10.0**-machine.format.angle_decimals / 2)
    cuts = part.cuts
    steep = max(map(abs, (cuts.web_start, cuts.web_end, cuts.flange_start, cuts.flange_end)))
    size = max(part.profile.height, part.profile.width)
    end = step + size * turn * (1 + tan(radians(min(steep, 80.0))) ** 2) + ROUNDING
    least_mitre = saw.min_mitre if saw else 0.0

    def larger(diameter: float) -> float:
        return _fit(diameter, machine)[0] / 2 + place + path + CHORD

    def smaller(diameter: float) -> float:
        return -(_fit(diameter, machine)[1] / 2 + place + path + CHORD)

    wide = Margins(
        larger, step, end, 0.0, _sharpest("drill", machine), minor=0.0, run_out=inf, sink=sink
    )
    narrow = Margins(smaller, -step, -end, 0.0, square_below=least_mitre, sink=-sink)
    return bodies_of(part, wide, narrow, 2 * end, place)


def _fit(diameter: float, machine: Machine) -> tuple[float, float]:
    """How much larger and smaller than its hole a tool may be."""
    drill = machine.drill
    if drill is None or not drill.fits:
        return 0.0, 0.0
    row = next((r for r in drill.fits if diameter <= r.up_to), drill.fits[-1])
    return row.plus + drill.twin, row.minus + drill.twin


def _sharpest(kind: ToolKind, machine: Machine) -> float:
    """The least angle of the points of a kind of tool."""
    return min((tools.point_deg for tools in machine.tools if tools.kind == kind), default=180.0)
