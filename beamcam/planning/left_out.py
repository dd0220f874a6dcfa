"""What a program does not make of its parts, or makes otherwise than by cutting, reported by name.

Nothing that a part has is missing from a program without a word: what was left out because
`--allow-skips` names its kind, or is left for manual work, is a warning at the feature. The list of
manual work has a row for each: marks that are not made, holes of which only the centre is marked,
edges that are cut square, and what --allow-skips let be missing; of that `why` is the code by which
the machine refused it.
"""

import csv
import io
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import PurePath
from typing import TypedDict

from beamcam.errors import Diagnostic, Source, error, note, warning
from beamcam.geometry.curves import circle_of, slot_of
from beamcam.machine.stations import Marks
from beamcam.machine.torch import Torch
from beamcam.model.description import description
from beamcam.model.part import Bend, Camber, Contour, Feature, Hole, Part, Slot, TextMark
from beamcam.model.plan import AnyPlan, Outcome, Plan, SheetPlan, unfinished
from beamcam.model.request import mark_kind, policy_on
from beamcam.plain_text import harmless_cell
from beamcam.planning import rules
from beamcam.planning.within import WITHIN

#: What may be left out of a program: codes of refusals by the kinds of work, without their "plan-".
SKIP_NAMES = (
    "tool", "countersink", "sink-depth", "thread-depth", "face", "reach", "stroke", "axis",
    "off-face", "slot", "cope", "cutout", "mark", "bevel", "other",
)  # fmt: skip
ALL_SKIPS = "all"  #: in place of the names of all kinds of features


def named_skips(words: Iterable[str]) -> tuple[str, ...]:
    """The kinds of features that are named, each once and in order; `all` names every kind."""
    names = set(words)
    if ALL_SKIPS in names:
        names = (names - {ALL_SKIPS}) | {*SKIP_NAMES}
    return tuple(sorted(names))


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
    face = getattr(feature, "face", "")
    return rules.MARK.at(feature.source, found=_named(feature), face=face, why=why)


def _named(feature: Feature) -> str:
    match feature:
        case TextMark():
            return f"the text {feature.text!r}"
        case Contour():
            return f"{sum(curve.length for curve in feature.curves):g} mm of line"
        case _:
            return "a centre punch"


LEFT_OUT = warning("plan-left-out",
    "found {what}, which the machine cannot make; left out, as --allow-skips {kind} allows",
    "The part is not finished when the program ends: what is left out has to be made manually or "
    "on another machine. `--exit-left-out` gives it an exit status of its own.")  # fmt: skip
MANUAL_WORK = warning("plan-by-hand",
    "found {what}; {why}; it is on the list of manual work",
    "The part is posted without the mark, which has to be made manually. The list of manual work "
    "is written beside the program; `[marks]` in a machine file says what becomes of each kind of "
    "mark.")  # fmt: skip


def told(plan: AnyPlan, torch: Torch | None) -> Iterator[Diagnostic]:
    """A warning for each feature that was left out, and remarks on each look that is not cut.

    Nor is it taken for granted that lines with gaps are to be cut, and closed contours not.
    """
    left = unfinished(plan.outcomes)
    skipped = [outcome for outcome in left if _is_by_name(outcome)]
    # A part that is on the bar several times is reported once.
    yield from dict.fromkeys(_left_out(plan, outcome) for outcome in skipped)
    listed = [outcome for outcome in left if outcome.manual_work]
    yield from dict.fromkeys(_manual_work(plan, outcome) for outcome in listed)
    if isinstance(plan, SheetPlan) and torch is not None:
        from beamcam.planning.map_keys import map_remarks

        yield from map_remarks(plan, torch)


def left_out_sources(plan: AnyPlan) -> Iterator[Source]:
    """Source of each feature that was left out because `--allow-skips` names its kind."""
    for outcome in unfinished(plan.outcomes):
        if _is_by_name(outcome):
            piece, index = outcome.feature
            yield plan.pieces[piece].part.features[index].source


def left_out_kinds(plan: AnyPlan) -> Counter[str]:
    """How many features of each kind were left out because `--allow-skips` names it."""
    left = unfinished(plan.outcomes)
    return Counter(one.by.removeprefix("plan-") for one in left if _is_by_name(one))


def manual_work_sources(plan: AnyPlan) -> Iterator[Source]:
    """Source of each mark that is left for manual work."""
    for outcome in unfinished(plan.outcomes):
        if outcome.manual_work:
            piece, index = outcome.feature
            yield plan.pieces[piece].part.features[index].source


def _is_by_name(outcome: Outcome) -> bool:
    """Whether a feature was left out because `--allow-skips` names its kind.

    What is mapped away, or too small to be cut, nobody has to name; other messages report it.
    """
    return outcome.how == "skipped" and outcome.by.removeprefix("plan-") in SKIP_NAMES


def _left_out(plan: AnyPlan, outcome: Outcome) -> Diagnostic:
    piece, index = outcome.feature
    feature = plan.pieces[piece].part.features[index]
    kind = outcome.by.removeprefix("plan-")
    return LEFT_OUT.at(feature.source, what=description(feature), kind=kind)


def _manual_work(plan: AnyPlan, outcome: Outcome) -> Diagnostic:
    piece, index = outcome.feature
    feature = plan.pieces[piece].part.features[index]
    return MANUAL_WORK.at(
        feature.source, what=description(feature), why=REASONS[outcome.manual_work]
    )


# --- list of manual work --------------------------------------------------------------------------


MARK_ROWS = ("text", "point", "line")  #: kinds of rows that are marks
LIST_SUFFIX = ".hand.csv"  #: behind a program's name, for the list beside it


class ManualRow(TypedDict):
    """One mark, hole or bevelled edge, with its place on the face of the part."""

    mark: str  #: of the part
    profile: str
    pieces: int  #: of that part that the program makes
    kind: str
    text: str
    face: str
    x: float
    y: float
    angle: float  #: of a text; of a bevel off the square edge
    height: float  #: of a text
    path: str  #: of a line: its corners, x and y each
    why: str
    source: str
    size: str  #: of a hole or a slot
    land: float  #: of a bevel, from the far side
    length: float  #: of a bevelled edge


HEAD = tuple(ManualRow.__annotations__)


LIST_BEGIN = (",".join(HEAD) + "\n").encode()  #: of every list that was written here


def manual_rows(plan: AnyPlan) -> list[ManualRow]:
    """A row for each feature that is left for manual work; pieces of one part share theirs."""
    rows: dict[tuple[int, int], list[ManualRow]] = {}
    least = 0.0 if isinstance(plan, Plan) else plan.min_bevel
    for outcome in plan.outcomes:
        why = outcome.manual_work
        if outcome.by == WITHIN.code or (outcome.how == "skipped" and _is_code(outcome.by)):
            why = outcome.by
        if not why:
            continue
        piece, index = outcome.feature
        part = plan.pieces[piece].part
        known = rows.get((id(part), index))
        if known is None:
            rows[id(part), index] = list(_manual_rows(part, part.features[index], why, least))
        for row in known or ():
            row["pieces"] += 1
    return [row for some in rows.values() for row in some]


def _manual_rows(part: Part, feature: Feature, why: str, min_bevel: float) -> Iterator[ManualRow]:
    """A row for a feature; of a contour one for each of its bevelled edges."""
    is_cut = isinstance(feature, Contour) and feature.process == "cut"
    if not isinstance(feature, Contour) or not (is_cut and feature.bevels) or _is_code(why):
        yield _manual_row(part, feature, why)
        return
    for bevel in feature.bevels:
        if abs(bevel.angle) >= min_bevel:
            row, curve = _manual_row(part, feature, why), feature.curves[bevel.curve]
            row["kind"], row["angle"], row["land"] = "bevel", bevel.angle, bevel.land
            (row["x"], row["y"]), row["length"] = curve.start, curve.length
            row["path"] = _path((curve.start, curve.end))
            yield row


def _is_code(why: str) -> bool:
    """Whether a code says that a machine cannot make a feature; one too small to cut is no work."""
    return why.startswith("plan-") and why != "plan-tiny"


def _manual_row(part: Part, feature: Feature, why: str) -> ManualRow:
    """Kind and position of a mark."""
    row: ManualRow = {
        "mark": part.mark, "profile": part.profile.name, "pieces": 1, "kind": "", "text": "",
        "face": getattr(feature, "face", ""), "x": 0.0, "y": 0.0, "angle": 0.0, "height": 0.0,
        "path": "", "why": why, "source": _source_name(feature.source),
        "size": "", "land": 0.0, "length": 0.0,
    }  # fmt: skip
    is_cut = isinstance(feature, Contour) and feature.process == "cut"
    match feature:
        case TextMark():
            row["kind"], row["text"], row["height"] = "text", feature.text, feature.height
            row["x"], row["y"], row["angle"] = feature.x, feature.y, feature.angle
        case Hole(kind="mark"):
            row["kind"], row["x"], row["y"] = "point", feature.x, feature.y
        case Hole():
            row["x"], row["y"] = feature.x, feature.y
            row["kind"] = "hole" if feature.kind == "through" else feature.kind
            row["size"] = f"{feature.diameter:g}"
        case Slot():
            row["kind"], row["x"], row["y"] = "slot", feature.x, feature.y
            row["angle"] = feature.angle
            size = feature.length + feature.diameter, feature.height + feature.diameter
            row["size"] = f"{size[0]:g} x {size[1]:g}"
        case Contour() if is_cut and (circle := circle_of(feature.curves)) is not None:
            row["kind"], row["size"] = "hole", f"{2 * circle[1]:g}"
            row["x"], row["y"] = circle[0]
        case Contour() if is_cut and (drawn := slot_of(feature.curves)) is not None:
            (row["x"], row["y"]), long, wide, row["angle"] = drawn
            row["kind"], row["size"] = "slot", f"{long:.4g} x {wide:.4g}"
        case Contour():
            corners = [feature.curves[0].start, *(curve.end for curve in feature.curves)]
            row["kind"], (row["x"], row["y"]) = "line", corners[0]
            if is_cut:
                row["kind"] = "outline" if feature.kind == "outer" else "cut-out"
            row["path"] = _path(corners)
        case Bend():
            row["kind"], row["angle"] = "bend", feature.angle
            (row["x"], row["y"]), row["path"] = feature.start, _path((feature.start, feature.end))
        case Camber():
            row["kind"], row["x"], row["y"] = "camber", feature.x, feature.y
    return row


def _path(corners: Iterable[tuple[float, float]]) -> str:
    return "; ".join(f"{_rounded(x)} {_rounded(y)}" for x, y in corners)


def _source_name(source: Source) -> str:
    """The place in the input, whatever folder that lies in."""
    words = (PurePath(source.file).name, source.line, source.where)
    return ":".join(str(word) for word in words if word is not None)


def _rounded(value: float) -> str:
    return f"{round(value, 3) + 0.0:g}"


def as_csv(rows: Iterable[ManualRow]) -> str:
    """The list as CSV, with a head."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(HEAD)
    for row in rows:
        writer.writerow(
            _rounded(value) if isinstance(value, float) else harmless_cell(value)
            for value in row.values()
        )
    return out.getvalue()
