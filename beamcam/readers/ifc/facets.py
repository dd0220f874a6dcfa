"""Faceted solids of IFC as shells: Breps, face sets and surface models, read without a kernel."""

from collections.abc import Iterator
from itertools import chain
from typing import Any

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
    if item.is_a("IfcFacetedBrep"):
        if item.is_a("IfcFacetedBrepWithVoids"):
            raise Unreadable("a Brep with hidden voids")
        yield from _shell_faces(model, item.Outer)
    elif item.is_a("IfcFaceBasedSurfaceModel"):
        for faces in item.FbsmFaces:
            yield from _shell_faces(model, faces)
    elif item.is_a("IfcShellBasedSurfaceModel"):
        for faces in item.SbsmBoundary:
            yield from _shell_faces(model, faces)
    elif item.is_a("IfcTriangulatedFaceSet"):
        points = _list3d(model, item.Coordinates)
        for triangle in item.CoordIndex:
            yield [[points[_index(item, i)] for i in triangle]]
    elif item.is_a("IfcPolygonalFaceSet"):
        points = _list3d(model, item.Coordinates)
        for face in item.Faces:
            rings = [[points[_index(item, i)] for i in face.CoordIndex]]
            if face.is_a("IfcIndexedPolygonalFaceWithVoids"):
                rings += [
                    [points[_index(item, i)] for i in ring] for ring in face.InnerCoordIndices
                ]
            yield rings
    else:
        raise Unreadable(f"a faceted solid by {item.is_a()}")


def _index(item: Entity, i: int) -> int:
    table: Any = getattr(item, "PnIndex", None)
    return (table[i - 1] if table else i) - 1


def _list3d(model: Model, entity: Entity) -> list[Vec]:
    mm = model.mm
    return [(x * mm, y * mm, z * mm) for x, y, z in entity.CoordList]


def _shell_faces(model: Model, shell: Entity) -> Iterator[list[Ring]]:
    for face in shell.CfsFaces:
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
