"""Marks that a machine file leaves for manual work or refuses, and remarks on texts."""

from beamcam.errors import Diagnostic, error, note, warning
from beamcam.machine.marking import Marks
from beamcam.model.description import mark_kind, policy_on
from beamcam.model.part import Contour, Feature, TextMark
from beamcam.planning import rules

TEXT_MOVED = warning("plan-text-moved",
    "the text {text!r} is lettered at x {x}, y {y}, {height} mm high; found no room {distance} mm "
    "clear at x {wanted_x}, y {wanted_y}, {wanted_height} mm high",
    "Letters on an edge or over a hole cannot be read. `marks.min_distance` and `marks.min_height` "
    "of the machine file say how much room is kept, and how small letters may be.")  # fmt: skip
TEXT_SIGN = warning("plan-text-sign",
    "found {sign!r} in the text {text!r}; expected a character of {has}, {other!r} is written",
    "`marks.replace` of the machine file says what is written for a character that no letter of "
    "the font, or of the stamp or printer, stands for.")  # fmt: skip
TEXT_HEIGHT = note("plan-text-height",
    "found the text {text!r} {found} mm high; it is lettered {height} mm high, the nearest of the "
    "machine's",
    "`marks.heights` of the machine file says in which heights its stamp or printer "
    "letters.")  # fmt: skip
TEXT_SEARCH = error("plan-text-search",
    "found no end of the search for a place of the text {text!r} on face {face} in {most} steps; "
    'expected room where the part has it, fewer texts, or text = "list" in [marks]',
    "A text is moved to the nearest place that is clear. Among hundreds of texts or holes that may "
    "take for ever; so that none is left out that has a place, the part is refused.")  # fmt: skip
RULES = (TEXT_MOVED, TEXT_SIGN, TEXT_HEIGHT, TEXT_SEARCH)

#: Why a mark is left for manual work, by its name in the ledger.
BY_POLICY, NO_UNIT = "marks", "no-unit"
NO_ROOM, TOO_SMALL, BLANK, FACE = "no-room", "too-small", "blank", "face"
CHARACTERS, ANGLE, HEIGHT = "characters", "angle", "height"
NOT_MOVED = "not-moved"
DRILL, BEVEL, ROOT = (
    "drill",
    "bevel",
    "root",
)  #: of a sheet's features that are only begun by the machine
REASONS = {
    BY_POLICY: "the machine file leaves such marks for manual work",
    NO_UNIT: "the machine has no unit that letters",
    NO_ROOM: "there is no room for it on its face",
    TOO_SMALL: "the machine does not letter so small",
    BLANK: "none of its characters can be seen",
    FACE: "the lettering unit does not reach that face",
    CHARACTERS: "the machine has no characters for it",
    ANGLE: "the machine does not letter at that angle",
    NOT_MOVED: "it is not clear of edges and holes there, and the machine moves no text",
    HEIGHT: "the machine does not letter at that height, which is binding",
    DRILL: "the torch cannot make it and marks its centre for the drill",
    BEVEL: "the torch cuts its bevelled edges square",
    ROOT: "the torch leaves steel along a flange, where it does not reach",
}


def listed_by(feature: Feature, marks: Marks) -> str | None:
    """Why a mark is manual work wherever it is; None if it is not."""
    policy = policy_on(feature, marks)
    if policy == "make" and isinstance(feature, TextMark) and marks.unit == "none":
        return NO_UNIT
    return BY_POLICY if policy == "list" else None


def refuse_mark(feature: Feature, marks: Marks) -> Diagnostic | None:
    """Why a mark is refused whatever the machine could do; None if it is not."""
    if policy_on(feature, marks) != "refuse":
        return None
    why = f'marks.{mark_kind(feature)} of the machine file is "refuse"'
    face = getattr(feature, "face", "")
    return rules.MARK.at(feature.source, found=_named(feature), face=face, why=why)


def _named(feature: Feature) -> str:
    match feature:
        case TextMark():
            return f"the text {feature.text!r}"
        case Contour():
            return f"{sum(curve.length for curve in feature.curves):g} mm of line"
        case _:
            return "a centre punch"
