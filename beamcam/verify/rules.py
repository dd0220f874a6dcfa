"""What can be wrong with a program, by itself or against the parts that it should make."""

from beamcam.errors import Rule, Severity

_E, _W = Severity.ERROR, Severity.WARNING

SYNTAX = Rule(
    "verify-syntax",
    _E,
    "found {found!r}; expected {expected}",
    "The controller would stop at that block, or read something else than was meant.",
)
WORD = Rule(
    "verify-word",
    _E,
    "found {found}; expected {expected}",
    "What the read-back does not know it cannot vouch for, so it refuses the program.",
)
NO_END = Rule(
    "verify-end",
    _E,
    "found {found}; expected M30 once, as the last command",
    "A program that was cut off in the middle looks like a whole one up to its last line.",
)
M_QUEUE = Rule(
    "verify-m-queue",
    _E,
    "found {found} M words in a row; expected at most {expected}",
    "CODESYS runs out of its queue (SMC_DEC_OUTQUEUE_RAN_EMPTY); a G75 before resets the count.",
)
ARC = Rule(
    "verify-arc",
    _E,
    "found an arc {found}; expected {expected}",
    "CODESYS replaces an arc that does not fit together by a straight line without a word.",
)
LIMIT = Rule(
    "verify-limit",
    _E,
    "found {axis} at {found}; expected {least} to {greatest}",
    "The axis cannot go there.",
)
STOP_BACK = Rule(
    "verify-stop-back",
    _E,
    "found X {found} after X {before}; expected the stop never to move back",
    "The bar runs against the stop, which can only give way.",
)
CUT_OFF = Rule(
    "verify-cut-off",
    _E,
    "found a hole at X {found} in a part that the cut on line {cut} has already parted; expected "
    "it before",
    "Where the drills come first a part has no reference any more once it is cut off.",
)
NO_SPINDLE = Rule(
    "verify-no-spindle",
    _E,
    "found {found}; expected a spindle to be chosen before",
    "Y and Z are axes of the spindle that is chosen; with none they mean nothing.",
)
SPINDLE_OFF = Rule(
    "verify-spindle-off",
    _E,
    "found a feed into the material on face {face} with the spindle standing; expected it turning",
    "A drill that does not turn breaks.",
)
SPINDLE_ON = Rule(
    "verify-spindle-on",
    _E,
    "found {found} with the spindle turning; expected it off",
    "Spindles are chosen, and the bar is moved, with the drills at rest.",
)
COOLANT = Rule(
    "verify-coolant",
    _E,
    "found {found}; expected the coolant {expected}",
    "The machine's own cycle cools every stroke, and only strokes.",
)
RAPID = Rule(
    "verify-rapid",
    _E,
    "found a rapid move to {axis} {found}, {depth} mm into the material; expected a feed",
    "A rapid move into steel breaks the tool or the spindle.",
)
SIDEWAYS = Rule(
    "verify-sideways",
    _E,
    "found {found} with the tool of face {face} at {axis} {at}; expected it drawn back",
    "A drill that is still in the material breaks when the bar or the spindle moves sideways.",
)
NO_FEED = Rule(
    "verify-no-feed",
    _E,
    "found a {found} without a feed; expected an F word",
    "The controller's own default feed is 0, or what somebody has set there.",
)
FEED = Rule(
    "verify-feed",
    _W,
    "found a feed of {found} mm/min for {what}; expected {expected} mm/min",
    "The feed is not the one that the machine file gives for that tool and grade.",
)
FEED_LIMIT = Rule(
    "verify-feed-limit",
    _E,
    "found a feed of {found} mm/min for {what}; expected at most {expected} mm/min",
    "The station cannot feed faster.",
)
SECTION = Rule(
    "verify-section",
    _E,
    "found {what} {found}; expected {expected}",
    "The controller sets clamps and offsets from the section, so it has to be the part's.",
)
CUT_MISSING = Rule(
    "verify-cut-missing",
    _E,
    "found no cut of {angle} degrees at X {x} for the {end} of {mark}; expected one",
    "The part would not get that end.",
)
CUT_PLACE = Rule(
    "verify-cut-place",
    _E,
    "found the cut for the {end} of {mark} at X {found}; expected X {expected}",
    "The part would come out longer or shorter.",
)
CUT_ANGLE = Rule(
    "verify-cut-angle",
    _E,
    "found a cut of {found} degrees for the {end} of {mark}; expected {expected}",
    "The end would be askew.",
)
CUT_EXTRA = Rule(
    "verify-cut-extra",
    _E,
    "found a cut of {angle} degrees at X {x}; expected none there",
    "It makes no part's end, so it cuts something that should stay whole, or cuts twice.",
)
OUTLINE = Rule(
    "verify-outline",
    _E,
    "found an outline on face {face} of {mark} that leaves the sawn stock at x {x}, y {y}; "
    "expected none that saw cuts do not make",
    "Saw cuts alone do not make that outline, and the program has nothing else for it.",
)
HOLE_MISSING = Rule(
    "verify-hole-missing",
    _E,
    "found no {what} on face {face} of {mark} at x {x}, y {y}; expected one at X {machine_x}",
    "A missing hole is found on the building site.",
)
HOLE_PLACE = Rule(
    "verify-hole-place",
    _E,
    "found the {what} on face {face} of {mark} at x {found_x}, y {found_y}; "
    "expected it at x {x}, y {y}",
    "The hole would lie elsewhere by more than the output's resolution.",
)
HOLE_EXTRA = Rule(
    "verify-hole-extra",
    _E,
    "found a {what} on face {face} at X {x}, y {y}; expected none there",
    "It belongs to no part, or is drilled twice.",
)
DEPTH = Rule(
    "verify-depth",
    _E,
    "found the {what} on face {face} of {mark} at x {x}, y {y} made {found} mm deep; "
    "expected {expected}",
    "The hole would be blind, too deep, or the drill would run into what lies behind.",
)
TOOL = Rule(
    "verify-tool",
    _E,
    "found {found} for the {what} on face {face} of {mark} at x {x}, y {y}; expected {expected}",
    "The tool does not make that.",
)
TURN = Rule(
    "verify-turn",
    _E,
    "found a feed into the material with M{found:02}; expected M{expected:02}",
    "A tool that turns the wrong way cuts nothing and breaks.",
)
PATH = Rule(
    "verify-path",
    _E,
    "found the path of {what} of {mark} {found} mm off; expected it within {expected} mm",
    "The outline that the tool leaves would not be the part's.",
)
PATH_EXTRA = Rule(
    "verify-path-extra",
    _E,
    "found a path of a {kind} on face {face} from X {x}, y {y}; expected none there",
    "It belongs to no part, or is gone twice.",
)
TOOL_NEARER = Rule(
    "verify-tool-nearer",
    _W,
    "found a drill {found} for the {what} on face {face} of {mark} at x {x}, y {y}; "
    "expected {expected}, which is nearer",
    "The drill is within the fit, but the shop has a better one.",
)
NOT_MADE = Rule(
    "verify-not-made",
    _E,
    "found nothing that makes {found} of {mark}; expected it to be made, or skipped by name",
    "Nothing is left out in silence.",
)

MODBUS = Rule(
    "verify-modbus",
    _E,
    "found {found}; expected a Modbus TCP server that takes the registers",
    "The trace could not be sent; the server may be down, or its register map too small.",
)

RULES = (
    SYNTAX, WORD, NO_END, M_QUEUE, ARC, LIMIT, STOP_BACK, CUT_OFF, NO_SPINDLE, SPINDLE_OFF,
    SPINDLE_ON, COOLANT, RAPID, SIDEWAYS, NO_FEED, FEED, FEED_LIMIT, SECTION, CUT_MISSING,
    CUT_PLACE, CUT_ANGLE, CUT_EXTRA, OUTLINE, HOLE_MISSING, HOLE_PLACE, HOLE_EXTRA, DEPTH, TOOL,
    TURN, PATH, PATH_EXTRA, TOOL_NEARER, NOT_MADE, MODBUS,
)  # fmt: skip
