"""What the geometry kernel builds of an element: a fine shell in mm, its surfaces, and the log."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from msgspec import Struct

from beamcam.readers.ifc.brep import BrepError, surfaces_of
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.shell import Face3, Shell, planar_face
from beamcam.readers.ifc.space import Vec, cross, size, sub
from beamcam.readers.ifc.surfaces import Cylinder, Unnamed

CHORD = 0.0002  #: m between a curve and its facets
ANGLE = 0.25  #: rad between two facets, 26 on a circle; every vertex lies on the curve
ROUNDER = 0.9999  #: of a slot's corner radius that the kernel can build; half the side it cannot


class Built(Struct, frozen=True):
    """A shell in the element's coordinates and what the kernel said while making it."""

    shell: Shell
    log: tuple[str, ...]


class Exact(Struct, frozen=True):
    """The cylinders of a solid, the names of its other curved faces, and the kernel's log."""

    cylinders: tuple[Cylinder, ...]
    others: tuple[str, ...]
    log: tuple[str, ...]


def build(model: Model, element: Entity) -> Built:
    """The kernel's solid of an element, openings taken off. Raises Unreadable if it has none."""
    shape, log = _shape(
        model,
        element,
        {
            "mesher-linear-deflection": CHORD,
            "mesher-angular-deflection": ANGLE,
            "weld-vertices": True,
        },
    )
    geometry = shape.geometry
    verts, faces = geometry.verts, geometry.faces
    points: list[Vec] = [
        (verts[i] * 1e3, verts[i + 1] * 1e3, verts[i + 2] * 1e3) for i in range(0, len(verts), 3)
    ]
    found: list[Face3] = []
    for i in range(0, len(faces), 3):
        face = planar_face([[points[faces[i]], points[faces[i + 1]], points[faces[i + 2]]]])
        if face is not None:
            found.append(face)
    if len(found) < 4:
        raise Unreadable("an empty solid by the kernel")
    return Built(Shell(tuple(found)), log)


def build_exact(model: Model, element: Entity) -> Exact:
    """The surfaces of the same solid. Raises Unreadable if the kernel has none."""
    from ifcopenshell import ifcopenshell_wrapper

    wrapper: Any = ifcopenshell_wrapper
    shape, log = _shape(model, element, {"iterator-output": wrapper.SERIALIZED})
    try:
        surfaces = surfaces_of(shape.geometry.brep_data)
    except BrepError as fault:
        raise Unreadable(f"a solid by the kernel that is not understood ({fault})") from fault
    cylinders = [s for s in surfaces if isinstance(s, Cylinder)]
    kept = tuple(c for c in cylinders if not any(_blunted(c, other) for other in cylinders))
    others = sorted({s.kind for s in surfaces if isinstance(s, Unnamed)})
    return Exact(kept, tuple(others), log)


def _shape(model: Model, element: Entity, wanted: Mapping[str, Any]) -> tuple[Any, tuple[str, ...]]:
    """The kernel's shape of an element under some settings, and the log. Raises Unreadable."""
    import ifcopenshell
    import ifcopenshell.geom

    openings = [r.RelatedOpeningElement for r in getattr(element, "HasOpenings", None) or ()]
    if any(contains_itself(each) for each in (element, *openings)):
        raise Unreadable("geometry that contains itself")
    geom: Any = ifcopenshell.geom
    settings = geom.settings()
    for name, value in wanted.items():
        settings.set(name, value)
    file = _file_of(model)
    kernel: Any = ifcopenshell
    kernel.get_log()  # what earlier shapes left
    with _buildable_slots(file):
        try:
            shape: Any = geom.create_shape(
                settings, file.by_id(element.id()), geometry_library="opencascade"
            )
        except RuntimeError as fault:
            raise Unreadable(f"no solid by the kernel ({fault})") from fault
    log = tuple(line for line in str(kernel.get_log()).splitlines() if line.strip())
    return shape, log


def contains_itself(element: Entity) -> bool:
    """Whether what an element refers to leads back to itself.

    The kernel follows such references until the process dies, so it is never given any.
    """
    open_, done = set[Entity](), set[Entity]()
    stack: list[tuple[Any, bool]] = [(element, False)]
    while stack:
        entity, leave = stack.pop()
        key = entity
        if leave:
            open_.discard(key)
            done.add(key)
        elif key in open_:
            return True
        elif key not in done:
            open_.add(key)
            stack.append((entity, True))
            stack += [(each, False) for each in _referred(entity.values)]
    return False


def _referred(values: tuple[Any, ...]) -> Iterator[Any]:
    """The entities with a number of their own among attribute values, lists in lists included."""
    for value in values:
        if isinstance(value, tuple):
            yield from _referred(value)
        elif isinstance(value, Entity):
            yield value


def _file_of(model: Model) -> Any:
    """The model as the kernel reads it, once. Raises Unreadable if it does not."""
    import ifcopenshell

    if not model.kernel:
        try:
            model.kernel.append(ifcopenshell.file.from_string(model.data.decode("latin-1")))
        except Exception as fault:  # the parser's own errors have no class of their own
            raise Unreadable(f"a file that the kernel does not read ({fault})") from fault
    return model.kernel[0]


def _blunted(a: Cylinder, b: Cylinder) -> bool:
    """Whether two cylinders are one end of a slot that was made a hair less round.

    Their radius is not the slot's, so that a circle fitted to both is nearer to it than they are.
    """
    apart = 2 * a.radius * (1 / ROUNDER - 1)
    off = size(cross(sub(a.frame.o, b.frame.o), a.axis))
    return abs(off - apart) < 0.01 * apart and abs(a.radius - b.radius) < 0.01 * apart


@contextmanager
def _buildable_slots(file: Any) -> Iterator[None]:
    """Rounded rectangles whose radius is half of a side, a hair less round for the while.

    The kernel leaves such slots out of the solid without an error to its caller.
    """
    changed = []
    for profile in file.by_type("IfcRoundedRectangleProfileDef"):
        radius = profile.RoundingRadius
        if radius >= min(profile.XDim, profile.YDim) / 2 * ROUNDER:
            changed.append((profile, radius))
            profile.RoundingRadius = min(profile.XDim, profile.YDim) / 2 * ROUNDER
    try:
        yield
    finally:
        for profile, radius in changed:
            profile.RoundingRadius = radius
