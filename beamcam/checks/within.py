"""Openings that no tool has to make, as all of their steel goes with a larger one."""

from math import atan2, cos, pi, radians, sin
from typing import Any

from beamcam.geometry.plane import Box
from beamcam.model.part import Contour, Face, Hole, Part, Slot

OFF = 0.05  #: mm by which the smaller one may stand out of the larger one
LESS = 1.0  #: mm2 that it is less than the other at least
SAG = 0.01  #: mm from a chord to its curve
FAR = 80.0  #: mm, side of the squares by which openings are found
LARGEST = 2e4  #: mm of a side of an opening; a larger one is in no sheet
WAYS = 144  #: directions in which two are compared


Opening = Hole | Slot | Contour


def needless(part: Part) -> frozenset[int]:
    """The openings, by their indices, that lie in one that goes through the wall of their face."""
    every: list[tuple[int, Any]] = [*enumerate(part.features)]
    every += [(-1, one) for one in part.made or ()]
    openings = [(k, one) for k, one in every if _is_opening(one)]
    if len({_size(one) for _, one in openings}) < 2:
        return frozenset()
    boxes = [(k, one, _box(one)) for k, one in openings]
    pieces = [
        (one.face, _box(one)) for _, one in every
        if isinstance(one, Contour) and one.kind == "outer"
    ] if any(isinstance(one, Contour) for _, one in openings) else []  # fmt: skip
    voids: dict[tuple[Face, int, int], list[tuple[Opening, Box]]] = {}
    for _, one, box in boxes:
        if isinstance(one, Contour):
            stays = any(face == one.face and _in(piece, box) for face, piece in pieces)
        else:
            stays = one.kind != "through" or one.depth is not None
        if stays or max(box[2] - box[0], box[3] - box[1]) > LARGEST:
            continue  # something of the wall is in it, or it is in no sheet
        for x in range(int(box[0] // FAR), int(box[2] // FAR) + 1):
            for y in range(int(box[1] // FAR), int(box[3] // FAR) + 1):
                voids.setdefault((one.face, x, y), []).append((one, box))
    within, areas = [], dict[int, Any]()  # areas by identity: in a crowd each is asked for often
    for k, one, box in boxes:
        middle = int((box[0] + box[2]) / 2 // FAR), int((box[1] + box[3]) / 2 // FAR)
        for other, around in voids.get((one.face, *middle), ()):
            if other is not one and k >= 0 and _in(box, around) and _goes_with(one, other, areas):
                within.append(k)
    return frozenset(within)


def _is_opening(one: Any) -> bool:
    if isinstance(one, Contour):
        return one.kind == "inner" and one.process == "cut" and one.closed
    return isinstance(one, Hole | Slot) and one.kind in ("through", "blind", "countersink")


def _size(one: Any) -> object:
    """The same of two that are equally large; each cut-out is by itself."""
    if isinstance(one, Contour):
        return id(one)
    return one.diameter, getattr(one, "length", 0.0), getattr(one, "height", 0.0)


def _box(one: Opening) -> Box:
    """Of cut-outs that of their curves, of others by how far they reach in four directions."""
    if isinstance(one, Hole):
        r = one.diameter / 2
        return one.x - r, one.y - r, one.x + r, one.y + r
    if isinstance(one, Contour):
        left, low, right, high = zip(*(curve.bbox for curve in one.curves), strict=True)
        return min(left), min(low), max(right), max(high)
    return (
        -_reach(one, pi), -_reach(one, -pi / 2), _reach(one, 0.0), _reach(one, pi / 2)
    )  # fmt: skip


def _in(box: Box, other: Box) -> bool:
    """Whether a box lies in another one."""
    low = box[0] >= other[0] - OFF and box[1] >= other[1] - OFF
    return low and box[2] <= other[2] + OFF and box[3] <= other[3] + OFF


def _reach(one: Hole | Slot, way_rad: float) -> float:
    """How far an opening reaches in a direction, from 0, 0 on."""
    far = one.x * cos(way_rad) + one.y * sin(way_rad) + one.diameter / 2
    if isinstance(one, Slot):
        beside = way_rad - radians(one.angle)
        far += abs(cos(beside)) * one.length / 2 + abs(sin(beside)) * one.height / 2
    return far


def _goes_with(one: Opening, other: Opening, areas: dict[int, Any]) -> bool:
    """Whether an opening is smaller than another one and lies in it.

    Round and slotted ones are convex: the one lies in the other if in no direction it reaches
    farther, from middle to middle and square to the other's sides among them.
    """
    if isinstance(one, Contour) or isinstance(other, Contour):
        for each in (one, other):
            if id(each) not in areas:
                areas[id(each)] = _area(each)
        small, large = areas[id(one)], areas[id(other)]
        less = bool(small.area + LESS <= large.area)
        return less and bool(small.difference(large.buffer(OFF)).is_empty)
    if _area_of(one) + LESS > _area_of(other):
        return False
    turn = radians(other.angle) if isinstance(other, Slot) else 0.0
    ways = [turn + k * 2 * pi / WAYS for k in range(WAYS)]
    ways.append(atan2(one.y - other.y, one.x - other.x))
    return all(_reach(one, way) <= _reach(other, way) + OFF for way in ways)


def _area_of(one: Hole | Slot) -> float:
    r = one.diameter / 2
    if isinstance(one, Hole):
        return pi * r**2
    return pi * r**2 + one.diameter * (one.length + one.height) + one.length * one.height


def _area(one: Opening) -> Any:
    """The region of an opening, of shapely."""
    from shapely import MultiPoint, Polygon, make_valid

    from beamcam.geometry.polylines import polylines

    if isinstance(one, Contour):
        return make_valid(Polygon(polylines(one.curves, SAG).points))
    c, s, places = 1.0, 0.0, [(0.0, 0.0)]
    if isinstance(one, Slot):
        c, s = cos(radians(one.angle)), sin(radians(one.angle))
        places = [(a * one.length / 2, b * one.height / 2) for a in (-1, 1) for b in (-1, 1)]
    middles = MultiPoint([(one.x + c * u - s * v, one.y + s * u + c * v) for u, v in places])
    return middles.convex_hull.buffer(one.diameter / 2, 64)
