"""Rules for programs of a cutting table."""

from beamcam.errors import error

# fmt: off


FEED = error("verify-sheet-feed",
    "found a feed of {found} mm/min to {process}; expected {expected}",
    "The feed is not that of the machine's file for this sheet.")
HOLE_FEED = error("verify-sheet-hole-feed",
    "found the contour of {contour} cut at {found} of its feed; expected {expected}",
    "Small holes are cut slower, by `hole_diameter` and `hole_feed_share` of the row; nothing else "
    "is.")
HOLE_LEAD = error("verify-sheet-hole-lead",
    "found the contour of {contour} begun {found}; expected half a circle from there",
    "`hole_lead` has round small holes pierced in their middle, as far from the part as there is "
    "room, and entered along their contour.")
SPOT = error("verify-sheet-spot",
    "found {found} at X {x}, Y {y}; expected {expected}",
    "A spot tells the drill where to begin: each centre has one, made where the torch stands, "
    "before the sheet may shift.")
NO_CONTOUR = error("verify-sheet-contour",
    "found contour {found} to begin with; expected 2 to {expected}, as `beamcam plan` counts",
    "The rest of a program begins with one of its contours, and the first begins the whole.")
REST = error("verify-sheet-rest",
    "found {found}; expected {expected}",
    "The rest of a program makes the last strokes of the whole as they are, and says so; what is "
    "cut is not looked at again.")
EDGE = error("verify-sheet-edge",
    "found the torch piercing on the edge of the contour of {contour} at X {x}, Y {y}; expected it "
    "in a kerf that was cut before",
    "What is left of a contour that shares an edge begins where the other was cut; anywhere else "
    "the hole of the pierce stays in the part.")
FRAME = error("verify-sheet-frame",
    "found {found}; expected {expected}",
    "A frame leads the head once round all of the work, slowly and with its tool off.")
OVERSCAN = error("verify-sheet-overscan",
    "found {found} mm dark before and behind a stroke at X {x}, Y {y}; expected {expected} mm",
    "The lines of a hatch begin and end at full speed, and nothing else is followed dark.")
RAMP = error("verify-sheet-ramp",
    "found {found}; expected {expected}",
    "The head would accelerate or brake faster than its axes can, or as slowly as the project's "
    "default.")
TOOL = error("verify-sheet-tool",
    "found {found}; expected {expected}",
    "The tool would not run as the machine's file says.")
HEIGHT = error("verify-sheet-height",
    "found {found}; expected {expected}",
    "The torch would strike the sheet or what has tipped up, or cut from another height than the "
    "row's.")
THC = error("verify-sheet-thc",
    "found {found}; expected {expected}",
    "The control of the height would follow no arc, or dive into what is cut already.")
OUTPUT = error("verify-sheet-output",
    "found {found}; expected {expected}",
    "Gases and outputs would come in another order, or stay as no next program expects them.")
DARK = error("verify-sheet-dark",
    "found {found} of the contour of {contour}; expected {expected}",
    "With the arc out before the contour is closed the part stays in the sheet; with it on behind "
    "that the edge is cut twice.")
MATERIAL = error("verify-sheet-material",
    "found {found}; expected {expected}",
    "The controller would pierce and cut by the data of another row.")
CORNER = error("verify-sheet-corner",
    "found a controller that passes corners at {found}; expected {expected}",
    "Corners would come out rounded, or the head would stop in each of them.")
RAPID = error("verify-sheet-rapid",
    "found a traverse to X {x}, Y {y} with the tool on; expected it off",
    "The head would cut its way across the sheet.")
IDLE = error("verify-sheet-idle",
    "found a feed to X {x}, Y {y} with the tool off; expected it on, or a traverse",
    "A contour that is followed with the tool off is not cut.")
AREA = error("verify-sheet-area",
    "found a move to X {x}, Y {y}; expected it within {length} x {width} mm",
    "The head cannot go there.")
RADIUS = error("verify-sheet-radius",
    "found an arc of radius {found} mm to X {x}, Y {y}; expected {least} to {greatest} mm",
    "The controller stops at an arc that it does not take, or follows another one "
    "(`torch.min_radius`, `torch.max_radius`).")
MISSING = error("verify-sheet-missing",
    "found nothing that {process}s the contour of {contour} at x {x}, y {y}, machine X "
    "{machine_x}, Y {machine_y}; expected the whole of it",
    "A contour that is not closed leaves the part in the sheet.")
EXTRA = error("verify-sheet-extra",
    "found a path at X {x}, Y {y} that is {away}; expected {expected}",
    "It cuts where nothing is drawn.")
TWICE = error("verify-sheet-twice",
    "found the contour of {contour} at x {x}, y {y} followed {found} times; expected once",
    "A contour that is cut twice is wider, rougher, and burns.")
SIDE = error("verify-sheet-side",
    "found the path at X {x}, Y {y} on the part's side of the contour of {contour}; expected it in "
    "the waste",
    "The part would come out smaller by the kerf.")
BAND = error("verify-sheet-band",
    "found the middle of the beam {found} mm from the contour of {contour} at X {x}, Y {y}; "
    "expected {expected}",
    "The beam takes half its kerf on each side of its path, and would cut into the part.")
COMPENSATION = error("verify-sheet-compensation",
    "found {found}; expected a path that the controller can keep the beam beside",
    "The controller would stop there, in the middle of a cut.")
OPEN = error("verify-sheet-open",
    "found a path that {what} at X {x}, Y {y}, in the middle of the contour of {contour}; expected "
    "it to close",
    "What is between the two ends holds the part.")
RESTART = error("verify-sheet-restart",
    "found the tool stopped and started again at X {x}, Y {y}, in the middle of the contour of "
    "{contour}; expected the contour in one stroke",
    "It would pierce on the edge of the part.")
TABS = error("verify-sheet-tabs",
    "found {found} bridge(s) in the contour of {contour}; expected {expected}",
    "With fewer the part comes loose while it is cut; each one more has to be broken off.")
TAB_WIDTH = error("verify-sheet-tab-width",
    "found a bridge {found} mm wide in the contour of {contour} at X {x}, Y {y}; expected "
    "{expected} mm between the strokes beside it",
    "A narrow bridge breaks while the part is cut, a wide one does not break afterwards.")
TAB_PLACE = error("verify-sheet-tab-place",
    "found a bridge in the contour of {contour} at X {x}, Y {y}, {found}; expected {expected}",
    "Bridges on one side let a part tilt, and one in a corner leaves a burr that no file reaches.")
DIRECTION = error("verify-sheet-direction",
    "found the contour of {contour} cut {found}; expected {expected}, as torch.direction is "
    "{how!r}",
    "The edge that a swirling torch cuts at a slant would be on the part.")
OVERCUT = error("verify-sheet-overcut",
    "found the contour of {contour} cut {found} mm beyond its start; expected {expected} mm",
    "Without its overcut a part hangs where the cut closes; a longer one burns the edge.")
LEAD = error("verify-sheet-lead",
    "found a lead {found} mm from the contour of {contour} at X {x}, Y {y}; expected {expected}",
    "The torch pierces or leaves where the part or its neighbour is.")
PIERCE = error("verify-sheet-pierce",
    "found the sheet pierced at X {x}, Y {y}, {found} mm from the contour of {contour}; expected "
    "at least {expected} mm, as there is room for a lead of {lead} mm",
    "Piercing burns a wider hole than the cut; it would take a bite out of the edge.")
LINK = error("verify-sheet-link",
    "found a way with the torch on from X {x0}, Y {y0} to X {x1}, Y {y1}, {found}; expected "
    "{expected}",
    "From one part to the next the torch stays on in waste alone, and no farther than `chain_cuts` "
    "says; over an open cut its arc goes out.")
ORDER = error("verify-sheet-order",
    "found {found} after {before}; expected it before",
    "Once a part is cut free it may tilt, and nothing on it comes out right any more.")
SETTINGS = error("verify-sheet-settings",
    "found the contour of {contour} {process} at {found}; expected {expected}",
    "Its colour or layer, or the machine's file, asks for other ones.")
TURN = error("verify-sheet-turn",
    "found a contour of order {found} after one of order {expected}; expected it before",
    "The order of colours and layers is what was asked for.")
HATCH = error("verify-sheet-hatch",
    "found {found} in the contours that {key!r} fills, at x {x}, y {y}; expected lines {expected} "
    "mm apart at {angle} degrees, each once and inside of them",
    "What is filled would be patchy, or run over its outline.")
HATCH_WAY = error("verify-sheet-hatch-way",
    "found a line of the hatch of {key!r} that runs backwards at X {x}, Y {y}; expected all of "
    "them to run one way",
    "Lines both ways differ in shade where a machine has play; `hatch_one_way` asks for one.")
NOT_MADE = error("verify-sheet-not-made",
    "found {found} that the machine does not make ({kind}); expected that kind to be named by "
    "--allow-skips, or its colour by --map",
    "Nothing is left out silently.")
CROWDED = error("verify-sheet-crowded",
    "found {found} places of the path beside a contour, about X {x}, Y {y}; expected fewer curves "
    "on one place",
    "To compare each of hundreds of curves on one place with all the others would take minutes.")

OTHER_SHEET = error("verify-sheet-other",
    "found a part of {found} on the sheet; expected {expected}, as the first one",
    "Parts that share a sheet share its thickness and its material.")
LAID = error("verify-sheet-laid",
    "found a {found} in a part that is mirrored, turned or copied; expected contours, holes, slots "
    "and, where nothing is mirrored, texts",
    "Where such a feature would come to lie is not known.")
BESIDE = error("verify-sheet-beside",
    "found {what} beside the plate; expected it within the outline",
    "It is cut into the sheet beside the part, where the next one may lie.")
SKEW_END = error("verify-sheet-end-skew",
    "found a program of a plate whose {end} is cut at {found} degrees through its thickness; "
    "expected 0",
    "A torch cuts square, so that it leaves what such an end takes off.")
