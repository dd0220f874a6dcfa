"""The JSON form of a part, `beamcam/part/1`: everything that a `Part` holds, and some sums.

`part_to_json` and `part_from_json` are inverse to the last bit. Features stand in lists by their
kind; the key `feature` says which place each has among all, since comments name it. Sums such as
`bbox` and `path_length` are written for those who read the file and ignored on reading.
"""

import json
from collections.abc import Iterable
from typing import Any

from msgspec import Struct
from msgspec.structs import asdict

from beamcam.conversion.schema import Schema, schema_of
from beamcam.errors import Source
from beamcam.geometry.curves import Curve, join_boxes
from beamcam.model.curve_json import curve_to_json
from beamcam.model.lengths import duplicate_length, total_length
from beamcam.model.part import (
    Bend,
    Camber,
    Contour,
    EndPlane,
    Feature,
    Hole,
    Measures,
    Part,
    Slot,
    TextMark,
)
from beamcam.model.part_forms import PartForm
from beamcam.plain_text import json_text

PART_SCHEMA = "beamcam/part/1"

Json = dict[str, Any]

#: The key of the list that holds the features of a kind; their own keys are their fields.
_LISTS: dict[type[Feature], str] = {
    Hole: "holes", Slot: "slots", Contour: "contours", TextMark: "texts", Bend: "bends",
    EndPlane: "end_planes", Camber: "cambers",
}  # fmt: skip


def part_to_json(part: Part) -> Json:
    """The JSON form of `part`, of values that `json.dumps` takes."""
    file = part.source.file
    made = {} if part.made is None else {"made": _lists(part.made, file)}
    curves: dict[str, list[Curve]] = {}
    for contour in part.contours:
        curves.setdefault(contour.face, []).extend(contour.curves)
    box = join_boxes([curve.bbox for curve in curves.get("v", ())])
    measures = part.measures or Measures()
    profile = asdict(part.profile)
    if part.profile.lip is None:
        del profile["lip"]
    return {
        "mark": part.mark,
        "drawing": part.drawing,
        "order": part.order,
        "phase": part.phase,
        "grade": part.grade,
        "quantity": part.quantity,
        "profile": profile,
        "length": part.length,
        "saw_length": part.saw_length,
        "cuts": asdict(part.cuts),
        "cut_lines": part.cut_lines,
        **_lists(part.features, file),
        **made,
        "planes": [{**_fields(plane), **_place(plane.source, file)} for plane in part.planes],
        "weight": part.weight,
        "surface": part.surface,
        "notes": list(part.notes),
        "tolerance": None if part.tolerance is None else list(part.tolerance),
        "section": [asdict(corner) for corner in part.section],
        "info": [list(pair) for pair in part.info],
        "comments": [asdict(comment) for comment in part.comments],
        "guid": part.guid,
        "source": {"file": file, **_place(part.source, file)},
        "bbox": None if box is None else list(box),
        "path_length": sum(total_length(on_face) for on_face in curves.values()),
        "duplicate_length": sum(duplicate_length(on_face) for on_face in curves.values()),
        "filled_length": total_length(measures.filled),
        "hidden_length": total_length(measures.hidden),
        "not_cut": dict(measures.not_cut),
    }


def _lists(features: Iterable[Feature], file: str) -> dict[str, list[Json]]:
    """Features in lists by their kinds, each with its place among all."""
    lists: dict[str, list[Json]] = {name: [] for name in _LISTS.values()}
    for i, feature in enumerate(features):
        fields = _fields(feature)
        if isinstance(feature, Contour):
            box = join_boxes([curve.bbox for curve in feature.curves])
            fields = {
                "face": feature.face, "kind": feature.kind, "process": feature.process,
                "closed": feature.closed, "curves": [*map(curve_to_json, feature.curves)],
                "length": total_length(feature.curves), "bbox": None if box is None else list(box),
                "layer": feature.layer, "colour": feature.colour,
                "bevels": [*map(asdict, feature.bevels)],
                "notches": [*map(asdict, feature.notches)], "edge": feature.edge,
            }  # fmt: skip
        own = {**fields, "feature": i, **_place(feature.source, file)}
        lists[_LISTS[type(feature)]].append(own)
    return lists


def _place(source: Source, file: str) -> Json:
    """Line and place of a feature, and its file where that is not the part's."""
    place: Json = {"line": source.line}
    if source.where is not None:
        place["where"] = source.where
    if source.file != file:
        place["file"] = source.file
    return place


def _fields(record: Struct) -> Json:
    """The fields of a record by their names, but not where it stands in its file."""
    return {name: value for name, value in asdict(record).items() if name != "source"}


def part_schema() -> Schema:
    """JSON schema of the format `beamcam/part/1`."""
    schema = schema_of(PartForm)
    schema["$defs"]["PartForm"]["properties"]["schema"] = {"const": PART_SCHEMA}
    schema["$defs"]["CurveForm"] |= {"minProperties": 1, "maxProperties": 1}
    return schema


def write(part: Part) -> str:
    """The part as JSON text of the schema `beamcam/part/1`, with a line end; numbers to the bit."""
    value = {"schema": PART_SCHEMA, **part_to_json(part)}
    return json_text(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False)) + "\n"
