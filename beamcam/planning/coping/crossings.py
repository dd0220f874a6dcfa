"""Cuts of a wall through the whole of a root: square to the bar, or in the plane of an end."""

from msgspec import Struct

from beamcam.geometry.curves import Point
from beamcam.machine.coper import Coper
from beamcam.planning.coping.cuts import borders_of, chains_of
from beamcam.planning.coping.regions import WallRegion
from beamcam.planning.coping.walls import EDGE

SHARE = 0.5  #: of the tolerance, that web and flange may differ by at a root


class Crossing(Struct, frozen=True):
    """A cut through the whole of a root, square to the bar or in the plane of an end."""

    x: float
    right: bool  #: whether the scrap lies at greater x
    square: bool = True  #: to the bar
    end: int | None = None  #: in whose plane it lies, 0 at the start


def crossings(
    region: WallRegion, band: tuple[float, float], coper: Coper
) -> tuple[list[Crossing], list[tuple[Point, ...]]]:
    """The cuts through a band of a wall, along x, and the paths by which it is cut otherwise."""
    crossings: list[Crossing] = []
    wrong: list[tuple[Point, ...]] = []
    for chain in chains_of(region.shape, borders_of(region.wall, *band, -EDGE)):
        xs = [x for x, _ in chain.points]
        whole = {chain.start, chain.end} == {"low", "high"}
        near = SHARE * coper.tolerance
        end = next(
            (k for k, line in enumerate(region.wall.skew)
             if line and all(abs(x - line.x(y)) <= near for x, y in chain.points)),
            None,
        )  # fmt: skip
        square = max(xs) - min(xs) <= near
        if not whole or (end is None and not square):
            wrong.append(chain.points)
            continue
        # The region lies on the left of its ring: upwards, the scrap is at greater x.
        crossings.append(Crossing((max(xs) + min(xs)) / 2, chain.start == "low", square, end))
    return sorted(crossings, key=lambda one: one.x), wrong


def through_flange(
    flange: WallRegion, coper: Coper
) -> tuple[list[Crossing], list[tuple[Point, ...]], tuple[float, float]]:
    """The cuts through a flange where its web stands, as `crossings`, and in which band: over web
    and fillets, or where one runs along the web, over that alone."""
    wall = flange.wall
    (behind,) = wall.roots
    band = max(EDGE, behind.low), min(wall.width - EDGE, behind.high)
    on_flange, wrong = crossings(flange, band, coper)
    if wrong and behind.stands is not None:
        low, high = max(behind.stands[0], 0.0) + EDGE, min(behind.stands[1], wall.width) - EDGE
        if wall.skew == (None, None):
            return *crossings(flange, (low, high), coper), (low, high)
        ys = [[y for _, y in way] for way in wrong]
        wrong = [way for way, of in zip(wrong, ys, strict=True) if max(of) > low and min(of) < high]
    return on_flange, wrong, band
