"""Parts as they have to lie on a sheet: mirrored, turned and copied as it was asked for; in rows.

    copy (k, n) of a point p of the part     M (p - m) + m + (k (w + s), n (h + s))

with m the middle of the part's box, M the mirror and then the turn, w and h the size of the box
around what comes out, s the spacing. Nothing is taken from the planner's layout.

A part by itself that is longer or wider than the sheet, and would not be if its length lay across,
lies so: M is a quarter turn, unless it was asked to lie in some way.

Where each of several lies follows from the parts in the order given and the machine's table alone:
in rows from the lower left corner, `margin` to the edges and `spacing` from box to box.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import atan2, cos, degrees, radians, sin

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace
from shapely import Polygon
from shapely.affinity import translate

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.asked_sheet import rows_on, thickness_of
from beamcam.checks.sheets.need import OUTLINE, Need, need_of
from beamcam.checks.sheets.plates import (
    beside_faults,
    header_outline,
    outlines_of,
    skew_ends,
    with_skew_edges,
)
from beamcam.checks.sheets.region import box_of
from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Box, Point, groups_of
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, material_said
from beamcam.model.colour import key_of
from beamcam.model.hatch import hatched
from beamcam.model.part import (
    Contour,
    Feature,
    Hole,
    Measures,
    Part,
    Slot,
    TextMark,
    extent,
    moved_feature,
)

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
    if len(parts) == 1 and torch.common_cuts:
        parts = (pulled_apart(parts[0], torch, kerf_on(parts[0], torch)),)
    torch = replace(torch, spacing=between(parts[0], torch)) if parts else torch
    if len(parts) == 1 and _lies_turned(parts[0], torch):
        torch = replace(torch, rotate=90.0)
    for part in parts:
        if torch.mirror != "none" or torch.rotate or torch.copies != (1, 1):
            whole = _outlined(part)
            diagnostics += _faults(whole, torch)
            part = whole if diagnostics else copied(whole, torch)
        laid.append(hatched(part, torch) if torch.settings else part)
    return tuple(laid), diagnostics


def between(part: Part, torch: Torch) -> float:
    """The distance between two parts or copies: with common cuts what one cut takes."""
    return kerf_on(part, torch) if torch.common_cuts else torch.spacing


def kerf_on(part: Part, torch: Torch) -> float:
    """The width of a cut on the part's sheet, where it is kept off."""
    taken = [row.kerf for row in rows_on(part, torch) if row.process == "cut"]
    return taken[0] if taken and torch.kerf_by != "none" else 0.0


def _lies_turned(part: Part, torch: Torch) -> bool:
    changed = torch.rotate or torch.mirror != "none" or torch.copies != (1, 1)
    if changed or (torch.origin == "table" and torch.place != "corner"):
        return False
    whole = _outlined(part)
    any_ignored = "ignore" in torch.colours.values()
    worked = [
        feature for feature in whole.features
        if not any_ignored or not isinstance(feature, Contour)
        or (key := key_of(feature, torch.colours)) is None or torch.colours[key] != "ignore"
    ]  # fmt: skip
    box = box_of(worked)
    if box is None:
        return False
    size, sheet = (box[2] - box[0], box[3] - box[1]), (torch.length, torch.width)
    lies, lies_across = (
        all(own <= most + torch.gap for own, most in zip(sides, sheet, strict=True))
        for sides in (size, size[::-1])
    )
    return lies_across and not lies and next(_faults(whole, torch), None) is None


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
    if part.measures is not None or outlines_of(part):
        return part
    sides = tuple(header_outline(part))
    return replace(part, features=(*part.features, Contour("v", "outer", sides, part.source)))


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


# --- several parts --------------------------------------------------------------------------------

# Parts that share a sheet, each at the place where the machine lays it, as one part to compare.


SKELETON = "skeleton"  #: where the cuts through what is left of a sheet are said to be


class SharedSheet(Struct, frozen=True):
    """One part with all that has to be on a sheet, and the machine that leaves it there."""

    part: Part
    machine: Machine
    places: list[Point]  #: of the x 0, y 0 of each of several parts
    diagnostics: list[Diagnostic]


def as_one(parts: Sequence[Part], machine: Machine, skips: Collection[str]) -> SharedSheet:
    """The parts of a sheet as one, and what is wrong with their sharing it.

    A part that is alone stays as it is.
    """
    torch = machine.torch
    off = [*skew_ends(parts, machine), *beside_faults(parts)]
    if torch is None or len(parts) == 1:
        return SharedSheet(parts[0], machine, [], off)
    features: list[Feature] = []
    sheet = _sheet_shown(parts[0], torch)
    diagnostics = off + [
        rules.OTHER_SHEET.at(part.source, found=own, expected=sheet)
        for part in parts[1:]
        if (own := _sheet_shown(part, torch)) != sheet
    ]
    tops: dict[float, float] = {}  #: upper edge of each row of parts, by its lower one
    lie = list(_places(parts, machine, torch, skips))
    for part, (here, need) in zip(parts, lie, strict=True):
        _, low, _, high = _box(need)
        row = round(here[1] + low, 6)
        tops[row] = max(tops.get(row, row), here[1] + high)
        features += [moved_feature(feature, here) for feature in part.features]
        if any(OUTLINE in some for some in need.features.values()):
            outline = Contour("v", "outer", tuple(header_outline(part)), part.source)
            features.append(moved_feature(outline, here))
    half = between(parts[0], torch) / 2
    if torch.skeleton_cuts and half > kerf_on(parts[0], torch):
        for y in (t + half for t in tops.values() if t + half < torch.width - torch.margin / 2):
            line = Line((torch.length, y), (0.0, y))
            source = replace(parts[0].source, where=SKELETON, line=None)
            features.append(Contour("v", "open", (line,), source, closed=False))
    whole = replace(parts[0], features=tuple(features), measures=Measures(), length=torch.length)
    machine = replace(machine, torch=replace(torch, place="drawn"))
    return SharedSheet(whole, machine, [place for place, _ in lie], diagnostics)


def _places(
    parts: Sequence[Part], machine: Machine, torch: Torch, skips: Collection[str]
) -> Iterator[tuple[Point, Need]]:
    """Where each of several parts lies on the table, its x 0, y 0; and what of it has to be cut."""
    left = bottom = torch.margin
    spacing = between(parts[0], torch)
    top = bottom
    needs: dict[int, Need] = {}  #: many are the same part
    for part in parts:
        if id(part) not in needs:
            needs[id(part)] = need_of(part, machine, torch, skips)
        need = needs[id(part)]
        x0, y0, x1, y1 = _box(need)
        if left + (x1 - x0) > torch.length - torch.margin and top > bottom:
            left, bottom = torch.margin, top + spacing
            top = bottom
        yield (left - x0, bottom - y0), need
        left, top = left + (x1 - x0) + spacing, max(top, bottom + (y1 - y0))


def _box(need: Need) -> Box:
    return extent(c for some in need.curves.values() for c in some) or (0.0, 0.0, 0.0, 0.0)


def _sheet_shown(part: Part, torch: Torch) -> str:
    material = material_said(part.grade, torch.material)
    return f"{thickness_of(part, torch):.2f} mm {material}".rstrip()
