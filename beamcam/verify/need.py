"""What a part needs: where its ends lie and which of its features want an operation.

Computed from the part alone, and not by the planner. Both ends follow DSTV's formula

    angle = atan2(x(lowest y) - x(highest y), height)      so      x(y) = x(0) - y tan(angle)

and touch x = 0 and x = length at their furthest points.
"""

from collections.abc import Collection, Iterator
from math import atan2, cos, degrees, radians, tan
from typing import NamedTuple

from beamcam.geometry.curves import Line, Point
from beamcam.machine.machine import Machine, Saw
from beamcam.model.part import Bend, Camber, Contour, EndPlane, Feature, Hole, Part, Slot, TextMark

FeatureRef = tuple[int, int]  #: index of the part on the bar, index of its feature

OUTLINE_TOLERANCE = 1.0  #: mm that exporters leave between outline and header
ANGLE_TOLERANCE_DEG = 0.2  #: between a bevel and the mitre that makes it


class End(NamedTuple):
    """The plane of one end of a part."""

    side: int  #: -1 start, +1 end: on which side of it the waste lies
    angle: float  #: degrees, DSTV's web angle; 0 is square
    x_0: float  #: x on the part at y = 0

    @property
    def name(self) -> str:
        return "start" if self.side < 0 else "end"

    def x(self, y: float) -> float:
        return self.x_0 - y * tan(radians(self.angle)) if self.angle else self.x_0

    def blade(self, saw: Saw, height: float) -> float:
        """Where the blade's middle stands, on the part's x, on the saw's pivot edge."""
        kerf = saw.kerf
        if self.angle and saw.kerf_along == "normal":
            kerf /= cos(radians(self.angle))
        return self.x(height if saw.pivot == "o" else 0.0) + self.side * kerf / 2


def ends_of(part: Part, saw: Saw) -> tuple[End, End]:
    """Start and end of a part: by the header's angles, by the outline where they are 0."""
    height = part.profile.height
    angles = []
    for side, angle in ((-1, part.cuts.web_start), (1, part.cuts.web_end)):
        if abs(angle) < saw.least_mitre:
            angle = _drawn_angle(part, side)
            angle = angle if abs(angle) > ANGLE_TOLERANCE_DEG else 0.0
        angles.append(angle)
    start, end = angles
    return (
        End(-1, start, max(0.0, height * tan(radians(start))) if start else 0.0),
        End(1, end, part.length + (min(0.0, height * tan(radians(end))) if end else 0.0)),
    )


def _drawn_angle(part: Part, side: int) -> float:
    """Angle of an end as the web's outline has it; 0 where it is no straight line there."""
    outlines = [c for c in part.contours if c.face == "v" and c.kind == "outer"]
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
    return degrees(atan2(bottom - top, high - low))


def off_outline(contour: Contour, part: Part, ends: tuple[End, End]) -> Point | None:
    """Where an outer contour leaves what the sawn stock is; None if it does not.

    Every point of it has to lie on a long edge or an end, and every corner of the sawn face has
    to be a point of it. A mitre leaves a flange's end skew, and either surface may be drawn.
    """
    width = part.profile.face_width(contour.face)
    points = [c.start for c in contour.curves]
    points += [c.point(0.5) for c in contour.curves if not isinstance(c, Line)]
    for x, y in points:
        spans = [_span(end, contour.face, part, y) for end in ends]
        on_edge = min(abs(y), abs(y - width)) <= OUTLINE_TOLERANCE
        at_end = x <= spans[0][1] or x >= spans[1][0]
        if not (spans[0][0] <= x <= spans[1][1]) or not (on_edge or at_end):
            return x, y
    for corner in (0.0, width):
        for end in ends:
            least, greatest = _span(end, contour.face, part, corner)
            if not any(
                least <= x <= greatest and abs(y - corner) <= OUTLINE_TOLERANCE for x, y in points
            ):
                return (least + greatest) / 2, corner
    return None


def _span(end: End, face: str, part: Part, y: float) -> tuple[float, float]:
    """Least and greatest x at which an end may be drawn on a face."""
    profile = part.profile
    if face == "o":
        heights = (profile.height - profile.flange_thickness, profile.height)
    elif face == "u":
        heights = (0.0, profile.flange_thickness)
    else:
        heights = (y, y)
    xs = [end.x(at) for at in heights]
    return min(xs) - OUTLINE_TOLERANCE, max(xs) + OUTLINE_TOLERANCE


def unsawn(feature: Feature, part: Part, ends: tuple[End, End]) -> tuple[str, Point | None] | None:
    """What of a feature neither saw nor drill makes: its name, and a place of an outline.

    None for holes, which are compared one by one, and for outlines that the saw cuts give.
    """
    match feature:
        case Hole():
            return None
        case Contour(process="cut", kind="outer"):
            off = off_outline(feature, part, ends)
            if off is not None:
                return "cope", off
            for bevel in feature.bevels:
                sawn = any(
                    abs(abs(bevel.angle) - abs(e.angle)) <= ANGLE_TOLERANCE_DEG for e in ends
                )
                if feature.face in ("v", "h") or not sawn:
                    return "bevel", None
            return None
        case Contour(process="cut"):
            return "cutout", None
        case Slot():
            return "slot", None
        case Contour() | TextMark():
            return "mark", None
        case Bend() | EndPlane() | Camber():
            return "other", None


def tool_for(hole: Hole, machine: Machine) -> float | None:
    """Diameter of the machine's tool that a hole wants; None if there is none within the fit.

    The nearest one, of two equally near the smaller.
    """
    kind = HOLE_TOOLS.get(hole.kind)
    limits = fit(hole.diameter, machine)
    if kind is None or limits is None:
        return None
    least, greatest = limits
    sizes = [
        (abs(d - hole.diameter), d)
        for tools in machine.tools
        if tools.kind == kind
        for d in tools.sizes
        if least - 1e-9 <= d <= greatest + 1e-9
    ]
    return min(sizes)[1] if sizes else None


def fit(diameter: float, machine: Machine) -> tuple[float, float] | None:
    """Least and greatest tool for a hole; None if the machine says nothing about that size."""
    for row in machine.drill.fits if machine.drill else ():
        if diameter <= row.up_to:
            return diameter - row.minus, diameter + row.plus
    return None


#: Which kind of tool makes which kind of hole.
HOLE_TOOLS = {"through": "drill", "blind": "drill"}


def skippable(
    parts: Collection[Part], machine: Machine, names: Collection[str]
) -> frozenset[FeatureRef]:
    """The features that may be left out under the names that `--allow-skips` takes."""
    if machine.saw is None:
        raise TypeError(f"{machine.name} has no saw")
    return frozenset(
        (p, f)
        for p, part in enumerate(parts)
        for ends in (ends_of(part, machine.saw),)
        for f, feature in enumerate(part.features)
        if not set(_names(feature, part, ends, machine)).isdisjoint(names)
    )


def _names(feature: Feature, part: Part, ends: tuple[End, End], machine: Machine) -> Iterator[str]:
    found = unsawn(feature, part, ends)
    if found is not None:
        yield found[0]
    if isinstance(feature, Hole):
        if all(s.face != feature.face for s in machine.spindles):
            yield "face"
        elif tool_for(feature, machine) is None:
            yield "tool"
        width = part.profile.face_width(feature.face)
        if not (0 <= feature.x <= part.length and 0 <= feature.y <= width):
            yield "off-face"
