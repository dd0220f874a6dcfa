"""The round corners of a rectangular tube between the views of the two faces beside each.

Over a corner a line goes on in both views: x = a + b - x where both meet at the sharp edge. A
cut-out that ends in a corner, and a line that goes along the tube there, lie as their face sees
them.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from math import asin, pi, sin
from typing import Any

import numpy as np
from msgspec import Struct
from shapely import Polygon, box, get_coordinates, get_parts, get_rings, transform, union_all

from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Floats
from beamcam.model.part import Face, Part
from beamcam.model.surface import SurfacePatch
from beamcam.planning.coping import rules
from beamcam.planning.coping.regions import CHORD, Shape
from beamcam.planning.coping.tube_ends import OVERLAP

BESIDE_BEND = (-1e-5, 1e-5)  #: rad before and behind the place of a bend of a line
STEP = 2.0  #: mm along the tube from place to place; a line with more goes along it there
LEVELS = 33  #: places across a corner; a line that bends by its radius is 0.005 mm off its chords
EDGE = 1e-6  #: mm inside of an edge, where a face is cut across
THIN = 0.1  #: mm of the wall beside that a line along the tube may leave and mean its inside
MEET = 1.0  #: mm that lines of two faces may be apart at their edge and mean the same place


class BoxFace(Struct, frozen=True):
    """A face of the tube as it is drawn."""

    leg: SurfacePatch
    size: float
    shape: Shape
    drawn: bool

    def levels(self, from_high: bool, most: float) -> Floats:
        """How far places at which its lines bend are off one of its edges, `most` at most."""
        ys = get_coordinates(self.shape)[:, 1]
        offs = np.unique(np.round(self.size - ys if from_high else ys, 6))
        return offs[(offs > CHORD) & (offs < most - CHORD)]

    def crossings(self, offs: Any, from_high: bool) -> list[Floats]:
        """x where lines of the face are, at each distance from one of its edges; along the part."""
        offs = np.clip(offs, EDGE, self.size - EDGE)
        ys = self.size - offs if from_high else offs
        rings = get_rings(get_parts(self.shape))
        places, ring = get_coordinates(rings, return_index=True)
        sides = np.flatnonzero(ring[1:] == ring[:-1])
        (x0, y0), (x1, y1) = places[sides].T, places[sides + 1].T
        level, side = np.nonzero((y0 <= ys[:, None]) != (y1 <= ys[:, None]))
        share = (ys[level] - y0[side]) / (y1 - y0)[side]
        xs = x0[side] + share * (x1 - x0)[side]
        order = np.lexsort((xs, level))
        pieces, of = xs[order].reshape(-1, 2), level[order][::2]
        met = pieces[:, 0] < pieces[:, 1]
        found, ends = pieces[met].ravel(), 2 * np.searchsorted(of[met], np.arange(len(ys) + 1))
        return [found[begin:end] for begin, end in pairwise(ends.tolist())]


#: The faces beside a corner, and whether it lies at the greatest y of each.
BESIDE: dict[str, tuple[tuple[Face, bool], tuple[Face, bool]]] = {
    "u-v": (("u", True), ("v", False)), "v-o": (("v", True), ("o", True)),
    "o-h": (("o", False), ("h", True)), "h-u": (("h", False), ("u", False)),
}  # fmt: skip


def corner_of(
    part: Part, faces: Mapping[Face, BoxFace], corner: SurfacePatch
) -> tuple[Shape | None, dict[Face, float], list[Diagnostic]]:
    """What stays of a corner, how much a square cut is off inside of the walls beside it."""
    (a, a_high), (b, b_high) = BESIDE[corner.patch.name]
    r, wall = corner.patch.radius, corner.patch.thickness
    gone: list[Shape] = []
    faces = dict(faces)
    for face, high, at, way in (
        (a, a_high, corner.begin, 1),
        (b, b_high, corner.begin + r * pi / 2, -1),
    ):
        faces[face], ending = ending_in(faces[face], high, r)
        gone += [_oncorner_of(void, faces[face].size, high, r, at, way) for void, _ in ending]
    source = next(
        (f.source for f in part.features if getattr(f, "face", "") in (a, b)), part.source
    )
    over = _lines_over((faces[a], a_high), (faces[b], b_high), r, wall)
    if isinstance(over, str):
        return None, {}, [rules.CORNER.at(source, found=over, a=a, b=b)]
    turns, lines, leaning, reaches = over
    reached = [
        rules.REACHES.at(source, face=face, into=f"{into:.2f}",
                         found=f"{r * (asin(into / (r - wall)) - asin(into / r)):.2f}")
        for face, into in zip((a, b), reaches, strict=True) if into
    ]  # fmt: skip
    ss = corner.begin + r * turns
    sides = [np.column_stack((line, ss)) for line in lines.T]
    shapes = [
        Polygon(np.concatenate((low, high[::-1])))
        for low, high in zip(sides[::2], sides[1::2], strict=True)
    ]
    left = dict(zip((b, a), leaning, strict=True))
    return union_all(shapes).difference(union_all(gone)), left, reached


def _lines_over(
    a: tuple[BoxFace, bool], b: tuple[BoxFace, bool], r: float, wall: float
) -> tuple[Floats, Floats, list[float], list[float]] | str:
    """The lines that go on over a corner: its turns and by them x of each line, how far those of
    the first face and of the second lean within the wall beside, and how far into the corner one
    goes along the tube; or what is wrong.

    A line that goes along the tube in the view of a face, as the edge of a cope does, has both its
    ends at one turn, and lies where the wall reaches farthest.
    """
    faces, highs = (a[0], b[0]), (a[1], b[1])
    offs = [face.levels(high, r) for face, high in zip(faces, highs, strict=True)]
    bends: list[float] = []
    for deep in (r, r - wall):
        of_a, of_b = ((r - off[r - off <= deep]) / (deep or 1.0) for off in offs)
        bends += [*np.arcsin(of_a).tolist(), *np.arccos(of_b).tolist()]
    places = [(turn, turn) for turn in np.linspace(0.0, pi / 2, LEVELS).tolist()]
    places += [(turn + by, turn) for turn in bends for by in BESIDE_BEND]
    turns, at = np.array(sorted(places)).T.round(9)
    radii = np.repeat((r, r - wall), len(turns))  # outside of the wall, and inside
    # The inside of a wall lies in the view of the face beside it.
    views = (np.append(np.minimum(r - radii * np.tile(way(turns), 2), r - EDGE), wall)
             for way in (np.sin, np.cos))  # fmt: skip
    rows = [f.crossings(view, high) for f, view, high in zip(faces, views, highs, strict=True)]
    throughs = [of_one.pop() for of_one in rows]
    if len({len(row) for of_one in rows for row in of_one}) > 1:
        return "a line that ends in it"
    (out_a, in_a), (out_b, in_b) = (np.split(np.array(of_one), 2) for of_one in rows)
    if (apart := float(np.abs(out_a[-1] - out_b[0]).max(initial=0.0))) > MEET:
        return f"lines {apart:.3g} mm apart at its edge"
    share = (turns / (pi / 2))[:, None]
    edge = (1 - share) * out_b[0] + share * out_a[-1]
    lines, deepest = out_a + out_b - edge, in_a + in_b - edge
    jumps = [(np.abs(np.diff(one, axis=0)) > STEP).any(axis=0) for one in (out_a, out_b)]
    if any(jump.any() and (off < wall - THIN).any() for jump, off in zip(jumps, offs, strict=True)):
        return "a line along the tube nearer to its edge than the inside of the wall"
    for k in np.flatnonzero(jumps[0] | jumps[1]).tolist():
        lines[:, k] = (np.maximum if k % 2 else np.minimum)(lines[:, k], deepest[:, k])
    leaning = []
    for through, edges, jump in zip(throughs, (out_a[-1], out_b[0]), jumps, strict=True):
        same = len(through) == len(edges)
        leaning.append(float(np.abs(through - edges)[~jump].max(initial=0.0)) if same else 0.0)
    reaches = [min(r - float(off.min()), r - wall) if jump.any() else 0.0
               for jump, off in zip(jumps, offs, strict=True)]  # fmt: skip
    return at, lines, leaning, reaches


def to_edges(shape: Shape, size: float, radius: float) -> Shape:
    """A face whose outline ends at the tangents of its corners, gone straight on to the edges."""
    if shape.geom_type != "Polygon" or shape.is_empty:
        return shape
    _, low, _, high = shape.bounds
    ring = [(x, y) for x, y in shape.exterior.coords[:-1]]
    for farthest, tangent, edge in ((low, radius, 0.0), (high, size - radius, size)):
        if abs(farthest - tangent) > MEET:
            continue
        there = [abs(y - tangent) <= MEET for _, y in ring]
        longer = list(ring)
        for k, (x, y) in enumerate(ring):
            for beside, before in ((k - 1, (k + 1) % len(ring)), ((k + 1) % len(ring), k - 1)):
                (xb, yb) = ring[before]
                if there[k] and there[beside] and not there[before]:
                    longer[k] = x + (x - xb) / (y - yb) * (edge - y), edge
        ring = longer
    return Polygon(ring, shape.interiors)


def on_surface(one: BoxFace, y: float, wall: float) -> Iterator[float]:
    """The s of a place of a face; on a corner beside it outside of the wall and inside."""
    low, high = one.leg.patch.low, one.leg.patch.high
    into, r = max(low - y, y - high), min(low, one.size - high)
    if into <= CHORD:
        yield one.leg.s(y)
        return
    for deep in (r, max(r - wall, into)):
        beyond = one.leg.way * r * asin(into / deep)
        yield one.leg.s(high) + beyond if y > high else one.leg.s(low) - beyond


def ending_in(one: BoxFace, high: bool, r: float) -> tuple[BoxFace, list[tuple[Shape, float]]]:
    """A face without the cut-outs that end in a corner, and these, each with how far into it.

    A face sees the corner beside it up to its middle, where the other one begins.
    """
    low, top, deepest = *((one.size - r, one.size) if high else (0.0, r)), r * sin(pi / 4)
    ys = get_coordinates(one.shape)[:, 1]
    intos = ys - low if high else top - ys
    if not ((intos > EDGE) & (intos <= deepest)).any():
        return one, []
    x0, _, x1, _ = one.shape.bounds
    within = box(x0 - 1.0, low, x1 + 1.0, top).difference(one.shape)
    found = []
    for void in getattr(within, "geoms", (within,)):
        _, y0, _, y1 = void.bounds if not void.is_empty else (0.0, 0.0, 0.0, one.size)
        into = y1 - low if high else top - y0
        if EDGE < into <= deepest and void.area > 0.0:
            found.append((void, into))
    if not found:
        return one, found
    filled = union_all([one.shape, *(void.buffer(OVERLAP) for void, _ in found)])
    filled = filled.intersection(box(x0, 0.0, x1, one.size))
    return BoxFace(one.leg, one.size, filled, one.drawn), found


def _oncorner_of(void: Shape, size: float, high: bool, r: float, at: float, way: int) -> Shape:
    """A cut-out that ends in a corner, seen square to its face, on the surface.

    `at` is where the corner begins for the face, from where the surface goes `way` into it.
    """

    def laid(places: Floats) -> Floats:
        into = places[:, 1] - (size - r) if high else r - places[:, 1]
        turned = np.arcsin(np.clip(into / r, 0.0, 1.0))
        s = np.where(into <= EDGE, at - way * OVERLAP, at + way * r * turned)
        return np.column_stack((places[:, 0], s))

    return transform(void.segmentize(CHORD * 20), laid)
