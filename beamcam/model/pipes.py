"""Pipes that are written as plates: the unrolled surface, as wide as the pipe is round.

Exporters of DSTV do so (Tekla: "Unroll round tubes"), with the pipe's name: CHS88.9*5, O76.1*4.
Cut or sawn flat such a part is no pipe, so all machines have to know it.
"""

import re
from math import pi

from msgspec.structs import replace

from beamcam.model.part import Part, Profile

#: Names that only a pipe has, whatever the width.
_CALLED = re.compile(r"\s*(PIPE|CHS|TUBE)", re.IGNORECASE)
#: A size in a name: 168.3, 6, .25, 1-1/2 or 3/4.
_SIZE = re.compile(r"(?:([0-9]+)[- ])?([0-9]+)/([0-9]+)|([0-9]+(?:\.[0-9]+)?|\.[0-9]+)")
SLACK = 0.5  #: mm between a diameter in a name and that of the width
#: mm where the name has no wall: widths have two decimals, and no flat is a diameter in its name
#: times pi wide.
_ALONE = 0.03
_WALL = 0.1  #: share of the wall by which that of the name is off: US tubes are drawn 7 % thinner
INCH = 25.4
#: Outside diameter of pipes by their nominal size, both in inches (ASME B36.10M, table 1).
NOMINAL = {
    0.125: 0.405, 0.25: 0.54, 0.375: 0.675, 0.5: 0.84, 0.75: 1.05, 1.0: 1.315, 1.25: 1.66,
    1.5: 1.9, 2.0: 2.375, 2.5: 2.875, 3.0: 3.5, 3.5: 4.0, 4.0: 4.5, 5.0: 5.563, 6.0: 6.625,
    8.0: 8.625, 10.0: 10.75, 12.0: 12.75,
}  # fmt: skip


def is_unrolled(profile: Profile) -> bool:
    """Whether a plate is the surface of a pipe: by its name, or by the name's sizes and its width.

    Of any other name the first size is a diameter whose circumference the plate is wide, and the
    second, where there is one, the wall (mm or inches). A flat is never so wide as pi times a size
    in its name: that is its own width or its thickness.
    """
    if profile.code != "B":
        return False
    if _CALLED.match(profile.name):
        return True
    sizes, wall = _sizes(profile.name), profile.web_thickness or 0.0
    across = profile.height / pi
    if not sizes or not 2.0 * wall < across:
        return False
    for unit in (1.0, INCH):
        off = abs(unit * sizes[0] - across)
        walled = len(sizes) > 1 and abs(unit * sizes[1] - wall) <= _WALL * wall
        if off <= (SLACK if walled else _ALONE):
            return True
    return False


def rolled(part: Part) -> Part:
    """A plate that is the surface of a pipe as the tube whose circumference is its width.

    Any other part comes back as it is. What is on face v stays unrolled, as of a tube.
    """
    plate = part.profile
    if not is_unrolled(plate):
        return part
    across, wall = plate.height / pi, plate.web_thickness or 0.0
    return replace(part, profile=Profile("RO", plate.name, across, across, wall, wall))


def named_diameters(name: str) -> tuple[float, ...]:
    """The diameters that a pipe's name may mean, in mm; none where it has no size.

    The first size is a diameter in mm or in inches, or a nominal one: PIPE1-1/2SCH40 is 1.9 inches
    wide.
    """
    sizes = _sizes(name)
    if not sizes or not sizes[0]:
        return ()
    inches = (sizes[0], NOMINAL.get(sizes[0], sizes[0]))
    return (sizes[0], *(INCH * one for one in inches))


def _sizes(name: str) -> list[float]:
    """The sizes in a name, a mixed number as one."""
    return [
        float(whole) if whole else float(more or 0) + float(over) / float(under)
        for more, over, under, whole in _SIZE.findall(name)
        if whole or float(under)
    ]
