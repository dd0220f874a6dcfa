"""What a saw cut can be refused for: the blade's reach, and two ends that cross."""

from collections.abc import Iterator

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Saw, SawSection
from beamcam.model.part import Part
from beamcam.planning.bar import Ends, saw_angles
from beamcam.planning.ends import corners
from beamcam.planning.operations import rules

TOUCH = 0.01  #: mm; ends that are as near meet in a point


def judge_ends(part: Part, ends: Ends, saw: Saw) -> Iterator[Diagnostic]:
    """What is wrong, or odd, about the two ends of a part together and one by one."""
    start, end = ends
    if not (start.is_square and end.is_square):
        left, y, z = min((end.x(y, z) - start.x(y, z), y, z) for y, z in corners(part.profile))
        if left < -TOUCH:
            yield rules.CUTS_CROSS.at(part.source, found=f"{-left:.3f}", y=f"{y:g}", z=f"{z:g}")
        elif left <= TOUCH:
            yield rules.CUTS_TOUCH.at(part.source, y=f"{y:g}", z=f"{z:g}")
    if not saw.max_sections:
        return
    height, width = part.profile.height, part.profile.width
    for each in ends:
        angle = saw_angles(each, saw)[0]
        reach = _reach_at(abs(angle - saw.square), saw)
        if reach is None or (height <= reach.max_height and width <= reach.max_width):
            continue
        yield rules.SAW_REACH.at(
            part.source, found=f"{height:g} x {width:g}", angle=f"{angle:g}", end=each.at,
            expected=f"{reach.max_height:g} x {reach.max_width:g}",
        )  # fmt: skip


def _reach_at(off_square_deg: float, saw: Saw) -> SawSection | None:
    """The row of the machine for an angle; the last one beyond all of them."""
    rows = sorted(saw.max_sections, key=lambda row: row.max_angle)
    fitting = (row for row in rows if off_square_deg <= row.max_angle + 1e-9)
    return next(fitting, rows[-1] if rows else None)
