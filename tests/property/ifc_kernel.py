"""Volumes and meshes of members, by the geometry kernels alone."""

from tests.property.ifc_builder import Vec
from tests.unit.readers.ifc.models import Small


def kernel_volume(data: bytes, library: str = "opencascade") -> float | None:
    """cm3 of the exact solid of a beam, by a geometry kernel alone; None where it has none."""
    import ifcopenshell
    import ifcopenshell.geom as geom

    file = ifcopenshell.file.from_string(data.decode())
    settings = geom.settings()
    settings.set("circle-segments", 256)
    if library == "opencascade":
        settings.set("iterator-output", ifcopenshell.ifcopenshell_wrapper.NATIVE)
    ifcopenshell.get_log()
    try:
        solid = geom.create_shape(settings, file.by_type("IfcElement")[0], geometry_library=library)
    except RuntimeError:
        return None
    if library != "opencascade":
        v, f = solid.geometry.verts, solid.geometry.faces
        p = [(v[i], v[i + 1], v[i + 2]) for i in range(0, len(v), 3)]
        corners = ((p[f[i]], p[f[i + 1]], p[f[i + 2]]) for i in range(0, len(f), 3))
        return abs(sum(_six(*c) for c in corners)) * 1e6 / 6
    found = float(solid.volume) * 1e6
    return None if "[error]" in str(ifcopenshell.get_log()).lower() else found


def _six(a: Vec, b: Vec, c: Vec) -> float:
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def volumes(data: bytes, other: bytes) -> tuple[float, float] | None:
    """cm3 of two solids by the first kernel by which they are the same, or else by the exact one.

    Opencascade loses pieces where faces nearly lie on one another; manifold has facets for arcs.
    """
    pairs = []
    for library in ("opencascade", "manifold", "cgal"):
        both = kernel_volume(data, library), kernel_volume(other, library)
        if both[0] is not None and both[1] is not None and both[0] > 0:
            pairs.append((both[0], both[1]))
            if same(*pairs[-1]):
                return pairs[-1]
    return pairs[0] if pairs else None


def same(true: float, found: float) -> bool:
    """Whether two volumes in cm3 are those of one part."""
    return abs(true - found) <= 0.1 + 1e-5 * true


def facets(data: bytes, angle: float = 0.35) -> tuple[list[Vec], list[tuple[int, int, int]]]:
    """Corners in mm and triangles of a beam's solid, as a viewer has them, `angle` (radians) of an
    arc in each."""
    import ifcopenshell
    import ifcopenshell.geom as geom

    file = ifcopenshell.file.from_string(data.decode())
    settings = geom.settings()
    settings.set("weld-vertices", True)
    settings.set("mesher-angular-deflection", angle)
    solid = geom.create_shape(settings, file.by_type("IfcElement")[0])
    v, f = solid.geometry.verts, solid.geometry.faces
    points = [(v[i] * 1e3, v[i + 1] * 1e3, v[i + 2] * 1e3) for i in range(0, len(v), 3)]
    return points, [(f[i], f[i + 1], f[i + 2]) for i in range(0, len(f), 3)]


def meshed(data: bytes) -> bytes:
    """A model whose beam is the mesh of another's."""
    points, triangles = facets(data)
    m = Small()
    listed = ",".join("(" + ",".join(m.step.length(round(v, 6)) for v in p) + ")" for p in points)
    where = m.add(f"IFCCARTESIANPOINTLIST3D(({listed}))")
    faces = ",".join(f"({a + 1},{b + 1},{c + 1})" for a, b, c in triangles)
    body = m.add(f"IFCTRIANGULATEDFACESET({where},$,.T.,({faces}),$)")
    m.element(body, kind_of_body="Tessellation")
    return m.data
