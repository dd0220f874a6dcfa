"""From walls and what is left of them to a part's features: both routes end here."""

from collections.abc import Iterable, Iterator, Sequence
from math import pi
from typing import Any, Literal

import shapely
from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.model.part import (
    MIRRORED_FACES,
    Bevel,
    Contour,
    EndCuts,
    EndPlane,
    Face,
    Feature,
    Hole,
    Part,
    Slot,
    moved_feature,
)
from beamcam.readers.ifc.cutters import UNEXPLAINED, HalfSpace, Level, bevels_of, end_of
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.outline import Chain, Round, Slotted, shape_of
from beamcam.readers.ifc.region import Circles, Shape, chains_of, cleaned, pieces_of
from beamcam.readers.ifc.section import BareStock, Section, Wall, corner_points, walls_of
from beamcam.readers.ifc.space import IDENTITY, Frame, add, scale
from beamcam.readers.ifc.stock import Stock

SQUARE_DEG = 0.005  #: an end that is less off square is square
COMPOUND_DEG = 0.05  #: web and flange angle above which an end needs a plane of its own
MOST_BEVELS = 12  #: on a face; more are a wall that varies along a mesh


class Shaped(Struct, frozen=True, gc=False):
    """A member as DSTV sees it."""

    section: Section
    length: float
    cuts: EndCuts
    features: tuple[Feature, ...]
    volume: float  #: mm3, of the material that is left
    gross: float  #: mm, of the stock before the cuts
    remarks: tuple[str, ...] = ()
    x0: float = 0.0  #: where the part's start lies on the stock
    frame: Frame = IDENTITY  #: the part's coordinates in the element's
    fitted: tuple[str, ...] = ()  #: surfaces of the kernel that only facets stand for
    stock: BareStock | None = None  #: the section, where a shell showed it
    #: whose borders on the outside of a tube its contours are, counted from the stock
    cutters: tuple[Any, ...] = ()
    #: of what no feature explains, where a body was compared, or no contour says
    diagnostics: tuple[Diagnostic, ...] = ()

    def at(self, source: Source) -> "Shaped":
        """What was read of a member, of another one of its form."""
        features = tuple(replace(f, source=source) for f in self.features)
        diagnostics = tuple(replace(d, source=source) for d in self.diagnostics)
        return replace(self, features=features, diagnostics=diagnostics)


def part_of(shaped: Shaped) -> Part:
    """The part of a member without its names."""
    section = shaped.section
    return Part(
        mark="", profile=section.profile(""), length=shaped.length, source=Source(""),
        cuts=shaped.cuts, features=shaped.features, section=section.points,
    )  # fmt: skip


Cut = Hole | Slot | Contour
Levels = tuple[tuple[float, Shape], ...]  #: of a wall, from its lowest c to its highest
Regions = dict[Wall, Levels]


def sawn(
    stock: Stock,
    ends: tuple[HalfSpace, HalfSpace],
    span: tuple[float, float],
    features: Sequence[Cut],
    source: Source,
    volume: float | None = None,
) -> Shaped:
    """The member between two plane ends of a stock, counted from its start.

    `span` is its least and greatest x, `volume` that of its steel where the features
    are not all holes. An end that is square within tolerance has angles of 0, one that leans both
    ways is a plane.
    """
    section = stock.section
    if volume is None:
        middle = section.height / 2, section.width / 2
        length = ends[1].x(*middle) - ends[0].x(*middle)
        volume = section.area * length - hole_volume(section, features)
    x0, x1 = span
    angles = [one.angles for one in ends]
    web, flange = zip(*angles, strict=True)
    cuts = EndCuts(*(0.0 if abs(angle) < SQUARE_DEG else angle for angle in (*web, *flange)))
    planes = [
        EndPlane((one.x(0.0, 0.0) - x0, 0.0, 0.0), one.normal, source)
        for one, leaning in zip(ends, angles, strict=True)
        if min(map(abs, leaning)) > COMPOUND_DEG
    ]
    moved = in_order(features if x0 == 0.0 else [moved_feature(f, (-x0, 0.0)) for f in features])
    at, gross = stock.frame, stock.x1 - stock.x0
    frame = Frame(add(at.o, scale(at.x, x0)), at.x, at.y, at.z)
    return Shaped(
        section, x1 - x0, cuts, (*moved, *planes), volume, gross, x0=x0, frame=frame,
        stock=stock.bare,
    )  # fmt: skip


def from_regions(
    stock: Stock,
    regions: Regions,
    holes: Sequence[Hole | Slot],
    circles: Circles,
    source: Source,
    planes: Sequence[HalfSpace],
    span: tuple[float, float] | None = None,
) -> Shaped:
    """The member whose walls are `regions`, at two levels each, with `holes` beside.

    `planes` are those that the member's ends may lie in, `span` its least and greatest x where they
    are known. Raises Unreadable if nothing is left.
    """
    section = stock.section
    levels: list[Level] = [(w, c, s) for w, row in regions.items() for c, s in row]
    if not any(pieces_of(s) for _, _, s in levels):
        raise Unreadable("cuts that leave nothing")
    corners = corner_points(section)
    x0, x1 = span or (None, None)
    start, x0 = end_of(-1, planes, levels, corners, x0)
    end, x1 = end_of(1, planes, levels, corners, x1)
    features: list[Cut] = list(holes)
    remarks: list[str] = []
    for wall, row in regions.items():
        features += _wall_features(section, wall, row, (start, end), circles, source, remarks)
    flat = sum(w.width * w.thickness for w in regions)
    left = sum(
        w.thickness * sum(float(s.area) for _, s in row) / len(row) for w, row in regions.items()
    )
    # What is left of the walls, with the section's fillets in proportion.
    volume = left * (section.area / flat if flat else 1.0) - hole_volume(section, holes)
    member = sawn(stock, (start, end), (x0, x1), features, source, volume)
    return replace(member, remarks=tuple(remarks))


def _wall_features(
    section: Section,
    wall: Wall,
    row: Levels,
    ends: tuple[HalfSpace, HalfSpace],
    circles: Circles,
    source: Source,
    remarks: list[str],
) -> Iterator[Cut]:
    pair = (row[0], row[-1])
    (_, low), (_, high) = pair
    differ = low.symmetric_difference(high)
    plain = [_plain(wall, c, ends, shape) for c, shape in pair]
    explained = all(_alike(p, _filled(shape)) for p, (_, shape) in zip(plain, pair, strict=True))
    # Where the two surfaces differ only as the leaning ends make them, the longer one counts.
    beyond = differ.difference(plain[0].symmetric_difference(plain[1]).buffer(UNEXPLAINED))
    skew = not explained and not beyond.buffer(-UNEXPLAINED).is_empty
    joint = low.union(high) if not low.equals(high) else low
    for _, between in row[1:-1]:
        if float(between.difference(joint).area) > UNEXPLAINED:
            joint = joint.union(between)
            skew, explained = True, False
    hollows = [_filled(s).difference(s) for s in (low, high)]
    differ = float(hollows[0].symmetric_difference(hollows[1]).area)
    if differ > UNEXPLAINED * max(1.0, float(hollows[0].length) / 2):
        raise Unreadable(f"an opening that is not square to face {wall.face}")
    pieces = pieces_of(cleaned(joint))
    if not pieces:
        raise Unreadable(f"a cut that takes all of face {wall.face}")
    if len(pieces) > 1:
        remarks.append(f"face {wall.face} is left in {len(pieces)} pieces")
    flat_stock = section.code == "B"
    box = shapely.box(joint.bounds[0], 0.0, joint.bounds[2], wall.width)
    needs_outline = not explained or (flat_stock and not _alike(box, _filled(joint)))
    for piece in pieces:
        outer, inner = chains_of(piece, circles)
        if needs_outline or len(pieces) > 1:
            bevels = bevels_of(outer, wall, row) if skew else ()
            if len(bevels) > MOST_BEVELS:
                raise Unreadable(f"a wall whose edges lean everywhere on face {wall.face}")
            yield contour(wall.face, "outer", outer, source, bevels)
        for chain in inner:
            yield opening(wall, chain, source)


def _filled(shape: Shape) -> Shape:
    """A region without its hollows."""
    return shapely.MultiPolygon([shapely.Polygon(p.exterior) for p in pieces_of(shape)])


def _plain(wall: Wall, c: float, ends: tuple[HalfSpace, HalfSpace], shape: Shape) -> Shape:
    """What the stock and the two end planes alone would leave of a wall at a level."""
    if shape.is_empty:
        return shapely.box(0.0, 0.0, 0.0, 0.0)
    x0, _, x1, _ = shape.bounds
    plain = shapely.box(x0 - 10.0, 0.0, x1 + 10.0, wall.width)
    for end in ends:
        plain = plain.difference(end.slice(wall, c))
    return plain


def _alike(a: Shape, b: Shape) -> bool:
    """Whether two shapes differ nowhere by a strip wider than twice `UNEXPLAINED`.

    An area would let a deep nick pass in a long edge.
    """
    return bool(a.symmetric_difference(b).buffer(-UNEXPLAINED).is_empty)


def hole_volume(section: Section, features: Sequence[Cut]) -> float:
    """Volume removed by holes, for the weight."""
    by_face = {w.face: w.thickness for w in walls_of(section)}
    total = 0.0
    for hole in (one for one in features if not isinstance(one, Contour)):
        area = pi * hole.diameter * hole.diameter / 4
        if isinstance(hole, Slot):
            area += hole.diameter * (hole.length + hole.height) + hole.length * hole.height
        wall = by_face.get(hole.face, section.web_thickness)
        total += area * (wall if hole.depth is None else hole.depth)
    return total


SAME = 0.01  #: mm between two features that are one, and degrees


def opening(wall: Wall, chain: Chain, source: Source) -> Cut:
    """A hole, a slot or an inner contour, by its outline."""
    shape = shape_of(chain)
    if isinstance(shape, Round):
        return Hole(wall.face, *shape.centre, shape.diameter, source)
    if isinstance(shape, Slotted):
        sizes = shape.diameter, shape.length, 0.0, shape.angle
        return Slot(wall.face, *shape.centre, *sizes, source)
    return contour(wall.face, "inner", chain, source)


def contour(
    face: Face,
    kind: Literal["outer", "inner"],
    chain: Chain,
    source: Source,
    bevels: tuple[Bevel, ...] = (),
) -> Contour:
    """A contour from a chain that is counter-clockwise in the face's numbers.

    Outer ones run counter-clockwise seen from outside, inner ones clockwise; the numbers of o and
    h are mirrored.
    """
    if (kind == "outer") != (face not in MIRRORED_FACES):
        bevels = tuple(replace(b, curve=len(chain) - 1 - b.curve) for b in bevels)
        chain = tuple(c.reversed() for c in reversed(chain))
    return Contour(face, kind, chain, source, bevels=bevels)


def in_order(features: Iterable[Cut]) -> list[Cut]:
    """Contours, then holes and slots, face by face along the part, each of these once."""

    def place(f: Cut) -> tuple[object, ...]:
        first = isinstance(f, Contour)
        later = f.kind != "outer" if isinstance(f, Contour) else isinstance(f, Slot)
        x, y = f.curves[0].start if isinstance(f, Contour) else (f.x, f.y)
        return not first, "vouh".index(f.face), later, round(x * 1000), round(y * 1000)

    once: list[Cut] = []
    for feature in sorted(features, key=place):
        if not any(_is_same(feature, one) for one in once):
            once.append(feature)
    return once


def _is_same(a: Cut, b: Cut) -> bool:
    """Whether two holes or slots are one that is modelled twice."""
    if isinstance(a, Contour) or isinstance(b, Contour):
        return False
    if abs(a.x - b.x) >= SAME or (a.face, a.depth, type(a)) != (b.face, b.depth, type(b)):
        return False
    pairs = [(a.y, b.y), (a.diameter, b.diameter)]
    if isinstance(a, Slot) and isinstance(b, Slot):
        pairs += [(a.length, b.length), (a.angle, b.angle)]
    return all(abs(p - q) < SAME for p, q in pairs)
