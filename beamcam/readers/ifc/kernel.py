"""Geometry kernel results for an element: a fine shell in mm, its surfaces, and the log."""

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import cached
from beamcam.geometry.array_types import Floats
from beamcam.geometry.polylines import polylines
from beamcam.readers.ifc.entities import Entity, Model, Unreadable, features_of
from beamcam.readers.ifc.profiles import spline_of
from beamcam.readers.ifc.shell import Shell, shell, vec
from beamcam.readers.ifc.space import Cylinder, cross, size, sub
from beamcam.system import interrupts_waiting

# --- references -----------------------------------------------------------------------------------
# References that the geometry kernel cannot follow: it ends the process over one that is missing.
#
# An attribute that the schema asks for stands for an entity of a class that the schema names there.


def broken_reference(file: Any, root: Any) -> str | None:
    """The first broken reference among all that an instance leads to; None if there is none.

    `file` and `root` are the kernel's own. What leads back to itself is not to be asked for.
    """
    from ifcopenshell import ifcopenshell_wrapper as wrapper

    schema = wrapper.schema_by_name(file.schema_identifier)
    known: dict[str, list[tuple[int, Any, Kinds]]] = {}
    for one in file.traverse(root):
        name = one.is_a()
        if name not in known:
            entity: Any = schema.declaration_by_name(name).as_entity()
            every = entity.all_attributes() if entity else ()
            rows = [(k, a, _kinds(a.type_of_attribute())) for k, a in enumerate(every)]
            known[name] = [row for row in rows if row[2][0] and not entity.derived()[row[0]]]
        for place, attribute, kinds in known[name]:
            value = one[place]
            missing = None if attribute.optional() else "missing"
            fault = missing if value is None else _fault(value, kinds)
            if fault is not None:
                return f"#{one.id()} {name} with {attribute.name()} {fault}"
    return None


#: The classes of entities that an attribute may refer to, and whether it takes nothing else.
Kinds = tuple[tuple[str, ...], bool]


def _kinds(kind: Any) -> Kinds:
    """Those of a type as ifcopenshell writes it: <list [2:?] of <entity IfcCartesianPoint>>."""
    text = str(kind)
    return tuple(re.findall(r"<entity (\w+)>", text)), not re.search("<(type|enumeration) ", text)


def _fault(value: Any, kinds: Kinds) -> str | None:
    """The fault of an attribute's value, if any."""
    classes, pure = kinds
    if isinstance(value, tuple):
        return next((fault for one in value if (fault := _fault(one, kinds))), None)
    if hasattr(value, "is_a") and (not value.id() or any(map(value.is_a, classes))):
        return None
    return "of another class" if pure or hasattr(value, "is_a") else None


CHORD = 0.0002  #: m between a curve and its facets
ANGLE = 0.25  #: rad between two facets, 26 on a circle; every vertex lies on the curve
FINE_CHORD = 0.0001  #: m, of solids that parts are held against
FINE = {"mesher-linear-deflection": FINE_CHORD}  #: settings for closer facets than a reading needs
#: Of a tube with cuts, whose facets the kernel makes wider than it is asked for.
FINEST = {**FINE, "mesher-angular-deflection": ANGLE / 3}
#: Likewise, before anything was cut off.
STOCK = {**FINE, "disable-boolean-result": True, "disable-opening-subtractions": True}
#: Names of a solid's mesh, since ifcopenshell 0.9 and before.
FACETED = ("triangulation_element", "TriangulationElement")
SPLINE_CHORD = 0.01  #: mm between a spline and the polyline that the kernel has for it
ON_IT = 1e-6  #: mm between a cylinder and the corners that are on it
BENT = 1e-6  #: between two unit normals of a facet that stands for a curved surface
MIN_CORNERS = 4
ROUNDER = 0.9999  #: of a slot's corner radius that the kernel can build; half the side it cannot


class Built(Struct, frozen=True):
    """A shell in the element's coordinates and what the kernel wrote while making it."""

    shell: Shell
    error: str | None  #: the first one that it wrote
    volume: float = 0.0  #: mm3 of the solid itself, not of its facets
    others: tuple[str, ...] = ()  #: what is said of curved faces that only facets stand for


def built(model: Model, element: Entity, own: Mapping[str, Any] = FINE) -> Built:
    """The kernel's solid of an element, openings taken off, with the cylinders that it has.

    The corners of the shell's facets lie on the solid's surfaces. `settings` are settings of the
    kernel beside its usual ones. Raises Unreadable if it has none.
    """
    solid = _solid(model, element, own)
    wrapper = _kernel().ifcopenshell_wrapper
    made = next(getattr(wrapper, name) for name in FACETED if hasattr(wrapper, name))
    try:
        mesh = made(solid)  # its geometry lives as long as it does
    except RuntimeError as fault:
        raise Unreadable(f"no solid by the kernel ({fault})") from fault
    corners = np.frombuffer(mesh.geometry.faces_buffer, np.int32)
    points = np.frombuffer(mesh.geometry.verts_buffer).reshape(-1, 3)[corners] * 1e3
    normals = np.frombuffer(mesh.geometry.normals_buffer).reshape(-1, 3)[corners]
    count = len(corners) // 3
    mesh = shell(points, [3] * count, range(count))
    if mesh.count < 4:
        raise Unreadable("an empty solid by the kernel")
    cylinders, others = _cylinders(points.reshape(-1, 3, 3), normals.reshape(-1, 3, 3))
    volume = float(solid.volume) * 1e9
    return Built(replace(mesh, cylinders=cylinders), _error(), volume, others)


def _cylinders(facets: Floats, normals: Floats) -> tuple[tuple[Cylinder, ...], tuple[str, ...]]:
    """The cylinders that facets (n, 3, 3) lie on, and what is said of other curved surfaces.

    The kernel's normals are those of its surfaces. Two points of a cylinder and their normals tell
    it: the points are as far apart as the normals, times the radius. A facet of a cone has a side
    along it, where the normal is one and the same; such a side of another surface that is swept
    runs square to all normals.
    """
    size = np.linalg.norm(normals, axis=2, keepdims=True)
    normals = normals / np.maximum(size, 1e-300)
    ways, sides = (one - np.roll(one, 1, axis=1) for one in (normals, facets))
    apart = (ways * ways).sum(axis=2)
    # The tip of a cone has no normal.
    bent = np.flatnonzero((apart.max(axis=1) > BENT * BENT) & (size.min(axis=(1, 2)) > 0.0))
    bent = bent[np.argsort(-apart[bent].max(axis=1), kind="stable")]
    at = bent, apart[bent].argmax(axis=1)  # where the normals are furthest apart
    axes = np.cross(normals[at[0], at[1] - 1], normals[at])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    radii = (sides[at] * ways[at]).sum(axis=1) / apart[at]
    middles = facets[at] - radii[:, None] * normals[at]
    middles -= (middles * axes).sum(axis=1)[:, None] * axes  # nearest to the zero point
    axes *= np.sign(axes[np.arange(len(axes)), np.abs(axes).argmax(axis=1)])[:, None]
    off = np.linalg.norm(np.cross(facets[bent] - middles[:, None], axes[:, None]), axis=2)
    round_ = (np.abs(off - np.abs(radii)[:, None]) < ON_IT).all(axis=1)
    rows = np.column_stack((middles, axes, np.abs(radii).round(9)))[round_]
    _, first = np.unique(rows.round(5) + 0.0, axis=0, return_index=True)
    every = [Cylinder(vec(row[:3]), vec(row[3:6]), float(row[6])) for row in rows[np.sort(first)]]
    points = np.unique(facets.reshape(-1, 3), axis=0)
    fitting = [one for one in every if np.count_nonzero(one.off(points) < ON_IT) >= MIN_CORNERS]
    kept = tuple(one for one in fitting if not any(_blunted(one, other) for other in fitting))
    along = np.abs((sides[bent] * axes[:, None]).sum(axis=2))
    lengths = np.linalg.norm(sides[bent], axis=2)
    cone = ((apart[bent] < BENT * BENT) & (along < (1.0 - BENT) * lengths)).any(axis=1)
    return kept, ("a curved surface of another form",) if (~round_ & ~cone).any() else ()


@cached("ifc.kernel")
def _kernel() -> Any:
    """ifcopenshell with its geometry kernel. An interrupt waits, as in `parser`."""
    with interrupts_waiting():
        import ifcopenshell.geom
    return ifcopenshell


def _solid(model: Model, element: Entity, own: Mapping[str, Any]) -> Any:
    """The kernel's solid of an element. Raises Unreadable."""
    openings = features_of(element, "openings")
    try:
        roots = [root for each in (element, *openings) for root in each.values[5:7] if root]
        used = [one for root in roots for one in root.below()]
    except RecursionError:
        raise Unreadable("geometry that contains itself") from None
    geom, wrapper = _kernel().geom, _kernel().ifcopenshell_wrapper
    settings = geom.settings()
    settings.set("iterator-output", wrapper.NATIVE)
    settings.set("mesher-linear-deflection", CHORD)
    settings.set("mesher-angular-deflection", ANGLE)
    settings.set("weld-vertices", False)  # which would leave out the normals
    for name, value in own.items():
        settings.set(name, value)
    file = model.file.opened
    try:
        instances = [file.by_id(each.number) for each in (element, *openings)]
    except RuntimeError as fault:
        raise Unreadable(f"no element by the kernel ({fault})") from fault
    for root in (root for one in instances for root in (one.Representation, one.ObjectPlacement)):
        if root is not None and (broken := broken_reference(file, root)) is not None:
            raise Unreadable(f"a broken reference ({broken})")
    if _is_in_itself(instances[0]):
        raise Unreadable("an assembly that contains itself")
    _make_buildable(model, file, used)
    _error()  # what earlier solids left
    try:
        return geom.create_shape(settings, instances[0], geometry_library="opencascade")
    except RuntimeError as fault:
        raise Unreadable(f"no solid by the kernel ({fault})") from fault


def _is_in_itself(instance: Any) -> bool:
    """Whether an element is a part of its own assembly, whose placement the kernel never finds."""
    seen: set[int] = set()
    while instance is not None and instance.id() not in seen:
        seen.add(instance.id())
        above = [relation.RelatingObject for relation in getattr(instance, "Decomposes", ())]
        instance = above[0] if above else None
    return instance is not None


def _error() -> str | None:
    """The first error that the kernel wrote since the last call."""
    lines = str(_kernel().get_log()).splitlines()
    return next((line[:160] for line in lines if "[error]" in line.lower()), None)


def _blunted(a: Cylinder, b: Cylinder) -> bool:
    """Whether two cylinders are one end of a slot that was made a hair less round.

    Their radius is not the slot's, so that a circle fitted to both is nearer to it than they are.
    """
    apart = 2 * a.radius * (1 / ROUNDER - 1)
    off = size(cross(sub(a.point, b.point), a.axis))
    return abs(off - apart) < 0.01 * apart and abs(a.radius - b.radius) < 0.01 * apart


def _make_buildable(model: Model, file: Any, entities: Iterable[Entity]) -> None:
    """Make what the kernel cannot build a little different, in the file that it has open.

    Rounded rectangles whose radius is half of a side become a hair less round, as slots as round
    as they are it leaves out of the solid without an error to its caller. The flanges of a Z, which
    it draws from the middle of the web, begin at its back (DIN 1027). Splines of outlines, of which
    it makes nothing, become polylines.
    """
    for entity in entities:
        if entity.is_a("IfcRoundedRectangleProfileDef"):
            profile = file.by_id(entity.number)
            most = min(profile.XDim, profile.YDim) / 2 * ROUNDER
            profile.RoundingRadius = min(profile.RoundingRadius, most)
        elif entity.is_a("IfcZShapeProfileDef"):
            profile = file.by_id(entity.number)
            profile.FlangeWidth = entity.FlangeWidth - entity.WebThickness / 2
        elif entity.is_a("IfcBSplineCurve") and len(entity.values[1][0]) == 2:
            spline = file.by_id(entity.number)
            points = polylines((spline_of(model, entity),), SPLINE_CHORD).points / model.mm
            line = file.create_entity("IfcPolyline", [
                file.create_entity("IfcCartesianPoint", tuple(p)) for p in points.tolist()
            ])  # fmt: skip
            for owner in file.get_inverse(spline):
                # The reader has its own values of it before, which stay as they are written.
                assert model.file.entity(owner.id()).values
                for k, value in enumerate(owner):
                    if value == spline:
                        owner[k] = line
                    elif isinstance(value, tuple) and spline in value:
                        owner[k] = [line if one == spline else one for one in value]
