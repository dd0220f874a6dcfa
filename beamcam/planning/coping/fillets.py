r"""Cuts of a flange that run along its web, in the root fillet beside it.

o ___________________     The torch is outside of the flange. A cut that comes no nearer to the
     ^  \    |            web than its surface goes through flange and fillet, as thick as they
     |   '-. |            are at its side towards the web, and behind them there is air. What is
  the cut   )| web        cut off takes its share of the fillet with it.

And holes and cut-outs of a web near to a flange: how near the torch comes, and why no nearer.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import dist, sqrt

from msgspec import Struct
from shapely import box

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Point
from beamcam.model.part import Contour, Feature
from beamcam.planning.coping import rules
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.cuts import CutChain, borders_of, chains_of
from beamcam.planning.coping.regions import Cut, Shape, WallRegion, taken
from beamcam.planning.coping.walls import EDGE, PlannedWall, Root

BESIDE = 1.0  #: mm that a path may turn beside a place where its contour does
STRAIGHT = 0.1  #: mm that a way through a whole root may be off its chord and be straight


class BesideWeb(Struct, frozen=True):
    """How a cut of a flange comes to a web otherwise than straight through its whole root."""

    gap: float  #: mm from its kerf to the web; 0 where it crosses that
    crosses: bool


def beside_web(points: Sequence[Point], wall: PlannedWall, half: float) -> BesideWeb | None:
    """How a path half a kerf off its contour comes to the web; None where it is clear of web and
    fillets, or goes straight through all of them."""
    root = root_of(wall)
    if root is None or root.stands is None:
        return None
    ys = [y for _, y in points]
    back, front = root.stands
    middle = (back + front) / 2
    if min(ys) < middle < max(ys):
        # Farther off the web the fillet is less than a pass through the root is deep anyway.
        near = root.radius / 2 - BESIDE
        ways = _within(points, max(back - near, EDGE), min(front + near, wall.width - EDGE))
        is_through = all(  # straight from side to side
            way[0][1] != way[-1][1] and all(
                dist((x, y), (_x_at(way[0], way[-1], y), y)) <= STRAIGHT for x, y in way
            )
            for way in ways
        )  # fmt: skip
        return None if is_through else BesideWeb(0.0, True)
    gap = back - max(ys) - half if max(ys) <= middle else min(ys) - half - front
    return BesideWeb(max(gap, 0.0), False) if gap < root.radius else None


def root_of(wall: PlannedWall) -> Root | None:
    """Where a web stands on a flange; None of a web itself."""
    return wall.roots[0] if wall.root_depth else None


def depth_beside(wall: PlannedWall, beside: BesideWeb) -> float:
    """How much steel such a cut goes through: flange and fillet, whose circle comes r away from the
    web to the flange; across the web the root as well."""
    root = root_of(wall)
    assert root is not None
    off = max(root.radius - beside.gap, 0.0)
    deep = wall.thickness + root.radius - sqrt(root.radius**2 - off**2)
    return max(deep, wall.root_depth) if beside.crosses else deep


def ways_beside(region: WallRegion) -> list[tuple[CutChain, BesideWeb]]:
    """The chains of a flange's contour that are not straight through its root."""
    wall = region.wall
    root = root_of(wall)
    if root is None or root.stands is None:
        return []
    chains = chains_of(region.shape, borders_of(wall, EDGE, wall.width - EDGE, -EDGE))
    beside = ((chain, beside_web(chain.points, wall, 0.0)) for chain in chains)
    return [(chain, one) for chain, one in beside if one is not None]


def _within(points: Sequence[Point], low: float, high: float) -> Iterator[list[Point]]:
    """The segments of a path between two y."""
    way: list[Point] = []
    for a, b in pairwise(points):
        if max(a[1], b[1]) < low or min(a[1], b[1]) > high:
            continue
        ends = [
            (x, y) if low <= y <= high else (_x_at(a, b, to), to)
            for x, y, to in ((x, y, min(max(y, low), high)) for x, y in (a, b))
        ]
        if way and way[-1] != ends[0]:
            yield way
            way = []
        way += ends if not way else ends[1:]
    if way:
        yield way


def _x_at(a: Point, b: Point, y: float) -> float:
    """x of a line through two places."""
    return a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1])


# --- openings of a web ---------------------------------------------------------------------------


def without_openings(
    web: WallRegion, features: Sequence[Feature], radius: float, chart: Chart
) -> tuple[WallRegion, list[Diagnostic]]:
    """A web without its openings near to a flange, and an error of each that is too near.

    `features` are those on the web, `radius` is that of the fillets. Openings that go on beyond an
    end or meet another cut there stay.
    """
    coper, width, shape, faults = chart.coper, web.wall.width, web.shape, list[Diagnostic]()
    row, widest = chart.row(web.wall.thickness), max(row.kerf for row in coper.rows)
    half = row.kerf / 2 if row else 0.0
    for feature in features:
        is_outer = isinstance(feature, Contour) and feature.kind != "inner"
        if is_outer or not isinstance(feature, Cut):
            continue
        gone: Shape = taken(feature)
        x0, y0, x1, y1 = gone.bounds
        for root in web.wall.roots:
            low = root.low == 0.0
            off = y0 if low else width - y1
            thick, high = root.thick, root.high - root.low  # to where the torch comes
            if off >= chart.depth(high + coper.root_over) + EDGE:
                continue
            band = (0.0, off + half + high) if low else (y0 - half - high, width)
            filled = web.shape.union(gone)
            if not filled.covers(box(x0 - widest, max(band[0], 0.0), x1 + widest, band[1])):
                continue
            shape, least = shape.union(gone), max(high, thick + radius) - half
            if off < least:
                what = "a cut-out" if isinstance(feature, Contour) else "a hole"
                how = f"that reaches {thick - max(off, 0.0):.1f} mm into" if off < thick else (
                    f"{off - thick:.1f} mm beside the inner surface of")  # fmt: skip
                faults.append(rules.ROOT.at(
                    feature.source, what=f"{what} {how} face {root.face}", x=f"{x0:.1f}",
                    face=web.wall.face,
                    expected=f"one {least:.1f} mm off the outside of face {root.face} at least, "
                    "where the torch over the web comes",
                ))  # fmt: skip
    return WallRegion(web.wall, shape, web.rounded), faults
