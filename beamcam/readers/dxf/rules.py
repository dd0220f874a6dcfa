"""Rules for DXF files: every code that this reader gives, with its reason."""

from beamcam.errors import error, note, warning

# fmt: off


# --- the file -------------------------------------------------------------------------------------
DWG = error("dxf-dwg",
    "found a DWG file ({found}), expected DXF: save the drawing as DXF",
    "DWG is a closed format; every program that writes it writes DXF too.")
NOT_DXF = error("dxf-not-dxf",
    "found a file that begins with {found!r}, expected the group 0 SECTION or binary DXF",
    "Another format under the suffix of DXF, or a download that went wrong.")
STRUCTURE = error("dxf-structure",
    "found a file that is damaged beyond repair ({found}), expected a DXF file",
    "Sections that are cut off and groups without a value cannot be trusted.")
TRUNCATED = error("dxf-truncated",
    "found {found!r} as the last line, expected EOF: the file is cut short",
    "Entities may be missing after the place where the file was cut.")
NO_EOF = warning("dxf-no-eof",
    "found the end of the file after a whole section, expected EOF there",
    "Some programs forget the last two lines; nothing is missing if the sections are whole.")
RECOVERED = warning("dxf-recovered",
    "found a damaged file and repaired it: {count} corrections, the first: {found}",
    "Look whether the drawing is complete; saving it again in the program that made it helps.")
SUBCLASSES = warning("dxf-subclasses",
    "found {count} polylines or splines without their subclass marker (group 100); expected one, "
    "read them by their group codes",
    "Programs that write DXF by hand leave the markers out, and most that read it do not look for "
    "them.")

# --- units ----------------------------------------------------------------------------------------
UNITS_MISSING = warning("dxf-units-missing",
    "found {found}, expected a unit; mm assumed, --units says another",
    "The file does not say what its numbers are; a drawing in inches would come out 25.4 times too "
    "small.")
UNITS_UNKNOWN = error("dxf-units-unknown",
    "found $INSUNITS {found}, expected one of {expected}; give --units",
    "The number stands for no unit that a part can be drawn in.")
UNITS_CONTRADICT = error("dxf-units-contradict",
    "found a dimension of {stated} where the drawing measures {measured:g} in {unit}, that is "
    "{size:g} mm; expected both to be one length: give --units",
    "The unit of the header and the unit of the dimensions differ by a factor between two units.")
UNITS_IMPERIAL = warning("dxf-units-feet",
    "found lengths shown in feet and inches ($LUNITS {found}) in a drawing in {unit}",
    "The drawing was made for inches; check a known length.")

# --- what is cut ----------------------------------------------------------------------------------
NOT_CUT = warning("dxf-not-cut",
    "found {found}, which no tool follows; expected curves only",
    "Text, hatches and dimensions are no paths; explode them to curves if they shall be cut.")
EMPTY_CURVES = note("dxf-empty-curves",
    "found {found} of no length and left them out",
    "Points drawn as lines or circles of radius 0 are remains of editing.")
EDGE_ON = warning("dxf-edge-on",
    "found {found} that stand upright on the plane of the drawing and left them out",
    "Seen from above such a curve is a line drawn twice.")
NOT_FLAT = warning("dxf-not-flat",
    "found heights from {low:g} to {high:g} mm, expected a flat drawing; projected along Z",
    "The projection shortens sloping curves.")
ENTITY = error("dxf-entity",
    "found {kind} that cannot be read ({found}), expected a curve",
    "A part of the drawing would be missing.")
FIT_SPLINE = warning("dxf-fit-spline",
    "found a spline given by {count} fit points only; the curve between them is interpolated",
    "The file does not hold the curve that the drawing program showed, a cubic spline; with --fit "
    "newton=LAYER it is the polynomial through the points.")
HIDDEN = note("dxf-hidden",
    "found {count} curves on layers that are off, frozen, not plotting or not chosen: {found}",
    "They are not read; name their layers with --layers to read them.")

# --- blocks ---------------------------------------------------------------------------------------
BLOCK_MISSING = warning("dxf-block-missing",
    "found an insert of block {found!r}, which the file does not hold",
    "An external reference that was not bound, or a damaged file: what it shows is not read.")
BLOCK_CYCLE = error("dxf-block-cycle",
    "found block {found!r} inside itself, expected blocks that end",
    "Expanding such a block would never end.")
BLOCK_COUNT = error("dxf-block-count",
    "found {found} copies of blocks, expected at most {expected}",
    "An array of that size is a damaged number, or blocks multiply each other.")
FROZEN_INSERT = warning("dxf-frozen-insert",
    "found an insert on the hidden layer {layer!r} with curves on visible layers, which are read",
    "Some programs hide all of a block with its insert, others only what lies on layer 0.")
