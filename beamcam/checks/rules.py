"""Rules for programs, by themselves or against the parts that they should make."""

from beamcam.errors import error, note, warning

# fmt: off


LIMIT = error("verify-limit",
    "found {axis} at {found}; expected {least} to {greatest}",
    "The axis cannot go there.")
ROUND = error("verify-round",
    "found {found} of {mark}; expected it seen square from v, o, h or u of the round bar",
    "Face v of a round is its surface, unrolled. The spindles stand square to four lines of it, "
    "and the saw cuts planes that lean in the view of v.")
STOP_BACK = error("verify-stop-back",
    "found X {found} after X {before}; expected the stop never to move back",
    "The bar runs against the stop, which can only give way.")
CUT_OFF = error("verify-cut-off",
    "found {what} at X {found} in a part that the cut on line {cut} has already parted; expected "
    "it before",
    "Where the drills come first a part has no reference any more once it is cut off.")
WORK_ORDER = error("verify-order",
    "found {what} on face {face} at X {x}, y {y} {found}; expected {expected}",
    "A tap or a countersink that meets full steel breaks, and so does a mill that cannot plunge.")
TAP = error("verify-tap",
    "found a tap of pitch {pitch} fed {way} at {found} mm/min; expected {expected} mm/min, as it "
    "turns",
    "A tap moves by its pitch each turn, in and out; any other feed strips the thread or breaks "
    "the tap.")
NO_SPINDLE = error("verify-no-spindle",
    "found {found}; expected a spindle to be chosen before",
    "Y and Z are axes of the spindle that is chosen; with none they mean nothing.")
SPINDLE_OFF = error("verify-spindle-off",
    "found a feed into the material on face {face} with the spindle standing; expected it turning",
    "A drill that does not turn breaks.")
SPINDLE_ON = error("verify-spindle-on",
    "found {found} with the spindle turning; expected it off",
    "Spindles are chosen, and the bar is moved, with the drills at rest.")
COOLANT = error("verify-coolant",
    "found {found}; expected the coolant {expected}",
    "The machine's own cycle cools every stroke, and only strokes.")
RAPID = error("verify-rapid",
    "found a rapid move to {axis} {found}, {depth} mm into the material; expected a feed",
    "A rapid move into steel breaks the tool or the spindle.")
SIDEWAYS = error("verify-sideways",
    "found {found} with the tool of face {face} at {axis} {at}; expected it drawn back",
    "A drill that is still in the material breaks when the bar or the spindle moves sideways.")
CLEARANCE = error("verify-clearance",
    "found a rapid move that ends {found} mm before face {face}; expected at least {expected} mm",
    "The machine file says how much room a rapid keeps; steel is never quite where it should be.")
SPINDLE_STOPPED = error("verify-spindle-stopped",
    "found the spindle stopped with the tool of face {face} at {axis} {at}, in the material; "
    "expected it drawn back before",
    "A drill that stops in the hole is caught there, and breaks when it is drawn out.")
SPEED = error("verify-speed",
    "found a speed of {found} rpm for {what}; expected {least} to {greatest} rpm",
    "The speed is beyond the spindle's limits, or more than 1.2 times what the cutting data give.")
SPINDLE_IDLE = error("verify-spindle-idle",
    "found {what} started and stopped without a stroke; expected a feed into the material between",
    "A rapid in place of the feed goes into the steel, and a missing stroke leaves out a hole.")
TOOL_CHANGE = error("verify-tool-change",
    "found {found} on spindle {spindle}; expected {expected}",
    "The stations hold the tools that the program needs first; any other is changed manually, "
    "where the program stops for it.")
STOP_COMMENT = error("verify-stop-comment",
    "found {found}; expected {expected}",
    "The operator puts in what the comment at the stop says, and the program works on with it.")
UNSEEN = note("verify-unseen",
    "how far face {found} lies below the flanges is not in the program, so rapids towards it were "
    "not checked; give the parts by --against",
    "The program says height, width and kind of its section, but no thickness.")
UNKNOWN_STEEL = note("verify-unknown-steel",
    "the program does not name the steel, so feeds and speeds were compared with the highest that "
    "the machine has for any; give the parts by --against",
    "Only a part says its grade.")
NO_FEED = error("verify-no-feed",
    "found a {found} without a feed; expected an F word",
    "The controller's default feed is 0 or unknown; a feed still active from an earlier cut is not "
    "the drill's.")
FEED = warning("verify-feed",
    "found a feed of {found} mm/min for {what}; expected about {expected} mm/min",
    "The feed is less than half of what the machine file gives for that tool and grade.")
FEED_LIMIT = error("verify-feed-limit",
    "found a feed of {found} mm/min for {what}; expected at most {expected} mm/min",
    "More than 1.2 times what the cutting data give, or beyond the machine, breaks the tool.")
NO_OPERATION = error("verify-operation",
    "found operation {found} to begin with; expected 2 to {expected}, as `beamcam plan` counts",
    "The remainder of a program begins with one of its operations, and the first begins the whole.")
SECTION = error("verify-section",
    "found {what} {found}; expected {expected}",
    "The controller sets clamps and offsets from the section, so it has to be the part's.")
CUT_MISSING = error("verify-cut-missing",
    "found no cut of {angle} degrees at X {x} for the {end} of {mark}; expected one",
    "The part would not get that end.")
CUT_PLACE = error("verify-cut-place",
    "found the cut for the {end} of {mark} at X {found}; expected X {expected}",
    "The part would come out longer or shorter.")
CUT_ANGLE = error("verify-cut-angle",
    "found a cut of {found} degrees for the {end} of {mark}; expected {expected}",
    "The end would be skew.")
ONE_PART = error("verify-no-saw",
    "found the part {mark} beside another one; expected one part, the machine has no saw",
    "A line without a saw takes parts that are cut, one by one.")
CUT_EXTRA = error("verify-cut-extra",
    "found a cut of {angle} degrees at X {x}; expected none there",
    "It makes no part's end, so it cuts something that should stay whole, or cuts twice.")
OUTLINE = error("verify-outline",
    "found an outline on face {face} of {mark} that leaves the sawn stock at x {x}, y {y}; "
    "expected none that saw cuts do not make",
    "Saw cuts alone do not make that outline, and the program has nothing else for it.")
HOLE_MISSING = error("verify-hole-missing",
    "found no {what} on face {face} of {mark} at x {x}, y {y}; expected one at X {machine_x}",
    "A missing hole is found on the building site.")
HOLE_PLACE = error("verify-hole-place",
    "found the {what} on face {face} of {mark} at x {found_x}, y {found_y}; expected it at x {x}, "
    "y {y}",
    "The hole would lie elsewhere by more than the output's resolution.")
HOLE_EXTRA = error("verify-hole-extra",
    "found a {what} on face {face} at X {x}, y {y}; expected none there",
    "It belongs to no part, or is drilled twice.")
DEPTH = error("verify-depth",
    "found the {what} on face {face} of {mark} at x {x}, y {y} made {found} mm deep; expected "
    "{expected}",
    "The hole would be blind, too deep, or the drill would run into what lies behind.")
TOOL = error("verify-tool",
    "found {found} for the {what} on face {face} of {mark} at x {x}, y {y}; expected {expected}",
    "The tool does not make that.")
PECK = error("verify-peck",
    "found {what} fed {found} mm at once; expected at most {expected} mm, then drawn back",
    "The chips of a deep hole block the drill unless it is drawn back for them.")
TURN = error("verify-turn",
    "found a feed into the material with M{found:02}; expected M{expected:02}",
    "A tool that turns the wrong way cuts nothing and breaks.")
PATH = error("verify-path",
    "found the path of {what} of {mark} {found} mm off; expected it within {expected} mm",
    "The outline that the tool leaves would not be the part's.")
PATH_EXTRA = error("verify-path-extra",
    "found a path of a {kind} on face {face} from X {x}, y {y}; expected none there",
    "It belongs to no part, or is followed twice.")
NOT_MADE = error("verify-not-made",
    "found nothing that makes {found} of {mark}; expected it to be made, or skipped by name",
    "Nothing is left out silently.")


# --- bar rules ------------------------------------------------------------------------------------

# Rules for what a machine can hold: the bar of a program, and the parts that come off it.


PART_SHORT = error("verify-part-short",
    "found the part {mark}, {found} mm long; expected at least {expected} mm",
    "A shorter part falls between the rollers or cannot be held (`layout.min_part`).")
BAR_START = error("verify-bar-start",
    "found the part {mark} to start {found} mm behind the front of the bar; expected at least "
    "{expected} mm",
    "The front of a bar is trimmed (`layout.front_trim`), before that there is no sound steel.")
BAR_END = error("verify-bar-end",
    "found the last cut to end {found} mm from the front of the bar; expected at most {expected} "
    "mm, that is {trim} mm from its end",
    "The gripper holds the end of the bar, out of the stations' reach (`layout.dead_zone`), and "
    "what is scrap there makes no part (`layout.end_trim`).")
BAR_SIZE = error("verify-bar-size",
    "found a bar of {found} mm; expected {least} to {greatest} mm",
    "The machine cannot hold another one (`layout.min_bar`, `layout.max_bar`).")
BAR_LEFT = error("verify-bar-left",
    "found {found} mm of bar from the start of {mark} on; expected at least {expected} mm",
    "The remnant of the bar pushes its last part, so it has to reach between the rollers "
    "(`layout.min_bar_left`).")
BAR_NEEDED = note("verify-bar-needed",
    "the length of the bar is not in the program; {found} mm are needed, of which its end takes "
    "{trim} mm; whether the bar is as long was not checked, give it by --bar",
    "How much of a bar the gripper holds, the machine file says; how long the bar is, only the "
    "user.")
BAR_TOLD = error("verify-bar-told",
    "found a program that needs a bar of {found} mm; expected at most the {expected} mm of the "
    "plan",
    "The plan tells which bar to load, the read-back works out which the program needs. It is a "
    "fault of beamcam; send in the part.")
STOCK = error("verify-stock",
    "found a section of {found}; expected {expected}",
    "The machine does not hold or reach round any other (`layout.profiles`, and `max_height` and "
    "`max_width` of saw and drill).")
SAW_REACH = error("verify-saw-reach",
    "found a cut of {angle} degrees through a section of {found} mm; expected at most {expected} "
    "mm (height x width), as the blade reaches at that angle",
    "A blade that is turned reaches less far across (`saw.max_sections`).")
NO_TOOL = error("verify-no-tool",
    "found {found} chosen; expected a tool that the shop has, {expected}",
    "No station can hold it, whatever hole it would fit.")
HOLE_STEEL = error("verify-hole-steel",
    "found the {what} on face {face} of {mark} at x {x}, y {y} {found}; expected {expected}",
    "A drill that meets another wall, an edge or another hole runs off or breaks.")

# Of the programs of a job against its request and its plan.

PIECES = error("verify-pieces",
    "found {found} of {mark} in the programs of this job; expected {expected}",
    "The pieces of all bars or sheets are counted against the quantities that were asked for. It "
    "is a fault of beamcam; send in the part.")
PIECE_ORDER = error("verify-piece-order",
    "found {found} behind {before} in a program; expected the order in which they were given",
    "Pieces go onto bars and sheets in the order of the inputs. It is a fault of beamcam; send in "
    "the parts.")
STOCK_BAR = error("verify-stock-bar",
    "found a program for a bar of {found}; expected {expected}",
    "A bar that is not in store cannot be loaded. It is a fault of beamcam; send in the "
    "part.")
LEFT_OUT = warning("verify-left-out",
    "found nothing that makes the {what} of {mark}; it may be left out, and is not made",
    "The machine cannot make it and its kind is allowed to be missing, by `--allow-skips` or the "
    "head of the program. It has to be made manually or on another machine.")
LEDGER = error("verify-ledger",
    "found {found} feature(s) missing from the program; expected {expected}, as planned",
    "What is missing from a program has to be what the plan left out by name, and nothing else. It "
    "is a fault of beamcam; send in the part.")
TEXT_TOLD = error("verify-text-told",
    "found a text lettered {found}; expected it {expected}, as planned",
    "The plan reports where a text is moved or made smaller, the read-back finds it in the "
    "program, and both have to agree. It is a fault of beamcam; send in the part.")
MANUAL_WORK = warning("verify-by-hand",
    "found nothing that makes the {what} of {mark}; it is left for manual work, as {machine} says",
    "`[marks]` in the machine's file says which kinds of marks are made by the machine, and which "
    "are left for manual work.")
TEXT_MOVED = warning("verify-text-moved",
    "found the text {text!r} at x {x}, y {y}, {height} mm high; at x {wanted_x}, y {wanted_y}, "
    "{wanted_height} mm high it would not be clear",
    "A text that would stand on an edge or over a hole is moved, or made smaller.")
UNCUT = warning("verify-sheet-left",
    "found {found} mm of waste in a corner at x {x}, y {y} that the beam does not reach; it stays "
    "on the part",
    "A round beam stops before a sharp corner. Where that matters, the place is finished by "
    "hand.")
UNCUT_TOLD = error("verify-sheet-untold",
    "found {found} mm of waste in a corner at x {x}, y {y} that the beam does not reach; expected "
    "it to be reported by the plan",
    "The plan reports what stays on a part, the read-back finds it in the program, and both have "
    "to agree. It is a fault of beamcam; send in the part.")
