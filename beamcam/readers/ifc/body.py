"""The Body of an element: the profile that is swept, and what is subtracted from it.

    IfcBooleanResult            -> the first operand's body, with the second as a cutter
    IfcMappedItem               -> the body of its source, mapped
    IfcRelVoidsElement          -> cutters, openings and voiding features alike

Everything is in the element's own coordinates, in mm; the element's placement only says where in
the building it is, and its large numbers are kept out.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from math import copysign, hypot
from operator import itemgetter

import numpy as np
from msgspec import Struct

from beamcam.geometry.curves import Arc
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.cutters import Combined, Cutter, HalfSpace, Prism, hole_of
from beamcam.readers.ifc.entities import Coordinates, Entity, Model, Unreadable, features_of, ratios
from beamcam.readers.ifc.profiles import Outline, chain_of, definition, outline_of, rounded_box
from beamcam.readers.ifc.shell import Shell, moved, shell
from beamcam.readers.ifc.space import IDENTITY, Frame, Vec, cross, dot, scale, unit

#: Identifiers of a representation that holds the solid, the best first.
_BODIES = {"Body": 0, None: 1, "": 2, "Facetation": 3, "Body-FallBack": 4}
_SKIPPED = ("Axis", "BoundingBox", "Box", "FootPrint", "Profile", "CoG", "Clearance")
_FLAT_TYPES = ("Curve2D", "Curve3D", "Curve", "BoundingBox", "GeometricCurveSet", "Point")


class Swept(Struct, frozen=True, gc=False):
    """A profile pushed along a vector; the profile lies in the plane of `frame`."""

    profile: Entity
    frame: Frame
    along: Vec


class Removed(Struct, frozen=True, gc=False):
    """A solid that is taken away; it stands in `frame`, in the element's coordinates."""

    item: Entity
    frame: Frame
    where: str | None = None  #: the GlobalId of its opening


class Body(Struct, frozen=True, gc=False):
    """Body of a member: one swept profile or one shell, and the solids subtracted from it."""

    base: Swept | Shell
    removed: tuple[Removed, ...]

    def cutters(self, model: Model, to: Frame) -> list[Cutter]:
        """What is taken away, in coordinates in which the element stands in `to`."""
        return [
            cutter
            for one in self.removed
            for cutter in solid_cutters(model, one.item, to.times(one.frame), one.where)
        ]


def body_of(model: Model, element: Entity) -> Body:
    """The body of an element with its openings. Raises Unreadable, which says what was found."""
    base, removed = _only(model, body_representation(element).values[3], IDENTITY, "a body")
    for opening in features_of(element, "openings"):
        frame, guid = relative_placement(model, element, opening), opening.guid
        if opening.values[6] is None:
            raise Unreadable(f"an opening {guid} without geometry")
        removed += [Removed(i, frame, guid) for i in body_representation(opening).values[3]]
    return Body(base, tuple(removed))


def body_representation(element: Entity) -> Entity:
    """The representation that holds the solid; its identifier is Body, or missing in old files."""
    shape = element.values[6]
    if shape is None:
        raise Unreadable("no geometry")
    solid: list[tuple[int, Entity]] = []
    for one in shape.values[2]:
        _, identifier, kind, items, *_ = one.values
        if items and identifier not in _SKIPPED and kind not in _FLAT_TYPES:
            solid.append((_BODIES.get(identifier, len(_BODIES)), one))
    if not solid:
        raise Unreadable("no solid geometry")
    return min(solid, key=itemgetter(0))[1]


def relative_placement(model: Model, element: Entity, other: Entity) -> Frame:
    """Placement of `other` in the coordinates of `element`."""
    mine, its = element.values[5], other.values[5]
    # Directly below the element the world's large numbers never come in.
    local = its is not None and mine is not None and its.is_a("IfcLocalPlacement")
    if local and its.values[0] is mine:
        return model.axes(its.values[1])
    return model.placement(mine).inverse().times(model.placement(its))


def _only(
    model: Model, items: tuple[Entity, ...], frame: Frame, what: str
) -> tuple[Swept | Shell, list[Removed]]:
    """As `_item` of the sole item of a representation."""
    solids = [_item(model, item, frame) for item in items]  # of several one may be bent
    if len(solids) != 1:
        raise Unreadable(f"{what} of {len(solids)} solids")
    return solids[0]


def _item(model: Model, item: Entity, frame: Frame) -> tuple[Swept | Shell, list[Removed]]:
    """What a representation item that stands in `frame` is made of, and what is taken from it."""
    kinds = item.type.kinds
    if item.type.name == "IfcExtrudedAreaSolid":
        profile, place, way, depth, *_ = item.values
        position = frame.times(model.axes(place))
        return Swept(profile, position, pushed(model, position, way, depth)), []
    if "IfcBooleanResult" in kinds:
        taken = []
        seen = set[Entity]()
        while "IfcBooleanResult" in item.type.kinds:
            if item in seen:
                raise Unreadable("geometry that contains itself")
            seen.add(item)
            operator, first, second, *_ = item.values
            if operator != "DIFFERENCE":
                raise Unreadable(f"a boolean {operator}")
            taken.append(Removed(second, frame))
            item = first
        base, removed = _item(model, item, frame)
        return base, removed + taken[::-1]
    if "IfcMappedItem" in kinds:
        inner, source = mapping(model, item, frame)
        return _only(model, source, inner, "a mapped body")
    if "IfcCsgSolid" in kinds:
        return _item(model, item.TreeRootExpression, frame)
    if not FACETED.isdisjoint(kinds):
        return shell_of(model, item, frame), []
    if (rule := BENT.get(item.type.name)) is not None and not _is_straight(item):
        raise Unreadable(item.type.name, rule, final=True)
    raise Unreadable(f"a solid by {item.type.name}")


#: Solids that no straight member has, and those of no single section.
BENT = {
    **dict.fromkeys(("IfcRevolvedAreaSolid", "IfcSurfaceCurveSweptAreaSolid", "IfcSweptDiskSolid",
                     "IfcFixedReferenceSweptAreaSolid", "IfcDirectrixCurveSweptAreaSolid",
                     "IfcSweptDiskSolidPolygonal"), rules.CURVED),
    **dict.fromkeys(("IfcExtrudedAreaSolidTapered", "IfcRevolvedAreaSolidTapered",
                     "IfcSectionedSpine", "IfcSectionedSolidHorizontal"), rules.TAPERED),
}  # fmt: skip


def _is_straight(item: Entity) -> bool:
    """Whether a solid is a disc or a ring that is swept along one line: a rod or a pipe."""
    if not item.is_a("IfcSweptDiskSolid"):
        return False
    line = item.Directrix
    return (line.is_a("IfcPolyline") and len(line.Points) == 2) or (
        line.is_a("IfcTrimmedCurve") and bool(line.BasisCurve.is_a("IfcLine"))
    )


# --- cutters --------------------------------------------------------------------------------------

FACETED = frozenset((
    "IfcFacetedBrep", "IfcTessellatedFaceSet", "IfcFaceBasedSurfaceModel",
    "IfcShellBasedSurfaceModel",
))  # fmt: skip
FAR = 1e6  #: mm beyond any member; how far the prism of a bounded half-space reaches
OFF_SQUARE = 2e-3  #: tangent of the angle by which a hole may be pushed off square


def mapping(model: Model, item: Entity, frame: Frame) -> tuple[Frame, tuple[Entity, ...]]:
    """The frame of a mapped item's source and the source's items."""
    source = item.values[0]
    target = model.operator(item.values[1])
    inner = frame.times(target).times(model.axes(source.values[0]))
    return inner, source.values[1].values[3]


def pushed(model: Model, position: Frame, way: Coordinates | None, depth: float) -> Vec:
    """The vector along which a profile is pushed that lies in the plane of `position`."""
    return position.vector(scale(unit(ratios(way) or (0.0, 0.0, 1.0)), depth * model.mm))


def solid_cutters(model: Model, item: Entity, frame: Frame, where: str | None) -> Sequence[Cutter]:
    """Cutters of a solid in `frame`."""
    kind, kinds = item.type.name, item.type.kinds
    if kind == "IfcExtrudedAreaSolid":
        return (_extrusion(model, item, frame, where),)
    if kind == "IfcHalfSpaceSolid":
        return (_half_space(model, item, frame, where),)
    if kind == "IfcPolygonalBoundedHalfSpace":
        half = _half_space(model, item, frame, where)
        position = frame.times(model.axes(item.Position))
        bound = Outline(chain_of(model, item.PolygonalBoundary))
        start = position.point((0.0, 0.0, -FAR))
        column = Frame(start, position.x, position.y, scale(position.z, 2 * FAR))
        return (Combined(half, (Prism(column, bound, where, hole_of(bound)),), False, where),)
    if kind == "IfcMappedItem":
        inner, source = mapping(model, item, frame)
        return [c for one in source for c in solid_cutters(model, one, inner, where)]
    if kind == "IfcCsgSolid":
        return solid_cutters(model, item.TreeRootExpression, frame, where)
    if "IfcBooleanResult" in kinds:
        first, second = (
            tuple(solid_cutters(model, one, frame, where))
            for one in (item.FirstOperand, item.SecondOperand)
        )
        if item.Operator == "UNION":
            return first + second
        if item.Operator == "DIFFERENCE":
            return [Combined(one, second, True, where) for one in first]
        return [Combined(one, (other,), False, where) for one in first for other in second]
    if kind in ("IfcRightCircularCylinder", "IfcBlock"):
        return (_primitive(model, item, frame, where),)
    if not FACETED.isdisjoint(item.type.kinds):
        return (shell_of(model, item, frame, where),)
    raise Unreadable(f"a cut by {kind}")


def _extrusion(model: Model, item: Entity, frame: Frame, where: str | None) -> Prism:
    profile, place, way, depth, *_ = item.values
    outline = outline_of(model, profile)
    hole = model.once("cut-out", definition(profile), hole_of, outline)
    at = frame.times(model.axes(place))
    upright = way is None or hypot(way[0], way[1]) <= OFF_SQUARE * abs(way[2])
    if not (at.even and upright):
        hole = None  # pushed off square or stretched it is no circle across its length
    return Prism(Frame(at.o, at.x, at.y, pushed(model, at, way, depth)), outline, where, hole)


def _half_space(model: Model, item: Entity, frame: Frame, where: str | None) -> HalfSpace:
    surface, agreement, *_ = item.values
    if not surface.is_a("IfcPlane"):
        raise Unreadable(f"a cut by a half-space over {surface.is_a()}")
    plane = frame.times(model.axes(surface.values[0]))
    # It goes with the directions in the plane, so that scales and mirrors are right. AgreementFlag
    # true: the half-space lies against the normal of its plane.
    normal = cross(plane.x, plane.y)
    side = copysign(1.0, dot(normal, plane.z)) * (-1.0 if agreement else 1.0)
    return HalfSpace(plane.o, unit(scale(normal, side)), where)


def _primitive(model: Model, item: Entity, frame: Frame, where: str | None) -> Prism:
    at, mm = frame.times(model.axes(item.Position)), model.mm
    if item.is_a("IfcBlock"):
        x, y, up = item.XLength * mm, item.YLength * mm, scale(at.z, item.ZLength * mm)
        block = Frame(at.point((x / 2, y / 2, 0.0)), at.x, at.y, up)
        return Prism(block, Outline(rounded_box(x, y, 0.0)), where)
    outline = Outline((Arc((0.0, 0.0), item.Radius * mm, 0.0, 360.0),))
    column = Frame(at.o, at.x, at.y, scale(at.z, item.Height * mm))
    return Prism(column, outline, where, hole_of(outline) if at.even else None)


# --- facets ---------------------------------------------------------------------------------------
# Faceted solids of IFC as shells: Breps, face sets and surface models, read without a kernel.

Ring = list[Vec]


def shell_of(model: Model, item: Entity, frame: Frame, where: str | None = None) -> Shell:
    """The shell of a faceted item that stands in `frame`, in mm. Raises Unreadable."""
    rings, faces = list[Ring](), list[int]()
    for face, around in enumerate(_faces(model, item)):
        rings += around
        faces += [face] * len(around)
    points = np.array(list(chain.from_iterable(rings))).reshape(-1, 3)
    solid = shell(moved(points, frame), [len(ring) for ring in rings], faces, where)
    if solid.count < 4:
        raise Unreadable(f"{item.is_a()} of {solid.count} faces")
    return solid


def _faces(model: Model, item: Entity) -> Iterator[list[Ring]]:
    if item.is_a("IfcFacetedBrepWithVoids"):
        raise Unreadable("a Brep with hidden voids")
    if item.is_a("IfcFacetedBrep"):
        return _shell_faces(model, (item.Outer,))
    if not item.is_a("IfcTessellatedFaceSet"):  # surface models, by their only value
        return _shell_faces(model, item.values[0])
    if item.is_a("IfcTriangulatedFaceSet"):
        return _indexed_faces(model, item, ((triangle,) for triangle in item.CoordIndex))
    if item.is_a("IfcPolygonalFaceSet"):
        rings = ((f.CoordIndex, *getattr(f, "InnerCoordIndices", ())) for f in item.Faces)
        return _indexed_faces(model, item, rings)
    raise Unreadable(f"a faceted solid by {item.is_a()}")


def _indexed_faces(
    model: Model, item: Entity, faces: Iterable[tuple[tuple[int, ...], ...]]
) -> Iterator[list[Ring]]:
    """Faces whose rings are places in the list of points, or in a list of such places."""
    points = [model.point((x, y, z)) for x, y, z in item.Coordinates.CoordList]
    table = getattr(item, "PnIndex", None)
    for rings in faces:
        yield [[points[(table[i - 1] if table else i) - 1] for i in ring] for ring in rings]


def _shell_faces(model: Model, shells: Iterable[Entity]) -> Iterator[list[Ring]]:
    for face in chain.from_iterable(one.CfsFaces for one in shells):
        if face.is_a("IfcFaceSurface") and not face.FaceSurface.is_a("IfcPlane"):
            raise Unreadable(f"a face on {face.FaceSurface.is_a()}")
        rings: list[Ring] = []
        for bound in face.Bounds:
            loop = bound.Bound
            if not loop.is_a("IfcPolyLoop"):
                raise Unreadable(f"a face bounded by {loop.is_a()}")
            place = 0 if bound.is_a("IfcFaceOuterBound") else len(rings)
            rings.insert(place, [model.point(p) for p in loop.Polygon])
        if rings:
            yield rings
