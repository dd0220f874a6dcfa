"""Every entity of model space, inserts opened, sorted into what is read and what is not."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from math import atan2, cos, degrees, hypot, radians, sin
from typing import Any

from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.budget import DEPTH, InForce
from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.geometry.curves import Curve
from beamcam.geometry.lettering import glyph_of, spelled
from beamcam.model.part import Contour, Dashed, TextMark
from beamcam.readers.drawing import as_contour
from beamcam.readers.dxf import curves, rules
from beamcam.readers.dxf.curves import (
    BY_VALUES,
    FROM_ABOVE,
    Axes,
    Chain,
    EdgeOnError,
    Heights,
    InsertFrame,
    Vector,
    check_bounds,
)
from beamcam.readers.dxf.layers import Attributes, Layers, LayerStyle, attributes_of
from beamcam.readers.dxf.load import MARKER, Run

# --- entities -------------------------------------------------------------------------------------

# The numbers of an entity that ezdxf holds, and the curves that they make.
#
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


def is_curve(entity: Any) -> bool:
    """Whether an entity is one that `CURVES` reads; a mesh is called POLYLINE too."""
    kind = entity.dxftype()
    if kind == "POLYLINE":
        return bool(entity.is_2d_polyline or entity.is_3d_polyline)
    return kind in CURVES


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


#: More copies of blocks than this are a damaged number, or blocks that multiply each other.
MOST_COPIES = 20_000

# What numbers that make no curve end in, here and inside ezdxf.
_BAD_NUMBERS = (ValueError, TypeError, ArithmeticError, LookupError)


class DrawingContent(Struct):
    """Results of reading the entities of a drawing."""

    contours: list[Contour] = field(default_factory=list)
    texts: list[TextMark] = field(default_factory=list)
    lettered: Counter[str] = field(default_factory=Counter)  #: texts by layer
    hidden: list[Curve] = field(default_factory=list)
    hidden_on: Counter[str] = field(default_factory=Counter)  #: curves by layer
    not_cut: Counter[str] = field(default_factory=Counter)  #: entities by kind
    empty: Counter[str] = field(default_factory=Counter)
    edge_on: Counter[str] = field(default_factory=Counter)
    heights: Heights = field(default_factory=list)
    dashed: dict[tuple[str, str, str], Dashed] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)


class DrawingWalk(Struct):
    """One pass over a document."""

    name: str
    layers: Layers
    handles: bool  #: whether entities have names of their own
    runs: Iterator[Run] = iter(())  #: the plain entities that stand at the markers
    newton: frozenset[str] = frozenset()  #: layers whose fit points are nodes of polynomials
    letters: frozenset[str] = frozenset()  #: layers whose texts are lettered
    found: DrawingContent = field(default_factory=DrawingContent)
    _seen: Counter[str] = field(default_factory=Counter)
    _copies: int = 0  #: of blocks, so far

    def entities(
        self,
        entities: Iterable[Any],
        frame: InsertFrame,
        above: LayerStyle,
        blocks: tuple[str, ...],
    ) -> None:
        """Sort `entities`, which stand in `frame` in the innermost of `blocks`."""
        from ezdxf.lldxf.const import DXFError

        for entity in entities:
            kind = entity.dxftype()
            if kind == MARKER:
                self.run(next(self.runs), frame)
                continue
            source = self._source(kind, entity.dxf.get("handle"))
            try:
                if kind == "INSERT":
                    self._insert(entity, source, frame, above, blocks)
                elif is_curve(entity):
                    look = self.layers.look(attributes_of(entity), above, bool(blocks))
                    self._curve(entity, source, frame, look)
                elif self._is_lettered(entity, kind, above, bool(blocks)):
                    self.found.texts += text_marks(entity, frame, source)
                # SEQEND ends a list of vertices; ezdxf hides it from sound files only. An ATTDEF in
                # a block shows nothing: each insert has attributes of its own.
                elif kind != "SEQEND" and not (blocks and kind == "ATTDEF"):
                    self._count(entity, kind, above, bool(blocks))
            # What ezdxf took in of a damaged file may lack attributes or have them of other types.
            except (DXFError, *_BAD_NUMBERS, AttributeError) as error:
                self._say_entity(source, kind, error)

    def _source(self, kind: str, handle: str | None) -> Source:
        """The entity's handle, or else its kind and number in the order of reading."""
        if self.handles:
            return Source(self.name, None, handle)
        self._seen[kind] += 1
        return Source(self.name, None, f"{kind} {self._seen[kind]}")

    def _say_entity(self, source: Source, kind: str, error: Exception) -> None:
        text = " ".join(str(error).split()) or type(error).__name__
        self.found.diagnostics.append(rules.ENTITY.at(source, kind=kind, found=text))

    def _count(self, entity: Any, kind: str, above: LayerStyle, inside: bool) -> None:
        """Count what is not a curve, unless it is hidden anyway."""
        if not self.layers.hides(self.layers.look(attributes_of(entity), above, inside)):
            self.found.not_cut[kind] += 1

    def _is_lettered(self, entity: Any, kind: str, above: LayerStyle, inside: bool) -> bool:
        """Whether a text stands on a layer that is mapped to a mark, and shows; it is counted."""
        if kind not in KINDS or not self.letters:
            return False
        look = self.layers.look(attributes_of(entity), above, inside)
        if look.layer.lower() not in self.letters or self.layers.hides(look):
            return False
        self.found.lettered[look.layer] += 1
        return True

    def run(self, run: Run, frame: InsertFrame) -> None:
        """Sort plain entities, which stand in model space."""
        attributes: Attributes | None = None
        for plain in run:
            if plain.says is not attributes:
                attributes = plain.says
                look = self.layers.look(attributes, LayerStyle(), False)
                hidden = self.layers.hides(look)
            kind = plain.kind
            self._sort(
                kind,
                self._source(kind, plain.handle),
                look,
                hidden,
                BY_VALUES[kind],
                frame,
                plain.values,
            )

    def _curve(self, entity: Any, source: Source, frame: InsertFrame, look: LayerStyle) -> None:
        kind = entity.dxftype()
        polynomial = by_fit_points(entity) > 0 and look.layer.lower() in self.newton
        read = through_fit_points if polynomial else CURVES[kind]
        seen = self._sort(kind, source, look, self.layers.hides(look), read, frame, (entity,))
        if seen and not polynomial and (count := by_fit_points(entity)):
            self.found.diagnostics.append(rules.FIT_SPLINE.at(source, count=count))

    def _sort(
        self,
        kind: str,
        source: Source,
        look: LayerStyle,
        hidden: bool,
        read: Callable[..., list[Chain]],
        frame: InsertFrame,
        values: tuple[Any, ...],
    ) -> bool:
        """Contours of the chains that `read` gives, if they are not hidden; whether there are any.

        `read` takes the frame, a list that it adds heights to, and the values.
        """
        collected = self.found
        heights: Heights = [] if hidden else collected.heights
        count = len(heights)
        try:
            chains = read(frame, heights, *values)
            check_bounds(chains)
        except _BAD_NUMBERS as error:
            del heights[count:]
            if not hidden and isinstance(error, EdgeOnError):
                collected.edge_on[kind] += 1
            elif not hidden:
                self._say_entity(source, kind, error)
            return False
        if not chains:
            collected.empty[kind] += 1
        if hidden:
            collected.hidden += (curve for chain in chains for curve in chain)
            collected.hidden_on[look.layer] += 1
            return False
        for chain in chains:
            collected.contours.append(as_contour(chain, source, look.layer, look.colour))
        if chains and look.line_type:
            key = look.layer, look.colour, look.line_type
            before = collected.dashed.get(key) or Dashed(*key, 0, source)
            collected.dashed[key] = replace(before, count=before.count + len(chains))
        return bool(chains)

    def _insert(
        self,
        insert: Any,
        source: Source,
        frame: InsertFrame,
        above: LayerStyle,
        blocks: tuple[str, ...],
    ) -> None:
        """Open an insert: its block, once for each place of its array."""
        look = self.layers.look(attributes_of(insert), above, bool(blocks))
        name = str(insert.dxf.get("name", ""))
        for attribute in insert.attribs:
            self._count(attribute, "ATTRIB", look, True)
        block = insert.block()
        if block is None or block.block.is_xref:
            self.found.diagnostics.append(rules.BLOCK_MISSING.at(source, found=name))
            return
        if name.lower() in blocks:
            self.found.diagnostics.append(rules.BLOCK_CYCLE.at(source, found=name))
            return
        if len(blocks) >= InForce.limits.depth:
            raise ReadError(DEPTH.at(source, found=name, expected=InForce.limits.depth))
        copies = insert.mcount
        self._copies += copies
        if self._copies > MOST_COPIES:
            raise ReadError(rules.BLOCK_COUNT.at(source, found=self._copies, expected=MOST_COPIES))
        before = len(self.found.contours)
        for place in insert.multi_insert() if copies > 1 else (insert,):
            self.entities(block, frame.inside(place.matrix44()), look, (*blocks, name.lower()))
        if len(self.found.contours) > before and self.layers.hides(look):
            self.found.diagnostics.append(rules.FROZEN_INSERT.at(source, layer=look.layer))
