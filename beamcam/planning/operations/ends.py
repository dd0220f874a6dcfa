"""The ends of a part: where a saw has to cut, and what of the contours that explains.

An end is a plane. Its angles are DSTV's (7th edition, header lines 17 to 20), the web's in the
view of v and the flange's in the view of u, and both follow one formula:

    x(y, z) = c - y * tan(web angle) - z * tan(flange angle)

    y = height  o  +--------------------+         web angle > 0 at the start: top edge longest
                  /                    /          web angle > 0 at the end: bottom edge longest
    y = 0     u  +--------------------+
                x = 0             x = length
"""

from collections.abc import Iterator
from math import atan2, degrees, hypot, radians, tan
from typing import Literal

from msgspec import Struct

from beamcam.errors import Diagnostic, PlanError
from beamcam.geometry.curves import Line, Point
from beamcam.machine.stations import Saw
from beamcam.model.part import Contour, Part, Profile
from beamcam.model.section import corners
from beamcam.planning import rules

CONTOUR_TOLERANCE = 1.0  #: mm between contour and header that exporters leave; no cope is smaller
ANGLE_TOLERANCE_DEG = 0.2  #: between header and contour


class SawnEnd(Struct, frozen=True):
    """The plane of one end, x on the part as a function of y and z in the section, and its kerf."""

    at: Literal["start", "end"]
    web_deg: float = 0.0
    x0: float = 0.0  #: x at y = 0, z = 0
    flange_deg: float = 0.0
    kerf: float = 0.0  #: length of bar that its cut takes, as the machine counts it

    @property
    def is_square(self) -> bool:
        return not (self.web_deg or self.flange_deg)

    def x(self, y: float, z: float = 0.0) -> float:
        if self.is_square:
            return self.x0
        return self.x0 - y * tan(radians(self.web_deg)) - z * tan(radians(self.flange_deg))


Ends = tuple[SawnEnd, SawnEnd]
SQUARE: Ends = (SawnEnd("start"), SawnEnd("end"))


def ends_of(part: Part, saw: Saw) -> tuple[Ends, tuple[Diagnostic, ...]]:
    """The start and the end plane of a part as the saw makes them, and remarks about them.

    Header and contour have to agree; where the header says nothing the contour decides. An angle
    below the saw's `min_mitre` is square. Raises PlanError where the two contradict each other.
    """
    cuts = part.cuts
    header = ((cuts.web_start, cuts.web_end), (cuts.flange_start, cuts.flange_end))
    drawn: tuple[tuple[float, float] | None, ...] = (None, None)
    if Contour in map(type, part.features):
        drawn = (_drawn_angles(part, "v"), _drawn_flange_angles(part))
    elif header == ((0.0, 0.0), (0.0, 0.0)):
        return (SawnEnd("start", kerf=saw.kerf), SawnEnd("end", x0=part.length, kerf=saw.kerf)), ()
    remarks: list[Diagnostic] = []
    web = _agreed(part, "web", header[0], drawn[0], saw.min_mitre, remarks)
    flange = _agreed(part, "flange", header[1], drawn[1], saw.min_mitre, remarks)
    slopes = [(tan(radians(w)), tan(radians(f))) for w, f in zip(web, flange, strict=True)]
    leans = [[y * t + z * s for y, z in corners(part.profile, part.section)] for t, s in slopes]
    kerfs = [saw.kerf * (hypot(1.0, *s) if saw.kerf_along == "normal" else 1.0) for s in slopes]
    start = SawnEnd("start", web[0], max(leans[0]), flange[0], kerfs[0])
    end = SawnEnd("end", web[1], part.length + min(leans[1]), flange[1], kerfs[1])
    return (start, end), tuple(remarks)


def _agreed(
    part: Part, name: Literal["web", "flange"], header: tuple[float, float],
    drawn: tuple[float, float] | None, min_mitre: float, remarks: list[Diagnostic],
) -> tuple[float, float]:  # fmt: skip
    """The angles of both ends on which header and contour agree."""
    angles = []
    ends: tuple[Literal["start", "end"], ...] = ("start", "end")
    for at, header_deg, seen in zip(ends, header, drawn or (None, None), strict=True):
        angle, source = header_deg, part.cut_source(name, at)
        if seen is not None and abs(seen - header_deg) > ANGLE_TOLERANCE_DEG:
            if abs(header_deg) >= min_mitre:
                raise PlanError(
                    rules.CUT_DENIED.at(
                        source, kind=name, found=f"{header_deg:g}", end=at, expected=f"{seen:.3f}"
                    )
                )
            remarks.append(
                rules.CUT_FROM_CONTOUR.at(source, kind=name, found=f"{seen:.3f}", end=at)
            )
            angle = seen
        if 0.0 < abs(angle) < min_mitre:
            remarks.append(
                rules.CUT_NOISE.at(
                    source, kind=name, found=f"{angle:.3g}", end=at, expected=f"{min_mitre:g}"
                )
            )
        angles.append(angle if abs(angle) >= min_mitre else 0.0)
    return angles[0], angles[1]


def _drawn_flange_angles(part: Part) -> tuple[float, float] | None:
    """Flange angles that the contours of all flanges agree on; None where they do not.

    One flange alone that is drawn skew is a preparation of that flange and no saw cut.
    """
    faces = ("u",) if part.profile.code == "L" else ("o", "u")
    seen = [_drawn_angles(part, face) for face in faces]
    first = seen[0]
    for other in seen:
        if first is None or other is None:
            return None
        if any(abs(a - b) > ANGLE_TOLERANCE_DEG for a, b in zip(first, other, strict=True)):
            return None
    return first


def _drawn_angles(part: Part, face: str) -> tuple[float, float] | None:
    """End angles of the outer contour on a face; None if it has none or is not a trapezoid."""
    outer = [c for c in part.contours if c.face == face and c.kind == "outer"]
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


def leaves_stock(contour: Contour, part: Part, ends: Ends) -> Point | None:
    """Where an outer contour is not what the stock and the end cuts alone give; None if it is.

    Each vertex has to lie on a long edge or on an end, and each corner has to be a vertex.
    """
    width = part.profile.face_width(contour.face)
    first, last = (wall_end(end, contour.face, part.profile) for end in ends)
    vertices = list(_vertices(contour))
    for x, y in vertices:
        (start, inside), (outside, end) = first.reach(y), last.reach(y)
        on_edge = min(abs(y), abs(y - width)) <= CONTOUR_TOLERANCE
        if not start <= x <= end or not (on_edge or x <= inside or x >= outside):
            return x, y
    for y in (0.0, width):
        for least, greatest in (first.reach(y), last.reach(y)):
            if not any(
                abs(vy - y) <= CONTOUR_TOLERANCE and least <= vx <= greatest for vx, vy in vertices
            ):
                return (least + greatest) / 2, y
    return None


class WallEnd(Struct, frozen=True):
    """End of the wall behind a face: x at q 0 on each of its surfaces, and its slope.

    `q` is the second coordinate of the face: z on the flanges, y on the web. A wall ends skew
    through its thickness, and is drawn as long as either of its surfaces.
    """

    least: float
    greatest: float
    slope: float  #: x falls by it with q

    def reach(self, q: float) -> tuple[float, float]:
        """Minimum and maximum x of a contour there, including the tolerance."""
        lean = q * self.slope
        return self.least - lean - CONTOUR_TOLERANCE, self.greatest - lean + CONTOUR_TOLERANCE


def wall_end(end: SawnEnd, face: str, profile: Profile) -> WallEnd:
    """The end of the wall behind a face."""
    web, tilt = tan(radians(end.web_deg)), tan(radians(end.flange_deg))
    flange = flange_borders(profile, face)
    lean, borders = (web, flange) if flange else (tilt, web_borders(profile, face))
    a, b = (end.x0 - border * lean for border in borders)
    return WallEnd(min(a, b), max(a, b), tilt if flange else web)


def flange_borders(profile: Profile, face: str) -> tuple[float, float] | None:
    """y of the two surfaces of the plate behind face o or u; None of another face."""
    thickness, height = profile.flange_thickness, profile.height
    if profile.code == "T" and face in ("o", "u"):
        return (height - thickness) / 2, (height + thickness) / 2
    return {"o": (height - thickness, height), "u": (0.0, thickness)}.get(face)


def web_borders(profile: Profile, face: str) -> tuple[float, float]:
    """z of the two surfaces of the plate behind face v or h."""
    thickness = profile.web_thickness or 0.0
    if profile.code == "I":
        return (profile.width - thickness) / 2, (profile.width + thickness) / 2
    if profile.code in ("M", "B", "RO", "RU", "SO") and face == "v":
        return profile.width - thickness, profile.width
    return 0.0, thickness


def _vertices(contour: Contour) -> Iterator[Point]:
    """Starts of the curves, and a point within every curve that is not straight."""
    for curve in contour.curves:
        yield curve.start
        if not isinstance(curve, Line):
            yield curve.point(0.5)
    if not contour.closed:
        yield contour.curves[-1].end
