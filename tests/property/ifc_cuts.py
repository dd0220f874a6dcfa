"""Members with cuts, written as IFC.

A cut is stated in DSTV's coordinates of the member, (x, Y, Z). Nothing here comes from the reader.
"""

from collections.abc import Sequence
from math import cos, pi, sin

from msgspec import Struct

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
    sizes: tuple[float, float, float, float, float]  #: height, width, flange, web, root radius
    girth: float = 0.0  #: of the lips of a cold formed channel (C)


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
            case "C":
                sizes = f"{h},{b},{tw},{bar.girth},{r}"
                return m.add(f"IFCCSHAPEPROFILEDEF(.AREA.,$,{m.flat},{sizes})")
            case "L" if tf != tw:  # of which IFC has no definition
                at = lie("L", bar.sizes)
                return m.polygon(
                    *((at.origin[0] + z, at.origin[1] + y) for y, z in angle_corners(bar))
                )
            case "L":
                return m.add(f"IFCLSHAPEPROFILEDEF(.AREA.,$,{m.flat},{h},{b},{tw},{r},$,$)")
            case "T":
                return m.add(
                    f"IFCTSHAPEPROFILEDEF(.AREA.,$,{m.flat},{b},{h},{tf},{tw},{r},$,$,$,$)"
                )
            case "M":
                radii = f"{r - tw},{r}" if r > tw else "$,$"
                sizes = f"{b},{h},{tw},{radii}"
                return m.add(f"IFCRECTANGLEHOLLOWPROFILEDEF(.AREA.,$,{m.flat},{sizes})")
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


def angle_corners(bar: Bar, chords: int = 15) -> list[tuple[float, float]]:
    """The corners (Y, Z) of an angle, its fillet of so many chords."""
    h, b, tf, tw, r = bar.sizes
    turns = [pi / 2 * i / chords for i in range(chords + 1)] if r else []
    root = [(tf + r * (1 - sin(a)), tw + r * (1 - cos(a))) for a in turns] or [(tf, tw)]
    return [(0.0, 0.0), (0.0, b), (tf, b), *reversed(root), (h, tw), (h, 0.0)]


def walls(bar: Bar) -> dict[str, tuple[int, float, float, float]]:
    """Normal axis, lowest and highest depth and width of the wall behind each face."""
    h, b, tf, tw, _ = bar.sizes
    top, bottom = (1, h - tf, h, b), (1, 0.0, tf, b)
    match bar.code:
        case "I":
            return {"v": (2, (b - tw) / 2, (b + tw) / 2, h), "o": top, "u": bottom}
        case "U" | "C":
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


def model_of(bar: Bar, cutters: Sequence[Cutter]) -> bytes:
    made = Cuts()
    made.small.element(made.body(bar, cutters))
    return made.small.data
