"""DXF files written tag by tag, as small as a reader takes them."""

from beamcam.errors import errors_in
from beamcam.geometry.curves import Curve
from beamcam.model.lengths import total_length
from beamcam.model.part import extent
from beamcam.readers import dxf

Pair = tuple[int, object]


def tags(*pairs: Pair) -> str:
    return "".join(f"{code}\n{value}\n" for code, value in pairs)


def section(name: str, content: str) -> str:
    return tags((0, "SECTION"), (2, name)) + content + tags((0, "ENDSEC"))


def drawing(
    entities: str,
    *header: Pair,
    units: int | None = 4,
    tables: str = "",
    blocks: str = "",
    version: str = "AC1015",
) -> bytes:
    """A whole file; `units` is $INSUNITS, None leaves it out."""
    said = () if units is None else ((9, "$INSUNITS"), (70, units))
    text = section("HEADER", tags((9, "$ACADVER"), (1, version), *said, *header))
    if tables:
        text += section("TABLES", tables)
    if blocks:
        text += section("BLOCKS", blocks)
    return (text + section("ENTITIES", entities) + tags((0, "EOF"))).encode()


def entity(
    kind: str, subclass: str, *pairs: Pair, layer: str = "0", common: tuple[Pair, ...] = ()
) -> str:
    head = ((0, kind), (5, "AB"), (100, "AcDbEntity"), (8, layer), *common, (100, subclass))
    return tags(*head, *pairs)


def line(x0: float, y0: float, x1: float, y1: float, **more: object) -> str:
    pairs = ((10, x0), (20, y0), (11, x1), (21, y1))
    return entity("LINE", "AcDbLine", *pairs, **more)  # type: ignore[arg-type]


def circle(x: float, y: float, radius: float, *pairs: Pair, **more: object) -> str:
    own = ((10, x), (20, y), (40, radius), *pairs)
    return entity("CIRCLE", "AcDbCircle", *own, **more)  # type: ignore[arg-type]


def arc(x: float, y: float, radius: float, start: float, end: float, *pairs: Pair) -> str:
    own = ((10, x), (20, y), (40, radius), *pairs, (100, "AcDbArc"), (50, start), (51, end))
    return entity("ARC", "AcDbCircle", *own)


def polyline(points: list[tuple[float, ...]], closed: bool = True, *pairs: Pair) -> str:
    """An LWPOLYLINE through points (x, y) or (x, y, bulge)."""
    rows: list[Pair] = [(90, len(points)), (70, int(closed)), *pairs]
    for x, y, *bulge in points:
        rows += [(10, x), (20, y), *((42, b) for b in bulge)]
    return entity("LWPOLYLINE", "AcDbPolyline", *rows)


def spline(
    control: list[tuple[float, float]],
    knots: list[float],
    degree: int = 3,
    weights: tuple[float, ...] = (),
    fit: tuple[tuple[float, float], ...] = (),
) -> str:
    rows: list[Pair] = [(70, 8), (71, degree), (72, len(knots)), (73, len(control)), (74, len(fit))]
    rows += [(40, knot) for knot in knots]
    rows += [(41, weight) for weight in weights]
    for x, y in control:
        rows += [(10, x), (20, y), (30, 0)]
    for x, y in fit:
        rows += [(11, x), (21, y), (31, 0)]
    return entity("SPLINE", "AcDbSpline", *rows)


def block(name: str, content: str) -> str:
    head = tags((0, "BLOCK"), (5, "B0"), (100, "AcDbEntity"), (8, "0"), (100, "AcDbBlockBegin"))
    head += tags((2, name), (70, 0), (10, 0), (20, 0), (30, 0), (3, name))
    end = ((0, "ENDBLK"), (5, "B1"), (100, "AcDbEntity"), (8, "0"), (100, "AcDbBlockEnd"))
    return head + content + tags(*end)


def insert(
    name: str, x: float = 0, y: float = 0, *pairs: Pair, layer: str = "0", **more: object
) -> str:
    own = ((2, name), (10, x), (20, y), (30, 0), *pairs)
    return entity("INSERT", "AcDbBlockReference", *own, layer=layer, **more)  # type: ignore[arg-type]


def layer_table(*rows: tuple[str, int, int, int]) -> str:
    """Layers by name, colour, flags and whether they plot."""
    text = tags((0, "TABLE"), (2, "LAYER"), (5, "2"), (100, "AcDbSymbolTable"), (70, len(rows)))
    for name, colour, flags, plot in rows:
        head = ((0, "LAYER"), (5, "C0"), (100, "AcDbSymbolTableRecord"))
        own = ((100, "AcDbLayerTableRecord"), (2, name), (70, flags), (62, colour))
        text += tags(*head, *own, (6, "CONTINUOUS"), (290, plot))
    return text + tags((0, "ENDTAB"))


def curves_of(data: bytes, **options: object) -> tuple[Curve, ...]:
    """All curves of a file that must not be refused."""
    reading = dxf.read(data, "a.dxf", **options)  # type: ignore[arg-type]
    assert errors_in(reading.diagnostics) == ()
    return tuple(curve for contour in reading.parts[0].contours for curve in contour.curves)


def box_of(data: bytes, **options: object) -> tuple[float, ...]:
    box = extent(curves_of(data, **options))
    assert box is not None
    return box


def length_of(data: bytes, **options: object) -> float:
    return total_length(curves_of(data, **options))


def codes(data: bytes, **options: object) -> list[str]:
    return [d.code for d in dxf.read(data, "a.dxf", **options).diagnostics]  # type: ignore[arg-type]
