"""Rules for sheets on a cutting table."""

from beamcam.errors import Rule, Severity

_E, _W, _N = Severity.ERROR, Severity.WARNING, Severity.NOTE

SHEETS = Rule(
    "plan-sheet-parts",
    _E,
    "found {found} parts; expected one for a sheet, or several",
    "A sheet without a part has nothing to cut.",
)
MIXED = Rule(
    "plan-sheet-mixed",
    _E,
    "found a part of {found}; expected {expected}, as the first part on the sheet",
    "Parts that share a sheet share its thickness and its material.",
)
SHEET_FULL = Rule(
    "plan-sheet-full",
    _E,
    "found {found} parts, of which {fits} fit on a sheet of {size} mm; expected all of them; "
    "give a larger --sheet, or let `post` take several sheets",
    "Parts lie in rows by their boxes, in the order given, with torch.spacing between them and "
    "torch.margin to the edges.",
)
UNROLLED = Rule(
    "plan-unrolled",
    _E,
    "found the profile {found}, a pipe written as a plate; expected a plate, or --unrolled, which "
    "cuts the development flat",
    "Some programs unroll a pipe and write it as a plate. Cut flat it is no pipe: its sheet has to "
    "be rolled and welded, or the pipe cut on another machine.",
)
QUANTITY = Rule(
    "plan-sheet-quantity",
    _W,
    "found a quantity of {found}; this program makes {made}, --quantity file makes all",
    "Without --quantity a part is laid on a sheet as often as its file is named, whatever quantity "
    "it states. --quantity 1 says that one is meant.",
)
TORCH_HEIGHT = Rule(
    "plan-torch-height",
    _E,
    "found no {key} to {process} up to {up_to} mm; expected one in the row, as {axis} lifts the "
    "torch",
    "0 stands for a height that is not known. The torch would touch the sheet.",
)
HEADROOM = Rule(
    "plan-torch-headroom",
    _E,
    "found a sheet of {found} mm; expected at most {expected} mm, which the torch passes by "
    "triggers.z.clearance below its home",
    "X and Y move at the clearance over the sheet, and homing ends above it.",
)
NOTHING = Rule(
    "plan-sheet-empty",
    _E,
    "found nothing to cut or mark, {found}; expected at least one line",
    "Filled shapes without a stroke, hidden layers and colours that are mapped to ignore are not "
    "cut.",
)
UNMAPPED = Rule(
    "plan-unmapped",
    _E,
    "found {count} curves {found}, which stand for no process; expected one of {expected}, "
    "or --map {key}=cut",
    "What a colour or a layer means is said in the machine's file or on the command line, "
    "and never guessed.",
)
MAP = Rule(
    "plan-map",
    _E,
    "found {found!r}; expected a colour or a layer, =, and one of cut, mark, engrave, ignore",
    "The option --map says what is done with the lines of a colour or a layer.",
)
OPTION = Rule(
    "plan-sheet-option",
    _E,
    "found an option that the machine cannot follow: {found}; expected one that it can",
    "Colours, kerfs, leads and bridges belong to machines that cut sheets.",
)
LOOK_SETTING = Rule(
    "plan-map-setting",
    _E,
    "found {key} = {found}; expected none, {why}",
    "The machine would run at another power than the one that is asked for.",
)
LOOK_OVERCUT = Rule(
    "plan-map-overcut",
    _E,
    "found map.{key}.overcut of lines to {found}; expected it of what is cut",
    "An overcut severs what a cut leaves where it closes; a mark would be darker there.",
)
LOOK_ORDER = Rule(
    "plan-map-order",
    _E,
    "found order {found} of {key!r}, which would {process} it after the cut of {other}, of "
    "order {expected}; expected marks before cuts, and what lies in a contour before it; give the "
    "later one a higher map.KEY.order",
    "Once a part is cut free it may tilt, and nothing on it comes out right any more.",
)
LAYOUT = Rule(
    "plan-sheet-layout",
    _E,
    "found {found}; expected only holes, slots and contours where sheet.mirror, sheet.rotate or "
    "sheet.copies is asked for",
    "What cannot be turned or mirrored with its part would come to lie elsewhere.",
)
TURNED = Rule(
    "plan-sheet-turned",
    _N,
    "found a part of {found} mm, larger as it is drawn than the sheet of {expected} mm; turned it "
    "by 90 degrees",
    "It lies on the table so that it fits. `sheet.rotate` says how a part lies, `sheet.place` "
    "leaves it where it is drawn.",
)
APART = Rule(
    "plan-sheet-apart",
    _N,
    "found parts that share edges; moved {count} of them apart by the kerf of {kerf} mm",
    "One cut goes between two parts and takes nothing of either: they lie a kerf farther from one "
    "another than they are drawn. `sheet.common_cuts` asks for it.",
)
HATCH = Rule(
    "plan-map-hatch",
    _E,
    "found {found} to fill by map.{key}.hatch; expected closed contours to mark or engrave",
    "A hatch fills what closed contours enclose; loose lines have no inside.",
)
NO_PROCESS = Rule(
    "plan-process",
    _E,
    "found {count} curves to {found}; expected only what {machine} does: {expected}",
    "The machine's file has no row for that process.",
)
NO_THICKNESS = Rule(
    "plan-thickness-unknown",
    _E,
    "found no thickness of the sheet; expected one, give it by --thickness",
    "Speed, power and kerf follow from the thickness, and a drawing does not say it.",
)
THICKNESS = Rule(
    "plan-thickness",
    _E,
    "found a sheet of {found} mm {material} to {process}; expected {expected}; {others}",
    "The machine's file has no speed for that thickness of that material. A row of your own cut "
    "chart under `[[torch.more_rows]]` in a machine file of your own adds one.",
)
OTHER_THICKNESS = Rule(
    "plan-thickness-other",
    _E,
    "found --thickness {found}; expected {expected}, as the part itself says",
    "Only a drawing does not say how thick its sheet is; one of the two is wrong.",
)
OTHER_MATERIAL = Rule(
    "plan-material-other",
    _E,
    "found --material {found}; expected {expected}, as the part itself says",
    "Speed, power and kerf follow from the material; one of the two is wrong. A part without a "
    "grade takes the option.",
)
ASSUMED = Rule(
    "plan-thickness-assumed",
    _N,
    "found no thickness in the drawing; the sheet is {found} mm {material}, by the options or the "
    "machine's file",
    "--thickness and --material say it, and where they do not, the machine's file.",
)
SHEET_SIZE = Rule(
    "plan-sheet-size",
    _E,
    "found a sheet of {found} mm; expected at most {expected} mm, the work area of the table",
    "The part with its leads has to lie within the work area.",
)
SHEET_PLACE = Rule(
    "plan-sheet-place",
    _E,
    "found work from x {x0}, y {y0} to x {x1}, y {y1}; expected it between 0, 0 and {length}, "
    "{width}",
    "The part is left where it is drawn, or its leads reach over the corner: --place corner moves "
    "it, and the machine's margin leaves room for leads.",
)
JUNCTION = Rule(
    "plan-junction",
    _W,
    "found {found} curves that meet at x {x}, y {y}, with {other}; expected two, the contour stops "
    "there",
    "Where three curves meet, the contour has no unique continuation and stays open.",
)
BRANCHED = Rule(
    "plan-junction-kerf",
    _E,
    "found {found} curves that meet at x {x}, y {y}, with {other}; expected two with kerf "
    "compensation of {kerf} mm, or --kerf-by none, which cuts them on their lines",
    "Where contours share curves nothing says on which side of them the part lies: both parts "
    "would come out half a kerf too small.",
)
NOT_CLOSED = Rule(
    "plan-not-closed",
    _E,
    "found a contour that is declared closed, and goes from x {x0}, y {y0} to x {x1}, y {y1}; "
    "expected its curves to meet there, not {found} mm apart",
    "The part is damaged: nothing says where to cut between its curves.",
)
TINY = Rule(
    "plan-tiny",
    _W,
    "found {count} curves no larger than {expected} mm; they are left out",
    "Two ends that close are one point to the machine (`torch.gap`), so the tool would be started "
    "and not moved.",
)
SHARED = Rule(
    "plan-shared-edge",
    _E,
    "found a contour that lies on {other} for {found} mm near x {x}, y {y}; expected them apart by "
    "the kerf of {kerf} mm, or --kerf-by none, which cuts the edge once",
    "One cut takes its kerf from both parts, or from one of them the whole of it.",
)
COMMON = Rule(
    "plan-common-edge",
    _N,
    "{count} contours share edges with others, {found} mm of them; each edge is cut once",
    "Without kerf compensation two parts can share a cut.",
)
RUNS_BACK_KERF = Rule(
    "plan-doubles-back-kerf",
    _E,
    "found a curve that turns round at x {x}, y {y} and runs back along itself for {found} mm; "
    "expected one that does not, or --kerf-by none, which follows it as it is drawn",
    "There is no waste on either side of such a stretch, so that the kerf cannot be compensated.",
)
RUNS_BACK = Rule(
    "plan-doubles-back",
    _W,
    "found a curve that turns round at x {x}, y {y} and runs back along itself for {found} mm; it "
    "is followed as it is drawn",
    "The tool may pass that stretch twice, which burns or widens it.",
)
RUNS_OVER = Rule(
    "plan-runs-over-itself",
    _E,
    "found a curve that runs over itself from x {x}, y {y} on, for {found} mm; expected one that "
    "passes each place once",
    "The torch would burn one place over and over, as where a formula goes round more than once. "
    "Passes one over the other are asked for by `passes` of the machine file or the map.",
)
GAP = Rule(
    "plan-gap",
    _W,
    "found a gap of {found} mm at x {x}, y {y}; expected at most {expected} mm in a contour, or a "
    "larger torch.gap in the machine file",
    "The contour stays open there, so that the part may not fall out.",
)
OPEN_CUT = Rule(
    "plan-open-cut",
    _W,
    "found an open contour to cut from x {x0}, y {y0} to x {x1}, y {y1}, {apart} mm apart; it is "
    "cut on its line, without regard to the kerf",
    "An open line has no side that the part lies on. Ends at most `torch.gap` of the machine file "
    "apart are joined.",
)
OPEN_KERF = Rule(
    "plan-open-kerf",
    _E,
    "found an open contour to cut from x {x0}, y {y0} to x {x1}, y {y1}, {apart} mm apart; "
    "expected it closed, as a kerf of {kerf} mm is compensated; {how}",
    "An open line has no side that the part lies on, and what it seems to enclose would be cut on "
    "the wrong one.",
)
GAPS = Rule(
    "plan-gaps-closed",
    _N,
    "closed {count} gaps between ends of curves, the widest {found} mm at x {x}, y {y}",
    "Ends at most `torch.gap` or --gap apart are joined by moving them, or by a line.",
)
MORE_OPEN = Rule(
    "plan-open-cuts",
    _W,
    "found {found} more open contours to cut; they are cut on their lines",
    "Only the first ten are named one by one.",
)
OVERLAP = Rule(
    "plan-overlap",
    _W,
    "found {count} curves that lie on others, {found} mm of them; they are cut once",
    "Exports of bolted or mirrored parts draw the same line twice.",
)
VANISHED = Rule(
    "plan-kerf",
    _E,
    "found a contour of {found} mm without room for a kerf of {kerf} mm; expected a wider one",
    "The cut would take away what it should leave, or close up.",
)
NARROW = Rule(
    "plan-narrow",
    _E,
    "found a place {found} mm wide at x {x}, y {y}{more}, {depth} mm of it out of reach; expected "
    "at least the kerf of {kerf} mm, or a smaller --kerf, or --kerf-by none",
    "The beam does not get into a slot or through a neck narrower than itself, and what is waste "
    "there would stay on the part.",
)
NEAR = Rule(
    "plan-near",
    _E,
    "found {found} mm of waste between the contour and {other} at x {x}, y {y}; expected at least "
    "the kerf of {kerf} mm, or a smaller --kerf, or --kerf-by none",
    "The cut along one contour would enter the part at the other. Parts just a kerf apart share a "
    "cut.",
)
LEFT = Rule(
    "plan-left-in-corner",
    _W,
    "the round beam leaves {depth} mm in a corner or a slot {found} mm wide at x {x}, y {y}{more}",
    "A round beam reaches no farther; where that matters, finish the place manually.",
)
CROWDED = Rule(
    "plan-crowded",
    _E,
    "found curves that pass the {reach} mm around x {x}, y {y} {found} times; expected at most "
    "{expected} passes of one place on an average",
    "The torch would burn one place over and over. Copies that are equal or lie on one another "
    "are cut once; these differ a little, or one curve runs to and fro.",
)
COPIES = Rule(
    "plan-copies",
    _E,
    "found one curve {found} times, and {copies} copies of curves in all; expected a drawing "
    "without so many copies that are equal in every number",
    "A few copies are cut once. Of thousands each is compared with each: delete them in the "
    "drawing.",
)
CROSSING = Rule(
    "plan-crossing",
    _E,
    "found a cut contour that crosses {other} near x {x}, y {y}; expected contours that do not "
    "cross, or --kerf-by none, which cuts them on their lines",
    "Its inside is not defined, and so neither is the side of the kerf nor what falls out.",
)
MORE_CROSSINGS = Rule(
    "plan-crossings",
    _E,
    "found {found} more places where cut contours cross; expected none",
    "Only the first twenty are named one by one.",
)
CROSSED = Rule(
    "plan-crossing-on-line",
    _W,
    "found a cut contour that crosses {other} near x {x}, y {y}; both are cut on their lines",
    "What falls out of contours that cross is in more pieces than are drawn.",
)
MORE_CROSSED = Rule(
    "plan-crossings-on-line",
    _W,
    "found {found} more places where cut contours cross; they are cut on their lines",
    "Only the first twenty are named one by one.",
)
NO_LEAD = Rule(
    "plan-lead",
    _N,
    "found {count} contours without room for a lead of {found} mm; theirs are shorter or missing",
    "A lead must stay in the waste; where a contour is too narrow the torch pierces nearer to it.",
)
SQUARE = Rule(
    "plan-bevel-left",
    _W,
    "found bevels on a contour, which is cut square; they are left to another machine",
    "`--allow-skips bevel` was given; a torch that does not tilt cuts every edge square.",
)
NEEDS_LEAD = Rule(
    "plan-kerf-lead",
    _E,
    "found a contour without room for the line along which the controller takes up {found} mm; "
    "expected a wider one, or --kerf-by offset",
    "A controller that keeps beside a contour needs a straight move to get there, longer than half "
    "the kerf, and so much room beside it.",
)
UNCOMPENSATED = Rule(
    "plan-kerf-machine",
    _E,
    "found {found} at x {x}, y {y}, too small for kerf compensation of {kerf} / 2 mm by the "
    "controller; expected a larger one, or --kerf-by offset",
    "Cutter compensation looks at two moves at a time: it refuses an arc smaller than the tool and "
    "a corner that the tool does not fit into.",
)
MACHINE_TABS = Rule(
    "plan-kerf-tabs",
    _E,
    "found {found} bridges with kerf compensation by the controller; expected none, or --kerf-by "
    "offset",
    "Behind each bridge the torch would pierce on the contour, before the compensation is active.",
)
NO_TABS = Rule(
    "plan-tabs",
    _N,
    "found {count} contours too short for {found} bridges; they get fewer or none",
    "Bridges need more contour between them than they take away.",
)
OVERCUT = Rule(
    "plan-overcut",
    _N,
    "found {count} contours too short for an overcut of {found} mm; theirs is half of the way to "
    "the first bridge, or of the contour",
    "An overcut that went round again would be a second pass, and cut through a bridge.",
)

CHAIN = Rule(
    "plan-chain",
    _E,
    "found {found} operations; expected at most {expected} in a chain, or --style table",
    "A controller looks at every operation of a chain in every cycle, and would fall behind.",
)

RULES = (
    CHAIN, SHEETS, MIXED, SHEET_FULL, UNROLLED, QUANTITY, NOTHING, UNMAPPED, MAP, OPTION,
    LOOK_SETTING, LOOK_OVERCUT, LOOK_ORDER, LAYOUT, HATCH, NO_PROCESS, NO_THICKNESS, THICKNESS,
    OTHER_THICKNESS, OTHER_MATERIAL, ASSUMED, SHEET_SIZE, SHEET_PLACE, JUNCTION, BRANCHED,
    NOT_CLOSED, TINY, SHARED, COMMON, RUNS_BACK_KERF, RUNS_BACK, RUNS_OVER, GAP, GAPS, OPEN_CUT,
    OPEN_KERF, MORE_OPEN, OVERLAP, VANISHED, NARROW, NEAR, LEFT, CROWDED, COPIES, CROSSING,
    MORE_CROSSINGS, CROSSED, MORE_CROSSED, NO_LEAD, SQUARE, NEEDS_LEAD, UNCOMPENSATED,
    MACHINE_TABS, TURNED, APART, NO_TABS, OVERCUT, TORCH_HEIGHT, HEADROOM,
)  # fmt: skip
