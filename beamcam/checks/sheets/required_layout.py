"""Parts as they have to lie on a sheet: mirrored, turned and copied as it was asked for.

    copy (k, n) of a point p of the part     M (p - m) + m + (k (w + s), n (h + s))

with m the middle of the part's box, M the mirror and then the turn, w and h the size of the box
around what comes out, s the spacing. Nothing is taken from the planner's layout.

A part by itself that is longer or wider than the sheet, and would not be if its length lay across,
lies so: M is a quarter turn, unless it was asked to lie in some way.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import atan2, cos, degrees, hypot, radians, sin, tan
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.chart_rows import rows_on
from beamcam.checks.sheets.skew_edges import with_skew_edges
from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Box, join_boxes
from beamcam.machine.torch import Torch
from beamcam.model.colour import key_of
from beamcam.model.hatch import hatched
from beamcam.model.part import PLATE_FACES, Contour, Feature, Hole, Part, Slot, TextMark, extent

if TYPE_CHECKING:
    from shapely import Polygon

Affine = tuple[tuple[float, float, float], tuple[float, float, float]]


def laid_out(
    parts: Sequence[Part], torch: Torch | None
) -> tuple[tuple[Part, ...], list[Diagnostic]]:
    """The parts as they have to lie, hatched; and errors for features that cannot.

    The lines of a hatch are what a program may follow; whether they fill their contours is looked
    at in `hatch`.
    """
    if torch is None:
        return tuple(parts), []
    diagnostics: list[Diagnostic] = []
    laid: list[Part] = []
    parts = [with_skew_edges(part, torch) for part in parts]
    if len(parts) == 1:
        parts = (pulled_apart(parts[0], torch),)
    torch = replace(torch, spacing=between(parts[0], torch)) if parts else torch
    if len(parts) == 1 and _lies_turned(parts[0], torch):
        torch = replace(torch, rotate=90.0)
    for part in parts:
        if torch.mirror != "none" or torch.rotate or torch.copies != (1, 1):
            whole = _outlined(part)
            diagnostics += _faults(whole, torch)
            part = whole if diagnostics else _copied(whole, torch)
        laid.append(hatched(part, torch) if torch.settings else part)
    return tuple(laid), diagnostics


def between(part: Part, torch: Torch) -> float:
    """The distance between two parts or copies: with common cuts what one cut takes."""
    return kerf_on(part, torch) if torch.common_cuts else torch.spacing


def kerf_on(part: Part, torch: Torch) -> float:
    """The width of a cut on the part's sheet, where it is kept off."""
    taken = [row.kerf for row in rows_on(part, torch) if row.process == "cut"]
    return taken[0] if taken and torch.kerf_by != "none" else 0.0


def pulled_apart(part: Part, torch: Torch) -> Part:
    """A drawing for common cuts whose parts touch, each as far from the next as a cut is wide.

    A part lies at the right of another if they would overlap, were it moved to the left by a hair;
    above, if it were moved down. The moves are those of least sum that keep all these distances;
    of parts that touch along a slant, those of least squares with the first part where it is.
    """
    import shapely

    width = between(part, torch)
    if not torch.common_cuts or not width or part.measures is None:
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
    moves: dict[int, list[float]] = {}
    for some, slants in touching(outer):
        mine = {k: outer[k] for k in some}
        places = by_slants(mine, width) if slants else _by_axes(mine, width)
        if places is None:
            return part
        moves |= places
    features = list(part.features)
    for k, feature in enumerate(features):
        middle = _somewhere(feature)
        around = [k] if k in outer else [
            o for o, ring in outer.items()
            if middle is not None and ring.covers(shapely.Point(middle))
        ]  # fmt: skip
        for o in around[:1]:
            dx, dy = moves[o]
            features[k] = _moved(feature, ((1.0, 0.0, dx), (0.0, 1.0, dy)))
    return replace(part, features=tuple(features))


def _by_axes(outer: "dict[int, Polygon]", width: float) -> dict[int, list[float]] | None:
    """The moves of parts that touch along upright and level edges; None if these contradict."""
    import shapely
    from shapely.affinity import translate

    moves = {k: [0.0, 0.0] for k in outer}
    for axis, hair in enumerate(((HAIR, 0.0), (0.0, HAIR))):
        behind = [
            (a, b) for a, one in outer.items() for b, other in outer.items()
            if a != b and one.distance(other) <= HAIR / 10
            and shapely.intersection(one, translate(other, -hair[0], -hair[1])).area > HAIR * HAIR
        ]  # fmt: skip
        beside: dict[int, list[tuple[int, float]]] = {k: [] for k in outer}
        for a, b in behind:
            beside[a].append((b, width))
            beside[b].append((a, -width))
        left = list(outer)
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
        if any(abs(moves[b][axis] - moves[a][axis] - width) > 1e-9 for a, b in behind):
            return None
    return moves


def _somewhere(feature: Feature) -> tuple[float, float] | None:
    if isinstance(feature, Contour):
        return feature.curves[0].point(0.5)
    return (feature.x, feature.y) if isinstance(feature, Hole | Slot) else None


def _lies_turned(part: Part, torch: Torch) -> bool:
    changed = torch.rotate or torch.mirror != "none" or torch.copies != (1, 1)
    where_drawn = torch.origin == "table" and torch.place != "corner"
    whole = _outlined(part)
    if changed or where_drawn or next(_faults(whole, torch), None) is not None:
        return False
    any_ignored = "ignore" in torch.colours.values()
    worked = [
        feature for feature in whole.features
        if not any_ignored or not isinstance(feature, Contour)
        or (key := key_of(feature, torch.colours)) is None or torch.colours[key] != "ignore"
    ]  # fmt: skip
    box = _box(worked)
    if box is None:
        return False
    long, high = box[2] - box[0], box[3] - box[1]

    def lies(along: float, across: float) -> bool:
        return along <= torch.length + torch.gap and across <= torch.width + torch.gap

    return lies(high, long) and not lies(long, high)


def _faults(part: Part, torch: Torch) -> Iterator[Diagnostic]:
    for feature in part.features:
        if isinstance(feature, Contour):
            what = "bevelled contour" if feature.bevels else ""
        elif isinstance(feature, TextMark) and torch.mirror == "none":
            continue
        else:
            what = "" if isinstance(feature, Hole | Slot) else type(feature).__name__.lower()
        if what:
            yield rules.LAID.at(getattr(feature, "source", part.source), found=what)


def _outlined(part: Part) -> Part:
    """The part with the rectangle of a plate that has no outer contour of its own."""
    for feature in part.features:
        if (
            isinstance(feature, Contour) and feature.kind == "outer"
            and feature.process == "cut" and feature.face in PLATE_FACES
        ):  # fmt: skip
            return part
    if part.measures is not None:
        return part
    sides = tuple(header_outline(part))
    return replace(part, features=(*part.features, Contour("v", "outer", sides, part.source)))


def header_outline(part: Part) -> list[Line]:
    """The outline of a plate by the header alone: at each end the angle between its edges in v."""
    low, high = [0.0, part.length], [0.0, part.length]  # x of both ends at y 0 and at the width
    for k, angle in enumerate((part.cuts.web_start, part.cuts.web_end)):
        shorter = part.profile.height * tan(radians(abs(angle)))
        shorter = -shorter if k else shorter
        side = low if (angle > 0.0) != bool(k) else high  # the other edge is the longest
        side[k] += shorter
    wide = part.profile.height
    corners = [(low[0], 0.0), (low[1], 0.0), (high[1], wide), (high[0], wide)]
    return [Line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]


def _copied(part: Part, torch: Torch) -> Part:
    x0, y0, x1, y1 = _box(part.features) or (0.0, 0.0, part.length, part.profile.height)
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
    x0, y0, x1, y1 = _box(once) or (0.0, 0.0, part.length, part.profile.height)
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


def _box(features: Sequence[Feature]) -> Box | None:
    """The box around the contours, holes and slots of a part; None if there are none."""
    boxes: list[Box] = []
    curves: list[Curve] = []
    for feature in features:
        if isinstance(feature, Contour):
            curves += feature.curves
        elif isinstance(feature, Hole | Slot):
            boxes.append(_hole_box(feature))
    drawn = extent(curves)
    return join_boxes(boxes if drawn is None else [drawn, *boxes])


def _hole_box(hole: Hole | Slot) -> Box:
    # A slot reaches as far as the diagonals between the centres of its corners, and the radius.
    r, x, y = hole.diameter / 2, hole.x, hole.y
    dx = dy = 0.0
    if isinstance(hole, Slot):
        half = hypot(hole.length, hole.height) / 2
        own = degrees(atan2(hole.height, hole.length))
        for angle in (hole.angle + own, hole.angle - own):
            dx = max(dx, abs(half * cos(radians(angle))))
            dy = max(dy, abs(half * sin(radians(angle))))
    return x - dx - r, y - dy - r, x + dx + r, y + dy + r


# --- touching -------------------------------------------------------------------------------------

# Parts of a drawing that touch: which of them do, and how far they go apart along slants.
#
# The edge of two parts is what of the one's outline lies on the other's. Each straight stretch of
# it has a normal; the part that the other one enters if that is moved along it by a hair lies
# behind.


HAIR = 1e-3  #: mm
STRAIGHT = 1e-6  #: of a direction, by which two stretches are one

Normal = tuple[float, float]


def touching(rings: "Mapping[int, Polygon]") -> Iterator[tuple[list[int], bool]]:
    """The parts that touch, directly or by others, and whether some do so along a slant."""
    group = {k: {k} for k in rings}
    slanting: set[int] = set()
    for a, one in rings.items():
        for b, other in rings.items():
            if a >= b or not (normals := list(_normals(one, other))):
                continue
            if any(min(abs(x), abs(y)) > STRAIGHT for x, y in normals):
                slanting.add(a)
            whole = group[a] | group[b]
            group |= dict.fromkeys(whole, whole)
    for k, some in group.items():
        if k == min(some):
            yield sorted(some), not slanting.isdisjoint(some)


def by_slants(rings: "Mapping[int, Polygon]", width: float) -> dict[int, list[float]] | None:
    """The moves that part all edges by `width`; None if there are none."""
    import shapely
    from shapely.affinity import translate

    at = {k: n for n, k in enumerate(rings)}
    asked: list[tuple[int, int, Normal]] = []
    for a, one in rings.items():
        for b, other in rings.items():
            for x, y in _normals(one, other) if a < b else ():
                nearer = translate(other, -HAIR * x, -HAIR * y)
                enters = shapely.intersection(one, nearer).area > HAIR * HAIR
                asked.append((a, b, (x, y)) if enters else (b, a, (x, y)))
    rows = np.zeros((len(asked), 2 * len(rings)))
    for row, (before, behind, normal) in zip(rows, asked, strict=True):
        row[2 * at[before] : 2 * at[before] + 2] -= normal
        row[2 * at[behind] : 2 * at[behind] + 2] += normal
    free = rows[:, 2:]  # the first part rests
    found = np.linalg.pinv(free) @ np.full(len(asked), width)
    if np.abs(free @ found - width).max() > STRAIGHT * width:
        return None
    places = np.concatenate((np.zeros(2), found)).reshape(-1, 2)
    return {k: places[n].tolist() for k, n in at.items()}


def _normals(one: "Polygon", other: "Polygon") -> Iterator[Normal]:
    """The normals of the straight stretches that two outlines share, each once.

    A curve that they share is many of them, which no moves can satisfy.
    """
    import shapely

    if one.distance(other) > HAIR / 10:
        return
    edge = shapely.intersection(one.boundary.buffer(HAIR / 10), other.boundary)
    lengths: dict[Normal, float] = {}
    for line in shapely.get_parts(edge):
        for x, y in _steps(shapely.get_coordinates(line).tolist()):
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


def _steps(points: Sequence[Sequence[float]]) -> Iterator[Normal]:
    for (x0, y0), (x1, y1) in pairwise(points):
        yield x1 - x0, y1 - y0
