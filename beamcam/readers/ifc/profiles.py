"""Profile definitions of IFC as sections: parameterised ones by their numbers, others by form.

Their curves are exact: lines and arcs in mm.
"""

from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from math import atan2, degrees, dist, hypot, pi
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.arc_fitting import fit_chains
from beamcam.geometry.conics import arc_between, arc_by_points
from beamcam.geometry.curves import Arc, BSpline, Curve, Line, Point, signed_area
from beamcam.geometry.plane import MAX_COORDINATE, cross, normalized
from beamcam.model.part import ProfileCode
from beamcam.model.section import section_fault
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.outline import Chain
from beamcam.readers.ifc.records import Typed
from beamcam.readers.ifc.section import FORMS, Section, area_by_measures, classify, placed
from beamcam.readers.ifc.space import IDENTITY, Frame

#: Code of a parameterised profile, and the names of its height, width, flange, web and radius.
MEASURES: dict[str, tuple[ProfileCode, str]] = {
    "IfcIShapeProfileDef":
        ("I", "OverallDepth OverallWidth FlangeThickness WebThickness FilletRadius"),
    "IfcUShapeProfileDef": ("U", "Depth FlangeWidth FlangeThickness WebThickness FilletRadius"),
    "IfcCShapeProfileDef": ("C", "Depth Width WallThickness WallThickness InternalFilletRadius"),
    "IfcTShapeProfileDef": ("T", "FlangeWidth Depth WebThickness FlangeThickness FilletRadius"),
    "IfcLShapeProfileDef": ("L", "Depth Width Thickness Thickness FilletRadius"),
    "IfcRectangleHollowProfileDef":
        ("M", "YDim XDim WallThickness WallThickness OuterFilletRadius"),
    "IfcRectangleProfileDef": ("B", "YDim XDim - - -"),
    "IfcCircleHollowProfileDef": ("RO", "Radius Radius WallThickness WallThickness -"),
    "IfcCircleProfileDef": ("RU", "Radius Radius - Radius -"),
}  # fmt: skip
SPLINE_FIT = 0.005  #: mm that the arcs which stand for a spline may lie off it
SAME_POINT = 1e-4  #: mm between the end of a curve and the start of the next
FLANGES = ("BottomFlangeThickness", "FlangeThickness")
FILLETS = ("BottomFlangeFilletRadius", "FilletRadius")


class Outline(Struct, frozen=True, gc=False, cache_hash=True):
    """A region of the profile's plane: its border and its hollows."""

    outer: Chain
    inner: tuple[Chain, ...] = ()


def definition(entity: Entity) -> Any:
    """Key that equal profile definitions share: the numbers, but not the name."""
    kind = entity.type
    return (kind.name, entity.values[2:]) if "IfcParameterizedProfileDef" in kind.kinds else entity


def section_of(model: Model, entity: Entity) -> Section:
    """The section of an IfcProfileDef. Raises Unreadable where it has none."""
    return model.once("section", definition(entity), _section, model, entity)


def _section(model: Model, entity: Entity) -> Section:
    """As `section_of`. Raises Unreadable for measures that no section has."""
    if entity.is_a() in MEASURES:
        section = _measured(model, entity)
    else:
        outline = outline_of(model, entity)
        known = model.once("form", outline, classify, outline.outer, outline.inner)
        if known is None:
            found = f"a section that is no rolled form ({entity.is_a()})"
            raise Unreadable(found, rules.SECTION, final=True)
        section = known
    widest = max(section.height, section.width, section.radius)
    if widest > MAX_COORDINATE:
        raise Unreadable(f"a section with a measure of {widest:g} mm", rules.SECTION)
    fault = section_fault(section.profile(""))
    if fault is not None:
        raise Unreadable(f"a section with {fault}", rules.SECTION, final=True)
    return section


def outline_of(model: Model, entity: Entity) -> Outline:
    """The outline of an IfcProfileDef, as exact curves. Raises Unreadable."""
    return model.once("outline", definition(entity), _outline, model, entity)


def _outline(model: Model, entity: Entity) -> Outline:
    if entity.is_a("IfcDerivedProfileDef"):
        parent = outline_of(model, entity.ParentProfile)
        # A mirrored one turns about the y axis.
        mirrored = entity.is_a("IfcMirroredProfileDef")
        by = Frame(x=(-1.0, 0.0, 0.0)) if mirrored else model.operator(entity.Operator)
        return Outline(moved(parent.outer, by), tuple(moved(c, by) for c in parent.inner))
    if entity.is_a("IfcArbitraryClosedProfileDef"):
        inner = tuple(chain_of(model, c) for c in getattr(entity, "InnerCurves", ()))
        return Outline(chain_of(model, entity.OuterCurve), inner)
    number = partial(_number, entity, model.mm)
    wall = number("WallThickness")
    hollow: tuple[Chain, ...] = ()
    if entity.is_a("IfcCircleProfileDef"):
        outer = _circle(number("Radius"))
        if entity.is_a("IfcCircleHollowProfileDef"):
            hollow = (_circle(number("Radius") - wall),)
    elif entity.is_a("IfcRectangleProfileDef"):
        x, y = number("XDim"), number("YDim")
        outer = rounded_box(x, y, number("OuterFilletRadius", "RoundingRadius"))
        if entity.is_a("IfcRectangleHollowProfileDef"):
            hollow = (rounded_box(x - 2 * wall, y - 2 * wall, number("InnerFilletRadius")),)
    elif entity.is_a("IfcTrapeziumProfileDef"):
        x, up = number("BottomXDim") / 2, number("YDim") / 2
        left = number("TopXOffset") - x
        right = left + number("TopXDim")
        outer = points_chain([(-x, -up), (x, -up), (right, up), (left, up)])
    elif entity.is_a("IfcZShapeProfileDef"):  # its flanges are measured from the back of the web
        h, w, t = number("Depth") / 2, number("WebThickness") / 2, number("FlangeThickness")
        tip, radii = number("FlangeWidth") - w, [0.0, 0.0, number("EdgeRadius"), number(*FILLETS)]
        half = [(-w, -h), (tip, -h), (tip, t - h), (w, t - h)]
        outer = rounded_chain(half + [(-x, -y) for x, y in half], radii + radii)
    elif entity.is_a("IfcAsymmetricIShapeProfileDef"):  # the bottom's names are another's in IFC2X3
        h, w = number("OverallDepth") / 2, number("WebThickness") / 2
        b0, t0 = number("BottomFlangeWidth", "OverallWidth") / 2, number(*FLANGES)
        b1, t1 = number("TopFlangeWidth") / 2, number("TopFlangeThickness", *FLANGES)
        radii = [0.0, 0.0, number(*FILLETS), number("TopFlangeFilletRadius", *FILLETS), 0.0, 0.0]
        half = [(b0, -h), (b0, t0 - h), (w, t0 - h), (w, h - t1), (b1, h - t1), (b1, h)]
        outer = rounded_chain(half + [(-x, y) for x, y in half[::-1]], radii + radii[::-1])
    elif entity.is_a() in MEASURES:
        return Outline(_drawn(section_of(model, entity), number("Girth")))
    else:
        raise Unreadable(f"a profile by {entity.is_a()}")
    frame = model.axes(entity.Position)
    return Outline(moved(outer, frame), tuple(moved(c, frame) for c in hollow))


def _drawn(section: Section, lip: float) -> Chain:
    """The outline of a section with its fillets; of a C all of whose bends are round."""
    s, form, (ox, oy), (yx, yy), (zx, zy) = (
        section, FORMS[section.code], section.origin, section.y, section.z,
    )  # fmt: skip
    points = form.drawn(s.height, s.width, s.flange_thickness, s.web_thickness, lip)
    outside = s.radius + s.web_thickness if s.code == "C" else 0.0
    radii = [
        s.radius if inner else outside * (set(at) <= set("0bh"))
        for at, inner in zip(form.corners, form.reflex, strict=True)
    ]
    matrix = (zx, yx, ox), (zy, yy, oy)
    return tuple(c.transformed(matrix) for c in rounded_chain(points, radii))


def rounded_box(x: float, y: float, radius: float) -> Chain:
    """A rectangle about the origin with round corners; a circle or a slot where nothing is left."""
    x, y = x / 2, y / 2
    r, corners = min(radius, x, y), [(-x, -y), (x, -y), (x, y), (-x, y)]
    if r <= 0:
        return points_chain(corners)
    first, *rest = rounded_chain(corners, [r] * 4)
    return (*rest, first)


def _circle(radius: float, centre: Point = (0.0, 0.0), start_deg: float = 0.0) -> Chain:
    if not radius > 0.0:
        raise Unreadable(f"a circle of radius {radius:g}")
    return (Arc(centre, radius, start_deg, 360.0),)


def moved(chain: Chain, by: Frame) -> Chain:
    """A chain of a frame's plane, in the plane that the frame stands in."""
    if by is IDENTITY:
        return chain
    matrix = (by.x[0], by.y[0], by.o[0]), (by.x[1], by.y[1], by.o[1])
    return tuple(c.transformed(matrix) for c in chain)


def _measured(model: Model, entity: Entity) -> Section:
    """The section of a parameterised profile, by its numbers."""
    code, names = MEASURES[entity.is_a()]
    number = partial(_number, entity, model.mm)
    h, b, tf, tw, r = (number(name) * (2 if name == "Radius" else 1) for name in names.split())
    b, frame = b or h if code == "L" else b, model.axes(entity.Position)
    if code == "B":
        tw = min(h, b)
    z, y = (frame.x[0], frame.x[1]), (frame.y[0], frame.y[1])
    if code == "T":  # its flange lies across, with the stem below
        y, z = z, (-y[0], -y[1])
    elif code in ("L", "M", "B") and b > h:  # the greater side is the height
        h, b, y, z = b, h, z, y
    if min(h, b, tw) <= 0 or r < 0:
        raise Unreadable(f"a profile of impossible size {h:g} x {b:g} x {tw:g}")
    sizes, centre = (h, b, tf, tw, r), (frame.o[0], frame.o[1])
    section = placed(code, sizes, centre, y, z, area_by_measures(code, *sizes))
    if code == "C":
        lip = number("Girth")
        area = abs(signed_area(_drawn(section, lip)))
        section = replace(section, area=area, lip=lip or None)
    return section


def _number(entity: Entity, mm: float, *names: str) -> float:
    """The first of some measures that a profile has, in mm; 0 where it has none."""
    stated = (getattr(entity, name, None) for name in names)
    return float(next((value for value in stated if value is not None), 0.0)) * mm


def rounded_chain(corners: Sequence[Point], radii: Sequence[float]) -> Chain:
    """A polygon of right angles with each corner rounded by its radius, or sharp where it is 0."""
    before, after = [corners[-1], *corners[:-1]], [*corners[1:], corners[0]]
    out: list[Curve] = []
    for p, a, b, r, s in zip(corners, before, after, radii, [*radii[1:], radii[0]], strict=True):
        u, v = (normalized((q[0] - p[0], q[1] - p[1])) for q in (a, b))
        enter, leave = (p[0] + u[0] * r, p[1] + u[1] * r), (p[0] + v[0] * r, p[1] + v[1] * r)
        if r > 0:
            centre = (enter[0] + leave[0] - p[0], enter[1] + leave[1] - p[1])
            out.append(arc_between(enter, leave, centre, -cross(u, v)))
        side = Line(leave, (b[0] - v[0] * s, b[1] - v[1] * s))
        if side.length > 1e-9:
            out.append(side)
    return tuple(out)


# --- curves ---------------------------------------------------------------------------------------


def chain_of(model: Model, entity: Entity) -> Chain:
    """A closed chain of lines and arcs of an IFC curve. Raises Unreadable for other curves."""
    chain = tuple(c for c in _curve(model, entity) if c.length > SAME_POINT)
    if not chain:
        raise Unreadable(f"an empty {entity.is_a()}")
    first, last = chain[0].start, chain[-1].end
    is_open = dist(first, last) > SAME_POINT and len(chain) > 1
    return (*chain, Line(last, first)) if is_open else chain


def points_chain(points: list[Point]) -> Chain:
    """The polygon of `points`, closed."""
    return tuple(_polyline([*points, points[0]]))


def _curve(model: Model, entity: Entity) -> list[Curve]:
    """The curves of an entity."""
    kind, kinds = entity.type.name, entity.type.kinds
    if kind == "IfcPolyline":
        return _polyline([model.point(c)[:2] for c in entity.values[0]])
    if "IfcCompositeCurve" in kinds:
        chain: list[Curve] = []
        for segment in entity.values[0]:
            if segment.type.name != "IfcCompositeCurveSegment":
                raise Unreadable(f"a curve segment {segment.is_a()}")
            _, forward, parent, *_ = segment.values
            pieces = _curve(model, parent)
            chain += pieces if forward else [c.reversed() for c in reversed(pieces)]
        return chain
    if kind == "IfcIndexedPolyCurve":
        return _indexed(model, entity)
    if kind == "IfcTrimmedCurve":
        return [_trimmed(model, entity)]
    if kind == "IfcCircle":
        (x, y, _), o = model.axes(entity.Position).x, model.axes(entity.Position).o
        return [*_circle(entity.Radius * model.mm, o[:2], degrees(atan2(y, x)))]
    if "IfcBSplineCurve" in kinds:
        (arcs,) = fit_chains([[spline_of(model, entity)]], SPLINE_FIT)
        return [*arcs]
    raise Unreadable(f"an outline by {kind}")


def spline_of(model: Model, entity: Entity) -> BSpline:
    """An IfcBSplineCurve in a plane. Raises Unreadable for one that is not well formed."""
    degree, listed, *_ = entity.values
    control = tuple((c[0] * model.mm, c[1] * model.mm) for c in listed)
    if entity.is_a("IfcBSplineCurveWithKnots"):
        rows = zip(entity.Knots, entity.KnotMultiplicities, strict=True)
        knots = tuple(float(knot) for knot, often in rows for _ in range(often))
    else:  # Bezier curves, one behind the other
        pieces = (len(control) - 1) // degree
        inner = (float(k) for k in range(1, pieces) for _ in range(degree))
        knots = (*(degree + 1) * (0.0,), *inner, *(degree + 1) * (float(pieces),))
    weights = entity.WeightsData if "WeightsData" in entity.type.places else None
    try:
        return BSpline(degree, control, knots, weights and tuple(map(float, weights)))
    except ValueError as fault:
        raise Unreadable(f"an outline by a spline that is not well formed ({fault})") from fault


def _polyline(points: list[Point]) -> list[Curve]:
    return [Line(a, b) for a, b in pairwise(points) if dist(a, b) > SAME_POINT]


def _indexed(model: Model, entity: Entity) -> list[Curve]:
    points = [model.point(c)[:2] for c in entity.Points.CoordList]
    if entity.Segments is None:
        return _polyline(points)
    chain: list[Curve] = []
    for segment in entity.Segments:
        run = [points[i - 1] for i in segment.value]
        if segment.is_a("IfcArcIndex"):
            chain.append(arc_by_points(run[0], run[1], run[2]) or Line(run[0], run[2]))
        else:
            chain += _polyline(run)
    return chain


def _trimmed(model: Model, entity: Entity) -> Curve:
    basis = entity.values[0]
    ends = [_trim(model, entity, trim) for trim in (entity.values[1], entity.values[2])]
    if basis.is_a("IfcLine"):
        x, y, _ = model.point(basis.Pnt)
        dx, dy = basis.Dir.Orientation[:2]
        by = basis.Dir.Magnitude * model.mm / hypot(dx, dy)
        start, end = (
            (x + dx * by * one, y + dy * by * one) if isinstance(one, float) else one
            for one in ends
        )
        return Line(start, end)
    if not basis.is_a("IfcCircle"):
        raise Unreadable(f"an outline by a trimmed {basis.is_a()}")
    frame = model.axes(basis.values[0])
    (ox, oy, _), (ax, ay, _), (bx, by, _) = frame.o, frame.x, frame.y
    start_rad, end_rad = (
        one * model.radians
        if isinstance(one, float)
        else atan2((one[0] - ox) * bx + (one[1] - oy) * by, (one[0] - ox) * ax + (one[1] - oy) * ay)
        for one in ends
    )
    way = 1 if entity.values[3] else -1
    turn = way * (end_rad - start_rad) % (2 * pi)
    if turn < 1e-9:
        turn = 2 * pi
    start_deg = degrees(start_rad + atan2(ay, ax))
    return Arc((ox, oy), basis.values[1] * model.mm, start_deg, degrees(way * turn))


def _trim(model: Model, entity: Entity, trim: tuple[Any, ...]) -> Point | float:
    """Trimming point of a curve: a parameter, or a point if the file has one."""
    points = [model.point(t)[:2] for t in trim if isinstance(t, tuple)]
    values = [float(t.value) for t in trim if isinstance(t, Typed)]
    if values and (entity.MasterRepresentation != "CARTESIAN" or not points):
        return values[0]
    if not points:
        raise Unreadable("a trimmed curve without trims")
    return points[0]
