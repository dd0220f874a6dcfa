"""Marks: what a part is called by, and which of a machine's policies a feature falls under."""

from collections.abc import Iterable
from pathlib import PurePath
from typing import Literal

from msgspec.structs import replace

from beamcam.machine.marking import Marks, Policy
from beamcam.model.part import Contour, Feature, Hole, Part, TextMark

MarkFrom = Literal["mark", "drawing", "file", "position"]
MARKS_FROM: tuple[MarkFrom, ...] = ("mark", "drawing", "file", "position")
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


def marked(parts: Iterable[Part], source: MarkFrom) -> tuple[Part, ...]:
    """Parts with the mark that stands elsewhere: as a drawing number, a file's name, a position.

    Offices that keep one word in the field of the mark have it there; the position is the third
    line of a DSTV header, the phase. Where nothing stands in that place the mark is kept.
    """
    if source == "mark":
        return tuple(parts)
    return tuple(replace(part, mark=_other_mark(part, source) or part.mark) for part in parts)


def _other_mark(part: Part, source: MarkFrom) -> str:
    if source == "file":
        return PurePath(part.source.file.replace("\\", "/")).stem
    return part.drawing if source == "drawing" else part.phase
