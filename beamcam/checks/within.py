"""Openings that no tool has to make, as all of their steel goes with a larger one."""

from math import atan2, cos, floor, pi, radians, sin
from typing import Any

from beamcam.geometry.plane import Box
from beamcam.model.part import Contour, Face, Hole, Part, Slot

OFF = 0.05  #: mm by which the smaller one may stand out of the larger one
LESS = 1.0  #: mm2 that it is less than the other at least
SAG = 0.01  #: mm from a chord to its curve
FAR = 80.0  #: mm, side of the squares by which openings are found
LARGEST = 2e4  #: mm of a side of an opening; a larger one is in no sheet
WAYS = 144  #: directions in which two are compared
ROUND = (Hole, Slot)
KINDS = ("through", "blind", "countersink")  #: of those, all but marks and threads


Opening = Hole | Slot | Contour


def needless(part: Part) -> frozenset[int]:
    """The openings, by their indices, that lie in one that goes through the wall of their face."""
    every: list[tuple[int, Any]] = [*enumerate(part.features)]
    every += [(-1, one) for one in part.made or ()]
    openings = [(k, one) for k, one in every if _is_opening(one)]
    cut_outs = [one for _, one in openings if type(one) is Contour]
    areas = [_area_of(one) for _, one in openings]
    enough = min(areas, default=0.0) + LESS  #: mm2 of one that another may be in
    if not cut_outs and max(areas, default=0.0) < enough:
        return frozenset()
    boxes = [(k, one, _box(one)) for k, one in openings]
    pieces = [
        (one.face, _box(one)) for _, one in every
        if isinstance(one, Contour) and one.kind == "outer"
    ] if cut_outs else []  # fmt: skip
    voids: dict[tuple[Face, int, int], list[tuple[Opening, Box]]] = {}
    for (_, one, box), area in zip(boxes, areas, strict=True):
        if type(one) is Contour:
            stays = any(face == one.face and _in(piece, box) for face, piece in pieces)
        else:
            stays = area < enough or one.kind != "through" or one.depth is not None
        left, low, right, high = box
        if stays or right - left > LARGEST or high - low > LARGEST:
            continue  # nothing is in it, or something of the wall, or it is in no sheet
        for x in range(floor(left / FAR), floor(right / FAR) + 1):
            for y in range(floor(low / FAR), floor(high / FAR) + 1):
                voids.setdefault((one.face, x, y), []).append((one, box))
    within, regions = [], dict[int, Any]()  # by identity: in a crowd each is asked for often
    for k, one, box in boxes:
        middle = floor((box[0] + box[2]) / 2 / FAR), floor((box[1] + box[3]) / 2 / FAR)
        for other, around in voids.get((one.face, *middle), ()):
            if other is not one and k >= 0 and _in(box, around) and _goes_with(one, other, regions):
                within.append(k)
    return frozenset(within)


def _is_opening(one: Any) -> bool:
    if type(one) is Contour:
        return one.kind == "inner" and one.process == "cut" and one.closed
    return type(one) in ROUND and one.kind in KINDS


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


def _goes_with(one: Opening, other: Opening, regions: dict[int, Any]) -> bool:
    """Whether an opening is smaller than another one and lies in it.

    Round and slotted ones are convex: the one lies in the other if in no direction it reaches
    farther, from middle to middle and square to the other's sides among them.
    """
    if isinstance(one, Contour) or isinstance(other, Contour):
        for each in (one, other):
            if id(each) not in regions:
                regions[id(each)] = _region(each)
        small, large = regions[id(one)], regions[id(other)]
        less = bool(small.area + LESS <= large.area)
        return less and bool(small.difference(large.buffer(OFF)).is_empty)
    if _area_of(one) + LESS > _area_of(other):
        return False
    turn = radians(other.angle) if isinstance(other, Slot) else 0.0
    ways = [turn + k * 2 * pi / WAYS for k in range(WAYS)]
    ways.append(atan2(one.y - other.y, one.x - other.x))
    return all(_reach(one, way) <= _reach(other, way) + OFF for way in ways)


def _area_of(one: Opening) -> float:
    """mm2 of a hole or slot; of a cut-out 0, as it is measured only where another is near."""
    if isinstance(one, Hole):
        return pi * (one.diameter / 2) ** 2
    if isinstance(one, Contour):
        return 0.0
    r = one.diameter / 2
    return pi * r**2 + one.diameter * (one.length + one.height) + one.length * one.height


def _region(one: Opening) -> Any:
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
