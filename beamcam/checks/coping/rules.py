"""Rules for programs that cope profiles."""

from beamcam.errors import error

# fmt: off


PARTS = error("verify-coping-parts",
    "found {found} parts for one program; expected one",
    "A program of a coper makes one part.")
SECTION = error("verify-coping-section",
    "found a section of profile code {found}; expected {expected}",
    "The read-back knows where the walls of these sections are, and of no others.")
TORCH = error("verify-coping-torch",
    "found {found}; expected {expected}",
    "The torch may only be on while it cuts, and only as the machine file says that it is.")
ANGLE = error("verify-coping-angle",
    "found the torch cutting at A {found}; expected -90, 0 or 90, fixed from pierce to end, "
    "or off it along a bevel",
    "Any other angle cuts the wall at a slant, or another wall.")
TILT = error("verify-coping-tilt",
    "found the torch cutting at B {found}; expected one angle from pierce to end, {expected} "
    "degrees at most",
    "B tilts the torch in the plane of the cut, and stands still while it cuts, but along a bevel "
    "of a curve, in inverse time.")
SQUARE = error("verify-coping-square",
    "found the torch {found} mm beside the normal of the surface below it; expected at most "
    "{expected} mm",
    "Over a tube the torch stands upright, square to the wall on faces and corners alike, all the "
    "way of a cut.")
RADIUS = error("verify-coping-radius",
    "found corners of {found} mm on {name}; expected their outer radius, {least} to {most} mm, in "
    "the part, by a row of coper.corners or by --corner",
    "Where the torch has to be over a corner follows from its radius. A program that was made "
    "with --corner is read back with the same.")
LIP = error("verify-coping-lip",
    "found lips of {found} mm on {name}; expected their length, {least} to {most} mm, in the part, "
    "by coper.lip or by --lip",
    "How deep each cut of a flange has to be at its lip follows from its length. A program that "
    "was made with --lip is read back with the same.")
LOST = error("verify-coping-corner",
    "found contours that end at the corner between faces {found}; expected them to go over it and "
    "meet",
    "What has to stay of a corner is not known then.")
HEIGHT = error("verify-coping-height",
    "found the tip {found} mm over the {face} face as it {does}; expected {expected} mm",
    "Too low the torch strikes the steel, too high its arc goes out or its kerf gets wider.")
FEED = error("verify-coping-feed",
    "found a feed of {found} mm/min through {thickness} mm; expected {expected} mm/min",
    "The cut chart of the machine file has one speed for each thickness: a faster cut is not "
    "through, a slower one is wider.")
PIERCE = error("verify-coping-pierce",
    "found a wait of {found} s to pierce; expected {expected} s",
    "A torch that moves before it is through leaves a cut that is not.")
AIR = error("verify-coping-air",
    "found the torch on at x {x}, y {y} of face {face}, where no steel is; expected it over scrap",
    "An arc does not start in air, and goes out where a cut leaves the steel.")
COLLISION = error("verify-coping-strikes",
    "found the torch {found} mm from the bar at A {a}, Y {y}, Z {z}; expected {expected} mm",
    "The torch and its holder must meet neither web nor flange, wherever they go.")
LIMIT = error("verify-coping-limit",
    "found {axis} at {found}; expected {least} to {most}",
    "The axis stops at its switch.")
PLACE = error("verify-coping-place",
    "found a cut at y {y} on face {face}; expected it on the wall, from {least} to {most}",
    "There the torch would cut another wall.")
HURT = error("verify-coping-hurt",
    "found {found} mm of the part cut away on face {face} near x {x}, y {y}; expected at most "
    "{expected} mm",
    "The kerf, or what piercing burns, reaches into steel that has to stay.")
LEFT = error("verify-coping-left",
    "found {found} mm of scrap left on face {face} near x {x}, y {y}; expected it cut off",
    "The piece that falls off is larger than the part, or nothing falls off at all.")
SHORT = error("verify-coping-short",
    "found the piece {found} mm shorter on face {face} than what has to stay of it; expected it as "
    "long",
    "What the machine before has cut off cannot be made again.")
GONE = error("verify-coping-gone",
    "found nothing of face {face} left; expected a wall of the part",
    "Each wall of the section is accounted for.")
HOLDS = error("verify-coping-holds",
    "found scrap of face {scrap} that holds to face {face} over {found} mm near x {x}; expected it "
    "cut off",
    "The root between web and flange is not cut through there.")
EXTRA = error("verify-coping-extra",
    "found a cut near x {x}, y {y} on face {face} that runs along no contour of the part; expected "
    "none but a straight lead",
    "It makes nothing that was asked for.")
ORDER = error("verify-coping-order",
    "found a cut on face {face} behind the first one of the far end; expected those last",
    "A piece that hangs by less and less moves; what is left is cut in the wrong place.")
PASSES = error("verify-coping-passes",
    "found the bevel of an edge on face {face} cut; expected {expected}",
    "A second pass takes the wedge off an edge that is cut, of a piece that is still held.")
MEASURED = error("verify-coping-measured",
    "found {found}; expected {expected}",
    "`measured_height` and `measured_width` of a machine file say the bar's own figures to the "
    "machine, once and before the first cut. A figure that is farther off the section's than "
    "`coper.rolled` is that of another bar.")
ZONE = error("verify-coping-zone",
    "found {found}; expected {expected}",
    "The machine file says where a torch may not cut or go: the root between web and flange "
    "(k_area), other places of a tube than its seam where an end begins, the stretch of the bar "
    "that the chuck holds.")
PLANE = error("verify-coping-plane",
    "found an end plane that takes {found} mm of the part; expected none but those of its ends",
    "No cut of this machine makes a plane of its own through all walls.")
RULES = (
    PARTS, SECTION, TORCH, ANGLE, TILT, SQUARE, RADIUS, LIP, LOST, HEIGHT, FEED, PIERCE, AIR,
    COLLISION, LIMIT, PLACE, HURT, LEFT, SHORT, GONE, HOLDS, EXTRA, ORDER, PASSES,
    MEASURED, ZONE, PLANE,
)
