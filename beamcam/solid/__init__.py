"""Parts and programs as solids: a third opinion beside the planner and the read-back.

A part's solid comes from its section and its features; a piece's from the events of a program.
Coordinates are DSTV's section axes: X along the part, Y up its height from the u edge, Z across
from the h side, right-handed, in mm. A mirrored part is another solid.
"""

from beamcam.errors import error, note

# fmt: off


NO_KERNEL = error("solid-kernel",
    "found no manifold3d; expected it for solids: pip install manifold3d",
    "Solids are cut and compared by this library. It comes with beamcam; here it is missing.")
NO_SOLID = error("solid-none",
    "found {found}; expected what a solid can be made of",
    "Without the figures of the section, or with features on planes of their own, the solid of the "
    "part is not known; nor is what a torch cuts that turns on its way, that is not square to its "
    "tube, or at a speed of no row. The read-back without --solid still counts.")
NO_MACHINE = error("solid-machine",
    "found {found}; expected a saw and drilling line, a coper, or a table whose torch runs G-code",
    "What is machined as a solid is bars, profiles, tubes and plates; tables of steps and triggers "
    "are read back without --solid.")
PIECES = error("solid-pieces",
    "found {found} in what the program leaves; expected {expected}",
    "The pieces are what holds together after all cuts. A cut that is missing leaves two parts in "
    "one; a piece that was not asked for is steel wasted.")
SIZE = error("solid-size",
    "found {piece} {found} mm long; expected {expected} mm, the length of {mark}",
    "The piece is as long as its solid after all cuts. A tolerance is what the machine's decimals "
    "leave.")
MISSING = error("solid-missing",
    "found {found} mm3 of {mark} cut away from {piece}, {lumps}, the largest {largest} mm3 "
    "{where}; expected this steel, {tolerance} mm off every void",
    "A hole that is too large, too deep, in a place or on a face where the part has none, or a cut "
    "into the part.")
EXTRA = error("solid-extra",
    "found {found} mm3 left on {piece} that {mark} does not have, {lumps}, the largest {largest} "
    "mm3 {where}; expected it cut away, {tolerance} mm off every void",
    "A hole, a slot or a cut that is missing, too small or not deep enough.")
HAND = error("solid-hand",
    "found {piece} as the mirror image of {mark} ({found} mm3 differ, {other} mm3 from the part "
    "itself); expected the part, which no turn makes of it",
    "A mirrored part is another part, as a left hand is no right one.")
LEFT_OUT = note("solid-left-out",
    "found {found} mm3 {where} left on {piece}; expected so, {what} may be left out",
    "--allow-skips, the configuration or the program's head names its kind.")
ROUNDED = note("solid-rounded",
    "found {found} mm3 left in {count} re-entrant corner(s) of {mark}; expected so, the machine "
    "rounds sharp ones with {radius} mm",
    "`coper.corner_radius` of the machine's file. More steel than such a round is an error.")
SQUARE = note("solid-square",
    "found {found} mm3 left on {mark} as {what} are cut square to the wall; expected so, the torch "
    "does not tilt",
    "Wedges of bevels and of ends that are skew through a wall stand on the list of manual work. A "
    "hole of a round tube is as wide as a drill through the axis makes it outside, and narrower "
    "inside. Wedges of a tube's bevels are not computed.")
