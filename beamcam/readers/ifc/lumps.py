"""Where a body and the part that was read of it differ: lumps of steel, each by face and x.

Both are cut across the part between all x at which either changes its form. Where the sections
differ in area or in moment, they are laid on one another.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from beamcam.readers.ifc.rebuilt import Rebuilt
from beamcam.readers.ifc.region import Shape
from beamcam.readers.ifc.section import Section
from beamcam.readers.ifc.shell import ALONG, Shell, section
from beamcam.readers.ifc.walls import Wall, walls_of

NEAR_EVENTS = 0.05  #: mm between two x that are one
MOST_STATIONS = 160  #: that are looked at; the longest stretches come first
SUSPECT = 0.5  #: mm2 of a section; less is rounding
MIN_LUMP = 20.0  #: mm3
TOUCHING = 0.05  #: mm between a piece and a cut that it lies beside
FACET_WIDTH = 0.05  #: mm by which the edge of a drilled hole may be off at a section

Numbers = NDArray[np.float64]


class Lump(Struct, frozen=True):
    """Steel that only the body has, or only the part."""

    face: str  #: v, o, u, h, or "the root fillet", "inside"
    x0: float
    x1: float
    volume: float  #: mm3
    more: bool  #: the body has it, and the part that was read has not
    beside: float | None = None  #: mm from the nearest cut, at most, where it lies on a wall

    def __str__(self) -> str:
        where = f"face {self.face}" if len(self.face) == 1 else self.face
        what = "more" if self.more else "less"
        return f"{self.volume / 1e3:.2f} cm3 {what} on {where} at x {self.x0:.1f} to {self.x1:.1f}"


def lumps(body: Shell, made: Rebuilt, of: Section, slack: float) -> list[Lump]:
    """The lumps wider than twice `slack` mm in which a body, in the part's place, is not the part.

    Greatest first.
    """
    found: list[Lump] = []
    for x0, x1, shape in _stretches(body, made):
        theirs = across(body, (x0 + x1) / 2)
        for more, differ in ((True, theirs.difference(shape)), (False, shape.difference(theirs))):
            for face, piece in _by_face(differ, of, slack):
                volume = float(piece.area) * (x1 - x0)
                gone, near = made.stock.difference(shape), 2 * slack + TOUCHING
                beside = _beside(piece, gone, made, face, (x0 + x1) / 2, near, more)
                found.append(Lump(face, x0, x1, volume, more, beside))
    return sorted(_joined(found), key=lambda lump: -lump.volume)


def _stretches(body: Shell, made: Rebuilt) -> Iterator[tuple[float, float, Shape]]:
    """Stretches of x in which body and part are not alike, with the part's section there."""
    marks = np.unique(np.concatenate([np.array(made.events), body.points[:, 0].round(4)]))
    keep = [marks[0]]
    for x in marks[1:]:
        if x - keep[-1] > NEAR_EVENTS:
            keep.append(x)
    edges = np.array(keep)
    if len(edges) < 2:
        return
    widths = np.diff(edges)
    chosen = np.sort(np.argsort(-widths, kind="stable")[:MOST_STATIONS])
    middles = (edges[:-1] + widths / 2)[chosen]
    shapes = made.sections(middles)
    areas = moments(body, middles) if body.volume is not None else None
    rough = (2 * FACET_WIDTH * made.walls_drilled(middles)).tolist()
    for i, place in enumerate(chosen.tolist()):
        shape = shapes[i]
        if areas is not None and _alike(shape, areas[i], SUSPECT + rough[i]):
            continue
        yield float(edges[place]), float(edges[place + 1]), shape


def _alike(shape: Shape, theirs: Sequence[float], slack: float) -> bool:
    area = float(shape.area)
    if abs(area - theirs[0]) > slack:
        return False
    if area < slack:
        return True
    centre = shape.centroid
    off = max(abs(centre.x * area - theirs[1]), abs(centre.y * area - theirs[2]))
    return bool(off <= slack * max(1.0, float(shape.length) / 4))


def moments(body: Shell, xs: Numbers) -> Numbers:
    """Area and first moments about y and z of a closed body's sections, a row for each x.

    The plane cuts each face along segments that run round the section, steel on their left, so
    that the sums over them are those of a polygon.
    """
    points, rings = body.points, body.rings
    face = rings.face_of_corner
    before = rings.before
    out = np.zeros((len(xs), 3))
    way = np.sign((body.area_normals * body.firsts).sum() or 1.0)
    for i, x in enumerate(xs):
        heights = points[:, 0] - x
        above = heights >= 0
        after = np.flatnonzero(above != above[before])
        if not len(after):
            continue
        ahead = before[after]
        share = heights[ahead] / (heights[ahead] - heights[after])
        hits = points[ahead, 1:] + (points[after, 1:] - points[ahead, 1:]) * share[:, None]
        of = face[after]
        normal = body.area_normals[of]
        # Along the plane and the face: the normal turned by a quarter.
        along = -hits[:, 0] * normal[:, 2] + hits[:, 1] * normal[:, 1]
        order = np.lexsort((along, of))
        y, z = hits[order, 0], hits[order, 1]
        y0, z0, y1, z1 = y[0::2], z[0::2], y[1::2], z[1::2]
        cross = y0 * z1 - y1 * z0
        out[i] = (
            cross.sum() / 2, (cross * (z0 + z1)).sum() / 6, (cross * (y0 + y1)).sum() / 6
        )  # fmt: skip
    found: Numbers = out * way
    return found


def across(body: Shell, x: float) -> Shape:
    """The body's section at x, in (Z, Y)."""
    return section(body, (x, 0.0, 0.0), ALONG, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))


def section_area(body: Shell) -> float:
    """mm3 of a body by its sections, which crossings measure even where faces lie twice."""
    marks = np.unique(body.points[:, 0].round(4))
    edges = np.array([m for i, m in enumerate(marks) if i == 0 or m - marks[i - 1] > NEAR_EVENTS])
    widths = np.diff(edges)
    chosen = np.argsort(-widths, kind="stable")[:MOST_STATIONS]
    places = (edges[:-1] + widths / 2)[chosen]
    slices = zip(places.tolist(), widths[chosen].tolist(), strict=True)
    return float(sum(float(across(body, x).area) * wide for x, wide in slices))


def _beside(
    piece: Shape, gone: Shape, made: Rebuilt, face: str, x: float, touching: float, more: bool
) -> float | None:
    """How far a piece reaches over its wall from the edge of what is cut; None if it is apart."""
    import shapely

    cuts = [cut for cut in made.cuts if cut.wall.face == face]
    if not cuts or gone.is_empty or piece.distance(gone) > touching:
        return None
    along_y = cuts[0].wall.normal == "y"
    spots = shapely.points([(x, z if along_y else y) for z, y in shapely.get_coordinates(piece)])
    edges = np.array([cut.shape.boundary if more else cut.shape for cut in cuts])
    nearest = edges[shapely.STRtree(edges).nearest(spots)]
    return float(shapely.distance(spots, nearest).max())


def _by_face(differ: Shape, of: Section, slack: float) -> Iterator[tuple[str, Shape]]:
    """The pieces of a difference of two sections, with the faces on which they lie."""
    for piece in getattr(differ, "geoms", (differ,)):
        if piece.geom_type != "Polygon" or piece.area < SUSPECT:
            continue
        core = piece.buffer(-slack)
        if core.is_empty:
            continue
        spot = core.representative_point()
        yield _face_at(float(spot.y), float(spot.x), of), piece


def _face_at(y: float, z: float, of: Section) -> str:
    """The face of a point of the section."""
    walls = walls_of(of)
    for wall in sorted(walls, key=lambda w: w.normal == "z"):
        q, c = wall.split((0.0, y, z))
        if wall.low - 0.01 <= c <= wall.high + 0.01 and -0.01 <= q <= wall.width + 0.01:
            return wall.face
    if not walls:
        return "v" if of.code in ("RO", "RU") else "the section"
    reach = of.radius + 0.01 * of.height
    near = [w for w in walls if _depth(w, y, z) <= reach]
    return "the root fillet" if len(near) > 1 else "no face"


def _depth(wall: Wall, y: float, z: float) -> float:
    _, c = wall.split((0.0, y, z))
    return max(wall.low - c, c - wall.high, 0.0)


def _joined(found: Sequence[Lump]) -> list[Lump]:
    """The lumps with those joined that follow one another on a face; scraps left out."""
    out: list[Lump] = []
    for one in found:
        for i, known in enumerate(out):
            same = known.face == one.face and known.more == one.more
            if same and one.x0 - known.x1 < 5.0:
                far = None
                if known.beside is not None and one.beside is not None:
                    far = max(known.beside, one.beside)
                volume = known.volume + one.volume
                out[i] = replace(known, x1=max(one.x1, known.x1), volume=volume, beside=far)
                break
        else:
            out.append(one)
    return [lump for lump in out if lump.volume > MIN_LUMP]
