"""Curves that a drawing holds twice: removed, so that no torch passes a place twice."""

from collections import defaultdict
from collections.abc import Callable, Sequence
from enum import Enum
from itertools import product
from math import degrees, floor

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
    into: int  #: the given curve that represents it
    why: Why


class Cleaned(Struct, frozen=True):
    """Curves without repetition, in the order given, and what was taken away."""

    curves: tuple[Curve, ...]
    indices: tuple[int, ...]  #: which of the curves given each is, or begins with
    removed: tuple[Removed, ...]


def remove_repetitions(
    curves: Sequence[Curve], tolerance: float, others: Sequence[Curve] = ()
) -> Cleaned:
    """Curves without duplicates, and with overlapping parts of one line or circle merged.

    Curves are duplicates if they are of one kind and five points along them are no farther
    apart than `tolerance`, in either direction. Stretches overlap if they share more than the
    tolerance of a line or circle; touching ends are not overlap. The first of them stays.

    They are not merged where another curve, one of `others` too, ends at an end that would be
    lost: there one contour may go on along a line that another one shares.

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
    ends = _Ends(tolerance)
    for name, curve in (*kept.items(), *((-1, other) for other in others)):
        if distance(curve.start, curve.end) > tolerance:
            ends.add(name, curve)
    # Merging lengthens a curve, which may then meet others: again until nothing changes.
    while True:
        names = sorted(kept)
        merged = 0
        for i, k in _neighbours([kept[n] for n in names], tolerance):
            a, b = names[i], names[k]
            if a not in kept or b not in kept:
                continue
            joined = _merged(kept[a], kept[b], tolerance)
            if joined is None:
                continue
            lost = ends.lost(joined, kept[a], kept[b])
            if all(o in kept and _merged(joined, kept[o], tolerance) for o in lost - {a, b}):
                ends.remove(a, kept[a])
                ends.remove(b, kept[b])
                ends.add(a, joined)
                kept[a] = joined
                del kept[b]
                removed.append(Removed(b, a, Why.OVERLAP))
                merged += 1
        if not merged:
            break
    names = sorted(kept)
    removed.sort(key=lambda r: r.index)
    return Cleaned(tuple(kept[n] for n in names), tuple(names), tuple(removed))


class _Ends:
    """The ends of curves, found again by their place."""

    def __init__(self, tolerance: float) -> None:
        self._tolerance = tolerance
        self._cells: defaultdict[tuple[int, int], list[tuple[int, Point]]] = defaultdict(list)

    def _cell(self, point: Point) -> tuple[int, int]:
        return floor(point[0] / self._tolerance), floor(point[1] / self._tolerance)

    def add(self, name: int, curve: Curve) -> None:
        for point in (curve.start, curve.end):
            self._cells[self._cell(point)].append((name, point))

    def remove(self, name: int, curve: Curve) -> None:
        for point in (curve.start, curve.end):
            cell = self._cells[self._cell(point)]
            if (name, point) in cell:
                cell.remove((name, point))

    def lost(self, joined: Curve, a: Curve, b: Curve) -> set[int]:
        """The curves that end where `joined`, made of two curves, has no end there."""
        kept, near = (joined.start, joined.end), (-1, 0, 1)
        return {
            name
            for point in (a.start, a.end, b.start, b.end)
            if min(distance(point, end) for end in kept) > self._tolerance
            for column, row in (self._cell(point),)
            for i, k in product(near, near)
            for name, end in self._cells.get((column + i, row + k), ())
            if distance(point, end) <= self._tolerance
        }


def uncovered(curve: Curve, covers: Sequence[Curve], tolerance: float) -> tuple[Curve, ...]:
    """The parts of a curve that lie on none of the others, in its order and direction.

    Lines are looked for on lines and arcs on circles no farther off than `tolerance`, other
    curves as a whole only. What is left and no longer than the tolerance is nothing.
    """
    if any(_are_same(curve, cover, tolerance) for cover in covers):
        return ()
    if not isinstance(curve, Line | Arc):
        return (curve,)
    taken: list[tuple[float, float]] = []
    for cover in covers:
        if isinstance(curve, Line) and isinstance(cover, Line):
            taken += _shared_line(curve, cover, tolerance)
        elif isinstance(curve, Arc) and isinstance(cover, Arc):
            taken += _shared_arc(curve, cover, tolerance)
    if not taken:
        return (curve,)
    curves: list[Curve] = []
    at = 0.0
    for low, high in (*sorted(taken), (1.0, 1.0)):
        if (low - at) * curve.length > tolerance:
            part = curve if low >= 1.0 else curve.split(low)[0]
            curves.append(part if at <= 0.0 else part.split(at / min(low, 1.0))[1])
        at = max(at, high)
    return tuple(curves)


def _shared_line(line: Line, cover: Line, tolerance: float) -> list[tuple[float, float]]:
    """The shares of a line between which it lies on another."""
    length = line.length
    if length <= tolerance or cover.length <= tolerance:
        return []
    ux, uy = line.tangent(0.0)
    along, aside = [], []
    for p in (cover.start, cover.end):
        rest = (p[0] - line.start[0], p[1] - line.start[1])
        along.append(dot((ux, uy), rest))
        aside.append(cross((ux, uy), rest))
    low, high = max(0.0, min(along)), min(length, max(along))
    if high - low <= tolerance:
        return []
    slope = (aside[1] - aside[0]) / (along[1] - along[0])
    off = [aside[0] + (at - along[0]) * slope for at in (low, high)]
    return [] if max(map(abs, off)) > tolerance else [(low / length, high / length)]


def _shared_arc(arc: Arc, cover: Arc, tolerance: float) -> list[tuple[float, float]]:
    """The shares of an arc between which it lies on another."""
    if not _same_circle(arc, cover, tolerance):
        return []
    if _is_circle(cover):
        return [(0.0, 1.0)]
    sign = 1.0 if arc.sweep_deg > 0 else -1.0
    other = cover if (cover.sweep_deg > 0) == (arc.sweep_deg > 0) else cover.reversed()
    sweep, slack = abs(arc.sweep_deg), degrees(tolerance / arc.radius)
    begin = (other.start_deg - arc.start_deg) * sign % 360.0
    points = []
    for low in (begin - 360.0, begin):
        shared = max(0.0, low), min(sweep, low + abs(other.sweep_deg))
        if shared[1] - shared[0] > slack:
            points.append((shared[0] / sweep, shared[1] / sweep))
    return points


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
    if isinstance(a, Arc) and isinstance(b, Arc) and _same_circle(a, b, tolerance):
        forward = a.sweep_deg > 0
        one, two = (arc if arc.sweep_deg > 0 else arc.reversed() for arc in (a, b))
        slack_deg = degrees(tolerance / a.radius)
        low, high = one.start_deg, one.start_deg + one.sweep_deg
        start = one.start_deg + (two.start_deg - one.start_deg) % 360.0
        is_merged = False
        # The second arc as it lies from the start of the first on, and a turn before.
        for begin in (start - 360.0, start):
            shared = min(high, begin + two.sweep_deg) - max(low, begin)
            if shared > slack_deg:
                low, high = min(low, begin), max(high, begin + two.sweep_deg)
                is_merged = True
        if not is_merged:
            return None
        joined = replace(one, start_deg=low, sweep_deg=high - low)
        if high - low >= 360.0 - slack_deg:
            joined = replace(one, sweep_deg=360.0)
        return joined if forward else joined.reversed()
    return None
