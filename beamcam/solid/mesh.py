"""Pieces as triangles, each with the line of the program that made it, for a picture in space."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct

from beamcam.controllers import cell_events
from beamcam.controllers.rotary import in_degrees
from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.solid.bar_solid import bar_pieces, lying, points_of, said_of_section, work_of
from beamcam.solid.coper_solid import burns_of, stock_of, taken_by
from beamcam.solid.copers import as_tube
from beamcam.solid.kernel import Frame, minus, prism
from beamcam.solid.sheet_solid import SweptStroke, left_of
from beamcam.solid.sheet_solid import taken_by as taken_of_sheet

if TYPE_CHECKING:
    from manifold3d import Manifold

AS_DRAWN: Frame = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))
ENDS = 1.0  #: mm off the ends of a bar; what comes nearer is a trim
STEEP = 0.5  #: share of a wall's height that the normal of a flat has at least


class Mesh(Struct, frozen=True):
    """A piece: n corners, m triangles counter-clockwise seen from outside."""

    points: Floats  #: (n, 3), mm
    triangles: Counts  #: (m, 3)
    lines: Counts  #: (m,) of the program; 0 is the stock's own surface


def bar_meshes(
    text: str, machine: Machine, parts: Sequence[Part], name: str, bar: float | None, chord: float
) -> list[Mesh]:
    """The pieces of a bar's program along x; the first part gives the section.

    Polygons of tools lie at most `chord` within their circles. Raises BeamcamError where the
    section has no solid.
    """
    events, _ = cell_events(text, machine, name)
    stock = lying(parts[0], said_of_section(events, machine))
    lines: dict[int, int] = {}
    work = work_of(events, machine, stock)
    pieces = bar_pieces(work, stock, machine, bar, points_of(machine, parts), chord, lines)
    return [_mesh(piece, lines) for piece in pieces]


def coper_meshes(text: str, machine: Machine, part: Part, name: str, chord: float) -> list[Mesh]:
    """The piece that a coper's program cuts out of its bar or tube, and no scrap; none if none
    comes free.

    It keeps within `chord` of what the jet leaves. Raises BeamcamError where there is no solid.
    """
    coper = machine.needed(machine.coper, "coper")
    part = as_tube(part, coper) if coper.turns == "bar" else part
    events, _ = cell_events(text, machine, name)
    turned = in_degrees(events, coper, part.profile.height)
    stock = stock_of(part, coper, None)
    taken = [
        (burn.line, taken_by(burn, coper, part).simplify(chord / 4).as_original())
        for burn in burns_of(turned, machine, coper, part, name)
    ]
    lines = {one.original_id(): line for line, one in taken}
    first, last = stock.bounding_box()[0], stock.bounding_box()[3]
    free = []
    for one in minus(stock, [body for _, body in taken]).decompose():
        low, high = one.bounding_box()[0], one.bounding_box()[3]
        is_parted = part.made is not None or (first + ENDS < low and high < last - ENDS)
        if is_parted and high - low > part.length / 2:  # else what falls out of it
            free.append(one)
    piece = max(free, key=lambda one: float(one.volume()), default=None)
    return [] if piece is None else [_mesh(piece.simplify(chord / 4), lines)]


def _mesh(body: "Manifold", lines: Mapping[int, int]) -> Mesh:
    mesh = body.to_mesh()
    runs = np.asarray(mesh.run_index, dtype=np.int64) // 3
    triangles = np.asarray(mesh.tri_verts, dtype=np.int64)
    made = np.zeros(len(triangles), dtype=np.int64)
    for k, original in enumerate(mesh.run_original_id):
        made[runs[k] : runs[k + 1]] = lines.get(int(original), 0)
    points: Floats = np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3]
    return Mesh(points, triangles, made)


def sheet_meshes(
    strokes: Sequence[SweptStroke], kerf: float, thickness: float, chord: float
) -> list[Mesh]:
    """The pieces that come free of a sheet in X and Y of the table, without what falls out of them.

    Outlines keep within `chord`.
    """
    from shapely import Polygon, STRtree, points

    cuts = [(s.moves[0].line, one) for s in strokes if s.process == "cut" and s.moves
            for one in taken_of_sheet(s, kerf)]  # fmt: skip
    free = left_of([one for _, one in cuts])
    whole = [Polygon(one.exterior) for one in free]
    pieces = [
        one
        for k, one in enumerate(free)
        if not any(j != k and _is_slug(one, free[j], whole[j]) for j in range(len(free)))
    ]
    tree = STRtree([one for _, one in cuts])
    line_of = np.array([line for line, _ in cuts], dtype=np.int64)
    meshes = []
    for piece in pieces:
        mesh = _mesh(prism(piece.simplify(chord), 0.0, thickness, AS_DRAWN), {})
        corners = mesh.points[mesh.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        walls = np.abs(normals[:, 2]) < STEEP * np.linalg.norm(normals, axis=1)
        middles = corners[walls].mean(axis=1)
        lines = np.zeros(len(mesh.triangles), dtype=np.int64)
        if len(middles):
            lines[walls] = line_of[tree.nearest(points(middles[:, :2]))]
        meshes.append(Mesh(mesh.points, mesh.triangles, lines))
    return meshes


def _is_slug(piece: Any, other: Any, whole: Any) -> bool:
    """Whether a piece falls out of a hole of another."""
    at = piece.representative_point()
    return bool(whole.contains(at) and not other.contains(at))
