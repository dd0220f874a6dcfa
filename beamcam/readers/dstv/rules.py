"""Rules for DSTV files: every code that this reader gives, with its reason."""

from beamcam.errors import error, note, warning

# fmt: off


# --- the file ---------------------------------------------------------------------------------
NOT_DSTV = error("dstv-not-dstv",
    "found {found!r}, expected a DSTV file, which begins with a line ST",
    "Nothing in the file is a block of the standard: it is another format, or an invented one.")
NO_ST = error("dstv-no-st",
    "found {found!r}, expected the block ST before any other data",
    "Without its header a file says neither length nor section.")
BEFORE_ST = error("dstv-before-st",
    "found {count} lines of data before ST, the first {found!r}; expected comments only",
    "Data before the header belongs to no part; the file was joined or damaged.")
SECOND_ST = error("dstv-second-st",
    "found a second ST, expected one part in a file",
    "The standard allows one part in a file; split the file.")
NO_EN = error("dstv-no-en",
    "found the end of the file, expected EN: the file is cut short",
    "Features may be missing after the place where the file was cut.")
AFTER_EN = error("dstv-after-en",
    "found {found!r} after EN, expected nothing",
    "EN closes the file; formats with EN after every block are not DSTV.")
UNREAD = note("dstv-unread",
    "{count} more lines were not read, because the header could not be read",
    "How much of a refused file was not read.")
BLOCK_UNKNOWN = error("dstv-block-unknown",
    "found block {found!r} with {count} lines, expected one of ST BO SI AK IK PU KO SC TO UE PR KA "
    "IN EN or a plane block such as E1, B1",
    "The block is not of the standard, so what it asks for cannot be made.")
ROW_LOST = error("dstv-row-lost",
    "found {found!r} in {block}, which cannot be read; expected a row of the standard",
    "The row belongs to no block that the standard knows, so what it asks for cannot be made.")
BLOCK_REPEATED = error("dstv-block-repeated",
    "found another {block}, expected one in a file",
    "Two values for one thing contradict each other.")
ENCODING = note("dstv-encoding",
    "found text that is not ASCII, read as {encoding}; --encoding names another",
    "The standard allows ASCII only, and a file does not name its alphabet. It is guessed from the "
    "letters; marks and profile names may show other characters than meant.")
INDENT = note("dstv-indent",
    "found a data line without its two leading blanks, read by its position",
    "The standard begins data lines with two blanks.")
CODE_CASE = warning("dstv-code-case",
    "found block code {found!r}, read as {block}",
    "Codes are written in capitals.")
CODE_ZERO = warning("dstv-code-zero",
    "found block B0 without a plane E0, read as BO",
    "A zero was written for the letter O.")
CODE_INDENT = note("dstv-code-indent",
    "found block code {block} behind blanks, expected it in column 1",
    "Data lines begin with blanks, codes do not.")
COMMENT_INLINE = note("dstv-comment-inline",
    "found a comment behind data, kept as a line of its own before it",
    "A comment is a line that begins with two stars.")
DECIMAL_COMMA = warning("dstv-decimal-comma",
    "found {found!r}, read as {value:g}",
    "The decimal sign is a point.")

# --- the header -------------------------------------------------------------------------------
HEADER_SHORT = error("dstv-header-short",
    "found {found!r} after {count} header lines, expected at least 20",
    "Header lines count by their position, so a missing one shifts all after it.")
HEADER_EXTRA = note("dstv-header-extra",
    "found {found!r} as header line {number}, expected at most 24; kept as a text",
    "The header has four text lines.")
HEADER_NUMBER = error("dstv-header-number",
    "header line {number} ({name}): found {found!r}, expected a number{limits}",
    "A dimension or cut angle cannot be read. A cut at 90 degrees would run along the part.")
HEADER_BLANK = note("dstv-header-blank",
    "header line {number} ({name}) is blank, read as 0",
    "The standard asks for a number.")
LENGTH = error("dstv-length",
    "found length {found!r}, expected a positive number, or two with a comma between",
    "Header line 9 is `Length[,Saw length]`.")
SAW_LENGTH = warning("dstv-saw-length",
    "found saw length {saw:g} below length {length:g}",
    "The stock cannot be shorter than the part; some programs swap the two.")
QUANTITY = error("dstv-quantity",
    "found quantity {found!r}, expected a whole number",
    "Header line 6 says how many pieces to make.")
QUANTITY_FORM = warning("dstv-quantity-form",
    "found quantity {found!r}, read as {value}",
    "The quantity is a whole number of at least 1.")
PROFILE_CODE = error("dstv-profile-code",
    "found profile code {found!r}, expected one of I U L M RO RU C T B SO",
    "The code says which faces a part has.")
PROFILE_CASE = warning("dstv-profile-case",
    "found profile code {found!r}, read as {code}",
    "Codes are written in capitals.")
WEIGHT = warning("dstv-weight",
    "header line {number} ({name}): found {found!r}, expected a number; read as 0",
    "Weight and surface do not change what is made, but for corners (dstv-corner-weight).")
WEIGHT_SECTION = note("dstv-weight-section",
    "found {found:g} kg/m in the header, but a section of {profile} as it is given weighs "
    "{expected:.3g} kg/m",
    "They should agree within 5 %; one of the figures of the section may be another's. The weight "
    "changes nothing of what is made, but for corners (dstv-corner-weight).")
HEIGHT = warning("dstv-height",
    "found height {found:g}, expected more than 0",
    "Features cannot be checked against a section without a height.")
SECTION = error("dstv-section",
    "found {found} in a section of profile code {code}, expected walls that fit into each other",
    "Such a section cannot be rolled. Header lines 10 to 15 are height, flange width, thickness of "
    "flange and web, and radius.")
CORNER_WEIGHT = warning("dstv-corner-weight",
    "found corners of {found:g} mm, less than the wall of the tube; read as {radius:g} mm, which "
    "the weight of {weight:g} kg/m has",
    "Some programs write no radius for rectangular tubes, or that inside. The weight tells how "
    "much steel the corners lack. Line 14 of the header is their outer radius.")
TEE_OUTLINE = warning("dstv-tee-outline",
    "found height {height:g} and flange width {width:g} of the T {name}; expected them the other "
    "way round, as its outlines are, and they are read so, with their thicknesses",
    "The flange of a T lies along face v, so that line 10 of the header is how wide it is, line 11 "
    "how high its stem is.")
TEE_NAME = warning("dstv-tee-name",
    "found height {height:g} and flange width {width:g} of the T {name}, whose name has the stem "
    "{height:g} high; read as a flange {height:g} wide and a stem {width:g} high",
    "The flange of a T lies along face v, so that line 10 of the header is how wide it is, line 11 "
    "how high its stem is. Name and header contradict each other: correct one.")
LIP_NAME = warning("dstv-lip-name",
    "found the name {found} of a C that is {sizes}; expected those figures in the name, and the "
    "length of its lips",
    "No header line says how long the lips of a C are; the name of one with four figures does. "
    "Where they are not the header's, the lips are as not known.")
NAME_SIZES = warning("dstv-name-sizes",
    "found {sizes} in the header of {name}, which is {expected}; the header counts",
    "The bar is taken by its name, the program is made by the header: one of them is wrong.")
INCHES = error("dstv-inches",
    "found a height of {height:g} for {name}, which is as high in inches; expected mm",
    "DSTV counts in mm. All lengths of such a file are 25.4 times too small.")
LIP_CODE = warning("dstv-lip-code",
    "found profile code {found} for {name}, whose name has lips of {lip:g} mm; expected C",
    "A U has no lips, so that tools and torches would meet them. Correct the code.")
TEXT_LONG = note("dstv-text-long",
    "found a text of {count} characters, the standard allows {limit}",
    "Other programs may cut it.")
MARK_ELSEWHERE = warning("dstv-mark-elsewhere",
    "found piece mark {found!r}, but the file is named after its {field} {name!r}",
    "Some programs write the piece mark into the drawing or phase; the mark was read from line 4.")

# --- rows -------------------------------------------------------------------------------------
HOLE_FIELDS = error("dstv-hole-fields",
    "found {found!r}, expected `face x[u|o|s] y [g|l|m|s]diameter [depth] [l width height angle]`",
    "The standard has no such row in block BO.")
CONTOUR_FIELDS = error("dstv-contour-fields",
    "found {found!r}, expected `face x[u|o|s] y[t|w] [radius [angle land [angle land]]]`",
    "The standard has no such row in a contour block.")
TEXT_FIELDS = error("dstv-text-fields",
    "found {found!r}, expected `face x[u|o|s] y angle height[r|z] text`",
    "The standard has no such row in block SI.")
PLANE_FIELDS = error("dstv-plane-fields",
    "found {found!r}, expected nine numbers: origin, a point on x, a point on y; {count} rows of "
    "the block are left out",
    "A plane needs three points.")
BEND_FIELDS = error("dstv-bend-fields",
    "found {found!r}, expected `x1 y1 x2 y2 angle [radius]`",
    "The standard has no such row in block KA.")
ENDPLANE_FIELDS = error("dstv-endplane-fields",
    "found {found!r}, expected six numbers: a point and the outward normal; {count} rows of the "
    "block are left out",
    "The standard has no such row in block SC.")
TOLERANCE_FIELDS = error("dstv-tolerance-fields",
    "found {found!r}, expected two numbers; {count} rows of the block are left out",
    "Block TO is `least greatest`.")
CAMBER_FIELDS = error("dstv-camber-fields",
    "found {found!r}, expected `face x y`",
    "Block UE is points of a camber line.")
SECTION_FIELDS = error("dstv-section-fields",
    "found {found!r}, expected `+|- y z radius`",
    "Block PR is a cross-section.")
SECTION_CODE = warning("dstv-section-code",
    "found a cross-section (PR) for profile code {code}, expected SO",
    "Only special profiles have a cross-section of their own; the named profile was taken.")
FACE = error("dstv-face",
    "found {found!r}, expected a face v, o, u or h first",
    "Without its face a feature has no place.")
FACE_CASE = note("dstv-face-case",
    "found the letter {found!r}, read as {read!r}",
    "Faces and reference letters are written small; where one stands a capital can mean nothing "
    "else. It is told once for a block.")
FACE_ASSUMED = warning("dstv-face-assumed",
    "found no face, read as v",
    "A plate has one face, so the row can mean no other.")
PLANE = error("dstv-plane",
    "found block {block}, expected a plane {plane} before it",
    "The features lie on a plane that the file does not give.")
EDGE = note("dstv-edge",
    "found reference letter {found!r}, expected u, o or s; ignored",
    "The letter only says which edge tolerances are measured from.")
EDGE_MIXED = note("dstv-edge-mixed",
    "found the reference letters {found} in one contour, kept {kept!r}",
    "The letter only says which edge tolerances are measured from.")
HOLE_DIAMETER = error("dstv-hole-diameter",
    "found diameter {diameter:g} and depth {depth:g}, expected none below 0",
    "The diameter of a hole is above 0, and its depth is not negative.")
HOLE_ANGLE = note("dstv-hole-angle",
    "found angle {angle:g} on a round hole, ignored",
    "A round hole has no direction.")
SLOT_ROUND = note("dstv-slot-round",
    "found a slot of no length, read as a round hole",
    "The slot's width and height are both 0.")
SLOT_LETTER = warning("dstv-slot-letter",
    "found width {width:g} and height {height:g} without the letter l, read as a slot",
    "A slot has the letter l behind its depth.")
NO_MARKING = note("dstv-no-marking",
    "found no {missing}: nothing is marked",
    "A row of SI without height and text asks for no marking.")
CONTOUR_EMPTY = warning("dstv-contour-empty",
    "found {points} different points, expected at least 2; {count} rows make nothing",
    "One point is no contour.")
CIRCLE_POINTS = error("dstv-circle-points",
    "found radius {radius:g} on a contour of one point, expected two half circles; its {count} "
    "rows are left out",
    "An arc from a point to itself has no centre.")
CONTOUR_OPEN = warning("dstv-contour-open",
    "found an end {gap:.2f} from the start, closed with a straight line",
    "The last row of AK and IK repeats the first.")
CONTOUR_AREA = warning("dstv-contour-area",
    "found a closed contour without area",
    "The contour runs back on itself and cuts nothing out.")
SINGLE_PUNCH = note("dstv-single-punch",
    "found one point, read as a punch mark",
    "A polyline has two points or more.")
REPEATED_POINT = note("dstv-repeated-point",
    "found the point of the row before again, left out",
    "An edge of no length has no direction.")
ARC_RADIUS = error("dstv-arc-radius",
    "found radius {radius:g} between points {chord:.3f} apart, expected at least {least:.3f}; the "
    "contour's {count} rows are left out",
    "No circle of this radius passes through both points; the shape is not known.")
ARC_STRETCHED = warning("dstv-arc-stretched",
    "found radius {radius:g} between points {chord:.3f} apart, read as a half circle",
    "The radius is a little too small for its points.")
NOTCH_CORNER = note("dstv-notch-corner",
    "found a notch corner at {x:g} {y:g}, left out",
    "Where both tangents are parallel some programs write a corner far away; the contour is whole "
    "without it.")
BEVEL_LAND = note("dstv-bevel-land",
    "found bevel {angle:g} with land 0, read as through the whole thickness {land:g}",
    "A bevel on the far side that ends there would cut nothing; some programs write it so.")
BEVEL_LOST = warning("dstv-bevel-lost",
    "found bevel {angle:g} where no edge starts, ignored",
    "A bevel belongs to the edge that starts on its row.")
BEVEL_ANGLE = note("dstv-bevel-angle",
    "found land {land:g} without an angle, ignored",
    "An edge without angle is square.")

# --- cross-checks (lint) ----------------------------------------------------------------------
CUT_ANGLE = error("dstv-cut-angle",
    "found {name} {header:g} in the header, but {contour:.3f} in the contour; expected the same, "
    "or --ends contour or --ends header, which says what counts",
    "The saw and the contour would make different ends.")
CUT_SETTLED = warning("dstv-cut-settled",
    "found {name} {header:g} in the header, but {contour:.3f} in the contour; the {ends} counts, "
    "as --ends says",
    "Only one can be right. The program's head says which was taken.")
CUT_MISSING = warning("dstv-cut-missing",
    "found {name} {header:g} in the header, but {contour:.3f} in the contour; the contour counts",
    "The angles of the header must describe the ends as well.")
LENGTH_CONTOUR = warning("dstv-length-contour",
    "found length {length:g}, but the contours reach {reach:.2f}",
    "Length and contour should agree within 0.2; cuts made late in the drawing can part them.")
HEIGHT_CONTOUR = warning("dstv-height-contour",
    "found height {height:g}, but the contour on v measures {found:.2f}",
    "Height and contour should agree within 0.2; rounded plate widths often do not.")
HOLE_OUTSIDE = warning("dstv-hole-outside",
    "found {what} at x {x:g} y {y:g}, outside the material of face {face}",
    "A hole outside the material is never drilled: its position, its face or the contour is wrong.")
TEXT_OUTSIDE = note("dstv-text-outside",
    "found a text at x {x:g} y {y:g}, off face {face}",
    "A text that begins off its face cannot be marked there; pipes written as plates have such.")
HOLE_DUPLICATE = warning("dstv-hole-duplicate",
    "found the hole of line {first} again (x {x:g} y {y:g} diameter {diameter:g})",
    "The same hole twice is one hole, or one of them should be elsewhere.")
HOLE_THROUGH = note("dstv-hole-through",
    "found a depth of {depth:g} in a wall of {wall:g} mm, read as through",
    "Some exporters write the thickness of the wall for a hole through it, for which DSTV has 0.")
HOLE_SMALL = note("dstv-hole-small",
    "found diameter {diameter:g}, probably a punch mark",
    "Many shops write punch marks as holes of a diameter from 0 to 7.")
CIRCLE_IN_IK = note("dstv-circle-in-ik",
    "found a circle of diameter {diameter:g} as a contour, expected in BO",
    "A hole that BO can describe must be there; as a contour it is cut and not drilled.")
DIRECTION = note("dstv-direction",
    "found the outer contour of face {face} {found} in its numbers, expected {expected}",
    "v and u are drawn counter-clockwise, o and h are seen mirrored; arcs keep their meaning.")
UNROLLED = note("dstv-unrolled",
    "found a plate {height:g} wide, which is pi times {diameter:g}: an unrolled pipe",
    "Some programs write pipes as plates.")
ENDPLANE_OVERRULED = note("dstv-endplane-overruled",
    "found cutting planes (SC) beside an outer contour; the contour counts",
    "Where both are given the contour has priority.")
