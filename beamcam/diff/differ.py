"""Two programs, or two parts, compared by what they mean.

Numbering, comments, spacing and the order of holes in a part's file count for nothing. Each
difference is a sentence: "hole v at x 1200.0 moved by 2.0 mm, drill 18 to 22".
"""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import zip_longest
from math import isnan
from typing import Any, TypeVar

from msgspec import Struct
from msgspec.structs import astuple, fields, replace

from beamcam.controllers import cell_events, table_events
from beamcam.controllers.events import (
    Acceleration,
    BarEvent,
    Blending,
    Compensation,
    FeedShare,
    Lift,
    Material,
    Move,
    Output,
    Pause,
    Switch,
    TableEvent,
    ToolOffset,
    Touch,
    Zero,
)
from beamcam.diff.pairing import (
    Difference,
    Kind,
    T,
    differences_of_kind,
    differences_one_by_one,
    moved,
    pairs_of,
    shown,
)
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.geometry.curves import Arc, Curve, EllipseArc
from beamcam.machine.dialects import DIALECTS
from beamcam.machine.machine import Machine
from beamcam.model.part import Bend, Camber, Contour, EndPlane, Feature, Hole, Part, Slot, TextMark
from beamcam.verify.bars.machined_features import (
    Bore,
    Cut,
    MachinedFeatures,
    MachinedPath,
    StampedText,
)

Dot = TypeVar("Dot", Bore, StampedText)


def diff_programs(
    a: MachinedFeatures, b: MachinedFeatures, resolution: float
) -> tuple[Difference, ...]:
    """Differences of program B from program A; lengths nearer than `resolution` are
    one."""
    step = resolution / 2 + 1e-9
    found = [*_section(a, b)]
    for things, kind in _kinds(step).items():
        found += differences_of_kind(kind, getattr(a, things), getattr(b, things), step)
    if not found and _order(a) != _order(b):
        found.append(Difference("order", "changed", "the same cuts and holes in another order"))
    return tuple(found)


def diff_parts(a: Sequence[Part], b: Sequence[Part]) -> tuple[Difference, ...]:
    """Differences of the parts of B from those of A, compared in order."""
    found: list[Difference] = []
    for first, second in zip(a, b, strict=False):
        found += _part(first, second)
    found += [Difference("part", "only in A", f"part {p.mark} only in A") for p in a[len(b) :]]
    found += [Difference("part", "only in B", f"part {p.mark} only in B") for p in b[len(a) :]]
    return tuple(found)


class Pair(Struct, frozen=True):
    """A thing of A and what it is in B; None where it is not there."""

    a: object | None
    b: object | None
    place_a: tuple[float, float] | None
    place_b: tuple[float, float] | None
    is_same: bool


def part_pairs(a: Part, b: Part) -> Iterator[Pair]:
    """The features of two parts, each with its like in the other."""
    for _, first, second in _by_face(a, b):
        yield from _pairs(first, second, _place, _feature)


def made_pairs(a: MachinedFeatures, b: MachinedFeatures, resolution: float) -> Iterator[Pair]:
    """The cuts, holes and paths of two programs, each with its like in the other."""
    kinds = _kinds(resolution / 2 + 1e-9)
    cut = kinds.pop("cuts")
    yield from _pairs(a.cuts, b.cuts, cut.place, cut.changes)
    faces = {one.face for made in (a, b) for things in kinds for one in getattr(made, things)}
    for face in sorted(faces):
        for things, kind in kinds.items():
            old, new = (
                [one for one in getattr(made, things) if one.face == face] for made in (a, b)
            )
            yield from _pairs(old, new, kind.place, kind.changes)


def _pairs(
    a: Sequence[T],
    b: Sequence[T],
    place: Callable[[T], tuple[float, float]],
    changes: Callable[[T, T], list[str]],
) -> Iterator[Pair]:
    for x, y in pairs_of(a, b, place, changes):
        same = x is not None and y is not None and not changes(x, y)
        at, to = (None if t is None else place(t) for t in (x, y))
        yield Pair(x, y, at, to, same)


# Programs


def _kinds(step: float) -> dict[str, Kind[Any]]:
    """The things that a program makes, by the name that they have in `MachinedFeatures`."""
    return {
        "cuts": Kind(
            "cut", "cuts", _cut_place, _cut_name, lambda x, y: _cut(x, y, step),
            lambda x, y: replace(x, x=y.x),
        ),
        "bores": Kind("hole", "holes", _place, _bore_name, lambda x, y: _bore(x, y, step), _put),
        "paths": Kind(
            "feature", "paths", _path_place, _path_name, lambda x, y: _path(x, y, step),
            _path_to,
        ),
        "texts": Kind("feature", "texts", _place, _text_name, lambda x, y: _text(x, y, step), _put),
    }  # fmt: skip


def _section(a: MachinedFeatures, b: MachinedFeatures) -> Iterator[Difference]:
    first, second = dict(a.section), dict(b.section)
    for name in sorted(first.keys() | second.keys()):
        old, new = first.get(name), second.get(name)
        if old != new and not (old is not None and new is not None and isnan(old) and isnan(new)):
            yield Difference("section", "changed", f"{name} {shown(old)} to {shown(new)}")


def _order(made: MachinedFeatures) -> list[tuple[object, ...]]:
    return [astuple(op)[1 : 3 if type(op) is Cut else 4] for op in made.order]


def _cut_place(cut: Cut) -> tuple[float, float]:
    return cut.x, cut.angle / 10  # of cuts at one place those of like angle belong together


def _cut_name(cut: Cut) -> str:
    return f"cut at x {cut.x:.1f}"


def _cut(a: Cut, b: Cut, step: float) -> list[str]:
    turns = ("angle", a.angle, b.angle), ("tilt", a.tilt, b.tilt)
    return [*moved(b.x - a.x, 0.0, step), *_figures(turns, 1e-9), *_feed(a, b)]


def _figures(pairs: Iterable[tuple[str, float, float]], step: float) -> list[str]:
    """What differs by more than a step: "angle 90 to 45"."""
    return [f"{name} {old:g} to {new:g}" for name, old, new in pairs if abs(old - new) > step]


def _feed(a: Cut | Bore | MachinedPath, b: Cut | Bore | MachinedPath) -> list[str]:
    if abs(a.feed_mm_min - b.feed_mm_min) > 1e-6:
        return [f"feed {a.feed_mm_min:.6g} to {b.feed_mm_min:.6g} mm/min"]
    return []


def _put(one: Dot, at: Dot) -> Dot:
    return replace(one, x=at.x, y=at.y)


def _bore_name(bore: Bore) -> str:
    noun = {"drill": "hole", "punch": "punch mark"}.get(bore.kind, bore.kind)
    return f"{noun} {bore.face} at x {bore.x:.1f}"


def _bore(a: Bore, b: Bore, step: float) -> list[str]:
    changes = moved(b.x - a.x, b.y - a.y, step)
    if (a.kind, a.diameter) != (b.kind, b.diameter):
        other = "" if a.kind == b.kind else f"{b.kind} "
        changes.append(f"{a.kind} {a.diameter:g} to {other}{b.diameter:g}")
    changes += _figures([("stroke", a.stroke, b.stroke)], step)
    if a.spindle != b.spindle:
        changes.append(f"spindle {a.spindle} to {b.spindle}")
    if a.turning != b.turning:
        changes.append(f"spindle M{a.turning:02} to M{b.turning:02}")
    if abs(a.begin - b.begin) > step:
        changes.append(f"feed from {a.begin:g} to from {b.begin:g}")
    turns = ("pitch", a.pitch, b.pitch), ("speed", a.speed_rpm, b.speed_rpm)
    return [*changes, *_figures(turns, 1e-6), *_feed(a, b)]


def _path_place(trail: MachinedPath) -> tuple[float, float]:
    return trail.points[0]


def _path_to(trail: MachinedPath, at: MachinedPath) -> MachinedPath:
    (x, y), (to_x, to_y) = trail.points[0], at.points[0]
    return replace(trail, points=tuple((p + to_x - x, q + to_y - y) for p, q in trail.points))


def _path_name(trail: MachinedPath) -> str:
    return f"path of a {trail.kind} {trail.face} at x {trail.points[0][0]:.1f}"


def _path(a: MachinedPath, b: MachinedPath, step: float) -> list[str]:
    (ax, ay), (bx, by) = a.points[0], b.points[0]
    changes = moved(bx - ax, by - ay, step)
    if len(a.points) != len(b.points) or any(
        abs((p[0] - ax) - (q[0] - bx)) > step or abs((p[1] - ay) - (q[1] - by)) > step
        for p, q in zip(a.points, b.points, strict=False)
    ):
        changes.append("another course")
    depths = (
        ("least depth", a.min_depth, b.min_depth), ("greatest depth", a.max_depth, b.max_depth),
    )  # fmt: skip
    changes += _figures([(a.kind, a.diameter, b.diameter)], 0.0)
    return [*changes, *_figures(depths, step), *_feed(a, b)]


def _text_name(text: StampedText) -> str:
    return f"text {text.text!r} {text.face} at x {text.x:.1f}"


def _text(a: StampedText, b: StampedText, step: float) -> list[str]:
    changes = moved(b.x - a.x, b.y - a.y, step)
    if a.text != b.text:
        changes.append(f"text {a.text!r} to {b.text!r}")
    if a.kind != b.kind:
        changes.append(f"{a.kind} to {b.kind}")
    turned = ("height", a.height, b.height), ("angle", a.angle, b.angle)
    return [*changes, *_figures(turned, 1e-9)]


# Parts


_HEADER = (
    "mark", "length", "saw_length", "quantity", "order", "drawing", "phase", "grade",
)  # fmt: skip
_KINDS: tuple[type[Feature], ...] = (Hole, Slot, Contour, TextMark, Bend, EndPlane, Camber)
_NAMES = {
    Hole: "hole", Slot: "slot", Contour: "contour", TextMark: "text", Bend: "bend",
    EndPlane: "end plane", Camber: "camber",
}  # fmt: skip


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
        yield from differences_one_by_one(
            "hole" if kind is Hole else "feature", own, other, _place, _name, _feature
        )


def _by_face(a: Part, b: Part) -> Iterator[tuple[type[Feature], list[Feature], list[Feature]]]:
    """The features of two parts, kind by kind and face by face."""
    for kind in _KINDS:
        old, new = ([f for f in part.features if isinstance(f, kind)] for part in (a, b))
        for face in sorted({_face(f) for f in (*old, *new)}):
            own, other = ([f for f in some if _face(f) == face] for some in (old, new))
            yield kind, own, other


def _face(feature: Feature) -> str:
    return getattr(feature, "face", "")


def _place(feature: Feature | Bore | StampedText) -> tuple[float, float]:
    match feature:
        case Hole() | Slot() | TextMark() | Camber() | Bore() | StampedText():
            return feature.x, feature.y
        case Contour():
            boxes = [curve.bbox for curve in feature.curves]
            return (
                (min(b[0] for b in boxes) + max(b[2] for b in boxes)) / 2,
                (min(b[1] for b in boxes) + max(b[3] for b in boxes)) / 2,
            )
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
        if field.name == "curves":
            if _chain(a, b, bx - ax, by - ay):
                changes.append("another course")
        elif old != new:
            changes.append(f"{field.name.replace('_', ' ')} {shown(old)} to {shown(new)}")
    return changes


def _chain(a: Feature, b: Feature, dx: float, dy: float) -> bool:
    """Whether two contours have another course, moved onto each other and begun anywhere."""
    if not isinstance(a, Contour) or not isinstance(b, Contour):
        return False
    first, second = [_key(c, dx, dy) for c in a.curves], [_key(c, 0.0, 0.0) for c in b.curves]
    if not (a.closed and b.closed):
        return first != second
    return all(first[i:] + first[:i] != second for i in range(max(1, len(first))))


def _key(curve: Curve, dx: float, dy: float) -> tuple[object, ...]:
    """A curve's kind and five points of it, to a thousandth of a millimetre."""
    points = [curve.point(t / 4) for t in range(5)]
    return type(curve).__name__, *(
        (round(x + dx, 3) + 0.0, round(y + dy, 3) + 0.0) for x, y in points
    )


# --- statements -----------------------------------------------------------------------------------

# Statements of a program for a cutting table or a coper, independent of how they are written.
#
# G-code is compared by what its interpreter makes of it, so that block numbers, spacing, comments
# and modal words that are left out count for nothing. Trigger programs and step tables are compared
# line by line, without comments and spacing.


_ST_COMMENT = re.compile(r"\(\*.*?\*\)|//[^\n]*", re.DOTALL)


def diff_statements(
    first: Sequence[str], second: Sequence[str], decimals: int
) -> tuple[Difference, ...]:
    """Differences of the statements of program B from those of A."""
    from difflib import SequenceMatcher

    found = []
    pairs: list[tuple[str, str]] = []
    for how, i0, i1, j0, j1 in SequenceMatcher(None, first, second, False).get_opcodes():
        if how == "equal":
            continue
        for old, new in zip_longest(first[i0:i1], second[j0:j1]):
            if old is None:
                found.append(Difference("feature", "only in B", f"{new}, only in B"))
            elif new is None:
                found.append(Difference("feature", "only in A", f"{old}, only in A"))
            else:
                found.append(Difference("feature", "changed", f"{old} became {new}"))
                pairs.append((old, new))
    if len(pairs) == len(found) > 1 and (common := _common(pairs, decimals)):
        text = f"{len(pairs)} of {len(first)} statements: {common}"
        found = [Difference("feature", "changed", text, common)]
    return tuple(found)


def _common(pairs: Sequence[tuple[str, str]], decimals: int) -> str:
    """Difference common to all pairs of statements: "X +1.440, at 1000 to 1200"; "" if none."""
    said = {_changed_words(old, new, decimals) for old, new in pairs}
    return ", ".join(said.pop()) if len(said) == 1 else ""


def _changed_words(old: str, new: str, decimals: int) -> tuple[str, ...]:
    """The words that a statement has changed, each with the word before it; () if it is another."""
    before, after = old.split(), new.split()
    if len(before) != len(after):
        return ()
    changed: list[str] = []
    for k, (a, b) in enumerate(zip(before, after, strict=True)):
        if a != b:
            word = before[k - 1] if k else ""
            if word in ("X", "Y"):
                far = float(b.rstrip(",")) - float(a.rstrip(","))
                changed.append(f"{word} {far:+.{decimals}f}")
            else:
                changed.append(f"{word} {a} to {b}".strip())
    return tuple(dict.fromkeys(changed))


def statements(name: str, text: str, machine: Machine) -> tuple[list[str], tuple[Diagnostic, ...]]:
    """The statements of a program in words, and the errors in its blocks."""
    if machine.controller in DIALECTS:
        lines = _ST_COMMENT.sub("", text).splitlines()
        return [" ".join(line.split()) for line in lines if line.strip()], ()
    if machine.controller == "stepper":
        return [line.strip() for line in text.splitlines() if line.strip()[:1] not in ("", "#")], ()
    if machine.stock == "profile":
        around, said = cell_events(text, machine, name)
        return list(_turned(around, machine.format.length_decimals)), errors_in(said)
    events, said = table_events(text, machine, name)
    return list(_sentences(events, machine.format.length_decimals)), errors_in(said)


def _sentences(events: list[TableEvent], decimals: int) -> Iterator[str]:
    for event in events:
        match event:
            case Move(rapid=rapid, end=(x, y), curve=curve):
                to = f"X {_number(x, decimals)} Y {_number(y, decimals)}"
                feed = "" if rapid else f" at {event.feed_mm_min:g} mm/min"
                match curve:
                    case None:
                        yield f"{'rapid' if rapid else 'line'} to {to}{feed}"
                    case Arc(centre=(cx, cy)) | EllipseArc(centre=(cx, cy)):
                        about = f"X {_number(cx, decimals)} Y {_number(cy, decimals)}"
                        shape = "arc" if isinstance(curve, Arc) else "ellipse"
                        yield f"{shape} to {to} about {about}, {curve.sweep_deg:.2f} deg{feed}"
                    case _:
                        yield f"curve to {to}{feed}"
            case Switch():
                yield str(event)
            case Pause(seconds=seconds):
                yield f"pause of {seconds:g} s"
            case Compensation(side=side, radius=radius):
                yield f"keep {side} of the path by {radius:g}"
            case Blending(distance=distance):
                yield f"pass corners at {distance:g} mm"
            case Acceleration(braking=braking, mm_s2=mm_s2):
                yield f"{'brake' if braking else 'run up'} at {mm_s2:g} mm/s2"
            case Lift(rapid=rapid, end=height):
                feed = "" if rapid else f" at {event.feed_mm_min:g} mm/min"
                yield f"{'rapid' if rapid else 'feed'} to {height:g} mm over the sheet{feed}"
            case Touch():
                yield f"touch the sheet at {event.feed_mm_min:g} mm/min"
            case Zero(shifted=shifted):
                yield "Z counts from another place" if shifted else "Z counts from its own place"
            case Output(name=name, on=on, with_move=with_move):
                yield f"{name} {'on' if on else 'off'}{' with the next move' if with_move else ''}"
            case FeedShare(share=share):
                yield f"feed at {100 * share:g} %"
            case ToolOffset(number=number):
                yield f"places of tool {number}"
            case Material(values=values):
                yield " ".join(["material", *(f"{k} {v:g}" for k, v in values.items())])


def _turned(events: Sequence[BarEvent], decimals: int) -> Iterator[str]:
    """The statements of a program that goes round a profile."""
    for event in events:
        match event:
            case Move(rapid=rapid, end=end, feed_mm_min=feed, minutes=minutes, a_deg=(_, turn)):
                to = " ".join(
                    f"{n} {_number(v, decimals)}" for n, v in zip("XYZ", end, strict=True)
                )
                by = f" in {60 * minutes:.3f} s" if minutes else f" at {feed:g} mm/min"
                around = "" if isnan(turn) else f" A {turn:.3f}"
                yield f"{'rapid' if rapid else 'line'} to {to}{around}{'' if rapid else by}"
            case Switch():
                yield str(event)
            case Pause(seconds=seconds):
                yield f"pause of {seconds:g} s"


def _number(value: float, decimals: int) -> str:
    return f"{round(value, decimals) + 0.0:.{decimals}f}"
