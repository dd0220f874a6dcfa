"""The pieces of a plate or a drawing, as plane shapes that a torch has to cut.

Closed contours enclose steel or cut-outs as their kinds say; what open ones enclose together is
found as the faces of their lines. Holes that a torch does not make are left, and told.
"""

from collections.abc import Iterator
from typing import Any, cast

from msgspec import Struct

from beamcam.geometry.polylines import polylines
from beamcam.machine.torch import Torch
from beamcam.model.colour import process_of
from beamcam.model.part import Contour, Feature, Hole, Part, Process, Slot
from beamcam.solid.kernel import CHORD, circle
from beamcam.solid.part_solid import end_planes, shape_of, slot_shape
from beamcam.solid.section import no_solid

Shape = Any  #: of shapely
SKIPS = ("tool", "slot", "countersink", "sink-depth", "thread-depth")  #: kinds of holes not made


class Plate(Struct, frozen=True):
    """A part's pieces in (x, y), and what of it a torch leaves."""

    part: Part
    thickness: float
    pieces: tuple[Shape, ...]
    slits: Shape  #: lines that are cut and enclose nothing
    left: tuple[tuple[Feature, Shape], ...]  #: holes for the drill


def thickness_of(part: Part, torch: Torch) -> float:
    """Of the part's sheet, or the machine's where the part does not say. Raises BeamcamError."""
    found = part.profile.web_thickness or torch.thickness or 0.0
    if not found > 0.0:
        raise no_solid(part, "a sheet without a thickness")
    return found


def plate_of(part: Part, torch: Torch, skips: tuple[str, ...]) -> Plate:
    """The pieces of a part as a torch cuts them, mirrored where it is asked to."""
    from shapely import Polygon, union_all
    from shapely.affinity import scale

    thickness = thickness_of(part, torch)
    whole, slits = _outlines(part, torch)
    left: list[tuple[Feature, Shape]] = []
    may_lack = torch.drilled == "mark" or "all" in skips or not {*SKIPS}.isdisjoint(skips)
    least = max(torch.min_hole, torch.min_hole_share * thickness)
    for feature, shape, width in _holes(part):
        made = feature.kind == "through" and feature.depth is None and width >= least
        if made or not may_lack:
            whole = whole.difference(shape)
        elif not any(shape.within(other) for _, other in left):
            left.append((feature, shape.intersection(whole)))
    if torch.mirror != "none":
        fx, fy = (-1.0, 1.0) if torch.mirror == "x" else (1.0, -1.0)
        whole, slits = (scale(s, fx, fy, origin=(0.0, 0.0)) for s in (whole, slits))
        left = [(f, scale(s, fx, fy, origin=(0.0, 0.0))) for f, s in left]
    polygons = [p for p in getattr(whole, "geoms", (whole,)) if isinstance(p, Polygon)]
    return Plate(
        part, thickness, tuple(p for p in polygons if not p.is_empty),
        slits if slits is not None else union_all([]), tuple(left),
    )  # fmt: skip


def _holes(part: Part) -> Iterator[tuple[Hole | Slot, Shape, float]]:
    """Holes and slots with their shape and their least width."""
    from shapely import Polygon

    for f in part.features:
        if isinstance(f, Hole) and f.kind != "mark":
            yield f, Polygon(circle(f.x, f.y, f.diameter / 2)), f.diameter
        elif isinstance(f, Slot) and f.kind != "mark":
            yield f, slot_shape(f), min(f.length, f.height) + f.diameter


def _outlines(part: Part, torch: Torch) -> tuple[Shape, Shape]:
    """What a part's contours enclose, and its slits."""
    from shapely import LineString, Polygon, union_all

    cut = [c for c in part.contours if c.face in ("v", "h") and _is_cut(c, torch)]
    closed = [c for c in cut if c.closed and c.kind != "open"]
    shapes = [(shape_of(c.curves), c.kind) for c in closed]
    lines = {
        k: LineString(polylines(c.curves, CHORD).points)
        for k, c in enumerate(cut)
        if c not in closed or shape_of(c.curves).area < CHORD
    }
    faces, slits = _enclosed([lines[k] for k in sorted(lines)], torch.gap)
    drawn = part.measures is not None  # a drawing does not say which side of a contour is steel
    whole: Shape = Polygon()
    if not drawn and not any(kind == "outer" for _, kind in shapes):
        whole = _rectangle(part)
    shapes += [(face, "outer") for face in faces]
    for shape, kind in sorted(shapes, key=lambda s: -s[0].area):
        if kind == "outer" and not (drawn and whole.contains(shape.representative_point())):
            whole = whole.union(shape)
        else:
            whole = whole.difference(shape)
    return whole, union_all(slits)


def _enclosed(lines: list[Shape], gap: float) -> tuple[list[Shape], list[Shape]]:
    """What lines enclose together, each face filled, and what of them encloses nothing."""
    from shapely import Polygon, polygonize, set_precision, union_all

    if not lines:
        return [], []
    noded = union_all([set_precision(line, max(gap / 2, 1e-4)) for line in lines])
    faces = [Polygon(face.exterior) for face in polygonize(getattr(noded, "geoms", [noded])).geoms]
    borders = union_all([face.exterior for face in faces]).buffer(CHORD)
    return faces, [noded.difference(borders)]


def _is_cut(contour: Contour, torch: Torch) -> bool:
    if contour.layer is None and contour.colour is None:
        return contour.process == "cut"
    return process_of(contour, cast("dict[str, Process]", torch.colours)) == "cut"


def _rectangle(part: Part) -> Shape:
    """A plate without an outline: its length and width between its end planes."""
    from shapely import Polygon

    corners = []
    for (x, _, _), (side, up, _) in end_planes(part):
        ends = [(x - side * up * y, y) for y in (0.0, part.profile.height)]
        corners += ends if side < 0 else ends[::-1]
    return Polygon(corners)
