"""The DXF reader: every curve of model space, exact, in mm."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.budget import DEPTH, InForce
from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.geometry.curves import Curve
from beamcam.model.part import Contour, Dashed, Measures, TextMark
from beamcam.readers import Reading, drawing
from beamcam.readers.dxf import curves, entities, rules
from beamcam.readers.dxf.curves import InsertFrame
from beamcam.readers.dxf.layers import Attributes, Layers, LayerStyle, attributes_of
from beamcam.readers.dxf.load import MARKER, Run, is_binary, load_document, looks_like

__all__ = ["looks_like", "read"]

#: Heights that differ by less are noise of the writer: files carry 1e-9 to 1e-7.
FLAT = 1e-3


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
    heights: curves.Heights = field(default_factory=list)
    dashed: dict[tuple[str, str, str], Dashed] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)


def read(
    data: bytes,
    name: str,
    units: str | None = None,
    layers: Sequence[str] = (),
    fit: Sequence[str] = (),
    letters: Sequence[str] = (),
    wrap: str | None = None,
) -> Reading:
    """The part that a DXF file draws in model space, and the remarks; never raises.

    `units` ("mm", "in", ...) overrides what the file says about its unit. `layers` names the
    layers to read, hidden ones too; by default those that are visible and plot. `fit` names layers
    whose polylines and splines by fit points become polynomials through their vertices, `letters`
    those whose texts are to be lettered. `wrap` names the tube whose unrolled surface is drawn.
    """
    source = Source(name)
    unit, diagnostics = find_unit(data, units, source)
    if unit is None:
        return Reading("dxf", (), diagnostics)
    try:
        loaded = load_document(data, source)
    except ReadError as error:
        return Reading("dxf", (), error.diagnostics)
    chosen = Layers(loaded.tables, frozenset(map(str.lower, layers)) or None)
    diagnostics += (*loaded.remarks, *drawing.unknown_layers(chosen.names(), layers, source))
    runs, frame = iter(loaded.runs), curves.scaled(unit.mm)
    fitted_on, lettered_on = (frozenset(map(str.lower, names)) for names in (fit, letters))
    walk = DrawingWalk(name, chosen, loaded.handles, runs, fitted_on, lettered_on)
    try:
        if loaded.document is None:
            walk.run(next(runs), frame)
        else:
            walk.entities(loaded.document.modelspace(), frame, LayerStyle(), ())
    except ReadError as error:
        return Reading("dxf", (), diagnostics + error.diagnostics)
    if loaded.document is not None and not unit.given:
        dimensions = list(loaded.document.modelspace().query("DIMENSION"))
        diagnostics += (
            entities.contradictions(dimensions, unit.name, unit.mm, name) if dimensions else ()
        )
    content = walk.content
    not_cut, lettered = (
        tuple(sorted(counts.items())) for counts in (content.not_cut, content.lettered)
    )
    dashed = tuple(content.dashed.values())
    measures = Measures((), tuple(content.hidden), not_cut, lettered=lettered, dashed=dashed)
    part, fitted = drawing.fit_newton(
        drawing.drawing_part(name, tuple(content.contours), measures), fit
    )
    part = replace(part, features=(*part.features, *content.texts))
    seen = sorted([*not_cut, ("hidden curves", content.hidden_on.total())])
    unit_name = None if unit.given else unit.name
    diagnostics += (*content.diagnostics, *fitted, *_remarks(content, source))
    diagnostics += (*drawing.verdict(part, seen, unit_name, source),)
    return drawing.wrapped(Reading("dxf", (part,), diagnostics), wrap)


def _remarks(content: DrawingContent, source: Source) -> Iterator[Diagnostic]:
    """Remarks on entities that are not contours, by kind and count."""
    kinds = (rules.NOT_CUT, rules.EDGE_ON, rules.EMPTY_CURVES, rules.HIDDEN)
    counters = (content.not_cut, content.edge_on, content.empty, content.hidden_on)
    for rule, counts in zip(kinds, counters, strict=True):
        if counts:
            found = drawing.counted(sorted(counts.items()))
            yield rule.at(source, count=counts.total(), found=found)
    low, high = min(content.heights, default=0.0), max(content.heights, default=0.0)
    if high - low > FLAT:
        yield rules.NOT_FLAT.at(source, low=low, high=high)


# --- units ----------------------------------------------------------------------------------------

# ezdxf invents `$INSUNITS` 6 (metres) for files without a header, so that the raw text is asked.

_NL = rb"[ \t]*(?:\r\n|\r|\n)[ \t]*"


class LengthUnit(Struct, frozen=True):
    """The unit of a drawing's numbers."""

    name: str
    mm: float
    given: bool = False  #: by the user: what the file says about it does not count


def header_number(data: bytes, variable: str) -> int | None:
    """The whole number that the header gives to `variable` (group 70); None if it does not.

    Of a number of more digits than any variable has the first nine.
    """
    name = re.escape(variable.encode("ascii"))
    if is_binary(data):
        # Group codes are two bytes since R13, and the values of group 70 too.
        match = re.search(rb"\x09\x00" + name + rb"\x00\x46\x00(..)", data, re.DOTALL)
        return None if match is None else int.from_bytes(match[1], "little", signed=True)
    end = data.find(b"ENDSEC")
    text = data[: end if end >= 0 else len(data)]
    match = re.search(
        rb"(?:^|[\r\n])[ \t]*9" + _NL + name + _NL + rb"70" + _NL + rb"(-?\d{1,9})", text
    )
    return None if match is None else int(match[1])


def find_unit(
    data: bytes, units: str | None, source: Source
) -> tuple[LengthUnit | None, tuple[Diagnostic, ...]]:
    """The unit of a file, or the one that the user gave; None with an error if there is none."""
    if units is not None:
        mm = drawing.MM_PER_UNIT.get(units.lower())
        if mm is None:
            expected = ", ".join(drawing.MM_PER_UNIT)
            return None, (drawing.UNITS_OPTION.at(source, found=units, expected=expected),)
        return LengthUnit(units.lower(), mm, given=True), ()
    code = header_number(data, "$INSUNITS")
    if not code:
        found = "no $INSUNITS" if code is None else "$INSUNITS 0 (no unit)"
        if header_number(data, "$MEASUREMENT") == 0:
            found += " but $MEASUREMENT 0 (inches)"
        return LengthUnit("mm", 1.0), (rules.UNITS_MISSING.at(source, found=found),)
    if code not in drawing.INSUNITS:
        expected = ", ".join(f"{c} {name}" for c, (name, _) in drawing.INSUNITS.items() if c <= 6)
        return None, (rules.UNITS_UNKNOWN.at(source, found=code, expected=expected),)
    unit = LengthUnit(*drawing.INSUNITS[code])
    shown = header_number(data, "$LUNITS")
    if shown in (3, 4) and unit.mm not in (25.4, 304.8):
        return unit, (rules.UNITS_IMPERIAL.at(source, found=shown, unit=unit.name),)
    return unit, ()


# --- walk -----------------------------------------------------------------------------------------

#: More copies of blocks than this are a damaged number, or blocks that multiply each other.
MOST_COPIES = 20_000
# What numbers that make no curve end in, here and inside ezdxf.
_BAD_NUMBERS = (ValueError, TypeError, ArithmeticError, LookupError)


class DrawingWalk(Struct):
    """One pass over a document."""

    name: str
    layers: Layers
    handles: bool  #: whether entities have names of their own
    runs: Iterator[Run] = iter(())  #: the plain entities that stand at the markers
    newton: frozenset[str] = frozenset()  #: layers whose fit points are nodes of polynomials
    letters: frozenset[str] = frozenset()  #: layers whose texts are lettered
    content: DrawingContent = field(default_factory=DrawingContent)
    _seen: Counter[str] = field(default_factory=Counter)
    _copies: int = 0  #: of blocks, so far

    def entities(
        self, those: Iterable[Any], frame: InsertFrame, above: LayerStyle, blocks: tuple[str, ...]
    ) -> None:
        """Sort entities, which stand in `frame` in the innermost of `blocks`."""
        from ezdxf.lldxf.const import DXFError

        for entity in those:
            kind = entity.dxftype()
            if kind == MARKER:
                self.run(next(self.runs), frame)
                continue
            source = self._source(kind, entity.dxf.get("handle"))
            try:
                if kind == "INSERT":
                    self._insert(entity, source, frame, above, blocks)
                elif kind in entities.CURVES and (kind != "POLYLINE" or entities.is_drawn(entity)):
                    style = self.layers.style(attributes_of(entity), above, bool(blocks))
                    self._curve(entity, source, frame, style)
                elif self._is_lettered(entity, kind, above, bool(blocks)):
                    self.content.texts += entities.text_marks(entity, frame, source)
                # SEQEND ends a list of vertices; ezdxf hides it from sound files only. An ATTDEF in
                # a block shows nothing: each insert has attributes of its own.
                elif kind != "SEQEND" and not (blocks and kind == "ATTDEF"):
                    self._count(entity, kind, above, bool(blocks))
            # What ezdxf took in of a damaged file may lack attributes or have them of other types.
            except (DXFError, *_BAD_NUMBERS, AttributeError) as error:
                self._report(source, kind, error)

    def _source(self, kind: str, handle: str | None) -> Source:
        """The entity's handle, or else its kind and number in the order of reading."""
        if self.handles:
            return Source(self.name, None, handle)
        self._seen[kind] += 1
        return Source(self.name, None, f"{kind} {self._seen[kind]}")

    def _report(self, source: Source, kind: str, error: Exception) -> None:
        text = " ".join(str(error).split()) or type(error).__name__
        self.content.diagnostics.append(rules.ENTITY.at(source, kind=kind, found=text))

    def _count(self, entity: Any, kind: str, above: LayerStyle, inside: bool) -> None:
        """Count what is not a curve, unless it is hidden anyway."""
        if not self.layers.hides(self.layers.style(attributes_of(entity), above, inside)):
            self.content.not_cut[kind] += 1

    def _is_lettered(self, entity: Any, kind: str, above: LayerStyle, inside: bool) -> bool:
        """Whether a text stands on a layer that is mapped to a mark, and shows; it is counted."""
        if kind not in entities.KINDS or not self.letters:
            return False
        style = self.layers.style(attributes_of(entity), above, inside)
        if style.layer.lower() not in self.letters or self.layers.hides(style):
            return False
        self.content.lettered[style.layer] += 1
        return True

    def run(self, run: Run, frame: InsertFrame) -> None:
        """Sort plain entities, which stand in model space."""
        attributes: Attributes | None = None
        for plain in run:
            if plain.attributes is not attributes:
                attributes = plain.attributes
                style = self.layers.style(attributes, LayerStyle(), False)
                hidden = self.layers.hides(style)
            kind = plain.kind
            source, read = self._source(kind, plain.handle), curves.BY_VALUES[kind]
            self._sort(kind, source, style, hidden, read, frame, plain.values)

    def _curve(self, entity: Any, source: Source, frame: InsertFrame, style: LayerStyle) -> None:
        kind, count = entity.dxftype(), entities.by_fit_points(entity)
        polynomial = count > 0 and style.layer.lower() in self.newton
        read = entities.through_fit_points if polynomial else entities.chains_of
        seen = self._sort(kind, source, style, self.layers.hides(style), read, frame, (entity,))
        if seen and count and not polynomial:
            self.content.diagnostics.append(rules.FIT_SPLINE.at(source, count=count))

    def _sort(
        self,
        kind: str,
        source: Source,
        style: LayerStyle,
        hidden: bool,
        read: Callable[..., list[curves.Chain]],
        frame: InsertFrame,
        values: tuple[Any, ...],
    ) -> bool:
        """Contours of the chains that `read` gives, if they are not hidden; whether there are any.

        `read` takes the frame, a list that it adds heights to, and the values.
        """
        content = self.content
        heights: curves.Heights = [] if hidden else content.heights
        count = len(heights)
        try:
            chains = read(frame, heights, *values)
            curves.check_bounds(chains)
        except _BAD_NUMBERS as error:
            del heights[count:]
            if not hidden and isinstance(error, curves.EdgeOnError):
                content.edge_on[kind] += 1
            elif not hidden:
                self._report(source, kind, error)
            return False
        if not chains:
            content.empty[kind] += 1
        if hidden:
            content.hidden += (curve for chain in chains for curve in chain)
            content.hidden_on[style.layer] += 1
            return False
        for chain in chains:
            content.contours.append(drawing.as_contour(chain, source, style.layer, style.colour))
        if chains and style.line_type:
            key = style.layer, style.colour, style.line_type
            before = content.dashed.get(key) or Dashed(*key, 0, source)
            content.dashed[key] = replace(before, count=before.count + len(chains))
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
        style = self.layers.style(attributes_of(insert), above, bool(blocks))
        name = str(insert.dxf.get("name", ""))
        for attribute in insert.attribs:
            self._count(attribute, "ATTRIB", style, True)
        block = insert.block()
        if block is None or block.block.is_xref:
            self.content.diagnostics.append(rules.BLOCK_MISSING.at(source, found=name))
            return
        if name.lower() in blocks:
            self.content.diagnostics.append(rules.BLOCK_CYCLE.at(source, found=name))
            return
        if len(blocks) >= InForce.limits.depth:
            raise ReadError(DEPTH.at(source, found=name, expected=InForce.limits.depth))
        copies = insert.mcount
        self._copies += copies
        if self._copies > MOST_COPIES:
            raise ReadError(rules.BLOCK_COUNT.at(source, found=self._copies, expected=MOST_COPIES))
        before = len(self.content.contours)
        for place in insert.multi_insert() if copies > 1 else (insert,):
            self.entities(block, frame.inside(place.matrix44()), style, (*blocks, name.lower()))
        if len(self.content.contours) > before and self.layers.hides(style):
            self.content.diagnostics.append(rules.FROZEN_INSERT.at(source, layer=style.layer))
