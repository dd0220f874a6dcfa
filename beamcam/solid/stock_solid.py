"""A part before its features: its section between two end planes, a plate within its outline.

`Margins` says how far its ends, and the voids of its features, may lie off what is drawn.
"""

from collections.abc import Callable, Iterator
from math import atan2, degrees, radians, tan
from typing import TYPE_CHECKING, Any

from msgspec import Struct
from msgspec.structs import replace
from shapely import Polygon

from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.polylines import polylines
from beamcam.model.part import Contour, Feature, Part
from beamcam.solid.kernel import (
    CHORD,
    FLAT_DEG,
    FREE,
    Frame,
    behind,
    corners,
    outline,
    prism,
    walls,
)

if TYPE_CHECKING:
    from manifold3d import Manifold

Shape = Any  #: of shapely
AGREE_DEG = 0.2  #: between the outlines of both flanges
LEAST_ANGLE = 0.02  #: degrees; nearer to square is noise of a file
MINOR = 1.0825  #: pitches between the diameters of a nut's thread (ISO 724)


class Margins(Struct, frozen=True):
    """How much larger each void is than drawn; what is below 0 makes it smaller."""

    radius: Callable[[float], float] = lambda diameter: 0.0  #: of a hole, by its diameter
    depth: float = 0.0  #: of what is not through
    end: float = 0.0  #: off each end, along the part
    outline: float = 0.0  #: into the steel along contours
    point_deg: float = FLAT_DEG  #: blind holes end in such a point, beyond their depth
    minor: float = MINOR  #: pitches that a thread's core is smaller than its diameter
    run_out: float = 0.0  #: of a blind thread's core below the thread
    sink: float = 0.0  #: of a countersink's depth
    square_below: float = LEAST_ANGLE  #: degrees; ends nearer to square are square
    skin: float = 0.0  #: off all surfaces of the stock
    #: that an outline may lie off the ends and mean them; real files differ by 0.7
    noise: float = 1.0
    section: Shape | None = None  #: the stock's, in (Y, Z), where a file shows more than measures


AS_DRAWN = Margins()
Void = tuple[Feature, "Manifold"]
#: Takes (Y, Z, depth) of a section to (x, y, z).
ALONG: Frame = ((0.0, 0.0, 1.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))


def shape_of(curves: tuple[Curve, ...]) -> Shape:
    """The inside of a closed chain of curves, chords within CHORD of it."""
    outline = polylines(curves, CHORD)
    ring = [
        tuple(point)
        for k in range(len(curves))
        for point in outline.points[outline.begins[k] : outline.begins[k + 1] - 1].tolist()
    ]
    ring.append(curves[-1].end)
    return Polygon(ring).buffer(0) if len(ring) > 2 else Polygon()


def is_cut(contour: Contour) -> bool:
    return contour.closed and contour.process == "cut" and contour.kind != "open"


def has_outline(part: Part) -> bool:
    return any(c.kind == "outer" and is_cut(c) and c.face in ("v", "h") for c in part.contours)


def plate_shape(part: Part, outline_margin: float = 0.0) -> Shape | None:
    """A plate in (x, y) within its outline, less its inner contours; None without an outline.

    The largest contours count first, so that what lies within a cut-out is steel again.
    """
    if not has_outline(part):
        return None
    cut = [c for c in part.contours if is_cut(c) and c.face in ("v", "h")]
    shapes = sorted(((shape_of(c.curves), c.kind) for c in cut), key=lambda s: -s[0].area)
    whole: Shape = Polygon()
    for shape, kind in shapes:
        whole = whole.union(shape) if kind == "outer" else whole.difference(shape)
    if outline_margin:
        whole = whole.buffer(-outline_margin, join_style="mitre")
    return whole


def stock_solid(part: Part, margins: Margins = AS_DRAWN) -> "Manifold":
    """The part before its features, between its two end planes; a plate within its outline."""
    section, skin = outline(part) if margins.section is None else margins.section, margins.skin
    shape = plate_shape(part, margins.outline) if part.profile.code == "B" else None
    if shape is not None:
        wall = walls(part.profile)["v"]
        body = prism(shape, skin, wall.thickness - skin, wall.frame)
        if max(abs(part.cuts.flange_start), abs(part.cuts.flange_end)) < 0.2:
            return body
    else:
        over = part.profile.height + part.profile.width + FREE
        section = section.buffer(-skin, join_style="mitre") if skin else section
        body = prism(section, -over, part.length + over, ALONG)
    for point, normal in end_planes(part, margins):
        body = behind(body, point, normal)
    return body


def end_planes(
    part: Part, margins: Margins = AS_DRAWN, drawn: bool = False
) -> Iterator[tuple[Any, Any]]:
    """A point and the outward normal of each end, with `drawn` as its outlines have it too.

    x = c - y tan(web) - z tan(flange), by DSTV's formula for both ends; the plane touches x = 0 or
    x = length at the outermost corner of the section.
    """
    cuts = part.cuts
    for side, web, flange in (
        (-1, cuts.web_start, cuts.flange_start), (1, cuts.web_end, cuts.flange_end)
    ):  # fmt: skip
        if drawn:
            web = web if abs(web) >= LEAST_ANGLE else _drawn(part, "v", side)[0]
            flange = flange if abs(flange) >= LEAST_ANGLE else _drawn(part, "ou", side)[0]
        web = web if abs(web) >= margins.square_below else 0.0
        flange = flange if abs(flange) >= margins.square_below else 0.0
        rise, lean = -tan(radians(web)), -tan(radians(flange))
        reach = [rise * y + lean * z for y, z in corners(part)] if web or flange else [0.0]
        x = part.length - max(reach) if side > 0 else -min(reach)
        yield (x - side * margins.end, 0.0, 0.0), (side, -side * rise, -side * lean)


def _drawn(part: Part, faces: str, side: int) -> tuple[float, Contour | None]:
    """The angle of an end that the outlines of some faces draw as one straight line from edge to
    edge, and one of them; of two flanges where both agree. A plate's ends are in its outline."""
    outer = [
        c for c in part.contours if c.face in faces and c.kind == "outer" and c.process == "cut"
    ]
    lines = [_line_across(c, part, side) for c in outer]
    two_flanges = part.profile.code in ("I", "U", "C", "M")
    there = not two_flanges or {c.face for c in outer} == set(faces)
    if part.profile.code == "B" or not lines or not there or max(lines) - min(lines) > AGREE_DEG:
        return 0.0, None
    return lines[0], outer[0] if lines[0] else None


def _line_across(contour: Contour, part: Part, side: int) -> float:
    """The angle in degrees of the straight line that ends an outline on one side; 0 without one."""
    ys = [y for c in contour.curves for _, y in (c.start, c.end)]
    low, high = min(ys), max(ys)
    for c in contour.curves:
        (xa, ya), (xb, yb) = sorted((c.start, c.end), key=lambda p: p[1])
        across = isinstance(c, Line) and ya - low < 0.5 and high - yb < 0.5
        if across and abs(xb - xa) > 0.5 and (xa + xb > part.length) == (side > 0):
            return degrees(atan2(xa - xb, yb - ya))
    return 0.0


def drawn_ends(part: Part, margins: Margins) -> Iterator[Void]:
    """What skew ends take that only outlines have, each by one of its outlines."""
    by_header, drawn = end_planes(part, margins), end_planes(part, margins, True)
    for side, header, (point, normal) in zip((-1, 1), by_header, drawn, strict=True):
        if header != (point, normal):
            contour = _drawn(part, "v", side)[1] or _drawn(part, "ou", side)[1]
            body = stock_solid(part, replace(margins, end=-FREE))  # to the air behind a square end
            if contour is not None:
                yield contour, body - behind(body, point, normal)
