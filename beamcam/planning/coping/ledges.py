"""Holes of a web right under a flange that stays, at its square end: weld access holes.

________ o        The torch over the web comes no nearer to the flange than `near`, and a pass
####|    |        through the root cuts as deep as its row. What is left there is a ledge (####);
    '--. | hole   it goes on to the end of the flange, where the root is cut with it.
web    |
"""

from collections.abc import Iterator, Mapping

from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.machine.coper import Coper
from beamcam.model.part import Face
from beamcam.planning.coping import rules
from beamcam.planning.coping.regions import OUTLINE_NOISE, Region, Shape
from beamcam.planning.coping.roots import crossings
from beamcam.planning.coping.walls import EDGE, Root

FAR = 1e5


def with_ledges(
    regions: Mapping[Face, Region], depth: float, kerf: float, coper: Coper, source: Source
) -> tuple[dict[Face, Region], list[Diagnostic]]:
    """Regions whose web keeps the ledges of such holes, and a warning of each.

    `depth` is that to which a pass through a root cuts, `kerf` that of a cut over the web.
    """
    web = regions["v"]
    said: list[Diagnostic] = []
    for root in web.wall.roots:
        flange = regions[root.face]
        (behind,) = flange.wall.roots
        band = max(EDGE, behind.low), min(flange.wall.width - EDGE, behind.high)
        on_flange, _ = crossings(flange, band, coper)
        for one in on_flange:
            if not one.square or web.wall.skew[one.right] is not None:
                continue
            for ledge, mm in _ledge(web, root, one.x, one.right, depth, kerf):
                web = replace(web, shape=web.shape.union(ledge))
                said.append(
                    rules.LEDGE.at(source, x=f"{one.x:g}", face=root.face, found=f"{mm:.1f}")
                )
    return {**regions, "v": web}, said


def _ledge(
    web: Region, root: Root, x: float, right: bool, depth: float, kerf: float
) -> Iterator[tuple[Shape, float]]:
    """What a web keeps at a root up to the end of its flange at x, and how high; nothing where the
    web ends there too, where it has no hole, or one that is all within reach of none."""
    from shapely import LineString, box

    wide, low = web.wall.width, root.low == 0.0
    top = max(root.high, depth) + 2 * EDGE if low else min(root.low, wide - depth) - 2 * EDGE
    beside = root.inner + (EDGE if low else -EDGE)
    inwards = (-FAR, x) if right else (x, FAR)
    gap = LineString([(end, beside) for end in inwards]).difference(web.shape)
    gap = next(
        (one for one in getattr(gap, "geoms", (gap,))
         if not one.is_empty and abs(one.bounds[2 if right else 0] - x) <= EDGE),
        None,
    )  # fmt: skip
    if gap is None or gap.length <= OUTLINE_NOISE or gap.length >= FAR / 2:
        return
    # An outline of the web without the flange's own thickness means that the flange goes too.
    least, _, most, _ = gap.bounds
    amid = root.inner / 2 if low else (root.inner + wide) / 2
    if LineString([(least, amid), (most, amid)]).difference(web.shape).length > OUTLINE_NOISE:
        return
    edges = (0.0, top) if low else (top, wide)
    strip = box(inwards[0], edges[0], inwards[1], edges[1]).difference(web.shape)
    over = box(inwards[0], top, inwards[1], wide) if low else box(inwards[0], 0.0, inwards[1], top)
    open_above = [
        one for one in _polygons(over.difference(web.shape).buffer(-kerf)) if one.length < FAR
    ]
    ledges = [one for one in _polygons(strip) if one.intersects(gap)]
    near = [one for one in open_above if any(one.distance(ledge) <= 2 * kerf for ledge in ledges)]
    if near and all(one.length < FAR for one in ledges):
        for one in ledges:
            yield one.buffer(EDGE / 10, join_style="mitre"), abs(top - root.inner)


def _polygons(shape: Shape) -> Iterator[Shape]:
    for one in getattr(shape, "geoms", (shape,)):
        if one.geom_type == "Polygon" and not one.is_empty:
            yield one
