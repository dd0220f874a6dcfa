"""What a machine cannot make of a part, or of a bar."""

from beamcam.errors import Rule, Severity

_E, _W, _N = Severity.ERROR, Severity.WARNING, Severity.NOTE

NO_PARTS = Rule(
    "plan-no-parts",
    _E,
    "found no part; expected at least one",
    "A bar needs something to be made from it.",
)
STOCK = Rule(
    "plan-stock",
    _E,
    "found a part of profile code {found}; {machine} takes {expected}",
    "The line clamps, saws and drills only the sections that its file names.",
)
MIXED_PROFILES = Rule(
    "plan-mixed-profiles",
    _E,
    "found profile {found}; expected {expected}, as the first part on the bar",
    "Parts that share a bar share its section.",
)
SECTION_SIZE = Rule(
    "plan-section",
    _E,
    "found a section of {found} mm; the {station} takes at most {expected} mm (height x width)",
    "A larger section does not pass the station.",
)
SAW_ANGLE = Rule(
    "plan-saw-angle",
    _E,
    "found a cut of {found} degrees at the {end}; the saw turns from {least} to {greatest}",
    "The mitre is outside the saw's range.",
)
FLANGE_CUT = Rule(
    "plan-flange-cut",
    _E,
    "found a flange cut of {found} degrees at the {end}; expected 0, the blade does not tilt",
    "The saw turns about one axis only, across the web.",
)
CUT_DENIED = Rule(
    "plan-cut-denied",
    _E,
    "found a web cut of {found} degrees at the {end} where the contour has {expected}",
    "Header and contour describe different ends, and only one can be right.",
)
CUT_FROM_CONTOUR = Rule(
    "plan-cut-from-contour",
    _W,
    "found no web cut in the header at the {end}; the contour's {found} degrees are sawn",
    "Some exporters leave the header's angle at 0 though the contour is skew.",
)
BAR_SHORT = Rule(
    "plan-bar-short",
    _E,
    "found a bar of {found} mm; expected at least {expected} mm, give --bar if the stock is longer",
    "The stop needs a bar of that length to hold it.",
)
BAR_LONG = Rule(
    "plan-bar-long",
    _E,
    "found a bar of {found} mm; expected at most {expected} mm",
    "The rollers or the stop do not reach further.",
)
BAR_FULL = Rule(
    "plan-bar-full",
    _E,
    "found parts, kerfs and trim of {found} mm; expected at most the bar's {expected} mm",
    "The parts do not fit on the bar.",
)
NO_TOOL = Rule(
    "plan-tool",
    _E,
    "found a {kind} hole of diameter {found} on face {face}; expected {expected}",
    "No tool of the machine makes the hole within the tolerance of its file.",
)
NO_SPINDLE = Rule(
    "plan-face",
    _E,
    "found a {kind} on face {found}; expected one of {expected}",
    "No spindle of the machine reaches that face.",
)
OFF_FACE = Rule(
    "plan-off-face",
    _E,
    "found a hole at x {x}, y {y} on face {face}; expected it within {length} x {width} mm",
    "A hole beyond its face is a slip of the export and would drill into nothing.",
)
SLOT = Rule(
    "plan-slot",
    _E,
    "found a slot of {found} mm on face {face}; expected no slot, the machine has no mill",
    "A drill cannot make a slot. `--allow-skips slot` leaves it to another machine.",
)
COPE = Rule(
    "plan-cope",
    _E,
    "found a contour on face {face} that leaves the straight stock at x {x}, y {y}; "
    "expected straight edges and saw cuts",
    "A saw cannot make a cope or a notch. `--allow-skips cope` leaves it to another machine.",
)
CUTOUT = Rule(
    "plan-cutout",
    _E,
    "found a cut-out of {found} mm on face {face}; expected none, the machine has no torch",
    "A drill cannot make a cut-out. `--allow-skips cutout` leaves it to another machine.",
)
MARK = Rule(
    "plan-mark",
    _E,
    "found {found} to mark on face {face}; expected none, the machine has no marking tool",
    "`--allow-skips mark` leaves marks and scribe lines to another machine.",
)
BEVEL = Rule(
    "plan-bevel",
    _E,
    "found a bevel of {found} degrees on face {face}; expected none but those of the saw cuts",
    "A weld preparation needs a torch. `--allow-skips bevel` leaves it to another machine.",
)
OTHER = Rule(
    "plan-other",
    _E,
    "found {found}; expected none, the machine does not bend, camber or cut in space",
    "`--allow-skips other` leaves it to another machine.",
)
QUANTITY = Rule(
    "plan-quantity",
    _N,
    "found a quantity of {found}; this program makes {made}",
    "A part is laid on the bar as often as its file is named, whatever quantity it states.",
)

RULES = (
    NO_PARTS, STOCK, MIXED_PROFILES, SECTION_SIZE, SAW_ANGLE, FLANGE_CUT, CUT_DENIED,
    CUT_FROM_CONTOUR, BAR_SHORT, BAR_LONG, BAR_FULL, NO_TOOL, NO_SPINDLE, OFF_FACE, SLOT, COPE,
    CUTOUT, MARK, BEVEL, OTHER, QUANTITY,
)  # fmt: skip

SKIPPABLE = (NO_TOOL, NO_SPINDLE, OFF_FACE, SLOT, COPE, CUTOUT, MARK, BEVEL, OTHER)
SKIP_NAMES = tuple(rule.code.removeprefix("plan-") for rule in SKIPPABLE)
