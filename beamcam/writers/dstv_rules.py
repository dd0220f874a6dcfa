"""Rules for writing DSTV files: every code that the writer gives."""

from beamcam.errors import error

# fmt: off

WRITE_TEXT = error("dstv-write-text",
    "found text {found!r} for {place}, expected {expected}",
    "DSTV is lines of text: such a text would be read back as something else.")
WRITE_CURVE = error("dstv-write-curve",
    "found a {kind}, expected lines and arcs; give a tolerance to flatten it",
    "DSTV has no word for the curve.")
WRITE_CONTOUR = error("dstv-write-contour",
    "found a contour of kind {kind} to {process}, expected an outer or inner one to cut, or one to "
    "punch or powder",
    "DSTV has no block for it.")
WRITE_BEVELS = error("dstv-write-bevels",
    "found {count} bevels on one curve, expected at most 2",
    "A row of a contour has place for two bevels.")
WRITE_FACE = error("dstv-write-face",
    "found face {found!r} of {what}, expected v, o, u, h or a plane E0 to E9 of the part",
    "DSTV has no such face.")
WRITE_PLANE = error("dstv-write-plane",
    "found a feature on plane {found!r} behind another plane of that number, expected it before",
    "A plane block with a number used before replaces the plane.")
WRITE_COMMENT = error("dstv-write-comment",
    "found a comment at {found!r}, expected a place that the part has",
    "A comment whose place is not there would be lost.")

RULES = (
    WRITE_TEXT,
    WRITE_CURVE,
    WRITE_CONTOUR,
    WRITE_BEVELS,
    WRITE_FACE,
    WRITE_PLANE,
    WRITE_COMMENT,
)
