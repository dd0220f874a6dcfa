"""grbl 1.1, as far as programs of cutting tables use it.

Source: the grbl wiki, "Grbl v1.1 Commands", and its arc check: the radii may differ by 0.005 mm,
or by 0.1 % up to 0.5 mm. Numbers are single precision, so that a sweep below 5e-7 rad would be a
full circle. A line holds at most 79 characters.
"""

from math import atan2, dist, pi

from beamcam.controllers.rs274.blocks import Variant
from beamcam.geometry.plane import Point

ARC_ABSOLUTE = 0.005
ARC_SHARE = 0.001
ARC_NEVER = 0.5
#: Twenty times the sweep at which grbl goes full circle; a coordinate of 800 in single precision
#: is off by 3e-5, which turns a radius of 5 by as much.
MIN_SWEEP_RAD = 1e-5


def arc_fault(start: Point, end: Point, centre: Point, clockwise: bool) -> str | None:
    """grbl's deviation from an arc; None if it makes that arc."""
    near, far = dist(start, centre), dist(end, centre)
    if near < ARC_ABSOLUTE:
        return f"of radius {near:.4f}"
    off = abs(near - far)
    if off > ARC_NEVER or (off > ARC_ABSOLUTE and off > ARC_SHARE * near):
        return f"whose radii at start and end differ by {off:.4f}"
    if start != end:
        turn = atan2(end[1] - centre[1], end[0] - centre[0])
        turn -= atan2(start[1] - centre[1], start[0] - centre[0])
        sweep = (-turn if clockwise else turn) % (2 * pi)
        if min(sweep, 2 * pi - sweep) < MIN_SWEEP_RAD:
            return f"of {sweep:.2g} rad, which may become a full circle"
    return None


GRBL = Variant(
    name="grbl",
    percent=False,
    longest_line=79,
    settings=frozenset({"G17", "G21", "G61", "G80", "G90", "G91.1", "G94"}),
    needed=("G17", "G21", "G90", "G94"),
    switches={
        3: frozenset("S"), 4: frozenset("S"), 5: frozenset(), 7: frozenset(), 8: frozenset(),
        9: frozenset(),
    },
    cycles=False,
    own_switches=range(0),
    own_letters=frozenset(),
    blends=False,
    sides={},
    idle={"G43.1": frozenset("Z"), "G49": frozenset(), "G53": frozenset(), "G92.1": frozenset()},
    offsets=frozenset(f"G{number}" for number in range(54, 60)),
    idle_switches={0: frozenset(), 1: frozenset()},
    probes=frozenset({"G38.2", "G38.3"}),
    named=False,
    arc_fault=arc_fault,
)  # fmt: skip
