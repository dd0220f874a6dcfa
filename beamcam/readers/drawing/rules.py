"""Rules for drawings of any format, and for their options."""

from beamcam.errors import Rule, error, note, warning

# fmt: off

UNITS_OPTION = error("drawing-units-option",
    "found unit {found!r}, expected one of {expected}",
    "The option --units names the unit of the drawing's numbers.")
WIDTH_OPTION = error("drawing-width-option",
    "found width {found!r}, expected a length above 0 such as 600mm or 24in",
    "The option --width gives the width of the page, where the file does not say it.")
LAYER_OPTION = error("drawing-layer-option",
    "found no layer {found!r}; expected one of the drawing's: {expected}",
    "The option --layers names the layers to read; a misspelt name would lose a part of them.")
NO_CURVES = error("drawing-empty",
    "found no curve that a tool could follow ({found}), expected at least one",
    "Everything is text, hidden, or on a sheet of paper space, or the export went wrong.")
TOO_LARGE = warning("drawing-large",
    "found a drawing of {width:.0f} x {height:.0f} mm in the unit {unit}; check the unit, --units "
    "overrides it",
    "Programs write metres as their default unit into drawings that are meant in mm.")
FIT_LAYER = error("drawing-fit-layer",
    "found {found}, expected --fit newton=LAYER with polylines on one of the layers {expected}",
    "The option --fit names the layers whose polylines are the nodes of polynomials.")
FIT_NODES = error("drawing-fit-nodes",
    "found a polyline that is no polynomial ({found}), expected vertices apart from each other",
    "A polynomial needs a place of its own for each of its nodes.")
FITTED = note("drawing-fitted",
    "found {count} polylines on layer {layer!r}, now polynomials through their vertices; {kept} "
    "other contours there stay as they are drawn",
    "This is what --fit newton=LAYER asked for; single lines and polylines with arcs are kept.")

WRAP_NAME = error("drawing-wrap-option",
    "found the tube {found!r}; expected its diameter and its wall in mm, as RO168.3x8",
    "The option --wrap names the round tube whose unrolled surface is drawn.")
WRAP_WIDE = error("drawing-wrap",
    "found a largest outline of {found} mm; expected one {expected} mm wide, the circumference of "
    "{tube}",
    "--wrap takes a drawing as the unrolled surface of a tube: one closed outline of all of it, as "
    "wide as the tube is round, and what is cut out of it. Another unit (--units) or another tube "
    "is meant.")
WRAPPED = note("drawing-wrapped",
    "taken as the unrolled outside of {tube}{how}: x along it, y round it from its lowest line",
    "This is what --wrap asked for. All that is closed is cut out; --layers leaves other lines.")

RULES: tuple[Rule, ...] = (
    UNITS_OPTION, WIDTH_OPTION, LAYER_OPTION, NO_CURVES, TOO_LARGE, FIT_LAYER, FIT_NODES, FITTED,
    WRAP_NAME, WRAP_WIDE, WRAPPED,
)  # fmt: skip
