"""Rules for what a machine can hold: the bar of a program, and the parts that come off it."""

from beamcam.errors import Rule, Severity

_E = Severity.ERROR

PART_SHORT = Rule(
    "verify-part-short",
    _E,
    "found the part {mark}, {found} mm long; expected at least {expected} mm",
    "A shorter part falls between the rollers or cannot be held (`layout.min_part`).",
)
BAR_START = Rule(
    "verify-bar-start",
    _E,
    "found the part {mark} to start {found} mm behind the front of the bar; expected at least "
    "{expected} mm",
    "The front of a bar is trimmed (`layout.front_trim`), before that there is no sound steel.",
)
BAR_END = Rule(
    "verify-bar-end",
    _E,
    "found the last cut to end {found} mm from the front of the bar; expected at most {expected} "
    "mm, that is {trim} mm from its end",
    "The gripper holds the end of the bar, out of the stations' reach (`layout.dead_zone`), and "
    "what is scrap there makes no part (`layout.end_trim`).",
)
BAR_SIZE = Rule(
    "verify-bar-size",
    _E,
    "found a bar of {found} mm; expected {least} to {greatest} mm",
    "The machine cannot hold another one (`layout.min_bar`, `layout.max_bar`).",
)
BAR_LEFT = Rule(
    "verify-bar-left",
    _E,
    "found {found} mm of bar from the start of {mark} on; expected at least {expected} mm",
    "The remnant of the bar pushes its last part, so it has to reach between the rollers "
    "(`layout.min_bar_left`).",
)
BAR_NEEDED = Rule(
    "verify-bar-needed",
    Severity.NOTE,
    "the length of the bar is not in the program; {found} mm are needed, of which its end takes "
    "{trim} mm; whether the bar is as long was not checked, give it by --bar",
    "How much of a bar the gripper holds, the machine file says; how long the bar is, only the "
    "user.",
)
BAR_TOLD = Rule(
    "verify-bar-told",
    _E,
    "found a program that needs a bar of {found} mm; expected at most the "
    "{expected} mm of the plan",
    "The plan tells which bar to load, the read-back works out which the program needs. It is a "
    "fault of beamcam; send in the part.",
)
STOCK = Rule(
    "verify-stock",
    _E,
    "found a section of {found}; expected {expected}",
    "The machine does not hold or reach round any other (`layout.profiles`, and `max_height` and "
    "`max_width` of saw and drill).",
)
SAW_REACH = Rule(
    "verify-saw-reach",
    _E,
    "found a cut of {angle} degrees through a section of {found} mm; expected at most {expected} "
    "mm (height x width), as the blade reaches at that angle",
    "A blade that is turned reaches less far across (`saw.max_sections`).",
)
NO_TOOL = Rule(
    "verify-no-tool",
    _E,
    "found {found} chosen; expected a tool that the shop has, {expected}",
    "No station can hold it, whatever hole it would fit.",
)
HOLE_STEEL = Rule(
    "verify-hole-steel",
    _E,
    "found the {what} on face {face} of {mark} at x {x}, y {y} {found}; expected {expected}",
    "A drill that meets another wall, an edge or another hole runs off or breaks.",
)
RULES = (
    STOCK, SAW_REACH, NO_TOOL, HOLE_STEEL, PART_SHORT, BAR_START, BAR_END, BAR_SIZE, BAR_LEFT,
    BAR_NEEDED, BAR_TOLD,
)  # fmt: skip
