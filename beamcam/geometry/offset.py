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

import itertools
from collections.abc import Callable, Sequence
from math import degrees, hypot, sqrt
from typing import Any, TypeVar

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.geometry.array_types import Floats
from beamcam.geometry.arrays import CurveTable, signed_areas
from beamcam.geometry.conics import arc_by_points
from beamcam.geometry.curves import Arc, Curve, Line, signed_area
from beamcam.geometry.plane import Point, cross, distance, dot
from beamcam.geometry.polylines import points_at, polylines
from beamcam.geometry.raw_offset import MITRE_LIMIT, Ring, raw_offsets

# --- refit ----------------------------------------------------------------------------------------

# Lines and arcs found again in the corners of a polygon.


Corners = TypeVar("Corners", list[Point], Floats)

#: So many corners, at least, make an arc.
MIN_CORNERS = 5

#: No chord of an arc turns it by more than this: a square is not a circle.
MOST_SWEEP_DEG = 350.0


def refit_ring(points: Sequence[Point], tolerance: float) -> tuple[Line | Arc, ...]:
    """A closed chain of lines and arcs through some of the corners of a polygon, which no
    corner and no side's middle lies farther from than `tolerance` (and the sagitta of a chord).

    Greedy: from each corner the longest arc, or else the longest line. It starts at the corner
    with the sharpest turn, so that an arc is not cut in two where it needs not be.
    """
    count = len(points)
    start = max(range(count), key=lambda k: (_turn(points, k), -k))
    ring = [points[(start + k) % count] for k in range(count)] + [points[start]]
    curves: list[Line | Arc] = []
    at = 0
    while at < count:
        arc, reach = longest_arc(ring, at, MIN_CORNERS - 1, lambda run: _arc_over(run, tolerance))
        if arc is None:
            reach = longest_line(ring, at, lambda run: _is_straight(run, tolerance / 4))
            curves.append(Line(ring[at], ring[reach]))
        else:
            curves.append(arc)
        at = reach
    return tuple(curves)


def _turn(points: Sequence[Point], k: int) -> float:
    """1 - cosine of the turn at a corner."""
    a, b, c = points[k - 1], points[k], points[(k + 1) % len(points)]
    u, v = (b[0] - a[0], b[1] - a[1]), (c[0] - b[0], c[1] - b[1])
    size = hypot(*u) * hypot(*v)
    return 1.0 - dot(u, v) / size if size else 0.0


def longest_arc(
    points: Corners, at: int, least: int, arc_over: Callable[[Corners], Arc | None]
) -> tuple[Arc | None, int]:
    """The arc from corner `at` over the most corners; doubles its reach, then halves the step.

    It goes over `least` chords or more. Without one None, and `at`.
    """
    best: Arc | None = None
    reach, step, growing = at, least, True
    while step >= 1:
        wished = reach + step
        arc = arc_over(points[at : wished + 1]) if wished < len(points) else None
        if arc is not None:
            best, reach = arc, wished
            step = step * 2 if growing else step
        elif best is None:
            break
        else:
            growing = False
            step //= 2
    return best, reach


def longest_line(points: Corners, at: int, is_straight: Callable[[Corners], bool]) -> int:
    """The last corner that a line from corner `at` may end at."""
    reach = at + 1
    while reach + 1 < len(points) and is_straight(points[at : reach + 2]):
        reach += 1
    return reach


def _arc_over(points: list[Point], tolerance: float) -> Arc | None:
    arc = arc_by_points(points[0], points[len(points) // 2], points[-1])
    if arc is None or abs(arc.sweep_deg) > MOST_SWEEP_DEG:
        return None
    centre, side = arc.centre, 1.0 if arc.sweep_deg > 0 else -1.0
    for p, q in itertools.pairwise(points):
        middle = ((p[0] + q[0]) / 2, (p[1] + q[1]) / 2)
        if (
            abs(distance(q, centre) - arc.radius) > tolerance
            or arc.radius - distance(middle, centre) > 4 * tolerance
        ):
            return None
        # Corners follow one another round the centre, never back.
        from_centre = (p[0] - centre[0], p[1] - centre[1])
        if side * cross(from_centre, (q[0] - p[0], q[1] - p[1])) <= 0.0:
            return None
    return arc


def _is_straight(points: list[Point], tolerance: float) -> bool:
    a, b = points[0], points[-1]
    chord = (b[0] - a[0], b[1] - a[1])
    size = hypot(*chord)
    return size > 0.0 and all(
        abs(cross(chord, (p[0] - a[0], p[1] - a[1]))) <= tolerance * size
        and dot(chord, (p[0] - a[0], p[1] - a[1])) >= 0.0
        for p in points
    )


# --- flat offset ----------------------------------------------------------------------------------

# Closed chains moved outwards or inwards as polygons, and their arcs found again.
#
# It replaces the exact form where parts of a moved chain run into each other.


def flat_offset(
    curves: tuple[Curve, ...], amount: float, tolerance: float
) -> tuple[tuple[Curve, ...], ...]:
    """The rings of a chain moved by `amount` mm, outwards if above 0; none if it vanishes.

    They are lines and arcs within `tolerance`, and run as the chain does, holes the other way.
    Corners that open are rounded: a mitre would close places where there is room.
    """

    ring = np.concatenate([_flat(curve, tolerance / 8) for curve in curves])
    quarter = max(8, int(90 / max(1.0, degrees(2 * sqrt(tolerance / 4 / abs(amount))))))
    moved = _moved(ring, amount, quarter, tolerance)
    parts = [p for p in getattr(moved, "geoms", [moved]) if p.area > tolerance * tolerance]
    turned = signed_area(curves) < 0
    chains = []
    for part in parts:
        for place, loop in enumerate((part.exterior, *part.interiors)):
            points = [(float(x), float(y)) for x, y in loop.coords[:-1]]
            fitted = refit_ring(points, tolerance / 4)
            backwards = (signed_area(fitted) < 0) != (turned != (place > 0))
            chains.append(tuple(c.reversed() for c in reversed(fitted)) if backwards else fitted)
    return tuple(chains)


def _moved(ring: NDArray[np.float64], amount: float, quarter: int, tolerance: float) -> Any:
    """The inside of a ring moved by `amount` mm, with so many chords to a quarter of a circle.

    In a corner that closes, made of sides much shorter than the amount, GEOS leaves out where the
    long sides beside them meet, and may be off by a sixth of the amount. Then every side is moved
    by itself.
    """
    import shapely

    inside = shapely.make_valid(shapely.Polygon(ring))
    moved = inside.buffer(amount, quad_segs=quarter)
    edge = shapely.linearrings(ring)
    shapely.prepare(edge)
    places = shapely.get_coordinates(shapely.segmentize(moved.boundary, abs(amount) / 4))
    if shapely.dwithin(edge, shapely.points(places), abs(amount) + tolerance).all():
        return moved
    corners = shapely.get_coordinates(edge)
    sides = shapely.linestrings(np.stack((corners[:-1], corners[1:]), axis=1))
    band = shapely.union_all(shapely.buffer(sides, abs(amount), quad_segs=quarter))
    whole = inside.buffer(0.0)  # without lines
    return whole.union(band) if amount > 0.0 else whole.difference(band)


def _flat(curve: Curve, tolerance: float) -> NDArray[np.float64]:
    """Points of a curve without its end; chords within `tolerance`, measured by doubling."""
    count = 1
    if not isinstance(curve, Line):
        count = 8
        while count < 4096:
            fine = points_at(curve, np.linspace(0.0, 1.0, 2 * count + 1))
            sag = fine[1::2] - (fine[:-1:2] + fine[2::2]) / 2
            if np.max(np.hypot(sag[:, 0], sag[:, 1])) <= tolerance:
                break
            count *= 2
    return points_at(curve, np.linspace(0.0, 1.0, count + 1))[:-1]


#: Distance from the original within which the flattened form replaces the exact one.
DEFAULT_TOLERANCE = 0.005

#: Rings are looked at as polygons so near to them, as a share of the tolerance: two stretches
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

    def __str__(self) -> str:
        return f"a contour of {self.area:.3f} mm2 vanishes when moved in by {-self.amount:g}"


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
    asked: Sequence[int], rings: Sequence[Ring | None], areas: NDArray[np.float64],
    rights: NDArray[np.float64], tolerance: float,
) -> dict[int, Offset]:  # fmt: skip
    """The rings that are right, by the chains (of all `areas`) that were `asked` for."""
    made = [(k, ring) for k, ring in zip(asked, rings, strict=True) if ring is not None]
    which, candidates = [k for k, _ in made], [ring for _, ring in made]
    after = signed_areas(candidates)
    right = _are_right(areas[which], after, candidates, rights[which], tolerance)
    return {
        k: Offset((ring,), (area,), True)
        for (k, ring), area, is_right in zip(made, after.tolist(), right, strict=True)
        if is_right
    }


def _are_right(
    areas: NDArray[np.float64], after: NDArray[np.float64], rings: Sequence[tuple[Curve, ...]],
    rights: NDArray[np.float64], tolerance: float,
) -> list[bool]:  # fmt: skip
    """Which moved rings are simple, run as before, and grew or shrank as they should.

    `areas` are those of the chains, `after` those of the rings.
    """
    grows = np.abs(after) > np.abs(areas)
    good: list[bool] = ((after * areas > 0.0) & (grows == (rights * areas > 0.0))).tolist()
    # A circle is simple; the others are looked at.
    which = [k for k, ring in enumerate(rings) if good[k] and len(ring) > 1]
    for k, simple in zip(which, _are_simple([rings[k] for k in which], tolerance), strict=True):
        good[k] = simple
    return good


def _are_simple(rings: Sequence[tuple[Curve, ...]], tolerance: float) -> list[bool]:
    """Which closed chains do not cross or touch themselves."""
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
    flags: list[bool] = simple.tolist()
    return flags
