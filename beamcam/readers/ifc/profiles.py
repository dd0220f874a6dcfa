"""Profile definitions of IFC as sections: parameterised ones by their numbers, others by form."""

from collections.abc import Sequence
from functools import partial
from math import atan2, degrees, hypot, pi
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.curves import Arc, Line, Point, signed_area
from beamcam.geometry.plane import MAX_COORDINATE, Matrix, mapped, mapped_vector
from beamcam.model.part import ProfileCode
from beamcam.model.section import section_fault
from beamcam.readers.ifc.classify import classify
from beamcam.readers.ifc.curves2d import Chain, chain_of, points_chain, with_sides
from beamcam.readers.ifc.entities import Entity, Model, OddSection, Unreadable
from beamcam.readers.ifc.section import Section, area_by_measures, placed, special
from beamcam.readers.ifc.space import IDENTITY, Frame

Sizes = tuple[float, float, float, float, float]  #: height, width, flange, web and radius


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
    section = _stated_section(model, entity)
    widest = max(section.height, section.width, section.radius)
    if widest > MAX_COORDINATE:
        raise OddSection(f"a section with a measure of {widest:g} mm")
    fault = section_fault(section.profile(""))
    if fault is not None:
        raise OddSection(f"a section with {fault}", final=True)
    return section


def _stated_section(model: Model, entity: Entity) -> Section:
    if entity.is_a("IfcDerivedProfileDef"):
        return _mapped(section_of(model, entity.ParentProfile), _operator(model, entity))
    if entity.is_a("IfcParameterizedProfileDef"):
        found = _parameterised(model, entity)
        if found is not None:
            return found
    outline = outline_of(model, entity)
    found = model.once("form", outline, classify, outline.outer, outline.inner)
    if found is None:
        raise OddSection(f"a section that is no rolled form ({entity.is_a()})", final=True)
    return found


def outline_of(model: Model, entity: Entity) -> Outline:
    """The outline of an IfcProfileDef, as exact curves. Raises Unreadable."""
    return model.once("outline", definition(entity), _outline, model, entity)


def _outline(model: Model, entity: Entity) -> Outline:
    kind = entity.is_a()
    if entity.is_a("IfcDerivedProfileDef"):
        parent = outline_of(model, entity.ParentProfile)
        by = _operator(model, entity)
        return Outline(_moved(parent.outer, by), tuple(_moved(c, by) for c in parent.inner))
    if entity.is_a("IfcArbitraryProfileDefWithVoids"):
        inner = tuple(chain_of(model, c) for c in entity.InnerCurves)
        return Outline(chain_of(model, entity.OuterCurve), inner)
    if entity.is_a("IfcArbitraryClosedProfileDef"):
        return Outline(chain_of(model, entity.OuterCurve))
    frame = model.axes(getattr(entity, "Position", None))
    mm = model.mm
    if entity.is_a("IfcCircleProfileDef"):
        outer = _circle(entity.Radius * mm)
        bore: tuple[Chain, ...] = ()
        if entity.is_a("IfcCircleHollowProfileDef"):
            bore = (_moved(_circle((entity.Radius - entity.WallThickness) * mm), frame),)
        return Outline(_moved(outer, frame), bore)
    if entity.is_a("IfcRectangleHollowProfileDef"):
        x, y, wall = entity.XDim * mm, entity.YDim * mm, entity.WallThickness * mm
        outer_radius = (entity.OuterFilletRadius or 0.0) * mm
        hollow = rounded_box(x - 2 * wall, y - 2 * wall, (entity.InnerFilletRadius or 0.0) * mm)
        return Outline(_moved(rounded_box(x, y, outer_radius), frame), (_moved(hollow, frame),))
    if entity.is_a("IfcRectangleProfileDef"):
        radius = 0.0
        if entity.is_a("IfcRoundedRectangleProfileDef"):
            radius = entity.RoundingRadius * mm
        chain = rounded_box(entity.XDim * mm, entity.YDim * mm, radius)
        return Outline(_moved(chain, frame))
    if entity.is_a("IfcTrapeziumProfileDef"):
        x, top, up = entity.BottomXDim * mm, entity.TopXDim * mm, entity.YDim * mm
        shift = entity.TopXOffset * mm - x / 2
        corners = [(-x / 2, -up / 2), (x / 2, -up / 2), (shift + top, up / 2), (shift, up / 2)]
        return Outline(_moved(points_chain(corners), frame))
    if entity.is_a("IfcParameterizedProfileDef"):
        sharp = _sharp(model, entity)
        if sharp is not None:
            return Outline(_moved(points_chain(sharp), frame))
    raise Unreadable(f"a profile by {kind}")


def rounded_box(x: float, y: float, radius: float) -> Chain:
    """A rectangle about the origin with round corners; a circle or a slot where nothing is left."""
    r = min(radius, x / 2, y / 2)
    if r <= 0:
        return points_chain([(-x / 2, -y / 2), (x / 2, -y / 2), (x / 2, y / 2), (-x / 2, y / 2)])
    a, b = x / 2 - r, y / 2 - r
    arcs = [
        Arc((a, -b), r, -90.0, 90.0),
        Arc((a, b), r, 0.0, 90.0),
        Arc((-a, b), r, 90.0, 90.0),
        Arc((-a, -b), r, 180.0, 90.0),
    ]
    return with_sides(arcs)


def _circle(radius: float) -> Chain:
    if not radius > 0.0:
        raise Unreadable(f"a circle of radius {radius:g}")
    return (Arc((0.0, 0.0), radius, 0.0, 360.0),)


def _moved(chain: Chain, by: Frame) -> Chain:
    if by is IDENTITY:
        return chain
    matrix = _matrix(by)
    return tuple(c.transformed(matrix) for c in chain)


def _matrix(by: Frame) -> Matrix:
    return (by.x[0], by.y[0], by.o[0]), (by.x[1], by.y[1], by.o[1])


def _operator(model: Model, entity: Entity) -> Frame:
    """The map of a derived profile; a mirrored one turns about the y axis."""
    if entity.is_a("IfcMirroredProfileDef"):
        return Frame(x=(-1.0, 0.0, 0.0))
    return model.operator(entity.Operator)


def _mapped(section: Section, by: Frame) -> Section:
    """A section under a map that keeps its form."""
    x, y = hypot(by.x[0], by.x[1]), hypot(by.y[0], by.y[1])
    if abs(x - y) > 1e-6 or abs(by.x[0] * by.y[0] + by.x[1] * by.y[1]) > 1e-6 or x == 0:
        raise Unreadable("a derived profile that is stretched unevenly")

    matrix = _matrix(by)

    def direction(v: Point) -> Point:
        mapped = mapped_vector(matrix, v)
        return mapped[0] / x, mapped[1] / x

    return replace(
        section.scaled(x),
        origin=mapped(matrix, section.origin),
        y=direction(section.y),
        z=direction(section.z),
        outline=_moved(section.outline, by),
    ).right_way()


def _parameterised(model: Model, entity: Entity) -> Section | None:
    """A section by the numbers of its definition; None for forms given by their outline."""
    frame = model.axes(entity.Position)
    number = partial(_number, entity, model.mm)
    if entity.is_a("IfcAsymmetricIShapeProfileDef"):
        return _asymmetric(entity, model.mm, frame)
    if entity.is_a("IfcZShapeProfileDef"):
        corners = _sharp(model, entity) or []
        half = [0.0, 0.0, number("EdgeRadius"), number("FilletRadius")]
        radii = half + half
        return _outlined(rounded_chain(corners, radii), frame)
    measures = _measures(model, entity)
    if measures is None:
        return None
    found = _standing(*measures, frame)
    if found.code == "C":
        lips = _lips(number("Girth"), found.web_thickness, found.radius)
        return replace(found, area=found.area + lips)
    return found


def _measures(model: Model, entity: Entity) -> tuple[ProfileCode, Sizes] | None:
    """Code and measures of a parameterised profile as it is drawn; None if it has no such code."""
    number = partial(_number, entity, model.mm)
    if entity.is_a("IfcIShapeProfileDef"):
        return "I", (
            number("OverallDepth"), number("OverallWidth"), number("FlangeThickness"),
            number("WebThickness"), number("FilletRadius"),
        )  # fmt: skip
    if entity.is_a("IfcUShapeProfileDef"):
        return "U", (
            number("Depth"), number("FlangeWidth"), number("FlangeThickness"),
            number("WebThickness"), number("FilletRadius"),
        )  # fmt: skip
    if entity.is_a("IfcCShapeProfileDef"):
        wall, radius = number("WallThickness"), number("InternalFilletRadius")
        return "C", (number("Depth"), number("Width"), wall, wall, radius)
    if entity.is_a("IfcTShapeProfileDef"):
        return "T", (
            number("FlangeWidth"), number("Depth"), number("WebThickness"),
            number("FlangeThickness"), number("FilletRadius"),
        )  # fmt: skip
    if entity.is_a("IfcLShapeProfileDef"):
        depth, thick = number("Depth"), number("Thickness")
        return "L", (depth, number("Width") or depth, thick, thick, number("FilletRadius"))
    if entity.is_a("IfcRectangleHollowProfileDef"):
        wall, radius = number("WallThickness"), number("OuterFilletRadius")
        return "M", (number("YDim"), number("XDim"), wall, wall, radius)
    if entity.is_a() == "IfcRectangleProfileDef":
        x, y = number("XDim"), number("YDim")
        return "B", (y, x, 0.0, min(x, y), 0.0)
    if entity.is_a("IfcCircleProfileDef"):
        d = 2 * number("Radius")
        if entity.is_a("IfcCircleHollowProfileDef"):
            return "RO", (d, d, number("WallThickness"), number("WallThickness"), 0.0)
        return "RU", (d, d, 0.0, d, 0.0)
    return None


def _standing(code: ProfileCode, sizes: Sizes, frame: Frame) -> Section:
    """The section of a profile about the middle of `frame`, with its zero point and directions."""
    h, b, tf, tw, r = sizes
    z, y = (frame.x[0], frame.x[1]), (frame.y[0], frame.y[1])
    if code == "T":  # its flange lies across, with the stem below
        y, z = z, (-y[0], -y[1])
    elif code in ("L", "M", "B") and b > h:  # the greater side is the height
        h, b, y, z = b, h, z, y
    if min(h, b, tw) <= 0 or r < 0:
        raise Unreadable(f"a profile of impossible size {h:g} x {b:g} x {tw:g}")
    sizes = h, b, tf, tw, r
    centre = (frame.o[0], frame.o[1])
    return placed(code, sizes, centre, y, z, area_by_measures(code, *sizes))


def _outlined(outline: Chain, frame: Frame) -> Section:
    """The special section of an outline in `frame`."""
    drawn = _moved(outline, frame)
    return special(drawn, abs(signed_area(drawn)))


def _number(entity: Entity, mm: float, name: str) -> float:
    """A measure of a profile in mm; 0 where it has none."""
    value = getattr(entity, name, None)
    return 0.0 if value is None else float(value) * mm


def _lips(girth: float, wall: float, radius: float) -> float:
    """Area that the lips of a cold formed channel add to its sharp area, with all its bends.

    Each of its four bends is round outside too: the inner fillet is in the sharp area already for
    two of them.
    """
    corner = 1 - pi / 4
    bends = 4 * corner * (radius * radius - (radius + wall) ** 2)
    return 2 * max(0.0, girth - wall) * wall + bends - 2 * corner * radius * radius


def _asymmetric(entity: Entity, mm: float, frame: Frame) -> Section:
    """An I of two flanges; a special section with its outline where they are not alike."""
    if entity.is_a("IfcIShapeProfileDef"):  # IFC2X3: the bottom flange has the inherited names
        bottom, thick = entity.OverallWidth, entity.FlangeThickness
        radius = entity.FilletRadius
    else:
        bottom, thick = entity.BottomFlangeWidth, entity.BottomFlangeThickness
        radius = entity.BottomFlangeFilletRadius
    top = entity.TopFlangeWidth
    thick_top = thick if entity.TopFlangeThickness is None else entity.TopFlangeThickness
    if abs(bottom - top) * mm > 0.2 or abs(thick - thick_top) * mm > 0.2:
        upper = entity.TopFlangeFilletRadius
        drawn = _two_flanges(
            entity.OverallDepth * mm / 2,
            entity.WebThickness * mm,
            (bottom * mm, thick * mm),
            (top * mm, thick_top * mm),
            ((radius or 0.0) * mm, ((radius if upper is None else upper) or 0.0) * mm),
        )
        return _outlined(drawn, frame)
    h, tw, r = entity.OverallDepth, entity.WebThickness, radius or 0.0
    return _standing("I", (h * mm, bottom * mm, thick * mm, tw * mm, r * mm), frame)


def _two_flanges(
    half: float,
    web: float,
    bottom: tuple[float, float],
    top: tuple[float, float],
    radii: tuple[float, float],
) -> Chain:
    """The outline of an I about its middle; flanges by width and thickness, lower fillet first."""
    w = web / 2
    (b0, t0), (b1, t1) = (bottom[0] / 2, bottom[1]), (top[0] / 2, top[1])
    right = [(b0, -half), (b0, t0 - half), (w, t0 - half), (w, half - t1), (b1, half - t1),
             (b1, half)]  # fmt: skip
    corners = right + [(-x, y) for x, y in reversed(right)]
    r0, r1 = radii
    rounds = [0.0, 0.0, r0, r1, 0.0, 0.0]
    return rounded_chain(corners, rounds + rounds[::-1])


def _reflex(corners: Sequence[Point], i: int) -> bool:
    """Whether a corner of a polygon that runs counter-clockwise points inwards."""
    (ax, ay), (bx, by), (cx, cy) = corners[i - 1], corners[i], corners[(i + 1) % len(corners)]
    return (bx - ax) * (cy - by) - (by - ay) * (cx - bx) < 0


def rounded_chain(corners: Sequence[Point], radii: Sequence[float]) -> Chain:
    """A polygon of right angles with each corner rounded by its radius, or sharp where it is 0."""
    n = len(corners)
    out: list[Any] = []
    ends: list[tuple[Point, Point]] = []
    for i, (p, r) in enumerate(zip(corners, radii, strict=True)):
        before, after = corners[i - 1], corners[(i + 1) % n]
        u, v = (_towards(p, before), _towards(p, after))
        ends.append(((p[0] + u[0] * r, p[1] + u[1] * r), (p[0] + v[0] * r, p[1] + v[1] * r)))
    for i, ((enter, leave), r) in enumerate(zip(ends, radii, strict=True)):
        if r > 0:
            p = corners[i]
            centre = (enter[0] + leave[0] - p[0], enter[1] + leave[1] - p[1])
            start = degrees(atan2(enter[1] - centre[1], enter[0] - centre[0]))
            out.append(Arc(centre, r, start, -90.0 if _reflex(corners, i) else 90.0))
        out.append(Line(leave, ends[(i + 1) % n][0]))
    return tuple(out)


def _towards(a: Point, b: Point) -> Point:
    by = hypot(b[0] - a[0], b[1] - a[1])
    return (b[0] - a[0]) / by, (b[1] - a[1]) / by


def _sharp(model: Model, entity: Entity) -> list[Point] | None:
    """The corners of an open parameterised profile without its fillets."""
    if entity.is_a("IfcZShapeProfileDef"):  # its flanges are measured from the back of the web
        number = partial(_number, entity, model.mm)
        h, b = number("Depth") / 2, number("FlangeWidth")
        t, w = number("FlangeThickness"), number("WebThickness") / 2
        half = [(-w, -h), (b - w, -h), (b - w, t - h), (w, t - h)]
        return half + [(-x, -y) for x, y in half]
    measures = _measures(model, entity)
    if measures is None:
        return None
    code, (high, wide, t, web, _) = measures
    h, b = high / 2, wide / 2
    if code == "I":
        w = web / 2
        half = [(b, -h), (b, t - h), (w, t - h), (w, h - t), (b, h - t), (b, h)]
        return half + [(-x, -y) for x, y in half]
    if code == "U":
        w = web - b
        return [(-b, -h), (b, -h), (b, t - h), (w, t - h), (w, h - t), (b, h - t), (b, h), (-b, h)]
    if code == "L":
        return [(-b, -h), (b, -h), (b, t - h), (t - b, t - h), (t - b, h), (-b, h)]
    return None
