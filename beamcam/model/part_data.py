"""Data of parts and jobs, as texts for the words of a machine."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import PurePath

from beamcam.model.part import Part

#: Names that words may carry (`PART_NAMES` of machine.words), each with a value to try it out.
PART_DATA: Mapping[str, str] = {
    "mark": "M58", "name": "M58", "profile": "IPE300", "grade": "S355", "length": "4200",
    "quantity": "4", "order": "1", "drawing": "1", "phase": "1", "date": "2024-02-29",
}  # fmt: skip


def part_data(parts: Sequence[Part]) -> dict[str, str]:
    """The data of the parts of a program; of several that differ, joined by +. Lengths in mm.

    The date of the job is not among them: see `posts.Job`.
    """
    return {
        "mark": _joined(part.mark for part in parts),
        "name": _joined(PurePath(part.source.file).stem for part in parts),
        "profile": _joined(part.profile.name for part in parts),
        "grade": _joined(part.grade for part in parts),
        "length": _joined(f"{part.length:g}" for part in parts),
        "quantity": _joined(str(part.quantity) for part in parts),
        "order": _joined(part.order for part in parts),
        "drawing": _joined(part.drawing for part in parts),
        "phase": _joined(part.phase for part in parts),
    }


def _joined(texts: Iterable[str]) -> str:
    return "+".join(dict.fromkeys(texts))
