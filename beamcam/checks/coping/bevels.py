"""Passes that make weld preparations, found among a program's strokes.

A bevel with the angle b takes of a wall t thick (t - land) tan(b) at the surface that the torch
looks at, and nothing from the land on; one of the far side land tan(b) there, and nothing above. A
stroke makes it that is tilted so and runs along its edge, half a kerf off what stays; any other
tilted stroke is none. It comes after the square cut along that edge, of the far side before it,
and before the piece is parted from its bar.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import atan2, cos, degrees, hypot, radians, sin, tan
from typing import Any

from msgspec import Struct

from beamcam.checks.coping import rules
from beamcam.checks.coping.section import CoperSection, other_side
from beamcam.checks.coping.strokes import ANGLE_SLACK_DEG, TorchStroke
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.model.part import Bevel, Contour, Part

Shape = Any  #: of shapely

AT_EDGE = 1.0  #: mm from an edge of its wall within which a drawn place means that edge
OFF_PASS = 0.1  #: mm that a pass may lie beside where its bevel has it
HAIR = 1e-3  #: mm that what is taken is larger, so that no hair of it stays
BESIDE = 0.1  #: mm that a square cut may lie beside the edge that it makes


class BevelPass(Struct, frozen=True):
    """A bevel of a part, and the stroke that makes it."""

    feature: int
    bevel: Bevel
    stroke: TorchStroke
    start: Point
    end: Point
    thickness: float
    drawn: Bevel  #: as the contour has it, from whichever side

    @property
    def is_lower(self) -> bool:
        """Whether it is of the far side of its wall."""
        return self.bevel.angle < 0.0

    def strip(self, depth: float) -> Shape:
        """What it takes of its wall, so far below the face."""
        from shapely import Polygon

        over_land = self.thickness - self.bevel.land - depth
        wide = max(0.0, over_land * tan(radians(self.bevel.angle)))
        turn = atan2(self.end[1] - self.start[1], self.end[0] - self.start[0])
        dx, dy = -sin(turn) * wide, cos(turn) * wide
        (xa, ya), (xb, yb) = self.start, self.end
        if not wide:
            return Polygon()
        whole = Polygon([(xa, ya), (xb, yb), (xb + dx, yb + dy), (xa + dx, ya + dy)])
        return whole.buffer(HAIR, join_style="mitre")


def passes_of(
    part: Part, section: CoperSection, coper: Coper, strokes: Sequence[TorchStroke]
) -> list[BevelPass]:
    """The bevels of a part that strokes make, each stroke once."""
    from shapely import Polygon

    passes: list[BevelPass] = []
    if section.lip:  # a pass would go on into a lip
        return passes
    for f, contour in enumerate(part.features):
        if not isinstance(contour, Contour) or contour.kind != "outer":
            continue
        face = "v" if contour.face == "h" else contour.face
        if face not in section.faces:
            continue
        for bevel in contour.bevels:
            curve = contour.curves[bevel.curve]
            if abs(bevel.angle) < coper.min_bevel or not isinstance(curve, Line):
                continue
            asked = bevel
            if contour.face == "h":  # seen through the web
                asked = other_side(bevel, section.web)
            wide = section.high if face == "v" else section.wide
            ends = [_at_edge(place, wide) for place in (curve.start, curve.end)]
            if not Polygon([c.start for c in contour.curves]).exterior.is_ccw:
                ends.reverse()  # so that the steel lies on the left
            thick = section.thickness(face)
            one = next(
                (s for s in strokes if s.face == face
                 and all(s is not other.stroke for other in passes)
                 and _makes(s, asked, ends[0], ends[1], thick, coper.over)),
                None,
            )  # fmt: skip
            if one is not None:
                passes.append(BevelPass(f, asked, one, ends[0], ends[1], thick, bevel))
    return passes


def _at_edge(place: Point, wide: float) -> Point:
    x, y = place
    return x, 0.0 if abs(y) <= AT_EDGE else wide if abs(y - wide) <= AT_EDGE else y


def _makes(
    stroke: TorchStroke, bevel: Bevel, start: Point, end: Point, thick: float, over: float
) -> bool:
    """Whether a stroke is the pass of a bevel, `over` mm longer than its edge and half a kerf."""
    long = hypot(end[0] - start[0], end[1] - start[1])
    dx, dy = (end[0] - start[0]) / long, (end[1] - start[1]) / long
    if not dy or not stroke.b_deg:
        return False
    b_deg = -degrees(atan2(tan(radians(bevel.angle)) * (1 if dy > 0 else -1), abs(dy)))
    if abs(stroke.b_deg - b_deg) > 2 * ANGLE_SLACK_DEG:
        return False
    half = stroke.row.kerf / 2
    reach = hypot(half / stroke.share * dy, half * dx)
    wanted = (thick - bevel.land) * tan(radians(bevel.angle)) - reach
    along = [((x - start[0]) * dx + (y - start[1]) * dy) for x, y in stroke.points[1:]]
    inside = [((x - start[0]) * -dy + (y - start[1]) * dx) for x, y in stroke.points[1:]]
    whole = bool(along) and min(along) <= -half and max(along) >= long + half
    most = half + over + OFF_PASS
    whole = whole and min(along) >= -most and max(along) <= long + most
    return whole and all(abs(one - wanted) <= OFF_PASS for one in inside)


def pass_faults(
    passes: Sequence[BevelPass], strokes: Sequence[TorchStroke], far: Mapping[int, bool], name: str
) -> Iterator[Diagnostic]:
    """Passes before the square cut along their edge, or of a piece that is parted already.

    `far` says of each stroke by its line whether it is of the far end of a bar.
    """
    from shapely import LineString
    from shapely import Point as Place

    of_pass = {one.stroke.line for one in passes}
    square = [s for s in strokes if s.line not in of_pass]
    parted = max((s.line for s in square if far.get(s.line)), default=0)
    for one in passes:
        middle = (one.start[0] + one.end[0]) / 2, (one.start[1] + one.end[1]) / 2
        along = [
            s.line for s in square
            if s.face == one.stroke.face and not s.b_deg
            and abs(LineString(s.points).distance(Place(middle)) - s.row.kerf / 2) <= BESIDE
        ]  # fmt: skip
        if one.is_lower:
            if not along or min(along) < one.stroke.line:
                yield rules.PASSES.at(
                    Source(name, one.stroke.line), face=one.stroke.face,
                    expected="before the square cut along its edge, through all of the wall",
                )  # fmt: skip
        elif one.strip(0.0).distance(Place(one.stroke.points[0])) > BESIDE:
            x, y = one.stroke.points[0]
            yield rules.AIR.at(
                Source(name, one.stroke.line), x=f"{x:.1f}", y=f"{y:.1f}", face=one.stroke.face
            )
        elif not along or min(along) > one.stroke.line:
            yield rules.PASSES.at(
                Source(name, one.stroke.line), face=one.stroke.face,
                expected="after the square cut along its edge, which leaves the land",
            )  # fmt: skip
        elif far.get(one.stroke.line) and one.stroke.line > parted:
            yield rules.PASSES.at(
                Source(name, one.stroke.line), face=one.stroke.face,
                expected="before the cut that parts the piece from its bar",
            )  # fmt: skip
