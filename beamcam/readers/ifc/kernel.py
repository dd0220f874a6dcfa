"""Geometry kernel results for an element: a fine shell in mm, its surfaces, and the log."""

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import cached
from beamcam.geometry.polylines import polylines
from beamcam.readers.ifc.brep import BrepError, Cylinder, surfaces_of
from beamcam.readers.ifc.curves2d import spline_of
from beamcam.readers.ifc.entities import Entity, Model, Unreadable, features_of
from beamcam.readers.ifc.shell import Shell, shell
from beamcam.readers.ifc.space import cross, size, sub
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
            entity = schema.declaration_by_name(name).as_entity()
            every = zip(entity.all_attributes(), entity.derived(), strict=True) if entity else ()
            rows = [
                (place, attribute, _kinds(attribute.type_of_attribute()))
                for place, (attribute, derived) in enumerate(every)
                if not derived
            ]
            known[name] = [row for row in rows if row[2][0]]
        for place, attribute, kinds in known[name]:
            value = one[place]
            fault = _fault(value, kinds)
            if value is None:
                fault = None if attribute.optional() else "missing"
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
FACETED = ("triangulation_element", "TriangulationElement")  #: since ifcopenshell 0.9, and before
WRITTEN = ("serialized_element", "SerializedElement")
SPLINE_CHORD = 0.01  #: mm between a spline and the polyline that the kernel has for it
ON_IT = 1e-6  #: mm between a cylinder and the corners that are on it
MIN_CORNERS = 4
ROUNDER = 0.9999  #: of a slot's corner radius that the kernel can build; half the side it cannot


class Built(Struct, frozen=True):
    """A shell in the element's coordinates and what the kernel said while making it."""

    shell: Shell
    log: tuple[str, ...]
    volume: float = 0.0  #: mm3 of the solid itself, not of its facets
    others: tuple[str, ...] = ()  #: names of curved faces that are no cylinders, if they were asked


def build(model: Model, element: Entity) -> Built:
    """The kernel's solid of an element, openings taken off, in closer facets than a reading needs.

    Raises Unreadable if it has none.
    """
    return _built(_solid(model, element, {"mesher-linear-deflection": FINE_CHORD}))


def build_stock(model: Model, element: Entity) -> Built:
    """As `build`, before anything was cut off. Raises Unreadable."""
    asked = {
        "mesher-linear-deflection": FINE_CHORD,
        "disable-boolean-result": True,
        "disable-opening-subtractions": True,
    }
    return _built(_solid(model, element, asked))


def build_both(model: Model, element: Entity) -> Built:
    """The kernel's solid of an element with the cylinders that it has. Raises Unreadable."""
    solid = _solid(model, element)
    built = _built(solid)
    written = _made(WRITTEN, solid)
    try:
        every, others = surfaces_of(written.geometry.brep_data)
    except BrepError as fault:
        raise Unreadable(f"a solid by the kernel that is not understood ({fault})") from fault
    points = np.unique(built.shell.points, axis=0)
    cylinders = [one for one in every if np.count_nonzero(one.off(points) < ON_IT) >= MIN_CORNERS]
    kept = tuple(c for c in cylinders if not any(_blunted(c, other) for other in cylinders))
    shell = replace(built.shell, cylinders=kept)
    return replace(built, shell=shell, log=(*built.log, *_log()), others=others)


def _built(solid: Any) -> Built:
    """A solid by its mesh, whose corners lie on its surfaces. Raises Unreadable."""
    mesh = _made(FACETED, solid)  # its geometry lives as long as it does
    points = np.frombuffer(mesh.geometry.verts_buffer).reshape(-1, 3) * 1e3
    corners = np.frombuffer(mesh.geometry.faces_buffer, np.int32)
    count = len(corners) // 3
    found = shell(points[corners], [3] * count, range(count))
    if found.count < 4:
        raise Unreadable("an empty solid by the kernel")
    return Built(found, _log(), float(solid.volume) * 1e9)


@cached("ifc.kernel")
def _kernel() -> Any:
    """The module of the geometry kernel.

    An interrupt waits until it is loaded: ifcopenshell's own code would swallow it.
    """
    with interrupts_waiting():
        import ifcopenshell.geom
    return ifcopenshell


def _made(form: tuple[str, str], solid: Any) -> Any:
    """A solid in another form, by either name of its class. Raises Unreadable."""
    wrapper = _kernel().ifcopenshell_wrapper
    name = form[0] if hasattr(wrapper, form[0]) else form[1]
    try:
        return getattr(wrapper, name)(solid)
    except RuntimeError as fault:
        raise Unreadable(f"no solid by the kernel ({fault})") from fault


def _solid(model: Model, element: Entity, asked: Mapping[str, Any] | None = None) -> Any:
    """The kernel's solid of an element, with settings of its own. Raises Unreadable."""
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
    settings.set("weld-vertices", True)
    for name, value in (asked or {}).items():
        settings.set(name, value)
    file = load(model)
    instances = [_instance(file, each) for each in (element, *openings)]
    if _is_in_itself(instances[0]):
        raise Unreadable("an assembly that contains itself")
    _make_buildable(model, file, used)
    _log()  # what earlier solids left
    try:
        return geom.create_shape(settings, instances[0], geometry_library="opencascade")
    except RuntimeError as fault:
        raise Unreadable(f"no solid by the kernel ({fault})") from fault


def _instance(file: Any, element: Entity) -> Any:
    """The kernel's own of an element. Raises Unreadable if it cannot follow its references."""
    try:
        instance = file.by_id(element.id())
    except RuntimeError as fault:
        raise Unreadable(f"no element by the kernel ({fault})") from fault
    for root in (instance.Representation, instance.ObjectPlacement):
        broken = None if root is None else broken_reference(file, root)
        if broken is not None:
            raise Unreadable(f"a broken reference ({broken})")
    return instance


def _is_in_itself(instance: Any) -> bool:
    """Whether an element is a part of its own assembly, whose placement the kernel never finds."""
    seen: set[int] = set()
    while instance is not None and instance.id() not in seen:
        seen.add(instance.id())
        above = [relation.RelatingObject for relation in getattr(instance, "Decomposes", ())]
        instance = above[0] if above else None
    return instance is not None


def _log() -> tuple[str, ...]:
    """Kernel messages since the last call."""
    return tuple(line for line in str(_kernel().get_log()).splitlines() if line.strip())


def load(model: Model) -> Any:
    """The file as ifcopenshell has it open, with its geometry kernel at hand."""
    _kernel()
    return model.file.opened


def _blunted(a: Cylinder, b: Cylinder) -> bool:
    """Whether two cylinders are one end of a slot that was made a hair less round.

    Their radius is not the slot's, so that a circle fitted to both is nearer to it than they are.
    """
    apart = 2 * a.radius * (1 / ROUNDER - 1)
    off = size(cross(sub(a.frame.o, b.frame.o), a.axis))
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
            profile = file.by_id(entity.id())
            most = min(profile.XDim, profile.YDim) / 2 * ROUNDER
            if profile.RoundingRadius > most:
                profile.RoundingRadius = most
        elif entity.is_a("IfcZShapeProfileDef"):
            wide = entity.FlangeWidth - entity.WebThickness / 2
            file.by_id(entity.id()).FlangeWidth = wide
        elif entity.is_a("IfcBSplineCurve") and len(entity.values[1][0]) == 2:
            spline = file.by_id(entity.id())
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
