"""The finished part: the ends that the saw makes, and the walls that holes lie in after all cuts.

An end is a plane. Its angles are DSTV's (7th edition, header lines 17 to 20), the web's in the
view of v and the flange's in the view of u, and both follow one formula:

    x(y, z) = c - y * tan(web angle) - z * tan(flange angle)

    y = height  o  +--------------------+         web angle > 0 at the start: top edge longest
                  /                    /          web angle > 0 at the end: bottom edge longest
    y = 0     u  +--------------------+
                x = 0             x = length

A hole lies wholly in a wall if its circle does on both surfaces of it, so that of each end the
plane that takes most counts:

          start plane  /           end plane
    v, h, o, u        / (  o  )   |           distance to the start, of the circle's edge:
                     /            |           (x - x_start(y)) / sqrt(1 + tan^2) - radius

Across the part a wall ends at a free edge or at another wall, which may have a root fillet:

    u  |<- edge -> ( hole ) <- fillet -> )| web |( ...

"""

from collections.abc import Sequence
from math import atan2, degrees, hypot, inf, radians, tan
from typing import Literal

from msgspec import Struct

from beamcam.errors import Diagnostic, PlanError, Rule, error, warning
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine, drill_of
from beamcam.machine.stations import Saw
from beamcam.model.description import named
from beamcam.model.part import Contour, Face, Hole, Part, Profile, Slot
from beamcam.model.section import Wall, corners, free_edges, walls_beside
from beamcam.planning import rules
from beamcam.planning.axis_limits import fixed_faces

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
        flanges = ("u",) if part.profile.code == "L" else ("o", "u")
        first, *others = (_drawn_angles(part, face) for face in flanges)
        # One flange alone that is drawn skew is a preparation of that flange and no saw cut.
        off = [abs(a - b) for one in others for a, b in zip(first or (), one or (), strict=False)]
        if None in others or max(off, default=0.0) > ANGLE_TOLERANCE_DEG:
            first = None
        drawn = (_drawn_angles(part, "v"), first)
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
    if end.is_square:
        return WallEnd(end.x0, end.x0, 0.0)
    flange = flange_borders(profile, face)
    web, tilt = tan(radians(end.web_deg)), tan(radians(end.flange_deg))
    lean, borders = (web, flange) if flange else (tilt, web_borders(profile, face))
    a, b = (end.x0 - border * lean for border in borders)
    return WallEnd(min(a, b), max(a, b), tilt if flange else web)


def flange_borders(profile: Profile, face: str) -> tuple[float, float] | None:
    """y of the two surfaces of the plate behind face o or u; None of another face."""
    thickness, height = profile.flange_thickness, profile.height
    if profile.code == "T" and face in ("o", "u"):
        return (height - thickness) / 2, (height + thickness) / 2
    if face == "o":
        return height - thickness, height
    return (0.0, thickness) if face == "u" else None


def web_borders(profile: Profile, face: str) -> tuple[float, float]:
    """z of the two surfaces of the plate behind face v or h."""
    thickness = profile.web_thickness or 0.0
    if profile.code == "I":
        return (profile.width - thickness) / 2, (profile.width + thickness) / 2
    if profile.code in ("M", "B", "RO", "RU", "SO") and face == "v":
        return profile.width - thickness, profile.width
    return 0.0, thickness


OFF_PART = error("plan-off-part",
    "found {what} at x {x}, y {y} on face {face} that reaches {out} mm beyond {where}; expected it "
    "wholly within the finished part",
    "A hole that an end cut or an edge cuts open is a mistake in the drawing, and the drill would "
    "run off. A hole in the wedge that a mitre cuts off is wasted.")  # fmt: skip
NEAR_EDGE = warning("plan-near-edge",
    "found {what} at x {x}, y {y} on face {face}, {apart} mm from {where}; expected at least "
    "{expected} mm",
    "So little steel bends or breaks out beside the drill "
    "(`drill.min_edge_distance`).")  # fmt: skip
WALL = error("plan-wall",
    "found {what} at x {x}, y {y} on face {face}; expected it clear of the wall from y {least} to "
    "{greatest}",
    "Another wall of the section stands there, and the drill would run into it.")  # fmt: skip
FILLET = error("plan-fillet",
    "found {what} at x {x}, y {y} on face {face} where the root fillet is {found} mm high; "
    "expected at most {expected} mm, {because}",
    "The fillet makes the wall thicker than the stroke is deep, or is in the drill's "
    "way.")  # fmt: skip
NEAR_FILLET = warning("plan-near-fillet",
    "found {what} at x {x}, y {y} on face {face}, {found}; expected at least {expected} mm from it",
    "A drill that meets the root fillet runs to one side "
    "(`drill.min_fillet_distance`).")  # fmt: skip
BLIND_DEPTH = error("plan-blind-depth",
    "found {what} of depth {found} at x {x}, y {y} on face {face}; expected at most {expected} mm, "
    "the thickness of the wall",
    "A blind hole ends in its wall. A depth of 0 is through.")  # fmt: skip
SHALLOW = error("plan-blind-shallow",
    "found {what} of depth {found} at x {x}, y {y} on face {face}; expected at least {expected} "
    "mm, which programs of the machine can say",
    "Nothing is left of such a depth in a program. A depth of 0 is through.")  # fmt: skip

TOLERANCE = 0.01  #: mm; files round to it, so a hole that is as near is tangent


#: A straight line at which the wall behind a face ends: the steel between it and x 0, y 0 of the
#: face, how much more there is for each mm of x and of y, and its name in messages.
Border = tuple[float, float, float, str]


class FinishedPart:
    """The part after its end cuts, as far as it limits holes."""

    def __init__(self, part: Part, ends: Ends, machine: Machine) -> None:
        self.part, self._ends, self._drill = part, ends, drill_of(machine)
        self._machine = machine
        self._borders: dict[Face, list[Border]] = {}

    def steel(self, face: Face, points: Sequence[Point]) -> tuple[float, str]:
        """Steel between points and the nearest border of their wall, and which border that is.

        It is negative if a point is beyond. Of borders that are as near the first by name counts.
        """
        borders = self._borders.get(face)
        if borders is None:
            # The ends of the wall behind the face, each where it takes most, and its free edges.
            profile = self.part.profile
            start, end = (wall_end(each, face, profile) for each in self._ends)
            a, b = hypot(1.0, start.slope), hypot(1.0, end.slope)
            at_low, at_width = free_edges(profile, face)
            borders = self._borders[face] = []  # sorted by their names
            if at_low:
                borders.append((0.0, 0.0, 1.0, f"the edge of face {face}"))
            if at_width:
                width = profile.face_width(face)
                borders.append((width, 0.0, -1.0, f"the edge of face {face}"))
            borders += (
                (end.least / b, -1 / b, -end.slope / b, "the end of the part"),
                (-start.greatest / a, 1 / a, start.slope / a, "the start of the part"),
            )
        nearest, name = inf, ""
        for at_zero, per_x, per_y, border in borders:
            for x, y in points:
                steel = at_zero + per_x * x + per_y * y
                if steel < nearest:
                    nearest, name = steel, border
        return nearest, name

    def judge(self, shape: Hole | Slot) -> list[Diagnostic]:
        """Errors and remarks on a hole or slot, errors first."""
        radius, drill = shape.diameter / 2, self._drill
        centres = shape.centres
        nearest, place = self.steel(shape.face, centres)
        left = nearest - radius
        if left < -TOLERANCE:
            return [_message(OFF_PART, shape, out=f"{-left:.3g}", where=place)]
        diagnostics: list[Diagnostic] = []
        ys = [y for _, y in centres]
        low, high = min(ys) - radius, max(ys) + radius
        for wall in walls_beside(self.part.profile, shape.face):
            apart = wall.apart(low, high)
            if apart < drill.min_fillet_distance - TOLERANCE:
                diagnostics.append(self._beside(shape, low, high, wall, apart))
        if shape.kind != "mark" and left < drill.min_edge_distance - TOLERANCE:
            apart_mm, expected = f"{max(left, 0.0):.3g}", f"{drill.min_edge_distance:g}"
            diagnostics.append(
                _message(NEAR_EDGE, shape, apart=apart_mm, where=place, expected=expected)
            )
        if shape.depth is not None:
            deep, thickness = f"{shape.depth:g}", self.part.profile.thickness(shape.face)
            step = self._machine.format.resolution
            if shape.depth < step and shape.kind != "mark":
                diagnostics.append(_message(SHALLOW, shape, found=deep, expected=f"{step:g}"))
            if shape.depth > thickness + TOLERANCE > TOLERANCE:
                diagnostics.append(
                    _message(BLIND_DEPTH, shape, found=deep, expected=f"{thickness:g}")
                )
        return diagnostics

    def _beside(
        self, shape: Hole | Slot, low: float, high: float, wall: Wall, apart: float
    ) -> Diagnostic:
        """The remark on a hole that is too near another wall, or in it."""
        if high > wall.least + TOLERANCE and low < wall.greatest - TOLERANCE:
            return _message(WALL, shape, least=f"{wall.least:g}", greatest=f"{wall.greatest:g}")
        high_mm = wall.fillet_height(-apart)
        profile = self.part.profile
        limit, because = self._drill.clearance, "the clearance of the rapid approach"
        is_outside = not profile.face_depth(shape.face)
        is_stem = profile.code == "T" and shape.face in ("o", "u")  # with fillets on both sides
        is_fixed = shape.face in fixed_faces(self._machine)  # such a stroke passes everything
        deeper = inf if is_fixed else self._drill.breakthrough
        if is_outside or (is_stem and deeper < limit):
            limit, because = deeper, "the breakthrough behind the wall"
        if high_mm > limit and shape.kind != "mark":
            return _message(
                FILLET, shape, found=f"{high_mm:.3g}", expected=f"{limit:g}", because=because
            )
        place = f"{-apart:.3g} mm into" if apart < 0 else f"{apart:.3g} mm from"
        expected = f"{self._drill.min_fillet_distance:g}"
        return _message(NEAR_FILLET, shape, found=f"{place} the root fillet", expected=expected)


def _message(rule: Rule, shape: Hole | Slot, **values: str) -> Diagnostic:
    return rule.at(
        shape.source, what=named(shape), x=f"{shape.x:g}", y=f"{shape.y:g}", face=shape.face,
        **values,
    )  # fmt: skip
