"""Pipes that are written as plates: the unrolled surface, as wide as the circumference."""

import re
from math import pi

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.model.part import Part, Profile
from beamcam.planning.coping import rules
from beamcam.planning.sheet import PIPE

#: A size in a name: 168.3, 6, 1-1/2 or 3/4.
_SIZE = re.compile(r"(?:([0-9]+)[- ])?([0-9]+)/([0-9]+)|([0-9]+(?:\.[0-9]+)?)")
SLACK = 0.5  #: mm between a diameter in a name and that of the width
INCH = 25.4
#: Outside diameter of pipes by their nominal size, both in inches (ASME B36.10M, table 1).
NOMINAL = {
    0.125: 0.405, 0.25: 0.54, 0.375: 0.675, 0.5: 0.84, 0.75: 1.05, 1.0: 1.315, 1.25: 1.66,
    1.5: 1.9, 2.0: 2.375, 2.5: 2.875, 3.0: 3.5, 3.5: 4.0, 4.0: 4.5, 5.0: 5.563, 6.0: 6.625,
    8.0: 8.625, 10.0: 10.75, 12.0: 12.75,
}  # fmt: skip


def as_pipe(part: Part) -> tuple[Part, Diagnostic | None]:
    """A part as the pipe that its plate is the surface of, and what is said of it.

    Any other part comes back as it is, and so does a plate whose name has another diameter.
    """
    profile = part.profile
    if profile.code != "B" or not PIPE.match(profile.name):
        return part, None
    diameter = profile.height / pi
    named = _diameters(profile.name)
    values = {"found": profile.name, "height": f"{profile.height:g}"}
    if named and min(abs(one - diameter) for one in named) > SLACK:
        nearest = min(named, key=lambda one: abs(one - diameter))
        expected = f"{pi * nearest:.2f}"
        return part, rules.NO_PIPE.at(
            part.source, diameter=f"{nearest:g}", expected=expected, **values
        )
    wall = profile.web_thickness or 0.0
    pipe = Profile("RO", profile.name, diameter, diameter, wall, wall)
    said = rules.PIPE.at(part.source, diameter=f"{diameter:.2f}", **values)
    return replace(part, profile=pipe), said


def _diameters(name: str) -> tuple[float, ...]:
    """The diameters that a name may mean, in mm; none where it has no size.

    The first size is a diameter in mm or in inches, or a nominal one: PIPE1-1/2SCH40 is 1.9 inches
    wide.
    """
    size = _SIZE.search(name)
    if size is None or (size[3] is not None and not float(size[3])):
        return ()
    value = float(size[4]) if size[4] else float(size[1] or 0) + float(size[2]) / float(size[3])
    inches = (value, NOMINAL.get(value, value))
    return (value, *(INCH * one for one in inches))
