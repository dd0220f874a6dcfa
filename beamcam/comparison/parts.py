"""Two parts compared feature by feature, wherever those stand in their files; equal ones as one."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Literal

from msgspec import Struct
from msgspec.structs import fields, replace

from beamcam.comparison.pairing import (
    Difference,
    ThingPair,
    differences_one_by_one,
    moved,
    paired,
    shown,
)
from beamcam.errors import Source
from beamcam.geometry.curves import Curve, join_boxes
from beamcam.model.part import Bend, Camber, Contour, EndPlane, Feature, Hole, Part, Slot, TextMark

_HEADER = (
    "mark", "length", "saw_length", "quantity", "order", "drawing", "phase", "grade",
)  # fmt: skip
_KINDS: tuple[type[Feature], ...] = (Hole, Slot, Contour, TextMark, Bend, EndPlane, Camber)
_NAMES = {
    Hole: "hole", Slot: "slot", Contour: "contour", TextMark: "text", Bend: "bend",
    EndPlane: "end plane", Camber: "camber",
}  # fmt: skip


def diff_parts(a: Sequence[Part], b: Sequence[Part]) -> tuple[Difference, ...]:
    """Differences of the parts of B from those of A, compared in order."""
    differences: list[Difference] = []
    for first, second in zip(a, b, strict=False):
        differences += _part(first, second)
    rest: tuple[tuple[Literal["only in A", "only in B"], Sequence[Part]], ...] = (
        ("only in A", a[len(b) :]), ("only in B", b[len(a) :]),
    )  # fmt: skip
    differences += [
        Difference("part", how, f"part {p.mark} {how}") for how, parts in rest for p in parts
    ]
    return tuple(differences)


def part_pairs(a: Part, b: Part) -> Iterator[ThingPair]:
    """The features of two parts, each with its like in the other."""
    for _, first, second in _by_face(a, b):
        yield from paired(first, second, _place, _feature)


def _part(a: Part, b: Part) -> Iterator[Difference]:
    for first, second, names, form in (
        (a, b, _HEADER, "{}"),
        (a.profile, b.profile, a.profile.__struct_fields__, "{}"),
        (a.cuts, b.cuts, a.cuts.__struct_fields__, "{} cut"),
    ):
        for name in names:
            old, new = getattr(first, name), getattr(second, name)
            if old != new:
                what = form.format("profile" if name == "name" else name.replace("_", " "))
                yield Difference("part", "changed", f"{what} {shown(old)} to {shown(new)}")
    for kind, own, other in _by_face(a, b):
        noun: Literal["hole", "feature"] = "hole" if kind is Hole else "feature"
        yield from differences_one_by_one(noun, own, other, _place, _name, _feature)


def _by_face(a: Part, b: Part) -> Iterator[tuple[type[Feature], list[Feature], list[Feature]]]:
    for kind in _KINDS:
        old, new = ([f for f in part.features if isinstance(f, kind)] for part in (a, b))
        for face in sorted({_face(f) for f in (*old, *new)}):
            own, other = ([f for f in some if _face(f) == face] for some in (old, new))
            yield kind, own, other


def _face(feature: Feature) -> str:
    return getattr(feature, "face", "")


def _place(feature: Feature) -> tuple[float, float]:
    match feature:
        case Hole() | Slot() | TextMark() | Camber():
            return feature.x, feature.y
        case Contour():
            boxes = [curve.bbox for curve in feature.curves]
            x0, y0, x1, y1 = join_boxes(boxes) or (0.0, 0.0, 0.0, 0.0)
            return (x0 + x1) / 2, (y0 + y1) / 2
        case Bend():
            return feature.start
        case EndPlane():
            return feature.point[0], feature.point[1]


def _name(feature: Feature) -> str:
    kind = _NAMES[type(feature)]
    if isinstance(feature, Contour):
        kind = {"outer": "outline", "inner": "cut-out", "open": "line"}[feature.kind]
    if isinstance(feature, TextMark):
        kind = f"text {feature.text!r}"
    face = f" {_face(feature)}" if _face(feature) else ""
    return f"{kind}{face} at x {_place(feature)[0]:.1f}"


_PLACES = ("x", "y")


def _feature(a: Feature, b: Feature) -> list[str]:
    """Differences of two features of one kind, wherever they are in their files."""
    (ax, ay), (bx, by) = _place(a), _place(b)
    changes = moved(bx - ax, by - ay, 1e-9)
    for field in fields(a):
        old, new = getattr(a, field.name), getattr(b, field.name)
        if isinstance(old, Source) or field.name in _PLACES:
            continue
        if isinstance(a, Contour) and isinstance(b, Contour) and field.name == "curves":
            # Moved onto each other, and begun anywhere if they are closed.
            first = [_key(c, bx - ax, by - ay) for c in a.curves]
            second = [_key(c, 0.0, 0.0) for c in b.curves]
            starts = range(max(1, len(first)) if a.closed and b.closed else 1)
            if all(first[i:] + first[:i] != second for i in starts):
                changes.append("another course")
        elif old != new:
            changes.append(f"{field.name.replace('_', ' ')} {shown(old)} to {shown(new)}")
    return changes


def _key(curve: Curve, dx: float, dy: float) -> tuple[object, ...]:
    """A curve's kind and five points of it, to a thousandth of a millimetre."""
    points = [curve.point(t / 4) for t in range(5)]
    return type(curve).__name__, *(
        (round(x + dx, 3) + 0.0, round(y + dy, 3) + 0.0) for x, y in points
    )


# --- quantities -----------------------------------------------------------------------------------

GRAIN = 0.05  #: mm and degrees to which measures are compared


def equal_parts(parts: Iterable[Part]) -> tuple[Part, ...]:
    """The parts with those of one mark, grade and geometry as one, its quantity their sum.

    They stand in the order in which each came first.
    """
    first: dict[object, Part] = {}
    for part in parts:
        profile = replace(part.profile, name="")
        form = profile, part.section, part.length, part.cuts, part.features
        key = part.mark, part.grade, part.drawing, _grained(form)
        known = first.setdefault(key, part)
        if known is not part:
            first[key] = replace(known, quantity=known.quantity + part.quantity)
    return tuple(first.values())


def _grained(value: object) -> object:
    """A key that equal values share, whatever the order of the features and curves among them."""
    if isinstance(value, float):
        return round(value / GRAIN)
    if isinstance(value, Struct):
        fields = (getattr(value, name) for name in value.__struct_fields__ if name != "source")
        return (type(value).__name__, *map(_grained, fields))
    if isinstance(value, tuple):
        grains = map(_grained, value)
        return tuple(
            sorted(grains, key=repr) if all(isinstance(v, Struct) for v in value) else grains
        )
    return value
