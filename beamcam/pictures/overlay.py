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

from beamcam.checks.bars.stations import Bore
from beamcam.comparison.pairing import ThingPair
from beamcam.model.part import Hole, Slot
from beamcam.pictures.callouts import (
    Callouts,
    FaceSize,
    SizePlace,
    callouts,
    hole_words,
    slot_words,
)
from beamcam.pictures.scene import Labels, PaperFrame, Pieces, Point, Polyline, Scene, Shape, Text
from beamcam.pictures.views import SIDE, WIDTH, Paper, View, footing, laid_out

MIN_ARROW = 2.0  #: pixels; nearer places have no arrow


class Overlay(Struct, frozen=True):
    """A picture of two things, and how many of what they hold is as it was."""

    scene: Scene
    same: int
    changed: int
    gone: int
    new: int


def changed_places(pairs: Iterable[ThingPair], origin: float = 0.0) -> tuple[float, ...]:
    """Where along x things lie that are not as they were, from `origin` on."""
    changed = [pair for pair in pairs if not pair.is_same]
    places = {p[0] for pair in changed for p in (pair.place_a, pair.place_b) if p is not None}
    return tuple(sorted(round(place - origin, 3) for place in places))


def rising(pairs: Iterable[ThingPair]) -> list[ThingPair]:
    """Equal features first, so that differences are drawn on top."""
    return sorted(pairs, key=lambda pair: not pair.is_same)


def drawn_pair(
    pair: ThingPair, shapes: Callable[[Any], Iterable[Shape]], frame: PaperFrame
) -> Iterator[Shape]:
    """A thing as both have it."""
    if pair.is_same:
        yield from _in_style(shapes(pair.b), "same")
        return
    if pair.a is not None:
        yield from _in_style(shapes(pair.a), "gone")
    if pair.b is not None:
        yield from _in_style(shapes(pair.b), "new")
    if pair.place_a is not None and pair.place_b is not None:
        yield from _arrow(frame.at(*pair.place_a), frame.at(*pair.place_b))


def _in_style(shapes: Iterable[Shape], style: str) -> Iterator[Shape]:
    for shape in shapes:
        name = f"{style}-text" if isinstance(shape, Text) else style
        yield replace(shape, classes=f"{name} {shape.classes.rpartition(' ')[2]}-of")


def _arrow(a: Point, b: Point) -> Iterator[Polyline]:
    """An arrow from one place to the other, where they can be told apart."""
    length = dist(a, b)
    if length < MIN_ARROW:
        return
    dx, dy = (b[0] - a[0]) / length, (b[1] - a[1]) / length
    size = min(6.0, length / 2)
    left = (b[0] - size * dx + size / 2 * dy, b[1] - size * dy - size / 2 * dx)
    right = (b[0] - size * dx - size / 2 * dy, b[1] - size * dy + size / 2 * dx)
    yield Polyline("moved arrow", (a, b, left, b, right), tip="moved")


def program_names(a: str, hash_a: str, b: str, hash_b: str) -> list[str]:
    """The lines above an overlay of two programs."""
    return ["two programs", f"A {a}   sha-256 {hash_a}", f"B {b}   sha-256 {hash_b}"]


def compared_pairs(
    title: str, lines: Sequence[str], drawn: list[Shape], paper: Paper, pairs: Sequence[ThingPair]
) -> Overlay:
    """An overlay whose things are pairs, with how many there are of each sort."""
    same = sum(pair.is_same for pair in pairs)
    gone = sum(pair.b is None for pair in pairs)
    new = sum(pair.a is None for pair in pairs)
    changed = len(pairs) - same - gone - new
    about = f"{same} the same, {changed} changed, {gone} gone, {new} new"
    return Overlay(overlay_scene(title, lines, drawn, paper, about), same, changed, gone, new)


def overlay_scene(
    title: str, lines: Sequence[str], drawn: list[Shape], paper: Paper, about: str
) -> Scene:
    y = paper.bottom + 8.0
    x = SIDE
    for style, text in (("same", "the same"), ("gone", "in A"), ("new", "in B"),
                        ("moved", "moved")):  # fmt: skip
        drawn.append(Polyline(f"{style} legend", ((x, y), (x + 18.0, y))))
        drawn.append(Text("label", (x + 23.0, y + 4.0), text))
        x += 100.0
    has_figures = any(isinstance(shape, Text) and shape.mm is not None for shape in drawn)
    notes = ["lengths in mm; figures are where things differ"] if has_figures else []
    drawn += footing([about, *notes], y + 10.0)
    return Scene(title, about, WIDTH, y + 53.0, tuple(drawn))


def feature_words(feature: Any) -> Pieces:
    """The size of a hole or a slot as a drawing says it; nothing of other features."""
    if isinstance(feature, Hole):
        return hole_words(feature)
    return slot_words(feature) if isinstance(feature, Slot) else ()


def bore_words(thing: Any) -> Pieces:
    """What a stroke makes; nothing of paths and texts."""
    if not isinstance(thing, Bore):
        return ()
    return ("" if thing.kind == "drill" else f"{thing.kind} ", "Ø", thing.diameter)


def radius_of_round(thing: Any) -> float:
    """Half the diameter of what has one, else 0."""
    return float(getattr(thing, "diameter", 0.0)) / 2


def changed_sizes(
    pairs: Iterable[ThingPair],
    words_of: Callable[[Any], Pieces],
    origin: float = 0.0,
    radius_of: Callable[[Any], float] = radius_of_round,
) -> list[FaceSize]:
    """The sizes of what is not as it was, in A and in B, each with its places from `origin` on.

    A leader begins `radius_of` a thing from its middle.
    """
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


def called_on(
    views: Sequence[View], sizes: Mapping[str, Sequence[FaceSize]], top: float
) -> tuple[tuple[View, ...], Paper, list[Shape]]:
    """The views with room for callouts above each face, their paper, and the callouts."""

    def callouts_on(views: Sequence[View], paper: Paper) -> dict[str, Callouts]:
        found = {}
        for view in views:
            frame = paper.frames[view.name]
            (left, high), (right, low) = (
                frame.at(x, y) for x, y in ((view.box[0], view.top), (view.box[2], view.bottom))
            )
            face = (left, high, right, low)
            found[view.name] = callouts(
                sizes[view.name], {}, frame, face, WIDTH - 8.0, Labels(), "mm"
            )
        return found

    above = callouts_on(views, laid_out(views, top))
    higher = tuple(replace(view, above=above[view.name].above) for view in views)
    paper = laid_out(higher, top)  # once more, as each face stands lower by what is above it
    called = callouts_on(higher, paper)
    return higher, paper, [shape for one in called.values() for shape in one.shapes]
