"""A wall as a torch sees it that may be tilted along the bar, and the paths that it cuts there.

Tilted by B it sees x shorter by cos(B). Half a kerf, a lead and what piercing burns are true in
that view, as the jet is round about the torch; the paths come back to the wall by 1 / cos(B).
"""

from collections.abc import Iterator
from math import cos, inf, radians

from msgspec import Struct
from msgspec.structs import replace
from shapely import box
from shapely.affinity import scale

from beamcam.machine.torch import TorchRow
from beamcam.model.plan import CopeKind
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.cuts import SHARE_OVER, CutChain, borders_of, chains_of, paths_of
from beamcam.planning.coping.ends import is_on
from beamcam.planning.coping.fillets import beside_web, depth_beside, ways_beside
from beamcam.planning.coping.regions import BEYOND, WallRegion
from beamcam.planning.coping.walls import EDGE, PlannedWall, over_lip


class SeenPath(Struct, frozen=True):
    """A path as a torch sees it that is tilted along the bar: x is shorter by cos(B)."""

    chain: CutChain
    row: TorchRow | None  #: None where none is deep enough
    region: WallRegion
    b_deg: float
    share: float  #: cos(B)
    thickness: float  #: of what it cuts through
    has_root: bool


def paths_seen(region: WallRegion, chart: Chart) -> Iterator[SeenPath]:
    """The paths round a region, square ones first.

    A path through a root runs as far off the part as its own, wider kerf asks for. A flange with a
    lip is cut by two paths, of which one goes through the lip.
    """
    for b_deg in dict.fromkeys((0.0, *(line.b_deg for line in region.wall.skew if line))):
        yield from _paths_on(region, b_deg, chart)
        if region.wall.lip:
            yield from _paths_on(replace(region, wall=over_lip(region.wall)), b_deg, chart)


def _paths_on(region: WallRegion, b_deg: float, chart: Chart) -> Iterator[SeenPath]:
    share, wall = cos(radians(b_deg)), region.wall
    if b_deg:
        start, end = (
            line and replace(line, at=line.at * share, slope=line.slope * share)
            for line in wall.skew
        )
        wall = replace(wall, skew=(start, end))
        shape = scale(region.shape, share, 1.0, origin=(0.0, 0.0))
        region = replace(region, shape=shape, wall=wall)
    shallow = wall.thickness / share
    deep = (wall.root_depth or wall.thickness + wall.fillets) / share
    ways = [*dict.fromkeys(one for _, one in ways_beside(region))]
    levels = [(one, None) for one in dict.fromkeys((shallow, deep))]
    for thickness, beside in (*levels, *((depth_beside(wall, one), one) for one in ways)):
        row = chart.row(thickness)
        half = row.kerf / 2 if row else EDGE
        over = SHARE_OVER * half
        low, high = max(wall.low, -over), min(wall.high, wall.width + over)
        borders = borders_of(wall, low, high, over)
        for chain in chains_of(paths_of(region.shape, half, wall), borders):
            tilted = next((line.b_deg for line in wall.skew if line and line.b_deg
                           and is_on(line, chain.points, half)), 0.0)  # fmt: skip
            rooted = is_rooted(chain, wall)
            if ways and (own := beside_web(chain.points, wall, half)) is not None:
                nearest = min(ways, key=lambda one: (one.crosses != own.crosses,
                                                     abs(one.gap - own.gap)))  # fmt: skip
                if nearest == beside and not b_deg:
                    yield SeenPath(chain, row, region, b_deg, share, thickness, own.crosses)
            elif beside is not None:
                continue
            elif tilted == b_deg and (rooted == (thickness == deep) or shallow == deep):
                has_root = rooted and bool(wall.root_depth)
                yield SeenPath(chain, row, region, b_deg, share, thickness, has_root)


def is_rooted(chain: CutChain, wall: PlannedWall) -> bool:
    """Whether a path crosses the root of a flange, or of a web goes as near as it can."""
    if wall.root_depth:
        (root,) = wall.roots
        low, high = max(root.low, EDGE), min(root.high, wall.width - EDGE)
        ys = [y for _, y in chain.points]
        return min(ys) <= low and max(ys) >= high
    edges = {"low": wall.low, "high": wall.high}
    return any(abs(edges.get(end, inf)) < inf for end in (chain.start, chain.end))


def kind_of(chain: CutChain, region: WallRegion, kerf: float) -> CopeKind:
    """What a path makes: what is inside, or at which end of its wall it is."""
    if not chain.start:
        return "inner"
    shape, wall = region.shape, region.wall
    if wall.lip:  # at its lip a flange may end elsewhere
        y0, y1 = max(wall.low, 0.0), min(wall.high, wall.width)
        shape = shape.intersection(box(-BEYOND, y0, BEYOND, y1))
    low, _, high, _ = shape.bounds
    xs = [x for x, _ in chain.points]
    near, far = (
        line is not None and any(line.is_beside(place, kerf) for place in chain.points)
        for line in region.wall.skew
    )
    if far or max(xs) >= high or "far" in (chain.start, chain.end):
        return "far"
    near = near or min(xs) <= low or "near" in (chain.start, chain.end)
    return "near" if near else "notch"
