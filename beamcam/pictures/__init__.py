"""Pictures of parts, programs and profiles.

part (model)                         -> scene -> SVG, PDF (reportlab) or PNG (Pillow)
machined features (verify), trace (simulate)

A scene is data: lines, circles and texts on paper, each of a named style. A picture of a program is
drawn from what the read-back's interpreter found in its text, and carries the hash of that text.
"""

from beamcam.errors import error

# fmt: off

NEEDS = error("picture-needs",
    "found {found}; expected it for {what}: pip install beamcam[pictures]",
    "The library that writes the format is not installed; SVG and HTML need none.")

SECTION = error("picture-section",
    "found the section {found} in the program's head; expected one of the catalogue, or the part: "
    "plot PART --show program --machine {machine}",
    "Where the torch is over the steel depends on the section, which a program does not say.")
