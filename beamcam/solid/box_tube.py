"""A rectangular tube as a torch leaves it that stands square to its surface.

farthest   what is drawn, seen square to the surface: of an end that is skew through a wall the
           place where the wall reaches farthest
corners    lines that lean on a face go on over the round of its corner; both faces beside it
           have them, and at x = a + b - edge they meet
"""

from collections.abc import Iterator
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from beamcam.geometry.array_types import Floats
from beamcam.model.part import Contour, Face, Hole, Part, Slot
from beamcam.solid.cutters import OUTLINE_NOISE, slot_shape
from beamcam.solid.kernel import CHORD, FREE, circle, minus
from beamcam.solid.stock_solid import Margins, Shape, end_planes, is_cut, shape_of, stock_solid
from beamcam.solid.wrapped import Skin, skin_of, unrolled, wrapped

if TYPE_CHECKING:
    from manifold3d import Manifold

FAR = 1e4  #: mm beyond a part
LEVELS = 33  #: places across a corner
#: The faces beside each corner on the way round, and whether it is at the greatest y of each.
CORNERS: tuple[tuple[Face, bool, Face, bool], ...] = (
    ("u", True, "v", False), ("v", True, "o", True), ("o", False, "h", True),
    ("h", False, "u", False),
)  # fmt: skip


def square_to_surface(
    least: "Manifold", most: "Manifold", part: Part, narrow: Margins
) -> "tuple[Manifold, Manifold]":
    """The least and the most steel of a part whose walls are cut square to their surface."""
    from shapely import box

    skin, wall = skin_of(part)
    shape = unrolled(most, skin, wall + FREE)
    slack = -narrow.end
    gone = []
    leaning = _leaning(part, skin) if part.profile.code == "M" else ()
    for first, last, steel, middle in leaning:
        band = box(middle[0], first, middle[1], last)
        grown = steel.buffer(slack, join_style="mitre").intersection(band)
        shape = shape.difference(band).union(grown)
        gone.append(band.difference(steel.buffer(-slack, join_style="mitre")))
    endless = replace(narrow, end=-FAR)
    most = wrapped(shape, skin, -FREE, wall + FREE) ^ stock_solid(part, endless)
    return minus(least, [wrapped(one, skin, -FREE, wall + FREE) for one in gone]), most


def skew_ends(part: Part) -> int:
    """How many ends are skew through a wall."""
    drawn = part.profile.code == "M"  # the outline of a round one is that of its surface
    return sum(bool(n[1] or n[2]) for _, n in end_planes(part, drawn=drawn))


def _leaning(part: Part, skin: Skin) -> Iterator[tuple[float, float, Shape, tuple[float, float]]]:
    """Corners with lines that lean on a face beside them: u from and to, the steel in (x, u) with a
    margin of u, and from which x to which it counts, as planes of ends are no lines of faces."""
    from shapely import Polygon, union_all

    r = skin.radius
    steel = {face: _steel(part, face) for face in ("u", "v", "o", "h")}
    turns = np.linspace(0.0, pi / 2, LEVELS)
    is_plane = [bool(n[1] or n[2]) for _, n in end_planes(part, drawn=True)]
    for k, (a, a_high, b, b_high) in enumerate(CORNERS):
        of_a = _lines(steel[a], part.profile.face_width(a), a_high, r * (1 - np.sin(turns)))
        of_b = _lines(steel[b], part.profile.face_width(b), b_high, r * (1 - np.cos(turns)))
        if of_a is None or of_b is None or of_a.shape != of_b.shape:
            continue
        inner = slice(1 if is_plane[0] else 0, -1 if is_plane[1] else None)
        bends = max(np.ptp(one[:, inner], axis=0).max(initial=0.0) for one in (of_a, of_b))
        if bends < CHORD:
            continue
        share = (turns / (pi / 2))[:, None]
        lines = of_a + of_b - ((1 - share) * of_b[0] + share * of_a[-1])
        free = lines[:, inner]
        low = float(free.min()) - OUTLINE_NOISE if is_plane[0] else -FAR
        high = float(free.max()) + OUTLINE_NOISE if is_plane[1] else FAR
        if is_plane[0]:
            lines[:, 0] = -FAR
        if is_plane[1]:
            lines[:, -1] = FAR
        first, last = skin.borders[1 + 2 * k], skin.borders[2 + 2 * k]
        us = first + r * turns
        us[0], us[-1] = first - FREE, last + FREE
        shapes = [
            Polygon([*zip(lines[:, j], us, strict=True),
                     *zip(lines[::-1, j + 1], us[::-1], strict=True)]).buffer(0)
            for j in range(0, lines.shape[1], 2)
        ]  # fmt: skip
        yield float(first), float(last), union_all(shapes), (low, high)


def _steel(part: Part, face: Face) -> Shape:
    """What is drawn of a face."""
    from shapely import Polygon, box, union_all

    own = [f for f in part.features if getattr(f, "face", "") == face]
    outer = [f for f in own if isinstance(f, Contour) and f.kind == "outer" and is_cut(f)]
    wide = part.profile.face_width(face)
    steel: Shape = box(0.0, 0.0, part.length, wide)
    if outer:
        strip = box(-FAR, 0.0, FAR, wide)
        steel = union_all([shape_of(f.curves) for f in outer]).intersection(strip)
    for f in own:
        if isinstance(f, Contour) and f.kind == "inner" and is_cut(f):
            steel = steel.difference(shape_of(f.curves))
        elif isinstance(f, Slot):
            steel = steel.difference(slot_shape(f))
        elif isinstance(f, Hole) and f.kind != "mark":
            steel = steel.difference(Polygon(circle(f.x, f.y, f.diameter / 2)))
    return steel


def _lines(steel: Shape, wide: float, at_high: bool, offs: Floats) -> Floats | None:
    """x of the lines of a face at places off its edge, along the part; None where one ends."""
    from shapely import LineString

    rows = []
    for off in np.clip(offs, CHORD / 2, wide - CHORD / 2):
        y = wide - off if at_high else off
        cut = steel.intersection(LineString([(-2 * FAR, y), (2 * FAR, y)]))
        pieces = [one for one in getattr(cut, "geoms", [cut]) if one.length > 0.0]
        rows.append(sorted(x for one in pieces for x in (one.bounds[0], one.bounds[2])))
    return np.array(rows) if rows[0] and len({len(row) for row in rows}) == 1 else None
