"""Reading a DXF file: bytes to a document, its entities to exact curves, those to one part."""

from collections import Counter
from collections.abc import Sequence

from msgspec.structs import replace

from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.model.drawing import Measures
from beamcam.model.part import Part
from beamcam.readers.drawing import LARGEST_SIZE, counted, drawing_part, unknown_layers
from beamcam.readers.drawing.newton import fit_newton
from beamcam.readers.drawing.rules import NO_CURVES, TOO_LARGE
from beamcam.readers.dxf import rules
from beamcam.readers.dxf.frame import scaled
from beamcam.readers.dxf.layers import Layers, Look
from beamcam.readers.dxf.load import load, looks_like
from beamcam.readers.dxf.units import Unit, contradictions, find_unit
from beamcam.readers.dxf.walk import Collected, Walk
from beamcam.readers.reading import Reading

__all__ = ["looks_like", "read"]

#: Heights that differ by less are noise of the writer: files carry 1e-9 to 1e-7.
FLAT = 1e-3


def read(
    data: bytes,
    name: str,
    units: str | None = None,
    layers: Sequence[str] = (),
    fit: Sequence[str] = (),
    letters: Sequence[str] = (),
) -> Reading:
    """The part that a DXF file draws in model space, and what is to be said; never raises.

    `units` ("mm", "in", ...) overrides what the file says about its unit. `layers` names the
    layers to read, hidden ones too; by default those that are visible and plot. `fit` names layers
    whose polylines and splines by fit points become polynomials through their vertices, `letters`
    those whose texts are to be lettered.
    """
    source = Source(name)
    unit, said = find_unit(data, units, source)
    if unit is None:
        return Reading("dxf", (), said)
    try:
        loaded = load(data, source)
    except ReadError as error:
        return Reading("dxf", (), error.diagnostics)
    said += loaded.remarks
    chosen = Layers(loaded.document, frozenset(n.lower() for n in layers) or None)
    said += unknown_layers(chosen.names(), layers, source)
    newton = frozenset(n.lower() for n in fit)
    walk = Walk(name, chosen, loaded.handles, iter(loaded.runs), newton,
                frozenset(n.lower() for n in letters))  # fmt: skip
    try:
        walk.entities(loaded.document.modelspace(), scaled(unit.mm), Look(), ())
    except ReadError as error:
        return Reading("dxf", (), said + error.diagnostics)
    part, fitted = fit_newton(_part(name, walk.found), fit)
    said += (
        *contradictions(loaded.document, unit, name),
        *walk.found.said,
        *fitted,
        *_remarks(walk.found, source),
        *_verdict(part, walk.found, unit, source),
    )
    return Reading("dxf", (part,), said)


def _part(name: str, found: Collected) -> Part:
    not_cut = tuple(sorted(found.not_cut.items()))
    lettered = tuple(sorted(found.lettered.items()))
    measures = Measures((), tuple(found.hidden), not_cut, lettered=lettered)
    part = drawing_part(name, tuple(found.contours), measures)
    return replace(part, features=(*part.features, *found.texts)) if found.texts else part


def _remarks(found: Collected, source: Source) -> list[Diagnostic]:
    """Remarks on entities that are not contours, by kind and count."""
    said = []
    if found.not_cut:
        said.append(rules.NOT_CUT.at(source, found=_list(found.not_cut)))
    if found.edge_on:
        said.append(rules.EDGE_ON.at(source, found=_list(found.edge_on)))
    if found.empty:
        said.append(rules.EMPTY_CURVES.at(source, found=_list(found.empty)))
    if found.hidden_on:
        count = sum(found.hidden_on.values())
        said.append(rules.HIDDEN.at(source, count=count, found=_list(found.hidden_on)))
    if found.heights:
        low, high = min(found.heights), max(found.heights)
        if high - low > FLAT:
            said.append(rules.NOT_FLAT.at(source, low=low, high=high))
    return said


def _list(counts: Counter[str]) -> str:
    return counted(sorted(counts.items()))


def _verdict(part: Part, found: Collected, unit: Unit, source: Source) -> list[Diagnostic]:
    """An error for a drawing without curves, a warning for one that no machine could hold."""
    if not found.contours and not found.texts:
        hidden = Counter({"hidden curves": sum(found.hidden_on.values())})
        return [NO_CURVES.at(source, found=_list(+(hidden + found.not_cut)))]
    width, height = part.length, part.profile.height
    if max(width, height) > LARGEST_SIZE and not unit.given:
        return [TOO_LARGE.at(source, width=width, height=height, unit=unit.name)]
    return []
