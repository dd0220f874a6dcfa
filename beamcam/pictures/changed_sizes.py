"""Callouts of what differs between two parts or two programs: its size in A and in B."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from msgspec.structs import replace

from beamcam.diff.pairing import Pair
from beamcam.model.part import Hole, Slot
from beamcam.pictures.callouts import Callouts, Place, Size, callouts, hole_words, slot_words
from beamcam.pictures.scene import Labels, Pieces, Shape
from beamcam.pictures.views import WIDTH, Paper, View, laid_out
from beamcam.verify.bars.machined_features import Bore


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
    pairs: Iterable[Pair],
    words_of: Callable[[Any], Pieces],
    origin: float = 0.0,
    radius_of: Callable[[Any], float] = radius_of_round,
) -> list[Size]:
    """The sizes of what is not as it was, in A and in B, each with its places from `origin` on.

    A leader begins `radius_of` a thing from its middle.
    """
    found: dict[Pieces, list[Place]] = {}
    for pair in pairs:
        a, b = words_of(pair.a), words_of(pair.b)
        at = pair.place_b or pair.place_a
        if pair.is_same or at is None or not (a or b):
            continue
        if pair.a is None or pair.b is None:
            words: Pieces = ("only A: ", *a) if pair.b is None else ("only B: ", *b)
        else:
            words = a if a == b else ("A ", *a, ", B ", *b)
        place = Place((at[0] - origin, at[1]), radius_of(pair.b or pair.a))
        found.setdefault(words, []).append(place)
    return [Size(words, tuple(places), True) for words, places in found.items()]


def called_on(
    views: Sequence[View], sizes: Mapping[str, Sequence[Size]], top: float
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
