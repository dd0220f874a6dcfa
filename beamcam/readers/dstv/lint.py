"""Cross-checks of a part that was read: does the file agree with itself?"""

from beamcam.model.part import Part
from beamcam.readers.dstv.contours import Rows
from beamcam.readers.dstv.tokens import Log


def check(part: Part, contours: list[Rows], log: Log) -> None:
    """Add what contradicts itself in `part` to the log."""
