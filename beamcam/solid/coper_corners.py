r"""The steel that re-entrant corners keep which a machine rounds.

What a disc, rolled through the air, does not reach at a re-entrant corner stays:

     steel |            between two straight sides with the angle a it ends r / tan(a / 2) from
     ______| r          the corner; what goes on farther is a notch that is too narrow, and is
    steel  (            no corner's: its corners have the largest radius with which all of their
                        sides are touched.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import atan2, degrees
from typing import TYPE_CHECKING

from msgspec import Struct
from shapely import MultiPoint, box, get_coordinates, union_all
from shapely import Point as Place

from beamcam.geometry.curves import signed_area
from beamcam.geometry.plane import Point
from beamcam.model.part import Contour, Face, Part
from beamcam.solid.cutters import taken, through_wall
from beamcam.solid.kernel import CHORD, FREE, Wall, facets, kernel, walls
from beamcam.solid.part_solid import part_solid
from beamcam.solid.stock_solid import Margins, Shape, is_cut, stock_solid
from beamcam.solid.wrapped import all_round, drawn_steel, outline_gone, skin_of, wrapped

if TYPE_CHECKING:
    from manifold3d import Manifold

CORNER_DEG = 20.0  #: what a corner turns more than
SLIVER = 0.01  #: radii; half of what may lie along a side that leans
CORNER_SLACK = 0.2  #: mm round what a corner on the round of a tube keeps
FACING_DEG = 125.0  #: by which two sides turn that face each other


def rounded_corners(
    part: Part, margins: Margins, radius: float
) -> "tuple[Manifold, list[tuple[str, Shape]], dict[tuple[str, float, float], float]]":
    """The steel that the re-entrant corners of contours keep, what they keep of each wall of a
    profile, by its face, and the radius of each."""
    m = kernel()
    kept: list[Manifold] = []
    rounds: list[tuple[str, Shape]] = []
    corners: dict[tuple[str, float, float], float] = {}
    if part.profile.code == "RO":
        skin, wall = skin_of(part)
        turn = skin.turn  # drawn on three turns
        gone = union_all([outline_gone(part), *(taken(f) for f in part.features)])
        steel = box(0.0, -turn, part.length, 2 * turn).difference(all_round(gone, turn))
        for (x, u), room, one in _rounds(steel, part.contours, radius):
            kept.append(wrapped(one, skin, -FREE, wall + FREE))
            corners["v", round(x, 2), round(u % turn, 2) % round(turn, 2)] = room
    sides = walls(part.profile)
    for face in ("v", "o", "u", "h") if part.profile.code != "RO" else ():
        if face in sides:
            own = [f for f in part.features if _wall_of(getattr(f, "face", ""), part) == face]
            steel = drawn_steel(own, part.length, sides[face].width)
            contours = [f for f in own if isinstance(f, Contour)]
            for (x, q), room, one in _rounds(steel, contours, radius):
                kept += _rounds_on(face, (x, q), one, room, sides[face], part)
                rounds.append((face, one))
                corners[face, x, q] = room
    whole = m.Manifold.batch_boolean([m.Manifold(), *kept], m.OpType.Add)
    return (whole ^ stock_solid(part, margins)) - part_solid(part), rounds, corners


def _wall_of(face: str, part: Part) -> str:
    """The face of a wall, seen from either side: a T has two of them, a rectangular tube four."""
    if part.profile.code == "M":
        return face
    return {"h": "v", "o": "u" if part.profile.code == "T" else "o"}.get(face, face)


def _rounds(
    steel: Shape, contours: Iterable[Contour], radius: float
) -> Iterator[tuple[Point, float, Shape]]:
    """The re-entrant corners of contours, the radius that each has room for, its steel."""
    # A window that is drawn on both sides of a web has each of its corners twice.
    every = [turn for contour in contours if is_cut(contour) for turn in _turns(contour)]
    by_place = {(*(round(xy, 2) for xy in turn.place), turn.deg > 0.0): turn for turn in every}
    turns = [*by_place.values()]
    whole = _filled(steel, turns, radius)
    for one in (turn for turn in turns if turn.deg > 0.0):
        room, filled = radius, whole
        if any(is_tight for _, is_tight in _at(one, filled)):
            (x, y), far = one.place, 5 * radius
            near = steel.intersection(box(x - far, y - far, x + far, y + far))
            least, room = 0.0, radius
            while room - least > CHORD / 5:  # a disc between sides that lean lies farther off
                middle = (least + room) / 2
                filled = _filled(near, turns, middle)
                if any(is_tight for _, is_tight in _at(one, filled)):
                    room = middle
                else:
                    least = middle
            filled = _filled(near, turns, least)
        for piece, _ in _at(one, filled):
            near = Place(one.place).buffer(2 * room + 2 * CHORD)
            kept = piece.intersection(near)
            yield one.place, room, kept.buffer(5 * CHORD) if room < radius else kept


class _Turn(Struct, frozen=True):
    """A corner of a contour."""

    place: Point
    deg: float  #: that it turns, above 0 into the steel


def _at(corner: _Turn, filled: Sequence[tuple[Shape, bool]]) -> Iterator[tuple[Shape, bool]]:
    """What of it is at a corner."""
    return (one for one in filled if one[0].distance(Place(corner.place)) < 2 * CHORD)


def _filled(steel: Shape, turns: Sequence[_Turn], radius: float) -> list[tuple[Shape, bool]]:
    """What a disc that is rolled through the air does not reach, and whether that is a narrow
    place: with sides that face each other, or that goes on far off its corners."""
    quarter = facets(radius) // 4
    closed = steel.buffer(radius, quad_segs=quarter).buffer(-radius, quad_segs=quarter)
    air, more = steel.envelope.buffer(2 * radius).difference(closed), closed.difference(steel)
    filled = []
    for piece, core in _thick(more, SLIVER * radius):
        if piece.area <= CHORD:
            continue
        own = [turn for turn in turns if piece.distance(Place(turn.place)) < 2 * CHORD
               and closed.boundary.distance(Place(turn.place)) > 2 * CHORD]  # fmt: skip
        around = MultiPoint([turn.place for turn in own])
        far = max((around.distance(Place(p)) for p in get_coordinates(core)), default=0.0)
        is_tight = sum(turn.deg for turn in own) > FACING_DEG or far > 2 * radius
        if is_tight or piece.distance(air) < CHORD:
            filled.append((piece, is_tight))
    return filled


def _thick(shape: Shape, half: float) -> Iterator[tuple[Shape, Shape]]:
    """The pieces of a shape that slivers may join, each with what of it is thicker."""
    for piece in getattr(shape, "geoms", [shape]):
        cores = piece.buffer(-half).buffer(half)
        thick = [one for one in getattr(cores, "geoms", [cores]) if not one.is_empty]
        for core in thick if piece.geom_type == "Polygon" else ():
            rest = union_all([one.buffer(4 * half) for one in thick if one is not core])
            whole = piece.difference(rest)
            own = (one for one in getattr(whole, "geoms", [whole]) if one.intersects(core))
            yield next(own, core), core


def _turns(contour: Contour) -> Iterator[_Turn]:
    """The corners of a contour."""
    curves = [curve for curve in contour.curves if curve.length > CHORD]
    into = -1.0 if (signed_area(contour.curves) > 0.0) == (contour.kind == "outer") else 1.0
    for before, after in zip(curves, (*curves[1:], *curves[:1]), strict=True):
        (ax, ay), (bx, by) = before.tangent(1.0), after.tangent(0.0)
        turn = into * degrees(atan2(ax * by - ay * bx, ax * bx + ay * by))
        if abs(turn) > CORNER_DEG:
            yield _Turn(after.start, turn)


def _rounds_on(
    face: Face, at: Point, flat: Shape, radius: float, wall: Wall, part: Part
) -> "Iterator[Manifold]":
    """What a re-entrant corner keeps: `flat` of its wall, or on the round of a rectangular tube
    that of 90 degrees on the surface, whatever way it is open."""
    if part.profile.code == "M":
        skin, thick = skin_of(part)
        seen = [skin.seen(face, at[1], deep) for deep in (0.0, thick)]
        if seen[0][2]:  # it is cut where the wall reaches farthest
            for u, _, _ in seen:
                ways = [(at[0] + a * radius, u + b * radius) for a in (-1, 1) for b in (-1, 1)]
                discs = [Place(one).buffer(radius, facets(radius) // 4) for one in ways]
                shape = box(*ways[0], *ways[3]).difference(union_all(discs))
                yield wrapped(shape.buffer(CORNER_SLACK), skin, -FREE, thick + FREE)
            return
    yield from through_wall(flat, wall)
