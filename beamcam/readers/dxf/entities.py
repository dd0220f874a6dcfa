"""What ezdxf holds of an entity: the numbers of its curves, its text, what a dimension says."""

import re
from collections.abc import Iterable, Iterator
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

# Flag of a vertex: a control point of the frame of a fitted polyline, which is not drawn.
SPLINE_FRAME = 16
#: Kinds of entities that are curves.
CURVES = ("LINE", "ARC", "CIRCLE", "ELLIPSE", "LWPOLYLINE", "POLYLINE", "SPLINE")


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


def chains_of(frame: InsertFrame, heights: Heights, entity: Any) -> list[Chain]:
    """The chains of a curve of ezdxf, by the functions of `curves`."""
    dxf, kind = entity.dxf, entity.dxftype()
    if kind == "LINE":
        return curves.line(frame, heights, _vector(dxf.start), _vector(dxf.end))
    if kind in ("ARC", "CIRCLE"):
        start, end = (dxf.start_angle, dxf.end_angle) if kind == "ARC" else (0.0, 360.0)
        centre, axes = _vector(dxf.center), _axes(entity)
        return curves.arc(frame, heights, centre, dxf.radius, start, end, axes)
    if kind == "ELLIPSE":
        normal, axis = _vector(dxf.extrusion.normalize()), _vector(dxf.major_axis)
        ends = dxf.start_param, dxf.end_param
        return curves.ellipse(frame, heights, _vector(dxf.center), axis, normal, dxf.ratio, *ends)
    if kind == "LWPOLYLINE":
        vertices = [(float(x), float(y), float(b)) for x, y, b in entity.get_points("xyb")]
        flat = bool(entity.closed), dxf.get("elevation", 0.0), _axes(entity)
        return curves.polyline(frame, heights, vertices, *flat)
    if kind == "POLYLINE":
        return _polyline(frame, heights, entity)
    tool = entity.construction_tool()
    points = [_vector(p) for p in tool.control_points]
    knots, weights = (tuple(map(float, row)) for row in (tool.knots(), tool.weights()))
    return curves.spline(frame, heights, tool.order - 1, points, knots, weights)


def _polyline(frame: InsertFrame, heights: Heights, entity: Any) -> list[Chain]:
    drawn = [v.dxf for v in entity.vertices if not v.dxf.flags & SPLINE_FRAME]
    closed = bool(entity.is_closed)
    if entity.is_2d_polyline:
        vertices = [(v.location.x, v.location.y, v.get("bulge", 0.0)) for v in drawn]
        elevation = entity.dxf.get("elevation", drawn[0].location if drawn else None)
        height = elevation.z if elevation is not None else 0.0
        return curves.polyline(frame, heights, vertices, closed, height, _axes(entity))
    points = [_vector(v.location) for v in drawn]
    if closed and points:
        points.append(points[0])
    return curves.polyline_through(frame, heights, points)


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


# --- texts ----------------------------------------------------------------------------------------

# Texts of a drawing that are to be lettered: those on layers that are mapped to a mark.


KINDS = ("TEXT", "MTEXT")
LINE_SPACING = 5 / 3  #: of MTEXT, as a share of its height. Source: DXF reference, group 44
#: Up to the baseline from where a text is held, in heights: baseline, bottom, middle, top.
_FEET = (0.0, 1 / 3, -0.5, -1.0)


def text_marks(entity: Any, frame: InsertFrame, source: Source) -> Iterator[TextMark]:
    """The lines of a text, each from where its baseline begins."""
    if entity.dxftype() == "TEXT":
        lines, along = [entity.plain_text()], entity.dxf.get("halign", 0)
        # From where it is aligned: a share of its length, and in heights above its baseline.
        across = (0.0, 0.5, 1.0, 0.0, 0.5, 0.0)[along]
        up = -0.5 if along == 4 else _FEET[entity.dxf.get("valign", 0)]  # 4: by its middle
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
        glyphs = (glyph_of(sign) for sign in spelled(line, {}).text)
        width = sum(glyph.advance for glyph in glyphs if glyph is not None)  # in heights
        begin, foot = -across * width * height, (up - number * LINE_SPACING) * height
        x, y = frame.point((at[0] + begin * c - foot * s, at[1] + begin * s + foot * c, at[2]))
        yield TextMark("v", x, y, degrees(atan2(uy, ux)), height * scale, line.strip(), source)


# --- what dimensions say --------------------------------------------------------------------------

_STATED = re.compile(r"(\d+(?:[.,]\d+)?)\s*(mm|cm|m|inch(?:es)?|in|ft|\"|″|')\.?\Z", re.IGNORECASE)
_WORDS = {"inch": 25.4, "inches": 25.4, '"': 25.4, "″": 25.4, "'": 304.8}
_FORMATTING = re.compile(r"\\[A-Za-z][^;\\]*;|[{}]")
_SIZES = (1.0, 10.0, 25.4, 304.8, 1000.0)
_UNIT_FACTORS = {a / b for a in _SIZES for b in _SIZES if a != b}


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
        if size > 0.0 and any(abs(length / size / k - 1.0) < 0.01 for k in _UNIT_FACTORS):
            figures = {"stated": text, "measured": measured, "unit": unit, "size": size}
            source = Source(name, None, dimension.dxf.handle)
            return (rules.UNITS_CONTRADICT.at(source, **figures),)
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


def is_drawn(polyline: Any) -> bool:
    """Whether it is a polyline; a mesh is called so too."""
    return bool(polyline.is_2d_polyline or polyline.is_3d_polyline)
