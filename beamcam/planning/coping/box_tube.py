"""The unrolled surface of a rectangular tube: what stays of its faces, and of its round corners.

      y h|  v  |             A contour counts as it is seen square to its face. Over a corner a line
     ____|_____|_            goes on in the views of both faces: x = v(Y) + o(Z) - x where both
    /    .     .  corner     meet at the sharp edge, which is exact for a plane and for whatever
         .  o  .             is drawn straight in one of the views.

An end that is a plane is skew through the wall. It is cut square to the surface where the wall
reaches farthest, so that no steel is missing; the rest is manual work.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import pi, radians, sin, tan
from typing import Any, Literal

import numpy as np
from msgspec import Struct

from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Point
from beamcam.model.part import Contour, Face, Part
from beamcam.model.section import corners
from beamcam.model.surface import Around, Leg
from beamcam.planning import rules as bar_rules
from beamcam.planning.coping import rules
from beamcam.planning.coping.regions import (
    CHORD,
    Cut,
    Shape,
    curves_of,
    outline_on,
    shape_of,
    sharp_corners,
)
from beamcam.planning.coping.tube_ends import (
    OVERLAP,
    SKEW_DEG,
    Plane,
    header_slopes,
    planes_of,
    within,
)
from beamcam.planning.coping.walls import Wall

LEVELS = 33  #: places across a corner; a line that bends by its radius is 0.005 mm off its chords
EDGE = 1e-6  #: mm inside of an edge, where a face is cut across
MEET = 1.0  #: mm that lines of two faces may be apart at their edge and mean the same place
FACES: tuple[Face, ...] = ("u", "v", "o", "h")  #: on the way round


class Unrolled(Struct, frozen=True):
    """What stays of the surface, on one turn from the corner before u on."""

    shape: Shape
    corners: tuple[Point, ...]  #: re-entrant and sharp
    slant: Mapping[Face, float]  #: mm that a square cut is off at the inside of each wall


class _Face(Struct, frozen=True):
    """A face of the tube as it is drawn."""

    leg: Leg
    size: float
    shape: Shape
    drawn: bool

    def crossings(self, offs: Any, from_high: bool) -> list[Floats]:
        """x where lines of the face are, at each distance from one of its edges; along the part."""
        from shapely import bounds, get_parts, intersection, length, linestrings

        if self.shape.is_empty:
            return [np.array([])] * len(offs)
        offs = np.clip(offs, EDGE, self.size - EDGE)
        ys = self.size - offs if from_high else offs
        x0, _, x1, _ = self.shape.bounds
        xs = np.tile((x0 - 1.0, x1 + 1.0), (len(ys), 1))
        across = linestrings(np.stack((xs, np.repeat(ys[:, None], 2, axis=1)), axis=2))
        pieces, of = get_parts(intersection(across, self.shape), return_index=True)
        met = length(pieces) > 0.0
        ends, of = bounds(pieces[met])[:, (0, 2)], of[met]
        return [np.sort(ends[of == k].ravel()) for k in range(len(ys))]


def unrolled(part: Part, features: Sequence[int], way: Around) -> tuple[Unrolled, list[Diagnostic]]:
    """What stays of a rectangular tube, and what is wrong with its contours."""
    from shapely import box, transform, union_all

    own = [f for f in map(part.features.__getitem__, features) if isinstance(f, Cut)]
    faces = {face: _face(part, face, own, way.on_face(face)) for face in FACES}
    said: list[Diagnostic] = [d for side in (-1, 1) for d in _denied(part, faces, side)]
    ends = [_end(part, faces, side) for side in (-1, 1)]
    planes = [*filter(None, ends), *planes_of(part, features)]
    slant = {
        face: max((plane.slant(one.leg.patch.outward, part.profile.thickness(face))
                   for plane in planes), default=0.0)
        for face, one in faces.items()
    }  # fmt: skip
    found: list[Point] = []
    for face, one in faces.items():
        shape = _beyond_ends(one, part, ends)
        for feature in own:
            if feature.face != face:
                continue
            if isinstance(feature, Contour):
                low, high = one.leg.patch.low - CHORD, one.leg.patch.high + CHORD
                turns = sharp_corners(feature)
                found += [(x, one.leg.s(y)) for x, y in turns if low <= y <= high]
                if feature.kind == "outer":
                    continue
            gone = shape_of(curves_of(feature))
            if not gone.intersects(shape):
                said.append(rules.OFF.at(feature.source, what=f"a hole or cut-out of face {face}"))
            shape = shape.difference(gone)
        faces[face] = _Face(one.leg, one.size, shape, one.drawn)
        r, wall = way.legs[1].patch.radius, part.profile.thickness(face)
        reaches = [into for high in (True, False) for _, into in _ending(faces[face], high, r)[1]]
        if reaches:
            into = max(reaches)
            source = next(f.source for f in own if f.face == face)
            said.append(rules.REACHES.at(source, face=face, into=f"{into:.2f}",
                                         found=f"{wall * into / r:.2f}"))  # fmt: skip
    shapes = []
    for one in faces.values():
        leg, (x0, _, x1, _) = one.leg, one.shape.bounds
        flat = one.shape.intersection(
            box(x0, leg.patch.low - OVERLAP, x1, leg.patch.high + OVERLAP)
        )

        def on_leg(places: Floats, leg: Leg = leg) -> Floats:
            return np.column_stack([places[:, 0], [leg.s(y) for y in places[:, 1].tolist()]])

        shapes.append(transform(flat, on_leg))
    for corner in way.legs[1::2]:
        shape, left, more = _corner(part, faces, corner)
        said += more
        if shape is not None:
            shapes.append(shape)
        for face, off in left.items():
            slant[face] = max(slant[face], off)
    return Unrolled(within(union_all(shapes), planes, way), tuple(found), slant), said


def _face(part: Part, face: Face, own: Sequence[Cut], leg: Leg) -> _Face:
    """A face within its outlines; h is as v without one of its own, and the other way round."""
    from shapely import box, union_all

    size = part.profile.face_width(face)
    wall = Wall(face, size, 0.0, 0.0, size, ())
    outer = [c for c in own if isinstance(c, Contour) and c.kind == "outer"]
    # DSTV, 7th edition, page 13: M has one contour of the web, that of v.
    other = {"v": "h", "h": "v"}.get(face, "")
    mine = [c for c in outer if c.face == face] or [c for c in outer if c.face == other]
    if not mine:
        return _Face(leg, size, box(0.0, 0.0, part.length, size), False)
    strip = box(-part.length, 0.0, 2 * part.length, size)
    shape = union_all([outline_on(wall, c.curves) for c in mine]).intersection(strip)
    return _Face(leg, size, shape, True)


# --- ends -----------------------------------------------------------------------------------------


def _lines(faces: Mapping[Face, _Face], side: int) -> dict[Face, tuple[Floats, Floats]]:
    """y and x along the end of each face that is drawn."""
    found: dict[Face, tuple[Floats, Floats]] = {}
    for face, one in faces.items():
        if one.drawn:
            ys = np.linspace(2 * CHORD, one.size - 2 * CHORD, 9)
            rows = one.crossings(ys, False)
            if all(len(row) for row in rows):
                found[face] = ys, np.array([row[0] if side < 0 else row[-1] for row in rows])
    return found


def _end(part: Part, faces: Mapping[Face, _Face], side: int) -> Plane | None:
    """The plane of an end; None where its faces are drawn square or as no plane has them."""
    by_y, by_z = header_slopes(part, side)
    lines = _lines(faces, side)
    if not lines:
        if not (by_y or by_z):
            return None
        reach = [by_y * y + by_z * z for y, z in corners(part.profile)]
        return Plane(side, max(reach) if side < 0 else part.length + min(reach), by_y, by_z)
    slopes = {face: (x[0] - x[-1]) / (y[-1] - y[0]) for face, (y, x) in lines.items()}
    by_y = by_y or next((slopes[f] for f in ("v", "h") if f in slopes), 0.0)
    by_z = by_z or next((slopes[f] for f in ("o", "u") if f in slopes), 0.0)
    if max(abs(by_y), abs(by_z)) <= tan(radians(SKEW_DEG)):
        return None
    plane, best = Plane(side, 0.0, by_y, by_z), (MEET, 0.0)
    for farthest in (True, False):  # outlines show where the wall reaches farthest, or the outside
        at = []
        for face, (ys, xs) in lines.items():
            outside, inside = _traces(plane, part, face, ys)
            far = np.maximum(outside, inside) if side > 0 else np.minimum(outside, inside)
            at.append(xs - (far if farthest else outside))
        every = np.concatenate(at)
        best = min(best, (float(np.ptp(every)), float(np.median(every))))
    return Plane(side, best[1], by_y, by_z) if best[0] < MEET else None


def _denied(part: Part, faces: Mapping[Face, _Face], side: int) -> Iterator[Diagnostic]:
    """An error where the header has an end skew and the outlines have it otherwise."""
    if any(header_slopes(part, side)) and _end(part, faces, side) is None:
        at: Literal["start", "end"] = "start" if side < 0 else "end"
        kind: Literal["web", "flange"] = "web" if header_slopes(part, side)[0] else "flange"
        angle = getattr(part.cuts, f"{kind}_{at}")
        yield bar_rules.CUT_DENIED.at(
            part.cut_source(kind, at), kind=kind, found=f"{angle:g}", end=at,
            expected="another line",
        )  # fmt: skip


def _traces(plane: Plane, part: Part, face: Face, ys: Any) -> tuple[Any, Any]:
    """x of a plane on the outside of a wall, and on its inside."""
    p = part.profile
    thick = p.thickness(face)
    if face in ("v", "h"):
        outside, inside = (p.width, p.width - thick) if face == "v" else (0.0, thick)
        return plane.x(ys, outside), plane.x(ys, inside)
    outside, inside = (p.height, p.height - thick) if face == "o" else (0.0, thick)
    return plane.x(outside, ys), plane.x(inside, ys)


def _beyond_ends(one: _Face, part: Part, ends: Sequence[Plane | None]) -> Shape:
    """A face that goes on beyond its ends where planes are to be cut."""
    from shapely import transform

    face: Face = one.leg.patch.name

    def moved(places: Floats) -> Floats:
        places = places.copy()
        for plane in ends:
            if plane is None:
                continue
            outside, inside = _traces(plane, part, face, places[:, 1])
            low, high = np.minimum(outside, inside), np.maximum(outside, inside)
            x = places[:, 0]
            near = (x >= low - MEET) & (x <= high + MEET)
            if not one.drawn:
                near = np.abs(x - (0.0 if plane.side < 0 else part.length)) < CHORD
            deep = part.profile.thickness(face) * (abs(plane.by_y) + abs(plane.by_z))
            places[near, 0] = (outside + plane.side * (deep + MEET))[near]
        return places

    return transform(one.shape, moved)


# --- corners --------------------------------------------------------------------------------------

#: The faces beside a corner, and whether it lies at the greatest y of each.
BESIDE: dict[str, tuple[tuple[Face, bool], tuple[Face, bool]]] = {
    "u-v": (("u", True), ("v", False)), "v-o": (("v", True), ("o", True)),
    "o-h": (("o", False), ("h", True)), "h-u": (("h", False), ("u", False)),
}  # fmt: skip


def _corner(
    part: Part, faces: Mapping[Face, _Face], corner: Leg
) -> tuple[Shape | None, dict[Face, float], list[Diagnostic]]:
    """What stays of a corner, how much a square cut is off inside of the walls beside it."""
    from shapely import Polygon, union_all

    (a, a_high), (b, b_high) = BESIDE[corner.patch.name]
    r, wall = corner.patch.radius, corner.patch.thickness
    turns = np.linspace(0.0, pi / 2, LEVELS)
    gone: list[Shape] = []
    faces = dict(faces)
    for face, high, at, way in (
        (a, a_high, corner.begin, 1),
        (b, b_high, corner.begin + r * pi / 2, -1),
    ):
        faces[face], ending = _ending(faces[face], high, r)
        gone += [_on_corner(void, faces[face].size, high, r, at, way) for void, _ in ending]
    of_a = faces[a].crossings(np.minimum(r * (1 - np.sin(turns)), r - EDGE), a_high)
    of_b = faces[b].crossings(np.minimum(r * (1 - np.cos(turns)), r - EDGE), b_high)
    source = next(
        (f.source for f in part.features if getattr(f, "face", "") in (a, b)), part.source
    )
    counts = {len(row) for row in (*of_a, *of_b)}
    if len(counts) > 1:
        return None, {}, [rules.CORNER.at(source, found="a line that ends in it", a=a, b=b)]
    if counts == {0}:
        return None, {}, []
    lines_a, lines_b = np.array(of_a), np.array(of_b)
    edge_a, edge_b = lines_a[-1], lines_b[0]
    share = np.linspace(0.0, 1.0, LEVELS)[:, None]
    lines = lines_a + lines_b - ((1 - share) * edge_b + share * edge_a)
    if (off := float(np.abs(edge_a - edge_b).max())) > MEET:
        found = f"lines {off:.3g} mm apart at its edge"
        return None, {}, [rules.CORNER.at(source, found=found, a=a, b=b)]
    ss = corner.begin + r * turns
    shapes = [
        Polygon(
            [*zip(lines[:, k], ss, strict=True), *zip(lines[::-1, k + 1], ss[::-1], strict=True)]
        )
        for k in range(0, lines.shape[1], 2)
    ]
    left = {}
    for face, other, high in ((b, a, a_high), (a, b, b_high)):
        # The inside of a wall lies in the view of the face beside it.
        (inside,) = faces[other].crossings((wall,), high)
        if len(inside) == lines.shape[1]:
            left[face] = float(np.abs(inside - (edge_a if other == a else edge_b)).max())
    return union_all(shapes).difference(union_all(gone)), left, []


def _ending(one: _Face, high: bool, r: float) -> tuple[_Face, list[tuple[Shape, float]]]:
    """A face without the cut-outs that end in a corner, and these, each with how far into it.

    A face sees the corner beside it up to its middle, where the other one begins.
    """
    from shapely import box, union_all

    if one.shape.is_empty:  # nothing of it stays
        return one, []
    x0, _, x1, _ = one.shape.bounds
    low, top = (one.size - r, one.size) if high else (0.0, r)
    within = box(x0 - 1.0, low, x1 + 1.0, top).difference(one.shape)
    found = []
    for void in getattr(within, "geoms", (within,)):
        _, y0, _, y1 = void.bounds if not void.is_empty else (0.0, 0.0, 0.0, one.size)
        into = y1 - low if high else top - y0
        if EDGE < into <= r * sin(pi / 4) and void.area > 0.0:
            found.append((void, into))
    if not found:
        return one, found
    filled = union_all([one.shape, *(void.buffer(OVERLAP) for void, _ in found)])
    filled = filled.intersection(box(x0, 0.0, x1, one.size))
    return _Face(one.leg, one.size, filled, one.drawn), found


def _on_corner(void: Shape, size: float, high: bool, r: float, at: float, way: int) -> Shape:
    """A cut-out that ends in a corner, seen square to its face, on the surface.

    `at` is where the corner begins for the face, from where the surface goes `way` into it.
    """
    from shapely import transform

    def laid(places: Floats) -> Floats:
        into = places[:, 1] - (size - r) if high else r - places[:, 1]
        turned = np.arcsin(np.clip(into / r, 0.0, 1.0))
        s = np.where(into <= EDGE, at - way * OVERLAP, at + way * r * turned)
        return np.column_stack((places[:, 0], s))

    return transform(void.segmentize(CHORD * 20), laid)
