"""Curves of a drawing joined to chains, end to end, in linear time.

Ends are numbered: 2 k is the start of link k, 2 k + 1 its end, so that `end ^ 1` is the other end
of the same link. Where just two ends meet they are partners, and a chain is found by going from
an end to the other one of its link, to the partner of that, and so on.

    curves --ends that are one point--> links --ends within the tolerance--> chains

Joining in two steps keeps contours of many short curves whole: within a tolerance above their
length every end would meet several.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import hypot

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.array_types import Floats
from beamcam.geometry.arrays import CurveTable, near_pairs
from beamcam.geometry.bezier import Bezier
from beamcam.geometry.curves import Curve, Line, join_boxes
from beamcam.geometry.junctions import Resolved, resolve
from beamcam.geometry.plane import Point, cross, distance, groups_of

#: Ends nearer than this are one point; nothing has to be moved to join them.
SAME_POINT = 1e-9

#: Ends that programs write for one point are as near as this: coordinates of three decimals.
WRITTEN_SAME = 1e-3

#: A gap as wide as the tolerance is within it, whatever the last digits of its ends.
SLACK = 1 + 1e-6

#: Ends that meet one another over more than so many tolerances are those of a hatch or a scale,
#: whose lines lie nearer to one another than the tolerance: they meet only where written alike.
WIDEST_PLACE = 2.0


class Chain(Struct, frozen=True, gc=False):
    """Curves that follow one another."""

    curves: tuple[Curve, ...]
    closed: bool
    members: tuple[int, ...]  #: which of the curves given each comes from; -1 for a bridge

    def reversed(self) -> "Chain":
        """The chain followed backwards."""
        curves = tuple([c.reversed() for c in reversed(self.curves)])
        return Chain(curves, self.closed, self.members[::-1])


class Junction(Struct, frozen=True):
    """A place where three ends or more meet: chains stop there, as the way on is not known."""

    point: Point
    members: tuple[int, ...]  #: the curves that end there, ascending
    in_ring: bool  #: whether more than one way leads from there back to it


class Gap(Struct, frozen=True):
    """Two ends of chains that are near but farther apart than the tolerance: not joined."""

    start: Point
    end: Point
    members: tuple[int, int]

    @property
    def width(self) -> float:
        return distance(self.start, self.end)


class Chains(Struct, frozen=True):
    """The result of joining: every curve is in exactly one chain, or dropped."""

    chains: tuple[Chain, ...]
    junctions: tuple[Junction, ...]
    gaps: tuple[Gap, ...]
    dropped: tuple[int, ...]  #: curves of chains no larger than the tolerance


def join_curves(curves: Sequence[Curve], tolerance: float, ends: Floats | None = None) -> Chains:
    """Chains of curves whose ends are no farther apart than `tolerance`, in the order given.

    Curves are turned round where needed. An end very near its neighbour is moved onto it where a
    curve can be (lines and free curves), else a line bridges the gap.

    Ends that are near a third one meet one another too, unless they meet one another over more than
    twice the tolerance. Where three ends or more meet, a chain that begins and ends there is
    closed, and chains that lead to nowhere leave the way on to the others; if more are left, all
    of them stop and a junction is reported. Open ends of chains nearer than 10 times
    the tolerance are reported as gaps. Chains no larger than the tolerance are dropped.
    `ends` are those of the curves (n, 4), if they are known already.

    Raises ValueError if the tolerance is not above 0.
    """
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    if not curves:
        return Chains((), (), (), ())
    ends = CurveTable(curves).ends if ends is None else ends
    same = min(tolerance, WRITTEN_SAME)
    away = np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1])
    point = np.zeros(len(curves), dtype=bool)
    for k in np.flatnonzero(away <= same).tolist():
        point[k] = _size((curves[k],)) <= same
    links = [Chain((curve,), False, (k,)) for k, curve in enumerate(curves)]
    closed = (away <= SAME_POINT) & ~point
    chains = [replace(links[k], closed=True) for k in np.flatnonzero(closed).tolist()]
    loose = np.flatnonzero(~closed & ~point)
    near = _meetings(ends[loose].reshape(-1, 2), same)
    linked = _linked([links[k] for k in loose.tolist()], near)
    chains += [link for link in linked if link.closed]
    whole, junctions = _joined_within([link for link in linked if not link.closed], tolerance)
    chains += whole
    chains.sort(key=lambda chain: min(m for m in chain.members if m >= 0))
    reach = tolerance * SLACK
    small = [
        distance(chain.curves[0].start, chain.curves[-1].start) <= reach
        and _size(chain.curves) <= reach
        for chain in chains
    ]
    kept = [chain for chain, is_small in zip(chains, small, strict=True) if not is_small]
    dropped = [c.members for c, is_small in zip(chains, small, strict=True) if is_small]
    lost = {m for members in dropped for m in members if m >= 0}
    lost.update(np.flatnonzero(point).tolist())
    return Chains(tuple(kept), junctions, _find_gaps(kept, tolerance), tuple(sorted(lost)))


def _size(curves: Iterable[Curve]) -> float:
    box = join_boxes([curve.bbox for curve in curves])
    return 0.0 if box is None else hypot(box[2] - box[0], box[3] - box[1])


def _joined_within(
    links: Sequence[Chain], tolerance: float
) -> tuple[list[Chain], tuple[Junction, ...]]:
    """Open links joined within the tolerance, and where more of them meet than go on."""
    if not links:
        return [], ()
    outer = CurveTable([curve for link in links for curve in (link.curves[0], link.curves[-1])])
    points = np.column_stack((outer.ends[0::2, :2], outer.ends[1::2, 2:])).reshape(-1, 2)
    # Of ends that meet one another over a long way only those that are written alike meet.
    near = _meetings(points, tolerance * SLACK)
    partner, moved, nodes = near.partner, set(near.apart), []
    for node in near.nodes:
        if hypot(*np.ptp(points[node], axis=0)) <= WIDEST_PLACE * tolerance * SLACK:
            nodes.append(node)
            continue
        own = _meetings(points[node], min(tolerance, WRITTEN_SAME))
        for k, other in enumerate(own.partner):
            partner[node[k]] = node[other] if other >= 0 else -1
        moved.update(node[k] for k in own.apart)
        nodes += [[node[k] for k in some] for some in own.nodes]
    near = _Meetings(partner, frozenset(moved), nodes)
    partner = near.partner

    def is_small(end: int) -> bool:
        walked = (curve for e in _follow(end, partner) for curve in links[e // 2].curves)
        return _size(walked) <= tolerance

    resolved = resolve(near.nodes, partner, is_small) if near.nodes else Resolved([], [])
    apart = near.apart.union(end for pair in resolved.joins for end in pair)
    chains = _linked(links, _Meetings(partner, apart, []))
    junctions = []
    for node, in_ring in resolved.left:
        members = {links[e // 2].members[-1 if e % 2 else 0] for e in node}
        curves = links[node[0] // 2].curves
        point = curves[-1].end if node[0] % 2 else curves[0].start
        junctions.append(Junction(point, tuple(sorted(members)), in_ring))
    return chains, tuple(junctions)


class _Meetings(Struct, frozen=True):
    """Which ends meet."""

    partner: list[int]  #: of each end the one that it meets, -1 for none
    apart: frozenset[int]  #: ends that have to be moved to their partner, both of each pair
    nodes: list[list[int]]  #: three ends or more that meet, by their first


def _meetings(points: Floats, tolerance: float) -> _Meetings:
    """Which ends at `points` (n, 2) meet.

    Ends that are near a third one meet one another too.
    """
    first, second = near_pairs(points, tolerance)
    friends = np.bincount(np.concatenate((first, second)), minlength=len(points))
    alone = (friends[first] == 1) & (friends[second] == 1)
    a, b = first[alone], second[alone]
    partner = np.full(len(points), -1)
    partner[a], partner[b] = b, a
    # Ends of arcs are known here but for their last digits: `_joined` looks again.
    moved = np.hypot(*(points[a] - points[b]).T) > SAME_POINT / 2
    apart = frozenset(np.concatenate((a[moved], b[moved])).tolist())
    pairs = zip(first[~alone].tolist(), second[~alone].tolist(), strict=True)
    nodes = sorted(map(sorted, groups_of(pairs)))
    return _Meetings(partner.tolist(), apart, nodes)


def _linked(links: Sequence[Chain], meetings: _Meetings) -> list[Chain]:
    """The chains that links make, in the order of their first ones."""
    used = [False] * len(links)
    return [_walk(links, k, meetings, used) for k in range(len(links)) if not used[k]]


def _walk(links: Sequence[Chain], first: int, meetings: _Meetings, used: list[bool]) -> Chain:
    """The chain through link `first`, which keeps its direction."""
    partner = meetings.partner
    ends = list(_follow(2 * first, partner))
    ring = partner[ends[-1] ^ 1] == 2 * first
    if not ring and partner[2 * first] >= 0:
        back = list(_follow(partner[2 * first], partner))
        ends = [e ^ 1 for e in reversed(back)] + ends
    parts: list[Curve] = []
    names: list[int] = []
    joints = []
    for e in ends:
        used[e // 2] = True
        link = links[e // 2].reversed() if e % 2 else links[e // 2]
        parts += link.curves
        names += link.members
        if e ^ 1 in meetings.apart:
            joints.append(len(parts) - 1)
    if joints:
        parts, names = joined(parts, names, joints)
    return Chain(tuple(parts), ring, tuple(names))


def _follow(end: int, partner: Sequence[int]) -> Iterator[int]:
    """The ends by which curves are entered, from `end` on, until the way stops or closes."""
    at = end
    while at >= 0:
        yield at
        at = partner[at ^ 1]
        if at == end:
            return


def _find_gaps(chains: list[Chain], tolerance: float) -> tuple[Gap, ...]:
    """Each open end with its nearest other within 10 times the tolerance, nearest pairs first."""
    ends: list[tuple[Point, int]] = []
    for chain in chains:
        if not chain.closed:
            ends.append((chain.curves[0].start, chain.members[0]))
            ends.append((chain.curves[-1].end, chain.members[-1]))
    points = np.array([point for point, _ in ends], dtype=np.float64).reshape(-1, 2)
    first, second = near_pairs(points, 10 * tolerance)
    away = np.hypot(*(points[first] - points[second]).T)
    apart = away > tolerance * SLACK
    first, second, away = first[apart], second[apart], away[apart]
    order = np.lexsort((second, first, away))
    pairs = zip(first[order].tolist(), second[order].tolist(), strict=True)
    taken: set[int] = set()
    gaps = []
    for a, b in pairs:
        if a in taken or b in taken:
            continue
        taken |= {a, b}
        gaps.append(Gap(ends[a][0], ends[b][0], (ends[a][1], ends[b][1])))
    return tuple(gaps)


#: An end is moved aside by no more than this, in mm, as the curve would lie elsewhere; an end of a
#: line no farther than a share of its length. Other gaps are bridged.
MOST_MOVED = 0.005
MOST_TURNED = 0.1

#: Lines whose directions differ by less, in radians, do not meet near their ends.
MIN_ANGLE = 0.1


def joined(
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
        corner = _corner(parts[k], parts[following])
        if corner is not None and following != k:
            parts[k] = replace(parts[k], end=corner)
            parts[following] = replace(parts[following], start=corner)
            continue
        moved_start = _with_end(parts[following].reversed(), a) if following != k else None
        moved_end = _with_end(parts[k], b)
        if moved_end is not None:
            parts[k] = moved_end
        elif moved_start is not None:
            parts[following] = moved_start.reversed()
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


def _corner(a: Curve, b: Curve) -> Point | None:
    """Where two lines meet that end near one another; None if that is not near their ends."""
    if not (isinstance(a, Line) and isinstance(b, Line)):
        return None
    gap = distance(a.end, b.start)
    if min(a.length, b.length) * MOST_TURNED < gap:
        return None
    u, v = a.tangent(0.0), b.tangent(0.0)
    if abs(cross(u, v)) < MIN_ANGLE:
        return None
    reach = cross((b.start[0] - a.end[0], b.start[1] - a.end[1]), v) / cross(u, v)
    point = (a.end[0] + reach * u[0], a.end[1] + reach * u[1])
    return point if max(abs(reach), distance(point, b.start)) <= gap * (1 + SAME_POINT) else None


def _with_end(curve: Curve, point: Point) -> Curve | None:
    """The curve with its end at a point; None if it would lie elsewhere."""
    match curve:
        case Line():
            off = (point[0] - curve.end[0], point[1] - curve.end[1])
            if hypot(*off) > MOST_TURNED * curve.length:
                return None
            aside = abs(cross(off, curve.tangent(0.0)))
            return replace(curve, end=point) if aside <= MOST_MOVED else None
        case Bezier() if distance(curve.end, point) <= MOST_MOVED:
            return replace(curve, points=(*curve.points[:-1], point))
        case _:
            return None
