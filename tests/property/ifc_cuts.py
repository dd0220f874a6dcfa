"""Members with cuts of every kind and proportion, and a part as a solid of the geometry kernel.

A cut is stated in DSTV's coordinates of the member, (x, Y, Z). `remade` writes what was read as a
model again: the stock, its end planes, and what contours and holes take, so that the kernel
measures both. Nothing here comes from the reader.
"""

from collections.abc import Sequence
from math import cos, hypot, pi, radians, sin, tan
from random import Random
from typing import Any

from msgspec import Struct

from beamcam.model.part import Bevel, Contour, Hole, Part, Slot
from tests.property.ifc_builder import Vec, lie
from tests.unit.readers.ifc.models import Small

SIZES = {
    "I": (300.0, 150.0, 10.7, 7.1, 15.0),
    "U": (200.0, 80.0, 11.0, 7.0, 12.0),
    "L": (120.0, 80.0, 10.0, 10.0, 11.0),
    "T": (140.0, 100.0, 9.0, 11.0, 12.0),
    "M": (200.0, 100.0, 8.0, 8.0, 0.0),
    "B": (160.0, 14.0, 0.0, 14.0, 0.0),
    "RO": (168.3, 168.3, 8.0, 8.0, 0.0),
    "RU": (60.0, 60.0, 0.0, 60.0, 0.0),
}  # height, width, flange, web, root radius


class Bar(Struct, frozen=True):
    code: str
    length: float
    sizes: tuple[float, float, float, float, float]


class Box(Struct, frozen=True):
    """A block that is taken away, turned by small angles about its middle."""

    low: Vec
    high: Vec
    tilt: tuple[float, float] = (0.0, 0.0)  #: radians about Y and about Z


class Round(Struct, frozen=True):
    """A cylinder that is taken away, along Y or Z (1 or 2)."""

    at: Vec
    along: int
    diameter: float
    depth: float
    lean: float = 0.0  #: radians, towards x


class Half(Struct, frozen=True):
    """All beyond a plane, on the side of its normal."""

    at: Vec
    normal: Vec


Cutter = Box | Round | Half


class Cuts:
    """A model of members with cuts."""

    def __init__(self) -> None:
        self.small = Small()
        self.step = self.small.step

    def profile(self, bar: Bar) -> str:
        m = self.small
        h, b, tf, tw, r = bar.sizes
        match bar.code:
            case "I":
                return m.add(f"IFCISHAPEPROFILEDEF(.AREA.,$,{m.flat},{b},{h},{tw},{tf},{r},$,$)")
            case "U":
                return m.add(f"IFCUSHAPEPROFILEDEF(.AREA.,$,{m.flat},{h},{b},{tw},{tf},{r},$,$)")
            case "L":
                return m.add(f"IFCLSHAPEPROFILEDEF(.AREA.,$,{m.flat},{h},{b},{tw},{r},$,$)")
            case "T":
                return m.add(
                    f"IFCTSHAPEPROFILEDEF(.AREA.,$,{m.flat},{b},{h},{tf},{tw},{r},$,$,$,$)"
                )
            case "M":
                return m.add(f"IFCRECTANGLEHOLLOWPROFILEDEF(.AREA.,$,{m.flat},{b},{h},{tw},$,$)")
            case "RO":
                return m.add(f"IFCCIRCLEHOLLOWPROFILEDEF(.AREA.,$,{m.flat},{h / 2},{tw})")
            case "RU":
                return m.add(f"IFCCIRCLEPROFILEDEF(.AREA.,$,{m.flat},{h / 2})")
        return m.box(b, h)

    def point(self, bar: Bar, p: Vec) -> Vec:
        at = lie(bar.code, bar.sizes)
        px = at.origin[0] + at.y[0] * p[1] + at.z[0] * p[2]
        py = at.origin[1] + at.y[1] * p[1] + at.z[1] * p[2]
        return (p[0] if at.forward else bar.length - p[0], px, py)

    def vector(self, bar: Bar, v: Vec) -> Vec:
        a, b = self.point(bar, (0, 0, 0)), self.point(bar, v)
        return (b[0] - a[0], b[1] - a[1], b[2] - a[2])

    def body(self, bar: Bar, cutters: Sequence[Cutter]) -> str:
        item = self.small.extruded(self.profile(bar), bar.length)
        return self.small.minus(item, *(self.cutter(bar, c) for c in cutters))

    def cutter(self, bar: Bar, cutter: Cutter) -> str:
        m = self.small
        if isinstance(cutter, Half):
            return m.half(self.point(bar, cutter.at), self.vector(bar, cutter.normal))
        if isinstance(cutter, Round):
            axis = [sin(cutter.lean), 0.0, 0.0]
            axis[cutter.along] = cos(cutter.lean)
            z = self.vector(bar, (axis[0], axis[1], axis[2]))
            at = m.step.axes(self.point(bar, cutter.at), z, self.vector(bar, (1, 0, 0)))
            return m.extruded(m.circle(cutter.diameter), cutter.depth, at)
        (x0, y0, z0), (x1, y1, z1) = cutter.low, cutter.high
        about_y, about_z = cutter.tilt
        along = self.vector(bar, (1.0, about_z, -about_y))
        up = self.vector(bar, (about_y, 0.0, 1.0))
        middle = self.point(bar, ((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2))
        by = (z1 - z0) / 2
        o = (middle[0] - up[0] * by, middle[1] - up[1] * by, middle[2] - up[2] * by)
        return m.extruded(m.box(x1 - x0, y1 - y0), z1 - z0, m.step.axes(o, up, along))

    def prism(self, bar: Bar, ring: Sequence[tuple[float, float]], normal: int, low: float,
              high: float) -> str:  # fmt: skip
        """An outline in (x, q), pushed through a wall from one depth to another."""
        m = self.small
        corner = [0.0, 0.0, 0.0]
        corner[normal] = low
        axis = [0.0, 0.0, 0.0]
        axis[normal] = 1.0
        across = [0.0, 0.0, 0.0]
        across[3 - normal] = 1.0
        ex, ec = self.vector(bar, (1, 0, 0)), self.vector(bar, (axis[0], axis[1], axis[2]))
        eq = self.vector(bar, (across[0], across[1], across[2]))
        cross = (
            ec[1] * ex[2] - ec[2] * ex[1], ec[2] * ex[0] - ec[0] * ex[2],
            ec[0] * ex[1] - ec[1] * ex[0],
        )  # fmt: skip
        sense = 1.0 if sum(a * b for a, b in zip(cross, eq, strict=True)) > 0 else -1.0
        at = m.step.axes(self.point(bar, (corner[0], corner[1], corner[2])), ec, ex)
        return m.extruded(m.polygon(*((x, sense * q) for x, q in ring)), high - low, at)


def walls(bar: Bar) -> dict[str, tuple[int, float, float, float]]:
    """Normal axis, lowest and highest depth and width of the wall behind each face."""
    h, b, tf, tw, _ = bar.sizes
    top, bottom = (1, h - tf, h, b), (1, 0.0, tf, b)
    match bar.code:
        case "I":
            return {"v": (2, (b - tw) / 2, (b + tw) / 2, h), "o": top, "u": bottom}
        case "U":
            return {"v": (2, 0.0, tw, h), "o": top, "u": bottom}
        case "L":
            return {"v": (2, 0.0, tw, h), "u": bottom}
        case "T":
            return {"v": (2, 0.0, tw, h), "o": (1, (h - tf) / 2, (h + tf) / 2, b)}
        case "M":
            return {"v": (2, b - tw, b, h), "h": (2, 0.0, tw, h), "o": top, "u": bottom}
        case "B":
            return {"v": (2, 0.0, b, h)}
    return {}


def remade(part: Part, bar: Bar) -> tuple[Cuts, str]:
    """A model of what was read: the stock, end planes, contours and holes; and its body."""
    made = Cuts()
    whole = Bar(bar.code, part.length, bar.sizes)
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
        between = {"I": (tf, h - tf), "U": (tf, h - tf), "L": (tf, h), "T": (tw, b)}.get(bar.code)
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
    return bar if p.code == bar.code and same else Bar(p.code, part.length, sizes)


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


def kernel_volume(data: bytes, library: str = "opencascade") -> float | None:
    """cm3 of the exact solid of a beam, by a geometry kernel alone; None where it has none."""
    import ifcopenshell
    import ifcopenshell.geom as geom

    file = ifcopenshell.file.from_string(data.decode())
    settings = geom.settings()
    settings.set("circle-segments", 256)
    if library == "opencascade":
        settings.set("iterator-output", ifcopenshell.ifcopenshell_wrapper.NATIVE)
    ifcopenshell.get_log()
    try:
        solid = geom.create_shape(settings, file.by_type("IfcElement")[0], geometry_library=library)
    except RuntimeError:
        return None
    if library != "opencascade":
        v, f = solid.geometry.verts, solid.geometry.faces
        p = [(v[i], v[i + 1], v[i + 2]) for i in range(0, len(v), 3)]
        corners = ((p[f[i]], p[f[i + 1]], p[f[i + 2]]) for i in range(0, len(f), 3))
        return abs(sum(_six(*c) for c in corners)) * 1e6 / 6
    found = float(solid.volume) * 1e6
    return None if "[error]" in str(ifcopenshell.get_log()).lower() else found


def _six(a: Vec, b: Vec, c: Vec) -> float:
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def volumes(data: bytes, other: bytes) -> tuple[float, float] | None:
    """cm3 of two solids by the first kernel by which they are the same, or else by the exact one.

    Opencascade loses pieces where faces nearly lie on one another; manifold has facets for arcs.
    """
    pairs = []
    for library in ("opencascade", "manifold", "cgal"):
        both = kernel_volume(data, library), kernel_volume(other, library)
        if both[0] is not None and both[1] is not None and both[0] > 0:
            pairs.append((both[0], both[1]))
            if same(*pairs[-1]):
                return pairs[-1]
    return pairs[0] if pairs else None


def same(true: float, found: float) -> bool:
    """Whether two volumes in cm3 are those of one part."""
    return abs(true - found) <= 0.1 + 1e-5 * true


def facets(data: bytes) -> tuple[list[Vec], list[tuple[int, int, int]]]:
    """Corners in mm and triangles of a beam's solid, as a viewer has them."""
    import ifcopenshell
    import ifcopenshell.geom as geom

    file = ifcopenshell.file.from_string(data.decode())
    settings = geom.settings()
    settings.set("weld-vertices", True)
    settings.set("mesher-angular-deflection", 0.35)
    solid = geom.create_shape(settings, file.by_type("IfcElement")[0])
    v, f = solid.geometry.verts, solid.geometry.faces
    points = [(v[i] * 1e3, v[i + 1] * 1e3, v[i + 2] * 1e3) for i in range(0, len(v), 3)]
    return points, [(f[i], f[i + 1], f[i + 2]) for i in range(0, len(f), 3)]


def meshed(data: bytes) -> bytes:
    """A model whose beam is the mesh of another's."""
    points, triangles = facets(data)
    m = Small()
    listed = ",".join("(" + ",".join(m.step.length(round(v, 6)) for v in p) + ")" for p in points)
    where = m.add(f"IFCCARTESIANPOINTLIST3D(({listed}))")
    faces = ",".join(f"({a + 1},{b + 1},{c + 1})" for a, b, c in triangles)
    body = m.add(f"IFCTRIANGULATEDFACESET({where},$,.T.,({faces}),$)")
    m.element(body, kind_of_body="Tessellation")
    return m.data


def some_bar(random: Random, codes: str = "I I U L T M B") -> Bar:
    code = random.choice(codes.split())
    factor = random.choice((1.0, 1.0, 0.6, 1.7))
    sizes = tuple(round(v * factor, 2) for v in SIZES[code])
    return Bar(code, round(random.uniform(600, 2500), 1), sizes)  # type: ignore[arg-type]


def cope(random: Random, bar: Bar, tilt: float = 0.0) -> Box:
    """A block at an end, from above or below, over the width or over a side of it."""
    h, b = bar.sizes[:2]
    long = random.uniform(5, 0.3 * bar.length)
    deep = random.choice((random.uniform(2, 0.15 * h), random.uniform(0.05 * h, 0.6 * h)))
    x = (-20.0, long) if random.random() < 0.5 else (bar.length - long, bar.length + 20.0)
    y = (-20.0, deep) if random.random() < 0.5 else (h - deep, h + 20.0)
    z = (-20.0, b + 20.0)
    if random.random() < 0.25 and bar.code in ("I", "M"):
        tw = bar.sizes[3]
        z = (-20.0, (b - tw) / 2) if random.random() < 0.5 else ((b + tw) / 2, b + 20.0)
    tilts = (random.uniform(-tilt, tilt), random.uniform(-tilt, tilt))
    return Box((x[0], y[0], z[0]), (x[1], y[1], z[1]), tilts)


def copes(random: Random) -> tuple[Bar, list[Cutter]]:
    bar = some_bar(random)
    return bar, [cope(random, bar) for _ in range(random.randint(1, 4))]


def tilted(random: Random) -> tuple[Bar, list[Cutter]]:
    bar = some_bar(random)
    tilt = 10 ** random.uniform(-7, -3)
    return bar, [cope(random, bar, tilt) for _ in range(random.randint(1, 2))]


def mitred(random: Random) -> tuple[Bar, list[Cutter]]:
    """Mitres, some in two halves, some with a cope beside them."""
    bar = some_bar(random)
    h, b = bar.sizes[:2]
    out: list[Cutter] = []
    for _ in range(random.randint(1, 3)):
        turn = radians(random.choice((0.0, 15.0, 30.0, 45.0, random.uniform(-50, 50))))
        lean = radians(random.choice((0.0, 0.0, random.uniform(-40, 40))))
        end = random.random() < 0.6
        x = bar.length - random.uniform(5, 120) if end else random.uniform(5, 120)
        side = 1.0 if end else -1.0
        normal = (side * cos(turn) * cos(lean), sin(turn) * cos(lean), sin(lean))
        out.append(Half((x, h / 2, b / 2), normal))
    if random.random() < 0.5:
        out.append(cope(random, bar))
    return bar, out


def windows(random: Random) -> tuple[Bar, list[Cutter]]:
    """Openings of any size in any wall, some through both of a tube's, some over an edge."""
    bar = some_bar(random)
    out: list[Cutter] = []
    for _ in range(random.randint(1, 3)):
        normal, low, high, width = random.choice(list(walls(bar).values()))
        x, q = random.uniform(50, bar.length - 50), random.uniform(0, width)
        dx, dq = random.uniform(5, 120), random.uniform(5, 0.4 * width)
        a, c = [x - dx, q - dq, q - dq], [x + dx, q + dq, q + dq]
        a[normal], c[normal] = low - 3, high + 3
        out.append(Box((a[0], a[1], a[2]), (c[0], c[1], c[2])))
    return bar, out


def drilled(random: Random) -> tuple[Bar, list[Cutter]]:
    """Holes anywhere: near edges, over ends, into one another, in fillets, blind, askew."""
    bar = some_bar(random, "I U L T M B RO RU")
    h, _ = bar.sizes[:2]
    out: list[Cutter] = []
    for _ in range(random.randint(1, 5)):
        if bar.code in ("RO", "RU"):
            q = random.choice((h / 2, h / 2, h / 2 + random.uniform(-0.3, 0.3) * h))
            x = random.choice((random.uniform(0, 60), random.uniform(100, bar.length - 100)))
            along = random.choice((1, 2))
            at = [x, q, q]
            at[along] = random.choice((-10.0, h / 2))
            d = random.uniform(6, 0.5 * h)
            out.append(Round((at[0], at[1], at[2]), along, d, h + 20.0))
            continue
        normal, low, high, width = random.choice(list(walls(bar).values()))
        at = [random.choice((random.uniform(0, 40), random.uniform(40, bar.length - 40))), 0.0, 0.0]
        at[3 - normal] = random.uniform(0, width)
        deep = random.choice((high - low + 6, high - low + 6, (high - low) * 0.6 + 3))
        at[normal] = low - 3 if random.random() < 0.5 else high + 3 - deep
        lean = random.choice((0.0, 0.0, 0.0, 0.0, 0.1))
        d = random.choice((14.0, 18.0, 22.0, 40.0))
        out.append(Round((at[0], at[1], at[2]), normal, d, deep, lean))
    return bar, out


def tubes(random: Random) -> tuple[Bar, list[Cutter]]:
    """Slots, saddles, windows and flats of round and square tubes."""
    bar = some_bar(random, "RO RO RU M")
    h, b, t = bar.sizes[0], bar.sizes[1], bar.sizes[3]
    kind = random.choice(("slot", "saddle", "window", "flat", "mitre", "cross"))
    long = random.uniform(20, 200)
    wide = random.uniform(4, 0.5 * b)
    end = random.random() < 0.5
    x = (bar.length - long, bar.length + 20.0) if end else (-20.0, long)
    out: list[Cutter] = []
    if kind in ("slot", "cross"):
        out.append(Box((x[0], -20.0, b / 2 - wide / 2), (x[1], h + 20.0, b / 2 + wide / 2)))
    if kind == "cross":
        out.append(Box((x[0], h / 2 - wide / 2, -20.0), (x[1], h / 2 + wide / 2, b + 20.0)))
    if kind == "saddle":
        at = bar.length if end else 0.0
        out.append(Round((at, -50.0, b / 2), 1, random.uniform(0.6, 2) * b, h + 100.0))
    if kind == "window":
        at = random.uniform(150, bar.length - 150)
        out.append(Box((at - long / 2, -20.0, b / 2 - wide), (at + long / 2, t * 2, b / 2 + wide)))
    if kind == "flat":
        out.append(Box((x[0], h - random.uniform(1, 0.4 * h), -20.0), (x[1], h + 20, b + 20.0)))
    if kind == "mitre" or random.random() < 0.3:
        turn = radians(random.uniform(-50, 50))
        out.append(Half((40.0, h / 2, b / 2), (-cos(turn), sin(turn), 0.0)))
    return bar, out


def bevelled(random: Random) -> tuple[Bar, list[Cutter]]:
    """Flat bars whose ends and edges are prepared for welding, from one side or both."""
    bar = some_bar(random, "B")
    h, t = bar.sizes[:2]
    out: list[Cutter] = []
    for _ in range(random.randint(1, 3)):
        turn = radians(random.choice((30.0, 37.5, 45.0, 60.0)))
        up = random.choice((-1.0, 1.0))
        land = random.uniform(0, 0.6) * t
        z = t - land if up > 0 else land
        if random.random() < 0.6:
            end = random.random() < 0.5
            at = (bar.length if end else 0.0, h / 2, z)
            normal = (cos(turn) * (1 if end else -1), 0.0, up * sin(turn))
        else:
            at, normal = (bar.length / 2, h, z), (0.0, cos(turn), up * sin(turn))
        out.append(Half(at, normal))
    return bar, out


def thinned(random: Random) -> tuple[Bar, list[Cutter]]:
    """Planes and blocks along the member: flanges thinned, tapered, taken off."""
    bar = some_bar(random, "I U L T M B")
    h, b, tf = bar.sizes[:3]
    if random.random() < 0.5:
        tilt = random.choice((0.0, 0.0, random.uniform(-0.02, 0.02)))
        return bar, [Half((bar.length / 2, h - random.uniform(1, 40), 0.0), (tilt, 1.0, 0.0))]
    x = sorted(random.uniform(-50, bar.length + 50) for _ in range(2))
    deep = random.uniform(0.3, 3) * (tf or 5.0)
    return bar, [Box((x[0], h - deep, -20.0), (x[1], h + 20.0, random.choice((b / 2, b + 20.0))))]


FAMILIES = {
    "copes": copes, "tilted": tilted, "mitred": mitred, "windows": windows, "drilled": drilled,
    "tubes": tubes, "bevelled": bevelled, "thinned": thinned,
}  # fmt: skip


def model_of(bar: Bar, cutters: Sequence[Cutter]) -> bytes:
    made = Cuts()
    made.small.element(made.body(bar, cutters))
    return made.small.data
