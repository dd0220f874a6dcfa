"""Pipes that are written as plates: the unrolled surface, as wide as the circumference."""

import re
from math import pi

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.model.part import Part, Profile
from beamcam.planning.coping import rules
from beamcam.planning.sheet import PIPE

_SIZE = re.compile(r"[0-9]+(?:\.[0-9]+)?")
SLACK = 0.5  #: mm between a diameter in a name and that of the width


def as_pipe(part: Part) -> tuple[Part, Diagnostic | None]:
    """A part as the pipe that its plate is the surface of, and what is said of it.

    Any other part comes back as it is, and so does a plate whose name has another diameter.
    """
    profile = part.profile
    if profile.code != "B" or not PIPE.match(profile.name):
        return part, None
    diameter = profile.height / pi
    named = _SIZE.search(profile.name)
    values = {"found": profile.name, "height": f"{profile.height:g}"}
    if named is not None and abs(float(named[0]) - diameter) > SLACK:
        expected = f"{pi * float(named[0]):.2f}"
        return part, rules.NO_PIPE.at(part.source, diameter=named[0], expected=expected, **values)
    wall = profile.web_thickness or 0.0
    pipe = Profile("RO", profile.name, diameter, diameter, wall, wall)
    said = rules.PIPE.at(part.source, diameter=f"{diameter:.2f}", **values)
    return replace(part, profile=pipe), said
