"""Rules for SVG files: every code that this reader gives, with its reason."""

from beamcam.errors import error, note, warning

# fmt: off


# --- the file -------------------------------------------------------------------------------------
XML = error("svg-xml",
    "found text that is no XML ({found}), expected an SVG drawing",
    "The file was cut short or damaged; what comes after that place is lost.")
NOT_SVG = error("svg-not-svg",
    "found the element {found!r}, expected svg",
    "The file is XML, but no drawing.")
DEPTH = error("svg-depth",
    "found elements deep inside one another; expected at most {expected} levels",
    "No drawing program nests so deep; the file is damaged, or an element uses itself.")

# --- size -----------------------------------------------------------------------------------------
PERCENT = error("svg-percent",
    "found the size {found!r}, which is no length, expected mm or inches: give --width or export "
    "with a size",
    "A page as wide as its window has no size of its own.")
NO_SIZE = error("svg-no-size",
    "found no {found}, expected the size of the page: give --width or --units",
    "Without it nothing says how long a unit of the drawing is.")
SIZE = error("svg-size",
    "found {found}, expected {expected}",
    "The size of the page or of what it shows cannot be read.")
CONTRADICT = error("svg-size-contradict",
    "found {first} mm for a unit by {first_by} and {second} mm by {second_by}, expected one scale: "
    "give --units or --width",
    "Two sizes of the file deny each other; either of them could be the wrong one.")
PIXELS = error("svg-px",
    "found a drawing in px ({found}) and nothing that says how many make an inch; expected --units "
    "px96, px90 or px72, or --width",
    "Programs wrote 72, 90 and 96 px an inch; the part would come out up to a third too small.")
PIXELS_BY_WRITER = warning("svg-px-writer",
    "found a drawing in px ({found}); {dpi} px an inch, as {writer} writes it; --units px96, px90 "
    "or px72 says another",
    "A px is no length by itself; check a known length.")

# --- elements -------------------------------------------------------------------------------------
PATH = error("svg-path",
    "found {found!r} in path data, expected {expected}",
    "What follows in the path would be missing.")
NUMBER = error("svg-number",
    "found {attribute}={found!r}, expected {expected}",
    "The shape would be missing or have another size.")
TRANSFORM = error("svg-transform",
    "found transform {found!r}, expected {expected}",
    "The shape would lie in another place.")
HIDING = error("svg-css-hides",
    "found the style rule {found!r}, which hides what it names; expected element, .class, #id, or "
    "one of these below another",
    "What a browser does not show would be cut. Save the drawing as plain SVG, with attributes in "
    "place of style rules, or take the rule out.")
SELECTOR = warning("svg-css-selector",
    "found the style rule {found!r}, expected element, .class or #id; the rule is ignored",
    "Strokes that only this rule sets are not read.")
COLOUR = warning("svg-colour",
    "found stroke {found!r}, expected a colour; the contour is read without one",
    "No process can be assigned to a colour that cannot be read.")
USE = warning("svg-use",
    "found a use of {found!r}, which the file does not hold",
    "What it shows is not read.")
USES = error("svg-uses",
    "found too many uses of elements; expected at most {expected}",
    "Such a drawing grows beyond any memory when its uses are expanded.")
CLIPPED = warning("svg-clip",
    "found {count} elements that are clipped or masked; their paths are read whole",
    "A tool follows the path, not the part of it that a picture shows.")

# --- what is cut ----------------------------------------------------------------------------------
TEXT = warning("svg-text",
    "found {count} texts, which no tool follows; convert text to curves to have it cut",
    "A text holds no curves, only the name of a font.")
NOT_CUT = warning("svg-not-cut",
    "found {found}, which no tool follows; expected curves only",
    "Images and foreign objects are no paths.")
FILL_ONLY = warning("svg-fill-only",
    "found {count} shapes with a fill and no stroke, which are not cut",
    "A fill is engraved by a raster or means nothing; give shapes that shall be cut a stroke.")
INVISIBLE = note("svg-invisible",
    "found {count} shapes that do not show (hidden, of another layer, without stroke and fill) and "
    "are not read",
    "Invisible shapes are not cut.")
DASHED = note("svg-dashed",
    "found {count} dashed strokes, which are read as whole lines",
    "Dashes often mean a bend line; give those a colour of their own.")
HAIRLINE = note("svg-hairline",
    "found {count} strokes of width 0, which are read as hairlines",
    "A browser shows no such line, a laser driver cuts it.")
DEGENERATE = note("svg-empty-curves",
    "found {count} paths of no length and left them out",
    "Drawing programs leave such points behind.")
FLATTENED = warning("svg-flattened",
    "found {count} shapes whose transform presses them to a line; they are left out",
    "A scale of 0 leaves nothing to cut.")
