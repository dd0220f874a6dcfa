"""What a program leaves of its bar or sheet, as a solid for the page: quantised triangles.

Each is marked with the line of the program that made it.

box      least corner and size of a piece: its points are shares of it, in 1/65535
points   how many corners the piece has, `triangles` how many triangles
wide     bytes of a number of a corner: 2, or 4 where there are more corners
data     x of all points, then y, then z, 16 bits each; then three numbers of points for each
         triangle. Each as the difference to the one before, all low bytes before all high ones,
         so that deflate makes them short; in base64
lines    runs of triangles that one line of the program made: line, how many; 0 is the stock
"""

import base64
import json
import zlib
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct

from beamcam.controllers import cell_events, table_events
from beamcam.controllers.events import HeadMove, Switch, in_degrees
from beamcam.errors import BeamcamError, Source
from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.machine import Machine
from beamcam.machine.tables import TABLE_CONTROLLERS
from beamcam.machine.torch import material_said
from beamcam.model.part import Part, Profile
from beamcam.pictures import ReadProgram
from beamcam.pictures.bar_made import BarMade
from beamcam.pictures.coper import part_of
from beamcam.pictures.table import TableMade
from beamcam.simulation.trace import runs
from beamcam.solid.bar_solid import bar_pieces, lying, points_of, said_of_section, work_of
from beamcam.solid.coper_solid import burns_of, stock_of, taken_by
from beamcam.solid.copers import as_tube
from beamcam.solid.kernel import Frame, facets, minus, prism
from beamcam.solid.plates import thickness_of
from beamcam.solid.sheet_solid import SweptStroke, left_of, rows_for, strokes_of
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
        # What falls out of a hole of another is none.
        for at in (one.representative_point(),)
        if not any(
            j != k and whole[j].contains(at) and not free[j].contains(at) for j in range(len(free))
        )
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


LIMIT = 280_000  #: characters of a page that a solid may take
#: How far a polygon lies within its circle, mm: from the finest on, until the page is small enough.
CHORDS = (0.05, 0.2, 0.6, 5.0)
GRID = 65535
CHARACTERS = 16  #: that a side of a hole takes, about
MAX_WORK = 20_000  #: moves and cuts that are machined as a solid, which takes its time


class Solids(Struct, frozen=True):
    """The pieces for the page, or why there are none."""

    pieces: tuple[dict[str, Any], ...]
    faces: str  #: that letters stand on
    chord: float = CHORDS[0]  #: of its circles
    without: str = ""  #: the reason


def solids_of(program: ReadProgram, made: BarMade | TableMade) -> Solids:
    """The pieces of a program as a solid. Circles have as many sides as there is room for."""
    faces = "vouh" if isinstance(made, BarMade) else "v"
    if program.machine.stock == "profile":
        faces = "v" if part_of(program).profile.code in ("RO", "B") else "vouh"
    without = _too_much(program, made)
    if without:
        return Solids((), faces, without=without)
    pieces: tuple[dict[str, Any], ...] = ()
    # Which chord is tried first: machining a solid again and again takes its time.
    bores = made.made.bores if isinstance(made, BarMade) else ()
    sides = (sum(facets(bore.diameter / 2, chord) for bore in bores) for chord in CHORDS)
    first = next((k for k, n in enumerate(sides) if n * CHARACTERS <= LIMIT), len(CHORDS) - 1)
    try:
        for chord in CHORDS[first:]:
            if isinstance(made, BarMade):
                solids = _bar(program, made, chord)
            else:
                solids = _torched(program, made, chord)
            pieces = tuple(_packed(*one) for one in solids)
            if len(json.dumps(pieces)) <= LIMIT:
                stock = "bar" if program.machine.stock == "profile" else "sheet"
                without = "" if pieces else f"nothing comes free of the {stock}"
                return Solids(pieces, faces, chord, without)
    except BeamcamError as error:
        return Solids((), faces, without="; ".join(d.message for d in error.diagnostics))
    size = len(json.dumps(pieces)) / 1000
    return Solids((), faces, without=f"it would take {size:.0f} kB; a page holds {LIMIT // 1000}")


def _too_much(program: ReadProgram, made: BarMade | TableMade) -> str:
    """Why a program is not machined as a solid; blank where it is."""
    if isinstance(made, BarMade):
        count = len(made.made.order)
    else:
        count = sum(last - first for first, last, process in made.strokes if process == "cut")
    if program.machine.stock == "sheet":
        torch = program.machine.torch
        if torch is None or not (
            torch.thickness or any(p.profile.web_thickness for p in program.parts)
        ):
            return "the thickness of the sheet is not known"
    return f"{count} cuts and moves are too many" if count > MAX_WORK else ""


def _bar(program: ReadProgram, made: BarMade, chord: float) -> Iterator[tuple[str, str, Mesh]]:
    """The pieces of a bar, each with its kind and its mark."""
    stock = Part("", made.profile, made.end, Source(program.name))
    meshes = bar_meshes(
        program.text, program.machine, program.parts or (stock,), program.name, made.drawn_end,
        chord,
    )  # fmt: skip
    known = made.pieces()
    middles = [sum(made.extent(piece)) / 2 for piece in known]
    for mesh in meshes:
        middle = (mesh.points[:, 0].min() + mesh.points[:, 0].max()) / 2
        piece = known[int(np.argmin([abs(m - middle) for m in middles]))]
        yield piece.kind, piece.mark, mesh


def _torched(
    program: ReadProgram, made: TableMade, chord: float
) -> Iterator[tuple[str, str, Mesh]]:
    """What a torch leaves of a sheet, a profile or a tube, each piece with its kind and a name."""
    if program.machine.stock == "profile":
        part = program.parts[0] if program.parts else part_of(program)
        for mesh in coper_meshes(program.text, program.machine, part, program.name, chord):
            yield "part", part.mark or "part", mesh
    else:
        for k, mesh in enumerate(_sheet(program, made, chord), 1):
            yield "part", f"piece {k}", mesh


def _sheet(program: ReadProgram, made: TableMade, chord: float) -> list[Mesh]:
    machine, torch = program.machine, program.machine.torch
    if torch is None:
        return []
    stock = Part("", Profile("B", "", 0.0, 0.0, 0.0, None), 0.0, Source(program.name))
    part = program.parts[0] if program.parts else stock
    thickness = thickness_of(part, torch)
    rows = rows_for(torch, thickness, material_said(part.grade, torch.material))
    kerf = next((row.kerf for row in rows if row.process == "cut"), 0.0)
    kerf = 0.0 if torch.kerf_by == "none" else kerf
    if machine.controller in TABLE_CONTROLLERS:
        return sheet_meshes(list(_strokes(made)), kerf, thickness, chord)
    events, _ = table_events(program.text, machine, program.name)
    return sheet_meshes(strokes_of(events, machine, rows, program.name), kerf, thickness, chord)


def _strokes(made: TableMade) -> Iterator[SweptStroke]:
    """The strokes of a table whose program has no events, by its trace."""
    trace = made.trace
    for first, last, process in made.strokes:
        places = trace.positions[first : last + 1, :2].tolist()
        moves = [
            HeadMove(int(trace.line[first + k]), False, (a[0], a[1]), (b[0], b[1]), 0.0)
            for k, (a, b) in enumerate(pairwise(places))
            if a != b
        ]
        yield SweptStroke(Switch(int(trace.line[first]), 0, {}), process, "on", 0.0, moves)


def _packed(kind: str, mark: str, mesh: Mesh) -> dict[str, Any]:
    low = mesh.points.min(axis=0)
    size = np.maximum(mesh.points.max(axis=0) - low, 1e-6)
    points = np.rint((mesh.points - low) / size * GRID).astype(np.int64)
    wide = 2 if len(points) <= GRID else 4
    data = b"".join(_differences(column, 2) for column in points.T)
    data += _differences(mesh.triangles.ravel(), wide)
    return {
        "kind": kind, "mark": mark, "box": [round(float(v), 3) for v in (*low, *size)],
        "points": len(points), "triangles": len(mesh.triangles), "wide": wide,
        "data": base64.b64encode(zlib.compress(data, 9)).decode("ascii"),
        "lines": [[int(mesh.lines[a]), b - a] for a, b in runs(mesh.lines)],
    }  # fmt: skip


def _differences(numbers: Counts, wide: int) -> bytes:
    """Differences of whole numbers in bytes of `wide` planes, the lowest first."""
    steps = np.diff(numbers, prepend=0) % 256**wide
    return b"".join((steps >> 8 * k & 255).astype(np.uint8).tobytes() for k in range(wide))
