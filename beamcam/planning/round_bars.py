"""Round bars and tubes on a bar line: plates that are pipes, and what no side of a round shows."""

from collections.abc import Collection, Iterator
from math import pi, sqrt

from beamcam.errors import Diagnostic, error, note
from beamcam.machine.machine import Machine
from beamcam.model.description import description
from beamcam.model.part import Contour, Hole, Part, Slot
from beamcam.model.pipes import SLACK, named_diameters
from beamcam.model.request import rolled_on
from beamcam.model.rounds import unseen
from beamcam.planning import rules

PIPE = note("plan-pipe",
    "found a plate {found} {height} mm wide; it is the unrolled surface of a pipe {diameter} mm in "
    "diameter, and is sawn as that pipe",
    "Some exporters write a pipe as a plate as wide as its circumference.")  # fmt: skip
ROUND = error("plan-round",
    "found {what}, which is the unrolled surface of a round bar; expected {expected}",
    "Face v of a round is its surface, unrolled: y counts the arc from its lowest line, and v is a "
    "quarter of the way round. A spindle drills square to the surface only in the middle of v, o, "
    "h or u, and the saw cuts planes. A machine for tubes makes the others; --allow-skips "
    "cutout leaves them out.")  # fmt: skip
LEFT_OUT_AS = "cutout"  #: name of what is not seen square for --allow-skips
PLANE_ENDS = "one as wide as the round, of two plane ends that lean in the view of v alone"


def told_of_round(
    given: Part, machine: Machine, skips: Collection[str] = ()
) -> Iterator[Diagnostic]:
    """That a plate is sawn as a pipe, and errors for what spindles and saw cannot make of it.

    Where `skips` has cut-outs, what is not seen square is left out as one.
    """
    part = rolled_on(machine, given)
    plate, diameter = given.profile, part.profile.height
    if part is not given:
        named_mm = named_diameters(plate.name)
        if named_mm and min(abs(one - diameter) for one in named_mm) > SLACK:
            nearest = min(named_mm, key=lambda one: abs(one - diameter))
            expected = f"{pi * nearest:.2f} mm of width, the circumference that its name has"
            yield rules.UNROLLED.at(given.source, found=plate.name, expected=expected)
            return
        yield PIPE.at(
            given.source, found=plate.name, height=f"{plate.height:g}", diameter=f"{diameter:.2f}"
        )
    quarters = ", ".join(f"{k * pi / 4 * diameter:.2f}" for k in range(4))
    wall = max(part.profile.flange_thickness, part.profile.web_thickness or 0.0)
    deeper = machine.drill.breakthrough if machine.drill else 0.0
    for hole in part.features if part.profile.code == "RO" and wall else ():
        if isinstance(hole, Hole | Slot) and hole.depth is None and hole.kind != "mark":
            # Beside its middle the wall curves away from the drill.
            inner = diameter / 2 - wall
            sag = inner - sqrt(max(0.0, inner**2 - (hole.diameter / 2) ** 2))
            if sag > deeper:
                expected = f"one through a wall that curves by {deeper:g} mm, not {sag:.2f}"
                yield ROUND.at(hole.source, what=description(hole), expected=expected)
    for feature in unseen(part) if LEFT_OUT_AS not in skips else ():
        is_end = isinstance(feature, Contour) and feature.kind == "outer"
        expected = PLANE_ENDS if is_end else f"it in the middle of a face, at y {quarters}"
        yield ROUND.at(feature.source, what=description(feature), expected=expected)
