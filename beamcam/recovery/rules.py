"""Rules of recovery: every code that it gives, with its reason."""

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
MANUAL_WORK = warning("recover-by-hand",
    "found {found} mark(s) left for manual work; they are not in the recovered part",
    "The machine does not make the marks and bevels on the list of manual work, so the program "
    "does not say what they are. The list is the `.hand.csv` beside the program.")
LEFT_OUT = warning("recover-left-out",
    "found {found} feature(s) left out of the program; they are not in the recovered part",
    "The head counts what --allow-skips left out, and says neither what it is nor where.")
UNNAMED = error("recover-unnamed-section",
    "found the section {found} in the program's head; expected one of the catalogue, or --profile "
    "with a part file or the name of a section",
    "Where the walls are below the torch follows from the section, whose thicknesses a program "
    "does not say.")
TILTED = error("recover-tilted",
    "found a cut with the torch tilted to B {found}; expected those of an end to lie in one plane, "
    "or each along an edge that is cut square besides",
    "Skew ends and bevels are recovered where nothing else is tilted. The part is in the file that "
    "the program was posted from.")
COMES_CUT = error("recover-comes-cut",
    "found a program for a piece that comes cut; expected one that cuts the part from a bar",
    "Its ends, and what another machine made, are not in the program. The part is in the rest file "
    "that it was posted from.")
NOT_PARTED = error("recover-not-parted",
    "found no piece of face {face} that the cuts part from both ends of the bar, beside the scrap "
    "in which they begin; expected the wall of a part",
    "The part is what lies between the cut of the near end and that of the far end. A cut is "
    "pierced, or begins on an edge, in what is scrap.")
REFITTED = note("recover-refitted",
    "found {count} contour(s) of chords, taken as lines and arcs within {within} mm of the cut",
    "A torch that goes round a profile runs along chords, and the program does not say what curves "
    "they replace.")
ROUNDED = note("recover-rounded",
    "found {count} re-entrant corner(s) with the machine's own radius of {radius} mm, which may "
    "have been drawn sharp",
    "The torch cuts a corner that is drawn sharp with coper.corner_radius; a radius that is drawn "
    "looks the same.")
CORNER = error("recover-corner",
    "found a line that ends or turns back in the corner between faces {found}; expected lines that "
    "go over it, or a cut-out that reaches into it from one face",
    "What is cut round a corner of a rectangular tube is given as contours of the faces beside it, "
    "which have to go on over it.")
