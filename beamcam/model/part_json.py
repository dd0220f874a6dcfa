"""The JSON form of a part, `beamcam/part/1`: everything that a `Part` holds, and some sums.

`part_to_json` and `part_from_json` are inverse to the last bit. Features stand in lists by their
kind; the key `feature` says which place each has among all, since comments name it. Sums such as
`bbox` and `path_length` are written for those who read the file and ignored on reading.
"""

from typing import Any

from beamcam.errors import Source
from beamcam.geometry.curves import Curve, join_boxes
from beamcam.model.curve_json import curve_to_json
from beamcam.model.drawing import Measures
from beamcam.model.lengths import duplicate_length, total_length
from beamcam.model.part import (
    Bend,
    Camber,
    Contour,
    EndPlane,
    Feature,
    Hole,
    Part,
    Plane,
    Slot,
    TextMark,
)

PART_SCHEMA = "beamcam/part/1"

Json = dict[str, Any]


def part_to_json(part: Part) -> Json:
    """The JSON form of `part`, of values that `json.dumps` takes."""
    profile = part.profile
    lists: dict[str, list[Json]] = {
        name: []
        for name in ("holes", "slots", "contours", "texts", "bends", "end_planes", "cambers")
    }
    for i, feature in enumerate(part.features):
        name, fields = _feature(feature)
        lists[name].append({**fields, "feature": i, **_place(feature.source, part.source.file)})
    return {
        "mark": part.mark,
        "drawing": part.drawing,
        "order": part.order,
        "phase": part.phase,
        "grade": part.grade,
        "quantity": part.quantity,
        "profile": {
            "code": profile.code,
            "name": profile.name,
            "height": profile.height,
            "width": profile.width,
            "flange_thickness": profile.flange_thickness,
            "web_thickness": profile.web_thickness,
            "radius": profile.radius,
        },
        "length": part.length,
        "saw_length": part.saw_length,
        "cuts": {
            "web_start": part.cuts.web_start,
            "web_end": part.cuts.web_end,
            "flange_start": part.cuts.flange_start,
            "flange_end": part.cuts.flange_end,
        },
        "cut_lines": part.cut_lines,
        **lists,
        "planes": [_plane(plane, part.source.file) for plane in part.planes],
        "weight": part.weight,
        "surface": part.surface,
        "notes": list(part.notes),
        "tolerance": None if part.tolerance is None else list(part.tolerance),
        "section": [{"side": p.side, "y": p.y, "z": p.z, "radius": p.radius} for p in part.section],
        "info": [list(pair) for pair in part.info],
        "comments": [{"text": c.text, "before": c.before} for c in part.comments],
        "guid": part.guid,
        "source": {"file": part.source.file, **_place(part.source, part.source.file)},
        **_sums(part),
    }


def _place(source: Source, file: str) -> Json:
    """Line and place of a feature, and its file where that is not the part's."""
    place: Json = {"line": source.line}
    if source.where is not None:
        place["where"] = source.where
    if source.file != file:
        place["file"] = source.file
    return place


def _feature(feature: Feature) -> tuple[str, Json]:
    """The list that holds a feature, and the feature's own keys."""
    match feature:
        case Hole():
            return "holes", {
                "face": feature.face,
                "x": feature.x,
                "y": feature.y,
                "diameter": feature.diameter,
                "depth": feature.depth,
                "kind": feature.kind,
                "angle": feature.angle,
                "edge": feature.edge,
            }
        case Slot():
            return "slots", {
                "face": feature.face,
                "x": feature.x,
                "y": feature.y,
                "diameter": feature.diameter,
                "length": feature.length,
                "height": feature.height,
                "angle": feature.angle,
                "depth": feature.depth,
                "kind": feature.kind,
                "edge": feature.edge,
            }
        case Contour():
            return "contours", _contour(feature)
        case TextMark():
            return "texts", {
                "face": feature.face,
                "x": feature.x,
                "y": feature.y,
                "angle": feature.angle,
                "height": feature.height,
                "text": feature.text,
                "option": feature.option,
                "edge": feature.edge,
            }
        case Bend():
            return "bends", {
                "start": list(feature.start),
                "end": list(feature.end),
                "angle": feature.angle,
                "radius": feature.radius,
            }
        case EndPlane():
            return "end_planes", {
                "point": list(feature.point),
                "normal": list(feature.normal),
            }
        case Camber():
            return "cambers", {"face": feature.face, "x": feature.x, "y": feature.y}


def _contour(contour: Contour) -> Json:
    box = join_boxes([curve.bbox for curve in contour.curves])
    return {
        "face": contour.face,
        "kind": contour.kind,
        "process": contour.process,
        "closed": contour.closed,
        "curves": [curve_to_json(curve) for curve in contour.curves],
        "length": total_length(contour.curves),
        "bbox": None if box is None else list(box),
        "layer": contour.layer,
        "colour": contour.colour,
        "bevels": [{"curve": b.curve, "angle": b.angle, "land": b.land} for b in contour.bevels],
        "notches": [
            {"curve": n.curve, "kind": n.kind, "corner": list(n.corner), "radius": n.radius}
            for n in contour.notches
        ],
        "edge": contour.edge,
    }


def _plane(plane: Plane, file: str) -> Json:
    return {
        "name": plane.name,
        "origin": list(plane.origin),
        "along_x": list(plane.along_x),
        "along_y": list(plane.along_y),
        **_place(plane.source, file),
    }


def _sums(part: Part) -> Json:
    """The box of what lies on face v, the lengths of all curves, and what a drawing also held."""
    curves: dict[str, list[Curve]] = {}
    for contour in part.contours:
        curves.setdefault(contour.face, []).extend(contour.curves)
    box = join_boxes([curve.bbox for curve in curves.get("v", ())])
    measures = part.measures or Measures()
    return {
        "bbox": None if box is None else list(box),
        "path_length": sum(total_length(on_face) for on_face in curves.values()),
        "duplicate_length": sum(duplicate_length(on_face) for on_face in curves.values()),
        "filled_length": measures.filled_length,
        "hidden_length": measures.hidden_length,
        "not_cut": dict(measures.not_cut),
    }
