"""What the map of colours and layers makes of the curves of a drawing, other than cuts.

Lines that it takes away from cutting are a note with their number, lines with gaps that are cut a
warning, and a key that no curve has is misspelt.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from beamcam.errors import Diagnostic, Source, error, note, warning
from beamcam.geometry.plane import Box, join_boxes
from beamcam.machine.torch import OTHERS, Torch
from beamcam.model.colour import colour_name, key_of
from beamcam.model.part import Contour, Dashed, Part
from beamcam.model.plan import HATCH, SheetPlan

NOT_CUT = note("plan-not-cut",
    "found {count} curve(s) {look}; the map has them {how}, not cut",
    "A colour or a layer that is mapped to mark, engrave or ignore leaves no cut in the "
    "sheet.")  # fmt: skip

CLOSED_MARK = warning("plan-closed-mark",
    "found {count} closed contour(s) {look} within what is cut; the map has them {how}, and no "
    "opening is cut there; expected --map '{key}=cut' for openings, '{key}={process}' for marks",
    "Drawing programs give holes and marks colours of their own, and which are which is a matter "
    "of custom. A key of the map, or `settled` in the machine file, says so.")  # fmt: skip
DASHED = warning("plan-dashed",
    "found {count} contour(s) {look} in the line type {line_type!r}, which are cut as whole lines; "
    "expected centre lines and hidden edges on a layer with --map '{key}=ignore', or '{key}=cut' "
    "if these are cuts",
    "A line with gaps mostly shows an axis, a bend or an edge that is hidden, and is not to be "
    "cut. Where it shares its layer with cuts, it needs one of its own in the drawing. A key of "
    "the map, or `settled` in the machine file, says what it is.")  # fmt: skip

MAPPED_AWAY = {"map-ignore": "ignored", "mark": "marked", "engrave": "engraved"}

UNMATCHED = error("plan-map-key",
    "found --map {found}, a colour or layer that no curve has; expected one of {expected}",
    "A key that matches nothing is misspelt, or meant for another drawing; the curves that it was "
    "meant for would be cut as something else.")  # fmt: skip
IDLE = note("plan-map-idle",
    "found no curve of colour or layer {found} in any drawing",
    "A key of the map that nothing in the whole run matches may be misspelt.")  # fmt: skip


def map_remarks(plan: SheetPlan, torch: Torch) -> Iterator[Diagnostic]:
    """Remarks on each look that is not cut, and on lines with gaps that are."""
    yield from _not_cut(plan, torch)
    for part in {id(piece.part): piece.part for piece in plan.pieces}.values():
        yield from _dashed(part, torch)


def _not_cut(plan: SheetPlan, torch: Torch) -> Iterator[Diagnostic]:
    """The curves by colour and layer that the map takes away from cutting."""
    curves: Counter[tuple[str | None, str | None, str]] = Counter()
    inside: Counter[tuple[str | None, str | None, str]] = Counter()
    first: dict[tuple[str | None, str | None, str], Contour] = {}
    rings: list[Box] | None = None
    for outcome in plan.outcomes:
        piece, index = outcome.feature
        feature = plan.pieces[piece].part.features[index]
        if outcome.by not in MAPPED_AWAY or not isinstance(feature, Contour):
            continue
        if feature.source.where == HATCH:  # which the drawing does not have
            continue
        look = feature.layer, feature.colour, outcome.by
        if look[:2] != (None, None):
            curves[look] += len(feature.curves)
            first.setdefault(look, feature)
            if feature.closed:
                rings = _boxes_cut(plan) if rings is None else rings
                x0, y0, x1, y1 = join_boxes([c.bbox for c in feature.curves]) or (0.0,) * 4
                inside[look] += any(a < x0 and b < y0 and x1 < c and y1 < d for a, b, c, d in rings)
    for look, count in curves.items():
        contour, process, named = first[look], look[2], _look_named(*look[:2])
        if process == "mark" and inside[look] and not _is_settled(contour, torch):
            yield CLOSED_MARK.at(
                contour.source, count=inside[look], look=named, how=MAPPED_AWAY[process],
                key=_key(contour, [piece.part for piece in plan.pieces]), process=process,
            )  # fmt: skip
        else:
            yield NOT_CUT.at(contour.source, count=count, look=named, how=MAPPED_AWAY[process])


def _boxes_cut(plan: SheetPlan) -> list[Box]:
    """The boxes of the closed contours that are cut, as they are drawn."""
    boxes_cut = []
    for op in plan.operations:
        if op.closed and op.row.process == "cut":
            drawn = [plan.pieces[piece].part.features[k] for piece, k in op.features]
            curves = [c for f in drawn if isinstance(f, Contour) for c in f.curves]
            if (box := join_boxes([curve.bbox for curve in curves])) is not None:
                boxes_cut.append(box)
    return boxes_cut


def _dashed(part: Part, torch: Torch) -> Iterator[Diagnostic]:
    """Lines of a drawing with gaps that are cut, by their look and line type."""
    for lines in part.measures.dashed if part.measures is not None else ():
        key = key_of(lines, torch.colours)
        if key is not None and torch.colours[key] == "cut" and not _is_settled(lines, torch):
            yield DASHED.at(
                lines.source, count=lines.count, look=_look_named(lines.layer, lines.colour),
                line_type=lines.line_type, key=_key(lines, [part]),
            )  # fmt: skip


def _is_settled(lines: Contour | Dashed, torch: Torch) -> bool:
    """Whether somebody has said what lines of a look are for, and not custom alone."""
    key = key_of(lines, torch.colours)
    by_layer = lines.layer is not None and (key or "").casefold() == lines.layer.casefold()
    return by_layer or key in torch.settled


def _key(lines: Contour | Dashed, parts: Iterable[Part]) -> str:
    """The key of the map for lines of a look: their layer, unless that has other colours too."""
    if lines.layer is not None:
        drawn = (f for part in parts for f in part.contours if f.layer == lines.layer)
        if all(contour.colour == lines.colour for contour in drawn):
            return lines.layer
    return colour_name(lines.colour or "")


def _look_named(layer: str | None, colour: str | None) -> str:
    words = [] if colour is None else [f"of colour {colour_name(colour)}"]
    return " ".join([*words, *([] if layer is None else [f"on layer {layer!r}"])])


def curves_by_key(parts: Iterable[Part], table: Iterable[str]) -> Counter[str]:
    """Number of curves and texts of the parts that each key of the map matches."""
    keys = tuple(table)
    known: dict[tuple[str | None, str | None], str | None] = {}
    counts: Counter[str] = Counter()
    for part in parts:
        for feature in part.features:
            if isinstance(feature, Contour):
                look = feature.layer, feature.colour
                if look not in known:
                    known[look] = key_of(feature, keys)
                key = known[look]
                if key is not None:
                    counts[key] += len(feature.curves)
        for layer, count in part.measures.lettered if part.measures is not None else ():
            counts.update({key: count for key in keys if key.lower() == layer.lower()})
    return counts


def unmatched(
    processes: Mapping[str, str], parts: Sequence[Part], table: Iterable[str]
) -> Iterator[Diagnostic]:
    """An error for each requested key that matches no curve of the parts."""
    used = curves_by_key(parts, table)
    for key, process in processes.items():
        if key not in used and key != OTHERS:
            source = parts[0].source if parts else Source("--map")
            expected = ", ".join(_looks(parts)) or "none, no curve has a colour or a layer"
            yield UNMATCHED.at(source, found=f"{key}={process}", expected=expected)


def idle(keys: Iterable[str], used: Iterable[str], source: Source) -> Iterator[Diagnostic]:
    """A note for each key that nothing of a whole run matched."""
    known = set(used)
    return (IDLE.at(source, found=key) for key in keys if key not in known and key != OTHERS)


def _looks(parts: Iterable[Part]) -> list[str]:
    """The layers and colours that contours of the parts have, sorted."""
    contours = [f for part in parts for f in part.features if isinstance(f, Contour)]
    layers = {c.layer for c in contours if c.layer is not None}
    colours = {colour_name(c.colour) for c in contours if c.colour is not None}
    return [*sorted(layers), *sorted(colours)]
