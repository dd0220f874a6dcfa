"""The list of manual work: a row for each feature that is left to people, as CSV.

It has marks that are not made, holes of which only the centre is marked, edges that are cut square,
and what --allow-skips let be missing; of that `why` is the code by which the machine refused it.
"""

import csv
import io
from collections.abc import Iterable
from pathlib import PurePath
from typing import TypedDict

from beamcam.geometry.curves import circle_of, slot_of
from beamcam.model.part import Bend, Camber, Contour, Feature, Hole, Part, Slot, TextMark
from beamcam.model.plan import AnyPlan, Plan
from beamcam.plain_text import harmless_cell
from beamcam.planning.within import WITHIN

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
        for row in known or ():
            row["pieces"] += 1
        if known is not None:
            continue
        feature = part.features[index]
        own = rows[id(part), index] = [_manual_row(part, feature, why)]
        is_cut = isinstance(feature, Contour) and feature.process == "cut"
        if isinstance(feature, Contour) and is_cut and feature.bevels and not _is_code(why):
            own.clear()  # one for each of its bevelled edges instead
            for bevel in feature.bevels:
                if abs(bevel.angle) >= least:
                    row, curve = _manual_row(part, feature, why), feature.curves[bevel.curve]
                    row["kind"], row["angle"], row["land"] = "bevel", bevel.angle, bevel.land
                    (row["x"], row["y"]), row["length"] = curve.start, curve.length
                    row["path"] = _path((curve.start, curve.end))
                    own.append(row)
    return [row for some in rows.values() for row in some]


def _is_code(why: str) -> bool:
    """Whether a code says that a machine cannot make a feature; one too small to cut is no work."""
    return why.startswith("plan-") and why != "plan-tiny"


def _manual_row(part: Part, feature: Feature, why: str) -> ManualRow:
    source = feature.source
    words = PurePath(source.file).name, source.line, source.where  # whatever folder it lies in
    place = ":".join(str(word) for word in words if word is not None)
    row: ManualRow = {
        "mark": part.mark, "profile": part.profile.name, "pieces": 1, "kind": "", "text": "",
        "face": getattr(feature, "face", ""), "x": 0.0, "y": 0.0, "angle": 0.0, "height": 0.0,
        "path": "", "why": why, "source": place,
        "size": "", "land": 0.0, "length": 0.0,
    }  # fmt: skip
    if isinstance(feature, Hole | Slot | TextMark | Camber):
        row["x"], row["y"] = feature.x, feature.y
    is_cut = isinstance(feature, Contour) and feature.process == "cut"
    match feature:
        case TextMark():
            row["kind"], row["text"] = "text", feature.text
            row["height"], row["angle"] = feature.height, feature.angle
        case Hole(kind="mark"):
            row["kind"] = "point"
        case Hole():
            row["kind"] = "hole" if feature.kind == "through" else feature.kind
            row["size"] = f"{feature.diameter:g}"
        case Slot():
            row["kind"], row["angle"] = "slot", feature.angle
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
            row["kind"] = "camber"
    return row


def _path(corners: Iterable[tuple[float, float]]) -> str:
    return "; ".join(f"{_rounded(x)} {_rounded(y)}" for x, y in corners)


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
