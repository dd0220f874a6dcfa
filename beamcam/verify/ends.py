"""Where the ends of a part lie, and which outlines they explain.

Computed from the part alone, and not by the planner. Both ends follow DSTV's formula, of the web
in y and of the flange in z (across, from the h side):

    angle = atan2(x(lowest) - x(highest), height)      so      x = c - y tan(web) - z tan(flange)

and touch x = 0 and x = length at their furthest points.
"""

from math import atan, atan2, cos, degrees, hypot, radians, tan
from typing import NamedTuple

from beamcam.geometry.curves import Line, Point
from beamcam.machine.machine import Saw
from beamcam.model.part import Contour, Face, Part, Profile

OUTLINE_TOLERANCE = 1.0  #: mm that exporters leave between outline and header
ANGLE_TOLERANCE_DEG = 0.2  #: between header and outline, and between a bevel and its mitre


class End(NamedTuple):
    """The plane of one end of a part."""

    side: int  #: -1 start, +1 end: on which side of it the waste lies
    web: float  #: degrees, DSTV's web angle
    flange: float  #: and its flange angle; both 0 is square
    x_0: float  #: x on the part at y = 0, z = 0

    @property
    def name(self) -> str:
        return "start" if self.side < 0 else "end"

    @property
    def square(self) -> bool:
        return not self.web and not self.flange

    def x(self, y: float, z: float = 0.0) -> float:
        if self.square:
            return self.x_0
        return self.x_0 - y * tan(radians(self.web)) - z * tan(radians(self.flange))

    def kerf(self, saw: Saw) -> float:
        """Length of bar that its cut takes: the blade's thickness, along the bar if it is so."""
        if self.square or saw.kerf_along != "normal":
            return saw.kerf
        return saw.kerf * hypot(1.0, tan(radians(self.web)), tan(radians(self.flange)))

    def blade(self, saw: Saw, height: float) -> float:
        """Where the blade's middle stands, on the part's x, on the saw's pivot edge."""
        return self.x(height if saw.pivot == "o" else 0.0) + self.side * self.kerf(saw) / 2

    def saw_angles(self, saw: Saw) -> tuple[float, float]:
        """Angle and tilt in the machine's counting.

        A blade turned by w and then tilted by t has the normal (cos t cos w, cos t sin w, sin t),
        which has to be along (1, tan w, tan f), so tan t = tan f cos w.
        """
        tilt = degrees(atan(tan(radians(self.flange)) * cos(radians(self.web))))
        return saw.square + saw.angle_sign * self.web, saw.tilt_sign * tilt + 0.0


def ends_of(part: Part, saw: Saw) -> tuple[End, End]:
    """Start and end of a part: by the header's angles, by the outlines where they are 0."""
    cuts, least = part.cuts, saw.least_mitre
    ends = []
    for side, web, flange in (
        (-1, cuts.web_start, cuts.flange_start),
        (1, cuts.web_end, cuts.flange_end),
    ):
        if abs(web) < least:
            web = _drawn(part, "v", side)
        if abs(flange) < least:
            seen = [_drawn(part, f, side) for f in ("u" if part.profile.code == "L" else "ou")]
            flange = seen[0] if max(seen) - min(seen) <= ANGLE_TOLERANCE_DEG else 0.0
        web = web if abs(web) >= least else 0.0
        flange = flange if abs(flange) >= least else 0.0
        # x(y, z) runs through the outermost corner, which lies on x = 0 or x = length.
        leans = [
            y * tan(radians(web)) + z * tan(radians(flange)) for y, z in _corners(part.profile)
        ]
        ends.append(End(side, web, flange, max(leans) if side < 0 else part.length + min(leans)))
    return ends[0], ends[1]


def _corners(profile: Profile) -> tuple[Point, ...]:
    """The outermost places (y, z) of a section that hold material."""
    height, width = profile.height, profile.width
    if profile.code == "L":
        return (0.0, 0.0), (height, 0.0), (0.0, width)
    if profile.code == "T":
        return (0.0, 0.0), (height, 0.0), (height / 2, width)
    return (0.0, 0.0), (height, 0.0), (0.0, width), (height, width)


def _drawn(part: Part, face: Face, side: int) -> float:
    """Angle of an end as an outline has it; 0 where it is no straight line, or nearly square."""
    outlines = [c for c in part.contours if c.face == face and c.kind == "outer"]
    if len(outlines) != 1 or not all(isinstance(c, Line) for c in outlines[0].curves):
        return 0.0
    points = [c.start for c in outlines[0].curves]
    low, high = min(y for _, y in points), max(y for _, y in points)
    if high - low < OUTLINE_TOLERANCE:
        return 0.0
    last = max if side > 0 else min
    bottom = last(x for x, y in points if y <= low + OUTLINE_TOLERANCE)
    top = last(x for x, y in points if y >= high - OUTLINE_TOLERANCE)
    for x, y in points:
        expected = bottom + (top - bottom) * (y - low) / (high - low)
        inside = low + OUTLINE_TOLERANCE < y < high - OUTLINE_TOLERANCE
        if inside and abs(x - expected) > OUTLINE_TOLERANCE and (x - part.length / 2) * side > 0:
            return 0.0
    angle = degrees(atan2(bottom - top, high - low))
    return angle if abs(angle) > ANGLE_TOLERANCE_DEG else 0.0


def off_outline(contour: Contour, part: Part, ends: tuple[End, End]) -> Point | None:
    """Where an outer contour leaves what the sawn stock is; None if it does not.

    Every point of it has to lie on a long edge or an end, and every corner of the sawn face has
    to be a point of it. A skew cut leaves a plate's end skew through its thickness, and either
    surface may be drawn.
    """
    width = part.profile.face_width(contour.face)
    points = [c.start for c in contour.curves]
    points += [c.point(0.5) for c in contour.curves if not isinstance(c, Line)]
    for x, y in points:
        spans = [_span(end, contour.face, part.profile, y) for end in ends]
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
    """Least and greatest x at which an end may be drawn on a face, at its coordinate q."""
    if end.square:
        return end.x_0 - OUTLINE_TOLERANCE, end.x_0 + OUTLINE_TOLERANCE
    height, thick, web = profile.height, profile.flange_thickness, profile.web_thickness or 0.0
    if face in ("o", "u"):
        surfaces = (height - thick, height) if face == "o" else (0.0, thick)
        xs = [end.x(y, q) for y in surfaces]
    else:
        middle = (profile.width - web) / 2 if profile.code == "I" else 0.0
        whole = profile.code in ("M", "SO", "RO", "RU")
        xs = [end.x(q, z) for z in ((0.0, profile.width) if whole else (middle, middle + web))]
    return min(xs) - OUTLINE_TOLERANCE, max(xs) + OUTLINE_TOLERANCE
