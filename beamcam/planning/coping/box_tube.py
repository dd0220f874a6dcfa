"""The unrolled surface of a rectangular tube: what stays of its faces, and of its round corners.

      y h|  v  |             A contour counts as it is seen square to its face. Over a corner a line
     ____|_____|_            goes on in the views of both faces: x = v(Y) + o(Z) - x where both
    /    .     .  corner     meet at the sharp edge, which is exact for a plane and for whatever
         .  o  .             is drawn straight in one of the views.

An end that is a plane is skew through the wall. It is cut square to the surface where the wall
reaches farthest, so that no steel is missing; the rest is manual work.
"""

from collections.abc import Mapping, Sequence
from math import radians, tan
from typing import Any, TypeGuard

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from shapely import box, transform, union_all

from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Point
from beamcam.model.part import Contour, Face, Part
from beamcam.model.surface import Around, SurfacePatch
from beamcam.planning.coping import rules
from beamcam.planning.coping.box_corners import (
    MEET,
    BoxFace,
    corner_of,
    ending_in,
    on_surface,
    to_edges,
)
from beamcam.planning.coping.ends import SectionEnd, plane_at
from beamcam.planning.coping.regions import (
    CHORD,
    OUTLINE_NOISE,
    Cut,
    Shape,
    outline_on,
    sharp_corners,
    taken,
)
from beamcam.planning.coping.tube_ends import (
    OVERLAP,
    SKEW_DEG,
    denied,
    header_slopes,
    own_planes,
    within,
)
from beamcam.planning.coping.tube_pieces import BEYOND, EndLine, FaceEnds, beyond_ends, opened
from beamcam.planning.coping.walls import PlannedWall

FACES: tuple[Face, ...] = ("u", "v", "o", "h")  #: on the way round
PLACES = 65  #: across a face, where the end of a piece is looked at
SLOT = 5.0  #: mm that a slot from an end is deep, at least; less than that, the end is no plane


class Unrolled(Struct, frozen=True):
    """What stays of the surface, on one turn from the corner before u on."""

    shape: Shape
    corners: tuple[Point, ...]  #: re-entrant and sharp
    slant: Mapping[Face, float]  #: mm that a square cut is off at the inside of each wall


def unrolled(
    part: Part, features: Sequence[int], way: Around, there: Mapping[Face, FaceEnds] | None = None
) -> tuple[Unrolled, list[Diagnostic]]:
    """What stays of a rectangular tube, and what is wrong with its contours.

    `there` are the ends of a piece that comes cut, beyond which its faces go on.
    """
    own = [f for f in map(part.features.__getitem__, features) if isinstance(f, Cut)]
    diagnostics: list[Diagnostic] = []
    faces = {
        face: _face(part, face, own, way.on_face(face), diagnostics, there[face] if there else None)
        for face in FACES
    }
    ends = [_end(part, faces, side) for side in (-1, 1)]
    for side, plane in zip((-1, 1), ends, strict=True):
        if plane is None and any(slopes := header_slopes(part, side)):
            diagnostics.append(denied(part, (side, slopes[0])))
    planes = [*filter(None, ends), *own_planes(part, features)]
    slant = {
        face: max((part.profile.thickness(face) * abs(plane.by_y * y + plane.by_z * z)
                   for plane in planes), default=0.0)
        for face, one in faces.items() for y, z in (one.leg.patch.outward,)
    }  # fmt: skip
    points: list[Point] = []
    for face, one in faces.items():
        shape = _beyond_ends(one, part, ends)
        inner = [f for f in own if f.face == face and not _is_outline(f)]
        of_face = [*_outlines(face, own), *inner]
        points += [
            (x, s) for contour in of_face if isinstance(contour, Contour)
            for x, y in sharp_corners(contour) if CHORD < y < one.size - CHORD
            for s in on_surface(one, y, part.profile.thickness(face))
        ]  # fmt: skip
        for feature in inner:
            lines = there[face].lines if there else ()
            drawn = taken(feature)
            gone = opened(drawn, lines)
            if not gone.intersects(shape) or beyond_ends(drawn, lines)[0] >= 0.0:
                diagnostics.append(
                    rules.OFF.at(feature.source, what=f"a hole or cut-out of face {face}")
                )
            shape = shape.difference(gone)
        faces[face] = replace(one, shape=shape)
        r, wall = way.legs[1].patch.radius, part.profile.thickness(face)
        reaches = [into for high in (True, False) for _, into in ending_in(faces[face], high, r)[1]]
        if reaches:
            into = max(reaches)
            diagnostics.append(rules.REACHES.at(of_face[0].source, face=face, into=f"{into:.2f}",
                                         found=f"{wall * into / r:.2f}"))  # fmt: skip
    shapes = [_flat(one) for one in faces.values()]
    for corner in way.legs[1::2]:
        shape, left, more = corner_of(part, faces, corner)
        diagnostics += more
        if shape is not None:
            shapes.append(shape)
        for face, off in left.items():
            slant[face] = max(slant[face], off)
    return Unrolled(within(union_all(shapes), planes, way), tuple(points), slant), diagnostics


def _flat(one: BoxFace) -> Shape:
    """What of a face lies between its corners, on the surface."""
    leg, (x0, _, x1, _) = one.leg, one.shape.bounds
    flat = one.shape.intersection(box(x0, leg.patch.low - OVERLAP, x1, leg.patch.high + OVERLAP))

    def on_leg(places: Floats) -> Floats:
        return np.column_stack([places[:, 0], [leg.s(y) for y in places[:, 1].tolist()]])

    return transform(flat, on_leg)


def _face(
    part: Part, face: Face, own: Sequence[Cut], leg: SurfacePatch, diagnostics: list[Diagnostic],
    there: FaceEnds | None,
) -> BoxFace:  # fmt: skip
    """A face within its outlines; of a piece that comes cut it goes on beyond its ends."""
    size = part.profile.face_width(face)
    wall = PlannedWall(face, size, 0.0, 0.0, size, ())
    mine = _outlines(face, own)
    if there and there.is_drawn and any(c.face != face for c in mine):
        mine = []  # its own outline is there
    if not mine:
        beyond = BEYOND if there else 0.0
        return BoxFace(leg, size, box(-beyond, 0.0, part.length + beyond, size), False)
    strip = box(-part.length, 0.0, 2 * part.length, size)
    drawn = union_all([outline_on(wall, c.curves) for c in mine])
    shape = to_edges(drawn, size, part.profile.radius).intersection(strip)
    if shape.area > drawn.area + CHORD:
        diagnostics.append(rules.TANGENTS.at(mine[0].source, face=face))
    if there:
        if (far := beyond_ends(shape, there.lines)[1]) > OUTLINE_NOISE:
            diagnostics.append(rules.SHORT.at(mine[0].source, face=face, found=f"{far:.3g}"))
        shape = opened(shape, there.lines).intersection(strip)
    return BoxFace(leg, size, shape, True)


def _outlines(face: Face, own: Sequence[Cut]) -> list[Contour]:
    """The outlines of a face; h is as v without one of its own, and the other way round.

    DSTV, 7th edition, page 13: M has one contour of the web, that of v.
    """
    outer = [c for c in own if _is_outline(c)]
    other = {"v": "h", "h": "v"}.get(face, "")
    return [c for c in outer if c.face == face] or [c for c in outer if c.face == other]


def _is_outline(feature: Cut) -> TypeGuard[Contour]:
    return isinstance(feature, Contour) and feature.kind == "outer"


# --- ends -----------------------------------------------------------------------------------------


def face_ends(part: Part, features: Sequence[int], way: Around) -> dict[Face, FaceEnds]:
    """Where a piece that comes cut ends on each of its faces, by some of its features."""
    own = [f for f in map(part.features.__getitem__, features) if isinstance(f, Cut)]
    faces = {face: _face(part, face, own, way.on_face(face), [], None) for face in FACES}
    ends: dict[Face, FaceEnds] = {}
    for face, one in faces.items():
        ys = np.linspace(0.0, one.size, PLACES)
        lines = []
        for side in (-1, 1):
            plane = _end(part, faces, side)
            k = 0 if side < 0 else -1
            other = 0.0 if side < 0 else part.length
            drawn = np.array([row[k] if len(row) else other for row in one.crossings(ys, False)])
            rows = [drawn, drawn] if plane is None else [*_traces(plane, part, face, ys)]
            for own_plane in own_planes(part, features):
                if own_plane.side == side:
                    traces = _traces(own_plane, part, face, ys)
                    rows = [side * np.minimum(side * a, side * b)
                            for a, b in zip(rows, traces, strict=True)]  # fmt: skip
            far = -BEYOND if side < 0 else part.length + BEYOND
            surfaces = tuple(np.broadcast_to(row, ys.shape) for row in rows)
            lines.append(EndLine(side, ys, surfaces, far))
        ends[face] = FaceEnds(
            (lines[0], lines[1]), any(c.face == face for c in _outlines(face, own))
        )
    return ends


def _end(part: Part, faces: Mapping[Face, BoxFace], side: int) -> SectionEnd | None:
    """The plane of an end; None where its faces are drawn square or as no plane has them."""
    by_y, by_z = header_slopes(part, side)
    lines: dict[Face, tuple[Floats, Floats]] = {}  # y and x along each that is drawn
    for face, one in faces.items():
        ys = np.linspace(2 * CHORD, one.size - 2 * CHORD, 9)
        rows = one.crossings(ys, False) if one.drawn else []
        if rows and all(len(row) for row in rows):
            lines[face] = ys, np.array([row[0] if side < 0 else row[-1] for row in rows])
    if not lines:
        return plane_at(part, side, by_y, by_z) if by_y or by_z else None
    slopes = {face: (x[0] - x[-1]) / (y[-1] - y[0]) for face, (y, x) in lines.items()}
    by_y = by_y or next((slopes[f] for f in ("v", "h") if f in slopes), 0.0)
    by_z = by_z or next((slopes[f] for f in ("o", "u") if f in slopes), 0.0)
    if max(abs(by_y), abs(by_z)) <= tan(radians(SKEW_DEG)):
        return None
    plane, best = SectionEnd(side, 0.0, by_y, by_z), (MEET, 0.0)
    for farthest in (True, False):  # outlines show where the wall reaches farthest, or the outside
        at = []
        for face, (ys, xs) in lines.items():
            outside, inside = _traces(plane, part, face, ys)
            far = np.maximum(outside, inside) if side > 0 else np.minimum(outside, inside)
            off = xs - (far if farthest else outside)
            # A slot from the end leaves the plane between the edges of its face.
            at.append(off[side * off >= min(side * off[0], side * off[-1]) - SLOT])
        every = np.concatenate(at)
        best = min(best, (float(np.ptp(every)), float(np.median(every))))
    return SectionEnd(side, best[1], by_y, by_z) if best[0] < MEET else None


def _traces(plane: SectionEnd, part: Part, face: Face, ys: Any) -> tuple[Any, Any]:
    """x of a plane on the outside of a wall, and on its inside."""
    p = part.profile
    thick = p.thickness(face)
    if face in ("v", "h"):
        outside, inside = (p.width, p.width - thick) if face == "v" else (0.0, thick)
        return plane.x(ys, outside), plane.x(ys, inside)
    outside, inside = (p.height, p.height - thick) if face == "o" else (0.0, thick)
    return plane.x(outside, ys), plane.x(inside, ys)


def _beyond_ends(one: BoxFace, part: Part, ends: Sequence[SectionEnd | None]) -> Shape:
    """A face that goes on beyond its ends where planes are to be cut."""
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
