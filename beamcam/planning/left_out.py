"""What a program does not make of its parts, or makes otherwise than by cutting, reported by name.

Nothing that a part has is missing from a program without a word: what was left out because
`--allow-skips` names its kind, or is left for manual work, is a warning at the feature. The list of
manual work (`manual_list.py`) has a row for each.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from beamcam.errors import Diagnostic, Source, error, note, warning
from beamcam.geometry.plane import Box, join_boxes
from beamcam.machine.stations import Marks
from beamcam.machine.torch import OTHERS, Torch
from beamcam.model.colour import colour_name, key_of
from beamcam.model.description import description
from beamcam.model.part import Bend, Camber, Contour, Dashed, Feature, Part, TextMark
from beamcam.model.plan import HATCH, AnyPlan, SheetPlan, unfinished
from beamcam.model.request import mark_kind, policy_on
from beamcam.planning import rules

TEXT_MOVED = warning("plan-text-moved",
    "the text {text!r} is lettered at x {x}, y {y}, {height} mm high; found no room {distance} mm "
    "clear at x {wanted_x}, y {wanted_y}, {wanted_height} mm high",
    "Letters on an edge or over a hole cannot be read. `marks.min_distance` and `marks.min_height` "
    "of the machine file say how much room is kept, and how small letters may be.")  # fmt: skip
TEXT_SIGN = warning("plan-text-sign",
    "found {sign!r} in the text {text!r}; expected a character of {has}, {other!r} is written",
    "`marks.replace` of the machine file says what is written for a character that no letter of "
    "the font, or of the stamp or printer, stands for.")  # fmt: skip
TEXT_HEIGHT = note("plan-text-height",
    "found the text {text!r} {found} mm high; it is lettered {height} mm high, the nearest of the "
    "machine's",
    "`marks.heights` of the machine file says in which heights its stamp or printer "
    "letters.")  # fmt: skip
TEXT_SEARCH = error("plan-text-search",
    "found no end of the search for a place of the text {text!r} on face {face} in {most} steps; "
    'expected room where the part has it, fewer texts, or text = "list" in [marks]',
    "A text is moved to the nearest place that is clear. Among hundreds of texts or holes that may "
    "take for good; so that none is left out that has a place, the part is refused.")  # fmt: skip

#: Why a mark is left for manual work, by its name in the ledger.
BY_POLICY, NO_UNIT = "marks", "no-unit"
NO_ROOM, TOO_SMALL, BLANK, FACE = "no-room", "too-small", "blank", "face"
CHARACTERS, ANGLE, HEIGHT = "characters", "angle", "height"
NOT_MOVED = "not-moved"
#: Of features that are only begun by the machine.
DRILL, BEVEL, ROOT, BEND, CAMBER = "drill", "bevel", "root", "bend", "camber"
REASONS = {
    BY_POLICY: "the machine file leaves such marks for manual work",
    NO_UNIT: "the machine has no unit that letters",
    NO_ROOM: "there is no room for it on its face",
    TOO_SMALL: "the machine does not letter so small",
    BLANK: "none of its characters can be seen",
    FACE: "the lettering unit does not reach that face",
    CHARACTERS: "the machine has no characters for it",
    ANGLE: "the machine does not letter at that angle",
    NOT_MOVED: "it is not clear of edges and holes there, and the machine moves no text",
    HEIGHT: "the machine does not letter at that height, which is binding",
    DRILL: "the torch cannot make it and marks its centre for the drill",
    BEVEL: "the torch cuts square what is bevelled or skew through the wall",
    ROOT: "the torch leaves steel at a root, where it does not reach",
    BEND: "the machine makes the blank, and does not bend",
    CAMBER: "the machine makes the straight beam, and does not camber it",
}


def listed_by(feature: Feature, marks: Marks) -> str | None:
    """Why a mark is manual work wherever it is; None if it is not."""
    policy = policy_on(feature, marks)
    if policy == "make" and isinstance(feature, TextMark) and marks.unit == "none":
        return NO_UNIT
    if policy != "list":
        return None
    if isinstance(feature, Camber):
        return CAMBER
    return BEND if isinstance(feature, Bend) else BY_POLICY


def refuse_mark(feature: Feature, marks: Marks) -> Diagnostic | None:
    """Why a mark is refused whatever the machine could do; None if it is not."""
    if policy_on(feature, marks) != "refuse":
        return None
    why = f'marks.{mark_kind(feature)} of the machine file is "refuse"'
    face, what = getattr(feature, "face", ""), "a centre punch"
    if isinstance(feature, TextMark):
        what = f"the text {feature.text!r}"
    elif isinstance(feature, Contour):
        what = f"{sum(curve.length for curve in feature.curves):g} mm of line"
    return rules.MARK.at(feature.source, found=what, face=face, why=why)


LEFT_OUT = warning("plan-left-out",
    "found {what}, which the machine cannot make; left out, as --allow-skips {kind} allows",
    "The part is not finished when the program ends: what is left out has to be made manually or "
    "on another machine. `--exit-left-out` gives it an exit status of its own.")  # fmt: skip
MANUAL_WORK = warning("plan-by-hand",
    "found {what}; {why}; it is on the list of manual work",
    "The part is posted without the mark, which has to be made manually. The list of manual work "
    "is written beside the program; `[marks]` in a machine file says what becomes of each kind of "
    "mark.")  # fmt: skip


def unfinished_remarks(plan: AnyPlan) -> Iterator[Diagnostic]:
    """A warning for each feature that was left out, or is left for manual work.

    A part that is on the bar several times is reported once.
    """
    left = [(one, plan.feature(one.feature)) for one in unfinished(plan.outcomes)]
    yield from dict.fromkeys(
        LEFT_OUT.at(
            feature.source, what=description(feature), kind=outcome.by.removeprefix("plan-")
        )
        for outcome, feature in left
        if outcome.is_left_out
    )
    yield from dict.fromkeys(
        MANUAL_WORK.at(feature.source, what=description(feature), why=REASONS[outcome.manual_work])
        for outcome, feature in left
        if outcome.manual_work
    )


# --- map of colours and layers --------------------------------------------------------------------

# What the map makes of the curves of a drawing, other than cuts: lines that it takes away from
# cutting are a note with their number, lines with gaps that are cut a warning, and a key that no
# curve has is misspelt.


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
        for lines in part.measures.dashed if part.measures is not None else ():
            key = key_of(lines, torch.colours)
            if key is not None and torch.colours[key] == "cut" and not _is_settled(lines, torch):
                yield DASHED.at(
                    lines.source, count=lines.count, look=_look_named(lines.layer, lines.colour),
                    line_type=lines.line_type, key=_key(lines, [part]),
                )  # fmt: skip


_Look = tuple[str | None, str | None, str]  #: layer, colour and outcome


def _not_cut(plan: SheetPlan, torch: Torch) -> Iterator[Diagnostic]:
    """The curves by colour and layer that the map takes away from cutting."""
    curves, inside = Counter[_Look](), Counter[_Look]()
    first: dict[_Look, Contour] = {}
    rings: list[Box] | None = None
    for outcome in plan.outcomes:
        feature = plan.feature(outcome.feature)
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
    boxes_cut = []
    for op in plan.operations:
        if op.closed and op.row.process == "cut":
            drawn = map(plan.feature, op.features)
            curves = [c for f in drawn if isinstance(f, Contour) for c in f.curves]
            if (box := join_boxes([curve.bbox for curve in curves])) is not None:
                boxes_cut.append(box)
    return boxes_cut


def _is_settled(lines: Contour | Dashed, torch: Torch) -> bool:
    """Whether a key says what lines of a look are for, and not custom alone."""
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
    keys, counts = tuple(table), Counter[str]()
    for part in parts:
        for feature in part.features:
            if isinstance(feature, Contour):
                key = key_of(feature, keys)
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
    contours = [contour for part in parts for contour in part.contours]
    layers = sorted({c.layer for c in contours if c.layer is not None})
    colours = sorted({colour_name(c.colour) for c in contours if c.colour is not None})
    for key, process in processes.items():
        if key not in used and key != OTHERS:
            source = parts[0].source if parts else Source("--map")
            looks = ", ".join([*layers, *colours])
            expected = looks or "none, no curve has a colour or a layer"
            yield UNMATCHED.at(source, found=f"{key}={process}", expected=expected)


def idle(keys: Iterable[str], used: Iterable[str], source: Source) -> Iterator[Diagnostic]:
    """A note for each key that nothing of a whole run matched."""
    known = {*used, OTHERS}
    return (IDLE.at(source, found=key) for key in keys if key not in known)
