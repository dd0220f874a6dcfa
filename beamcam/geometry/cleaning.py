"""Curves that a drawing holds twice: removed, so that no torch passes a place twice."""

from collections.abc import Callable, Sequence
from enum import Enum
from math import degrees

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point, cross, distance, dot


class Why(Enum):
    """Why a curve was removed."""

    DUPLICATE = "duplicate"  #: the same as another, in either direction
    OVERLAP = "overlap"  #: merged into another on the same line or circle


class Removed(Struct, frozen=True):
    """A curve that is not there any more."""

    index: int  #: of the curves given
    into: int  #: the curve given that stands for it
    why: Why


class Cleaned(Struct, frozen=True):
    """Curves without repetition, in the order given, and what was taken away."""

    curves: tuple[Curve, ...]
    indices: tuple[int, ...]  #: which of the curves given each is, or begins with
    removed: tuple[Removed, ...]


def remove_repetitions(curves: Sequence[Curve], tolerance: float) -> Cleaned:
    """Curves without duplicates, and with overlapping stretches of one line or circle merged.

    Curves are duplicates if they are of one kind and five points along them are no farther
    apart than `tolerance`, in either direction. Stretches overlap if they share more than the
    tolerance of a line or circle; touching ends are no overlap. The first of them stays.

    Raises ValueError if the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    kept: dict[int, Curve] = dict(enumerate(curves))
    removed: list[Removed] = []
    for a, b in _neighbours(curves, tolerance):
        if a in kept and b in kept and _are_same(curves[a], curves[b], tolerance):
            del kept[b]
            removed.append(Removed(b, a, Why.DUPLICATE))
    # Merging lengthens a curve, which may then meet others: again until nothing changes.
    while True:
        names = sorted(kept)
        merged = 0
        for i, k in _neighbours([kept[n] for n in names], tolerance):
            a, b = names[i], names[k]
            if a not in kept or b not in kept:
                continue
            joined = _merged(kept[a], kept[b], tolerance)
            if joined is not None:
                kept[a] = joined
                del kept[b]
                removed.append(Removed(b, a, Why.OVERLAP))
                merged += 1
        if not merged:
            break
    names = sorted(kept)
    removed.sort(key=lambda r: r.index)
    return Cleaned(tuple(kept[n] for n in names), tuple(names), tuple(removed))


def _neighbours(curves: Sequence[Curve], tolerance: float) -> list[tuple[int, int]]:
    """Pairs (a, b), a < b, whose boxes touch, in ascending order: a sweep along x."""
    boxes = [curve.bbox for curve in curves]
    active: list[int] = []
    pairs = []
    for k in sorted(range(len(curves)), key=lambda i: boxes[i][0]):
        x0, y0, _, y1 = boxes[k]
        active = [i for i in active if boxes[i][2] >= x0 - tolerance]
        for i in active:
            if boxes[i][1] <= y1 + tolerance and boxes[i][3] >= y0 - tolerance:
                pairs.append((min(i, k), max(i, k)))
        active.append(k)
    return sorted(pairs)


def _are_same(a: Curve, b: Curve, tolerance: float) -> bool:
    if type(a) is not type(b):
        return False
    shares = (0.0, 0.25, 0.5, 0.75, 1.0)
    if _is_circle(a) and _is_circle(b):
        return _same_circle(a, b, tolerance)

    def agree(of_b: Callable[[float], float]) -> bool:
        return all(distance(a.point(t), b.point(of_b(t))) <= tolerance for t in shares)

    return agree(lambda t: t) or agree(lambda t: 1.0 - t)


def _is_circle(curve: Curve) -> bool:
    return isinstance(curve, Arc) and abs(curve.sweep_deg) == 360.0


def _same_circle(a: Curve, b: Curve, tolerance: float) -> bool:
    return (
        isinstance(a, Arc)
        and isinstance(b, Arc)
        and distance(a.centre, b.centre) + abs(a.radius - b.radius) <= tolerance
    )


def _merged(a: Curve, b: Curve, tolerance: float) -> Curve | None:
    """The curve over both, with the direction of `a`; None if they do not overlap."""
    if isinstance(a, Line) and isinstance(b, Line):
        return _merged_lines(a, b, tolerance)
    if isinstance(a, Arc) and isinstance(b, Arc) and _same_circle(a, b, tolerance):
        return _merged_arcs(a, b, tolerance)
    return None


def _merged_lines(a: Line, b: Line, tolerance: float) -> Line | None:
    long, short = (a, b) if a.length >= b.length else (b, a)
    if long.length <= tolerance:
        return None
    ux, uy = long.tangent(0.0)

    def along(p: Point) -> float:
        return dot((ux, uy), (p[0] - long.start[0], p[1] - long.start[1]))

    for p in (short.start, short.end):
        if abs(cross((ux, uy), (p[0] - long.start[0], p[1] - long.start[1]))) > tolerance:
            return None
    low, high = sorted((along(short.start), along(short.end)))
    shared = min(high, long.length) - max(low, 0.0)
    if shared <= tolerance:
        return None
    ends = sorted([*((along(p), p) for p in (a.start, a.end, b.start, b.end))])
    first, last = ends[0][1], ends[-1][1]
    forward = along(a.end) > along(a.start)
    return Line(first, last) if forward else Line(last, first)


def _merged_arcs(a: Arc, b: Arc, tolerance: float) -> Arc | None:
    forward = a.sweep_deg > 0
    one, two = (arc if arc.sweep_deg > 0 else arc.reversed() for arc in (a, b))
    slack_deg = degrees(tolerance / a.radius)
    low, high = one.start_deg, one.start_deg + one.sweep_deg
    start = one.start_deg + (two.start_deg - one.start_deg) % 360.0
    found = False
    # The second arc as it lies from the start of the first on, and a turn before.
    for begin in (start - 360.0, start):
        shared = min(high, begin + two.sweep_deg) - max(low, begin)
        if shared > slack_deg:
            low, high = min(low, begin), max(high, begin + two.sweep_deg)
            found = True
    if not found:
        return None
    whole = high - low >= 360.0 - slack_deg
    joined = replace(one, start_deg=low, sweep_deg=high - low)
    if whole:
        joined = replace(one, sweep_deg=360.0)
    return joined if forward else joined.reversed()
