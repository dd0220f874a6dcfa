"""Parts as they have to lie on a sheet: mirrored, turned and copied as it was asked for.

    copy (k, n) of a point p of the part     M (p - m) + m + (k (w + s), n (h + s))

with m the middle of the part's box, M the mirror and then the turn, w and h the size of the box
around what comes out, s the spacing. Nothing is taken from the planner's layout.

A part by itself that is longer or wider than the sheet, and would not be if its length lay across,
lies so: M is a quarter turn, unless it was asked to lie in some way.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import atan2, cos, degrees, radians, sin

import numpy as np
import shapely
from msgspec.structs import replace
from shapely import Polygon
from shapely.affinity import translate

from beamcam.checks.sheets.region import box_of
from beamcam.geometry.curves import Curve
from beamcam.geometry.plane import groups_of
from beamcam.machine.torch import Torch
from beamcam.model.colour import key_of
from beamcam.model.part import Contour, Feature, Hole, Part, Slot, TextMark

Affine = tuple[tuple[float, float, float], tuple[float, float, float]]


def pulled_apart(part: Part, torch: Torch, width: float) -> Part:
    """A drawing for common cuts whose parts touch, each as far from the next as a cut is wide.

    A part lies at the right of another if they would overlap, were it moved to the left by a hair;
    above, if it were moved down. The moves are those of least sum that keep all these distances;
    of parts that touch along a slant, those of least squares with the first part where it is.
    """
    if not width or part.measures is None:
        return part
    rings: dict[int, shapely.Polygon] = {}
    for k, feature in enumerate(part.features):
        if not isinstance(feature, Contour) or feature.curves[-1].end != feature.curves[0].start:
            continue
        key = key_of(feature, torch.colours)
        if key is not None and torch.colours[key] == "cut":
            rings[k] = shapely.Polygon([c.point(n / 48) for c in feature.curves for n in range(48)])
    outer = {
        k: ring for k, ring in rings.items()
        if not any(o.contains(ring.representative_point()) and o.area > ring.area
                   for o in rings.values())
    }  # fmt: skip
    edges = [*_edges(outer)]
    moves = dict.fromkeys(outer, (0.0, 0.0))
    for group in groups_of((a, b) for a, b, _ in edges):
        own = [edge for edge in edges if edge[0] in group]
        is_slant = any(min(abs(x), abs(y)) > STRAIGHT for *_, (x, y) in own)
        places = _by_slants(sorted(group), own, width) if is_slant else _by_axes(own, width)
        if places is None:
            return part
        moves |= places
    features = list(part.features)
    for k, feature in enumerate(features):
        middle = None
        if isinstance(feature, Contour):
            middle = feature.curves[0].point(0.5)
        elif isinstance(feature, Hole | Slot):
            middle = feature.x, feature.y
        around = [k] if k in outer else [
            o for o, ring in outer.items()
            if middle is not None and ring.covers(shapely.Point(middle))
        ]  # fmt: skip
        for o in around[:1]:
            dx, dy = moves[o]
            features[k] = _moved(feature, ((1.0, 0.0, dx), (0.0, 1.0, dy)))
    return replace(part, features=tuple(features))


def copied(part: Part, torch: Torch) -> Part:
    x0, y0, x1, y1 = box_of(part.features) or (0.0, 0.0, part.length, part.profile.height)
    mx, my = (x0 + x1) / 2, (y0 + y1) / 2
    c, s = cos(radians(torch.rotate)), sin(radians(torch.rotate))
    if torch.rotate % 90 == 0:
        c, s = float(round(c)), float(round(s))
    sx, sy = -1.0 if torch.mirror == "x" else 1.0, -1.0 if torch.mirror == "y" else 1.0
    turn: Affine = (
        (c * sx, -s * sy, mx - c * sx * mx + s * sy * my),
        (s * sx, c * sy, my - s * sx * mx - c * sy * my),
    )
    once = [_moved(feature, turn) for feature in part.features]
    x0, y0, x1, y1 = box_of(once) or (0.0, 0.0, part.length, part.profile.height)
    columns, rows = torch.copies
    step_x, step_y = x1 - x0 + torch.spacing, y1 - y0 + torch.spacing
    every: list[Feature] = []
    for row in range(rows):
        for column in range(columns):
            shift: Affine = ((1.0, 0.0, column * step_x), (0.0, 1.0, row * step_y))
            every += [_moved(feature, shift) for feature in once]
    size = replace(part.profile, height=rows * step_y - torch.spacing)
    length = columns * step_x - torch.spacing
    return replace(part, features=tuple(every), profile=size, length=length)


def _moved(feature: Feature, by: Affine) -> Feature:
    (a, b, e), (c, d, f) = by
    if isinstance(feature, Contour):
        curves: list[Curve] = [curve.transformed(by) for curve in feature.curves]
        if a * d - b * c < 0.0:  # what was counter-clockwise would run the other way round
            curves = [curve.reversed() for curve in curves[::-1]]
        return replace(feature, curves=tuple(curves), notches=())
    if isinstance(feature, Hole | Slot | TextMark):
        x, y = a * feature.x + b * feature.y + e, c * feature.x + d * feature.y + f
        if isinstance(feature, Hole):
            return replace(feature, x=x, y=y)
        u, v = cos(radians(feature.angle)), sin(radians(feature.angle))
        return replace(feature, x=x, y=y, angle=degrees(atan2(c * u + d * v, a * u + b * v)))
    return feature


# --- edges ----------------------------------------------------------------------------------------

# Edges that parts of a drawing share, and how far the parts go apart across them.
#
# The edge of two parts is what of the one's outline lies on the other's. Each straight piece of it
# has a normal; the part that the other one enters if that is moved along it by a hair lies behind.


HAIR = 1e-3  #: mm
STRAIGHT = 1e-6  #: of a direction, by which two pieces are one

Normal = tuple[float, float]
Edge = tuple[int, int, Normal]  #: the part before it, the one behind it, and the way between


def _edges(rings: Mapping[int, Polygon]) -> Iterator[Edge]:
    for a, one in rings.items():
        for b, other in rings.items():
            for x, y in _normals(one, other) if a < b else ():
                for sign, before, behind in ((-HAIR, a, b), (HAIR, b, a)):
                    nearer = translate(other, sign * x, sign * y)
                    if shapely.intersection(one, nearer).area > HAIR * HAIR:
                        yield before, behind, (x, y)


def _by_axes(edges: Sequence[Edge], width: float) -> Mapping[int, Normal] | None:
    """The moves across upright and level edges; None if these contradict."""
    moves: dict[int, list[float]] = {k: [0.0, 0.0] for edge in edges for k in edge[:2]}
    for axis in (0, 1):
        pairs = [(a, b) for a, b, normal in edges if abs(normal[axis]) > 0.5]
        beside: dict[int, list[tuple[int, float]]] = {k: [] for pair in pairs for k in pair}
        for a, b in pairs:
            beside[a].append((b, width))
            beside[b].append((a, -width))
        left = list(beside)
        while left:
            # What touches by way of others moves together; none of it to the left, or down.
            places, waiting = {left[0]: 0.0}, [left[0]]
            for k in waiting:
                more = {other: places[k] + by for other, by in beside[k] if other not in places}
                places |= more
                waiting += more
            least = min(places.values())
            for k, at in places.items():
                moves[k][axis] = at - least
            left = [k for k in left if k not in places]
        if any(abs(moves[b][axis] - moves[a][axis] - width) > 1e-9 for a, b in pairs):
            return None
    return {k: (x, y) for k, (x, y) in moves.items()}


def _by_slants(
    parts: Sequence[int], edges: Sequence[Edge], width: float
) -> Mapping[int, Normal] | None:
    """The moves that part all edges by `width`, the first part resting; None if there are none."""
    rows = np.zeros((len(edges), 2 * len(parts)))
    for row, (before, behind, normal) in zip(rows, edges, strict=True):
        for k, sign in ((parts.index(before), -1.0), (parts.index(behind), 1.0)):
            row[2 * k : 2 * k + 2] += sign * np.array(normal)
    free = rows[:, 2:]
    moves = np.linalg.pinv(free) @ np.full(len(edges), width)
    if np.abs(free @ moves - width).max() > STRAIGHT * width:
        return None
    places = np.concatenate((np.zeros(2), moves)).reshape(-1, 2).tolist()
    return {k: (x, y) for k, (x, y) in zip(parts, places, strict=True)}


def _normals(one: Polygon, other: Polygon) -> Iterator[Normal]:
    """The normals of the straight pieces that two outlines share, each once.

    A curve that they share is many of them, which no moves can satisfy.
    """
    if one.distance(other) > HAIR / 10:
        return
    edge = shapely.intersection(one.boundary.buffer(HAIR / 10), other.boundary)
    lengths: dict[Normal, float] = {}
    for line in shapely.get_parts(edge):
        for x, y in np.diff(shapely.get_coordinates(line), axis=0).tolist():
            size = float(np.hypot(x, y))
            if size < HAIR / 100:
                continue
            normal = (-y / size, x / size)
            if normal[0] < -STRAIGHT or (abs(normal[0]) <= STRAIGHT and normal[1] < 0.0):
                normal = (-normal[0], -normal[1])
            same = next((n for n in lengths if np.hypot(n[0] - normal[0], n[1] - normal[1])
                         < 100 * STRAIGHT), normal)  # fmt: skip
            lengths[same] = lengths.get(same, 0.0) + size
    yield from (normal for normal, length in lengths.items() if length > 4 * HAIR)
