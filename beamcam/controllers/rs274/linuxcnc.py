"""LinuxCNC, as far as programs of cells and cutting tables use it.

Source: LinuxCNC documentation, "G-Codes" and "M-Codes"; the limits of arcs are those of its
interpreter: the radii may differ by 0.1 %, or by 0.02 sqrt(2) mm; nothing below 0.00127 mm.
"""

from math import dist, sqrt

from beamcam.controllers.rs274.blocks import Variant
from beamcam.geometry.plane import Point

#: The interpreter takes 0.0283 mm or 0.1 %. Older manuals say 0.005 mm, which the annexed check
#: of other programs and of grbl uses as well; a program that keeps to it is safe on all of them.
ARC_ABSOLUTE = 0.005
ARC_SHARE = 0.001
ARC_NEVER = 100 * 0.02 * sqrt(2)
MIN_RADIUS = 0.00127


def arc_fault(start: Point, end: Point, centre: Point, clockwise: bool) -> str | None:
    """The interpreter's error for an arc; None if it accepts it."""
    near, far = dist(start, centre), dist(end, centre)
    if near <= MIN_RADIUS or far <= MIN_RADIUS:
        return f"of radius {near:.5f}"
    off = abs(near - far)
    if off > ARC_NEVER or (off > ARC_ABSOLUTE and off > ARC_SHARE * max(near, far)):
        return f"whose radii at start and end differ by {off:.4f}"
    return None


LINUXCNC = Variant(
    name="LinuxCNC",
    percent=True,
    longest_line=255,
    settings=frozenset({"G17", "G21", "G61", "G61.1", "G64", "G90", "G91.1", "G94"}),
    needed=("G17", "G21", "G40", "G90", "G91.1", "G94"),
    switches={
        3: frozenset("S$"), 4: frozenset("S$"), 5: frozenset("$"), 6: frozenset("T"),
        7: frozenset(), 8: frozenset(), 9: frozenset(), 62: frozenset("P"), 63: frozenset("P"),
        64: frozenset("P"), 65: frozenset("P"),
    },
    cycles=True,
    own_switches=range(100, 200),  # "User Defined Commands M100-M199"
    own_letters=frozenset("PQ"),
    blends=True,
    sides={"G41.1": "left", "G42.1": "right"},
    idle={
        "G43": frozenset("HZ"), "G43.1": frozenset("Z"), "G49": frozenset(), "G53": frozenset(),
        "G92.1": frozenset(), "G92.2": frozenset(),
    },
    offsets=frozenset({f"G{number}" for number in range(54, 60)} | {"G59.1", "G59.2", "G59.3"}),
    idle_switches={
        0: frozenset(), 1: frozenset(), 6: frozenset("T"), 48: frozenset(), 49: frozenset(),
        50: frozenset("P"), 51: frozenset("P$"), 52: frozenset("P"), 53: frozenset("P"),
        60: frozenset(),
    },
    probes=frozenset({"G38.2", "G38.3"}),
    named=True,
    arc_fault=arc_fault,
)  # fmt: skip
