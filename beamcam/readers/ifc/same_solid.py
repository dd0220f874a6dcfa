"""A part beside the body that it was read from: the steel that only one of them has.

The part is the solid that `verify --solid` takes it for, built of its section and its features. It
stands twice, with every void as large as facets and roundings may make it (`least` steel) and as
small (`most`):

    least steel  <=  body  <=  most steel

What sticks out on either side is named by face and x.
"""

from collections.abc import Iterator, Sequence
from math import cos, radians, tan
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct

from beamcam.budget import check_member
from beamcam.errors import BeamcamError, Diagnostic, Source
from beamcam.geometry.curves import Arc
from beamcam.model.part import Contour, Hole, Part, Slot
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.finish import Shaped
from beamcam.readers.ifc.region import Shape, rectangle
from beamcam.readers.ifc.section import BareStock, Section, area_by_measures
from beamcam.readers.ifc.shell import ALONG, Shell, section
from beamcam.readers.ifc.walls import Wall, walls_of
from beamcam.solid.kernel import kernel, prism
from beamcam.solid.part_solid import ALONG as SECTIONS
from beamcam.solid.part_solid import Margins, part_solid, shape_of, slot_corners
from beamcam.solid.section import FREE, outline

if TYPE_CHECKING:
    from manifold3d import Manifold

BOUND = 100.0  #: mm3 that lumps of a kind may be in all
MIN_LUMP = 20.0  #: mm3
#: Share of a volume from which on it is an error that steel leans, or that it is of a root fillet.
GROSS = 0.005
LEVEL_REACH = 0.15  #: thicknesses of a wall that a level may lie inside it
LEAN_REACH = 2.0  #: thicknesses of a wall that an edge may lean through it
WELDED = 5  #: decimals of a mm to which corners of faces are one
FACET_RAD = 0.6  #: between two corners of a mesh on one arc, at most
NEAR_EVENTS = 0.05  #: mm between two x that are one
MOST_STATIONS = 160  #: that are looked at; the longest stretches come first
TOUCHING = 0.05  #: mm of a cut or beside an arc that is rounding
BESIDE = 0.35  #: mm from a cut to the steel beside it; its margins lie between
KERNEL_SLACK = 0.13  #: mm that a reading of the kernel's solid may be off
SECTION_SLACK = 0.005  #: share of a section's area that its measures may leave out
FILM = 0.15  #: mm, half of what facets of a section may be off
WALL_SLACK = 0.01  #: mm by which steel of a wall may stand out of it
SHOWN = 3  #: lumps that a message names
FILLET = "the root fillet"
#: Takes (x, y, z) to (Y, Z, x), for sections across.
ACROSS = ((0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (1.0, 0.0, 0.0, 0.0))


class Lump(Struct, frozen=True):
    """Steel that only the body has, or only the part."""

    face: str  #: v, o, u, h, or FILLET, "no face", "the section"
    x0: float
    x1: float
    volume: float  #: mm3
    more: bool  #: the body has it, and the part that was read has not
    leans: bool  #: it lies beside a cut, no further than an edge may lean through its wall

    def __str__(self) -> str:
        where = f"face {self.face}" if len(self.face) == 1 else self.face
        what = "more" if self.more else "less"
        return f"{self.volume / 1e3:.2f} cm3 {what} on {where} at x {self.x0:.1f} to {self.x1:.1f}"


class Differences(Struct, frozen=True):
    """Regions of a body that no feature of its part accounts for, the largest first."""

    lumps: tuple[Lump, ...] = ()
    fillets: tuple[Lump, ...] = ()  #: root fillets, which no contour of a flange describes
    leaning: tuple[Lump, ...] = ()  #: beside edges that do not go square through their wall
    volume: float = 0.0  #: mm3 of the body

    @property
    def off(self) -> float:
        """mm3 that the body has more than its part."""
        every = (*self.lumps, *self.fillets, *self.leaning)
        return sum(one.volume if one.more else -one.volume for one in every)

    def said(self, source: Source) -> tuple[Diagnostic, ...]:
        """The diagnostics of it."""
        if self.lumps:
            return (rules.UNEXPLAINED.at(source, found=_told(self.lumps)),)
        if sum(one.volume for one in self.fillets) > GROSS * self.volume > 0.0:
            share = f"{100 * GROSS:g}"
            return (rules.ROOT_CUT.at(source, found=_told(self.fillets), share=share),)
        pairs = (rules.ROOT_FILLET, self.fillets), (rules.LEANING, self.leaning)
        return tuple(rule.at(source, found=_told(found)) for rule, found in pairs if found)


def differences(shaped: Shaped, body: Shell, stock: Shape, slack: float) -> Differences:
    """What of a body, in the part's place, is not explained by its part.

    `stock` is the section that the body was cut from, in (Y, Z), with the facets that it has there.
    Surfaces may be `slack` mm off. Raises Unreadable if the part has no solid.
    """
    part = part_of(shaped)
    try:
        least, most = (part_solid(part, margins) for margins in _margins(part, stock, slack))
    except BeamcamError as reason:
        raise Unreadable(str(reason.diagnostics[0])) from reason
    solid = solid_of(body)
    if solid is not None:
        apart = [(True, solid - most), (False, least - solid)]
        volume = float(solid.volume())
    else:
        apart, volume = [*_by_stations(body, least, most, slack)], section_area(body)
    check_member()
    arcs = _arcs(part)
    found = [
        lump
        for more, shape in apart
        for piece in shape.decompose()
        if piece.volume() > MIN_LUMP and not _is_of_facets(piece, arcs)
        for lump in _by_face(piece, more, part, shaped.section)
    ]
    found = sorted(_joined(found), key=lambda one: -one.volume)
    fillets = tuple(one for one in found if one.face == FILLET)
    leaning = tuple(one for one in found if one.leans)
    if sum(one.volume for one in leaning) > GROSS * volume:
        leaning = ()  # too much for a cut whose edge leans
    rest = tuple(one for one in found if one not in fillets and one not in leaning)
    kinds = [
        kind if sum(one.volume for one in kind) > BOUND else () for kind in (rest, fillets, leaning)
    ]
    return Differences(*kinds, volume)


def section_said(shaped: Shaped, stock: BareStock, source: Source) -> tuple[Diagnostic, ...]:
    """Whether the section that a body was cut from is the one that its part holds.

    Of open sections rounded toes and missing fillets count, but not slopes about the thickness
    that is given. Of others no figure of a part gives the inner roundings and the lips.
    """
    section, area, expected = shaped.section, stock.area, shaped.section.area
    if section.code in ("I", "U", "L", "T"):
        drawn = outline(part_of(shaped))
        more, less = (
            float(one.buffer(-FILM).buffer(FILM).area)
            for one in (stock.shape.difference(drawn), drawn.difference(stock.shape))
        )
        s = section
        sizes = s.height, s.width, s.flange_thickness, s.web_thickness, s.radius
        expected = area_by_measures(s.code, *sizes)
        area = expected + more - less
    if abs(area - expected) <= SECTION_SLACK * area:
        return ()
    found, by_measures = (f"{v / 100:.2f}" for v in (area, expected))
    return (rules.SECTION_AREA.at(source, found=found, expected=by_measures),)


def part_of(shaped: Shaped) -> Part:
    """The part of a member without its names."""
    section = shaped.section
    return Part(
        mark="", profile=section.profile(""), length=shaped.length, source=Source(""),
        cuts=shaped.cuts, features=shaped.features, section=section.points,
    )  # fmt: skip


def _margins(part: Part, stock: Shape, slack: float) -> Iterator[Margins]:
    """Of the least steel and of the most; the lips of a channel, which no part holds, may be there."""
    sections = stock, stock
    if part.profile.code == "C":
        drawn = outline(part)
        sections = stock.intersection(drawn), stock.union(drawn)
    for off, shape in zip((slack, -slack), sections, strict=True):
        yield Margins(
            lambda _, off=off: off, depth=off, end=off, outline=off, skin=off, section=shape,
            square_below=0.0,
        )  # fmt: skip


def solid_of(body: Shell) -> "Manifold | None":
    """A shell as a solid; None where its faces do not close one."""
    m = kernel()
    points, places = np.unique(body.points.round(WELDED) + 0.0, axis=0, return_inverse=True)
    corners = places.reshape(-1)[_triangles(body)]
    a, b, c = corners.T
    corners = corners[(a != b) & (b != c) & (c != a)]
    found = m.Manifold(m.Mesh64(np.ascontiguousarray(points), corners.astype(np.uint64)))
    if found.status() == m.Error.NoError and found.volume() < 0.0:
        corners = corners[:, ::-1]
        found = m.Manifold(
            m.Mesh64(np.ascontiguousarray(points), np.ascontiguousarray(corners.astype(np.uint64)))
        )
    return None if found.status() != m.Error.NoError or found.is_empty() else found


def _triangles(body: Shell) -> Any:
    """The corners of triangles that the faces of a shell are made of, counter-clockwise."""
    rings = body.rings
    sizes = np.bincount(rings.ring, minlength=len(rings.face))
    counts = np.bincount(rings.face)  # of the rings of each face
    plain = (counts[rings.face] == 1) & (sizes == 3)
    found = [rings.start[plain][:, None] + np.arange(3)]
    odd = np.flatnonzero(~plain)
    for face in np.unique(rings.face[odd]).tolist():
        normal = body.area_normals[face]
        drop = int(np.abs(normal).argmax())
        u, v = ((1, 2), (2, 0), (0, 1))[drop]
        places, flat = [], []
        for k, ring in enumerate(np.flatnonzero(rings.face == face).tolist()):
            here = np.arange(rings.start[ring], rings.start[ring] + sizes[ring])
            x, y = body.points[here][:, (u, v)].T
            left = float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) * normal[drop] > 0
            if k and left:
                here = here[::-1]  # hollows run the other way
            places.append(here)
            flat.append(
                np.ascontiguousarray(body.points[here][:, (u, v)] * (1.0, np.sign(normal[drop])))
            )
        found.append(np.concatenate(places)[kernel().triangulate(flat)])
    return np.concatenate(found)


def _by_stations(
    body: Shell, least: "Manifold", most: "Manifold", slack: float
) -> "Iterator[tuple[bool, Manifold]]":
    """As the differences of two solids, of a body that is none: by sections across.

    They lie between all x at which body or part change their form.
    """
    parts = [one.transform(ACROSS) for one in (least, most)]
    events = [body.points[:, 0], *(one.to_mesh64().vert_properties[:, 2] for one in parts)]
    for x0, x1 in _stretches(np.concatenate(events)):
        check_member()
        x = (x0 + x1) / 2
        theirs = across(body, x)
        low, high = (_section(one, x) for one in parts)
        for more, shape in ((True, theirs.difference(high)), (False, low.difference(theirs))):
            yield more, prism(shape.buffer(-slack).buffer(slack), x0, x1, SECTIONS)


def _stretches(events: Any) -> list[tuple[float, float]]:
    """The stretches between some x, the longest if there are too many."""
    marks = np.unique(events.round(4))
    edges = np.array([m for i, m in enumerate(marks) if i == 0 or m - marks[i - 1] > NEAR_EVENTS])
    chosen = np.sort(np.argsort(-np.diff(edges), kind="stable")[:MOST_STATIONS])
    return [(float(edges[k]), float(edges[k + 1])) for k in chosen.tolist()]


def across(body: Shell, x: float) -> Shape:
    """The body's section at x, in (Y, Z)."""
    return section(body, (x, 0.0, 0.0), ALONG, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _section(solid: "Manifold", x: float) -> Shape:
    from shapely import Polygon, union_all

    shape = union_all([])
    for ring in solid.slice(x).to_polygons():
        shape = shape.symmetric_difference(Polygon(ring).buffer(0))
    return shape


def section_area(body: Shell) -> float:
    """mm3 of a body by its sections, which crossings measure even where faces lie twice."""
    stretches = _stretches(body.points[:, 0])
    return sum(float(across(body, (x0 + x1) / 2).area) * (x1 - x0) for x0, x1 in stretches)


def _by_face(piece: "Manifold", more: bool, part: Part, of: Section) -> Iterator[Lump]:
    """The steel of a lump by the walls that it lies in, and beside them."""
    walls = sorted(walls_of(of), key=lambda wall: wall.normal == "z")
    for wall in walls:
        box = prism(
            rectangle(-FAR, -WALL_SLACK, FAR, wall.width + WALL_SLACK),
            wall.low - WALL_SLACK, wall.high + WALL_SLACK, _frame(wall),
        )  # fmt: skip
        inside, piece = piece.split(box)
        if inside.volume() > MIN_LUMP:
            yield _lump(inside, wall.face, more, _leans(inside, more, wall, part))
    if piece.volume() > MIN_LUMP:
        face = (
            _face_beside(piece, walls, of) if walls else ("the section" if of.code == "SO" else "v")
        )
        yield _lump(piece, face, more, False)


FAR = 1e6  #: mm


def _lump(piece: "Manifold", face: str, more: bool, leans: bool) -> Lump:
    box = piece.bounding_box()
    return Lump(face, float(box[0]), float(box[3]), float(piece.volume()), more, leans)


def _face_beside(piece: "Manifold", walls: Sequence[Wall], of: Section) -> str:
    """Where steel lies that is in no wall: in the fillets between two, or at none."""
    from shapely import box, union_all

    reach = of.radius + 0.01 * of.height
    fillets = union_all([
        box(a.low - reach, b.low - reach, a.high + reach, b.high + reach)
        for a in walls if a.normal == "y"
        for b in walls if b.normal == "z"
    ])  # fmt: skip
    inside = piece ^ prism(fillets, -FAR, FAR, SECTIONS)
    return FILLET if inside.volume() > piece.volume() / 2 else "no face"


def _frame(wall: Wall) -> Any:
    """Takes (x, q, c) of a wall to (x, y, z)."""
    along, first, second = (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)
    return (along, second, first) if wall.normal == "y" else (along, first, second)


def _leans(piece: "Manifold", more: bool, wall: Wall, part: Part) -> bool:
    """Whether a lump is what an edge leaves that does not go square through its wall.

    The part has the outline of both sides of the wall together, so that it may lack no more than
    what lies between its surface and the level at which it was looked at.
    """
    gone = _cut_of(wall, part)
    if gone.is_empty:
        return False

    def through(shape: Shape) -> "Manifold":
        return prism(shape, wall.low - FREE, wall.high + FREE, _frame(wall))

    if (piece ^ through(gone.buffer(BESIDE))).is_empty():
        return False
    if not more:
        far = piece - through(gone.buffer(LEAN_REACH * wall.thickness))
        return bool(far.volume() < MIN_LUMP)
    far = piece ^ through(gone.buffer(-LEVEL_REACH * wall.thickness))
    return bool((far + (piece - through(gone.buffer(BESIDE)))).volume() < MIN_LUMP)


def _cut_of(wall: Wall, part: Part) -> Shape:
    """What contours and their bevels take of a wall, in (x, q)."""
    from shapely import LineString, union_all

    inner = [shape_of(c.curves) for c in part.contours if c.face == wall.face and c.kind == "inner"]
    outer = [shape_of(c.curves) for c in part.contours if c.face == wall.face and c.kind == "outer"]
    if outer:
        whole = rectangle(0.0, 0.0, part.length, wall.width)
        inner.append(whole.difference(union_all(outer)))
    for contour in (c for c in part.contours if c.face == wall.face):
        for bevel in contour.bevels:
            wide = (wall.thickness - bevel.land) * tan(radians(abs(bevel.angle)))
            edge = contour.curves[bevel.curve]
            inner.append(LineString([edge.start, edge.end]).buffer(wide, cap_style="square"))
    return union_all(inner).buffer(-TOUCHING).buffer(TOUCHING)


def _arcs(part: Part) -> list[tuple[int, float, float, float]]:
    """The arcs of a part: the axis that they are across of (1 is y), centre (x, q) and radius."""
    found = []
    for f in part.features:
        axis = 1 if getattr(f, "face", "v") in ("o", "u") else 2
        if isinstance(f, Hole):
            found.append((axis, f.x, f.y, f.diameter / 2))
        elif isinstance(f, Slot):
            found += [(axis, x, y, f.diameter / 2) for x, y in slot_corners(f)]
        elif isinstance(f, Contour):
            found += [(axis, *c.centre, c.radius) for c in f.curves if isinstance(c, Arc)]
    return found


def _is_of_facets(piece: "Manifold", arcs: Sequence[tuple[int, float, float, float]]) -> bool:
    """Whether a lump lies between an arc of the part and the chords that a mesh has for it."""
    points = piece.to_mesh64().vert_properties
    thin = 2.0 * float(piece.volume()) / float(piece.surface_area())
    for axis, x, q, radius in arcs:
        rise = radius * (1.0 - cos(FACET_RAD / 2))
        if thin < rise:
            off = np.hypot(points[:, 0] - x, points[:, 3 - axis] - q)
            if off.min() > radius - rise - TOUCHING and off.max() < radius + TOUCHING:
                return True
    return False


def _joined(found: Sequence[Lump]) -> list[Lump]:
    """The lumps with those joined that follow one another on a face."""
    out: list[Lump] = []
    for one in sorted(found, key=lambda lump: lump.x0):
        for i, known in enumerate(out):
            same = (known.face, known.more, known.leans) == (one.face, one.more, one.leans)
            if same and one.x0 - known.x1 < 5.0:
                volume = known.volume + one.volume
                out[i] = Lump(
                    one.face, known.x0, max(one.x1, known.x1), volume, one.more, one.leans
                )
                break
        else:
            out.append(one)
    return out


def _told(found: Sequence[Lump]) -> str:
    text = "; ".join(map(str, found[:SHOWN]))
    more = len(found) - SHOWN
    return f"{text}; and {more} more" if more > 0 else text
