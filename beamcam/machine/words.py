"""Templates of a program's blocks, what each may name in braces, rules for machine files."""

from beamcam.conversion import Keys
from beamcam.errors import error, warning

# fmt: off

UNKNOWN_MACHINE = error("machine-unknown",
    "found no machine {found!r}; expected {expected}",
    "A machine is one of those shipped (`beamcam machines list`) or the path of a TOML file.")
NAME_TWICE = error("machine-name-twice",
    "found a machine of your own with the name {found!r} of one that is shipped; expected another "
    "name, of the file and of its key `name`",
    "Which of the two a job means would be a guess, and a program's head would name a machine that "
    "did not make it.")
NOT_TOML = error("machine-toml",
    "found no TOML ({found}); expected key = value, or a [table]",
    "The file breaks the rules of TOML at that line.")
UNKNOWN_KEY = error("machine-key",
    "found unknown key {found!r}; expected {expected}",
    "A misspelt limit would leave the machine without that limit, so no key is ignored.")
MISSING_KEY = error("machine-missing",
    "found no key {expected!r}; expected it, it is required",
    "The key has no default because a wrong guess could hurt the machine.")
WRONG_VALUE = error("machine-value",
    "found {found} for {key!r}; expected {expected}",
    "The value is of the wrong kind, out of its range, or names something that does not exist.")
WORD = error("machine-word",
    "in {key!r}, {said}",
    "The words of a machine file are tried on its controller before planning: a word that the "
    "read-back would refuse in every program is a fault of the file.")
BASE_LOOP = error("machine-base",
    "found the machine {found!r} among its own bases; expected another one",
    "A machine file may build on another by `base`, but not on itself.")

CHART = error("machine-chart",
    "found {found}; expected {expected}",
    "A row of a chart that is left out, or read as another thickness, would cut by wrong figures.")
FORMER_KEY = warning("machine-former-key",
    "found the key {found!r} of an older version; expected {expected!r}",
    "The key is read for one more minor version. Rename it in the file; nothing else changes.")
KEY_TWICE = error("machine-key-twice",
    "found {found!r}, the older name of {expected!r}, beside it; expected one of them",
    "Two names of one key could have two values. Remove the older one.")


# fmt: on


class Words(Keys, frozen=True):
    """The blocks of a program as templates with placeholders in braces."""

    header: tuple[str, ...] = ()  #: the first blocks
    footer: tuple[str, ...] = ()  #: the last blocks
    saw: tuple[str, ...] = ()  #: a cut
    drill: tuple[str, ...] = ()  #: a hole, from the choice of the spindle on
    tap: tuple[str, ...] = ()  #: a thread
    countersink: tuple[str, ...] = ()  #: a countersink
    punch: tuple[str, ...] = ()  #: a centre point
    mill: tuple[str, ...] = ()  #: from the choice of the spindle to the path's first point
    mill_to: tuple[str, ...] = ()  #: to each further point of the path
    mill_end: tuple[str, ...] = ()  #: from the last point back, and off
    scribe: tuple[str, ...] = ()  #: as mill
    scribe_to: tuple[str, ...] = ()  #: as mill_to
    scribe_end: tuple[str, ...] = ()  #: as mill_end
    stamp: tuple[str, ...] = ()  #: a text by a stamp
    printer: tuple[str, ...] = ()  #: a text by a printer
    change: tuple[str, ...] = ()  #: stop for a manual tool change
    comment: str = "({text})"  #: how the controller marks a comment

    traverse: tuple[str, ...] = ()  #: the head to a place, its tool off
    turn: tuple[str, ...] = ()  #: the torch of a coper about the bar, its tool off
    measured_height: tuple[str, ...] = ()  #: of a coper behind its header: the bar's, as measured
    measured_width: tuple[str, ...] = ()  #: likewise its width
    feed: tuple[str, ...] = ()  #: the tool along a line
    #: the torch of a coper along a line while it turns about the bar and tilts, its tool on
    feed_turning: tuple[str, ...] = ()
    arc_cw: tuple[str, ...] = ()  #: the tool along an arc, clockwise
    arc_ccw: tuple[str, ...] = ()  #: counter-clockwise
    parabola: tuple[str, ...] = ()  #: the tool along a parabola
    ellipse_cw: tuple[str, ...] = ()  #: the tool along an ellipse, clockwise
    ellipse_ccw: tuple[str, ...] = ()  #: counter-clockwise
    material: tuple[str, ...] = ()  #: the controller's choice of a row's data, before its contours
    #: the tool of the head that works, before the traverse to its place where another one worked
    choose_cut: tuple[str, ...] = ()
    choose_mark: tuple[str, ...] = ()  #: likewise to mark
    choose_engrave: tuple[str, ...] = ()  #: likewise to engrave
    cut_on: tuple[str, ...] = ()  #: the tool on to cut
    close: tuple[str, ...] = ()  #: the arc out where a cut is closed, on its overcut and behind
    cut_off: tuple[str, ...] = ()  #: and off
    mark_on: tuple[str, ...] = ()  #: the tool on to mark
    mark_off: tuple[str, ...] = ()  #: and off
    engrave_on: tuple[str, ...] = ()  #: the tool on to engrave
    engrave_off: tuple[str, ...] = ()  #: and off
    choose_spot: tuple[str, ...] = ()  #: as choose_mark, to spot
    spot_on: tuple[str, ...] = ()  #: the tool on to spot a centre where it stands
    spot_off: tuple[str, ...] = ()  #: and off
    left: tuple[str, ...] = ()  #: kerf compensation on: tool left of the contour
    right: tuple[str, ...] = ()  #: tool right of the contour
    straight: tuple[str, ...] = ()  #: kerf compensation off
    modal: tuple[str, ...] = ()  #: words of a move, each written when its value changes
    slow: tuple[str, ...] = ()  #: from the next move on slower than the row, as near a corner
    full: tuple[str, ...] = ()  #: and again at the feed of the row
    power: tuple[str, ...] = ()  #: another power from the next move on, in laser mode
    pace: tuple[str, ...] = ()  #: another feed from the next move on, where moves do not say it


def _names(text: str) -> frozenset[str]:
    return frozenset(text.split())


#: What is known of the part that work is on, and of the job.
PART_NAMES = _names("mark name profile grade length quantity order drawing phase date")
#: Templates of work on a part, in which `PART_NAMES` may stand besides the header.
WORK_WORDS = (
    "saw", "drill", "tap", "countersink", "punch", "mill", "mill_to", "mill_end", "scribe",
    "scribe_to", "scribe_end", "stamp", "printer", "cut_on", "cut_off", "mark_on", "mark_off",
    "engrave_on", "engrave_off", "spot_on", "spot_off",
)  # fmt: skip
_STROKE_NAMES = PART_NAMES | _names(
    "spindle tool tool_name station diameter x y z near_y near_z bottom_y bottom_z feed speed"
)
_TEXT_NAMES = PART_NAMES | _names("string x y height angle face")
_TO_NAMES = _names("x y feed")
_ARC_NAMES = _TO_NAMES | {"i", "j"}
_ELLIPSE_NAMES = _ARC_NAMES | {"angle", "ratio"}
_ROW_NAMES = _names("power pierce preheat feed pierce_height cut_height amps volts number")
_OFF_NAMES = PART_NAMES | {"clearance"}
_TORCH_NAMES = _OFF_NAMES | _ROW_NAMES | {"touch_height"}
_SIDE_NAMES = _names("kerf half_kerf")

#: What each template of `Words` may name.
WORD_NAMES: dict[str, frozenset[str]] = {
    "header": PART_NAMES | {"job", "section", "width", "height"}, "footer": frozenset(),
    "saw": PART_NAMES | frozenset({"x", "angle", "tilt", "feed"}),
    "drill": _STROKE_NAMES | {"peck"}, "tap": _STROKE_NAMES | {"pitch"},
    "countersink": _STROKE_NAMES, "punch": _STROKE_NAMES, "mill": _STROKE_NAMES,
    "mill_to": _STROKE_NAMES, "mill_end": _STROKE_NAMES, "scribe": _STROKE_NAMES,
    "scribe_to": _STROKE_NAMES, "scribe_end": _STROKE_NAMES, "stamp": _TEXT_NAMES,
    "printer": _TEXT_NAMES, "change": frozenset({"spindle", "station", "diameter", "text"}),
    "traverse": frozenset({"x", "y", "z"}), "turn": frozenset({"x", "y", "z", "a", "b"}),
    "measured_height": frozenset({"height"}), "measured_width": frozenset({"width"}),
    "feed": _TO_NAMES | {"z", "a", "inverse"},
    "feed_turning": frozenset({"x", "y", "z", "a", "b", "inverse"}),
    "arc_cw": _ARC_NAMES, "arc_ccw": _ARC_NAMES,
    "parabola": _ARC_NAMES, "ellipse_cw": _ELLIPSE_NAMES, "ellipse_ccw": _ELLIPSE_NAMES,
    "choose_cut": frozenset(), "choose_mark": frozenset(), "choose_engrave": frozenset(),
    "material": _ROW_NAMES | {"material_name", "thickness", "kerf", "nozzle"},
    "cut_on": _TORCH_NAMES, "close": frozenset(), "cut_off": _OFF_NAMES, "mark_on": _TORCH_NAMES,
    "mark_off": _OFF_NAMES, "engrave_on": _TORCH_NAMES, "engrave_off": _OFF_NAMES,
    "choose_spot": frozenset(), "spot_on": _TORCH_NAMES, "spot_off": _OFF_NAMES,
    "left": _SIDE_NAMES, "right": _SIDE_NAMES, "straight": frozenset(),
    "modal": frozenset({"feed", "acceleration"}), "slow": frozenset({"feed", "share"}),
    "full": frozenset({"feed"}), "pace": frozenset({"feed"}), "power": frozenset({"power"}),
    "comment": frozenset({"text"}),
}  # fmt: skip
