"""Overlay of two things: how what they hold is drawn, by whether both have it.

same    grey       in both, unchanged
gone    red        only in A, or where A has it     - - -
new     green      only in B, or where B has it     -----
moved   violet     from where A has a thing to where B has it
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import dist
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.comparison.pairing import ThingPair
from beamcam.pictures.callouts import FaceSize, SizePlace, called_on
from beamcam.pictures.scene import PaperFrame, Pieces, Point, Polyline, Scene, Shape, Text
from beamcam.pictures.views import SIDE, WIDTH, View, figures, footing, head_height, heading, titles

MIN_ARROW = 2.0  #: pixels; nearer places have no arrow


class Overlay(Struct, frozen=True):
    """A picture of two things, and how many of what they hold is as it was."""

    scene: Scene
    same: int
    changed: int
    gone: int
    new: int


def radius_of_round(thing: Any) -> float:
    """Half the diameter of what has one, else 0."""
    return float(getattr(thing, "diameter", 0.0)) / 2


def faces_overlay(
    title: str, lines: Sequence[str], views: Iterable[View], pairs: Sequence[ThingPair],
    on_face: Mapping[str, Sequence[ThingPair]], words: Callable[[Any], Pieces],
    shapes: Callable[[Any, PaperFrame], Iterable[Shape]],
    stock: Callable[[View], Iterable[Shape]], origin: float = 0.0,
    radius: Callable[[Any], float] = radius_of_round,
) -> Overlay:  # fmt: skip
    """Pairs of things over each other, on the faces that they lie on.

    `words` are a thing's size, `shapes` the thing by itself, and `stock` what a face is cut of. The
    places of things count from `origin` on; a leader begins `radius` of a thing from its middle.
    """
    plain = [
        replace(view, places=_changed_places(on_face[view.name], origin), heights=())
        for view in views
    ]
    sizes = {face: _changed_sizes(own, words, origin, radius) for face, own in on_face.items()}
    drawn_on, bottom, called = called_on(plain, sizes, head_height(lines))
    drawn: list[Shape] = [*heading(lines), *titles(drawn_on)]
    drawn += [shape for one in called.values() for shape in one.shapes]
    for view in drawn_on:
        drawn += stock(view)
        frame = replace(view.frame, left=view.frame.left - origin * view.frame.scale)
        # Equal things first, so that differences are drawn on top.
        for pair in sorted(on_face[view.name], key=lambda pair: not pair.is_same):
            drawn += _drawn_pair(pair, shapes, frame)
        drawn += figures(view, "mm", -origin)
    same = sum(pair.is_same for pair in pairs)
    gone = sum(pair.b is None for pair in pairs)
    new = sum(pair.a is None for pair in pairs)
    changed = len(pairs) - same - gone - new
    about = f"{same} the same, {changed} changed, {gone} gone, {new} new"
    return Overlay(overlay_scene(title, drawn, bottom, about), same, changed, gone, new)


def _changed_places(pairs: Iterable[ThingPair], origin: float) -> tuple[float, ...]:
    """Where along x things lie that are not as they were, from `origin` on."""
    changed = [pair for pair in pairs if not pair.is_same]
    places = {p[0] for pair in changed for p in (pair.place_a, pair.place_b) if p is not None}
    return tuple(sorted(round(place - origin, 3) for place in places))


def _changed_sizes(
    pairs: Iterable[ThingPair], words_of: Callable[[Any], Pieces], origin: float,
    radius_of: Callable[[Any], float],
) -> list[FaceSize]:  # fmt: skip
    """The sizes of what is not as it was, in A and in B, each with its places from `origin` on."""
    sizes: dict[Pieces, list[SizePlace]] = {}
    for pair in pairs:
        a, b = words_of(pair.a), words_of(pair.b)
        at = pair.place_b or pair.place_a
        if pair.is_same or at is None or not (a or b):
            continue
        if pair.a is None or pair.b is None:
            words: Pieces = ("only A: ", *a) if pair.b is None else ("only B: ", *b)
        else:
            words = a if a == b else ("A ", *a, ", B ", *b)
        place = SizePlace((at[0] - origin, at[1]), radius_of(pair.b or pair.a))
        sizes.setdefault(words, []).append(place)
    return [FaceSize(words, tuple(places), True) for words, places in sizes.items()]


def _drawn_pair(
    pair: ThingPair, shapes: Callable[[Any, PaperFrame], Iterable[Shape]], frame: PaperFrame
) -> Iterator[Shape]:
    """A thing as both have it, with an arrow where its two places can be told apart."""
    both = (("gone", pair.a), ("new", pair.b))
    for style, thing in (("same", pair.b),) if pair.is_same else both:
        for shape in shapes(thing, frame) if thing is not None else ():
            name = f"{style}-text" if isinstance(shape, Text) else style
            yield replace(shape, classes=f"{name} {shape.classes.rpartition(' ')[2]}-of")
    if pair.is_same or pair.place_a is None or pair.place_b is None:
        return
    a, b = frame.at(*pair.place_a), frame.at(*pair.place_b)
    length = dist(a, b)
    if length >= MIN_ARROW:
        dx, dy = (b[0] - a[0]) / length, (b[1] - a[1]) / length
        size = min(6.0, length / 2)
        left = (b[0] - size * dx + size / 2 * dy, b[1] - size * dy - size / 2 * dx)
        right = (b[0] - size * dx - size / 2 * dy, b[1] - size * dy + size / 2 * dx)
        yield Polyline("moved arrow", (a, b, left, b, right), tip="moved")


def outlines(a: tuple[Point, ...], b: tuple[Point, ...], noun: str) -> Iterator[Polyline]:
    """What both are cut of, once where it is the same."""
    if a == b:
        yield Polyline("same stock-outline", a, True)
        return
    yield Polyline("gone stock-outline", a, True, f"{noun} of A")
    yield Polyline("new stock-outline", b, True, f"{noun} of B")


def overlay_scene(title: str, drawn: list[Shape], bottom: float, about: str) -> Scene:
    """The picture with its legend and its footing."""
    x, y = SIDE, bottom + 8.0
    for style, text in (("same", "the same"), ("gone", "in A"), ("new", "in B"),
                        ("moved", "moved")):  # fmt: skip
        drawn.append(Polyline(f"{style} legend", ((x, y), (x + 18.0, y))))
        drawn.append(Text("label", (x + 23.0, y + 4.0), text))
        x += 100.0
    has_figures = any(isinstance(shape, Text) and shape.mm is not None for shape in drawn)
    notes = ["lengths in mm; figures are where things differ"] if has_figures else []
    drawn += footing([about, *notes], y + 10.0)
    return Scene(title, about, WIDTH, y + 53.0, tuple(drawn))
