"""A part beside the body that it was read from: the steel that only one of them has.

The part is the solid that `verify --solid` takes it for, built of its section and its features. It
stands twice, with every void as large as facets and roundings may make it (`least` steel) and as
small (`most`):

    least steel  <=  body  <=  most steel

What sticks out on either side is named by face and x.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from math import cos, inf, radians, tan
from typing import TYPE_CHECKING

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace

from beamcam.budget import check_member
from beamcam.errors import BeamcamError, Diagnostic, Source
from beamcam.geometry.curves import Arc
from beamcam.model.part import Contour, Hole, Part, Slot
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.finish import Shaped, part_of
from beamcam.readers.ifc.region import Shape
from beamcam.readers.ifc.section import BareStock, Section, Wall, walls_of
from beamcam.readers.ifc.shell import Shell
from beamcam.readers.ifc.solid_body import (
    beside_contours,
    by_stations,
    section_area,
    solid_less,
    solid_of,
)
from beamcam.readers.ifc.space import cross, dot
from beamcam.solid.cutters import slot_corners
from beamcam.solid.kernel import FREE, prism, walls
from beamcam.solid.part_solid import part_solid
from beamcam.solid.stock_solid import ALONG as SECTIONS
from beamcam.solid.stock_solid import Margins, shape_of

if TYPE_CHECKING:
    from manifold3d import Manifold

BOUND = 100.0  #: mm3 that lumps of a kind may be in all
MIN_LUMP = 20.0  #: mm3
MIN_CORE = 3.0  #: mm3 of a lump that stick out of the margins
#: Share of a volume from which on it is an error that steel leans, or that it is of a root fillet.
GROSS = 0.005
SPREAD = 0.0005  #: share of a volume that facets and roundings may be, which no lump shows
LEVEL_REACH = 0.15  #: thicknesses of a wall that a level may lie inside it
LEAN_REACH = 2.0  #: thicknesses of a wall that an edge may lean through it
TOUCHING = 0.05  #: mm of a cut or beside an arc that is rounding
BESIDE = 0.35  #: mm from a cut to the steel beside it; its margins lie between
WALL_SLACK = 0.01  #: mm by which steel of a wall may stand out of it
FAR = 1e5  #: mm
ROUNDING = 1e-6  #: mm
ROUND = 64  #: chords of a quarter of a circle
SHOWN = 3  #: lumps that a message names
FILLET = "the root fillet"

ArcAt = tuple[int, float, float, float]


class Fineness(Struct, frozen=True):
    """How closely a body shows what it stands for."""

    slack: float  #: mm that surfaces may be off
    facet_rad: float  #: between two corners of a mesh on one arc, at most
    chord: float = inf  #: mm between an arc and a chord, at most

    def rise(self, radius: float) -> float:
        """mm between an arc and the longest chord that a mesh has for it."""
        return min(self.chord, radius * (1.0 - cos(self.facet_rad / 2)))


class Lump(Struct, frozen=True):
    """Steel that only the body has, or only the part."""

    face: str  #: v, o, u, h, or FILLET, "no face", "the section"
    x0: float
    x1: float
    volume: float  #: mm3
    more: bool  #: the body has it, and the part that was read has not
    leans: bool  #: it lies beside a cut, no further than an edge may lean through its wall
    off: str = ""  #: how much of its wall's thickness it takes, unless that is all of it

    def __str__(self) -> str:
        where = f"face {self.face}" if len(self.face) == 1 else self.face
        what = "more" if self.more else "less"
        place = f"at x {self.x0:.1f} to {self.x1:.1f}{self.off}"
        return f"{self.volume / 1e3:.2f} cm3 {what} on {where} {place}"


class Differences(Struct, frozen=True):
    """Regions of a body that no feature of its part accounts for, the largest first."""

    lumps: tuple[Lump, ...] = ()
    fillets: tuple[Lump, ...] = ()  #: root fillets, which no contour of a flange describes
    leaning: tuple[Lump, ...] = ()  #: beside edges that do not go square through their wall
    volume: float = 0.0  #: mm3 of the body
    expected: float = 0.0  #: mm3 of the part

    def diagnostics(self, source: Source) -> tuple[Diagnostic, ...]:
        if self.lumps:
            return (rules.UNEXPLAINED.at(source, found=_listed(self.lumps)),)
        if sum(one.volume for one in self.fillets) > GROSS * self.volume > 0.0:
            share = f"{100 * GROSS:g}"
            return (rules.ROOT_CUT.at(source, found=_listed(self.fillets), share=share),)
        pairs = (rules.ROOT_FILLET, self.fillets), (rules.LEANING, self.leaning)
        off = abs(self.volume - self.expected)
        if not self.fillets and not self.leaning and off > max(BOUND, SPREAD * self.volume):
            rule = rules.VOLUME_OFF if off > GROSS * self.volume else rules.VOLUME
            found, expected = (f"{v / 1e3:.2f}" for v in (self.volume, self.expected))
            return (rule.at(source, found=found, expected=expected),)
        return tuple(rule.at(source, found=_listed(found)) for rule, found in pairs if found)


def differences(
    shaped: Shaped, body: Shell, stock: BareStock, by: Fineness, volume: float | None = None
) -> Differences:
    """What of a body, in the part's place, is not explained by its part.

    `stock` is the section that the body was cut from, `volume` that of the solid in mm3 where the
    body only stands for it. Raises Unreadable if the part has no solid.
    """
    frame, part = shaped.frame, part_of(shaped)
    if dot(cross(frame.x, frame.y), frame.z) <= 0.0:
        raise Unreadable("a part that is the mirror image of its solid")
    try:
        solid = solid_of(body)
        theirs = section_area(body) if solid is None else volume or float(solid.volume())
        if solid is not None:
            plain = None if shaped.cutters else _plainly_drilled(solid, part, shaped, stock, by)
            if plain is not None and abs(theirs - plain) <= max(BOUND, SPREAD * theirs):
                return Differences((), (), (), theirs, plain)
        drawn = _drawn(part, stock, shaped)
        if solid is None:
            rise = max((by.rise(radius) for *_, radius in _arcs(part)), default=0.0)
            pieces = [*by_stations(body, drawn, by.slack + rise)]
        else:
            # Surfaces that lie in one another are dear to cut: only where there is a core.
            exact = {True: solid - drawn, False: drawn - solid}
            cores = _cores(solid, part, stock, by, shaped)
            pieces = [(k, _grown(one, exact[k], by.slack)) for k, lumps in cores for one in lumps]
    except BeamcamError as reason:
        raise Unreadable(str(reason.diagnostics[0])) from reason
    check_member()
    by_face = (_by_face(one, more, part, shaped.section, by.slack) for more, one in pieces)
    lumps = sorted(_joined(chain.from_iterable(by_face)), key=lambda one: -one.volume)
    fillets = tuple(one for one in lumps if one.face == FILLET)
    leaning = tuple(one for one in lumps if one.leans)
    if sum(one.volume for one in leaning) > GROSS * theirs:
        leaning = ()  # too much for a cut whose edge leans
    rest = tuple(one for one in lumps if one not in fillets and one not in leaning)
    kinds = rest, fillets, leaning
    rest, fillets, leaning = (k if sum(one.volume for one in k) > BOUND else () for k in kinds)
    if shaped.cutters:  # where the outside of a tube lies beside its contours
        rest += tuple(_lump(one, more, "v", v) for more, one, v in beside_contours(part, shaped))
    expected = float(drawn.volume()) * stock.area / float(stock.shape.area)
    if part.profile.code == "C" or stock.rough is not None:
        expected = theirs  # cuts of lips are not known, nor what slanted facets take
    return Differences(rest, fillets, leaning, theirs, expected)


def _drawn(part: Part, stock: BareStock, shaped: Shaped) -> "Manifold":
    return _solid(part, Margins(section=stock.shape, square_below=0.0), shaped)


def _solid(part: Part, margins: Margins, shaped: Shaped) -> "Manifold":
    """The solid of a part; a channel's lips, which no contour describes, go with their flanges.

    The wall of a tube is cut as its cutters lie, where its contours stand for these.
    """
    if shaped.cutters:
        return solid_less(part, shaped, margins)
    solid, p = part_solid(part, margins), part.profile
    for face, wall in walls(p).items():
        if p.code == "C" and wall.normal == "y":
            bend = p.radius + (p.web_thickness or 0.0)
            strip = shapely.box(-FAR, wall.width - bend, FAR, FAR)
            gone = _gone(part, face, wall.width).buffer(margins.outline).intersection(strip)
            solid -= prism(gone, -FREE, p.height / 2, wall.frame)
    return solid


def _cores(
    solid: "Manifold", part: Part, stock: BareStock, by: Fineness, shaped: Shaped
) -> "Iterator[tuple[bool, list[Manifold]]]":
    """What sticks out of the margins of a part: of more steel, and of less."""
    least, most = (_solid(part, one, shaped) for one in _margins(stock, by.slack))
    arcs = _arcs(part)
    for more, rest in ((True, solid - most), (False, least - solid)):
        cores = [one for one in rest.decompose() if one.volume() > MIN_CORE]
        yield more, [one for one in cores if not _is_of_facets(one, arcs, by)]


def _plainly_drilled(
    solid: "Manifold", part: Part, shaped: Shaped, stock: BareStock, by: Fineness
) -> float | None:
    """The volume in mm3 of a part that differs from its body by facets only; None if in doubt.

    Round voids take most of the time of building a part, and of most parts they are holes and
    slots square through a wall. So the part is built without these. What the body lacks of that has
    to be their plugs then: one of each, which is no further from their outline than facets are, and
    as deep as the wall.
    """
    walls = {wall.face: wall for wall in walls_of(shaped.section)}
    round_ones = [f for f in part.features if isinstance(f, (Hole, Slot)) and f.face in walls]
    bare = replace(part, features=tuple(f for f in part.features if f not in round_ones))
    (_, more), (_, plugs) = _cores(solid, bare, stock, by, shaped)
    if more or len(plugs) != len(round_ones):
        return None
    volume = float(_drawn(bare, stock, shaped).volume()) * stock.area / float(stock.shape.area)
    for f in round_ones:
        wall, radius = walls[f.face], f.diameter / 2
        centres = slot_corners(f) if isinstance(f, Slot) else [(f.x, f.y)]
        spine = shapely.MultiPoint(centres).convex_hull
        pieces = [one for one in plugs if _is_plug(one, spine, radius, wall, by)]
        through = f.depth is None and (isinstance(f, Slot) or f.kind == "through")
        if len(pieces) != 1 or not through:
            return None
        volume -= wall.thickness * float(spine.buffer(radius, ROUND).area)
    return volume


def _is_plug(one: "Manifold", spine: Shape, radius: float, wall: Wall, by: Fineness) -> bool:
    """Whether steel is what a hole or a slot takes of a wall, but for facets."""
    box, axis = one.bounding_box(), 1 if wall.normal == "y" else 2
    ends = box[axis] - wall.low - by.slack, wall.high - by.slack - box[axis + 3]
    if max(map(abs, ends)) > ROUNDING:
        return False
    corners = one.to_mesh64().vert_properties
    off = shapely.distance(spine, shapely.points(corners[:, 0], corners[:, 3 - axis]))
    if np.abs(off - radius).max() > by.slack or one.hull().volume() - one.volume() > MIN_CORE:
        return False
    inside = spine.buffer(radius - by.rise(radius), ROUND).area * (wall.thickness - 2 * by.slack)
    return bool(one.volume() > inside - MIN_CORE)


def _grown(piece: "Manifold", exact: "Manifold", slack: float) -> "Manifold":
    """All of a lump of which only the core is known, that sticks out of the margins."""
    (x0, y0, z0, x1, y1, z1), by = piece.bounding_box(), slack + ROUNDING
    near = prism(shapely.box(y0 - by, z0 - by, y1 + by, z1 + by), x0 - by, x1 + by, SECTIONS)
    parts = [one for one in (exact ^ near).decompose() if not (one ^ piece).is_empty()]
    return max(parts, key=lambda one: one.volume(), default=piece)


def _margins(stock: BareStock, slack: float) -> tuple[Margins, Margins]:
    """Of the least steel and of the most."""
    least, most = stock.shape, stock.shape
    if stock.rough is not None:
        least, most = least.difference(stock.rough), most.union(stock.rough)

    def by(off: float, section: Shape) -> Margins:
        return Margins(lambda _: off, off, off, off, skin=off, section=section, square_below=0.0)

    return by(slack, least), by(-slack, most)


def _lump(steel: "Manifold", more: bool, face: str, volume: float, leans: bool = False) -> Lump:
    box = steel.bounding_box()
    return Lump(face, float(box[0]), float(box[3]), volume, more, leans)


def _by_face(
    piece: "Manifold", more: bool, part: Part, of: Section, slack: float
) -> Iterator[Lump]:
    """The steel of a lump by the walls that it lies in, and beside them."""
    walls = sorted(walls_of(of), key=lambda wall: wall.normal == "z")
    for wall in walls:
        inside, rest = piece.split(_box_of(wall, WALL_SLACK))
        if (inside ^ _box_of(wall, -slack)).volume() > MIN_CORE:  # or it only grazes the wall
            piece = rest
            if inside.volume() > MIN_LUMP:
                leans = _leans(inside, more, wall, part)
                box, k = inside.bounding_box(), 1 if wall.normal == "y" else 2
                deep = min(box[k + 3], wall.high) - max(box[k], wall.low)
                thin = not (more or leans) and deep < wall.thickness - 2 * slack
                off = f" ({deep:.1f} mm off its {wall.thickness:g} mm)" if thin else ""
                one = _lump(inside, more, wall.face, float(inside.volume()), leans)
                yield replace(one, off=off)
    if (volume := float(piece.volume())) > MIN_LUMP:
        bare = "the section" if of.code == "SO" else "v"
        yield _lump(piece, more, _face_beside(piece, walls, of) if walls else bare, volume)


def _box_of(wall: Wall, larger: float) -> "Manifold":
    return _through(wall, shapely.box(-FAR, -larger, FAR, wall.width + larger), larger)


def _face_beside(piece: "Manifold", walls: Sequence[Wall], of: Section) -> str:
    """Where steel lies that is in no wall: in the fillets between two, or at none."""
    reach = of.radius + 0.01 * of.height
    fillets = shapely.union_all([
        shapely.box(a.low - reach, b.low - reach, a.high + reach, b.high + reach)
        for a in walls if a.normal == "y"
        for b in walls if b.normal == "z"
    ])  # fmt: skip
    inside = piece ^ prism(fillets, -FAR, FAR, SECTIONS)
    return FILLET if inside.volume() > piece.volume() / 2 else "no face"


def _through(wall: Wall, shape: Shape, over: float) -> "Manifold":
    """All through a wall and over its surfaces, by a shape in (x, q)."""
    frame = (1.0, 0.0, 0.0, 0.0), (0.0, *wall.across[1:], 0.0), (0.0, *wall.direction[1:], 0.0)
    return prism(shape, wall.low - over, wall.high + over, frame)


def _leans(piece: "Manifold", more: bool, wall: Wall, part: Part) -> bool:
    """Whether a lump is what an edge leaves that does not go square through its wall.

    The part has the outline of both sides of the wall together, so that it may lack no more than
    what lies between its surface and the level at which it was looked at.
    """
    cuts = _cuts_of(wall, part)
    gone = shapely.union_all(cuts)
    if gone.is_empty or (piece ^ _through(wall, gone.buffer(BESIDE), FREE)).is_empty():
        return False
    near = gone.buffer(LEAN_REACH * wall.thickness)
    if more:
        edges = shapely.union_all([cut.boundary for cut in cuts])
        near = edges.buffer(LEVEL_REACH * wall.thickness)
    return bool((piece - _through(wall, near, FREE)).volume() < MIN_LUMP)


def _gone(part: Part, face: str, width: float) -> Shape:
    """What contours take of the wall behind a face, in (x, q)."""
    contours = [c for c in part.contours if c.face == face]
    gone = [shape_of(c.curves) for c in contours if c.kind == "inner"]
    outer = [shape_of(c.curves) for c in contours if c.kind == "outer"]
    if outer:
        whole = shapely.box(0.0, 0.0, part.length, width)
        gone.append(whole.difference(shapely.union_all(outer)))
    return shapely.union_all(gone).buffer(-TOUCHING).buffer(TOUCHING)


def _cuts_of(wall: Wall, part: Part) -> list[Shape]:
    """What contours take of a wall, and each of their bevels, in (x, q)."""
    cuts = [_gone(part, wall.face, wall.width)]
    for contour in (c for c in part.contours if c.face == wall.face):
        for bevel in contour.bevels:
            deep = wall.thickness - bevel.land
            if bevel.angle < 0.0:
                deep = bevel.land or wall.thickness
            wide = deep * tan(radians(abs(bevel.angle)))
            edge = contour.curves[bevel.curve]
            cuts.append(shapely.LineString([edge.start, edge.end]).buffer(wide, cap_style="square"))
    return cuts


def _arcs(part: Part) -> list[ArcAt]:
    """The arcs of a part's holes, slots and contours: across which axis, centre (x, q), radius."""
    arcs: list[ArcAt] = []
    for f in part.features:
        axis = 1 if getattr(f, "face", "v") in ("o", "u") else 2
        if isinstance(f, Hole):
            arcs.append((axis, f.x, f.y, f.diameter / 2))
        elif isinstance(f, Slot):
            arcs += [(axis, x, y, f.diameter / 2) for x, y in slot_corners(f)]
        elif isinstance(f, Contour):
            arcs += [(axis, *c.centre, c.radius) for c in f.curves if isinstance(c, Arc)]
    return arcs


def _is_of_facets(piece: "Manifold", arcs: Sequence[ArcAt], by: Fineness) -> bool:
    """Whether a lump lies between an arc of the part and the chords that a mesh has for it."""
    points = piece.to_mesh64().vert_properties
    thin = 2.0 * float(piece.volume()) / float(piece.surface_area())
    for axis, x, q, radius in arcs:
        rise = by.rise(radius)
        if thin < rise:
            off = np.hypot(points[:, 0] - x, points[:, 3 - axis] - q)
            if off.min() > radius - rise - TOUCHING and off.max() < radius + TOUCHING:
                return True
    return False


def _joined(lumps: Iterable[Lump]) -> list[Lump]:
    """The lumps with those joined that follow one another on a face."""
    out: list[Lump] = []
    for one in sorted(lumps, key=lambda lump: lump.x0):
        for i, known in enumerate(out):
            same = (known.face, known.more, known.leans) == (one.face, one.more, one.leans)
            if same and one.x0 - known.x1 < 5.0:
                volume, x1 = known.volume + one.volume, max(one.x1, known.x1)
                out[i] = replace(known, x1=x1, volume=volume)
                break
        else:
            out.append(one)
    return out


def _listed(lumps: Sequence[Lump]) -> str:
    more = f"; and {len(lumps) - SHOWN} more" if len(lumps) > SHOWN else ""
    return "; ".join(map(str, lumps[:SHOWN])) + more
