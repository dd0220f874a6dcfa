"""The SVG reader: every stroked shape, exact, in mm from the lower left corner of the page."""

from collections.abc import Iterator, Sequence

from beamcam.errors import Diagnostic, ReadError, Rule, Source
from beamcam.model.part import Measures
from beamcam.readers import Reading, drawing
from beamcam.readers.svg import rules
from beamcam.readers.svg.page import find_page
from beamcam.readers.svg.tree import INITIAL, StyleSheet, looks_like, parse, style_of
from beamcam.readers.svg.walk import Context, PageContent, PageWalk

__all__ = ["looks_like", "read"]


def read(
    data: bytes, name: str, units: str | None = None, width: str | float | None = None,
    layers: Sequence[str] = (), fit: Sequence[str] = (),
    wrap: str | None = None,
) -> Reading:  # fmt: skip
    """The part that an SVG file draws, and remarks on it; never raises.

    `units` names the unit of plain numbers ("mm", "px90"), `width` is the width of the page
    ("600mm"; a number is mm): for files that do not say their size, or say it wrong. `layers`
    names the layers to read; by default those that show. `fit` names layers whose polylines become
    polynomials through their vertices. `wrap` names the tube whose unrolled surface is drawn.
    """
    try:
        document = parse(data, name)
        page = find_page(document, name, units, width)
        sheet = StyleSheet()
        for text in document.styles:
            sheet.add(text)
        walk = PageWalk(name, document, page, sheet, frozenset(n.lower() for n in layers) or None)
        style = style_of(document.root, dict(INITIAL), sheet)
        hidden = style.get("display") == "none"
        walk.elements(document.root.children, Context(page.matrix, style, hidden=hidden))
    except ReadError as error:
        return Reading("svg", (), error.diagnostics)
    content, source = walk.content, Source(name)
    grid = page.unit * 10.0**-content.decimals if content.contours else None
    not_cut = tuple(sorted(content.not_cut.items()))
    measures = Measures(tuple(content.filled), tuple(content.hidden), not_cut, grid)
    part, fitted = drawing.fit_newton(
        drawing.drawing_part(name, tuple(content.contours), measures), fit
    )
    seen = [*content.not_cut.items(), ("hidden shapes", content.counts["invisible"])]
    unit = "of the page" if units is None and width is None else None
    unknown = drawing.unknown_layers(sorted(content.layers - {""}), layers, source)
    diagnostics = (
        *page.remarks, *(rules.HIDING.at(source, found=s) for s in sheet.hiding),
        *(rules.SELECTOR.at(source, found=s) for s in sheet.ignored),
        *unknown, *content.diagnostics, *fitted, *_remarks(content, source),
        *drawing.verdict(part, seen, unit, source),
    )  # fmt: skip
    return drawing.wrapped(Reading("svg", (part,), diagnostics), wrap)


#: Remarks on the drawing.counted shapes, in this order.
_COUNTED: tuple[tuple[str, Rule], ...] = (
    ("filled", rules.FILL_ONLY), ("clipped", rules.CLIPPED), ("flattened", rules.FLATTENED),
    ("invisible", rules.INVISIBLE), ("dashed", rules.DASHED), ("hairline", rules.HAIRLINE),
    ("degenerate", rules.DEGENERATE),
)  # fmt: skip


def _remarks(content: PageContent, source: Source) -> Iterator[Diagnostic]:
    """Remarks on elements that are not contours, by kind and count."""
    if content.not_cut["text"]:
        yield rules.TEXT.at(source, count=content.not_cut["text"])
    others = [(tag, count) for tag, count in sorted(content.not_cut.items()) if tag != "text"]
    if others:
        yield rules.NOT_CUT.at(source, found=drawing.counted(others))
    for key, rule in _COUNTED:
        if content.counts[key]:
            yield rule.at(source, count=content.counts[key])
