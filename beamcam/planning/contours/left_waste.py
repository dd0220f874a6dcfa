"""What stays where there is no room for the kerf: between contours, in a slot, a neck, a corner.

____          ____      The beam is a disc of the kerf's width. Where it does not get in, what
    |  slot  |          is waste stays on the part; where the waste between two contours is
    |        |          narrower than it, the cut of the one enters the other.
    |________|
"""

from collections.abc import Iterator, Sequence
from math import dist, sqrt
from typing import Any

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Arc, Curve
from beamcam.geometry.plane import Point
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import Shape, outlines, waste_side, ways

#: What is left in a slot is no deeper than so many kerfs, or the slot is refused; and in a corner
#: that is sharp, where everybody knows that a round beam leaves something.
DEEPEST_SLOT = 1.0
DEEPEST_CORNER = 4.0

#: What is left is reported where it is deeper than so many kerfs: half of one in a corner of 60
#: degrees.
REPORTED = 0.55

#: A slot may be so much deeper than the corner between its walls where they meet the beam: what
#: curves are flattened by, and a share.
CORNER_SLACK = 0.05
CORNER_SHARE = 1.2

#: Chords that stand for contours and paths where they are measured, as a share of the tolerance.
FINE_SHARE = 0.1

#: mm between places of two outlines that are the same but for the last digits.
SAME_PLACE = 1e-6


class Left(Struct, frozen=True):
    """Waste that the beam does not reach, and so stays on the part."""

    place: Point
    width: float  #: of the way to it
    depth: float  #: the farthest of it from where the beam comes
    is_corner: bool  #: no more than any corner of that angle leaves
    is_cut_off: bool = False  #: the beam would have room, but does not get there


def left_in(
    shape: Shape,
    path: Shape,
    kerf: float,
    tolerance: float,
    others: Sequence[Sequence[Curve]] = (),
) -> list[Left]:
    """What the beam leaves of the waste beside a contour, the deepest first.

    `others` are the rings behind necks, on which the beam does not go.
    The waste that it reaches is all that a disc of the kerf's width covers whose middle is no
    nearer to the contour than half of that: the inside of the path grown by half a kerf for a
    hole, shrunk for an outline.
    """
    drawn = outlines([shape.curves, path.curves], tolerance * FINE_SHARE)
    # A ring that touches itself has lines beside its areas when it is made valid.
    contour, ring = (shapely.buffer(one, 0.0) for one in shapely.make_valid(drawn))
    side = kerf / 2 if shape.is_hole else -kerf / 2
    reached = shapely.buffer(ring, side, quad_segs=32)
    waste, rest = (contour, reached) if shape.is_hole else (reached, contour)
    pieces = shapely.get_parts(shapely.difference(waste, rest))
    pieces = pieces[shapely.area(pieces) > 0.0]  # points and lines in which both touch
    if not len(pieces):
        return []
    # The waste that the beam takes away, on the path's own side of the contour.
    #
    #   | ||\    The beam at o takes the tip of a thin wall's other side, too, by no more than the
    # o | || \   tolerance. What is left behind the wall is not near the beam by that.
    if shape.is_hole:
        taken = shapely.intersection(contour, reached)
    else:
        sheet = shapely.box(*shapely.bounds(ring)).buffer(1.0)
        taken = shapely.difference(sheet, shapely.union(contour, reached))
    parts = shapely.get_parts(taken)
    own = shapely.length(shapely.intersection(parts, shapely.boundary(ring))) > 0.0
    swept = shapely.multipolygons(parts[own])
    taken, middle, edge = (shapely.boundary(one) for one in (swept, ring, contour))
    beyond = shapely.buffer(shapely.multilinestrings(ways(others, tolerance)), kerf / 2)
    cut_off = shapely.intersects(pieces, beyond).tolist()
    places = [
        replace(left, is_cut_off=is_cut_off)
        for piece, is_cut_off in zip(pieces.tolist(), cut_off, strict=True)
        if (left := _left(piece, taken, middle, edge, kerf / 2, tolerance)) is not None
    ]
    return sorted(places, key=lambda left: -left.depth)


def _left(
    piece: Any, swept: Any, ring: Any, contour: Any, radius: float, tolerance: float
) -> Left | None:
    """What is left in one place; None if it is no more than curves are flattened by.

    `swept` is the edge of what the beam takes away, `ring` its path. The mouth of a piece is where
    it lies at what is taken away: what is behind it is as deep as it is far from there.
    """
    # The rings by themselves: of a polygon that is not quite valid nothing would be left.
    outline = shapely.segmentize(shapely.get_rings(piece), radius / 4)
    corners, number = shapely.get_coordinates(outline, return_index=True)
    ends = np.stack((corners[:-1], corners[1:]), axis=1)[number[1:] == number[:-1]]
    sides, middles = shapely.linestrings(ends), shapely.points(ends.mean(axis=1))
    mouth = shapely.multilinestrings(sides[shapely.dwithin(middles, swept, SAME_PLACE)])
    if mouth.is_empty:  # a neck that has no width
        entry = corners[int(np.argmin(shapely.distance(shapely.points(corners), swept)))]
        depth = float(np.hypot(*(corners - entry).T).max())
        return Left(tuple(entry.tolist()), 0.0, depth, False) if depth > tolerance else None
    away = shapely.distance(shapely.points(corners), mouth)
    depth = float(away.max())
    if depth <= tolerance:
        return None
    x, y = corners[int(np.argmax(away))].tolist()
    rest = shapely.multilinestrings(sides[~shapely.dwithin(middles, mouth, tolerance)])
    merged = shapely.get_parts(shapely.line_merge(rest)).tolist()
    walls = [wall for wall in merged if wall.length > radius / 4]
    if len(walls) > 1:  # a neck: the beam comes from both ends
        (a, b), (c, d) = shapely.get_coordinates(shapely.shortest_line(*walls[:2])).tolist()
        return Left(((a + c) / 2, (b + d) / 2), walls[0].distance(walls[1]), depth, False)
    # Its two places that are farthest apart.
    open_part = shapely.multipoints(_open_part(mouth, ring, contour, radius, tolerance))
    hull = shapely.get_coordinates(shapely.convex_hull(open_part))
    chords = np.hypot(*(hull[:, None] - hull[None]).transpose(2, 0, 1))
    (x0, y0), (x1, y1) = hull[[*np.unravel_index(int(np.argmax(chords)), chords.shape)]].tolist()
    width = dist((x0, y0), (x1, y1))
    from_middle = sqrt(max(radius * radius - width * width / 4, 0.0))
    in_corner = radius * radius / from_middle - radius if from_middle > 0.0 else depth
    if depth <= in_corner * CORNER_SHARE + CORNER_SLACK:
        return Left((x, y), width, depth, True)
    return Left(((x0 + x1) / 2, (y0 + y1) / 2), width, depth, False)


def _open_part(mouth: Any, ring: Any, contour: Any, radius: float, tolerance: float) -> Floats:
    """Points of a mouth without the slivers beside the contour that lead to it.

    Between a contour and the edge of what the beam takes away may be up to the tolerance, and so
    a piece has slivers that are longer than itself. They are not part of what the beam touches
    from the places where it stands before the mouth.
    """
    corners: Floats = shapely.get_coordinates(mouth)
    points = shapely.points(corners)
    clear = points[~shapely.dwithin(points, contour, tolerance)]
    if not len(clear):
        return corners
    stands = shapely.get_coordinates(shapely.shortest_line(clear, ring))[1::2]
    away = shapely.distance(points, shapely.multipoints(stands))
    touched: Floats = corners[away <= radius + tolerance * FINE_SHARE]
    return touched


def left_diagnostics(shape: Shape, left: Sequence[Left], kerf: float) -> Iterator[Diagnostic]:
    """An error for the deepest place that is refused, else a warning if there is one to give."""
    deepest = {True: DEEPEST_CORNER * kerf, False: DEEPEST_SLOT * kerf}
    refused = [one for one in left if one.is_cut_off or one.depth > deepest[one.is_corner]]
    reported = [one for one in left if one.depth > REPORTED * kerf]
    for first, *others in (which for which in (refused or reported,) if which):
        yield (rules.NARROW if refused else rules.LEFT).at(
            shape.source, found=f"{first.width:.3f}", depth=f"{first.depth:.3f}",
            kerf=f"{kerf:g}", more=f" and {len(others)} more" if others else "",
            **rules.at_place(first.place),
        )  # fmt: skip


def uncompensated(shape: Shape, kerf: float) -> Diagnostic:
    """The error for a contour with a curve that has no other one half a kerf beside it.

    That is one whose middle, moved so far into the waste, comes nearest to another place of the
    contour: an arc that is smaller than the tool, or a side between two corners.
    """
    side = waste_side(shape.area, shape.is_hole)
    contour = ways([shape.curves], kerf / 1000)[0]
    curves = [curve for curve in shape.curves if curve.length > 0.0]
    points = []
    for curve in curves:
        (x, y), (tx, ty) = curve.point(0.5), curve.tangent(0.5)
        points.append((x - side * ty * kerf / 2, y + side * tx * kerf / 2))
    k = int(np.argmin(shapely.distance(shapely.points(points), contour)))
    curve = curves[k]
    size = f"a side of {dist(curve.start, curve.end):.3f} mm"
    if isinstance(curve, Arc):
        size = f"an arc of radius {curve.radius:.3f} mm"
    place = rules.at_place(curve.point(0.5))
    return rules.UNCOMPENSATED.at(shape.source, found=size, kerf=f"{kerf:g}", **place)
