"""Marks that a machine's file leaves to the hand, or refuses."""

from beamcam.errors import Diagnostic
from beamcam.machine.marking import Marks
from beamcam.model.marks import mark_kind, policy_on
from beamcam.model.part import Contour, Feature, TextMark
from beamcam.planning import rules

BY_POLICY = "marks"  #: in the ledger: listed for the hand, as the machine file says
#: Why a mark is left to the hand, by its name in the ledger.
REASONS = {BY_POLICY: "the machine's file leaves such marks to the hand"}


def is_listed(feature: Feature, marks: Marks) -> bool:
    """Whether the machine's file leaves a feature to the hand."""
    policy = policy_on(feature, marks)
    return policy == "list" or (policy == "make" and isinstance(feature, TextMark))


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
