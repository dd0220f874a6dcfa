"""What a machine cannot make of a part, or of a bar."""

from beamcam.errors import Rule, Severity
from beamcam.planning.operations.rules import FINISHED_PART

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
    "found a part of profile code {found}; expected {expected}, which {machine} takes",
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
    "found a section of {found} mm; expected at most {expected} mm (height x width), which the "
    "{station} takes",
    "A larger section does not pass the station.",
)
SAW_ANGLE = Rule(
    "plan-saw-angle",
    _E,
    "found a cut of {found} degrees at the {end}; expected one from {least} to {greatest}, "
    "as far as the saw turns",
    "The mitre is outside the saw's range.",
)
FLANGE_CUT = Rule(
    "plan-flange-cut",
    _E,
    "found a flange cut of {found} degrees at the {end}; expected {expected}",
    "The blade does not tilt, or it tilts one way only; a part that is turned may need that way.",
)
COMPOUND = Rule(
    "plan-compound",
    _E,
    "found a cut of {web} degrees on the web and {flange} on the flange at the {end}; "
    "expected one of them, the saw cannot turn and tilt at once",
    "A compound mitre needs a saw whose blade tilts while the saw is turned.",
)
CUT_DENIED = Rule(
    "plan-cut-denied",
    _E,
    "found a {kind} cut of {found} degrees at the {end}; expected {expected}, "
    "which the contour has",
    "Header and contour describe different ends, and only one can be right.",
)
CUT_FROM_CONTOUR = Rule(
    "plan-cut-from-contour",
    _W,
    "found no {kind} cut in the header at the {end}; the contour's {found} degrees are sawn",
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
    "found parts, kerfs, trims and dead zone of {found} mm; expected at most the bar's "
    "{expected} mm",
    "The parts do not fit on the bar. `--order best` nests mitres, where they can be.",
)
PART_SHORT = Rule(
    "plan-part-short",
    _E,
    "found a part of {found} mm; expected at least {expected} mm",
    "A shorter part falls between the rollers or cannot be held.",
)
REMNANT = Rule(
    "plan-remnant",
    _N,
    "a rest of {found} mm is long enough to go back to the store",
    "The machine's file says from which length a rest is a remnant (`layout.min_remnant`).",
)
NO_TOOL = Rule(
    "plan-tool",
    _E,
    "found a {kind} hole of diameter {found} on face {face}; expected {expected}",
    "No tool of the machine makes the hole within the tolerance of its file.",
)
NO_PILOT = Rule(
    "plan-countersink",
    _E,
    "found a countersink of diameter {found} on face {face} at x {x}, y {y}; "
    "expected a hole to sink at that place",
    "DSTV gives a countersunk hole in two rows, the sink and the hole; one of them is missing.",
)
SINK_DEPTH = Rule(
    "plan-sink-depth",
    _E,
    "found a countersink of diameter {found} and depth {depth} on face {face}; "
    "expected a depth of at least {expected} for that cone and hole",
    "Diameter, depth, cone and hole contradict each other, and only three of them can be right.",
)
THREAD_DEPTH = Rule(
    "plan-thread-depth",
    _E,
    "found a thread of depth {found} on face {face}; "
    "expected at most {expected}, the tapping drill would come through",
    "The drill before a blind tap goes deeper than the thread by the tap's run-out.",
)
DUPLICATE = Rule(
    "plan-duplicate",
    _W,
    "found a hole of diameter {found} on face {face} at x {x}, y {y} a second time; "
    "it is drilled once, for {first}",
    "Some exporters write a hole of two bolted plates, or of both sides of a web, twice.",
)
TOO_NEAR = Rule(
    "plan-too-near",
    _E,
    "found a hole of diameter {found} on face {face} at x {x}, y {y}, {apart} mm from that of "
    "{first}; expected the same place, or one more than {expected} mm away",
    "Holes nearer than the program's decimals tell apart are one hole that was drawn twice, not "
    "quite at the same place.",
)
NO_SPINDLE = Rule(
    "plan-face",
    _E,
    "found a {kind} on face {found}; expected one of {expected}",
    "No spindle of the machine reaches that face.",
)
IN_THE_WAY = Rule(
    "plan-reach",
    _E,
    "found {what} at y {y} on face {face}; expected y from {least} to {greatest}, the flange "
    "stands in the tool's way",
    "A tool that comes to the web between the flanges needs room beside them.",
)
STROKE = Rule(
    "plan-stroke",
    _E,
    "found a stroke to {found} mm below face {face}, the same for every hole; "
    "expected {expected} mm for {what}",
    "A stroke that is the same for every hole fits no blind hole, and through ones of small "
    "sections alone. A machine file whose `bottom` follows `depth` has no such limit.",
)
AXIS = Rule(
    "plan-axis",
    _E,
    "found {what} on face {face} that takes the {axis} to {found}; expected {expected}",
    "The axis does not come to that place across the bar, or as deep. `--allow-skips axis` leaves "
    "the feature to another machine.",
)
STOP = Rule(
    "plan-stop",
    _E,
    "found {what} that takes the {axis} to {found}; expected {expected}",
    "Where a part lies on the bar says where the bar has to be brought to; with a longer "
    "front trim, another order or a shorter bar it may be within reach.",
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
    "found a slot of {found} mm on face {face}; expected {expected}",
    "A drill cannot make a slot, and a mill none narrower than itself. "
    "`--allow-skips slot` leaves it to another machine.",
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
    "found {found} to mark on face {face}; expected none, the machine has no {tool} for it",
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
TURNED = Rule(
    "plan-turned",
    _N,
    "the part is {found}: {reason}",
    "A part may be laid on the rollers in eight ways; `--turn` takes the one that costs least.",
)
TURN_HELPS = Rule(
    "plan-turn-helps",
    _N,
    "the machine can make the part {found}; allow it by --turn",
    "The way that the part lies is what the machine cannot do, and not the part itself.",
)
ORDER = Rule(
    "plan-order",
    _N,
    "the parts lie in the order {found}: {reason}",
    "`--order best` puts parts side by side that share a cut, so that less of the bar is lost.",
)
RELOAD = Rule(
    "plan-reload",
    _W,
    "found {found} tools for the {stations} stations of spindle {spindle}; "
    "{changes} must be changed by hand during the work",
    "The bar needs more tools than the spindle holds at once; `beamcam plan` lists the changes.",
)
UNNAMED_GRADE = Rule(
    "plan-grade",
    _N,
    "found steel grade {found}, which no row of drill.cutting in {machine} names; "
    "its rows for any grade are used",
    "Speed and feed follow from the machine's cutting data. Give the grade a row there if its "
    "drills should run otherwise.",
)
CUTTING_SPEED = Rule(
    "plan-cutting-speed",
    _W,
    "found {tool} in {grade}, which should turn at {expected} rpm; the spindle turns at {found} "
    "rpm at least",
    "The drill's edge runs faster than its data allow. Harder steel wears it out, so that a larger "
    "hole may be better made elsewhere.",
)
NO_CHANGE_WORD = Rule(
    "plan-change-word",
    _E,
    "found {found} tools for the {stations} stations of spindle {spindle}; expected at most "
    "{stations}, as words.change of {machine} is empty",
    "The program has to stop where a tool is changed by hand. Give the machine file the word that "
    'does so, such as `change = ["M00"]` under `[words]`, or split the parts over several bars.',
)

RULES = (
    NO_PARTS, STOCK, MIXED_PROFILES, SECTION_SIZE, SAW_ANGLE, FLANGE_CUT, COMPOUND, CUT_DENIED,
    CUT_FROM_CONTOUR, BAR_SHORT, BAR_LONG, BAR_FULL, PART_SHORT, REMNANT, NO_TOOL, NO_PILOT,
    SINK_DEPTH, THREAD_DEPTH, DUPLICATE, TOO_NEAR, NO_SPINDLE, IN_THE_WAY, STROKE, AXIS, STOP,
    OFF_FACE, SLOT, COPE, CUTOUT, MARK, BEVEL, OTHER, QUANTITY, TURNED, TURN_HELPS, ORDER, RELOAD,
    *FINISHED_PART, UNNAMED_GRADE, CUTTING_SPEED, NO_CHANGE_WORD,
)  # fmt: skip

SKIPPABLE = (
    NO_TOOL, NO_PILOT, SINK_DEPTH, THREAD_DEPTH, NO_SPINDLE, IN_THE_WAY, STROKE, AXIS, OFF_FACE,
    SLOT, COPE, CUTOUT, MARK, BEVEL, OTHER,
)  # fmt: skip
SKIP_NAMES = tuple(rule.code.removeprefix("plan-") for rule in SKIPPABLE)
