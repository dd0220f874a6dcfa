"""A part from its JSON form, as written by `part_to_json` or by hand."""

from collections.abc import Callable
from typing import cast

from beamcam.errors import ReadError, Rule, Severity, Source
from beamcam.geometry.curves import Arc, Curve, signed_area
from beamcam.model.colour import parse_colour
from beamcam.model.curve_json import JSON_CURVE, curves_from_json
from beamcam.model.function_json import JSON_EXPRESSION
from beamcam.model.json_object import JSON_OBJECT_RULES, JSON_VALUE, JsonObject, show
from beamcam.model.part import (
    FACES,
    MIRRORED_FACES,
    PROFILE_CODES,
    Bend,
    Bevel,
    Camber,
    Comment,
    Contour,
    ContourKind,
    EndCuts,
    EndPlane,
    Feature,
    Hole,
    HoleKind,
    Notch,
    Part,
    Plane,
    Process,
    Profile,
    ProfileCode,
    SectionPoint,
    Slot,
    TextMark,
)
from beamcam.model.part_json import COMPUTED_KEYS, PART_SCHEMA
from beamcam.plain_text import whole_text

HOLE_KINDS = ("through", "blind", "thread", "left-thread", "countersink", "mark")
CONTOUR_KINDS = ("outer", "inner", "open")
PROCESSES = ("cut", "mark", "engrave", "punch", "powder")

JSON_SCHEMA = Rule(
    "json-schema",
    Severity.ERROR,
    "found schema {found}, expected {expected!r}",
    "Another version may mean something else by the same keys.",
)
JSON_FACE = Rule(
    "json-face",
    Severity.ERROR,
    "found face {found!r}, expected v, o, u, h or a plane of the part ({planes})",
    "A feature on a face that the part does not have has no place.",
)
JSON_INDEX = Rule(
    "json-index",
    Severity.ERROR,
    "found {found}, expected the index of one of {count} curves",
    "A bevel or notch belongs to a curve of its contour.",
)

JSON_PART_RULES = (
    *JSON_OBJECT_RULES,
    JSON_CURVE,
    JSON_EXPRESSION,
    JSON_SCHEMA,
    JSON_FACE,
    JSON_INDEX,
)


def part_from_json(value: object, file: str) -> Part:
    """The part of a JSON value as `json.loads` gives it; `file` names it in messages.

    Raises ReadError with the path of the key, what was found and what was expected.
    """
    top = JsonObject(value, "", file)
    if "schema" in top and top.raw("schema") != PART_SCHEMA:
        raise top.fault(JSON_SCHEMA, "schema", found=show(top.raw("schema")), expected=PART_SCHEMA)
    source = Source(file)
    if "source" in top:
        place = top.child("source")
        source = _stored(place, file)
        place.finish()
    planes = top.children("planes", lambda item: _plane(item, source.file))
    mark, profile, length = top.text("mark"), _profile(top), top.positive("length")
    features = _features(top, source.file, tuple(plane.name for plane in planes))
    part = Part(
        mark,
        profile,
        length,
        source,
        top.integer("quantity", 1),
        top.number_or_none("saw_length"),
        top.text("order", ""),
        top.text("drawing", ""),
        top.text("phase", ""),
        top.text("grade", ""),
        _cuts(top),
        features,
        planes,
        top.number("weight", 0.0),
        top.number("surface", 0.0),
        _texts(top, "notes"),
        _tolerance(top),
        top.children("section", _section_point),
        tuple(_pair(top, i, item) for i, item in enumerate(top.items("info"))),
        top.children("comments", lambda c: Comment(c.text("text"), c.text("before"))),
        top.text_or_none("guid"),
    )
    top.ignore(("schema", *COMPUTED_KEYS))
    top.finish()
    return part


def _stored(item: JsonObject, file: str) -> Source:
    """The source that an object keeps; of one written by hand its path."""
    if "line" not in item:
        item.ignore(("line", "where", "file"))
        return Source(item.text("file", file), None, item.path)
    line = None if item.raw("line") is None else item.integer("line")
    return Source(item.text("file", file), line, item.text_or_none("where"))


def _profile(top: JsonObject) -> Profile:
    fields = top.child("profile")
    code = cast(ProfileCode, fields.choice("code", PROFILE_CODES))
    profile = Profile(
        code,
        fields.text("name", ""),
        fields.number("height"),
        fields.number("width", 0.0),
        fields.number("flange_thickness", 0.0),
        fields.number_or_none("web_thickness"),
        fields.number("radius", 0.0),
    )
    fields.finish()
    return profile


def _cuts(top: JsonObject) -> EndCuts:
    if "cuts" not in top:
        top.ignore(("cuts",))
        return EndCuts()
    fields = top.child("cuts")
    names = ("web_start", "web_end", "flange_start", "flange_end")
    cuts = EndCuts(*(fields.number(name, 0.0) for name in names))
    fields.finish()
    return cuts


def _texts(top: JsonObject, key: str) -> tuple[str, ...]:
    found = []
    for i, value in enumerate(top.items(key)):
        if not isinstance(value, str):
            raise top.fault(JSON_VALUE, f"{key}[{i}]", found=show(value), expected="a text")
        found.append(whole_text(value))
    return tuple(found)


def _pair(top: JsonObject, index: int, value: object) -> tuple[str, str]:
    match value:
        case [str(word), str(text)]:
            return whole_text(word), whole_text(text)
    key = f"info[{index}]"
    raise top.fault(JSON_VALUE, key, found=show(value), expected="two texts [word, text]")


def _tolerance(top: JsonObject) -> tuple[float, float] | None:
    if top.raw("tolerance") is None:
        return None
    least, greatest = top.numbers("tolerance", 2)
    return least, greatest


def _section_point(item: JsonObject) -> SectionPoint:
    side = item.choice("side", ("+", "-"))
    return SectionPoint(
        "+" if side == "+" else "-", item.number("y"), item.number("z"), item.number("radius", 0.0)
    )


def _plane(item: JsonObject, file: str) -> Plane:
    return Plane(
        item.text("name"),
        item.vector("origin"),
        item.vector("along_x"),
        item.vector("along_y"),
        _stored(item, file),
    )


def _features(top: JsonObject, file: str, planes: tuple[str, ...]) -> tuple[Feature, ...]:
    """All features in the order of their key `feature`; those without it follow as they stand."""

    def numbered(
        read: Callable[[JsonObject], Feature],
    ) -> Callable[[JsonObject], tuple[float, Feature]]:
        def place(item: JsonObject) -> tuple[float, Feature]:
            where = item.integer("feature") if "feature" in item else float("inf")
            item.ignore(("feature",))
            return where, read(item)

        return place

    def face(item: JsonObject) -> str:
        name = item.text("face", "v")
        if name not in FACES and name not in planes:
            raise item.fault(
                JSON_FACE, "face", found=name, planes=", ".join(planes) or "it has none"
            )
        return name

    readers: dict[str, Callable[[JsonObject], Feature]] = {
        "holes": lambda item: _hole(item, face(item), file),
        "slots": lambda item: _slot(item, face(item), file),
        "contours": lambda item: _contour(item, face(item), file),
        "texts": lambda item: _text_mark(item, face(item), file),
        "bends": lambda item: _bend(item, file),
        "end_planes": lambda item: EndPlane(
            item.vector("point"), item.vector("normal"), _stored(item, file)
        ),
        "cambers": lambda item: Camber(
            face(item), item.number("x"), item.number("y"), _stored(item, file)
        ),
    }
    found = [pair for key, read in readers.items() for pair in top.children(key, numbered(read))]
    found.sort(key=lambda pair: pair[0])
    return tuple(feature for _, feature in found)


def _diameter(item: JsonObject) -> float:
    value = item.number("diameter")
    if value < 0:
        raise item.fault(JSON_VALUE, "diameter", found=show(value), expected="0 or more")
    return value


def _hole(item: JsonObject, face: str, file: str) -> Hole:
    depth = item.number_or_none("depth")
    kind = item.choice("kind", HOLE_KINDS, "through" if depth is None else "blind")
    return Hole(
        face,
        item.number("x"),
        item.number("y"),
        _diameter(item),
        _stored(item, file),
        depth,
        cast(HoleKind, kind),
        item.number_or_none("angle"),
        item.text("edge", ""),
    )


def _slot(item: JsonObject, face: str, file: str) -> Slot:
    depth = item.number_or_none("depth")
    kind = item.choice("kind", HOLE_KINDS, "through" if depth is None else "blind")
    return Slot(
        face,
        item.number("x"),
        item.number("y"),
        _diameter(item),
        item.number("length"),
        item.number("height", 0.0),
        item.number("angle", 0.0),
        _stored(item, file),
        depth,
        cast(HoleKind, kind),
        item.text("edge", ""),
    )


def _contour(item: JsonObject, face: str, file: str) -> Contour:
    kind = cast(ContourKind, item.choice("kind", CONTOUR_KINDS))
    found: list[Curve] = []
    drawn = True  # by shorthands only, which have no direction of their own
    for i, value in enumerate(item.items("curves")):
        curve = JsonObject(value, f"{item.at('curves')}[{i}]", item.file)
        drawn = drawn and any(key in curve for key in ("polygon", "circle", "function"))
        found += curves_from_json(curve)
        curve.finish()
    if not found:
        raise item.fault(JSON_VALUE, "curves", found="no curves", expected="one curve or more")
    curves = tuple(found)
    if drawn and kind != "open" and _is_closed(curves):
        curves = _turned_as(curves, kind, face)
    item.ignore(("length", "bbox"))
    return Contour(
        face,
        kind,
        curves,
        _stored(item, file),
        cast(Process, item.choice("process", PROCESSES, "cut")),
        item.boolean("closed", _is_closed(curves)),
        item.children("bevels", lambda b: _bevel(b, len(curves))),
        item.children("notches", lambda n: _notch(n, len(curves))),
        item.text("edge", ""),
        item.text_or_none("layer"),
        _colour(item),
    )


def _colour(item: JsonObject) -> str | None:
    """A colour as "#rrggbb"."""
    text = item.text_or_none("colour")
    if text is None:
        return None
    try:
        return parse_colour(text)
    except ValueError:
        expected = "#RRGGBB, rgb(r, g, b) or the name of a colour"
        raise item.fault(JSON_VALUE, "colour", found=show(text), expected=expected) from None


def _turned_as(curves: tuple[Curve, ...], kind: ContourKind, face: str) -> tuple[Curve, ...]:
    """Polygons, circles and ways so that outer ones run counter-clockwise seen from outside."""
    positive = (kind == "outer") != (face in MIRRORED_FACES)
    if (signed_area(curves) > 0) == positive:
        return curves
    return tuple(curve.reversed() for curve in reversed(curves))


def _is_closed(curves: tuple[Curve, ...]) -> bool:
    start, end = curves[0].start, curves[-1].end
    if len(curves) == 1 and isinstance(curves[0], Arc):
        return abs(curves[0].sweep_deg) == 360.0
    return abs(start[0] - end[0]) < 1e-6 and abs(start[1] - end[1]) < 1e-6


def _index(item: JsonObject, count: int) -> int:
    index = item.integer("curve")
    if not 0 <= index < count:
        raise item.fault(JSON_INDEX, "curve", found=index, count=count)
    return index


def _bevel(item: JsonObject, count: int) -> Bevel:
    return Bevel(_index(item, count), item.number("angle"), item.number("land"))


def _notch(item: JsonObject, count: int) -> Notch:
    kind = item.choice("kind", ("t", "w"))
    return Notch(
        _index(item, count),
        "t" if kind == "t" else "w",
        item.point("corner"),
        item.number("radius", 0.0),
    )


def _text_mark(item: JsonObject, face: str, file: str) -> TextMark:
    option = item.choice("option", ("", "r", "z"), "")
    return TextMark(
        face,
        item.number("x"),
        item.number("y"),
        item.number("angle", 0.0),
        item.number("height"),
        item.text("text"),
        _stored(item, file),
        "r" if option == "r" else "z" if option == "z" else "",
        item.text("edge", ""),
    )


def _bend(item: JsonObject, file: str) -> Bend:
    return Bend(
        item.point("start"),
        item.point("end"),
        item.number("angle"),
        item.number_or_none("radius"),
        _stored(item, file),
    )


__all__ = ["JSON_PART_RULES", "ReadError", "part_from_json"]
