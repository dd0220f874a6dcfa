"""A part as a solid of the geometry kernel: stock, end planes, what contours and holes take.

So what was read can be measured beside the member that went in. Nothing here comes from the reader.
"""

from math import cos, hypot, pi, radians, sin, tan
from typing import Any

from msgspec.structs import replace

from beamcam.model.part import Bevel, Contour, Hole, Part, Slot
from tests.property.ifc_builder import Vec
from tests.property.ifc_cuts import Bar, Cuts, Half, Round, walls


def remade(part: Part, bar: Bar) -> tuple[Cuts, str]:
    """A model of what was read: the stock, end planes, contours and holes; and its body."""
    made = Cuts()
    whole = replace(bar, length=part.length)
    h, b, tf, tw, r = bar.sizes
    corners = [(y, z) for y in (0.0, h) for z in (0.0, b)]
    if bar.code == "L":
        corners = [(0.0, 0.0), (0.0, b), (tf, b), (h, 0.0), (h, tw)]
    if bar.code == "T":
        s0, s1 = (h - tf) / 2, (h + tf) / 2
        corners = [(0.0, 0.0), (0.0, tw), (h, 0.0), (h, tw), (s0, b), (s1, b)]
    if bar.code in ("RO", "RU"):
        corners = [(h / 2 * (1 + cos(i / 500)), h / 2 * (1 + sin(i / 500))) for i in range(3142)]
    item = made.small.extruded(made.profile(whole), part.length)
    taken: list[str] = []
    c = part.cuts
    for side, web, flange in ((-1, c.web_start, c.flange_start), (1, c.web_end, c.flange_end)):
        slope, lean = -tan(radians(web)), -tan(radians(flange))
        if web or flange:
            reach = [slope * y + lean * z for y, z in corners]
            x = part.length - max(reach) if side > 0 else -min(reach)
            by = (1 + slope * slope + lean * lean) ** 0.5
            normal = (side / by, -side * slope / by, -side * lean / by)
            taken.append(made.cutter(whole, Half((x, 0.0, 0.0), normal)))
    for face in {f.face for f in part.features if isinstance(f, Contour)}:
        normal, low, high, width = walls(bar)[face]
        gone = gone_of(part, face, width)
        # Beyond the surface there is air, in which faces do not lie on faces.
        low_side = low if low > 0.0 else low - 5.0
        high_side = high if high < (h if normal == 1 else b) else high + 5.0
        taken += [made.prism(whole, ring, normal, low_side, high_side) for ring in rings(gone)]
        taken += [_lip(made, whole, face, ring) for ring in _over_lips(whole, face, gone)]
        between = {
            "I": (tf, h - tf),
            "U": (tf, h - tf),
            "C": (tf, h - tf),
            "L": (tf, h),
            "T": (tw, b),
        }.get(bar.code)
        stands = normal == (1 if bar.code == "T" else 2)
        if between and stands:
            strip = shapely_box(-50.0, between[0], part.length + 50.0, between[1])
            for ring in rings(gone.intersection(strip)):
                taken.append(made.prism(whole, ring, normal, low - r, high + r))
    taken += [wedge(made, whole, f, b) for f in part.contours for b in f.bevels]
    for f in part.features:
        if isinstance(f, Hole) and bar.code in ("RO", "RU"):
            taken.append(_radial(made, whole, f))
        elif isinstance(f, Hole | Slot):
            taken.append(_drilled(made, whole, f))
    return made, made.small.minus(item, *taken)


def _over_lips(bar: Bar, face: str, gone: Any) -> list[list[tuple[float, float]]]:
    """The borders of what is gone of a flange over its lip and their bend, which go with it."""
    b, bend = bar.sizes[1], bar.sizes[3] + bar.sizes[4]
    if not bar.girth or face not in ("o", "u"):
        return []
    return rings(gone.intersection(shapely_box(-50.0, b - bend, bar.length + 50.0, b + 5.0)))


def _lip(made: Cuts, bar: Bar, face: str, ring: list[tuple[float, float]]) -> str:
    h, girth = bar.sizes[0], bar.girth
    low, high = (h - girth, h + 5.0) if face == "o" else (-5.0, girth)
    return made.prism(bar, ring, 1, low, high)


def wedge(made: Cuts, bar: Bar, contour: Contour, bevel: Bevel) -> str:
    """What a bevel takes: a triangle from the surface inwards, pushed along its edge."""
    from shapely import Point, Polygon

    normal, low, high, _ = walls(bar)[contour.face]
    curve = contour.curves[bevel.curve]
    (ax, aq), (bx, bq) = curve.start, curve.end
    long = hypot(bx - ax, bq - aq)
    ex, eq = (bx - ax) / long, (bq - aq) / long
    nx, nq = -eq, ex
    inside = Polygon([c.start for c in contour.curves])
    if not inside.contains(Point((ax + bx) / 2 + nx * 0.01, (aq + bq) / 2 + nq * 0.01)):
        nx, nq = -nx, -nq
    outer = contour.face in ("v", "o")
    from_high = outer == (bevel.angle > 0)
    deep = high - low - bevel.land
    if bevel.angle < 0.0:  # of the far side, which its land counts from; 0 is all of the wall
        deep = bevel.land or high - low
    wide = deep * tan(radians(abs(bevel.angle)))
    top, way = (high, -1.0) if from_high else (low, 1.0)

    def at(x: float, q: float, c: float) -> Vec:
        p = [x, q, q]
        p[normal] = c
        return made.point(bar, (p[0], p[1], p[2]))

    def towards(x: float, q: float, c: float) -> Vec:
        a, b = at(0.0, 0.0, 0.0), at(x, q, c)
        return (b[0] - a[0], b[1] - a[1], b[2] - a[2])

    along, inwards, down = towards(ex, eq, 0.0), towards(nx, nq, 0.0), towards(0.0, 0.0, way)
    cross = (
        along[1] * inwards[2] - along[2] * inwards[1],
        along[2] * inwards[0] - along[0] * inwards[2],
        along[0] * inwards[1] - along[1] * inwards[0],
    )
    sense = 1.0 if sum(a * b for a, b in zip(cross, down, strict=True)) > 0 else -1.0
    m = made.small
    # A little higher than the surface and longer than the edge, so that no faces coincide.
    grown = 1.0 + 1.0 / deep
    corners = ((0.0, -sense), (wide * grown, -sense), (0.0, sense * deep))
    return m.extruded(m.polygon(*corners), long, m.step.axes(at(ax, aq, top), along, inwards))


def _radial(made: Cuts, bar: Bar, f: Hole) -> str:
    r = bar.sizes[0] / 2
    angle = f.y / r
    way = (0.0, -cos(angle), sin(angle))
    o = made.point(bar, (f.x, r, r))
    at = made.step.axes(o, made.vector(bar, way), made.vector(bar, (1, 0, 0)))
    m = made.small
    if bar.code == "RU":
        back = made.point(bar, (f.x, r - 2 * r * way[1], r - 2 * r * way[2]))
        at = made.step.axes(back, made.vector(bar, way), made.vector(bar, (1, 0, 0)))
        return m.extruded(m.circle(f.diameter), 4 * r, at)
    return m.extruded(m.circle(f.diameter), 2 * r, at)


def _drilled(made: Cuts, bar: Bar, f: Hole | Slot) -> str:
    normal, low, high, _ = walls(bar)[f.face if f.face in walls(bar) else "v"]
    if f.depth is not None:
        outer = f.face in ("v", "o")
        low, high = (high - f.depth, high) if outer else (low, low + f.depth)
    # Beyond the section there is air, in which faces do not lie on faces.
    low = low - 3.0 if low <= 0.0 else low
    high = high + 3.0 if high >= bar.sizes[normal - 1] else high
    r = f.diameter / 2
    if isinstance(f, Hole):
        at = [f.x, f.y, f.y]
        at[normal] = low
        return made.cutter(bar, Round((at[0], at[1], at[2]), normal, f.diameter, high - low))
    turn = radians(f.angle)
    ring = []
    for i in range(720):
        t = 2 * pi * i / 720
        x, q = r * cos(t), r * sin(t)
        x += f.length / 2 * (1 if cos(t) >= 0 else -1)
        q += f.height / 2 * (1 if sin(t) >= 0 else -1)
        ring.append((f.x + x * cos(turn) - q * sin(turn), f.y + x * sin(turn) + q * cos(turn)))
    return made.prism(bar, ring, normal, low, high)


def shapely_box(*bounds: float) -> Any:
    from shapely import box

    return box(*bounds)


def gone_of(part: Part, face: str, width: float) -> Any:
    """What the contours of a face take of its wall, in (x, q)."""
    from shapely import Polygon, union_all

    left = []
    gone = []
    for f in part.contours:
        if f.face != face:
            continue
        points = [c.point(i / n) for c in f.curves for n in (_steps(c),) for i in range(n)]
        (left if f.kind == "outer" else gone).append(Polygon(points).buffer(0))
    if left:
        stock = shapely_box(-50.0, 0.0, part.length + 50.0, width)
        gone.append(stock.difference(union_all(left)))
    return _over_edges(union_all(gone), width)


def _over_edges(gone: Any, width: float) -> Any:
    """What is gone, a little over the edges of its wall where it is open: no faces coincide."""
    from shapely import LineString, union_all

    x0, _, x1, _ = gone.bounds
    over = [gone]
    for edge, outside in ((0.0, -5.0), (width, width + 5.0)):
        inside = edge + (1e-4 if edge == 0.0 else -1e-4)
        line = gone.intersection(LineString([(x0 - 1, inside), (x1 + 1, inside)]))
        for piece in getattr(line, "geoms", (line,)):
            if piece.geom_type == "LineString" and piece.length > 1e-3:
                a, _, b, _ = piece.bounds
                over.append(shapely_box(a, min(inside, outside), b, max(inside, outside)))
    return union_all(over)


def _steps(curve: Any) -> int:
    return 1 if not hasattr(curve, "radius") else 90


def shape_of(part: Part, bar: Bar) -> Bar:
    """The bar that a part was read as, which may be what is left of another section."""
    p = part.profile
    web = p.web_thickness or 0.0
    sizes = (p.height, web if p.code == "B" else p.width, p.flange_thickness, web, p.radius)
    same = all(abs(a - b) < 0.01 for a, b in zip(sizes[:4], bar.sizes[:4], strict=True))
    if p.code == bar.code and same:
        return bar
    return Bar(p.code, part.length, sizes, bar.girth if p.code == "C" else 0.0)


def rings(shape: Any) -> list[list[tuple[float, float]]]:
    """The borders of the pieces of a shape; pieces with hollows are cut in two."""
    from shapely import box

    out = []
    for piece in getattr(shape, "geoms", (shape,)):
        if piece.geom_type != "Polygon" or piece.area < 1e-6:
            continue
        if piece.interiors:
            x0, y0, x1, y1 = piece.bounds
            at = piece.interiors[0].centroid.x
            for half in (box(x0, y0, at, y1), box(at, y0, x1, y1)):
                out += rings(piece.intersection(half))
            continue
        out.append(list(piece.exterior.coords)[:-1])
    return out
