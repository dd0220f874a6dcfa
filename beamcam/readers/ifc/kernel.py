"""What the geometry kernel builds of an element: a fine shell in mm, and the kernel's log."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from msgspec import Struct

from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.shell import Face3, Shell, planar_face
from beamcam.readers.ifc.space import Vec

CHORD = 0.0002  #: m between a curve and its facets
ANGLE = 0.25  #: rad between two facets, 26 on a circle; every vertex lies on the curve
ROUNDER = 0.9999  #: of a slot's corner radius that the kernel can build; half the side it cannot


class Built(Struct, frozen=True):
    """A shell in the element's coordinates and what the kernel said while making it."""

    shell: Shell
    log: tuple[str, ...]


def build(model: Model, element: Entity) -> Built:
    """The kernel's solid of an element, openings taken off. Raises Unreadable if it has none."""
    import ifcopenshell
    import ifcopenshell.geom

    openings = [r.RelatedOpeningElement for r in getattr(element, "HasOpenings", None) or ()]
    if any(contains_itself(each) for each in (element, *openings)):
        raise Unreadable("geometry that contains itself")
    geom: Any = ifcopenshell.geom
    settings = geom.settings()
    settings.set("mesher-linear-deflection", CHORD)
    settings.set("mesher-angular-deflection", ANGLE)
    settings.set("weld-vertices", True)
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
