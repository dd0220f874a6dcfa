"""Every shape of a drawing, groups and uses opened, sorted into what is read and what is not.

An own walk, as svgelements drops what it does not know in silence, knows no line of the file,
keeps no layers, and reads T behind a cubic and S behind a quadratic curve as the standard does
not. The walk may not pass over anything: what it does not read is a diagnostic. Where svgelements
follows the standard, paths, transforms and lengths are equal to its own:
tests/property/test_svg_laws.py.
"""

import re
from collections import Counter
from collections.abc import Iterable
from contextlib import suppress

from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.errors import Diagnostic, ReadError, Rule, Source
from beamcam.geometry.curves import Curve
from beamcam.geometry.plane import MAX_COORDINATE, Matrix
from beamcam.model.colour import is_transparent, parse_colour
from beamcam.model.part import Contour
from beamcam.readers.drawing import as_contour, is_in_bounds, split_length
from beamcam.readers.svg import rules
from beamcam.readers.svg.page import (
    NumberError,
    Page,
    fit_of,
    parse_transform,
    product,
    scale,
    shift,
    view_box,
)
from beamcam.readers.svg.path import SHAPES, PathError, Subpath, decimals, length_of, subpaths_of
from beamcam.readers.svg.tree import (
    MOST_DEEP,
    Document,
    Element,
    Style,
    StyleSheet,
    is_nothing,
    style_of,
)

_ESCAPED = re.compile(r"_x([0-9A-Fa-f]{4})_")
_NUMBER = re.compile(r"_?\d+\Z")


def layer_of(group: Element, depth: int) -> str | None:
    """The layer's name if `group` is a layer, None if not.

    Inkscape marks layers. CorelDRAW begins one with a `metadata` element and escapes its name
    (`Layer_x0020_1`). Elsewhere a named group at the top is one; a number is not a name.
    """
    if group.get("inkscape:groupmode") == "layer":
        return group.get("inkscape:label") or _name(group)
    marked = bool(group.children) and (group.children[0].get("id") or "").startswith("CorelCorpID")
    return _name(group) if marked or depth == 0 else None


def _name(group: Element) -> str | None:
    """The id of a group, "Layer 1" of "Layer_x0020_1"; None where it is none or a number."""
    name = group.get("id")
    if name is None or _NUMBER.match(name):
        return None
    return _ESCAPED.sub(lambda letter: chr(int(letter[1], 16)), name)


_GROUPS = ("g", "a", "svg", "use", "switch")
_TEXTS = ("text", "flowRoot")
_NOT_CUT = ("image", "foreignObject", "video", "audio", "iframe", "canvas")

#: A drawing that opens more uses than this multiplies itself.
MOST_USES = 10_000


class PageContent(Struct):
    """Results of reading the elements of a drawing."""

    contours: list[Contour] = field(default_factory=list)
    filled: list[Curve] = field(default_factory=list)
    hidden: list[Curve] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)  #: of shapes, by what is said of them
    not_cut: Counter[str] = field(default_factory=Counter)  #: elements by tag
    layers: set[str] = field(default_factory=set)  #: names of those with shapes, "" for none
    decimals: int = 0  #: the most digits behind a point in coordinates
    diagnostics: list[Diagnostic] = field(default_factory=list)


#: What a child of a switch asks for that shows in some programs only.
_ASKING = frozenset(("requiredExtensions", "requiredFeatures", "systemLanguage"))
_OF_SYMBOL = ("viewBox", "preserveAspectRatio", "style", "class")


class Context(Struct, frozen=True):
    """Context of an element."""

    matrix: Matrix  #: to mm
    style: Style
    layer: str | None = None
    hidden: bool = False  #: in something with display none
    depth: int = 0


class PageWalk(Struct):
    """One pass over a document."""

    name: str
    document: Document
    page: Page
    sheet: StyleSheet
    chosen: frozenset[str] | None = None  #: layers to read, in lower case; None is all
    content: PageContent = field(default_factory=PageContent)

    def elements(self, elements: Iterable[Element], context: Context) -> None:
        """Sort elements and their content; what only defines something is passed over."""
        for element in elements:
            tag = element.tag
            if tag in _TEXTS or tag in _NOT_CUT:
                style = style_of(element, context.style, self.sheet)
                if not context.hidden and not _is_hidden(style):
                    self.content.not_cut["text" if tag in _TEXTS else tag] += 1
            elif tag in SHAPES or tag in _GROUPS:
                if (inner := self._inside(element, context)) is None:
                    continue
                if tag in SHAPES:
                    self._shape(element, inner)
                elif tag == "use":
                    self._use(element, inner)
                elif tag == "switch":  # the first that asks for nothing special shows
                    plain = [c for c in element.children if _ASKING.isdisjoint(c.attributes)]
                    self.elements(plain[:1], inner)
                else:
                    self.elements(element.children, inner)

    def _report(self, rule: Rule, element: Element, **values: object) -> None:
        self.content.diagnostics.append(rule.at(self._source(element), **values))

    def _report_number(self, element: Element, error: NumberError) -> None:
        found = {"attribute": error.attribute, "found": error.found}
        self._report(rules.NUMBER, element, **found, expected=error.expected)

    def _source(self, element: Element) -> Source:
        return Source(self.name, element.line, element.get("id"))

    def _inside(self, element: Element, context: Context) -> Context | None:
        """Context of the content of `element`; None if its transform cannot be read."""
        if context.depth > MOST_DEEP:
            raise ReadError(rules.DEPTH.at(self._source(element), expected=MOST_DEEP))
        style = style_of(element, context.style, self.sheet)
        matrix = context.matrix
        text = element.get("transform")
        try:
            if element.tag == "svg":
                matrix = product(matrix, self._viewport(element))
            if text is not None:
                matrix = product(matrix, parse_transform(text))
        except NumberError as error:
            self._report_number(element, error)
            return None
        except ValueError as error:
            self._report(rules.TRANSFORM, element, found=text, expected=error)
            return None
        layer = layer_of(element, context.depth) if element.tag == "g" else None
        hidden = context.hidden or style.get("display") == "none"
        hidden = hidden or is_nothing(style.get("opacity", "1"))
        for name in ("clip-path", "mask"):
            if style.get(name, "none") != "none":
                self.content.counts["clipped"] += 1
        return Context(matrix, style, layer or context.layer, hidden, context.depth + 1)

    def _viewport(self, element: Element) -> Matrix:
        """The map of an svg inside the drawing: its place, and its viewBox onto its size."""
        sides = ("x", "y", "width", "height")
        x, y, width, height = (length_of(element, side, self.page.view) for side in sides)
        text = element.get("viewBox")
        if text is None or not width or not height:
            return shift(x, y)
        left, top, across, down = view_box(text)
        fit = fit_of(element.get("preserveAspectRatio"))
        sx, sy = fit.scales(width / across, height / down)
        x += (width - across * sx) * fit.share_x - left * sx
        y += (height - down * sy) * fit.share_y - top * sy
        return product(shift(x, y), scale(sx, sy))

    # --- uses -------------------------------------------------------------------------------------

    def _use(self, element: Element, context: Context) -> None:
        """The content of a use: the element that it names, moved by its x and y."""
        reference = element.get("href") or element.get("xlink:href") or ""
        target = self.document.ids.get(reference[1:]) if reference.startswith("#") else None
        if target is None:
            self._report(rules.USE, element, found=reference)
            return
        self.content.counts["uses"] += 1
        if self.content.counts["uses"] > MOST_USES:
            raise ReadError(rules.USES.at(self._source(element), expected=MOST_USES))
        try:
            x, y = (length_of(element, side, self.page.view) for side in ("x", "y"))
        except NumberError as error:
            self._report_number(element, error)
            return
        moved = replace(context, matrix=product(context.matrix, shift(x, y)))
        if target.tag == "symbol":
            size = {k: v for k in ("width", "height") if (v := element.get(k))}
            view = {k: v for k in _OF_SYMBOL if (v := target.get(k))}
            target = Element("svg", {**size, **view}, target.line, target.children)
        self.elements((target,), moved)

    # --- shapes -----------------------------------------------------------------------------------

    def _shape(self, element: Element, context: Context) -> None:
        source = self._source(element)
        try:
            subpaths = subpaths_of(element, self.page.view)
        except PathError as error:
            self._report(rules.PATH, element, found=error.found, expected=error.expected)
            return
        except NumberError as error:
            self._report_number(element, error)
            return
        chains = self._placed(subpaths, context.matrix)
        if not all(is_in_bounds(curve) for chain in chains for curve in chain):
            expected = f"coordinates of at most {MAX_COORDINATE:g} mm"
            self._report_number(element, NumberError(element.tag, "no such number", expected))
        elif chains:
            self._sort(element, chains, context, source)

    def _placed(self, subpaths: Iterable[Subpath], matrix: Matrix) -> list[tuple[Curve, ...]]:
        """The chains in mm, without those of no length."""
        chains: list[tuple[Curve, ...]] = []
        for subpath in subpaths:
            try:
                chain = tuple(curve.transformed(matrix) for curve in subpath)
            except ValueError:  # circles have no image if the map presses them to a line
                self.content.counts["flattened"] += 1
                continue
            if any(c.start != c.end or c.bbox[:2] != c.bbox[2:] for c in chain):
                chains.append(chain)
            else:
                self.content.counts["degenerate"] += 1
        return chains

    def _sort(
        self, element: Element, chains: list[tuple[Curve, ...]], context: Context, source: Source
    ) -> None:
        """Contours if the shape has a stroke, else filled, or hidden."""
        style = context.style
        self.content.layers.add(context.layer or "")
        unwanted = self.chosen is not None and (context.layer or "").lower() not in self.chosen
        hidden = unwanted or context.hidden or _is_hidden(style)
        if not hidden and _is_painted(style, "stroke"):
            colour = self._colour(style, source)
            self._note_stroke(element, style)
            contours = [as_contour(chain, source, context.layer, colour) for chain in chains]
            self.content.contours += contours
        elif not hidden and _is_painted(style, "fill"):
            self.content.counts["filled"] += 1
            self.content.filled += (curve for chain in chains for curve in chain)
        else:
            self.content.counts["invisible"] += 1
            self.content.hidden += (curve for chain in chains for curve in chain)

    def _note_stroke(self, element: Element, style: Style) -> None:
        """Remarks on a stroked shape: hairlines, dashes, its grid."""
        with suppress(ValueError):  # browsers draw a stroke of no length 1 px wide
            self.content.counts["hairline"] += split_length(style["stroke-width"])[0] == 0.0
        self.content.counts["dashed"] += style["stroke-dasharray"] not in ("none", "")
        numbers = element.get("d") or element.get("points")
        if numbers is None:
            numbers = " ".join(v for k, v in element.attributes.items() if k in _COORDINATES)
        self.content.decimals = decimals(numbers, self.content.decimals)

    def _colour(self, style: Style, source: Source) -> str | None:
        """The stroke as "#rrggbb"; None for a pattern, or where it cannot be read."""
        text = style["stroke"]
        if text.lower() == "currentcolor":
            text = style["color"]
        if text.startswith("url("):
            text = text.partition(")")[2].strip()
            if not text:
                return None
        try:
            return parse_colour(text.split(" icc-color")[0])
        except ValueError:
            self.content.diagnostics.append(rules.COLOUR.at(source, found=text))
            return None


_COORDINATES = frozenset(
    ("x", "y", "width", "height", "rx", "ry", "cx", "cy", "r", "x1", "y1", "x2", "y2")
)


def _is_hidden(style: Style) -> bool:
    return (
        style.get("display") == "none" or style["visibility"] in ("hidden", "collapse")
        or is_nothing(style.get("opacity", "1"))
    )  # fmt: skip


def _is_painted(style: Style, paint: str) -> bool:
    """Whether a stroke or a fill shows; a width of 0 is a hairline and does."""
    if style[paint].lower() in ("none", "") or is_transparent(style[paint]):
        return False
    try:
        opacity = split_length(style[f"{paint}-opacity"])[0]
    except ValueError:  # a value that browsers ignore
        return True
    return opacity > 0.0
