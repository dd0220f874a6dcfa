"""Lines and arcs of closed chains moved to their right, cut and joined at their corners.

All chains are worked together in arrays. Only where an arc is cut at a corner that closes are the
two curves looked at by themselves.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from math import hypot, sqrt

import numpy as np

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.arrays import CurveTable, arc_ends, unit_vectors
from beamcam.geometry.conics import arc_between, direction_deg
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point, cross, distance, dot

# --- corners --------------------------------------------------------------------------------------

# Intersections of lines and circles, and curves trimmed there.


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


Ring = tuple[Line | Arc, ...]

#: Corners sharper than this are rounded; their mitre would stand out by more than 2.5 times
#: the offset.
MITRE_LIMIT = 2.5

#: Moved neighbours whose ends are nearer than this (mm for a move of 1 mm, no controller tells so
#: little) follow one another: coordinates rounded to 1e-6 make such corners of smooth joints.
SMOOTH = 1e-5

#: An arc whose radius shrinks to less than this share is gone.
GONE = 1e-9

#: Below this the directions of two lines are one.
PARALLEL = 1e-12


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
    records = _records(moved)
    for k, piece in pieces.items():
        records[k] = piece
    joined = [(one, joints[k]) if k in joints else (one,) for k, one in enumerate(records)]
    bounds = zip(begins.tolist(), (begins + sizes).tolist(), failed.tolist(), strict=True)
    return [
        None if has_failed else tuple(chain.from_iterable(joined[begin:end]))
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
    joints = {
        i: _joint(before[i], before[j], corners[i], right[i])
        for i, j in zip(*(v[opens & ~(straight & blunt)].tolist() for v in (k, n)), strict=True)
    }
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


def _joint(before: Floats, after: Floats, corner: Floats, right: float) -> Arc:
    """The arc about a corner from the end of one curve to the start of the next."""
    (x0, y0), (x1, y1), (x, y) = before[2:].tolist(), after[:2].tolist(), corner.tolist()
    return arc_between((x0, y0), (x1, y1), (x, y), float(right))


def _cut_arcs(
    moved: _Moved, before: Floats, corners: Floats, closing: Sequence[tuple[int, int]]
) -> dict[int, Line | Arc]:
    """The arcs that meet a neighbour at a corner that closes, cut there."""
    touched: set[int] = set()
    for i, j in closing:
        a, b = (_record(moved.is_line[k], before[k], moved.arcs[k]) for k in (i, j))
        x, y = corners[i].tolist()
        point = meeting(a, b, (x, y))
        if point is None:
            moved.bad[i] = True
            continue
        moved.ends[i, 2:] = point
        moved.ends[j, :2] = point
        touched |= {i, j}
    found: dict[int, Line | Arc] = {}
    for k in sorted(touched):
        if not moved.is_line[k]:
            x0, y0, x1, y1 = moved.ends[k].tolist()
            whole = _record(False, before[k], moved.arcs[k])
            piece = between(whole, (x0, y0), (x1, y1))
            if piece is None:
                moved.bad[k] = True
            else:
                found[k] = piece
    return found


def _record(is_line: bool, ends: Floats, arc: Floats) -> Line | Arc:
    if is_line:
        x0, y0, x1, y1 = ends.tolist()
        return Line((x0, y0), (x1, y1))
    x, y, radius, start_deg, sweep_deg = arc.tolist()
    return Arc((x, y), radius, start_deg, sweep_deg)


def _records(moved: _Moved) -> list[Line | Arc]:
    return [
        Line((x0, y0), (x1, y1)) if is_line else Arc((x, y), radius, start_deg, sweep_deg)
        for is_line, (x0, y0, x1, y1), (x, y, radius, start_deg, sweep_deg) in zip(
            moved.is_line.tolist(), moved.ends.tolist(), moved.arcs.tolist(), strict=True
        )
    ]
