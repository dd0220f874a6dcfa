"""Mach3 Mill, as far as programs of cutting tables use it; UCCNC runs the same programs.

It probes by G31, takes any M word as a macro of its own, waits in seconds or in milliseconds as it
is set up (`format.dwell_unit`), and rounds corners as far as its own settings say: G64 has no P.
Source: Mach3 Mill, "G and M codes"; its arcs are those of RS274, as LinuxCNC's.
"""

from beamcam.controllers.rs274.blocks import Variant
from beamcam.controllers.rs274.linuxcnc import arc_fault

MACH3 = Variant(
    name="Mach3",
    percent=True,
    longest_line=255,
    settings=frozenset({"G17", "G21", "G61", "G64", "G80", "G90", "G91.1", "G94"}),
    needed=("G17", "G21", "G40", "G90", "G91.1", "G94"),
    switches={
        3: frozenset("S"), 4: frozenset("S"), 5: frozenset(), 6: frozenset("T"), 7: frozenset(),
        8: frozenset(), 9: frozenset(), 10: frozenset("P"), 11: frozenset("P"),
    },
    cycles=False,
    own_switches=range(12, 10000),  # macros, files M<number>.m1s of the machine
    own_letters=frozenset("PQS"),
    blends=False,
    sides={},
    idle={"G49": frozenset(), "G53": frozenset(), "G92.1": frozenset(), "G92.2": frozenset()},
    offsets=frozenset(f"G{number}" for number in range(54, 60)),
    idle_switches={
        0: frozenset(), 1: frozenset(), 6: frozenset("T"), 48: frozenset(), 49: frozenset(),
        60: frozenset(),
    },
    probes=frozenset({"G31"}),
    named=False,
    arc_fault=arc_fault,
)  # fmt: skip
