"""What LinuxCNC, Mach3 and grbl take of RS274, as far as programs of cells and tables use it."""

import re
from math import atan2, dist, pi, sqrt

from msgspec.structs import replace

from beamcam.controllers.rs274.blocks import Variant
from beamcam.geometry.plane import Point

OFFSETS = frozenset(f"G{number}" for number in range(54, 60))  #: of the workpiece


def _switches(words: str) -> dict[int, frozenset[str]]:
    """M words, each with the letters that belong to it behind its number."""
    pairs = re.findall(r"(\d+)(\S*)", words)
    return {int(number): frozenset(letters) for number, letters in pairs}


# --- LinuxCNC -------------------------------------------------------------------------------------

# Source: LinuxCNC documentation, "G-Codes" and "M-Codes"; the limits of arcs are those of its
# interpreter: the radii may differ by 0.1 %, or by 0.02 sqrt(2) mm; nothing below 0.00127 mm.

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
    switches=_switches("3S$ 4S$ 5$ 6T 7 8 9 62P 63P 64P 65P"),
    cycles=True,
    own_switches=range(100, 200),  # "User Defined Commands M100-M199"
    own_letters=frozenset("PQ"),
    blends=True,
    sides={"G41.1": "left", "G42.1": "right"},
    idle={
        "G43": frozenset("HZ"), "G43.1": frozenset("Z"), "G49": frozenset(), "G53": frozenset(),
        "G92.1": frozenset(), "G92.2": frozenset(),
    },
    offsets=OFFSETS | {"G59.1", "G59.2", "G59.3"},
    idle_switches=_switches("0 1 6T 48 49 50P 51P$ 52P 53P 60"),
    probes=frozenset({"G38.2", "G38.3"}),
    named=True,
    arc_fault=arc_fault,
)  # fmt: skip


# --- Mach3 ----------------------------------------------------------------------------------------

# Mach3 Mill; UCCNC runs the same programs. It probes by G31, takes any M word as a macro of its
# own, waits in seconds or in milliseconds as it is set up (`format.dwell_unit`), and rounds corners
# as far as its own settings say: G64 has no P.
# Source: Mach3 Mill, "G and M codes"; its arcs are those of RS274, as LinuxCNC's.

MACH3 = replace(
    LINUXCNC,
    name="Mach3",
    settings=frozenset({"G17", "G21", "G61", "G64", "G80", "G90", "G91.1", "G94"}),
    switches=_switches("3S 4S 5 6T 7 8 9 10P 11P"),
    cycles=False,
    own_switches=range(12, 10000),  # macros, files M<number>.m1s of the machine
    own_letters=frozenset("PQS"),
    blends=False,
    sides={},
    idle=dict.fromkeys(("G49", "G53", "G92.1", "G92.2"), frozenset()),
    offsets=OFFSETS,
    idle_switches=_switches("0 1 6T 48 49 60"),
    probes=frozenset({"G31"}),
    named=False,
)


# --- grbl -----------------------------------------------------------------------------------------

# Source: the grbl wiki, "Grbl v1.1 Commands", and its arc check: the radii may differ by 0.005 mm,
# or by 0.1 % up to 0.5 mm. Numbers are single precision, so that a sweep below 5e-7 rad would be a
# full circle. A line holds at most 79 characters.

GRBL_NEVER = 0.5  #: the other limits are those of LinuxCNC
#: Twenty times the sweep at which grbl goes full circle; a coordinate of 800 in single precision
#: is off by 3e-5, which turns a radius of 5 by as much.
MIN_SWEEP_RAD = 1e-5


def grbl_arc_fault(start: Point, end: Point, centre: Point, clockwise: bool) -> str | None:
    """grbl's deviation from an arc; None if it makes that arc."""
    near, far = dist(start, centre), dist(end, centre)
    if near < ARC_ABSOLUTE:
        return f"of radius {near:.4f}"
    off = abs(near - far)
    if off > GRBL_NEVER or (off > ARC_ABSOLUTE and off > ARC_SHARE * near):
        return f"whose radii at start and end differ by {off:.4f}"
    if start != end:
        turn = atan2(end[1] - centre[1], end[0] - centre[0])
        turn -= atan2(start[1] - centre[1], start[0] - centre[0])
        sweep = (-turn if clockwise else turn) % (2 * pi)
        if min(sweep, 2 * pi - sweep) < MIN_SWEEP_RAD:
            return f"of {sweep:.2g} rad, which may become a full circle"
    return None


GRBL = replace(
    LINUXCNC,
    name="grbl",
    percent=False,
    longest_line=79,
    settings=frozenset({"G17", "G21", "G61", "G80", "G90", "G91.1", "G94"}),
    needed=("G17", "G21", "G90", "G94"),
    switches=_switches("3S 4S 5 7 8 9"),
    cycles=False,
    own_switches=range(0),
    own_letters=frozenset(),
    blends=False,
    sides={},
    idle={"G43.1": frozenset("Z"), "G49": frozenset(), "G53": frozenset(), "G92.1": frozenset()},
    offsets=OFFSETS,
    idle_switches=_switches("0 1"),
    named=False,
    arc_fault=grbl_arc_fault,
)


#: By `controller` of the machine file.
VARIANTS = {"linuxcnc": LINUXCNC, "mach3": MACH3, "grbl": GRBL}
