"""Curves of a drawing joined to chains, end to end.

A hash grid whose cells are as wide as the tolerance finds the ends near a point in nine cells,
so joining takes linear time.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from math import floor, hypot

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.bezier import Bezier
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point, distance

#: Ends nearer than this are one point; nothing has to be moved to join them.
SAME_POINT = 1e-9


class Chain(Struct, frozen=True):
    """Curves that follow one another."""

    curves: tuple[Curve, ...]
    closed: bool
    members: tuple[int, ...]  #: which of the curves given each comes from; -1 for a bridge


class Junction(Struct, frozen=True):
    """A place where three ends or more meet: chains stop there, as the way on is not known."""

    point: Point
    members: tuple[int, ...]  #: the curves that end there, ascending


class Gap(Struct, frozen=True):
    """Two ends of chains that are near but farther apart than the tolerance: not joined."""

    start: Point
    end: Point
    members: tuple[int, int]

    @property
    def width(self) -> float:
        return distance(self.start, self.end)


class Chains(Struct, frozen=True):
    """What joining gives: every curve given is in just one chain or dropped."""

    chains: tuple[Chain, ...]
    junctions: tuple[Junction, ...]
    gaps: tuple[Gap, ...]
    dropped: tuple[int, ...]  #: curves no larger than the tolerance


class _Grid:
    """Points in square cells."""

    def __init__(self, cell: float) -> None:
        self.cell = cell
        self.cells: dict[tuple[int, int], list[tuple[Point, int]]] = defaultdict(list)

    def add(self, point: Point, name: int) -> None:
        self.cells[self._cell_of(point)].append((point, name))

    def near(self, point: Point) -> Iterator[tuple[float, int]]:
        """Distance and name of the points no farther than a cell is wide."""
        column, row = self._cell_of(point)
        for i in (column - 1, column, column + 1):
            for k in (row - 1, row, row + 1):
                for other, name in self.cells.get((i, k), ()):
                    away = distance(point, other)
                    if away <= self.cell:
                        yield away, name

    def _cell_of(self, point: Point) -> tuple[int, int]:
        return floor(point[0] / self.cell), floor(point[1] / self.cell)


def join_curves(curves: Sequence[Curve], tolerance: float, look: float | None = None) -> Chains:
    """Chains of curves whose ends are no farther apart than `tolerance`, in the order given.

    Curves are turned round where needed. An end within the tolerance is moved onto its
    neighbour where a curve can be (lines and free curves), else a line bridges the rest. Where
    three ends or more meet, chains stop and a junction is reported. Open ends of chains nearer
    than `look` (10 times the tolerance if not given) are reported as gaps. Curves no larger
    than the tolerance are dropped: both their ends would be one.

    Raises ValueError if the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    tiny = [_size(c) <= tolerance for c in curves]
    closed = [distance(c.start, c.end) <= SAME_POINT for c in curves]
    # Ends are numbered 2 k for the start and 2 k + 1 for the end of curve k.
    left_out = [a or b for a, b in zip(closed, tiny, strict=True)]
    clusters = _cluster_ends(curves, left_out, tolerance)
    partner: dict[int, int] = {}
    junctions = []
    for ends in clusters:
        if len(ends) == 2:
            partner[ends[0]], partner[ends[1]] = ends[1], ends[0]
        elif len(ends) > 2:
            members = tuple(sorted({e // 2 for e in ends}))
            junctions.append(Junction(_end_point(curves, ends[0]), members))
    chains: list[Chain] = []
    used = [False] * len(curves)
    for k in range(len(curves)):
        if used[k] or tiny[k]:
            continue
        if closed[k]:
            used[k] = True
            chains.append(Chain((curves[k],), True, (k,)))
        else:
            chains.append(_walk(curves, k, partner, used))
    gaps = _find_gaps(chains, 10 * tolerance if look is None else look, tolerance)
    dropped = tuple(k for k in range(len(curves)) if tiny[k])
    return Chains(tuple(chains), tuple(junctions), gaps, dropped)


def _size(curve: Curve) -> float:
    x0, y0, x1, y1 = curve.bbox
    return hypot(x1 - x0, y1 - y0)


def _end_point(curves: Sequence[Curve], end: int) -> Point:
    return curves[end // 2].end if end % 2 else curves[end // 2].start


def _cluster_ends(
    curves: Sequence[Curve], left_out: Sequence[bool], tolerance: float
) -> list[list[int]]:
    """Groups of ends that meet, in the order of their first member."""
    grid = _Grid(tolerance)
    ends = [e for k in range(len(curves)) if not left_out[k] for e in (2 * k, 2 * k + 1)]
    for e in ends:
        grid.add(_end_point(curves, e), e)
    group: dict[int, int] = {}
    found: list[list[int]] = []
    for e in ends:
        if e in group:
            continue
        cluster, waiting = [], [e]
        group[e] = len(found)
        while waiting:
            member = waiting.pop()
            cluster.append(member)
            for _, other in grid.near(_end_point(curves, member)):
                if other not in group:
                    group[other] = len(found)
                    waiting.append(other)
        found.append(sorted(cluster))
    return found


def _walk(curves: Sequence[Curve], first: int, partner: dict[int, int], used: list[bool]) -> Chain:
    """The chain through curve `first`, which keeps its direction."""
    ends = list(_follow(2 * first, partner))
    ring = partner.get(ends[-1] ^ 1) == 2 * first
    if not ring and 2 * first in partner:
        back = list(_follow(partner[2 * first], partner))
        ends = [e ^ 1 for e in reversed(back)] + ends
    parts = []
    for e in ends:
        used[e // 2] = True
        parts.append(curves[e // 2].reversed() if e % 2 else curves[e // 2])
    joined, names = _joined(parts, [e // 2 for e in ends], ring)
    return Chain(joined, ring, names)


def _follow(end: int, partner: dict[int, int]) -> Iterator[int]:
    """The ends by which curves are entered, from `end` on, until the way stops or closes."""
    at: int | None = end
    while at is not None:
        yield at
        at = partner.get(at ^ 1)
        if at == end:
            return


def _joined(
    parts: list[Curve], names: list[int], ring: bool
) -> tuple[tuple[Curve, ...], tuple[int, ...]]:
    """The curves with their ends moved together, and lines where that cannot be."""
    count = len(parts)
    bridges: dict[int, Line] = {}
    for k in range(count if ring else count - 1):
        following = (k + 1) % count
        a, b = parts[k].end, parts[following].start
        if distance(a, b) <= SAME_POINT:
            continue
        moved_start = _with_start(parts[following], a) if following != k else None
        moved_end = _with_end(parts[k], b)
        if moved_end is not None:
            parts[k] = moved_end
        elif moved_start is not None:
            parts[following] = moved_start
        else:
            bridges[k] = Line(a, b)
    curves: list[Curve] = []
    members: list[int] = []
    for k, (part, name) in enumerate(zip(parts, names, strict=True)):
        curves.append(part)
        members.append(name)
        if k in bridges:
            curves.append(bridges[k])
            members.append(-1)
    return tuple(curves), tuple(members)


def _with_end(curve: Curve, point: Point) -> Curve | None:
    match curve:
        case Line():
            return replace(curve, end=point)
        case Bezier():
            return replace(curve, points=(*curve.points[:-1], point))
        case _:
            return None


def _with_start(curve: Curve, point: Point) -> Curve | None:
    match curve:
        case Line():
            return replace(curve, start=point)
        case Bezier():
            return replace(curve, points=(point, *curve.points[1:]))
        case _:
            return None


def _find_gaps(chains: list[Chain], look: float, tolerance: float) -> tuple[Gap, ...]:
    """Pairs of open ends within `look`, each end with its nearest other, nearest pairs first."""
    grid = _Grid(look)
    ends: list[tuple[Point, int]] = []
    for chain in chains:
        if not chain.closed:
            ends.append((chain.curves[0].start, chain.members[0]))
            ends.append((chain.curves[-1].end, chain.members[-1]))
    for name, (point, _) in enumerate(ends):
        grid.add(point, name)
    pairs = sorted(
        (away, name, other)
        for name, (point, _) in enumerate(ends)
        for away, other in grid.near(point)
        if name < other and away > tolerance
    )
    taken: set[int] = set()
    found = []
    for _, a, b in pairs:
        if a in taken or b in taken:
            continue
        taken |= {a, b}
        found.append(Gap(ends[a][0], ends[b][0], (ends[a][1], ends[b][1])))
    return tuple(found)
