"""Every entity of model space, inserts opened, sorted into what is read and what is not."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from msgspec import Struct, field

from beamcam.budget import DEPTH, limits
from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.geometry.curves import Curve
from beamcam.model.part import Contour, TextMark
from beamcam.readers.drawing import as_contour
from beamcam.readers.dxf import rules
from beamcam.readers.dxf.bulk import MARKER, Run
from beamcam.readers.dxf.curves import BY_VALUES, Chain, EdgeOnError, Heights, check_bounds
from beamcam.readers.dxf.entities import CURVES, by_fit_points, is_curve, through_fit_points
from beamcam.readers.dxf.frame import Frame
from beamcam.readers.dxf.layers import Attributes, Layers, Look, attributes_of
from beamcam.readers.dxf.texts import KINDS, text_marks

#: More copies of blocks than this are a damaged number, or blocks that multiply each other.
MOST_COPIES = 20_000

# What numbers that make no curve end in, here and inside ezdxf.
_BAD_NUMBERS = (ValueError, TypeError, ArithmeticError, LookupError)


class Collected(Struct):
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
    said: list[Diagnostic] = field(default_factory=list)


class Walk(Struct):
    """One pass over a document."""

    name: str
    layers: Layers
    handles: bool  #: whether entities have names of their own
    runs: Iterator[Run] = iter(())  #: the plain entities that stand at the markers
    newton: frozenset[str] = frozenset()  #: layers whose fit points are nodes of polynomials
    letters: frozenset[str] = frozenset()  #: layers whose texts are lettered
    found: Collected = field(default_factory=Collected)
    _seen: Counter[str] = field(default_factory=Counter)
    _copies: int = 0  #: of blocks, so far

    def entities(
        self, entities: Iterable[Any], frame: Frame, above: Look, blocks: tuple[str, ...]
    ) -> None:
        """Sort `entities`, which stand in `frame` in the innermost of `blocks`."""
        from ezdxf.lldxf.const import DXFError

        for entity in entities:
            kind = entity.dxftype()
            if kind == MARKER:
                self._run(next(self.runs), frame)
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
        said = " ".join(str(error).split()) or type(error).__name__
        self.found.said.append(rules.ENTITY.at(source, kind=kind, found=said))

    def _count(self, entity: Any, kind: str, above: Look, inside: bool) -> None:
        """Count what is not a curve, unless it is hidden anyway."""
        if not self.layers.hides(self.layers.look(attributes_of(entity), above, inside)):
            self.found.not_cut[kind] += 1

    def _is_lettered(self, entity: Any, kind: str, above: Look, inside: bool) -> bool:
        """Whether a text stands on a layer that is mapped to a mark, and shows; it is counted."""
        if kind not in KINDS or not self.letters:
            return False
        look = self.layers.look(attributes_of(entity), above, inside)
        if look.layer.lower() not in self.letters or self.layers.hides(look):
            return False
        self.found.lettered[look.layer] += 1
        return True

    def _run(self, run: Run, frame: Frame) -> None:
        """Sort plain entities, which stand in model space."""
        said: Attributes | None = None
        for plain in run:
            if plain.says is not said:
                said = plain.says
                look = self.layers.look(said, Look(), False)
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

    def _curve(self, entity: Any, source: Source, frame: Frame, look: Look) -> None:
        kind = entity.dxftype()
        polynomial = by_fit_points(entity) > 0 and look.layer.lower() in self.newton
        read = through_fit_points if polynomial else CURVES[kind]
        seen = self._sort(kind, source, look, self.layers.hides(look), read, frame, (entity,))
        if seen and not polynomial and (count := by_fit_points(entity)):
            self.found.said.append(rules.FIT_SPLINE.at(source, count=count))

    def _sort(
        self,
        kind: str,
        source: Source,
        look: Look,
        hidden: bool,
        read: Callable[..., list[Chain]],
        frame: Frame,
        values: tuple[Any, ...],
    ) -> bool:
        """Contours of the chains that `read` gives, if they are not hidden; whether there are any.

        `read` takes the frame, a list that it adds heights to, and the values.
        """
        found = self.found
        heights: Heights = [] if hidden else found.heights
        count = len(heights)
        try:
            chains = read(frame, heights, *values)
            check_bounds(chains)
        except _BAD_NUMBERS as error:
            del heights[count:]
            if not hidden and isinstance(error, EdgeOnError):
                found.edge_on[kind] += 1
            elif not hidden:
                self._say_entity(source, kind, error)
            return False
        if not chains:
            found.empty[kind] += 1
        if hidden:
            found.hidden += (curve for chain in chains for curve in chain)
            found.hidden_on[look.layer] += 1
            return False
        for chain in chains:
            found.contours.append(as_contour(chain, source, look.layer, look.colour))
        return bool(chains)

    def _insert(
        self, insert: Any, source: Source, frame: Frame, above: Look, blocks: tuple[str, ...]
    ) -> None:
        """Open an insert: its block, once for each place of its array."""
        look = self.layers.look(attributes_of(insert), above, bool(blocks))
        name = str(insert.dxf.get("name", ""))
        for attribute in insert.attribs:
            self._count(attribute, "ATTRIB", look, True)
        block = insert.block()
        if block is None or block.block.is_xref:
            self.found.said.append(rules.BLOCK_MISSING.at(source, found=name))
            return
        if name.lower() in blocks:
            self.found.said.append(rules.BLOCK_CYCLE.at(source, found=name))
            return
        if len(blocks) >= limits().depth:
            raise ReadError(DEPTH.at(source, found=name, expected=limits().depth))
        copies = insert.mcount
        self._copies += copies
        if self._copies > MOST_COPIES:
            raise ReadError(rules.BLOCK_COUNT.at(source, found=self._copies, expected=MOST_COPIES))
        before = len(self.found.contours)
        for place in insert.multi_insert() if copies > 1 else (insert,):
            self.entities(block, frame.inside(place.matrix44()), look, (*blocks, name.lower()))
        if len(self.found.contours) > before and self.layers.hides(look):
            self.found.said.append(rules.FROZEN_INSERT.at(source, layer=look.layer))
