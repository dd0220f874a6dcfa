"""What the finished part denies: holes that it does not hold, ends that it cannot have."""

from beamcam.errors import Rule, Severity

_E, _W, _N = Severity.ERROR, Severity.WARNING, Severity.NOTE

SECTION_SHAPE = Rule(
    "plan-section-shape",
    _E,
    "found {found} in a section of profile code {code}; expected walls that fit into each other",
    "No such section can be rolled, and where its walls stand is not known.",
)
CUTS_CROSS = Rule(
    "plan-cuts-cross",
    _E,
    "found end cuts that cross by {found} mm at y {y}, z {z}; "
    "expected the part to be longer than both mitres there",
    "Nothing is left of the part where its two end cuts meet.",
)
CUTS_TOUCH = Rule(
    "plan-cuts-touch",
    _N,
    "the end cuts meet in a point at y {y}, z {z}",
    "The part is as long as its two mitres, and ends there in an edge.",
)
SAW_REACH = Rule(
    "plan-saw-reach",
    _E,
    "found a section of {found} mm at a cut of {angle} degrees at the {end}; "
    "expected at most {expected} mm (height x width), as the blade reaches at that angle",
    "A blade that is turned reaches less far across. `saw.max_sections` of the machine file says "
    "how far at which angle.",
)
BAR_LEFT = Rule(
    "plan-bar-left",
    _E,
    "found {found} mm of bar from the last part on; expected at least {expected} mm, "
    "give a longer --bar or another order of parts",
    "What is left of the bar pushes its last part, so it has to reach between the rollers "
    "(`layout.min_bar_left`).",
)
OFF_PART = Rule(
    "plan-off-part",
    _E,
    "found {what} at x {x}, y {y} on face {face} that reaches {out} mm beyond {where}; "
    "expected it wholly within the finished part",
    "A hole that an end cut or an edge cuts open is a slip of the drawing, and the drill would "
    "run off. A hole in the wedge that a mitre takes off is made for nothing.",
)
NEAR_EDGE = Rule(
    "plan-near-edge",
    _W,
    "found {what} at x {x}, y {y} on face {face}, {apart} mm from {where}; "
    "expected at least {expected} mm",
    "So little steel bends or breaks out beside the drill (`drill.min_edge_distance`).",
)
OVERLAP = Rule(
    "plan-hole-overlap",
    _E,
    "found {what} at x {x}, y {y} on face {face}, {apart} mm from {other} of {first}; "
    "expected at least {expected} mm between their middles",
    "A drill that breaks into another hole runs off or breaks. Two diameters at one place may be "
    "a stepped hole, of which the wider one is blind.",
)
WALL = Rule(
    "plan-wall",
    _E,
    "found {what} at x {x}, y {y} on face {face}; "
    "expected it clear of the wall from y {least} to {greatest}",
    "Another wall of the section stands there, and the drill would go down in it.",
)
FILLET = Rule(
    "plan-fillet",
    _E,
    "found {what} at x {x}, y {y} on face {face} where the root fillet is {found} mm high; "
    "expected at most {expected} mm, {because}",
    "The fillet makes the wall thicker than the stroke is deep, or stands in the drill's way.",
)
NEAR_FILLET = Rule(
    "plan-near-fillet",
    _W,
    "found {what} at x {x}, y {y} on face {face}, {found}; expected at least {expected} mm from it",
    "A drill that meets the root fillet runs to one side (`drill.min_fillet_distance`).",
)
BLIND_DEPTH = Rule(
    "plan-blind-depth",
    _E,
    "found {what} of depth {found} at x {x}, y {y} on face {face}; "
    "expected at most {expected} mm, the thickness of the wall",
    "A blind hole ends in its wall. A depth of 0 is through.",
)
BLIND_POINT = Rule(
    "plan-blind-point",
    _W,
    "found {what} of depth {found} at x {x}, y {y} on face {face}; its point comes {out} mm "
    "through the wall of {expected} mm",
    "The depth counts to the full diameter, and the drill's point goes beyond it.",
)
LINE_BEYOND = Rule(
    "plan-line-beyond",
    _W,
    "found a line to mark on face {face} that goes {out} mm beyond {where}; "
    "expected it on the finished part",
    "What is scribed beyond the part is scribed on waste, or in the air.",
)
FROM_BEHIND = Rule(
    "plan-from-behind",
    _N,
    "found {what} at x {x}, y {y} on face {face}; it is made from face {other}",
    "A through hole is the same from either side of its wall, and no spindle reaches that face.",
)
ANGLE_FACE = Rule(
    "plan-angle-face",
    _W,
    "found {what} at x {x}, y {y} on face {face} of an angle, which has faces v and u; "
    "it is made on face {other}",
    "An angle has one flange, whose outside is u. Exporters that take the section for a channel "
    "write its other side as o.",
)

FINISHED_PART = (
    SECTION_SHAPE, CUTS_CROSS, CUTS_TOUCH, SAW_REACH, BAR_LEFT, OFF_PART, NEAR_EDGE, OVERLAP, WALL,
    FILLET, NEAR_FILLET, BLIND_DEPTH, BLIND_POINT, LINE_BEYOND, FROM_BEHIND, ANGLE_FACE,
)  # fmt: skip
