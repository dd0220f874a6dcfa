"""Rules for parts recovered from a program."""

from beamcam.errors import error, note, warning

# fmt: off

NO_PIECE = error("recover-no-piece",
    "found {cuts} saw cut(s) and no piece between two of them; expected the two ends of a part",
    "A part lies between two saw cuts; a program without them makes none.")
FACES = error("recover-faces",
    "found work on face {found} of a section whose thicknesses are not known; expected --profile "
    "with a part file or the name of a section",
    "Where the web lies follows from its thickness, which the program does not say.")
PROFILE = warning("recover-profile",
    "found a section {code} of {size} mm and no thicknesses; every hole is taken as a through "
    "hole: give --profile with a part file or the name of a section ({known})",
    "A program says of the section its kind, height and width, and those of several are alike.")
CATALOGUE = note("recover-section",
    "found a section {code} of {size} mm, taken as {name}, the only one of that size in the "
    "catalogue; --profile names another",
    "A program says of the section its kind, height and width only.")
PATH = error("recover-path",
    "found the path of a {kind} on face {face} at x {x:g}, y {y:g} that is neither a round hole "
    "nor a slot; expected a feature that a part has",
    "A part has round holes, and slots with round corners.")
SHEET = error("recover-thickness",
    "found no row of the machine for a sheet of {found} mm {material}; expected --thickness that a "
    "row covers",
    "What starts the tool, and the kerf, are those of the sheet's thickness.")
FITTED = warning("recover-thickness-fitted",
    "found the feeds and pierce times of a sheet of {found} mm; taken as such, --thickness gives "
    "another",
    "A program does not say how thick its sheet is. Thinner ones may have the same row of the cut "
    "chart.")
KERF = error("recover-kerf",
    "found a closed path of {found:.3f} mm2 that has no room for half a kerf of {kerf:g} mm; "
    "expected a contour around which the beam can go",
    "The contour lies half a kerf beside the path, on the part's side.")
CROWDED = error("recover-crowded",
    "found closed paths that cross or cover each other at about {found} places; expected contours "
    "that lie beside or inside one another",
    "What lies inside of what cannot be told, and the work would grow with every crossing.")
BY_HAND = warning("recover-by-hand",
    "found {found} mark(s) left for manual work; they are not in the recovered part",
    "The machine does not make the marks on the list of manual work, so the program does not say "
    "what they are. The list is the `.hand.csv` beside the program.")

RULES = (NO_PIECE, FACES, PROFILE, CATALOGUE, PATH, SHEET, FITTED, KERF, CROWDED, BY_HAND)
