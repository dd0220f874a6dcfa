"""The ends of a part: where a saw has to cut, and what of the contours that explains.

Both end planes follow one formula (reference: DSTV 7th edition, header lines 17 to 20):

    x(y) = c - y * tan(web angle)

    y = height  o  +--------------------+         web angle > 0 at the start: top edge longest
                  /                    /          web angle > 0 at the end: bottom edge longest
    y = 0     u  +--------------------+
                x = 0             x = length
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import atan2, degrees, radians, tan

from beamcam.errors import Diagnostic, PlanError
from beamcam.geometry.curves import Line, Point
from beamcam.model.part import Contour, Part
from beamcam.planning import rules

CONTOUR_TOLERANCE = 1.0  #: mm between contour and header that exporters leave; no cope is smaller
ANGLE_TOLERANCE_DEG = 0.2  #: between header and contour


@dataclass(frozen=True, slots=True)
class End:
    """The plane of one end: x on the part as a function of y on the web."""

    at: str  #: "start" or "end", for messages
    web_deg: float
    x0: float  #: x at y = 0

    def x(self, y: float) -> float:
        return self.x0 - y * tan(radians(self.web_deg))


def ends_of(part: Part, least_mitre: float) -> tuple[tuple[End, End], tuple[Diagnostic, ...]]:
    """The start and the end plane of a part, and remarks about them.

    Header and contour have to agree; where the header says nothing the contour decides. An angle
    below `least_mitre` degrees is square. Raises PlanError for a flange cut, and where the two
    contradict each other.
    """
    cuts, remarks = part.cuts, []
    drawn = _drawn_angles(part)
    found = []
    for at, web, flange, seen in (
        ("start", cuts.web_start, cuts.flange_start, drawn[0] if drawn else None),
        ("end", cuts.web_end, cuts.flange_end, drawn[1] if drawn else None),
    ):
        if abs(flange) >= least_mitre:
            raise PlanError(rules.FLANGE_CUT.at(part.source, found=f"{flange:g}", end=at))
        if seen is not None and abs(seen - web) > ANGLE_TOLERANCE_DEG:
            if abs(web) >= least_mitre:
                raise PlanError(
                    rules.CUT_DENIED.at(
                        part.source, found=f"{web:g}", end=at, expected=f"{seen:.3f}"
                    )
                )
            remarks.append(rules.CUT_FROM_CONTOUR.at(part.source, found=f"{seen:.3f}", end=at))
            web = seen
        found.append(web if abs(web) >= least_mitre else 0.0)
    height = part.profile.height
    lean = [height * tan(radians(angle)) for angle in found]
    start = End("start", found[0], max(0.0, lean[0]))
    end = End("end", found[1], part.length + min(0.0, lean[1]))
    return (start, end), tuple(remarks)


def _drawn_angles(part: Part) -> tuple[float, float] | None:
    """Web angles of the outer contour on v; None if there is none, or it is no trapezoid."""
    outer = [c for c in part.contours if c.face == "v" and c.kind == "outer"]
    if len(outer) != 1 or not all(isinstance(c, Line) for c in outer[0].curves):
        return None
    points = [c.start for c in outer[0].curves]
    low, high = min(p[1] for p in points), max(p[1] for p in points)
    if high - low < CONTOUR_TOLERANCE:
        return None
    bottom = [p[0] for p in points if p[1] <= low + CONTOUR_TOLERANCE]
    top = [p[0] for p in points if p[1] >= high - CONTOUR_TOLERANCE]
    angles = tuple(degrees(atan2(pick(bottom) - pick(top), high - low)) for pick in (min, max))
    for x, y in points:
        share = (y - low) / (high - low)
        on_edge = y <= low + CONTOUR_TOLERANCE or y >= high - CONTOUR_TOLERANCE
        ends = (pick(bottom) + share * (pick(top) - pick(bottom)) for pick in (min, max))
        if not on_edge and all(abs(x - e) > CONTOUR_TOLERANCE for e in ends):
            return None
    return angles[0], angles[1]


def leaves_stock(contour: Contour, part: Part, ends: tuple[End, End]) -> Point | None:
    """Where an outer contour is not what the stock and the end cuts alone give; None if it is.

    Each vertex has to lie on a long edge or on an end, and each corner has to be a vertex.
    """
    width = part.profile.face_width(contour.face)
    vertices = list(_vertices(contour))
    for x, y in vertices:
        first, last = (_reach(end, contour.face, part, y) for end in ends)
        along = first[0] <= x <= last[1]
        on_edge = min(abs(y), abs(y - width)) <= CONTOUR_TOLERANCE
        on_end = x <= first[1] or x >= last[0]
        if not along or not (on_edge or on_end):
            return x, y
    for y in (0.0, width):
        for end in ends:
            least, greatest = _reach(end, contour.face, part, y)
            if not any(
                abs(vy - y) <= CONTOUR_TOLERANCE and least <= vx <= greatest for vx, vy in vertices
            ):
                return end.x(y), y
    return None


def _reach(end: End, face: str, part: Part, y: float) -> tuple[float, float]:
    """Least and greatest x that a contour may have at an end, the tolerance included.

    A flange ends skew through its thickness, and is drawn as long as either of its surfaces.
    """
    height, inner = part.profile.height, part.profile.flange_thickness
    at = {"o": (height - inner, height), "u": (0.0, inner)}.get(face, (y,))
    xs = [end.x(border) for border in at]
    return min(xs) - CONTOUR_TOLERANCE, max(xs) + CONTOUR_TOLERANCE


def _vertices(contour: Contour) -> Iterator[Point]:
    """Starts of the curves, and a point amid every curve that is not straight."""
    for curve in contour.curves:
        yield curve.start
        if not isinstance(curve, Line):
            yield curve.point(0.5)
    if not contour.closed:
        yield contour.curves[-1].end
