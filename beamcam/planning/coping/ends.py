"""The ends of a bar or a piece: planes, where they end each wall, and how a torch cuts them.

An end is a plane, x = at - y tan(web) - z tan(flange), with DSTV's angles. A wall that it crosses
square is cut along a slanted line. One that it leans over is cut with the torch tilted along the
bar, so that the cut face is the plane, through the root too; without B, or beyond its reach, square
where the wall reaches farthest. Then web and flange are cut at one x where they meet:

    \\ |    o    x      the plane
     \\|____|_   \\|     the cut; below a flange it goes square as deep as a pass through
      |     v   |     the root does, so that no steel is missing
      |\\
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from math import atan, cos, degrees, radians, sin, tan
from typing import Any, Literal

from msgspec import Struct
from msgspec.structs import replace
from shapely import Polygon

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Line, Point
from beamcam.machine.coper import Coper
from beamcam.model.part import Bevel, Contour, EndCuts, Face, Part, Profile, extent
from beamcam.model.section import corners
from beamcam.planning import rules as bar_rules
from beamcam.planning.coping.cuts import borders_of, chains_of
from beamcam.planning.coping.regions import OUTLINE_NOISE, Shape, WallRegion
from beamcam.planning.coping.walls import EDGE, EndLine, PlannedWall, web_back

NOISE_DEG = 0.2  #: of an end cut; header and outlines may differ by as much
ON_LINE = 0.02  #: mm that an edge of a region lies off the end that it is
STEEPEST_DEG = 30.0  #: of a line that a square step may begin on
AT: tuple[Literal["start", "end"], ...] = ("start", "end")
Pair = tuple[bool, bool]


class SectionEnd(Struct, frozen=True):
    """The plane of one end in the section's axes."""

    side: int  #: -1 at the start, 1 at the end
    at: float  #: x at y 0, z 0
    by_y: float
    by_z: float

    def x(self, y: Any, z: Any) -> Any:
        return self.at - self.by_y * y - self.by_z * z

    @property
    def is_skew(self) -> bool:
        return bool(self.by_y or self.by_z)

    def farthest(self, ys: Sequence[float], zs: Sequence[float]) -> float:
        """The outermost x over some places."""
        return float(self.side * max(self.side * self.x(y, z) for y in ys for z in zs))


def plane_at(part: Part, side: int, by_y: float, by_z: float) -> SectionEnd:
    """The plane of an end of a part as it lies, through its outermost corner at x 0 or L."""
    leans = [side * (y * by_y + z * by_z) for y, z in _corners(part)]
    at = (0.0 if side < 0 else part.length) + side * min(leans)
    return SectionEnd(side, at, by_y, by_z)


def planes_of(part: Part) -> tuple[SectionEnd, SectionEnd]:
    """The start and the end of a part as it lies by its header."""
    cuts = part.cuts
    start = plane_at(part, -1, tan(radians(cuts.web_start)), tan(radians(cuts.flange_start)))
    return start, plane_at(part, 1, tan(radians(cuts.web_end)), tan(radians(cuts.flange_end)))


def _corners(part: Part) -> Sequence[Point]:
    """The outermost places (y, z) of a section as it lies."""
    profile = part.profile
    if profile.code != "T":
        return corners(profile, part.section)
    back = (profile.width - (profile.web_thickness or 0.0)) / 2
    flange, front = profile.flange_thickness, back + (profile.web_thickness or 0.0)
    ends = (0.0, 0.0), (0.0, profile.width), (flange, 0.0), (flange, profile.width)
    return *ends, (profile.height, back), (profile.height, front)


def outermost(part: Part) -> Iterator[tuple[float, float, float]]:
    """The corners of a part as it lies, by its header, and by its outlines where all walls have
    one: a wall without is as long as the part."""
    drawn = [c for c in part.contours if c.kind == "outer" and c.process == "cut"]
    walls = {"v", "u"} if part.profile.code in ("L", "T") else {"v", "o", "u"}
    is_drawn = walls <= {"v" if one.face == "h" else one.face for one in drawn}
    box = extent(curve for one in drawn for curve in one.curves) if is_drawn else None
    for end in planes_of(agreed_ends(part)[0]):
        for y, z in _corners(part):
            x = end.x(y, z)
            yield (min(max(x, box[0]), box[2]) if box else x), y, z


def ends_on(face: Face, part: Part) -> tuple[EndLine, EndLine]:
    """Where a wall ends, at its outermost."""
    start, end = planes_of(part)
    return _on_wall(start, face, part), _on_wall(end, face, part)


def _on_wall(plane: SectionEnd, face: Face, part: Part, is_tilted: bool = False) -> EndLine:
    """Where a plane ends a wall at its outermost, or meets the surface that the torch looks at as
    it is tilted to lie in the plane."""
    profile, back = part.profile, web_back(part.profile)
    edge = profile.height - profile.flange_thickness if face == "o" else 0.0
    slope, across = (plane.by_y, plane.by_z) if face == "v" else (plane.by_z, plane.by_y)
    thick = profile.web_thickness or 0.0 if face == "v" else profile.flange_thickness
    low = back if face == "v" else edge
    surfaces = [plane.at - across * (low + k * thick) for k in (0.0, 1.0)]
    outermost = min(surfaces) if plane.side < 0 else max(surfaces)
    line = EndLine(outermost, -slope, abs(across) * thick)
    if not is_tilted:
        return line
    b_deg = degrees(atan(across)) if face == "u" else -degrees(atan(across))
    return replace(line, at=surfaces[0 if face == "u" else 1], b_deg=b_deg)


def with_skew(wall: PlannedWall, part: Part, tilts: Pair) -> PlannedWall:
    """A wall of a bar with its skew ends; `tilts` says at which of them the torch is tilted."""
    start, end = (
        _on_wall(plane, wall.face, part, tilt) if plane.is_skew else None
        for plane, tilt in zip(planes_of(part), tilts, strict=True)
    )
    return replace(wall, skew=(start, end))


def agreed_ends(part: Part) -> tuple[Part, list[Diagnostic]]:
    """A part whose header has the ends that its outlines have, and what is wrong with them.

    A header without an angle takes that of the web's outline, or of all flanges' outlines, where a
    straight side goes from edge to edge there. A side that lies wholly within the header's end is
    that of a cope, and says nothing of it.
    """
    planes = planes_of(part)
    diagnostics: list[Diagnostic] = []
    angles: dict[str, float] = {}
    kinds: tuple[tuple[Literal["web", "flange"], tuple[Face, ...]], ...] = (
        ("web", ("v", "h")), ("flange", ("u",) if part.profile.code in ("L", "T") else ("o", "u"))
    )  # fmt: skip
    for kind, faces in kinds:
        drawn = [*map(partial(_drawn, part), faces)]
        for k, at in enumerate(AT):
            angle, source = getattr(part.cuts, f"{kind}_{at}"), part.cut_source(kind, at)
            sides = [(face, one[k]) for face, one in zip(faces, drawn, strict=True) if one[k]]
            seen = [_leaning(side) for _, side in sides]
            needed = 1 if kind == "web" else len(faces)
            if abs(angle) <= NOISE_DEG:
                same = len(seen) >= needed and max(seen) - min(seen) <= NOISE_DEG
                angle = seen[0] if same and abs(seen[0]) > NOISE_DEG else 0.0
                if angle:
                    diagnostics.append(bar_rules.CUT_FROM_CONTOUR.at(
                        source, kind=kind, found=f"{angle:.3f}", end=at))  # fmt: skip
            else:
                denied = []
                for face, side in sides:
                    end = _on_wall(planes[k], "v" if face == "h" else face, part)
                    is_within = all(  # on the steel's side of the end, clear of it
                        planes[k].side * (end.x(y) - x) > OUTLINE_NOISE + end.play for x, y in side
                    )
                    if not is_within and abs(_leaning(side) - angle) > NOISE_DEG:
                        denied.append(_leaning(side))
                if denied:
                    diagnostics.append(bar_rules.CUT_DENIED.at(
                        source, kind=kind, found=f"{angle:g}", end=at,
                        expected=f"{denied[0]:.3f}"))  # fmt: skip
            angles[f"{kind}_{at}"] = angle
    return replace(part, cuts=EndCuts(**angles)), diagnostics


Side = tuple[Point, Point]  #: of an outline, from the lower edge of its face to the upper one


def _leaning(side: Side) -> float:
    """The angle of a side in degrees, with DSTV's sign."""
    (xa, ya), (xb, yb) = side
    return degrees(atan((xa - xb) / (yb - ya)))


def _drawn(part: Part, face: Face) -> list[Any]:
    """The sides of a face's outline from edge to edge, at start and end; or None."""
    wide = part.profile.face_width(face)
    sides: list[Side | None] = [None, None]
    for contour in part.contours:
        if contour.face != face or contour.kind != "outer" or contour.process != "cut":
            continue
        middle = sum(c.start[0] for c in contour.curves) / len(contour.curves)
        for curve in contour.curves:
            (xa, ya), (xb, yb) = sorted((curve.start, curve.end), key=lambda p: p[1])
            if isinstance(curve, Line) and ya <= OUTLINE_NOISE and yb >= wide - OUTLINE_NOISE:
                sides[(xa + xb) / 2 > middle] = (xa, ya), (xb, yb)
    return sides


# --- how a skew end is cut ------------------------------------------------------------------------


def is_on(line: EndLine, points: Sequence[tuple[float, float]], off: float = 0.0) -> bool:
    """Whether places lie on an end, or `off` beside it."""
    long = cos(atan(line.slope))
    return all(abs(abs(x - line.x(y)) * long - off) <= ON_LINE for x, y in points)


def crossed(wall: PlannedWall, length: float) -> bool:
    """Whether the skew ends of a wall leave nothing of it at one of its edges."""
    start, end = (
        line or EndLine(at, 0.0) for line, at in zip(wall.skew, (0.0, length), strict=True)
    )
    return any(start.x(y) >= end.x(y) - OUTLINE_NOISE for y in (0.0, wall.width))


def edges_at(region: WallRegion, k: int) -> Iterator[tuple[tuple[float, float], ...]]:
    """The segments of a wall's edge between its sides that lie on an end in part."""
    wall, line = region.wall, region.wall.skew[k]
    if line is None:
        return
    low, high = max(wall.low, EDGE), min(wall.high, wall.width - EDGE)
    for chain in chains_of(region.shape, borders_of(wall, low, high, 0.0)):
        if any(is_on(line, pair) for pair in zip(chain.points, chain.points[1:], strict=False)):
            yield chain.points


def room_at(b_deg: float, coper: Coper) -> float:
    """How deep between flanges a tilted torch reaches before its holder, mm."""
    b = radians(abs(b_deg))
    return coper.torch_length * cos(b) - coper.head_width / 2 * sin(b) - coper.clearance


def tilts_at(regions: Mapping[Face, WallRegion], part: Part, k: int, coper: Coper) -> bool:
    """Whether the torch can be tilted to an end: each wall that it leans over ends in it alone."""
    front = web_back(part.profile) + (part.profile.web_thickness or 0.0)
    for region in regions.values():
        line = region.wall.skew[k]
        for edge in edges_at(region, k):
            assert line is not None
            if region.wall.face == "v" and part.profile.width - front > room_at(line.b_deg, coper):
                return False
            if abs(line.b_deg) > coper.tilt or (line.b_deg and not is_on(line, edge)):
                return False
    return True


def own_bevels(contour: Contour, part: Part, tilts: Sequence[bool], least: float) -> list[Bevel]:
    """The bevels of a contour of `least` degrees that no tilted end shows of itself."""
    angles = [
        degrees(atan(plane.by_z if contour.face in ("v", "h") else plane.by_y))
        for plane, tilt in zip(planes_of(part), tilts, strict=True) if tilt
    ]  # fmt: skip
    return [
        bevel for bevel in contour.bevels if abs(bevel.angle) >= least
        and all(abs(abs(bevel.angle) - abs(a)) > NOISE_DEG for a in angles)
    ]  # fmt: skip


def squared(
    regions: Mapping[Face, WallRegion], part: Part, k: int, depth: float
) -> tuple[dict[Face, WallRegion], dict[Face, float]]:
    """Regions whose walls meet square at an end that no tilt is for, and mm too much by wall.

    `depth` is that to which a pass through a root cuts.
    """
    walls, plane = dict(regions), planes_of(part)[k]
    lines = {face: region.wall.skew[k] for face, region in regions.items()}
    there = {face: [*edges_at(region, k)] for face, region in regions.items()}
    off = {face: line.play for face, line in lines.items() if line is not None and there[face]}
    for face in ("o", "u"):
        if face not in regions:
            continue
        line, web_line = lines[face], lines["v"]
        if line is not None and there[face] and regions[face].wall.lip:
            walls[face], mm = _as_long_as_lip(walls[face], line, part.profile, plane)
            off[face] = max(off[face], mm)
        if line is None or web_line is None or not (there[face] and there["v"]):
            continue
        wall, high = regions[face].wall, regions["v"].wall.width
        (root,) = wall.roots
        zs = max(root.low - EDGE, 0.0), min(root.high + EDGE, wall.width)
        ys = (high - depth - EDGE, high) if face == "o" else (0.0, depth + EDGE)
        x = plane.farthest(ys, zs)
        for one, edge, band in ((face, line, zs), ("v", web_line, ys)):
            more = stepped(edge, band, x, plane.side, regions[one].wall.width)
            walls[one] = replace(walls[one], shape=walls[one].shape.union(more))
            off[one] = max(off[one], *(abs(x - edge.x(y)) for y in band))
    return walls, off


def _as_long_as_lip(
    flange: WallRegion, line: EndLine, profile: Profile, plane: SectionEnd
) -> tuple[WallRegion, float]:
    """A flange that at its lip is as long as that, with which it is cut, and how many mm more."""
    high, lip, band = profile.height, profile.lip or 0.0, (0.0, flange.wall.lip)
    ys = (high - lip, high) if flange.wall.face == "o" else (0.0, lip)
    x = plane.farthest(ys, (0.0, flange.wall.low))
    mm = max(0.0, *(plane.side * (x - line.x(y)) for y in band))
    if mm <= ON_LINE:
        return flange, 0.0
    if plane.side * (line.x(band[1]) - x) > 0.0 and plane.side * line.slope > 0.0:
        band = 0.0, (x - line.at) / line.slope  # from where on the line reaches farther
    more = stepped(line, band, x, plane.side, flange.wall.width)
    return replace(flange, shape=flange.shape.union(more)), mm


def stepped(line: EndLine, band: tuple[float, float], x: float, side: float, wide: float) -> Shape:
    """What a wall has more where it ends at x on a band of it.

    Off the band it goes on until it meets the line where that is steep and reaches farther.
    """
    ys = list(band)
    for j, (y, edge, way) in enumerate(zip(band, (0.0, wide), (-1.0, 1.0), strict=True)):
        if abs(y - edge) <= EDGE:
            continue
        rises = side * line.slope * way > 0.0  # whether the line reaches farther on that side
        if rises and degrees(atan(abs(line.slope))) > STEEPEST_DEG:
            ys[j] = y + way * abs((x - line.x(y)) / line.slope)
            ys[j] = min(max(ys[j], 0.0), wide)
    inside = [(line.x(y) - side * OUTLINE_NOISE, y) for y in ys]
    (a, b), (c, d) = inside, [(side * max(side * x, side * line.x(y)), y) for y in ys]
    return Polygon([a, b, d, c])
