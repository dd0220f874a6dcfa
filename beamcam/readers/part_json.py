"""The reader of the JSON form of parts: a file of one part, `beamcam/part/1`."""

import json
import re
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from math import inf
from typing import Any, TypeVar

from msgspec import UnsetType
from msgspec.structs import asdict

from beamcam.errors import ReadError, Source, error
from beamcam.geometry.curves import Arc, signed_area
from beamcam.model import part_forms
from beamcam.model.colour import parse_colour
from beamcam.model.curve_json import JsonPlace, curves_of, record_of, show
from beamcam.model.part import (
    FACES,
    MIRRORED_FACES,
    Bend,
    Camber,
    Contour,
    EndPlane,
    Feature,
    Hole,
    Part,
    Plane,
    Profile,
    Slot,
    TextMark,
)
from beamcam.model.part_json import PART_SCHEMA
from beamcam.plain_text import fault_text, whole_text
from beamcam.readers import Reading
from beamcam.readers.drawing import checked_polynomials

Form = TypeVar("Form")
SourceOf = Callable[[part_forms.Located, JsonPlace], Source]

JSON_SCHEMA = error("json-schema",
    "found schema {found}, expected {expected!r}",
    "Another version may mean something else by the same keys.")  # fmt: skip
JSON_FACE = error("json-face",
    "found face {found!r}, expected v, o, u, h or a plane of the part ({planes})",
    "A feature on a face that the part does not have has no place.")  # fmt: skip
JSON_INDEX = error("json-index",
    "found {found}, expected the index of one of {count} curves",
    "A bevel or notch belongs to a curve of its contour.")  # fmt: skip


def part_from_json(value: object, file: str) -> Part:
    """The part of a JSON value as `json.loads` gives it; `file` names it in messages.

    Raises ReadError with the path of the key, what was found and what was expected.
    """
    top = JsonPlace(file)
    if isinstance(value, dict) and value.get("schema", PART_SCHEMA) != PART_SCHEMA:
        raise top.at("schema").fault(JSON_SCHEMA, found=show(value["schema"]), expected=PART_SCHEMA)
    form = record_of(_without_computed(value), part_forms.PartForm, top)
    source = Source(file) if form.source is None else _source(form.source, top.at("source"), file)
    of_file = partial(_source, file=source.file)
    planes = tuple(
        Plane(plane.name, plane.origin, plane.along_x, plane.along_y, of_file(plane, place))
        for plane, place in _each(form.planes, top.at("planes"))
    )
    names = tuple(plane.name for plane in planes)
    made = None if form.made is None else _features(form.made, top.at("made"), of_file, names)
    return Part(
        form.mark, Profile(**asdict(form.profile)), form.length, source, form.quantity,
        form.saw_length, form.order, form.drawing, form.phase, form.grade, form.cuts,
        _features(form, top, of_file, names), planes, form.weight, form.surface, form.notes,
        form.tolerance, form.section, form.info, form.comments, form.guid, made,
        cut_lines=form.cut_lines,
    )  # fmt: skip


#: Keys that are written for those who read the file: lengths and boxes of what stands beside them.
_COMPUTED = {
    "bbox", "path_length", "duplicate_length", "filled_length", "hidden_length", "not_cut",
}  # fmt: skip
_COMPUTED_OF_CONTOUR = {"length", "bbox"}


def _without_computed(value: object) -> object:
    """A part without its computed keys: a curve may be longer than a number that is read."""

    def without(table: Any, keys: set[str]) -> Any:
        is_table = isinstance(table, dict)
        return {k: v for k, v in table.items() if k not in keys} if is_table else table

    kept = without(value, _COMPUTED)
    for holder in (kept, kept.get("made")) if isinstance(kept, dict) else ():
        if isinstance(holder, dict) and isinstance(contours := holder.get("contours"), list):
            holder["contours"] = [without(one, _COMPUTED_OF_CONTOUR) for one in contours]
    return kept


def _each(forms: Iterable[Form], place: JsonPlace) -> Iterator[tuple[Form, JsonPlace]]:
    """The forms of a list, each with its place."""
    return ((form, place.at(index)) for index, form in enumerate(forms))


def _source(form: part_forms.Located, place: JsonPlace, file: str) -> Source:
    """The recorded source of an object; its JSON path if written by hand."""
    if isinstance(form.line, UnsetType):
        return Source(form.file or file, None, place.path)
    return Source(form.file or file, form.line, form.where)


def _features(
    form: part_forms.PartForm | part_forms.FeatureLists,
    top: JsonPlace,
    source: SourceOf,
    planes: tuple[str, ...],
) -> tuple[Feature, ...]:
    """All features in the order of their key `feature`; those without it follow as they stand."""
    numbered: list[tuple[float, Feature]] = []
    for key in ("holes", "slots", "contours", "texts", "bends", "end_planes", "cambers"):
        for one, place in _each(getattr(form, key), top.at(key)):
            name = getattr(one, "face", "v")
            if name not in FACES and name not in planes:
                known = ", ".join(planes) or "it has none"
                raise place.at("face").fault(JSON_FACE, found=name, planes=known)
            order = inf if one.feature is None else one.feature
            if isinstance(one, part_forms.ContourForm):
                numbered.append((order, _contour(one, place, source(one, place))))
                continue
            fields = {k: value for k, value in asdict(one).items() if k not in _NOT_ITS_OWN}
            if isinstance(one, part_forms.HoleForm | part_forms.SlotForm):
                of_depth = "through" if one.depth is None else "blind"
                fields["kind"] = of_depth if isinstance(one.kind, UnsetType) else one.kind
            numbered.append((order, _MADE[type(one)](**fields, source=source(one, place))))
    numbered.sort(key=lambda pair: pair[0])
    return tuple(feature for _, feature in numbered)


#: Keys of a feature's form that are not fields of the feature.
_NOT_ITS_OWN = {"line", "where", "file", "feature", "kind"}
#: The feature of each form whose fields it has.
_MADE: dict[type[part_forms.Featured], Callable[..., Feature]] = {
    part_forms.HoleForm: Hole, part_forms.SlotForm: Slot, part_forms.TextForm: TextMark,
    part_forms.BendForm: Bend, part_forms.EndPlaneForm: EndPlane, part_forms.CamberForm: Camber,
}  # fmt: skip


def _contour(form: part_forms.ContourForm, place: JsonPlace, source: Source) -> Contour:
    if not form.curves:
        raise place.at("curves").wrong("no curves", "one curve or more")
    forms = _each(form.curves, place.at("curves"))
    curves = tuple(curve for one, below in forms for curve in curves_of(one, below))
    (x0, y0), (x1, y1) = curves[0].start, curves[-1].end
    closed = max(abs(x0 - x1), abs(y0 - y1)) < 1e-6
    if len(curves) == 1 and isinstance(curves[0], Arc):
        closed = abs(curves[0].sweep_deg) == 360.0
    # Shorthands have no direction of their own: outer ones run counter-clockwise from outside.
    drawn = all(
        one.polygon or one.circle or one.tangent_circle or one.function for one in form.curves
    )
    if drawn and form.kind != "open" and closed:
        positive = (form.kind == "outer") != (form.face in MIRRORED_FACES)
        if (signed_area(curves) > 0) != positive:
            curves = tuple(curve.reversed() for curve in reversed(curves))
    colour = form.colour
    if colour is not None:
        try:
            colour = parse_colour(colour)
        except ValueError:
            expected = "#RRGGBB, rgb(r, g, b) or the name of a colour"
            raise place.at("colour").wrong(colour, expected) from None
    for key in ("bevels", "notches"):
        for row, below in _each(getattr(form, key), place.at(key)):
            if not 0 <= row.curve < len(curves):
                raise below.at("curve").fault(JSON_INDEX, found=row.curve, count=len(curves))
    return Contour(
        form.face, form.kind, curves, source, form.process,
        closed if isinstance(form.closed, UnsetType) else form.closed, form.bevels,
        form.notches, form.edge, form.layer, colour,
    )  # fmt: skip


JSON_SYNTAX = error("json-syntax",
    "found {found}, expected JSON",
    "The file is not JSON, so nothing in it can be read.")  # fmt: skip
JSON_KEY_TWICE = error("json-key-twice",
    "found key {key!r} twice in one object, expected it once",
    "One of the two values would be lost silently.")  # fmt: skip


class _KeyTwice(ValueError):
    """An object with a key that is there twice."""


def looks_like(data: bytes) -> bool:
    """Whether the bytes are a JSON object that names the schema of parts or has its main keys."""
    start = data[:4000].lstrip(b"\xef\xbb\xbf \t\r\n")
    return start.startswith(b"{") and (
        PART_SCHEMA.encode() in start or (b'"mark"' in data and b'"profile"' in data)
    )


def read(data: bytes, name: str) -> Reading:
    """The part of a JSON file; never raises."""
    source = Source(name)
    try:
        value = json.loads(
            data.decode("utf-8-sig"), object_pairs_hook=_unique, parse_constant=_refuse_constant
        )
        if _HALF.search(data):
            value = _whole(value)
    except _KeyTwice as error:
        return Reading("part-json", (), (JSON_KEY_TWICE.at(source, key=str(error)),))
    except json.JSONDecodeError as error:
        source, found = Source(name, error.lineno), f"{error.msg} in column {error.colno}"
    except UnicodeDecodeError as error:
        found = f"bytes that are no UTF-8 at {error.start}"
    except (RecursionError, ValueError) as error:
        found = fault_text(error)
    else:
        try:
            part = part_from_json(value, name)
        except ReadError as error:
            return Reading("part-json", (), error.diagnostics)
        return Reading("part-json", (part,), tuple(checked_polynomials(part)))
    return Reading("part-json", (), (JSON_SYNTAX.at(source, found=found),))


#: What half of a character is written as, which no file takes afterwards.
_HALF = re.compile(rb"\\u[dD][89a-fA-F]")


def _whole(value: Any) -> Any:
    """A value whose texts hold no half of a character."""
    if isinstance(value, dict):
        return {whole_text(key): _whole(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_whole(item) for item in value]
    return whole_text(value) if isinstance(value, str) else value


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        keys = [key for key, _ in pairs]
        raise _KeyTwice(next(key for key in keys if keys.count(key) > 1))
    return table


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name}, which is no number")
