"""What ezdxf holds of an entity: the numbers of its curves, its text, what a dimension says."""

import re
from collections.abc import Callable, Iterable, Iterator
from math import atan2, cos, degrees, hypot, radians, sin
from typing import Any

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.lettering import glyph_of, spelled
from beamcam.model.part import TextMark
from beamcam.readers.drawing import MM_PER_UNIT
from beamcam.readers.dxf import curves, rules
from beamcam.readers.dxf.curves import (
    FROM_ABOVE,
    Axes,
    Chain,
    Heights,
    InsertFrame,
    Vector,
)

# --- curves ---------------------------------------------------------------------------------------

# A function of the table `CURVES` takes the frame that an entity stands in, a list that it adds
# heights to, and the entity, and gives chains, as the functions of `curves` do.


# Flag of a vertex: a control point of the frame of a fitted polyline, which is not drawn.
SPLINE_FRAME = 16


def _vector(v: Any) -> Vector:
    return v.x, v.y, v.z


def _axes(entity: Any) -> Axes:
    """The axes of the entity's own plane (OCS, by its extrusion).

    An extrusion of (0, 0, -1) shows the plane from behind: x is mirrored.
    """
    extrusion = entity.dxf.get("extrusion")
    if extrusion is None or (extrusion.x == 0.0 and extrusion.y == 0.0 and extrusion.z > 0.0):
        return FROM_ABOVE
    ocs = entity.ocs()
    return _vector(ocs.ux), _vector(ocs.uy), _vector(ocs.uz)


def _line(frame: InsertFrame, heights: Heights, entity: Any) -> list[Chain]:
    return curves.line(frame, heights, _vector(entity.dxf.start), _vector(entity.dxf.end))


def _circle(frame: InsertFrame, heights: Heights, entity: Any) -> list[Chain]:
    centre, radius = _vector(entity.dxf.center), entity.dxf.radius
    return curves.arc(frame, heights, centre, radius, axes=_axes(entity))


def _arc(frame: InsertFrame, heights: Heights, entity: Any) -> list[Chain]:
    centre, radius = _vector(entity.dxf.center), entity.dxf.radius
    start, end = entity.dxf.start_angle, entity.dxf.end_angle
    return curves.arc(frame, heights, centre, radius, start, end, _axes(entity))


def _ellipse(frame: InsertFrame, heights: Heights, entity: Any) -> list[Chain]:
    dxf = entity.dxf
    normal = _vector(dxf.extrusion.normalize())
    axis = _vector(dxf.major_axis)
    ends = dxf.start_param, dxf.end_param
    return curves.ellipse(frame, heights, _vector(dxf.center), axis, normal, dxf.ratio, *ends)


def _lwpolyline(frame: InsertFrame, heights: Heights, entity: Any) -> list[Chain]:
    vertices = [(float(x), float(y), float(b)) for x, y, b in entity.get_points("xyb")]
    elevation = entity.dxf.get("elevation", 0.0)
    return curves.polyline(frame, heights, vertices, bool(entity.closed), elevation, _axes(entity))


def _polyline(frame: InsertFrame, heights: Heights, entity: Any) -> list[Chain]:
    drawn = [v.dxf for v in entity.vertices if not v.dxf.flags & SPLINE_FRAME]
    closed = bool(entity.is_closed)
    if entity.is_2d_polyline:
        vertices = [(v.location.x, v.location.y, v.get("bulge", 0.0)) for v in drawn]
        elevation = entity.dxf.get("elevation")
        height = elevation.z if elevation is not None else 0.0
        if elevation is None and drawn:
            height = drawn[0].location.z
        return curves.polyline(frame, heights, vertices, closed, height, _axes(entity))
    points = [_vector(v.location) for v in drawn]
    if closed and points:
        points.append(points[0])
    return curves.polyline_through(frame, heights, points)


def _spline(frame: InsertFrame, heights: Heights, entity: Any) -> list[Chain]:
    tool = entity.construction_tool()
    points = [_vector(p) for p in tool.control_points]
    knots = tuple(float(k) for k in tool.knots())
    weights = tuple(float(w) for w in tool.weights())
    return curves.spline(frame, heights, tool.order - 1, points, knots, weights)


def by_fit_points(entity: Any) -> int:
    """Count of fit points of a spline that the file gives by nothing else; 0 for other curves."""
    if entity.dxftype() != "SPLINE" or entity.control_point_count():
        return 0
    return int(entity.fit_point_count())


def through_fit_points(frame: InsertFrame, heights: Heights, entity: Any) -> list[Chain]:
    """The polyline through the fit points of a spline: the nodes of a polynomial that is asked
    for, where drawing programs show a cubic spline."""
    points = [(float(x), float(y), float(z)) for x, y, z in entity.fit_points]
    return curves.polyline_through(frame, heights, points)


CURVES: dict[str, Callable[[InsertFrame, Heights, Any], list[Chain]]] = {
    "LINE": _line,
    "ARC": _arc,
    "CIRCLE": _circle,
    "ELLIPSE": _ellipse,
    "LWPOLYLINE": _lwpolyline,
    "POLYLINE": _polyline,
    "SPLINE": _spline,
}


# --- texts ----------------------------------------------------------------------------------------

# Texts of a drawing that are to be lettered: those on layers that are mapped to a mark.


KINDS = ("TEXT", "MTEXT")
LINE_SPACING = 5 / 3  #: of MTEXT, as a share of its height. Source: DXF reference, group 44
#: Up to the baseline from where a text is held, in heights: baseline, bottom, middle, top.
_FEET = (0.0, 1 / 3, -0.5, -1.0)


def text_marks(entity: Any, frame: InsertFrame, source: Source) -> Iterator[TextMark]:
    """The lines of a text, each from where its baseline begins."""
    if entity.dxftype() == "TEXT":
        lines, across, up = [entity.plain_text()], *_held(entity)
        at = entity.dxf.insert if (across, up) == (0.0, 0.0) else entity.dxf.align_point
        height, turn = entity.dxf.height, entity.dxf.get("rotation", 0.0)
    else:
        lines = entity.plain_text().split("\n")
        place = entity.dxf.get("attachment_point", 1) - 1
        across, row = (place % 3) / 2, place // 3
        height, turn = entity.dxf.char_height, entity.get_rotation()
        below = (len(lines) - 1) * LINE_SPACING
        up = (-1.0, below / 2 - 0.5, below)[row]
        at = entity.dxf.insert
    c, s = cos(radians(turn)), sin(radians(turn))
    ux, uy = frame.vector((c, s, 0.0))
    scale = hypot(ux, uy)
    for number, line in enumerate(lines):
        if not line.strip():
            continue
        begin, foot = -across * _width(line) * height, (up - number * LINE_SPACING) * height
        x, y = frame.point((at[0] + begin * c - foot * s, at[1] + begin * s + foot * c, at[2]))
        yield TextMark("v", x, y, degrees(atan2(uy, ux)), height * scale, line.strip(), source)


def _held(text: Any) -> tuple[float, float]:
    """Alignment point of a TEXT: as a share of its length, and above its baseline in heights."""
    across = (0.0, 0.5, 1.0, 0.0, 0.5, 0.0)[text.dxf.get("halign", 0)]
    if text.dxf.get("halign", 0) == 4:  # by its middle
        return 0.5, -0.5
    return across, _FEET[text.dxf.get("valign", 0)]


def _width(line: str) -> float:
    """Length of a line of text in heights."""
    glyphs = (glyph_of(sign) for sign in spelled(line, {}).text)
    return sum(glyph.advance for glyph in glyphs if glyph is not None)


# --- what dimensions say --------------------------------------------------------------------------

_STATED = re.compile(r"(\d+(?:[.,]\d+)?)\s*(mm|cm|m|inch(?:es)?|in|ft|\"|″|')\.?\Z", re.IGNORECASE)
_WORDS = {"inch": 25.4, "inches": 25.4, '"': 25.4, "″": 25.4, "'": 304.8}
_FORMATTING = re.compile(r"\\[A-Za-z][^;\\]*;|[{}]")


def contradictions(
    dimensions: Iterable[Any], unit: str, mm: float, name: str
) -> tuple[Diagnostic, ...]:
    """An error for the first dimension that names a length in a unit which denies `unit`.

    A dimension measures in drawing units and may show its length with a unit, written by hand
    ("100 mm") or appended by its style. If both differ by the factor between two units, the
    drawing was scaled or its header is wrong. Other differences are no matter of units.
    """
    for dimension in dimensions:
        stated = _stated_length(dimension)
        if stated is None:
            continue
        text, length, measured = stated
        size = measured * mm
        if size > 0.0 and _is_unit_factor(length / size):
            return (
                rules.UNITS_CONTRADICT.at(
                    Source(name, None, dimension.dxf.handle),
                    stated=text,
                    measured=measured,
                    unit=unit,
                    size=size,
                ),
            )
    return ()


def _stated_length(dimension: Any) -> tuple[str, float, float] | None:
    """Text, mm that it states, and measure in drawing units; None if it names no unit."""
    measured = dimension.dxf.get("actual_measurement")
    if not measured or not 0.0 < measured < 1e9:
        return None
    text = _FORMATTING.sub("", dimension.dxf.get("text", "") or "<>").strip()
    if "<>" in text:
        style = dimension.override()
        shown = measured * float(style.get("dimlfac", 1.0) or 1.0)
        post = str(style.get("dimpost", "") or "")
        text = text.replace("<>", (post if "<>" in post else "<>" + post))
        text = text.replace("<>", f"{shown:.9f}")
    match = _STATED.match(text)
    if match is None:
        return None
    word = match[2].lower()
    mm = _WORDS.get(word) or MM_PER_UNIT[word]
    return text, float(match[1].replace(",", ".")) * mm, measured


def _is_unit_factor(factor: float) -> bool:
    sizes = (1.0, 10.0, 25.4, 304.8, 1000.0)
    known = {a / b for a in sizes for b in sizes if a != b}
    return any(abs(factor / k - 1.0) < 0.01 for k in known)


def is_drawn(polyline: Any) -> bool:
    """Whether it is a polyline; a mesh is called so too."""
    return bool(polyline.is_2d_polyline or polyline.is_3d_polyline)
