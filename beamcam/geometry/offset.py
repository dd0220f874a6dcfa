"""Closed chains moved outwards or inwards by the half width of a cut, many at once.

Lines move beside themselves, arcs change their radius. At a corner that opens, the lines are
extended until they meet (a mitre) or an arc about the corner joins them; at one that closes,
both curves are cut where they meet. A ring that comes out so is right if it does not cross itself:

    All places beside the chain (with every corner swept round) wind about the points that the
    moved shape covers at least once, and about no others (Chen and McMains, "Polygon offsetting
    by computing winding numbers", 2005). Cutting at a corner that closes takes away a loop that
    runs backwards, and a mitre adds to what is covered. So a simple ring that is left holds all
    that is covered, and being beside the chain itself, it is the edge of it: none of its points
    is nearer to the chain than it shall be.

Where a ring crosses itself, as a mitre may make it do where two corners are near one another, all
its corners are rounded. Where it still crosses itself, or a side or an arc would have to run
backwards, the chain is moved as a polygon (`flat_offset`).

Shapely moves polygons only: arcs would come out as chords, which a controller runs through in
jerks. So it is left to the cases that cannot be exact, and nothing is taken from here that crosses
itself. tests/property/test_offset_laws.py measures the distance of every place of a moved ring and
compares the covered area with shapely's.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain as chained
from math import hypot, sqrt

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.arrays import CurveTable, arc_ends, signed_areas, unit_vectors
from beamcam.geometry.conics import arc_between, direction_deg
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.flat_offset import flat_offset
from beamcam.geometry.plane import Point, cross, distance, dot
from beamcam.geometry.polylines import polylines

Ring = tuple[Line | Arc, ...]

#: Corners sharper than this are rounded; their mitre would stand out by more than 2.5 times
#: the offset.
MITRE_LIMIT = 2.5
DEFAULT_TOLERANCE = 0.005  #: mm that the flattened form may be off where it replaces the exact one
#: Rings are looked at as polygons so near to them, as a share of the tolerance: two parts
#: that cross unseen lie too near to the chain by twice that at most.
LOOK_SHARE = 1 / 20


class Offset(Struct, frozen=True):
    """The moved chain; more than one if a narrow place closed."""

    chains: tuple[tuple[Curve, ...], ...]
    areas: tuple[float, ...]  #: of each, mm2, above 0 if it runs counter-clockwise
    exact: bool  #: False where arcs were found again in a flattened form


class Vanished(Struct, frozen=True):
    """Nothing is left of a chain: it is narrower than twice the offset."""

    area: float  #: of the chain that was
    amount: float


def offset_chains(
    chains: Sequence[Sequence[Curve]],
    amounts: Sequence[float],
    tolerance: float = DEFAULT_TOLERANCE,
    mitre_limit: float = MITRE_LIMIT,
) -> list[Offset | Vanished]:
    """Closed chains, each moved by its amount in mm, outwards if above 0; their directions stay.

    Outer contours take +kerf / 2, holes -kerf / 2, by their depth, not by how they are drawn.
    Lines and arcs stay what they are. Chains with other curves, and those whose parts run into
    each other, come back as lines and arcs within `tolerance`. Mitres stand out by no more than
    `mitre_limit` times the amount; with 0 every corner that opens is rounded.

    Raises ValueError for a chain that is not closed or has no area.
    """
    for chain in chains:
        if not chain or distance(chain[-1].end, chain[0].start) > tolerance:
            raise ValueError("only a closed chain can be moved outwards or inwards")
    table = CurveTable([curve for chain in chains for curve in chain])
    areas = signed_areas(chains, table)
    if not areas.all():
        raise ValueError("a chain without area has no outside")
    # On a ring that runs counter-clockwise the outside is on the right.
    rights = np.where(areas > 0, 1.0, -1.0) * np.array(amounts, dtype=np.float64)
    moved: dict[int, Offset] = {}
    waiting = list(range(len(chains)))
    for limit in dict.fromkeys((mitre_limit, 0.0)):
        some = [chains[k] for k in waiting]
        if len(some) < len(chains):
            table = CurveTable([curve for chain in some for curve in chain])
        rings = raw_offsets(some, rights[waiting], table, limit)
        moved |= _right_ones(waiting, rings, areas, rights, tolerance)
        waiting = [k for k in waiting if k not in moved]
    offsets: list[Offset | Vanished] = []
    for k, (chain, amount) in enumerate(zip(chains, amounts, strict=True)):
        if amount == 0.0:
            offsets.append(Offset((tuple(chain),), (float(areas[k]),), True))
        elif k in moved:
            offsets.append(moved[k])
        elif parts := flat_offset(tuple(chain), amount, tolerance):
            offsets.append(Offset(parts, tuple(signed_areas(parts).tolist()), False))
        else:
            offsets.append(Vanished(abs(float(areas[k])), amount))
    return offsets


def _right_ones(
    numbers: Sequence[int], rings: Sequence[Ring | None], areas: NDArray[np.float64],
    rights: NDArray[np.float64], tolerance: float,
) -> dict[int, Offset]:  # fmt: skip
    """The rings that are right, by the `numbers` of their chains among all: they are simple, run
    as the chains do, and grew or shrank as they should."""
    made = [(k, ring) for k, ring in zip(numbers, rings, strict=True) if ring is not None]
    which, candidates = [k for k, _ in made], [ring for _, ring in made]
    before, after = areas[which], signed_areas(candidates)
    grows = np.abs(after) > np.abs(before)
    right = ((after * before > 0.0) & (grows == (rights[which] * before > 0.0))).tolist()
    # A circle is simple; the others are looked at.
    looked = [k for k, ring in enumerate(candidates) if right[k] and len(ring) > 1]
    simple = _are_simple([candidates[k] for k in looked], tolerance)
    for k, is_simple in zip(looked, simple, strict=True):
        right[k] = is_simple
    return {
        k: Offset((ring,), (area,), True)
        for (k, ring), area, is_right in zip(made, after.tolist(), right, strict=True)
        if is_right
    }


def _are_simple(rings: Sequence[tuple[Curve, ...]], tolerance: float) -> list[bool]:
    import shapely

    if not rings:
        return []
    drawn = polylines([curve for ring in rings for curve in ring], tolerance * LOOK_SHARE)
    # Neighbours share a point, which is taken from the one that starts there.
    kept = np.ones(len(drawn.points), dtype=bool)
    kept[drawn.begins[1:] - 1] = False
    ring_of = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    owner = np.repeat(ring_of, np.diff(drawn.begins))[kept]
    simple = np.bincount(owner, minlength=len(rings)) >= 3
    of_simple = simple[owner]
    _, owner = np.unique(owner[of_simple], return_inverse=True)
    polygons = shapely.polygons(shapely.linearrings(drawn.points[kept][of_simple], indices=owner))
    simple[simple] = shapely.is_valid(polygons)
    return [bool(one) for one in simple]


# --- moved and joined -----------------------------------------------------------------------------

# Lines and arcs moved to their right, cut and joined at their corners: all chains together, in
# arrays. Only where an arc is cut at a corner that closes are both curves looked at by themselves.


BEYOND = 1e-9  #: mm beyond its end that a line may reach by the last digits


def meeting(a: Line | Arc, b: Line | Arc, corner: Point) -> Point | None:
    """Where two curves meet, nearest to the corner that both are cut at."""
    points = [p for p in intersections(a, b) if between(a, a.start, p) and between(b, p, b.end)]
    return min(points, key=lambda p: distance(p, corner), default=None)


def intersections(a: Line | Arc, b: Line | Arc) -> list[Point]:
    """Points where the whole lines or circles of two curves meet."""
    if isinstance(a, Line) and isinstance(b, Line):
        (ux, uy), (vx, vy) = a.tangent(0.0), b.tangent(0.0)
        det = cross((ux, uy), (vx, vy))
        if abs(det) < 1e-12:
            return []
        s = cross((b.start[0] - a.start[0], b.start[1] - a.start[1]), (vx, vy)) / det
        return [(a.start[0] + s * ux, a.start[1] + s * uy)]
    if isinstance(a, Arc) and isinstance(b, Line):
        a, b = b, a
    if isinstance(a, Line) and isinstance(b, Arc):
        ux, uy = a.tangent(0.0)
        to = (b.centre[0] - a.start[0], b.centre[1] - a.start[1])
        foot, away = dot((ux, uy), to), cross((ux, uy), to)
        if abs(away) > b.radius:
            return []
        half = sqrt(b.radius**2 - away**2)
        return [(a.start[0] + s * ux, a.start[1] + s * uy) for s in (foot - half, foot + half)]
    assert isinstance(a, Arc)
    assert isinstance(b, Arc)
    d = (b.centre[0] - a.centre[0], b.centre[1] - a.centre[1])
    gap = hypot(*d)
    if gap < 1e-12 or gap > a.radius + b.radius or gap < abs(a.radius - b.radius):
        return []
    along = (gap * gap + a.radius**2 - b.radius**2) / (2 * gap)
    height = sqrt(max(0.0, a.radius**2 - along**2))
    ux, uy = d[0] / gap, d[1] / gap
    x, y = a.centre[0] + along * ux, a.centre[1] + along * uy
    return [(x - h * uy, y + h * ux) for h in (height, -height)]


def between(part: Line | Arc, start: Point, end: Point) -> Line | Arc | None:
    """The stretch of a line or circle between two of its points.

    None if it would run back, or reach beyond either end: cutting shortens.
    """
    if part.start == start and part.end == end:
        return part
    if isinstance(part, Line):
        ahead = part.tangent(0.0)
        first, last, length = (
            dot((p[0] - part.start[0], p[1] - part.start[1]), ahead) for p in (start, end, part.end)
        )
        is_on = first >= -BEYOND and last <= length + BEYOND
        return Line(start, end) if is_on and first < last else None
    sign = 1.0 if part.sweep_deg > 0 else -1.0
    angles = [direction_deg((p[0] - part.centre[0], p[1] - part.centre[1])) for p in (start, end)]
    sweep = (angles[1] - angles[0]) * sign % 360.0
    # What sweeps further has turned inside out.
    if sweep > abs(part.sweep_deg) + 1e-6 or sweep == 0.0:
        return None
    return Arc(part.centre, part.radius, angles[0], sign * sweep)


#: Moved neighbours whose ends are nearer than this (mm for a move of 1 mm, no controller tells so
#: little) follow one another: coordinates rounded to 1e-6 make such corners of smooth joints.
SMOOTH = 1e-5
GONE = 1e-9  #: share of its radius below which an arc is gone
PARALLEL = 1e-12  #: below this the directions of two lines are one


@dataclass(slots=True)
class _Moved:
    """The curves of all chains, moved but not yet cut, one a row."""

    is_line: Flags
    bad: Flags  #: neither line nor arc, or nothing is left of it
    ends: Floats  #: (n, 4); cut at corners they change
    tangents: Floats  #: (n, 4) at start and end
    arcs: Floats  #: (n, 5) centre, radius, start and sweep in degrees, of the arcs


def raw_offsets(
    chains: Sequence[Sequence[Curve]],
    rights: Floats,
    table: CurveTable,
    mitre_limit: float = MITRE_LIMIT,
) -> list[Ring | None]:
    """Each chain moved to its right by so much (n,), to its left if below 0.

    `table` holds the curves of all chains. Mitres stand out by no more than `mitre_limit` times
    the move; corners that are sharper get arcs, with 0 all of them.
    None where that cannot be: for a chain with other curves than lines and arcs, where an arc
    would vanish, and where two curves do not meet or would run backwards. The rings may cross
    themselves.
    """
    sizes = np.array([len(chain) for chain in chains], dtype=np.int64)
    begins = np.cumsum(sizes) - sizes
    chain_of = np.repeat(np.arange(len(chains)), sizes)
    right = rights[chain_of]
    following = np.arange(len(table.curves)) + 1
    following[begins + sizes - 1] = begins
    moved, corners = _beside(table, right)
    lonely = (sizes == 1)[chain_of]
    moved.bad |= lonely & (np.abs(moved.arcs[:, 4]) != 360.0)
    step = moved.ends[following, :2] - moved.ends[:, 2:]
    apart = np.hypot(step[:, 0], step[:, 1]) > SMOOTH * (1 + np.abs(right))
    smooth = np.flatnonzero(~apart & moved.is_line[following])
    moved.ends[following[smooth], :2] = moved.ends[smooth, 2:]
    joints, pieces = _cornered(moved, corners, following, right, apart & ~lonely, mitre_limit)
    failed = np.zeros(len(chains), dtype=bool)
    failed[chain_of[moved.bad]] = True
    records = list(map(_record, moved.is_line.tolist(), moved.ends.tolist(), moved.arcs.tolist()))
    for k, piece in pieces.items():
        records[k] = piece
    joined = [(one, joints[k]) if k in joints else (one,) for k, one in enumerate(records)]
    bounds = zip(begins.tolist(), (begins + sizes).tolist(), failed.tolist(), strict=True)
    return [
        None if has_failed else tuple(chained.from_iterable(joined[begin:end]))
        for begin, end, has_failed in bounds
    ]


def _beside(table: CurveTable, right: Floats) -> tuple[_Moved, Floats]:
    """The curves beside themselves, and the corners (n, 2) in which they ended."""
    count = len(table.curves)
    lines, arcs = table.where(Line), table.where(Arc)
    is_line, bad = np.zeros(count, dtype=bool), np.ones(count, dtype=bool)
    ends, tangents = np.zeros((count, 4)), np.zeros((count, 4))
    corners, all_arcs = np.zeros((count, 2)), np.zeros((count, 5))
    is_line[lines] = True
    before = table.lines
    step = before[:, 2:] - before[:, :2]
    length = np.hypot(step[:, 0], step[:, 1])
    unit = step / np.where(length > 0.0, length, 1.0)[:, None]
    aside = right[lines, None] * np.column_stack((unit[:, 1], -unit[:, 0]))
    ends[lines] = before + np.hstack((aside, aside))
    tangents[lines] = np.hstack((unit, unit))
    corners[lines] = before[:, 2:]
    bad[lines] = length == 0.0
    rows = table.arcs.copy()
    turn = np.where(rows[:, 4] > 0, 1.0, -1.0)
    radius = rows[:, 2] + turn * right[arcs]
    corners[arcs] = arc_ends(rows)[:, 2:]
    bad[arcs] = radius <= GONE * rows[:, 2]
    rows[:, 2] = radius
    all_arcs[arcs] = rows
    ends[arcs] = arc_ends(rows)
    for place, angle in ((0, rows[:, 3]), (2, rows[:, 3] + rows[:, 4])):
        out = unit_vectors(angle)
        tangents[arcs, place : place + 2] = turn[:, None] * np.column_stack((-out[:, 1], out[:, 0]))
    return _Moved(is_line, bad, ends, tangents, all_arcs), corners


def _cornered(
    moved: _Moved, corners: Floats, following: Counts, right: Floats, apart: Flags,
    mitre_limit: float,
) -> tuple[dict[int, Arc], dict[int, Line | Arc]]:  # fmt: skip
    """Trim or extend the moved curves at corners (`apart`); mark those that cannot meet as bad.

    Gives the arcs about corners that open, by the curve before them, and the arcs that were cut.
    """
    k = np.flatnonzero(apart & ~moved.bad & ~moved.bad[following])
    n = following[k]
    a, b = moved.tangents[k, 2:], moved.tangents[n, :2]
    turn = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    along = np.sum(a * b, axis=1)
    opens = (turn * right[k] > 0) | ((turn == 0) & (along < 0))
    straight = moved.is_line[k] & moved.is_line[n]
    # The mitre of two lines stands out by 1 / cos(turn / 2) of the move.
    blunt = (1 + along) * mitre_limit**2 >= 2
    before = moved.ends.copy()
    joints: dict[int, Arc] = {}
    for i, j in zip(*(v[opens & ~(straight & blunt)].tolist() for v in (k, n)), strict=True):
        (x0, y0), (x1, y1), (x, y) = (
            p.tolist() for p in (before[i, 2:], before[j, :2], corners[i])
        )
        joints[i] = arc_between((x0, y0), (x1, y1), (x, y), float(right[i]))
    meet = straight & (~opens | blunt)
    i, j = k[meet], n[meet]
    gap = before[j, :2] - before[i, :2]
    parallel = np.abs(turn[meet]) < PARALLEL
    reach = (gap[:, 0] * b[meet, 1] - gap[:, 1] * b[meet, 0]) / np.where(parallel, 1.0, turn[meet])
    points = before[i, :2] + reach[:, None] * a[meet]
    # At a corner that closes both have to reach the point.
    rest = np.sum((before[j, 2:] - points) * b[meet], axis=1)
    moved.bad[i[parallel | (~opens[meet] & ((reach <= 0.0) | (rest <= 0.0)))]] = True
    moved.ends[i, 2:] = points
    moved.ends[j, :2] = points
    closing = zip(*(v[~straight & ~opens].tolist() for v in (k, n)), strict=True)
    pieces = _cut_arcs(moved, before, corners, list(closing))
    # What was cut at both ends may have turned round.
    run = moved.ends[:, 2:] - moved.ends[:, :2]
    moved.bad |= moved.is_line & (np.sum(run * moved.tangents[:, :2], axis=1) <= 0.0)
    return joints, pieces


def _cut_arcs(
    moved: _Moved, before: Floats, corners: Floats, closing: Sequence[tuple[int, int]]
) -> dict[int, Line | Arc]:
    """The arcs that meet a neighbour at a corner that closes, cut there."""
    touched: set[int] = set()
    for i, j in closing:
        a, b = (
            _record(moved.is_line[k], before[k].tolist(), moved.arcs[k].tolist()) for k in (i, j)
        )
        x, y = corners[i].tolist()
        point = meeting(a, b, (x, y))
        if point is None:
            moved.bad[i] = True
            continue
        moved.ends[i, 2:] = point
        moved.ends[j, :2] = point
        touched |= {i, j}
    cut: dict[int, Line | Arc] = {}
    for k in sorted(touched):
        if not moved.is_line[k]:
            x0, y0, x1, y1 = moved.ends[k].tolist()
            whole = _record(False, before[k].tolist(), moved.arcs[k].tolist())
            piece = between(whole, (x0, y0), (x1, y1))
            if piece is None:
                moved.bad[k] = True
            else:
                cut[k] = piece
    return cut


def _record(is_line: bool, ends: Sequence[float], arc: Sequence[float]) -> Line | Arc:
    if is_line:
        x0, y0, x1, y1 = ends
        return Line((x0, y0), (x1, y1))
    x, y, radius, start_deg, sweep_deg = arc
    return Arc((x, y), radius, start_deg, sweep_deg)
