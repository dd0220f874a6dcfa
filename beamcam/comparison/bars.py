"""Two programs for bars, compared by the cuts, holes, paths and texts that they make.

Each difference is a sentence: "hole v at x 1200.0 moved by 2.0 mm, drill 18 to 22".
"""

from collections.abc import Iterable, Iterator
from math import isnan
from typing import Any, TypeVar

from msgspec.structs import astuple, replace

from beamcam.checks.bars.stations import Bore, Cut, MachinedFeatures, MachinedPath, StampedText
from beamcam.comparison.pairing import (
    Difference,
    ThingKind,
    ThingPair,
    differences_of_kind,
    moved,
    paired,
    shown,
)

Dot = TypeVar("Dot", Bore, StampedText)


def diff_programs(
    a: MachinedFeatures, b: MachinedFeatures, resolution: float
) -> tuple[Difference, ...]:
    """Differences of program B from program A; lengths nearer than `resolution` are
    one."""
    step = resolution / 2 + 1e-9
    differences = []
    first, second = dict(a.section), dict(b.section)
    for name in sorted(first.keys() | second.keys()):
        old, new = first.get(name), second.get(name)
        if old != new and not (old is not None and new is not None and isnan(old) and isnan(new)):
            text = f"{name} {shown(old)} to {shown(new)}"
            differences.append(Difference("section", "changed", text))
    for things, kind in _kinds(step).items():
        differences += differences_of_kind(kind, getattr(a, things), getattr(b, things), step)
    if not differences and _order(a) != _order(b):
        text = "the same cuts and holes in another order"
        differences.append(Difference("order", "changed", text))
    return tuple(differences)


def made_pairs(a: MachinedFeatures, b: MachinedFeatures, resolution: float) -> Iterator[ThingPair]:
    """The cuts, holes and paths of two programs, each with its like in the other."""
    kinds = _kinds(resolution / 2 + 1e-9)
    cut = kinds.pop("cuts")
    yield from paired(a.cuts, b.cuts, cut.place, cut.changes)
    faces = {one.face for made in (a, b) for things in kinds for one in getattr(made, things)}
    for face in sorted(faces):
        for things, kind in kinds.items():
            both = [[t for t in getattr(made, things) if t.face == face] for made in (a, b)]
            yield from paired(both[0], both[1], kind.place, kind.changes)


def _kinds(step: float) -> dict[str, ThingKind[Any]]:
    """The things that a program makes, by the name that they have in `MachinedFeatures`."""
    return {
        "cuts": ThingKind(
            # Of cuts at one place those of like angle belong together.
            "cut", "cuts", lambda cut: (cut.x, cut.angle / 10), lambda cut: f"cut at x {cut.x:.1f}",
            lambda x, y: _cut(x, y, step), lambda x, y: replace(x, x=y.x),
        ),
        "bores": ThingKind(
            "hole", "holes", _place, _bore_name, lambda x, y: _bore(x, y, step), _put
        ),
        "paths": ThingKind(
            "feature", "paths", lambda path: path.points[0],
            lambda path: f"path of a {path.kind} {path.face} at x {path.points[0][0]:.1f}",
            lambda x, y: _path(x, y, step), _path_to,
        ),
        "texts": ThingKind(
            "feature", "texts", _place,
            lambda text: f"text {text.text!r} {text.face} at x {text.x:.1f}",
            lambda x, y: _text(x, y, step), _put,
        ),
    }  # fmt: skip


def _order(made: MachinedFeatures) -> list[tuple[object, ...]]:
    return [astuple(op)[1 : 3 if type(op) is Cut else 4] for op in made.order]


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


def _place(one: Bore | StampedText) -> tuple[float, float]:
    return one.x, one.y


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


def _path_to(trail: MachinedPath, at: MachinedPath) -> MachinedPath:
    (x, y), (to_x, to_y) = trail.points[0], at.points[0]
    return replace(trail, points=tuple((p + to_x - x, q + to_y - y) for p, q in trail.points))


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


def _text(a: StampedText, b: StampedText, step: float) -> list[str]:
    changes = moved(b.x - a.x, b.y - a.y, step)
    if a.text != b.text:
        changes.append(f"text {a.text!r} to {b.text!r}")
    if a.kind != b.kind:
        changes.append(f"{a.kind} to {b.kind}")
    turned = ("height", a.height, b.height), ("angle", a.angle, b.angle)
    return [*changes, *_figures(turned, 1e-9)]
