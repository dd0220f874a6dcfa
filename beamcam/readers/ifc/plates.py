"""Plates: an outline that is pushed through its thickness."""

from math import atan2, cos, hypot, pi, sin

from msgspec import Struct

from beamcam.geometry.curves import Line, Point
from beamcam.readers.ifc.classify import classify
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.outline import with_arcs
from beamcam.readers.ifc.profiles import outline_of

_FLAT = frozenset(("IfcRectangleProfileDef", "IfcCircleProfileDef", "IfcTrapeziumProfileDef"))
THIN = 0.3  #: of the lesser side, below which an outline of a rolled form is a plate all the same
TIGHTER = 0.98  #: of the area of the box as drawn, for another box to be taken


class Plate(Struct, frozen=True, gc=False):
    """Placement of a plate in its profile's plane, and its outline in its own (x, y)."""

    origin: Point
    x: Point
    y: Point
    length: float
    width: float
    outline: Chain | None  #: None where it is the full rectangle
    hollows: tuple[Chain, ...]


def plate_of(model: Model, element: Entity, profile: Entity, depth: float) -> Plate | None:
    """The plate that a profile pushed by `depth` is; None if it is a bar of that section."""
    kinds = profile.row.kinds
    if "IfcParameterizedProfileDef" in kinds and kinds.isdisjoint(_FLAT):
        return None  # a rolled form
    known = model.plates.get((profile, round(depth, 4), element.is_a()))
    if known is None:
        known = _plate_of(model, element, profile, depth) or "bar"
        model.plates[(profile, round(depth, 4), element.is_a())] = known
    return known if isinstance(known, Plate) else None


def _plate_of(model: Model, element: Entity, profile: Entity, depth: float) -> Plate | None:
    if profile.is_a("IfcRectangleHollowProfileDef"):
        return None
    is_ring = profile.is_a("IfcCircleHollowProfileDef")
    if is_ring and depth >= profile.WallThickness * model.mm:
        return None  # a tube
    if (
        profile.is_a() == "IfcRectangleProfileDef"
        and depth >= min(profile.XDim, profile.YDim) * model.mm
    ):
        return None
    try:
        outline = outline_of(model, profile)
    except Unreadable:
        return None
    if 2 * depth > sum(c.length for c in outline.outer):
        return None  # a closed curve is at least twice as long as what it spans: a bar
    boxes = [c.bbox for c in outline.outer]
    across = max(b[2] for b in boxes) - min(b[0] for b in boxes)
    upright = max(b[3] for b in boxes) - min(b[1] for b in boxes)
    if depth > hypot(across, upright):
        return None  # longer than any side: a bar
    box = box_of(outline.outer)
    section = classify(outline.outer, outline.inner)
    code = section.code if section is not None else None
    least = min(box.length, box.width)
    if (code in ("M", "RO") and not is_ring) or (
        code is not None and code not in ("B", "SO") and depth > THIN * least
    ):
        return None
    if code in ("B", "SO") and depth >= least * (1 - 1e-9):
        return None
    if code == "SO" and depth > THIN * least and not element.is_a("IfcPlate"):
        return None
    full = (
        len(box.outline) == 4 and code == "B" and abs(section.area - box.length * box.width) < 0.01
        if section
        else False
    )
    return Plate(
        box.origin,
        box.x,
        box.y,
        box.length,
        box.width,
        None if full else box.outline,
        tuple(into(h, box) for h in outline.inner),
    )


class PlateBox(Struct, frozen=True):
    """The minimum bounding box of an outline, and the outline in its coordinates."""

    origin: Point
    x: Point
    y: Point
    length: float
    width: float
    outline: Chain


def box_of(outer: Chain) -> PlateBox:
    """The minimum bounding box of an outline, x along its longer side; as drawn if as small."""
    curves = with_arcs(outer)
    angles = [0.0]
    for curve in curves:
        if isinstance(curve, Line) and curve.length > 1.0:
            dx, dy = curve.end[0] - curve.start[0], curve.end[1] - curve.start[1]
            angle = atan2(dy, dx) % (pi / 2)
            if all(abs(angle - a) > 1e-6 for a in angles):
                angles.append(angle)
    boxes = [(_extent(curves, a), a) for a in angles]
    drawn = boxes[0]
    best = min(boxes, key=lambda b: _area(b[0]))
    (x0, y0, x1, y1), angle = best if _area(best[0]) < TIGHTER * _area(drawn[0]) else drawn
    c, s = cos(angle), sin(angle)
    x, y = (c, s), (-s, c)
    low = (x0, y0)
    length, width = x1 - x0, y1 - y0
    if width > length:
        # A quarter turn: the new x is the old y, the new y the old -x.
        x, y, low, length, width = y, (-x[0], -x[1]), (y0, -x1), width, length
    origin = (low[0] * x[0] + low[1] * y[0], low[0] * x[1] + low[1] * y[1])
    box = PlateBox(origin, x, y, length, width, ())
    return PlateBox(origin, x, y, length, width, into(curves, box))


def _extent(curves: Chain, angle: float) -> tuple[float, float, float, float]:
    c, s = cos(angle), sin(angle)
    boxes = [k.transformed(((c, s, 0.0), (-s, c, 0.0))).bbox for k in curves]
    return (
        min(b[0] for b in boxes), min(b[1] for b in boxes),
        max(b[2] for b in boxes), max(b[3] for b in boxes),
    )  # fmt: skip


def _area(box: tuple[float, float, float, float]) -> float:
    return (box[2] - box[0]) * (box[3] - box[1])


def into(chain: Chain, box: PlateBox) -> Chain:
    """A chain of the profile's plane in the plate's own coordinates."""
    (a, b), (c, d), (ox, oy) = box.x, box.y, box.origin
    matrix = ((a, b, -(a * ox + b * oy)), (c, d, -(c * ox + d * oy)))
    return tuple(k.transformed(matrix) for k in chain)
