"""The DXF reader: every curve of model space, exact, in mm."""

from collections.abc import Sequence

from msgspec.structs import replace

from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.model.part import Measures, Part
from beamcam.readers import Reading
from beamcam.readers.drawing import (
    counted,
    drawing_part,
    fit_newton,
    unknown_layers,
    verdict,
    wrapped,
)
from beamcam.readers.dxf import rules
from beamcam.readers.dxf.curves import scaled
from beamcam.readers.dxf.layers import Layers, LayerStyle
from beamcam.readers.dxf.load import contradictions, find_unit, load_document, looks_like
from beamcam.readers.dxf.walk import DrawingContent, DrawingWalk

__all__ = ["RULES", "looks_like", "read"]

RULES = rules.RULES


#: Heights that differ by less are noise of the writer: files carry 1e-9 to 1e-7.
FLAT = 1e-3


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
    chosen = Layers(loaded.tables, _folded(layers) or None)
    diagnostics += (*loaded.remarks, *unknown_layers(chosen.names(), layers, source))
    runs, frame = iter(loaded.runs), scaled(unit.mm)
    walk = DrawingWalk(name, chosen, loaded.handles, runs, _folded(fit), _folded(letters))
    try:
        if loaded.document is None:
            walk.run(next(runs), frame)
        else:
            walk.entities(loaded.document.modelspace(), frame, LayerStyle(), ())
    except ReadError as error:
        return Reading("dxf", (), diagnostics + error.diagnostics)
    collected = walk.found
    part, fitted = _part(name, collected, fit)
    seen = sorted([*collected.not_cut.items(), ("hidden curves", collected.hidden_on.total())])
    diagnostics += (
        *contradictions(loaded.document, unit, name),
        *collected.diagnostics,
        *fitted,
        *_remarks(collected, source),
        *verdict(part, seen, None if unit.given else unit.name, source),
    )
    return wrapped(Reading("dxf", (part,), diagnostics), wrap)


def _folded(names: Sequence[str]) -> frozenset[str]:
    return frozenset(name.lower() for name in names)


def _part(
    name: str, collected: DrawingContent, fit: Sequence[str]
) -> tuple[Part, tuple[Diagnostic, ...]]:
    """The part of a drawing, polylines on the layers of `fit` as polynomials; what is said."""
    not_cut = tuple(sorted(collected.not_cut.items()))
    lettered = tuple(sorted(collected.lettered.items()))
    dashed = tuple(collected.dashed.values())
    measures = Measures((), tuple(collected.hidden), not_cut, lettered=lettered, dashed=dashed)
    part, fitted = fit_newton(drawing_part(name, tuple(collected.contours), measures), fit)
    return replace(part, features=(*part.features, *collected.texts)), fitted


def _remarks(collected: DrawingContent, source: Source) -> list[Diagnostic]:
    """Remarks on entities that are not contours, by kind and count."""
    by_kind = (
        (rules.NOT_CUT, collected.not_cut),
        (rules.EDGE_ON, collected.edge_on),
        (rules.EMPTY_CURVES, collected.empty),
        (rules.HIDDEN, collected.hidden_on),
    )
    diagnostics = [
        rule.at(source, count=counts.total(), found=counted(sorted(counts.items())))
        for rule, counts in by_kind
        if counts
    ]
    if collected.heights:
        low, high = min(collected.heights), max(collected.heights)
        if high - low > FLAT:
            diagnostics.append(rules.NOT_FLAT.at(source, low=low, high=high))
    return diagnostics
