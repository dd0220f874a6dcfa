"""Curves of a drawing joined to chains, end to end, in linear time.

Ends are numbered: 2 k is the start of curve k, 2 k + 1 its end, so that `end ^ 1` is the other end
of the same curve. Where just two ends meet they are partners, and a chain is found by going from
an end to the other one of its curve, to the partner of that, and so on.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from math import hypot

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from beamcam.geometry.arrays import ends_of
from beamcam.geometry.bezier import Bezier
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.near import near_pairs
from beamcam.geometry.plane import Point, distance

Floats = NDArray[np.float64]

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


def join_curves(
    curves: Sequence[Curve],
    tolerance: float,
    look: float | None = None,
    ends: Floats | None = None,
) -> Chains:
    """Chains of curves whose ends are no farther apart than `tolerance`, in the order given.

    Curves are turned round where needed. An end within the tolerance is moved onto its
    neighbour where a curve can be (lines and free curves), else a line bridges the rest. Where
    three ends or more meet, chains stop and a junction is reported. Open ends of chains nearer
    than `look` (10 times the tolerance if not given) are reported as gaps. Curves no larger
    than the tolerance are dropped: both their ends would be one. `ends` are those of the curves
    (n, 4), if they are known already.

    Raises ValueError if the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    if not curves:
        return Chains((), (), (), ())
    ends = ends_of(curves) if ends is None else ends
    away = np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1])
    closed = away <= SAME_POINT
    # A curve whose ends are far apart is not tiny; the others are looked at.
    tiny = np.zeros(len(curves), dtype=bool)
    for k in np.flatnonzero(away <= tolerance * (1 + SAME_POINT)).tolist():
        tiny[k] = _size(curves[k]) <= tolerance
    meetings = _meetings(ends.reshape(-1, 2), np.repeat(closed | tiny, 2), tolerance)
    junctions = tuple(
        Junction(_end_point(curves, crowd[0]), tuple(sorted({e // 2 for e in crowd})))
        for crowd in meetings.crowds
    )
    chains: list[Chain] = []
    used = tiny.tolist()
    rings = closed.tolist()
    for k in range(len(curves)):
        if used[k]:
            continue
        if rings[k]:
            used[k] = True
            chains.append(Chain((curves[k],), True, (k,)))
        else:
            chains.append(_walk(curves, k, meetings, used))
    gaps = _find_gaps(chains, 10 * tolerance if look is None else look, tolerance)
    return Chains(tuple(chains), junctions, gaps, tuple(np.flatnonzero(tiny).tolist()))


def _size(curve: Curve) -> float:
    x0, y0, x1, y1 = curve.bbox
    return hypot(x1 - x0, y1 - y0)


def _end_point(curves: Sequence[Curve], end: int) -> Point:
    return curves[end // 2].end if end % 2 else curves[end // 2].start


class _Meetings(Struct, frozen=True):
    """Which ends meet."""

    partner: list[int]  #: of each end the one that it meets, -1 for none
    apart: frozenset[int]  #: ends that have to be moved to their partner, both of each pair
    crowds: list[list[int]]  #: three ends or more that meet, by their first


def _meetings(points: Floats, left_out: NDArray[np.bool_], tolerance: float) -> _Meetings:
    """How the ends at `points` (n, 2) meet; those `left_out` meet none.

    Ends that are near a third one meet one another too.
    """
    asked = np.flatnonzero(~left_out)
    first, second = near_pairs(points[asked], tolerance)
    first, second = asked[first], asked[second]
    friends = np.bincount(np.concatenate((first, second)), minlength=len(points))
    alone = (friends[first] == 1) & (friends[second] == 1)
    a, b = first[alone], second[alone]
    partner = np.full(len(points), -1)
    partner[a], partner[b] = b, a
    # Ends of arcs are known here but for their last digits: `_joined` looks again.
    moved = np.hypot(*(points[a] - points[b]).T) > SAME_POINT / 2
    apart = frozenset(np.concatenate((a[moved], b[moved])).tolist())
    pairs = zip(first[~alone].tolist(), second[~alone].tolist(), strict=True)
    return _Meetings(partner.tolist(), apart, _crowds(pairs))


def _crowds(pairs: Iterator[tuple[int, int]]) -> list[list[int]]:
    """Groups of ends that hang together by pairs, each ascending, in the order of their first."""
    near: defaultdict[int, list[int]] = defaultdict(list)
    for a, b in pairs:
        near[a].append(b)
        near[b].append(a)
    found: list[list[int]] = []
    seen: set[int] = set()
    for end in sorted(near):
        if end in seen:
            continue
        crowd, waiting = [], [end]
        seen.add(end)
        while waiting:
            member = waiting.pop()
            crowd.append(member)
            fresh = [e for e in near[member] if e not in seen]
            seen.update(fresh)
            waiting += fresh
        found.append(sorted(crowd))
    return found


def _walk(curves: Sequence[Curve], first: int, meetings: _Meetings, used: list[bool]) -> Chain:
    """The chain through curve `first`, which keeps its direction."""
    partner = meetings.partner
    ends = list(_follow(2 * first, partner))
    ring = partner[ends[-1] ^ 1] == 2 * first
    if not ring and partner[2 * first] >= 0:
        back = list(_follow(partner[2 * first], partner))
        ends = [e ^ 1 for e in reversed(back)] + ends
    parts = []
    for e in ends:
        used[e // 2] = True
        parts.append(curves[e // 2].reversed() if e % 2 else curves[e // 2])
    names = [e // 2 for e in ends]
    joints = [k for k, e in enumerate(ends) if e ^ 1 in meetings.apart]
    if joints:
        parts, names = _joined(parts, names, joints)
    return Chain(tuple(parts), ring, tuple(names))


def _follow(end: int, partner: Sequence[int]) -> Iterator[int]:
    """The ends by which curves are entered, from `end` on, until the way stops or closes."""
    at = end
    while at >= 0:
        yield at
        at = partner[at ^ 1]
        if at == end:
            return


def _joined(
    parts: list[Curve], names: list[int], joints: Sequence[int]
) -> tuple[list[Curve], list[int]]:
    """The curves with their ends moved together, and lines where that cannot be.

    `joints` names the curves whose end has to be brought to the start of the following one.
    """
    count = len(parts)
    bridges: dict[int, Line] = {}
    for k in joints:
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
    return curves, members


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
    ends: list[tuple[Point, int]] = []
    for chain in chains:
        if not chain.closed:
            ends.append((chain.curves[0].start, chain.members[0]))
            ends.append((chain.curves[-1].end, chain.members[-1]))
    points = np.array([point for point, _ in ends], dtype=np.float64).reshape(-1, 2)
    first, second = near_pairs(points, look)
    away = np.hypot(*(points[first] - points[second]).T)
    apart = away > tolerance
    first, second, away = first[apart], second[apart], away[apart]
    order = np.lexsort((second, first, away))
    pairs = zip(first[order].tolist(), second[order].tolist(), strict=True)
    taken: set[int] = set()
    found = []
    for a, b in pairs:
        if a in taken or b in taken:
            continue
        taken |= {a, b}
        found.append(Gap(ends[a][0], ends[b][0], (ends[a][1], ends[b][1])))
    return tuple(found)
