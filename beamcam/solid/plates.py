"""The pieces that a program cuts from a sheet beside the pieces of its parts.

A piece lies in the table as its part is drawn, or in quarter turns of it, with the same face up; so
does one that is asked for mirrored. What may differ follows from the machine's file:

    tolerance   of the path, and how near ends belong together (`torch.tolerance`, `gap`, `corner`)
    step        the last decimal of a place, on both sides
    corners     an inner corner keeps the round of half a kerf
"""

from collections.abc import Iterable, Iterator, Sequence
from math import dist, hypot, pi
from typing import TYPE_CHECKING, Any, cast

from msgspec import Struct
from shapely import LineString, Polygon, polygonize, set_precision, union_all
from shapely.affinity import rotate, scale, translate

from beamcam.controllers import table_events
from beamcam.errors import BeamcamError, Diagnostic, Source
from beamcam.geometry.polylines import polylines
from beamcam.machine.torch import Torch, material_said
from beamcam.model.colour import process_of
from beamcam.model.part import Contour, Feature, Hole, Part, Process, Slot
from beamcam.model.request import Request
from beamcam.solid import NO_SOLID, PIECES
from beamcam.solid.compare import ALIKE, NOISE, Bodies, best_fit, differences, left_out
from beamcam.solid.cutters import taken
from beamcam.solid.kernel import CHORD, no_solid, prism
from beamcam.solid.sheet_solid import pieces_cut, rows_for, strokes_of
from beamcam.solid.stock_solid import AS_DRAWN, end_planes, shape_of

if TYPE_CHECKING:
    from manifold3d import Manifold

Shape = Any  #: of shapely

# --- plate pieces ---------------------------------------------------------------------------------

# The pieces of a plate or a drawing, as plane shapes that a torch has to cut.
#
# Closed contours enclose steel or cut-outs as their kinds say; what open ones enclose together is
# found as the faces of their lines. Holes that a torch does not make are left, and told.


FINEST = 1e-5  #: mm between a curve and its chords, where a width is the least but for chords
SKIPS = ("tool", "slot", "countersink", "sink-depth", "thread-depth")  #: kinds of holes not made


class Plate(Struct, frozen=True):
    """A part's pieces in (x, y), and what of it a torch leaves."""

    part: Part
    thickness: float
    pieces: tuple[Shape, ...]
    slits: Shape  #: lines that are cut and enclose nothing
    left: tuple[tuple[Feature, Shape], ...]  #: holes for the drill


def thickness_of(part: Part, torch: Torch) -> float:
    """Of the part's sheet, or the machine's where the part does not say. Raises BeamcamError."""
    thickness = part.profile.web_thickness or torch.thickness or 0.0
    if not thickness > 0.0:
        raise no_solid(part, "a sheet without a thickness")
    return thickness


def plate_of(part: Part, torch: Torch, skips: tuple[str, ...]) -> Plate:
    """The pieces of a part as a torch cuts them, mirrored where it is asked to."""
    thickness = thickness_of(part, torch)
    rows = rows_for(torch, thickness, material_said(part.grade, torch.material))
    torch = torch.by(next((row for row in rows if row.process == "cut"), None))
    may_leave = torch.drilled != "refuse" or "all" in skips or not {*SKIPS}.isdisjoint(skips)
    least = max(torch.min_hole, torch.min_hole_share * thickness)
    left: list[tuple[Feature, Shape]] = []
    whole, slits = _outlines(part, torch, least if may_leave else 0.0, left)
    for feature in part.features:
        if not isinstance(feature, Hole | Slot) or feature.kind == "mark":
            continue
        shape, width = taken(feature), feature.diameter
        if isinstance(feature, Slot):
            width += min(feature.length, feature.height)
        made = feature.kind == "through" and feature.depth is None and width >= least
        if made or not may_leave:
            whole = whole.difference(shape)
        elif not any(shape.within(other) for _, other in left):
            left.append((feature, shape.intersection(whole)))
    if torch.mirror != "none":
        fx, fy = (-1.0, 1.0) if torch.mirror == "x" else (1.0, -1.0)
        whole, slits = (scale(s, fx, fy, origin=(0.0, 0.0)) for s in (whole, slits))
        left = [(f, scale(s, fx, fy, origin=(0.0, 0.0))) for f, s in left]
    polygons = [p for p in getattr(whole, "geoms", (whole,)) if isinstance(p, Polygon)]
    return Plate(
        part, thickness, tuple(p for p in polygons if not p.is_empty),
        slits if slits is not None else union_all([]), tuple(left),
    )  # fmt: skip


def _outlines(
    part: Part, torch: Torch, least: float, left: list[tuple[Feature, Shape]]
) -> tuple[Shape, Shape]:
    """What a part's contours enclose, and its slits; round openings below `least` are `left`."""
    colours = cast("dict[str, Process]", torch.colours)
    cut = [
        c for c in part.contours if c.face in ("v", "h")
        and (c.process if c.layer is None and c.colour is None else process_of(c, colours)) == "cut"
    ]  # fmt: skip
    closed = [c for c in cut if c.closed and c.kind != "open"]
    shapes: list[tuple[Shape, str, Contour | None]] = [
        (shape_of(c.curves), c.kind, c) for c in closed
    ]
    opens = {
        k: LineString(polylines(c.curves, CHORD).points)
        for k, c in enumerate(cut)
        if c not in closed or shape_of(c.curves).area < CHORD
    }
    lines = [set_precision(line, max(torch.gap / 2, 1e-4)) for line in opens.values()]
    noded = union_all(lines)  # which enclose faces together, each filled
    faces = [Polygon(face.exterior) for face in polygonize(getattr(noded, "geoms", [noded])).geoms]
    slits = noded.difference(union_all([face.exterior for face in faces]).buffer(CHORD))
    drawn = part.measures is not None  # a drawing does not say which side of a contour is steel
    whole: Shape = Polygon()
    if not drawn and not any(kind == "outer" for _, kind, _ in shapes):
        ends = []  # its length and width between its end planes
        for (x, _, _), (side, up, _) in end_planes(part):
            edge = [(x - side * up * y, y) for y in (0.0, part.profile.height)]
            ends += edge if side < 0 else edge[::-1]
        whole = Polygon(ends)
    for face in faces:
        around = face.exterior.buffer(torch.gap + CHORD)
        shapes.append(
            (face, "outer", next((cut[k] for k in opens if opens[k].within(around)), None))
        )
    for shape, kind, contour in sorted(shapes, key=lambda s: -s[0].area):
        if contour is not None and _is_drilled(shape, contour, whole, least, left):
            if not any(shape.within(other) for _, other in left):
                left.append((contour, shape))
        elif kind == "outer" and not (drawn and whole.contains(shape.representative_point())):
            whole = whole.union(shape)
        else:
            whole = whole.difference(shape)
    return whole, slits


def _is_drilled(
    shape: Shape, contour: Contour, whole: Shape, least: float,
    left: Sequence[tuple[Feature, Shape]],
) -> bool:  # fmt: skip
    """Whether an opening, round or a slot, is smaller than the torch can cut.

    `contour` draws it, or a stretch of it. One as wide as the least, but for chords, is measured
    by its curves.
    """
    if shape.area < CHORD:  # a slit, which the torch follows
        return False
    width, long = _sides(shape)
    if abs(width - least) < 4 * CHORD and contour.closed:
        width, long = _sides(Polygon(polylines(contour.curves, FINEST).points))
    area = (long - width) * width + pi * width * width / 4
    is_round = abs(shape.area - area) < CHORD * shape.length
    middle = shape.representative_point()
    is_opening = whole.contains(middle) or any(hole.contains(middle) for _, hole in left)
    return is_round and width < least - 4 * FINEST and is_opening


def _sides(shape: Shape) -> tuple[float, float]:
    """The lesser and the greater side of the least rectangle around a shape."""
    corners = shape.minimum_rotated_rectangle.exterior.coords
    one, other = dist(corners[0], corners[1]), dist(corners[1], corners[2])
    return min(one, other), max(one, other)


SAME_AREA = 0.02  #: share by which the area of a piece may differ that was not asked for
QUARTERS = (0.0, 90.0, 180.0, 270.0)
UPRIGHT = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))


class Expected(Struct, frozen=True):
    """One piece of a part, with the least and the most steel that a sound program leaves of it."""

    plate: Plate
    drawn: Shape
    least: Shape
    most: Shape
    tolerance: float

    @property
    def bodies(self) -> Bodies:
        """As solids."""
        thick = self.plate.thickness
        drawn, least, most = (
            prism(shape, 0.0, thick, UPRIGHT) for shape in (self.drawn, self.least, self.most)
        )
        return Bodies(
            self.plate.part, drawn, least, most, AS_DRAWN, AS_DRAWN, 2 * self.tolerance,
            self.tolerance,
        )  # fmt: skip

    def holds(self, piece: Shape) -> bool:
        """Whether a piece that lies on it is within it, and it within the piece."""
        noise = NOISE / self.plate.thickness
        missing, extra = self.least.difference(piece), piece.difference(self.most)
        return all(
            one.area < noise
            for shape in (missing, extra)
            for one in getattr(shape, "geoms", [shape])
        )


def sheet_faults(text: str, parts: Sequence[Part], request: Request) -> list[Diagnostic]:
    """Where the pieces that a program frees differ from those of its parts."""
    machine, name = request.machine, request.name
    torch = machine.torch
    if torch is None or torch.tabs:
        found = (
            "parts that bridges hold in their sheet" if torch else f"{machine.name} without torch"
        )
        raise BeamcamError(NO_SOLID.at(Source(name), found=found))
    plates = {part: plate_of(part, torch, request.skips) for part in dict.fromkeys(parts)}
    first = plates[parts[0]]
    for plate in plates.values():
        if not plate.pieces:
            raise no_solid(plate.part, "cuts that enclose no piece")
    rows = rows_for(torch, first.thickness, material_said(first.part.grade, torch.material))
    kerf = next((row.kerf for row in rows if row.process == "cut"), None)
    if kerf is None:
        raise no_solid(first.part, f"no cut of {first.thickness:g} mm in the machine's chart")
    kerf = 0.0 if torch.kerf_by == "none" else kerf
    events, _ = table_events(text, machine, name)
    pieces = pieces_cut(strokes_of(events, machine, rows, name), kerf)
    copies = torch.copies[0] * torch.copies[1]
    tolerance = torch.tolerance + torch.gap + torch.corner + 2 * CHORD
    tolerance += hypot(machine.format.resolution, machine.format.resolution)
    pieces_of: dict[Part, list[Expected]] = {part: [] for part in plates}
    for part, plate in plates.items():
        for drawn in plate.pieces:
            least = drawn.buffer(-tolerance, join_style="mitre")
            least = least.difference(plate.slits.buffer(kerf / 2 + 2 * tolerance))
            most = drawn.buffer(kerf / 2 + tolerance, quad_segs=32)
            most = most.buffer(-kerf / 2, quad_segs=32)
            pieces_of[part].append(Expected(plate, drawn, least, most, tolerance))
    expected = [one for part in parts for one in pieces_of[part] * copies]
    return [
        *_compared(pieces, expected, torch.rotate, request),
        *(
            left_out(feature, shape.area * plates[part].thickness, part.mark or "the part")
            for part in parts for feature, shape in plates[part].left
        ),
    ]  # fmt: skip


def _compared(
    pieces: Sequence[Shape], expected: Sequence[Expected], turn: float, request: Request
) -> Iterator[Diagnostic]:
    """Each piece that is wanted beside the likeliest one that is free."""
    source = Source(request.name)
    free = {*range(len(pieces))}
    filled = [Polygon(one.exterior) for one in pieces]
    cut_out = {
        k for k, one in enumerate(pieces)
        if any(other.contains(one) for j, other in enumerate(filled) if j != k)
    }  # fmt: skip
    for number, one in enumerate(expected, 1):
        # How much two shapes differ, in mm of their outlines.
        area, long = one.drawn.area, one.drawn.length
        costs = sorted(
            (round(abs(pieces[k].area - area) / max(long, 1e-9)
                   + abs(pieces[k].length - long) / 4, 3), k) for k in free
        )  # fmt: skip
        if not costs:
            found = f"{len(pieces)} piece(s) that come free"
            yield PIECES.at(source, found=found, expected=f"{len(expected)}, and their cut-outs")
            return
        near = [k for cost, k in costs if cost <= costs[0][0] + ALIKE]
        near.sort(key=cut_out.__contains__)  # a cut-out may be as large as a part
        chosen = next((k for k in near if _lies(pieces[k], one, turn)), None)
        if chosen is None:
            chosen = near[0]
            yield from _differences(pieces[chosen], one, turn, f"piece {number}", source)
        free.remove(chosen)
    for k in sorted(free):
        if k not in cut_out:
            for one in dict.fromkeys(expected):
                alike = abs(pieces[k].area - one.drawn.area) <= SAME_AREA * one.drawn.area
                if alike and _lies(pieces[k], one, turn):
                    mark = one.plate.part.mark or "part"
                    yield PIECES.at(source, found=f"one more {mark}", expected="only those asked")
                    break


def _laid(piece: Shape, drawn: Shape, turn: float, mirrored: bool) -> Iterator[Shape]:
    """A piece in the axes of its part: in quarter turns, by the middles of the boxes."""
    if mirrored:
        piece = scale(piece, -1.0, 1.0, origin=(0.0, 0.0))
    for angle in QUARTERS:
        yield _onto(rotate(piece, angle - turn, origin=(0.0, 0.0)), drawn, 0.5)


def _onto(piece: Shape, drawn: Shape, share: float) -> Shape:
    """A piece moved so that its box has its middle, or a corner, where the drawn one's is."""
    a, b = piece.bounds, drawn.bounds
    dx, dy = ((b[k] - a[k]) * (1 - share) + (b[k + 2] - a[k + 2]) * share for k in (0, 1))
    return translate(piece, dx, dy)


def _lies(piece: Shape, one: Expected, turn: float) -> bool:
    return any(one.holds(laid) for laid in _laid(piece, one.drawn, turn, False))


def _differences(
    piece: Shape, one: Expected, turn: float, name: str, source: Source
) -> Iterator[Diagnostic]:
    bodies = one.bodies

    def ways(mirrored: bool) -> "Iterable[Manifold]":
        for laid in _laid(piece, one.drawn, turn, mirrored):
            for share in (0.5, 0.0, 1.0):
                moved = _onto(laid, one.drawn, share)
                yield prism(moved, 0.0, one.plate.thickness, UPRIGHT)

    best = best_fit(ways(False), bodies)
    if best is not None:
        yield from differences(best, ways(True), bodies, name, source)
