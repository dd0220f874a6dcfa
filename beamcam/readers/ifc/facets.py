"""Faceted solids of IFC as shells: Breps, face sets and surface models, read without a kernel."""

from collections.abc import Iterable, Iterator
from itertools import chain

import numpy as np

from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.shell import Shell, moved, shell
from beamcam.readers.ifc.space import Frame, Vec

Ring = list[Vec]


def shell_of(model: Model, item: Entity, frame: Frame, where: str | None = None) -> Shell:
    """The shell of a faceted item that stands in `frame`, in mm. Raises Unreadable."""
    rings, faces = list[Ring](), list[int]()
    for face, around in enumerate(_faces(model, item)):
        rings += around
        faces += [face] * len(around)
    points = np.array(list(chain.from_iterable(rings))).reshape(-1, 3)
    found = shell(moved(points, frame), [len(ring) for ring in rings], faces, where)
    if found.count < 4:
        raise Unreadable(f"{item.is_a()} of {found.count} faces")
    return found


def _faces(model: Model, item: Entity) -> Iterator[list[Ring]]:
    if item.is_a("IfcFacetedBrepWithVoids"):
        raise Unreadable("a Brep with hidden voids")
    if item.is_a("IfcFacetedBrep"):
        yield from _shell_faces(model, (item.Outer,))
    elif item.is_a("IfcFaceBasedSurfaceModel"):
        yield from _shell_faces(model, item.FbsmFaces)
    elif item.is_a("IfcShellBasedSurfaceModel"):
        yield from _shell_faces(model, item.SbsmBoundary)
    elif item.is_a("IfcTriangulatedFaceSet"):
        yield from _indexed_faces(model, item, ((triangle,) for triangle in item.CoordIndex))
    elif item.is_a("IfcPolygonalFaceSet"):
        yield from _indexed_faces(model, item, map(_rings_of, item.Faces))
    else:
        raise Unreadable(f"a faceted solid by {item.is_a()}")


def _indexed_faces(
    model: Model, item: Entity, faces: Iterable[tuple[tuple[int, ...], ...]]
) -> Iterator[list[Ring]]:
    """Faces whose rings are places in the list of points, or in a list of such places."""
    mm = model.mm
    points = [(x * mm, y * mm, z * mm) for x, y, z in item.Coordinates.CoordList]
    table = getattr(item, "PnIndex", None)
    for rings in faces:
        yield [[points[(table[i - 1] if table else i) - 1] for i in ring] for ring in rings]


def _rings_of(face: Entity) -> tuple[tuple[int, ...], ...]:
    if face.is_a("IfcIndexedPolygonalFaceWithVoids"):
        return (face.CoordIndex, *face.InnerCoordIndices)
    return (face.CoordIndex,)


def _shell_faces(model: Model, shells: Iterable[Entity]) -> Iterator[list[Ring]]:
    for face in chain.from_iterable(one.CfsFaces for one in shells):
        if face.is_a("IfcFaceSurface") and not face.FaceSurface.is_a("IfcPlane"):
            raise Unreadable(f"a face on {face.FaceSurface.is_a()}")
        rings: list[Ring] = []
        for bound in face.Bounds:
            loop = bound.Bound
            if not loop.is_a("IfcPolyLoop"):
                raise Unreadable(f"a face bounded by {loop.is_a()}")
            ring = [model.point(p) for p in loop.Polygon]
            if bound.is_a("IfcFaceOuterBound"):
                rings.insert(0, ring)
            else:
                rings.append(ring)
        if rings:
            yield rings
