"""What has to stay of a rectangular tube, on its unrolled surface, for the read-back alone.

A contour counts as it is seen square to its face. Over a corner a line of one face goes on in that
of the other: both are added, less the x at which they meet at the sharp edge. An end that is a
plane is cut where the wall reaches farthest, at its outside or at its inside.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from math import asin, hypot, pi, radians, sin, tan
from typing import Any

from msgspec import Struct
from shapely import Polygon, box, get_coordinates, line_merge, transform, union_all
from shapely.affinity import translate

from beamcam.checks.coping.box_faces import (
    APART,
    BoxWall,
    outlined,
    outlines_of,
    short_face,
    void_of,
)
from beamcam.checks.coping.required_wall import corners_of, with_corners_cut
from beamcam.checks.coping.section import TubeSection, areas_of, pieces_of
from beamcam.checks.coping.stock import FINE
from beamcam.checks.coping.tube_ends import (
    FAR,
    SQUARE_DEG,
    End,
    FaceEnds,
    PieceAsked,
    Xs,
    ends_of_shape,
    is_stated,
    kept,
    planes_of,
    round_corner,
    surfaces_of,
    x_on,
)
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.model.part import Contour, Part

Shape = Any  #: of shapely

PLACES = 48  #: across a corner
STRAIGHT = 0.001  #: mm that places across a corner are off a straight line, and are left out
LEVEL = tan(radians(SQUARE_DEG))
INSIDE = 1e-6  #: mm off the edges of a band
LEAST_OFF = 0.5  #: mm that a square cut is off inside of a wall, and that are manual work
#: The faces beside each corner on the way round, and whether it is at the greatest y of each.
CORNERS = (("u", True, "v", False), ("v", True, "o", True), ("o", False, "h", True),
           ("h", False, "u", False))  # fmt: skip


class RequiredTube(Struct, frozen=True):
    """What has to stay of three turns of the surface, and how skew a square cut leaves walls."""

    drawn: Shape
    cut: Shape
    off: dict[str, float]  #: mm at the inside of the wall, by face
    lost: str = ""  #: the corner over which the contours do not go on
    #: the face for which a piece that comes cut is too short, and by how much
    short: tuple[str, float] = "", 0.0


def required_box(
    part: Part, coper: Coper, left: set[int], section: TubeSection, piece: PieceAsked | None = None
) -> RequiredTube:
    """What has to stay of a part or a piece; `left` are features that are not made."""
    features = [f for k, f in enumerate(part.features) if k not in left]
    walls = {face: outlined(part, face, features, section, piece) for face in "uvoh"}
    ends = _ends(part, walls, section)
    planes = [*planes_of(part, left, section)]
    skew = [*ends, *(end for _, end in planes)]
    off = {face: max(_skew(end, section, face) for end in skew) for face in walls}
    shapes, corners = [], list[Point]()
    ending: dict[str, list[Shape]] = {face: [] for face in walls}
    for face, wall in walls.items():
        steel = _ended(wall, ends, section)
        others = [f for f in features if getattr(f, "face", "") == face
                  and getattr(f, "kind", "") != "outer"]  # fmt: skip
        for feature in [*outlines_of(face, features), *others]:
            void = void_of(feature, piece)
            if _into_corner(void, wall.wide, section.radius):
                ending[face].append(void)
            else:
                steel = steel.difference(void)
            if isinstance(feature, Contour):
                corners += [
                    (x, s)
                    for x, y in corners_of(feature.curves, steel)
                    if FINE < y < wall.wide - FINE
                    and not (piece and piece.faces[face].is_mouth((x, y)))
                    for s in _on_surface(face, y, wall.wide, section)
                ]
        walls[face] = BoxWall(face, wall.wide, steel, wall.is_drawn)
        flat = steel.difference(union_all(ending[face])) if ending[face] else steel
        shapes.append(_flat(BoxWall(face, wall.wide, flat, wall.is_drawn), section))
    for k, corner in enumerate(CORNERS):
        shape = _rounded(k, walls, ends, section, off)
        if shape is None:
            return RequiredTube(shapes[0], shapes[0], off, f"{corner[0]} and {corner[2]}")
        seen = [
            _in_corner(void, walls[face].wide, at_high, is_first, k, section)
            for face, at_high, is_first in ((*corner[:2], True), (*corner[2:], False))
            for void in ending[face]
        ]
        shapes.append(shape.difference(union_all(seen)) if seen else shape)
    one, turn = areas_of(union_all(shapes)), section.turn
    drawn = union_all([translate(one, 0.0, k * turn) for k in (-1, 0, 1)])
    for side, end in planes:
        drawn = kept(drawn, side, end, section)
    drawn = areas_of(drawn.intersection(piece.steel) if piece else drawn)
    cut = with_corners_cut(drawn, corners, coper.corner_radius, turn)
    skew_walls = {f: mm for f, mm in off.items() if mm >= LEAST_OFF}
    return RequiredTube(drawn, cut, skew_walls, short=short_face(part, features, section, piece))


def box_outlines(part: Part, coper: Coper, section: TubeSection) -> Iterator[list[Point]]:
    """The outlines of what is drawn on one turn of the surface, for pictures."""
    drawn = required_box(part, coper, set(), section).drawn
    for one in pieces_of(drawn.intersection(box(-FAR, 0.0, FAR, section.turn))):
        for ring in (one.exterior, *one.interiors):
            yield [(x, s) for x, s in ring.coords[:-1]]


# --- ends -----------------------------------------------------------------------------------------


def box_ends(part: Part, section: TubeSection) -> tuple[dict[str, FaceEnds], float]:
    """Where a piece ends on each of its faces, by its header and its outlines, and how far apart
    the two surfaces of a wall end at most."""
    walls = {face: outlined(part, face, part.features, section) for face in "uvoh"}
    own, skew = [*planes_of(part, (), section)], _ends(part, walls, section)
    ends: dict[str, FaceEnds] = {}
    apart = 0.0
    for face, wall in walls.items():
        rows = []
        drawn = ends_of_shape(wall.steel, 0.0, wall.wide)
        for side, plane, as_drawn in zip((-1, 1), skew, drawn, strict=True):
            planes = [end for at, end in own if at == side]
            planes += [] if plane is None else [plane]
            apart = max(apart, *(section.wall * hypot(*end[1:]) for end in planes), 0.0)

            def xs(y: float, side: int = side, planes: Sequence[End] = planes,
                   face: str = face, as_drawn: Xs = as_drawn) -> tuple[float, ...]:  # fmt: skip
                if not planes:
                    return as_drawn(y)
                return tuple(
                    side * min(side * x_on(end, face, at, y, section) for end in planes)
                    for at in surfaces_of(face, section)
                )

            rows.append(xs)
        outlines = any(f.face == face for f in outlines_of(face, part.features))
        ends[face] = FaceEnds(rows[0], rows[1], part.length, outlines)
    return ends, apart


def _ends(
    part: Part, walls: Mapping[str, BoxWall], section: TubeSection
) -> tuple[End | None, End | None]:
    """The planes of skew ends; None of any other."""
    drawn = [(wall.face, wall.ends()) for wall in walls.values() if wall.is_drawn]
    seen = [[(face, y, x) for face, ends in drawn for x, y in ends[k]] for k in (0, 1)]
    return _end(part, seen[0], section, -1), _end(part, seen[1], section, 1)


def _end(
    part: Part, seen: Sequence[tuple[str, float, float]], section: TubeSection, side: int
) -> End | None:
    """The plane of a skew end, by places (face, y, x) along it where it is drawn."""
    import numpy as np

    cuts = part.cuts
    degs = (cuts.web_start, cuts.flange_start) if side < 0 else (cuts.web_end, cuts.flange_end)
    if is_stated(part, side, *degs):
        degs = (0.0, 0.0)
    web, flange = (tan(radians(d)) if abs(d) > SQUARE_DEG else 0.0 for d in degs)
    if not seen:
        if not (web or flange):
            return None
        # The farthest place of a rounded rectangle along a way, from its middle.
        reach = section.flat_y * abs(web) + section.flat_z * abs(flange)
        reach += section.radius * hypot(web, flange)
        return (reach if side < 0 else part.length - reach), web, flange
    best: tuple[float, End] | None = None
    for signs in ((0, 0), *product((1, -1), repeat=2)):
        rows, xs = [], []
        for face, y, x in seen:
            outside, inside = surfaces_of(face, section)
            # A plane whose x falls along an axis reaches farthest at the least place of a far end.
            sign = signs[0] if face in "ou" else signs[1]
            pick = min if sign * side > 0 else max
            at = pick(outside, inside) if sign else outside
            along = (y - section.half_y, at) if face in "vh" else (at, y - section.half_z)
            rows.append((1.0, -along[0], -along[1]))
            xs.append(x)
        matrix, values = np.array(rows), np.array(xs)
        if web or flange:
            given = matrix[:, 1] * web + matrix[:, 2] * flange
            solution = np.array([np.mean(values - given), web, flange])
        else:
            # Round the means, so that a slope of which no face says anything is none.
            around = matrix[:, 1:] - matrix[:, 1:].mean(axis=0)
            slopes = np.linalg.lstsq(around, values - values.mean(), rcond=None)[0]
            solution = np.array([np.mean(values - matrix[:, 1:] @ slopes), *slopes])
        worst = float(np.max(np.abs(matrix @ solution - values)))
        by_y, by_z = float(solution[1]), float(solution[2])
        if worst > APART / 2 or min(signs[0] * by_y, signs[1] * by_z) < -LEVEL:
            continue
        if best is None or worst < best[0]:
            best = worst, (float(solution[0]), by_y, by_z)
    if best is None or max(map(abs, best[1][1:])) <= LEVEL:
        return None
    return best[1]


def _skew(end: End | None, section: TubeSection, face: str) -> float:
    if end is None:
        return 0.0
    return section.wall * abs(end[1] if face in "ou" else end[2])


def _ended(wall: BoxWall, ends: Sequence[End | None], section: TubeSection) -> Shape:
    """A face whose ends are where planes are to be cut."""
    low, _, high, _ = wall.steel.bounds
    steel = wall.steel if wall.is_drawn else box(
        -FAR if ends[0] else low, 0.0, FAR if ends[1] else high, wall.wide
    )  # fmt: skip
    for side, end in zip((-1, 1), ends, strict=True):
        if end is None:
            continue
        pick = min if side < 0 else max
        low, high = (
            pick(x_on(end, wall.face, at, y, section) for at in surfaces_of(wall.face, section))
            for y in (0.0, wall.wide)
        )
        deep = -side * (_skew(end, section, wall.face) + 2 * APART)

        def quad(by: float, low: float = low, high: float = high, wide: float = wall.wide) -> Shape:
            return Polygon([(low, 0.0), (high, wide), (high + by, wide), (low + by, 0.0)])

        # Moved on along the tube, an outline keeps the slots that begin at its end.
        further = quad(deep).intersection(translate(steel, -deep)) if wall.is_drawn else Polygon()
        whole = union_all([steel, further])
        steel = whole.intersection(quad(-side * FAR))
    return steel


def _into_corner(void: Shape, wide: float, radius: float) -> float:
    """How far a cut-out goes into a corner where it ends before its middle, or 0."""
    if void.is_empty:
        return 0.0
    _, low, _, high = void.bounds
    into = max(high - wide, -low) + radius
    return into if INSIDE < into <= radius * sin(pi / 4) else 0.0


def _in_corner(
    void: Shape, wide: float, at_high: bool, is_first: bool, k: int, section: TubeSection
) -> Shape:
    """A cut-out seen square to its face, where it lies on the corner behind or before that."""
    r, first = section.radius, section.corner(k)
    zone = box(-FAR, wide - r, FAR, wide) if at_high else box(-FAR, 0.0, FAR, r)
    part = void.intersection(zone)
    if part.area <= 0.0:
        return Polygon()

    def laid(places: Any) -> Any:
        import numpy as np

        beyond = places[:, 1] - (wide - r) if at_high else r - places[:, 1]
        turned = r * np.arcsin(np.clip(beyond / r, 0.0, 1.0))
        turned = np.where(beyond < INSIDE, -1e-4, turned)  # over the seam with the flat
        return np.column_stack((places[:, 0], first + turned if is_first
                                else first + r * pi / 2 - turned))  # fmt: skip

    return transform(part.segmentize(0.2), laid)


def _on_surface(face: str, y: float, wide: float, section: TubeSection) -> set[float]:
    """s of a place of a face; over the corner beside it those of outside and inside."""
    r = section.radius
    flat = min(max(y, r), wide - r)
    into, rises = abs(y - flat), (y > flat) == (face in "uv")
    if into <= INSIDE:
        return {section.around(face, y)}
    shares = (min(1.0, into / q) if q else 1.0 for q in (r, r - section.wall))
    return {section.around(face, flat) + (r if rises else -r) * asin(share) for share in shares}


# --- round ----------------------------------------------------------------------------------------


def _flat(wall: BoxWall, section: TubeSection) -> Shape:
    """The flat stretch of a face on the unrolled surface."""
    r = section.radius
    flat = wall.steel.intersection(box(-FAR, r - 1e-4, FAR, wall.wide - r + 1e-4))

    def laid(places: Any) -> Any:
        import numpy as np

        return np.column_stack((places[:, 0], section.around(wall.face, places[:, 1])))

    return transform(flat, laid)


def _lines(wall: BoxWall, at_high: bool, radius: float) -> list[Any]:
    """The lines of a face beside an edge by their x there, each as distances from it and x."""
    import numpy as np

    low, high = (wall.wide - radius, wall.wide) if at_high else (0.0, radius)
    band = wall.steel.boundary.intersection(box(-FAR, low + INSIDE, FAR, high - INSIDE))
    lines = []
    for piece in pieces_of(line_merge(band) if band.geom_type == "MultiLineString" else band):
        x, y = get_coordinates(piece).T
        off = wall.wide - y if at_high else y
        if off[0] > off[-1]:  # places at one distance stay in their order from the edge on
            off, x = off[::-1], x[::-1]
        order = np.argsort(off, kind="stable")
        lines.append((off[order], x[order]))
    return sorted(lines, key=lambda line: float(line[1][0]))


def _rounded(
    k: int,
    walls: Mapping[str, BoxWall],
    ends: Sequence[End | None],
    section: TubeSection,
    off: dict[str, float],
) -> Shape | None:
    """What has to stay of a corner, or None; `off` gets what a square cut leaves beside it."""
    import numpy as np

    a, a_high, b, b_high = CORNERS[k]
    r = section.radius
    lines_a, lines_b = _lines(walls[a], a_high, r), _lines(walls[b], b_high, r)
    whole = all(d[0] <= 2 * INSIDE and d[-1] >= r - 2 * INSIDE for d, _ in (*lines_a, *lines_b))
    if len(lines_a) != len(lines_b) or len(lines_a) % 2 or not whole:
        return None
    depths = [q for q in (r, r - section.wall) if q]
    bends = [np.arcsin(np.clip((r - d) / q, 0.0, 1.0)) for d, _ in lines_a for q in depths]
    bends += [np.arccos(np.clip((r - d) / q, 0.0, 1.0)) for d, _ in lines_b for q in depths]
    beside = [np.clip(one + by, 0.0, pi / 2) for one in bends for by in (-1e-5, 1e-5)]
    turns = np.unique(np.concatenate((np.linspace(0.0, pi / 2, PLACES), *beside)))
    share = turns / (pi / 2)
    curves = []
    for number, ((da, xa), (db, xb)) in enumerate(zip(lines_a, lines_b, strict=True)):
        at_end = ends[0] if number == 0 else ends[1] if number == len(lines_a) - 1 else None
        if at_end is not None:
            curves.append(round_corner(at_end, k, turns, section, number == 0))
            continue
        if abs(xa[0] - xb[0]) > APART:
            return None
        edge = (1 - share) * xb[0] + share * xa[0]
        outside, inside = (
            np.interp(r - q * np.sin(turns), da, xa) + np.interp(r - q * np.cos(turns), db, xb)
            - edge
            for q in (r, r - section.wall)
        )  # fmt: skip
        along = [bool(np.any((np.diff(d) < FINE) & (np.abs(np.diff(x)) > FINE)))
                 for d, x in ((da, xa), (db, xb))]  # fmt: skip
        if any(along):  # the edge of a cope, which lies where the wall reaches farthest
            outside = (np.maximum if number % 2 else np.minimum)(outside, inside)
        curves.append(outside)
        for face, d, x, is_along in ((b, da, xa, along[0]), (a, db, xb, along[1])):
            if is_along:
                continue
            off[face] = max(off[face], abs(float(np.interp(section.wall, d, x)) - float(x[0])))
    ss = section.corner(k) + r * turns
    sides = [np.column_stack((curve, ss)) for curve in curves]
    return union_all([
        Polygon(np.concatenate((low, high[::-1]))).simplify(STRAIGHT, preserve_topology=False)
        for low, high in zip(sides[::2], sides[1::2], strict=True)
    ])  # fmt: skip
