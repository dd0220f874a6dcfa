"""Rules for a bar as a whole, and those shared by bars and sheets.

What one kind of work alone refuses stands in its file under `operations/`.
"""

from collections.abc import Iterable

from beamcam.errors import Diagnostic, error, errors_in, note, warning

# fmt: off


NO_PARTS = error("plan-no-parts",
    "found no part; expected at least one",
    "A bar needs something to be made from it.")
STOCK = error("plan-stock",
    "found a part of profile code {found}; expected {expected}, which {machine} takes",
    "The line clamps, saws and drills only the sections that its file names.")
UNROLLED = error("plan-unrolled",
    "found the profile {found}, a pipe written as a plate; expected {expected}",
    "Some programs unroll a pipe and write it as a plate. Cut flat it is no pipe: its sheet has to "
    "be rolled and welded, or the pipe cut on a machine for tubes.")
MIXED_PROFILES = error("plan-mixed-profiles",
    "found profile {found}; expected {expected}, as the first part on the bar",
    "Parts that share a bar share its section.")
SECTION_SIZE = error("plan-section",
    "found a section of {found} mm; expected at most {expected} mm (height x width), which the "
    "{station} takes",
    "A larger section does not pass the station.")
SECTION_SHAPE = error("plan-section-shape",
    "found {found} in a section of profile code {code}; expected walls that fit into each other",
    "No such section can be rolled, and where its walls stand is not known.")
CUT_DENIED = error("plan-cut-denied",
    "found a {kind} cut of {found} degrees at the {end}; expected {expected}, which the contour "
    "has",
    "Header and contour describe different ends, and only one can be right.")
CUT_FROM_CONTOUR = warning("plan-cut-from-contour",
    "found no {kind} cut in the header at the {end}; the contour's {found} degrees are sawn",
    "Some exporters leave the header's angle at 0 though the contour is skew.")
CUT_NOISE = note("plan-cut-noise",
    "found a {kind} cut of {found} degrees at the {end}; below {expected} degrees an end is sawn "
    "square",
    "Some exporters write rounding errors as angles. `saw.min_mitre` of the machine file says from "
    "which angle on a cut is meant.")
BAR_SHORT = error("plan-bar-short",
    "found a bar of {found} mm; expected at least {expected} mm, give --bar if the stock is longer",
    "The stop needs a bar of that length to hold it.")
BAR_LONG = error("plan-bar-long",
    "found a bar of {found} mm; expected at most {expected} mm",
    "The rollers or the stop do not reach further.")
NO_SAW = error("plan-no-saw",
    "found {found} parts for one bar; expected one, {machine} has no saw and takes parts that are "
    "cut",
    "Without a saw nothing parts them. Post them one by one.")
NO_WORK = error("plan-no-work",
    "found no work on the part; expected a hole or another feature, {machine} has no saw",
    "A line without a saw has nothing to do on it.")
COMES_CUT = note("plan-comes-cut",
    "the part is expected cut to {found} mm with finished ends; {machine} has no saw",
    "Neither the program nor its read-back checks the part's length and ends.")
BAR_FULL = error("plan-bar-full",
    "found parts, kerfs, trims and dead zone of {found} mm; expected at most the bar's {expected} "
    "mm",
    "The parts do not fit on the bar. `--order best` nests mitres, where they can be.")
BAR_LEFT = error("plan-bar-left",
    "found {found} mm of bar from the last part on; expected at least {expected} mm, give a longer "
    "--bar or another order of parts",
    "The remnant of the bar pushes its last part, so it has to reach between the rollers "
    "(`layout.min_bar_left`).")
PART_SHORT = error("plan-part-short",
    "found a part of {found} mm; expected at least {expected} mm",
    "A shorter part falls between the rollers or cannot be held.")
REMNANT_OF = error("batch-remnant",
    "found the remnant {found}; expected {expected}",
    "The parts are of several sections or grades, and a remnant is of one of them.")
REMNANT = note("plan-remnant",
    "a remnant of {found} mm is long enough to go back to stock",
    "The machine file says from which length on a remnant is kept (`layout.min_remnant`).")
QUANTITY = warning("plan-quantity",
    "found a quantity of {found}; this program makes {made}, --quantity file makes all",
    "Without --quantity a part is laid on the bar as often as its file is named, whatever quantity "
    "it states. --quantity 1 says that one is meant.")
TURNED = note("plan-turned",
    "the part is {found}: {reason}",
    "A part may lie on the rollers in eight orientations; `--turn` takes the one that costs least.")
TURN_HELPS = note("plan-turn-helps",
    "the machine can make the part {found}; allow it by --turn",
    "The machine can make the part, but not in this orientation.")
ORDER = note("plan-order",
    "the parts lie in the order {found}: {reason}",
    "`--order best` puts parts side by side that share a cut, so that less of the bar is lost.")
MANUAL_CHANGE = warning("plan-reload",
    "found {found} tools for the {stations} stations of spindle {spindle}; {changes} must be "
    "changed manually during the work",
    "The bar needs more tools than the spindle holds at once; `beamcam plan` lists the changes.")
UNNAMED_GRADE = note("plan-grade",
    "found steel grade {found}, which no row of drill.cutting in {machine} names; its rows for any "
    "grade are used",
    "Speed and feed follow from the machine's cutting data. Give the grade a row there if its "
    "drills should run otherwise.")
CUTTING_SPEED = warning("plan-cutting-speed",
    "found {tool} in {grade}, which should turn at {expected} rpm; the spindle turns at {found} "
    "rpm at least",
    "The drill's edge runs faster than its data allow. Harder steel wears it out, so that a larger "
    "hole may be better made elsewhere.")
NO_CHANGE_WORD = error("plan-change-word",
    "found {found} tools for the {stations} stations of spindle {spindle}; expected at most "
    "{stations}, as words.change of {machine} is empty",
    "The program has to stop where a tool is changed manually. Give the machine file the word that "
    'does so, such as `change = ["M00"]` under `[words]`, or split the parts over several bars.')

# What neither a line nor a table makes of a feature.

NO_TOOL = error("plan-tool",
    "found a {kind} hole of diameter {found} on face {face}; expected {expected}",
    "No tool of the machine makes the hole within the tolerance of its file.")
NO_SPINDLE = error("plan-face",
    "found a {kind} on face {found}; expected {expected}",
    "No spindle of the machine reaches that face.")
SLOT = error("plan-slot",
    "found a slot of {found} mm on face {face}; expected {expected}",
    "A drill cannot make a slot, and a mill none narrower than itself. `--allow-skips slot` leaves "
    "it to another machine.")
MARK = error("plan-mark",
    "found {found} to mark on face {face}; expected none, {why}",
    "Points and lines locate other parts. `--allow-skips mark` leaves them out; with `[marks]` of "
    'the machine file as `points = "list"` or `contours = "list"` they go on the list of manual '
    "work.")
BEVEL = error("plan-bevel",
    "found a bevel of {found} degrees on face {face}; expected none but those of the saw cuts",
    "A weld preparation needs a torch. `--allow-skips bevel` leaves it to another machine.")
BEVEL_NOISE = note("plan-bevel-noise",
    "found {count} bevel(s) of at most {found} degrees; below {expected} degrees an edge is cut "
    "square",
    "Some exporters write rounding errors as angles. `torch.min_bevel` and `saw.min_mitre` of the "
    "machine file say from which angle on a bevel is meant.")
DRILL_SIZE = note("plan-drill-size",
    "holes of diameter {found} are drilled with {size}, {off} mm {way}",
    "The shop has no drill of that diameter; `drill.fits` of the machine file says how far over "
    "and under a drill may be, `drill.never_under` that none may be smaller.")
OTHER = error("plan-other",
    "found {found}; expected none, the machine does not bend, camber or cut in space",
    "`--allow-skips other` leaves it to another machine.")


def no_unit(tool: str) -> str:
    """Why a machine marks nothing."""
    return f"the machine has no {tool} for it"


def is_too_short(diagnostics: Iterable[Diagnostic]) -> bool:
    """Whether a longer bar is all that would help."""
    return {d.code for d in errors_in(diagnostics)} <= {
        BAR_FULL.code, BAR_SHORT.code, BAR_LEFT.code,
    }  # fmt: skip
