"""Features as rows of a DSTV file."""

from itertools import pairwise
from math import acos, ceil, hypot, pi, radians

from msgspec.structs import replace

from beamcam.errors import BeamcamError, error
from beamcam.geometry.curves import (
    Arc,
    Bezier,
    Curve,
    EllipseArc,
    Line,
    Point,
    bezier_pieces,
    signed_area,
    unit_vector,
)
from beamcam.geometry.plane import distance
from beamcam.model.part import (
    MIRRORED_FACES,
    Bevel,
    Contour,
    Hole,
    Slot,
    TextMark,
)

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


# fmt: on


DECIMALS = 6  #: as many as are needed and no more than these; at least 2
_WIDTH = 11  #: of a number's column

_KIND_LETTERS = {"thread": "g", "left-thread": "l", "mark": "m", "countersink": "s"}


def format_number(value: float, least: int = 2) -> str:
    """`value` with `least` decimals or as many as it needs, without exponent or -0.00."""
    whole, _, decimals = f"{value:.{DECIMALS}f}".partition(".")
    decimals = decimals.rstrip("0").ljust(least, "0")
    if whole == "-0" and not decimals.strip("0"):
        whole = "0"
    return f"{whole}.{decimals}"


def _column(text: str) -> str:
    return " " + text.rjust(_WIDTH - 1)


def numbers(*values: float) -> str:
    """Numbers in their columns."""
    return "".join(_column(format_number(value)) for value in values)


def place(face: str, x: float, edge: str, y: str) -> str:
    """Face, x with its reference letter, and y with what stands behind it."""
    letter = face if len(face) == 1 else " "
    return f"  {letter}{_column(format_number(x))}{edge or ' '}{_column(y)}"


def hole_row(hole: Hole) -> str:
    """The row of a hole in BO."""
    # "  v      100.00u     100.00      s18.00       8.00       0.00       0.00      90.00"
    size = _KIND_LETTERS.get(hole.kind, "") + format_number(hole.diameter)
    row = place(hole.face, hole.x, hole.edge, format_number(hole.y)) + _column(size)
    row += numbers(hole.depth or 0.0)
    return row + numbers(0.0, 0.0, hole.angle) if hole.angle else row


def slot_row(slot: Slot) -> str:
    """The row of a slot in BO, which begins at the centre of its first corner circle."""
    # "  v      115.58s      46.80      31.78      0.00l       0.00       6.40       0.00"
    cos_w, sin_w = unit_vector(slot.angle)
    x = slot.x - (slot.length * cos_w - slot.height * sin_w) / 2
    y = slot.y - (slot.length * sin_w + slot.height * cos_w) / 2
    size = _KIND_LETTERS.get(slot.kind, "") + format_number(slot.diameter)
    row = place(slot.face, x, slot.edge, format_number(y)) + _column(size)
    row += _column(format_number(slot.depth or 0.0) + "l")
    return row + numbers(slot.length, slot.height, slot.angle)


def text_row(mark: TextMark) -> str:
    """The row of a text in SI."""
    # "  v       30.00u     134.44       0.00  25r pt56"
    height = format_number(mark.height, 0).rstrip(".")
    row = place(mark.face, mark.x, mark.edge, format_number(mark.y))
    return f"{row}{numbers(mark.angle)} {height}{mark.option} {mark.text}"


def contour_rows(contour: Contour, tolerance: float | None) -> list[str]:
    """The rows of a contour in its direction by the standard.

    Raises BeamcamError for a curve that DSTV does not have, unless there is a `tolerance` (mm)
    that its polyline may be away from it.
    """
    contour = _by_the_book(_in_dstv_curves(contour, tolerance))
    sign = -1.0 if contour.face in MIRRORED_FACES else 1.0
    bevels: dict[int, list[Bevel]] = {}
    for bevel in contour.bevels:
        bevels.setdefault(bevel.curve, []).append(bevel)
    rows: list[str] = []

    def add(point: Point, radius: float, letter: str = "", pairs: tuple[float, ...] = ()) -> None:
        face, edge = (" ", "") if rows else (contour.face, contour.edge)
        row = place(face, point[0], edge, format_number(point[1]))
        rows.append(row + (letter or " ") + numbers(radius, *pairs))

    for i, curve in enumerate(contour.curves):
        here = bevels.get(i, [])
        if len(here) > 2:
            raise BeamcamError(WRITE_BEVELS.at(contour.source, count=len(here)))
        pairs = tuple(value for bevel in here for value in (bevel.angle, bevel.land))
        radius = 0.0  # of an arc, negative if it runs clockwise in the numbers
        if isinstance(curve, Arc):
            radius = curve.radius if curve.sweep_deg > 0 else -curve.radius
        add(curve.start, sign * radius, pairs=pairs)
        for notch in contour.notches:
            if notch.curve == i:
                add(notch.corner, sign * notch.radius, notch.kind)
    start, end = contour.curves[0].start, contour.curves[-1].end
    if contour.closed and distance(start, end) < 0.01:
        end = start
    add(end, 0.0)
    if contour.closed and end != start:
        add(start, 0.0)
    return rows


def _by_the_book(contour: Contour) -> Contour:
    """`contour` running counter-clockwise seen from outside if it is an outer one, else clockwise.

    On o and h a reader tells from the direction whether the numbers are mirrored.
    """
    if not contour.closed or contour.kind == "open":
        return contour
    positive = (contour.kind == "outer") != (contour.face in MIRRORED_FACES)
    area = signed_area(contour.curves)
    if area == 0.0 or (area > 0) == positive:
        return contour
    last = len(contour.curves) - 1
    bevels = [replace(b, curve=last - b.curve) for b in contour.bevels]
    return replace(
        contour,
        curves=tuple(curve.reversed() for curve in reversed(contour.curves)),
        bevels=tuple(sorted(bevels, key=lambda bevel: bevel.curve)),
        notches=tuple(
            replace(n, curve=last - n.curve, radius=-n.radius) for n in reversed(contour.notches)
        ),
    )


def _in_dstv_curves(contour: Contour, tolerance: float | None) -> Contour:
    """`contour` in lines and arcs of at most 180 degrees; bevels go with each piece."""
    pieces: list[Curve] = []
    places: list[range] = []  # of each curve's pieces
    for curve in contour.curves:
        pieces += _pieces(curve, contour, tolerance)
        places.append(range(places[-1].stop if places else 0, len(pieces)))
    if len(pieces) == len(contour.curves):
        return replace(contour, curves=tuple(pieces))
    bevels = tuple(Bevel(k, b.angle, b.land) for b in contour.bevels for k in places[b.curve])
    notches = tuple(replace(n, curve=places[n.curve].start) for n in contour.notches)
    return replace(contour, curves=tuple(pieces), bevels=bevels, notches=notches)


LIKE_HALF = 0.05  #: mm by which the chord of an arc is shorter than its diameter


def _pieces(curve: Curve, contour: Contour, tolerance: float | None) -> list[Curve]:
    """A curve as curves that DSTV has."""
    match curve:
        case Line():
            return [curve]
        case Arc():
            count = ceil(abs(curve.sweep_deg) / 180.0 - 1e-12)
            if count <= 1:
                # Readers take an arc for the half circle whose rounded numbers it could have.
                short = 2 * curve.radius - distance(curve.start, curve.end)
                is_half = abs(abs(curve.sweep_deg) - 180.0) < 1e-9
                if is_half or not 0.0 < short <= LIKE_HALF:
                    return [curve]
                count = 2
            step = curve.sweep_deg / count
            return [
                Arc(curve.centre, curve.radius, curve.start_deg + k * step, step)
                for k in range(count)
            ]
    if tolerance is None or tolerance <= 0:
        raise BeamcamError(WRITE_CURVE.at(contour.source, kind=type(curve).__name__))
    if isinstance(curve, EllipseArc):
        # An ellipse is a circle of its major axis pressed flat, so that its chords are no further
        # away than the circle's: step = 2 acos(1 - tolerance / major).
        step = 2 * acos(max(0.0, 1 - tolerance / curve.major))
        count = max(2, ceil(abs(radians(curve.sweep_deg)) / min(step, pi / 2)))
        points = [curve.point(k / count) for k in range(count + 1)]
    else:
        points = [curve.start]
        for piece in bezier_pieces(curve):
            points += _bezier_points(piece, tolerance)
    return [Line(a, b) for a, b in pairwise(points) if a != b]


def _bezier_points(curve: Bezier, tolerance: float, depth: int = 24) -> list[Point]:
    """Points behind the start of a Bezier curve whose chords stay within `tolerance` of it.

    A curve lies in the hull of its control points, so it is flat when they are; else it is
    halved. `depth` bounds the halving of what has no direction.
    """
    (x0, y0), (x1, y1) = curve.start, curve.end
    dx, dy = x1 - x0, y1 - y0
    square = dx * dx + dy * dy
    flat = True
    for x, y in curve.points[1:-1]:
        t = 0.0 if square == 0 else min(1.0, max(0.0, ((x - x0) * dx + (y - y0) * dy) / square))
        flat = flat and hypot(x - x0 - t * dx, y - y0 - t * dy) <= tolerance
    if flat or depth == 0:
        return [curve.end]
    halves = [_bezier_points(half, tolerance, depth - 1) for half in curve.split(0.5)]
    return halves[0] + halves[1]
