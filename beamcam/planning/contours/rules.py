"""Rules for sheets on a cutting table."""

from collections.abc import Iterable

from beamcam.errors import error, note, warning

# fmt: off


SHEETS = error("plan-sheet-parts",
    "found {found} parts; expected one for a sheet, or several",
    "A sheet without a part has nothing to cut.")
MIXED = error("plan-sheet-mixed",
    "found a part of {found}; expected {expected}, as the first part on the sheet",
    "Parts that share a sheet share its thickness and its material.")
SHEET_FULL = error("plan-sheet-full",
    "found {found} parts, of which {fits} fit on a sheet of {size} mm; expected all of them; give "
    "a larger --sheet, or let `post` take several sheets",
    "Parts lie in rows by their boxes, in the order given, with torch.spacing between them and "
    "torch.margin to the edges.")
QUANTITY = warning("plan-sheet-quantity",
    "found a quantity of {found}; this program makes {made}, --quantity file makes all",
    "Without --quantity a part is laid on a sheet as often as its file is named, whatever quantity "
    "it states. --quantity 1 says that one is meant.")
TORCH_HEIGHT = error("plan-torch-height",
    "found no {key} to {process} up to {up_to} mm; expected one in the row, as {axis} lifts the "
    "torch",
    "0 stands for a height that is not known. The torch would touch the sheet.")
HEADROOM = error("plan-torch-headroom",
    "found a sheet of {found} mm; expected at most {expected} mm, which the torch passes by "
    "triggers.z.clearance below its home",
    "X and Y move at the clearance over the sheet, and homing ends above it.")
NOTHING = error("plan-sheet-empty",
    "found nothing to cut or mark, {found}; expected at least one line",
    "Filled shapes without a stroke, hidden layers and colours that are mapped to ignore are not "
    "cut.")
UNMAPPED = error("plan-unmapped",
    "found {count} curves {found}, which stand for no process; expected one of {expected}, or "
    "--map {key}=cut",
    "What a colour or a layer means is said in the machine's file or on the command line, and "
    "never guessed.")
MAP = error("plan-map",
    "found {found!r}; expected a colour or a layer, =, and one of cut, mark, engrave, ignore",
    "The option --map says what is done with the lines of a colour or a layer.")
OPTION = error("plan-sheet-option",
    "found an option that the machine cannot follow: {found}; expected one that it can",
    "Colours, kerfs, leads and bridges belong to machines that cut sheets.")
LOOK_SETTING = error("plan-map-setting",
    "found {key} = {found}; expected none, {why}",
    "The machine would run at another power than the one that is asked for.")
LOOK_OVERCUT = error("plan-map-overcut",
    "found map.{key}.overcut of lines to {found}; expected it of what is cut",
    "An overcut severs what a cut leaves where it closes; a mark would be darker there.")
LOOK_ORDER = error("plan-map-order",
    "found order {found} of {key!r}, which would {process} it after the cut of {other}, of order "
    "{expected}; expected marks before cuts, and what lies in a contour before it; give the later "
    "one a higher map.KEY.order",
    "Once a part is cut free it may tilt, and nothing on it comes out right any more.")
LAYOUT = error("plan-sheet-layout",
    "found {found}; expected only holes, slots and contours where sheet.mirror, sheet.rotate or "
    "sheet.copies is asked for",
    "What cannot be turned or mirrored with its part would come to lie elsewhere.")
TURNED = note("plan-sheet-turned",
    "found a part of {found} mm, larger as it is drawn than the sheet of {expected} mm; turned it "
    "by 90 degrees",
    "It lies on the table so that it fits. `sheet.rotate` says how a part lies, `sheet.place` "
    "leaves it where it is drawn.")
APART = note("plan-sheet-apart",
    "found parts that share edges; moved {count} of them apart by the kerf of {kerf} mm",
    "One cut goes between two parts and takes nothing of either: they lie a kerf farther from one "
    "another than they are drawn. `sheet.common_cuts` asks for it.")
HATCH = error("plan-map-hatch",
    "found {found} to fill by map.{key}.hatch; expected closed contours to mark or engrave",
    "A hatch fills what closed contours enclose; loose lines have no inside.")
NO_PROCESS = error("plan-process",
    "found {count} curves to {found}; expected only what {machine} does: {expected}",
    "The machine's file has no row for that process.")
NO_THICKNESS = error("plan-thickness-unknown",
    "found no thickness of the sheet; expected one, give it by --thickness",
    "Speed, power and kerf follow from the thickness, and a drawing does not say it.")
THICKNESS = error("plan-thickness",
    "found a sheet of {found} mm {material} to {process}; expected {expected}; {others}",
    "The machine's file has no speed for that thickness of that material. A row of your own cut "
    "chart under `[[torch.more_rows]]` in a machine file of your own adds one.")
OTHER_THICKNESS = error("plan-thickness-other",
    "found --thickness {found}; expected {expected}, as the part itself says",
    "Only a drawing does not say how thick its sheet is; one of the two is wrong.")
OTHER_MATERIAL = error("plan-material-other",
    "found --material {found}; expected {expected}, as the part itself says",
    "Speed, power and kerf follow from the material; one of the two is wrong. A part without a "
    "grade takes the option.")
ASSUMED = note("plan-thickness-assumed",
    "found no thickness in the drawing; the sheet is {found} mm {material}, by the options or the "
    "machine's file",
    "--thickness and --material say it, and where they do not, the machine's file.")
SHEET_SIZE = error("plan-sheet-size",
    "found a sheet of {found} mm; expected at most {expected} mm, the work area of the table",
    "The part with its leads has to lie within the work area.")
SHEET_PLACE = error("plan-sheet-place",
    "found work from x {x0}, y {y0} to x {x1}, y {y1}; expected it between 0, 0 and {length}, "
    "{width}",
    "The part is left where it is drawn, or its leads reach over the corner: --place corner moves "
    "it, and the machine's margin leaves room for leads.")
JUNCTION = warning("plan-junction",
    "found {found} curves that meet at x {x}, y {y}, with {other}; expected two, the contour stops "
    "there",
    "Where three curves meet, the contour has no unique continuation and stays open.")
BRANCHED = error("plan-junction-kerf",
    "found {found} curves that meet at x {x}, y {y}, with {other}; expected two with kerf "
    "compensation of {kerf} mm, or --kerf-by none, which cuts them on their lines",
    "Where contours share curves nothing says on which side of them the part lies: both parts "
    "would come out half a kerf too small.")
NOT_CLOSED = error("plan-not-closed",
    "found a contour that is declared closed, and goes from x {x0}, y {y0} to x {x1}, y {y1}; "
    "expected its curves to meet there, not {found} mm apart",
    "The part is damaged: nothing says where to cut between its curves.")
TINY = warning("plan-tiny",
    "found {count} curves no larger than {expected} mm; they are left out",
    "Two ends that close are one point to the machine (`torch.gap`), so the tool would be started "
    "and not moved.")
SHARED = error("plan-shared-edge",
    "found a contour that lies on {other} for {found} mm near x {x}, y {y}; expected them apart by "
    "the kerf of {kerf} mm, or --kerf-by none, which cuts the edge once",
    "One cut takes its kerf from both parts, or from one of them the whole of it.")
COMMON = note("plan-common-edge",
    "{count} contours share edges with others, {found} mm of them; each edge is cut once",
    "Without kerf compensation two parts can share a cut.")
RUNS_BACK_KERF = error("plan-doubles-back-kerf",
    "found a curve that turns round at x {x}, y {y} and runs back along itself for {found} mm; "
    "expected one that does not, or --kerf-by none, which follows it as it is drawn",
    "There is no waste on either side of such a stretch, so that the kerf cannot be compensated.")
RUNS_BACK = warning("plan-doubles-back",
    "found a curve that turns round at x {x}, y {y} and runs back along itself for {found} mm; it "
    "is followed as it is drawn",
    "The tool may pass that stretch twice, which burns or widens it.")
RUNS_OVER = error("plan-runs-over-itself",
    "found a curve that runs over itself from x {x}, y {y} on, for {found} mm; expected one that "
    "passes each place once",
    "The torch would burn one place over and over, as where a formula goes round more than once. "
    "Passes one over the other are asked for by `passes` of the machine file or the map.")
GAP = warning("plan-gap",
    "found a gap of {found} mm at x {x}, y {y}; expected at most {expected} mm in a contour, or a "
    "larger torch.gap in the machine file",
    "The contour stays open there, so that the part may not fall out.")
OPEN_CUT = warning("plan-open-cut",
    "found an open contour to cut from x {x0}, y {y0} to x {x1}, y {y1}, {apart} mm apart; it is "
    "cut on its line, without regard to the kerf",
    "An open line has no side that the part lies on. Ends at most `torch.gap` of the machine file "
    "apart are joined.")
OPEN_KERF = error("plan-open-kerf",
    "found an open contour to cut from x {x0}, y {y0} to x {x1}, y {y1}, {apart} mm apart; "
    "expected it closed, as a kerf of {kerf} mm is compensated; {how}",
    "An open line has no side that the part lies on, and what it seems to enclose would be cut on "
    "the wrong one.")
GAPS = note("plan-gaps-closed",
    "closed {count} gaps between ends of curves, the widest {found} mm at x {x}, y {y}",
    "Ends at most `torch.gap` or --gap apart are joined by moving them, or by a line.")
MORE_OPEN = warning("plan-open-cuts",
    "found {found} more open contours to cut; they are cut on their lines",
    "Only the first ten are named one by one.")
OVERLAP = warning("plan-overlap",
    "found {count} curves that lie on others, {found} mm of them; they are cut once",
    "Exports of bolted or mirrored parts draw the same line twice.")
VANISHED = error("plan-kerf",
    "found a contour of {found} mm without room for a kerf of {kerf} mm; expected a wider one",
    "The cut would take away what it should leave, or close up.")
NARROW = error("plan-narrow",
    "found a place {found} mm wide at x {x}, y {y}{more}, {depth} mm of it out of reach; expected "
    "at least the kerf of {kerf} mm, or a smaller --kerf, or --kerf-by none",
    "The beam does not get into a slot or through a neck narrower than itself, and what is waste "
    "there would stay on the part.")
NEAR = error("plan-near",
    "found {found} mm of waste between the contour and {other} at x {x}, y {y}; expected at least "
    "the kerf of {kerf} mm, or a smaller --kerf, or --kerf-by none",
    "The cut along one contour would enter the part at the other. Parts just a kerf apart share a "
    "cut.")
LEFT = warning("plan-left-in-corner",
    "the round beam leaves {depth} mm in a corner or a slot {found} mm wide at x {x}, y {y}{more}",
    "A round beam reaches no farther; where that matters, finish the place manually.")
CROWDED = error("plan-crowded",
    "found curves that pass the {reach} mm around x {x}, y {y} {found} times; expected at most "
    "{expected} passes of one place on an average",
    "The torch would burn one place over and over. Copies that are equal or lie on one another are "
    "cut once; these differ a little, or one curve runs to and fro.")
COPIES = error("plan-copies",
    "found one curve {found} times, and {copies} copies of curves in all; expected a drawing "
    "without so many copies that are equal in every number",
    "A few copies are cut once. Of thousands each is compared with each: delete them in the "
    "drawing.")
CROSSING = error("plan-crossing",
    "found a cut contour that crosses {other} near x {x}, y {y}; expected contours that do not "
    "cross, or --kerf-by none, which cuts them on their lines",
    "Its inside is not defined, and so neither is the side of the kerf nor what falls out.")
MORE_CROSSINGS = error("plan-crossings",
    "found {found} more places where cut contours cross; expected none",
    "Only the first twenty are named one by one.")
CROSSED = warning("plan-crossing-on-line",
    "found a cut contour that crosses {other} near x {x}, y {y}; both are cut on their lines",
    "What falls out of contours that cross is in more pieces than are drawn.")
MORE_CROSSED = warning("plan-crossings-on-line",
    "found {found} more places where cut contours cross; they are cut on their lines",
    "Only the first twenty are named one by one.")
NO_LEAD = note("plan-lead",
    "found {count} contours without room for a lead of {found} mm; theirs are shorter or missing",
    "A lead must stay in the waste; where a contour is too narrow the torch pierces nearer to it.")
SQUARE = warning("plan-bevel-left",
    "found bevels on a contour, which is cut square; they are left to another machine",
    "`--allow-skips bevel` was given; a torch that does not tilt cuts every edge square.")
NEEDS_LEAD = error("plan-kerf-lead",
    "found a contour without room for the line along which the controller takes up {found} mm; "
    "expected a wider one, or --kerf-by offset",
    "A controller that keeps beside a contour needs a straight move to get there, longer than half "
    "the kerf, and so much room beside it.")
UNCOMPENSATED = error("plan-kerf-machine",
    "found {found} at x {x}, y {y}, too small for kerf compensation of {kerf} / 2 mm by the "
    "controller; expected a larger one, or --kerf-by offset",
    "Cutter compensation looks at two moves at a time: it refuses an arc smaller than the tool and "
    "a corner that the tool does not fit into.")
MACHINE_TABS = error("plan-kerf-tabs",
    "found {found} bridges with kerf compensation by the controller; expected none, or --kerf-by "
    "offset",
    "Behind each bridge the torch would pierce on the contour, before the compensation is active.")
TAB_JOINT = error("plan-tabs-joint",
    "found a bridge of {found} mm at x {x}, y {y} without a place beside it where no cut of a part "
    "that touches begins or ends; expected fewer or narrower bridges, or parts that do not touch",
    "With common cuts what is left of a part's contour is cut after that of the part it touches, "
    "and begins on it: there it would cut the bridge that holds that part.")
NO_TABS = note("plan-tabs",
    "found {count} contours too short for {found} bridges; they get fewer or none",
    "Bridges need more contour between them than they take away.")
OVERCUT = note("plan-overcut",
    "found {count} contours too short for an overcut of {found} mm; theirs is half of the way to "
    "the first bridge, or of the contour",
    "An overcut that went round again would be a second pass, and cut through a bridge.")

CHAIN = error("plan-chain",
    "found {found} operations; expected at most {expected} in a chain, or --style table",
    "A controller looks at every operation of a chain in every cycle, and would fall behind.")

SKEW_END = error("plan-sheet-end",
    "found the {end} of a plate cut at {found} degrees through its thickness, and no edge of its "
    "outline there; expected one, as long as the plate",
    "A torch cuts square along the longer face, so that no steel is missing, and the bevel is "
    "manual work. An outline that ends elsewhere says another length than the header.")
OFF = error("plan-sheet-off",
    "found {what}, beside the plate; expected it within the outline",
    "It would be cut into the sheet beside the part. A number of the file is wrong, or its outline "
    "is.")
NOTCH = note("plan-sheet-notch",
    "found {what}, which lies on the outline of {first} along {found} mm; it is cut with it, as a "
    "notch",
    "A cut-out that is open to the edge takes that edge away, and leaves one contour.")


def at_place(place: Iterable[float]) -> dict[str, str]:
    """A place as messages have it, by `x` and `y`."""
    x, y = (f"{value:.3f}" for value in place)
    return {"x": x, "y": y}
