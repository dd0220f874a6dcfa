"""Waste of sheets that no beam reaches, and that stays on the part."""

from beamcam.errors import Rule, Severity

UNCUT = Rule(
    "verify-sheet-left",
    Severity.WARNING,
    "found {found} mm of waste in a corner at x {x}, y {y} that the beam does not reach; it stays "
    "on the part",
    "A round beam stops before a sharp corner. Where that matters, the place is finished by hand.",
)
UNCUT_TOLD = Rule(
    "verify-sheet-untold",
    Severity.ERROR,
    "found {found} mm of waste in a corner at x {x}, y {y} that the beam does not reach; expected "
    "it to be reported by the plan",
    "The plan reports what stays on a part, the read-back finds it in the program, and both have "
    "to agree. It is a fault of beamcam; send in the part.",
)
RULES = (UNCUT, UNCUT_TOLD)
