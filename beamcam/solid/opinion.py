"""The third opinion: a program machined as a solid, and each piece compared with its part.

It shares nothing with planning, motion and emitters, and nothing with the read-back but the
controllers' events.
"""

from math import hypot, inf, radians, sqrt, tan
from typing import TYPE_CHECKING

from beamcam.controllers import cell_events
from beamcam.errors import BeamcamError, Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.request import Request, rolled_on
from beamcam.model.rounds import with_sawn_ends
from beamcam.solid import NO_MACHINE, PIECES
from beamcam.solid.bar_solid import bar_pieces, lying, points_of, said_of_section, work_of
from beamcam.solid.compare import (
    ALIKE,
    Bodies,
    FittedPiece,
    best_fit,
    bodies_of,
    differences,
    likely,
    ways_to_lie,
    without_left_out,
)
from beamcam.solid.copers import coper_faults
from beamcam.solid.kernel import CHORD, kernel
from beamcam.solid.plates import sheet_faults
from beamcam.solid.stock_solid import Margins

if TYPE_CHECKING:
    from manifold3d import Manifold

# --- bar margins ----------------------------------------------------------------------------------

# How far a sound program's bar may differ from its part, from what the machine's file says.
#
# place     a coordinate is written to the output's last decimal: each is off by half a step, a
#           hole and the cut that it counts from by a whole one along the bar
# pair      two flange holes that are one stroke may lie `merge_tolerance` apart
# radius    half of what a drill may be larger or smaller than its hole, and the place
# end       the place, and half a step of the angle over the section's size
# chords    circles are polygons


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
        return _fit_of_drills(diameter, machine)[0] / 2 + place + path + CHORD

    def smaller(diameter: float) -> float:
        return -(_fit_of_drills(diameter, machine)[1] / 2 + place + path + CHORD)

    sharpest = min((t.point_deg for t in machine.tools if t.kind == "drill"), default=180.0)
    largest = Margins(larger, step, end, 0.0, sharpest, minor=0.0, run_out=inf, sink=sink)
    smallest = Margins(smaller, -step, -end, 0.0, square_below=least_mitre, sink=-sink)
    return bodies_of(part, largest, smallest, 2 * end, place)


def _fit_of_drills(diameter: float, machine: Machine) -> tuple[float, float]:
    """How much larger and smaller than its hole a tool may be."""
    drill = machine.drill
    if drill is None or not drill.fits:
        return 0.0, 0.0
    row = next((r for r in drill.fits if diameter <= r.up_to), drill.fits[-1])
    return row.plus + drill.same_tool_tolerance, row.minus + drill.same_tool_tolerance


def solid_faults(
    program: str | bytes, request: Request, bar: float | None = None
) -> tuple[Diagnostic, ...]:
    """Where the pieces that a program leaves differ from those of a request.

    They may lie in any order and turned, but that of a coper lies where its machine puts it; `bar`
    is the length of the bar. What no solid shows is not looked for: marks, texts, scribed lines,
    threads. A machine or a section that has no solid is said (`solid-machine`, `solid-none`), as is
    a missing manifold3d.
    """
    text = program if isinstance(program, str) else program.decode("utf-8", "replace")
    try:
        kernel()
        if request.machine.stock == "beam":
            return tuple(_of_bar(text, request, bar))
        if request.machine.stock == "profile":
            return tuple(coper_faults(text, request.parts, request, bar))
        has_words = request.machine.controller in ("codesys", "linuxcnc", "grbl", "mach3")
        if request.machine.stock == "sheet" and has_words:
            return tuple(sheet_faults(text, expected_parts(request), request))
        raise BeamcamError(NO_MACHINE.at(Source(request.name), found=request.machine.name))
    except BeamcamError as error:
        return error.diagnostics


def expected_parts(request: Request) -> list[Part]:
    """The part of each piece: as often as the request or the part's file says, or once."""
    quantity = request.quantity
    is_bar = request.machine.stock == "beam"
    return [
        one
        for part in request.parts
        for one in [with_sawn_ends(rolled_on(request.machine, part)) if is_bar else part]
        for _ in range(1 if quantity is None else part.quantity if quantity == "file" else quantity)
    ]


def _of_bar(text: str, request: Request, bar: float | None) -> list[Diagnostic]:
    parts, machine, name = expected_parts(request), request.machine, request.name
    events, _ = cell_events(text, machine, name)
    stock = lying(parts[0], said_of_section(events, machine))
    work = work_of(events, machine, stock)
    pieces = bar_pieces(work, stock, machine, bar, points_of(machine, parts))
    known: dict[Part, Bodies] = {}
    for part in parts:
        if part not in known:
            known[part] = bar_bodies(part, machine)
    bodies = [known[part] for part in parts]
    source = Source(name)
    if len(pieces) < len(parts):
        found = f"{len(pieces)} piece(s)"
        return [PIECES.at(source, found=found, expected=f"{len(parts)}, one for each part")]
    diagnostics: list[Diagnostic] = []
    free = {*range(len(pieces))}
    for number, one in enumerate(bodies, 1):
        costs = [(cost, k) for cost, k in likely(pieces, one) if k in free]
        alike = [k for cost, k in costs if cost <= costs[0][0] + ALIKE]
        fits = [(k, fit) for k in alike if (fit := _fit(pieces[k], stock, one)) is not None]
        if not fits:
            return [PIECES.at(source, found="no piece", expected=one.part.mark or "a part")]
        chosen, best = next(((k, fit) for k, fit in fits if not fit.differs), fits[0])
        free.remove(chosen)
        mirror = ways_to_lie(pieces[chosen], stock, one, True)
        best, told = without_left_out(best, one, f"piece {number}", request.skips)
        diagnostics += (*told, *differences(best, mirror, one, f"piece {number}", source))
    for piece in (pieces[k] for k in sorted(free)):  # parts though no more are wanted
        for one in known.values():
            alike_one = likely([piece], one)[0][0] <= ALIKE
            if alike_one and (more := _fit(piece, stock, one)) is not None and not more.differs:
                found = f"one more {one.part.mark or 'part'}"
                diagnostics.append(PIECES.at(source, found=found, expected="only those asked"))
    return diagnostics


def _fit(piece: "Manifold", stock: Part, bodies: Bodies) -> FittedPiece | None:
    """How a piece of the bar fits its part, as it lies or turned."""
    return best_fit(ways_to_lie(piece, stock, bodies, False), bodies)
