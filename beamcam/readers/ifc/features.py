"""Holes, slots and contours of a part: made of outlines, moved, and each listed once."""

from collections.abc import Sequence
from typing import TypeVar

from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.geometry.curves import Curve
from beamcam.model.part import (
    MIRRORED_FACES,
    Bevel,
    Contour,
    Hole,
    Slot,
)
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.outline import Round, Slotted, shape_of
from beamcam.readers.ifc.section import Wall

Shifted = TypeVar("Shifted", bound=Hole | Slot | Contour)

SAME = 0.01  #: mm between two features that are one, and degrees
FACES = {"v": 0, "o": 1, "u": 2, "h": 3}  #: the order in which they are listed


def opening(wall: Wall, chain: Chain, source: Source) -> Hole | Slot | Contour:
    """A hole, a slot or an inner contour, by its outline."""
    shape = shape_of(chain)
    if isinstance(shape, Round):
        return Hole(wall.face, *shape.centre, shape.diameter, source)
    if isinstance(shape, Slotted) and shape.height == 0:
        return slot(wall, shape, source)
    return contour(wall.face, "inner", chain, source)


def slot(wall: Wall, shape: Slotted, source: Source, depth: float | None = None) -> Slot:
    return Slot(
        wall.face,
        *shape.centre,
        shape.diameter,
        shape.length,
        shape.height,
        shape.angle,
        source,
        depth,
    )


def contour(
    face: str, kind: str, chain: Chain, source: Source, bevels: tuple[Bevel, ...] = ()
) -> Contour:
    """A contour from a chain that is counter-clockwise in the face's numbers.

    Outer ones run counter-clockwise seen from outside, inner ones clockwise; the numbers of o and
    h are mirrored.
    """
    outer = kind == "outer"
    if outer == (face not in MIRRORED_FACES):
        return Contour(face, "outer" if outer else "inner", chain, source, bevels=bevels)
    last = len(chain) - 1
    turned = tuple(replace(b, curve=last - b.curve) for b in bevels)
    back = tuple(c.reversed() for c in reversed(chain))
    return Contour(face, "outer" if outer else "inner", back, source, bevels=turned)


def shifted(feature: Shifted, by: float) -> Shifted:
    """A feature moved along the part."""
    if by == 0.0:
        return feature
    if isinstance(feature, Contour):
        matrix = ((1.0, 0.0, by), (0.0, 1.0, 0.0))
        curves: tuple[Curve, ...] = tuple(c.transformed(matrix) for c in feature.curves)
        return replace(feature, curves=curves)
    return replace(feature, x=feature.x + by)


def sorted_features(
    features: Sequence[Hole | Slot | Contour],
) -> tuple[Hole | Slot | Contour, ...]:
    """Contours, then holes and slots, face by face along the part, each of these once."""
    contours = [f for f in features if isinstance(f, Contour)]
    contours.sort(key=_place_of_contour)
    return (*contours, *sorted_holes([f for f in features if not isinstance(f, Contour)]))


def sorted_holes(holes: Sequence[Hole | Slot]) -> tuple[Hole | Slot, ...]:
    """Holes and slots face by face along the part, each once."""
    once: list[Hole | Slot] = []
    for hole in sorted(holes, key=_place_of_hole):
        if not _among(hole, once):
            once.append(hole)
    return tuple(once)


def _place_of_contour(f: Contour) -> tuple[object, ...]:
    x, y = f.curves[0].start
    return FACES[f.face], f.kind != "outer", round(x * 1000), round(y * 1000)


def _place_of_hole(f: Hole | Slot) -> tuple[object, ...]:
    return FACES[f.face], isinstance(f, Slot), round(f.x * 1000), round(f.y * 1000)


def _among(feature: Hole | Slot, before: Sequence[Hole | Slot]) -> bool:
    """Whether one of those that are sorted before a feature is the same."""
    for known in reversed(before):
        if abs(feature.x - known.x) > 2 * SAME or feature.face != known.face:
            return False
        if _same(feature, known):
            return True
    return False


def _same(a: Hole | Slot, b: Hole | Slot) -> bool:
    """Whether two features are one and the same, modelled twice."""
    same = (
        abs(a.x - b.x) < SAME
        and abs(a.y - b.y) < SAME
        and abs(a.diameter - b.diameter) < SAME
        and a.face == b.face
        and a.depth == b.depth
        and type(a) is type(b)
    )
    if same and isinstance(a, Slot) and isinstance(b, Slot):
        return abs(a.length - b.length) < SAME and abs(a.angle - b.angle) < SAME
    return same
