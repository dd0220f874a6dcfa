"""Rules for DXF files: every code that this reader gives, with its reason."""

from beamcam.errors import Rule, rule_makers

_error, _warning, _note = rule_makers("dxf")

# --- the file -------------------------------------------------------------------------------------
DWG = _error(
    "dwg",
    "found a DWG file ({found}), expected DXF: save the drawing as DXF",
    "DWG is a closed format; every program that writes it writes DXF too.",
)
NOT_DXF = _error(
    "not-dxf",
    "found a file that begins with {found!r}, expected the group 0 SECTION or binary DXF",
    "Another format under the suffix of DXF, or a download that went wrong.",
)
STRUCTURE = _error(
    "structure",
    "found a file that is damaged beyond repair ({found}), expected a DXF file",
    "Sections that are cut off and groups without a value cannot be trusted.",
)
TRUNCATED = _error(
    "truncated",
    "found {found!r} as the last line, expected EOF: the file is cut short",
    "Entities may be missing after the place where the file was cut.",
)
NO_EOF = _warning(
    "no-eof",
    "found the end of the file after a whole section, expected EOF there",
    "Some programs forget the last two lines; nothing is missing if the sections are whole.",
)
RECOVERED = _warning(
    "recovered",
    "found a damaged file and repaired it: {count} corrections, the first: {found}",
    "Look whether the drawing is complete; saving it again in the program that made it helps.",
)
SUBCLASSES = _warning(
    "subclasses",
    "found {count} polylines or splines without their subclass marker (group 100); expected one, "
    "read them by their group codes",
    "Programs that write DXF by hand leave the markers out, and most that read it do not look for "
    "them.",
)

# --- units ----------------------------------------------------------------------------------------
UNITS_MISSING = _warning(
    "units-missing",
    "found {found}, expected a unit; mm assumed, --units says another",
    "The file does not say what its numbers are; a drawing in inches would come out 25.4 times "
    "too small.",
)
UNITS_UNKNOWN = _error(
    "units-unknown",
    "found $INSUNITS {found}, expected one of {expected}; give --units",
    "The number stands for no unit that a part can be drawn in.",
)
UNITS_CONTRADICT = _error(
    "units-contradict",
    "found a dimension of {stated} where the drawing measures {measured:g} in {unit}, that is "
    "{size:g} mm; expected both to be one length: give --units",
    "The unit of the header and the unit of the dimensions differ by a factor between two units.",
)
UNITS_IMPERIAL = _warning(
    "units-feet",
    "found lengths shown in feet and inches ($LUNITS {found}) in a drawing in {unit}",
    "The drawing was made for inches; check a known length.",
)

# --- what is cut ----------------------------------------------------------------------------------
NOT_CUT = _warning(
    "not-cut",
    "found {found}, which no tool follows; expected curves only",
    "Text, hatches and dimensions are no paths; explode them to curves if they shall be cut.",
)
EMPTY_CURVES = _note(
    "empty-curves",
    "found {found} of no length and left them out",
    "Points drawn as lines or circles of radius 0 are remains of editing.",
)
EDGE_ON = _warning(
    "edge-on",
    "found {found} that stand upright on the plane of the drawing and left them out",
    "Seen from above such a curve is a line drawn twice.",
)
NOT_FLAT = _warning(
    "not-flat",
    "found heights from {low:g} to {high:g} mm, expected a flat drawing; projected along Z",
    "The projection shortens sloping curves.",
)
ENTITY = _error(
    "entity",
    "found {kind} that cannot be read ({found}), expected a curve",
    "A part of the drawing would be missing.",
)
FIT_SPLINE = _warning(
    "fit-spline",
    "found a spline given by {count} fit points only; the curve between them is interpolated",
    "The file does not hold the curve that the drawing program showed, a cubic spline; with "
    "--fit newton=LAYER it is the polynomial through the points.",
)
HIDDEN = _note(
    "hidden",
    "found {count} curves on layers that are off, frozen, not plotting or not chosen: {found}",
    "They are not read; name their layers with --layers to read them.",
)

# --- blocks ---------------------------------------------------------------------------------------
BLOCK_MISSING = _warning(
    "block-missing",
    "found an insert of block {found!r}, which the file does not hold",
    "An external reference that was not bound, or a damaged file: what it shows is not read.",
)
BLOCK_CYCLE = _error(
    "block-cycle",
    "found block {found!r} inside itself, expected blocks that end",
    "Expanding such a block would never end.",
)
BLOCK_COUNT = _error(
    "block-count",
    "found {found} copies of blocks, expected at most {expected}",
    "An array of that size is a damaged number, or blocks multiply each other.",
)
FROZEN_INSERT = _warning(
    "frozen-insert",
    "found an insert on the hidden layer {layer!r} with curves on visible layers, which are read",
    "Some programs hide all of a block with its insert, others only what lies on layer 0.",
)

RULES: tuple[Rule, ...] = tuple(
    value for value in list(globals().values()) if isinstance(value, Rule)
)
