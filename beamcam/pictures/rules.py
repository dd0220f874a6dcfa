"""Rules for pictures."""

from beamcam.errors import error

# fmt: off

NEEDS = error("picture-needs",
    "found {found}; expected it for {what}: pip install beamcam[pictures]",
    "The library that writes the format is not installed; SVG and HTML need none.")

RULES = (NEEDS,)
