"""Which of a machine's policies on marks a feature falls under."""

from typing import Literal

from beamcam.machine.marking import Marks, Policy
from beamcam.model.part import Contour, Feature, Hole, TextMark

MarkKind = Literal["text", "points", "contours"]


def mark_kind(feature: Feature) -> MarkKind | None:
    """The key of `[marks]` that applies to a feature; None if it is not a mark.

    The process of a line in a drawing follows from its layer and colour, not from a policy.
    """
    if isinstance(feature, Hole):
        return "points" if feature.kind == "mark" else None
    if isinstance(feature, Contour):
        seen = feature.layer is not None or feature.colour is not None
        return None if seen or feature.process == "cut" else "contours"
    return "text" if isinstance(feature, TextMark) else None


def policy_on(feature: Feature, marks: Marks) -> Policy | None:
    """A machine's policy for a mark; None for any other feature."""
    kind = mark_kind(feature)
    return None if kind is None else getattr(marks, kind)
