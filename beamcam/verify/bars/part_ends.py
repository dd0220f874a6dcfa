"""End planes of a part, and the outlines that they account for.

Computed from the part alone, and not by the planner. Both ends follow DSTV's formula, of the web
in y and of the flange in z (across, from the h side):

    angle = atan2(x(lowest) - x(highest), height)      so      x = c - y tan(web) - z tan(flange)

and touch x = 0 and x = length at their furthest points.
"""

from math import atan, atan2, cos, degrees, hypot, radians, tan
from typing import Literal

from msgspec import Struct

from beamcam.geometry.curves import Line, Point
from beamcam.machine.saw import Saw
from beamcam.model.part import Contour, Face, Part, Profile
from beamcam.model.section import corners

OUTLINE_TOLERANCE = 1.0  #: mm that exporters leave between outline and header
ANGLE_TOLERANCE_DEG = 0.2  #: between header and outline, and between a bevel and its mitre


class End(Struct, frozen=True, gc=False):
    """The plane of one end of a part."""

    side: int  #: -1 start, +1 end: on which side of it the waste lies
    web: float  #: degrees, DSTV's web angle
    flange: float  #: and its flange angle; both 0 is square
    x_0: float  #: x on the part at y = 0, z = 0
    tan_web: float = 0.0
    tan_flange: float = 0.0

    @property
    def name(self) -> Literal["start", "end"]:
        return "start" if self.side < 0 else "end"

    @property
    def square(self) -> bool:
        return not self.web and not self.flange

    def x(self, y: float, z: float = 0.0) -> float:
        return self.x_0 - y * self.tan_web - z * self.tan_flange

    def kerf(self, saw: Saw) -> float:
        """Length of bar that its cut takes: the blade's thickness, along the bar if it is so."""
        if self.square or saw.kerf_along != "normal":
            return saw.kerf
        return saw.kerf * hypot(1.0, self.tan_web, self.tan_flange)

    def blade(self, saw: Saw, height: float) -> float:
        """The part's x of the blade's centre, on the saw's pivot edge."""
        return self.x(height if saw.pivot == "o" else 0.0) + self.side * self.kerf(saw) / 2

    def saw_angles(self, saw: Saw) -> tuple[float, float]:
        """Angle and tilt in the machine's counting.

        A blade turned by w and then tilted by t has the normal (cos t cos w, cos t sin w, sin t),
        which has to be along (1, tan w, tan f), so tan t = tan f cos w.
        """
        if not self.flange:
            return saw.square + saw.angle_sign * self.web, 0.0
        tilt = degrees(atan(self.tan_flange * cos(radians(self.web))))
        return saw.square + saw.angle_sign * self.web, saw.tilt_sign * tilt + 0.0


def ends_of(part: Part, saw: Saw) -> tuple[End, End]:
    """Start and end of a part: by the header's angles, by the outlines where they are 0."""
    cuts, least = part.cuts, saw.min_mitre
    webs, flanges = (cuts.web_start, cuts.web_end), (cuts.flange_start, cuts.flange_end)
    if Contour in map(type, part.features):
        if abs(webs[0]) < least or abs(webs[1]) < least:
            webs = _instead(webs, _drawn(part, "v"), least)
        if abs(flanges[0]) < least or abs(flanges[1]) < least:
            seen = [_drawn(part, face) for face in ("u" if part.profile.code == "L" else "ou")]
            agreed = (
                seen[0][i] if all(abs(s[i] - seen[0][i]) <= ANGLE_TOLERANCE_DEG for s in seen)
                else 0.0
                for i in (0, 1)
            )  # fmt: skip
            start, end = agreed
            flanges = _instead(flanges, (start, end), least)
    ends = []
    for side, web, flange in ((-1, webs[0], flanges[0]), (1, webs[1], flanges[1])):
        web = web if abs(web) >= least else 0.0
        flange = flange if abs(flange) >= least else 0.0
        x_0, t, s = 0.0 if side < 0 else part.length, 0.0, 0.0
        if web or flange:
            # x(y, z) runs through the outermost corner, which lies on x = 0 or x = length.
            t, s = tan(radians(web)), tan(radians(flange))
            leans = [y * t + z * s for y, z in corners(part.profile, part.section)]
            x_0 += max(leans) if side < 0 else min(leans)
        ends.append(End(side, web, flange, x_0, t, s))
    return ends[0], ends[1]


def _instead(
    angles: tuple[float, float], drawn: tuple[float, float], least: float
) -> tuple[float, float]:
    """The header's angles, and what is drawn where they are 0."""
    start, end = (a if abs(a) >= least else d for a, d in zip(angles, drawn, strict=True))
    return start, end


def _drawn(part: Part, face: Face) -> tuple[float, float]:
    """Angles of start and end as an outline has them; 0 where either is not a straight line."""
    outlines = [
        f for f in part.features
        if isinstance(f, Contour) and f.face == face and f.kind == "outer"
    ]  # fmt: skip
    if len(outlines) != 1 or not all(isinstance(c, Line) for c in outlines[0].curves):
        return 0.0, 0.0
    points = [c.start for c in outlines[0].curves]
    ys = [y for _, y in points]
    low, high = min(ys), max(ys)
    if high - low < OUTLINE_TOLERANCE:
        return 0.0, 0.0
    bottom = [x for x, y in points if y <= low + OUTLINE_TOLERANCE]
    top = [x for x, y in points if y >= high - OUTLINE_TOLERANCE]
    within = [
        p for p in points if low + OUTLINE_TOLERANCE < p[1] < high - OUTLINE_TOLERANCE
    ]  # fmt: skip
    ends = (
        (min(bottom), min(top), [p for p in within if p[0] < part.length / 2]),
        (max(bottom), max(top), [p for p in within if p[0] > part.length / 2]),
    )
    for x_low, x_high, between in ends:
        for x, y in between:
            if abs(x - x_low - (x_high - x_low) * (y - low) / (high - low)) > OUTLINE_TOLERANCE:
                return 0.0, 0.0  # what is not sawn says nothing of the saw
    start, end = (degrees(atan2(a - b, high - low)) for a, b, _ in ends)
    return (
        start if abs(start) > ANGLE_TOLERANCE_DEG else 0.0,
        end if abs(end) > ANGLE_TOLERANCE_DEG else 0.0,
    )


def off_outline(contour: Contour, part: Part, ends: tuple[End, End]) -> Point | None:
    """The first point of an outer contour off the sawn stock; None if there is none.

    Every point of it has to lie on a long edge or an end, and every corner of the sawn face has
    to be a point of it. A skew cut leaves a plate's end skew through its thickness, and either
    surface may be drawn.
    """
    width = part.profile.face_width(contour.face)
    points = [c.start for c in contour.curves]
    points += [c.point(0.5) for c in contour.curves if not isinstance(c, Line)]
    fixed = None
    if ends[0].square and ends[1].square:
        fixed = [_span(end, contour.face, part.profile, 0.0) for end in ends]
    for x, y in points:
        spans = fixed or [_span(end, contour.face, part.profile, y) for end in ends]
        on_edge = min(abs(y), abs(y - width)) <= OUTLINE_TOLERANCE
        at_end = x <= spans[0][1] or x >= spans[1][0]
        if not (spans[0][0] <= x <= spans[1][1]) or not (on_edge or at_end):
            return x, y
    for corner in (0.0, width):
        for end in ends:
            least, greatest = _span(end, contour.face, part.profile, corner)
            if not any(
                least <= x <= greatest and abs(y - corner) <= OUTLINE_TOLERANCE for x, y in points
            ):
                return (least + greatest) / 2, corner
    return None


def _span(end: End, face: Face, profile: Profile, q: float) -> tuple[float, float]:
    """Minimum and maximum x at which an end may be drawn on a face, at its coordinate q."""
    if end.square:
        return end.x_0 - OUTLINE_TOLERANCE, end.x_0 + OUTLINE_TOLERANCE
    height, thick, web = profile.height, profile.flange_thickness, profile.web_thickness or 0.0
    if face in ("o", "u"):
        surfaces = (height - thick, height) if face == "o" else (0.0, thick)
        xs = [end.x(y, q) for y in surfaces]
    else:
        middle = (profile.width - web) / 2 if profile.code == "I" else 0.0
        if profile.code == "M" and face == "v":
            middle = profile.width - web
        whole = profile.code in ("SO", "RO", "RU")
        xs = [end.x(q, z) for z in ((0.0, profile.width) if whole else (middle, middle + web))]
    return min(xs) - OUTLINE_TOLERANCE, max(xs) + OUTLINE_TOLERANCE
