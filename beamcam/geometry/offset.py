"""Closed chains moved outwards or inwards by the half width of a cut, many at once.

Lines move beside themselves, arcs change their radius. At a corner that opens, the lines are
prolonged until they meet (a mitre) or an arc about the corner joins them; at one that closes,
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

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.geometry.arrays import CurveTable, signed_areas
from beamcam.geometry.curves import Curve
from beamcam.geometry.flat_offset import flat_offset
from beamcam.geometry.plane import distance
from beamcam.geometry.polylines import polylines
from beamcam.geometry.raw_offset import MITRE_LIMIT, Ring, raw_offsets

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
    found: list[Offset | Vanished] = []
    for k, (chain, amount) in enumerate(zip(chains, amounts, strict=True)):
        if amount == 0.0:
            found.append(Offset((tuple(chain),), (float(areas[k]),), True))
        elif k in moved:
            found.append(moved[k])
        elif parts := flat_offset(tuple(chain), amount, tolerance):
            found.append(Offset(parts, tuple(signed_areas(parts).tolist()), False))
        else:
            found.append(Vanished(abs(float(areas[k])), amount))
    return found


def _right_ones(
    asked: Sequence[int],
    rings: Sequence[Ring | None],
    areas: NDArray[np.float64],
    rights: NDArray[np.float64],
    tolerance: float,
) -> dict[int, Offset]:
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
    areas: NDArray[np.float64],
    after: NDArray[np.float64],
    rings: Sequence[tuple[Curve, ...]],
    rights: NDArray[np.float64],
    tolerance: float,
) -> list[bool]:
    """Which moved rings are simple, run as before, and grew or shrank as they should.

    `areas` are those of the chains, `after` those of the rings.
    """
    grows = np.abs(after) > np.abs(areas)
    good: list[bool] = ((after * areas > 0.0) & (grows == (rights * areas > 0.0))).tolist()
    # A circle is simple; the others are looked at.
    asked = [k for k, ring in enumerate(rings) if good[k] and len(ring) > 1]
    for k, simple in zip(asked, _are_simple([rings[k] for k in asked], tolerance), strict=True):
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
    found: list[bool] = simple.tolist()
    return found
