"""Weld preparations of a wall by passes of a torch that is tilted off its normal.

  \\\\ angle      On the side that the torch looks at: the wall is cut square first, its root
___\\\\ wedge     with it. Then the torch takes the wedge off, from its surface to the square
   \\|           face, which stays as the land. A pass needs a wedge that is wider than what
    |  land      piercing burns, and room to run out at both ends of the edge.

       // angle  On the far side: the torch leans the other way, over the scrap, and cuts the
_____ //         whole wall along the bevel first. What that leaves beyond the edge above the
     |/          land goes with the square cut, whose arc stands on it.
     / wedge

       // angle  On the far side, up to the surface: one cut makes the edge. The square cut beside
_____ //         it ends in its kerf, and goes on behind it; that behind it runs the other way, as
     //          it is pierced at its end.

The torch leans square to the edge: over an edge across the bar by B, along the bar by A, else by
both. Round a curve both turn as it cuts; round a cut-out the pass ends where it began.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import dist, pi, tan

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Point
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, Face, Part
from beamcam.model.plan import CopeCut
from beamcam.planning.coping import rules
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.cuts import CutChain, Leads
from beamcam.planning.coping.edges import BevelEdge, bevel_edges
from beamcam.planning.coping.ends import own_bevels
from beamcam.planning.coping.passes import NoPass, Passes
from beamcam.planning.coping.regions import WallRegion
from beamcam.planning.coping.views import is_rooted
from beamcam.planning.coping.walls import PlannedWall, from_behind

BESIDE = 0.05  #: mm from half a kerf off a corner within which a path passes it
SHARPEST = 5 / 6 * pi  #: of a corner beside an edge that one cut makes


class BevelsMade(Struct, frozen=True):
    """The cuts of a part with the passes along its bevelled edges."""

    cuts: list[CopeCut]
    features: set[int]  #: contours all of whose bevels are made, by passes or by tilted ends
    notes: list[Diagnostic]  #: why edges are left


def bevel_cuts(
    part: Part, regions: Mapping[Face, WallRegion], features: Mapping[Face, Sequence[int]],
    cuts: Mapping[CopeCut, CutChain], tilts: Sequence[bool], chart: Chart, machine: Machine,
) -> BevelsMade:  # fmt: skip
    """The passes along the edges that `cuts` make, each with its chain, or the bar has.

    `tilts` says to which ends the torch is tilted. The last wall of a far end parts the piece from
    its bar; no second pass follows it.
    """
    coper = machine.needed(machine.coper, "coper")
    square = dict(cuts)
    passes: list[CopeCut] = []
    made: set[int] = set()
    notes: list[Diagnostic] = []
    beveled: set[Face] = set()
    for face in ("o", "u", "v"):
        for f in features.get(face, ()) if face in regions else ():
            contour = part.features[f]
            if not isinstance(contour, Contour):
                continue
            bevels = own_bevels(contour, part, tilts, coper.min_bevel)
            if not bevels:
                made.add(f)
            if not bevels or not coper.tilt:
                continue
            region = regions[face]
            contour = replace(contour, bevels=tuple(bevels))
            if contour.face != face:
                contour = from_behind(contour, face, region.wall.thickness)
            own: list[CopeCut] = []
            count = 0
            # One cut makes an edge only before all else is made of the square cut beside it.
            edges = sorted(bevel_edges(contour, region.wall, coper.min_bevel),
                           key=lambda edge: not edge.is_whole)  # fmt: skip
            parts = part.made is None and len(beveled | {face}) == len(regions)
            for edge in edges:
                beside = [c for c in square if c.face == face and not c.b_deg]
                plan = Passes(region, part, beside, chart, machine)
                try:
                    cut = plan.along(edge, (0, f), contour)
                    if cut.kind == "far" and not cut.lower and parts:
                        raise NoPass("its wall parts the piece from the bar, which is loose then")
                    if edge.is_whole:
                        _replace(square, plan.square_beside(edge), edge, region, coper)
                except NoPass as why:
                    x, y = edge.curves[0].start
                    notes.append(rules.BEVEL.at(
                        contour.source, found=f"{edge.angle:g}", land=f"{edge.land:g}",
                        face=contour.face, x=f"{x:.1f}", y=f"{y:.1f}", why=str(why),
                    ))  # fmt: skip
                else:
                    own.append(cut)
                    count += edge.count
            if any(cut.kind == "far" and not cut.lower for cut in own):
                beveled.add(face)
            passes += own
            if count == len(bevels):
                made.add(f)
    return BevelsMade([*square, *passes], made, notes)


def _replace(
    square: dict[CopeCut, CutChain], cut: CopeCut | None, edge: BevelEdge, region: WallRegion,
    coper: Coper,
) -> None:  # fmt: skip
    """Leaves of a square cut what an edge that one cut makes leaves it. Raises NoPass."""
    assert cut is not None
    wall, found = region.wall, dict[CopeCut, CutChain]()
    for chain in _beside(edge, square[cut], cut.row.kerf / 2, wall):
        if cut.thickness > wall.thickness and not is_rooted(chain, wall):
            raise NoPass("the square cut beside it would be cut as its root is")
        path = Leads(region, cut.row, coper).path(chain)
        if path is None:
            raise NoPass("the square cut beside it has no scrap to be pierced in")
        found[replace(cut, path=path)] = chain
    del square[cut]
    square |= found


def _beside(edge: BevelEdge, chain: CutChain, half: float, wall: PlannedWall) -> Iterator[CutChain]:
    """What of a path is before an edge and behind it, as far beyond its corners as to where lines
    half a kerf off both edges meet: there it is all in the kerf of the edge's own cut."""
    if edge.is_ring:
        return
    if not chain.start:
        raise NoPass("the square cut beside it would end in the part")
    for points, start, corner, way, turn in (
        (chain.points, chain.start, edge.curves[0].start, edge.ways[0], edge.turns[0]),
        (chain.points[::-1], chain.end, edge.curves[-1].end, edge.ways[1], edge.turns[1]),
    ):
        if wall.is_free(corner):
            continue
        if not 0.0 < turn <= SHARPEST:
            raise NoPass("a corner beside it is too sharp, or turns into the part")
        (x, y), (wx, wy) = corner, way
        at = x + half * wy, y - half * wx
        k = next((k for k, place in enumerate(points) if dist(place, at) <= BESIDE), None)
        if k is None:
            raise NoPass("the square cut beside it does not come to its corner")
        more = half * tan(turn / 2) * (1.0 if points is chain.points else -1.0)
        end: Point = (at[0] + more * wx, at[1] + more * wy)
        yield CutChain((*points[:k], at, end), start, "bevel")
