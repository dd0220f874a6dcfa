"""Differences between things of one kind: paired by place, or said of all of them at once."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from math import hypot
from typing import Any, Generic, Literal, NamedTuple, TypeVar

from msgspec import Struct
from msgspec.structs import replace

NEAR = 60.0  #: mm; what lies nearer is taken to have moved, what lies further to be another thing

T = TypeVar("T")


class Difference(Struct, frozen=True):
    """One difference between A and B."""

    what: Literal["section", "cut", "hole", "order", "part", "feature"]
    how: Literal["changed", "only in A", "only in B"]
    text: str
    of_all: str = ""  #: the same said of all things of its kind, where it is true of all

    def as_data(self) -> dict[str, str]:
        """The difference as `--json` prints it."""
        return {"what": self.what, "how": self.how, "text": self.text}


class ThingKind(NamedTuple, Generic[T]):
    """What is known of the things of one kind that a program makes."""

    what: Literal["cut", "hole", "feature"]
    plural: str
    place: Callable[[T], tuple[float, float]]
    name: Callable[[T], str]
    changes: Callable[[T, T], list[str]]
    put: Callable[[T, T], T]  #: the first where the second is


def differences_of_kind(
    kind: ThingKind[T], a: Sequence[T], b: Sequence[T], step: float
) -> Iterator[Difference]:
    """The differences of one kind of things: of all at once, of those of a face, one by one."""
    faces = sorted({_face_of(thing) for thing in (*a, *b)})
    groups: list[tuple[Sequence[T], Sequence[T], str]] = []
    if common := _common(kind, a, b, step):
        groups.append((a, b, f"all {kind.plural} {common}"))
    for face in faces if not groups else ():
        first, second = ([one for one in some if _face_of(one) == face] for some in (a, b))
        common = _common(kind, first, second, step) if len(faces) > 1 else ""
        groups.append((first, second, f"all {kind.plural} {face} {common}" if common else ""))
    for own, other, of_all in groups:
        if of_all and len(own) > 1:
            yield Difference(kind.what, "changed", of_all, of_all)
            continue
        each = differences_one_by_one(kind.what, own, other, kind.place, kind.name, kind.changes)
        yield from (replace(one, of_all=of_all) for one in each)


def _common(kind: ThingKind[T], a: Sequence[T], b: Sequence[T], step: float) -> str:
    """What is true of each thing of A and its like in B: "X +1.440, feed 90 to 80 mm/min".

    "" where there is nothing of the kind, or it is not the same of all.
    """
    if len(a) != len(b):
        return ""
    lines: list[str] = []
    shift: tuple[float, float] | None = None
    by_place = [sorted(things, key=lambda t: (_face_of(t), *kind.place(t))) for things in (a, b)]
    for x, y in zip(*by_place, strict=True):
        (ax, ay), (bx, by) = kind.place(x), kind.place(kind.put(x, y))
        if shift is None:
            shift, lines = (bx - ax, by - ay), kind.changes(x, kind.put(y, x))
        elif (
            abs(bx - ax - shift[0]) > step
            or abs(by - ay - shift[1]) > step
            or kind.changes(x, kind.put(y, x)) != lines
        ):
            return ""
    axes = zip("XY", shift or (), strict=False)
    return ", ".join([*(f"{axis} {by:+.3f}" for axis, by in axes if abs(by) > step), *lines])


def _face_of(thing: object) -> str:
    return getattr(thing, "face", "")


def moved(dx: float, dy: float, step: float) -> list[str]:
    if abs(dx) <= step and abs(dy) <= step:
        return []
    way = "" if abs(dy) <= step else " across" if abs(dx) <= step else " in x and y"
    far = hypot(dx, dy)
    decimals = 1 if abs(far * 10 - round(far * 10)) < 1e-6 else 3
    return [f"moved by {far:.{decimals}f} mm{way}"]


def shown(value: object) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    return "none" if value is None or value == "" else str(value)


def differences_one_by_one(
    what: Literal["cut", "hole", "feature"], a: Iterable[T], b: Iterable[T],
    place: Callable[[T], tuple[float, float]], name: Callable[[T], str],
    changes: Callable[[T, T], list[str]],
) -> Iterator[Difference]:  # fmt: skip
    """Things of A and B paired: first those that are the same, then the nearest ones."""
    sides = list(a), list(b)
    counts = [Counter(map(name, side)) for side in sides]

    def called(thing: T, side: int) -> str:
        """The thing's name, with its y where others on its side have the same name."""
        own = name(thing)
        return f"{own}, y {place(thing)[1]:.1f}" if counts[side][own] > 1 else own

    for pair in paired(*sides, place, changes):
        if pair.b is None:
            yield Difference(what, "only in A", f"{called(pair.a, 0)} only in A")
        elif pair.a is None:
            yield Difference(what, "only in B", f"{called(pair.b, 1)} only in B")
        elif pair.changes:
            yield Difference(what, "changed", f"{called(pair.a, 0)} {', '.join(pair.changes)}")


class ThingPair(Struct, frozen=True):
    """A thing of A and what it is in B; None where it is not there."""

    a: Any
    b: Any
    place_a: tuple[float, float] | None
    place_b: tuple[float, float] | None
    changes: tuple[str, ...] = ()  #: of a thing that both have

    @property
    def is_same(self) -> bool:
        """Whether both have it, unchanged."""
        return self.a is not None and self.b is not None and not self.changes


def paired(
    left: Sequence[T],
    right: Sequence[T],
    place: Callable[[T], tuple[float, float]],
    changes: Callable[[T, T], list[str]],
) -> Iterator[ThingPair]:
    """Things of A and B, each with its like in the other: those that are the same, the nearest
    ones, and those left alone."""
    index: dict[tuple[float, float], list[int]] = {}
    for i, thing in enumerate(right):
        index.setdefault(place(thing), []).append(i)
    taken: set[int] = set()
    rest: list[T] = []
    for thing in left:
        at = place(thing)
        same = next(
            (i for i in index.get(at, ()) if i not in taken and not changes(thing, right[i])), None
        )
        if same is None:
            rest.append(thing)
        else:
            taken.add(same)
            yield ThingPair(thing, right[same], at, at)
    free = [t for i, t in enumerate(right) if i not in taken]
    nearest = sorted(
        (hypot(place(x)[0] - place(y)[0], place(x)[1] - place(y)[1]), len(changes(x, y)), i, j)
        for i, x in enumerate(rest)
        for j, y in enumerate(free)
        if abs(place(x)[0] - place(y)[0]) <= NEAR
    )
    mine: dict[int, int] = {}
    theirs: set[int] = set()
    for distance, _, i, j in nearest:
        if distance <= NEAR and i not in mine and j not in theirs:
            mine[i] = j
            theirs.add(j)
    for i, thing in enumerate(rest):
        if i in mine:
            other = free[mine[i]]
            changed = tuple(changes(thing, other))
            yield ThingPair(thing, other, place(thing), place(other), changed)
        else:
            yield ThingPair(thing, None, place(thing), None)
    for j, thing in enumerate(free):
        if j not in theirs:
            yield ThingPair(None, thing, None, place(thing))
