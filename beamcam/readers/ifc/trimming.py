"""Which cutters are saw cuts: those that take all of an end."""

from collections.abc import Sequence

from beamcam.geometry.curves import Line, Point
from beamcam.readers.ifc.curves2d import Chain, box_around
from beamcam.readers.ifc.cutters import Bounded, Cutter, HalfSpace, Prism
from beamcam.readers.ifc.ends import MIN_LEAN
from beamcam.readers.ifc.space import add, cross, dot, scale, size, sub, unit
from beamcam.readers.ifc.stock import Stock


def end_plane(cutter: Cutter, stock: Stock, corners: Sequence[Point]) -> HalfSpace | None:
    """The half-space that a cutter is for this member; None if it does not take all of an end."""
    if isinstance(cutter, Prism) and cutter.shape is not None:
        return None
    if isinstance(cutter, HalfSpace):
        return cutter if abs(cutter.normal[0]) > MIN_LEAN else None
    if isinstance(cutter, Bounded) and isinstance(cutter.first, HalfSpace):
        half = cutter.first
        if abs(half.normal[0]) > MIN_LEAN and isinstance(cutter.second, Prism):
            return half if _takes_all(cutter.second, half, stock, corners) else None
        return None
    if isinstance(cutter, Prism):
        for plane in _sides(cutter):
            if abs(plane.normal[0]) > MIN_LEAN and _takes_all(cutter, plane, stock, corners):
                return plane
    return None


def _sides(cutter: Prism) -> list[HalfSpace]:
    """The planes of a prism's flat sides and ends; normals point into the prism."""
    f = cutter.frame
    found = []
    for o, way in ((f.o, 1.0), (add(f.o, f.z), -1.0)):
        normal = unit(cross(f.x, f.y))
        if dot(normal, f.z) * way < 0:
            normal = scale(normal, -1.0)
        found.append(HalfSpace(o, normal, cutter.where))
    x0, y0, x1, y1 = box_around(cutter.outline.outer)
    middle = f.point(((x0 + x1) / 2, (y0 + y1) / 2, 0.5))
    for curve in cutter.outline.outer:
        if isinstance(curve, Line):
            a, b = f.point((*curve.start, 0.0)), f.point((*curve.end, 0.0))
            normal = cross(sub(b, a), f.z)
            if size(normal) < 1e-9:
                continue
            normal = unit(normal)
            if dot(normal, sub(middle, a)) < 0:
                normal = scale(normal, -1.0)
            found.append(HalfSpace(a, normal, cutter.where))
    return found


def _takes_all(cutter: Prism, plane: HalfSpace, stock: Stock, corners: Sequence[Point]) -> bool:
    """Whether a prism holds everything of the stock beyond a plane, up to the stock's end."""
    inverse = cutter.frame.inverse()
    far = stock.x1 if plane.normal[0] > 0 else stock.x0
    way = 1.0 if plane.normal[0] > 0 else -1.0
    some = False
    h, b = stock.section.height, stock.section.width
    for y, z in (*corners[:: max(1, len(corners) // 24)], (h / 2, b / 2)):
        x = plane.x_at(y, z)
        if way * (far - x) <= 1e-4:
            continue
        some = True
        for at in (x + way * 1e-3, (x + far) / 2, far - way * 1e-3):
            inner_y = min(max(y, 1e-3), h - 1e-3)
            inner_z = min(max(z, 1e-3), b - 1e-3)
            shift = plane.x_at(inner_y, inner_z) - x
            s, t, k = inverse.point(
                (at + (shift if at != far - way * 1e-3 else 0.0), inner_y, inner_z)
            )
            if not -1e-9 <= k <= 1 + 1e-9 or not _inside(cutter.outline.outer, (s, t)):
                return False
    return some


def _inside(chain: Chain, p: Point) -> bool:
    """Whether a point is inside a chain, its arcs taken as eight chords each."""
    points: list[Point] = []
    for curve in chain:
        count = 1 if isinstance(curve, Line) else 16
        points += [curve.point(i / count) for i in range(count)]
    inside = False
    for i, (bx, by) in enumerate(points):
        ax, ay = points[i - 1]
        if (ay > p[1]) != (by > p[1]) and p[0] < ax + (p[1] - ay) * (bx - ax) / (by - ay):
            inside = not inside
    return inside
