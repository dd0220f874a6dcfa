"""The list for the hand: marks that a program leaves to whoever stands beside the machine."""

import csv
import io
from collections.abc import Iterable, Iterator
from pathlib import PurePath
from typing import TypedDict

from beamcam.errors import Source
from beamcam.model.part import Contour, Feature, Hole, Part, TextMark
from beamcam.model.plan import Plan, SheetPlan
from beamcam.plain_text import harmless_cell

LIST_SUFFIX = ".hand.csv"  #: behind a program's name, for the list beside it


class HandRow(TypedDict):
    """One mark, with its place on the face of the part."""

    mark: str  #: of the part
    profile: str
    pieces: int  #: of that part that the program makes
    kind: str
    text: str
    face: str
    x: float
    y: float
    angle: float
    height: float  #: of a text
    path: str  #: of a line: its corners, x and y each
    why: str
    source: str


HEAD = tuple(HandRow.__annotations__)


def is_hand_list(name: str) -> bool:
    """Whether a file is such a list by its name."""
    return name.lower().endswith(LIST_SUFFIX)


LIST_BEGIN = (",".join(HEAD) + "\n").encode()  #: of every list that was written here


def hand_rows(plan: Plan | SheetPlan) -> list[HandRow]:
    """A row for each mark that is left to the hand; pieces of one part share theirs."""
    rows: dict[tuple[int, int], HandRow] = {}
    for outcome in plan.outcomes:
        if outcome.how != "listed":
            continue
        piece, index = outcome.feature
        part = plan.pieces[piece].part
        row = rows.get((id(part), index))
        if row is None:
            rows[id(part), index] = _row(part, part.features[index], outcome.by)
        else:
            row["pieces"] += 1
    return list(rows.values())


def _row(part: Part, feature: Feature, why: str) -> HandRow:
    """What a mark is, and where."""
    row: HandRow = {
        "mark": part.mark, "profile": part.profile.name, "pieces": 1, "kind": "", "text": "",
        "face": getattr(feature, "face", ""), "x": 0.0, "y": 0.0, "angle": 0.0, "height": 0.0,
        "path": "", "why": why, "source": _where(feature.source),
    }  # fmt: skip
    match feature:
        case TextMark():
            row["kind"], row["text"], row["height"] = "text", feature.text, feature.height
            row["x"], row["y"], row["angle"] = feature.x, feature.y, feature.angle
        case Hole():
            row["kind"], row["x"], row["y"] = "point", feature.x, feature.y
        case Contour():
            corners = [feature.curves[0].start, *(curve.end for curve in feature.curves)]
            row["kind"], (row["x"], row["y"]) = "line", corners[0]
            row["path"] = "; ".join(f"{_rounded(x)} {_rounded(y)}" for x, y in corners)
    return row


def _where(source: Source) -> str:
    """The place in the input, whatever folder that lies in."""
    words = (PurePath(source.file).name, source.line, source.where)
    return ":".join(str(word) for word in words if word is not None)


def _rounded(value: float) -> str:
    return f"{round(value, 3) + 0.0:g}"


def as_csv(rows: Iterable[HandRow]) -> str:
    """The list as CSV, with a head."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(HEAD)
    for row in rows:
        writer.writerow(map(harmless_cell, _cells(row)))
    return out.getvalue()


def _cells(row: HandRow) -> Iterator[object]:
    for value in row.values():
        yield _rounded(value) if isinstance(value, float) else value
