r"""The plan of a tube that turns under a torch: its surface unrolled, and wrapped again.

   x 0                   The surface lies flat, x along the tube and u round its outside, from
u  |   ( )     |  end    the middle of its lowest line towards v. What crosses u 0 is there again
   |           |         a turn on: the region is laid three times above itself, and each cut is
0  |___________|         taken once. The ends go all round, from the seam to the seam.
"""

from collections.abc import Collection, Iterator, Sequence
from math import degrees, hypot, inf, radians, tan

from msgspec.structs import replace
from shapely import box

from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow
from beamcam.model.part import Contour, EndPlane, Feature, Part
from beamcam.model.plan import CopeCut, CopeKind, CopePlan
from beamcam.model.surface import Around, around
from beamcam.planning.coping import rules
from beamcam.planning.coping.box_tube import Unrolled, face_ends, unrolled
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.cuts import ROUND, Leads, borders_of, chains_of, no_room, over_hole
from beamcam.planning.coping.ends import outermost
from beamcam.planning.coping.features import (
    LEAST_SLANT,
    FeatureLedger,
    has_bevels,
    plan_of,
    slant_notes,
    sorted_features,
)
from beamcam.planning.coping.regions import AROUND, CHORD, WallRegion, rounded, rounded_notes
from beamcam.planning.coping.round_tube import end_round, once_round
from beamcam.planning.coping.tube_ends import several
from beamcam.planning.coping.tube_pieces import (
    TubePiece,
    ends_there,
    holes_there,
    open_paths,
    path_from_air,
    paths_round,
    planes_refused,
    without_ends,
)
from beamcam.planning.coping.walls import PlannedWall
from beamcam.planning.left_out import BEVEL
from beamcam.planning.within import idle_planes

LEAST = 1e-6  #: mm that a place may lie off a straight line and say nothing


def plan_tube(part: Part, machine: Machine, coper: Coper, skips: Collection[str]) -> CopePlan:
    """The work that cuts a tube from a bar. Raises PlanError as `plan_coping` does."""
    ledger = sorted_features(part, machine, coper, skips)
    if ledger.refusals:
        raise PlanError(ledger.refusals)
    chart, profile = Chart(part, coper), part.profile
    wall = max(profile.thickness("v"), profile.flange_thickness)
    row = chart.row(wall)
    if row is None:
        raise PlanError(chart.too_thick(wall, "v", part.source))
    way = around(profile)
    surface = PlannedWall("v", way.turn, wall, -inf, inf, ())
    piece = None
    if part.made is None:
        once, diagnostics = _once_round(part, ledger.cut, way)
    else:
        once, piece, diagnostics = _left_of_piece(part, ledger.cut, way)
        surface = replace(surface, open=piece.open)
    slant = {face: off for face, off in once.slant.items() if off >= LEAST_SLANT}
    region, more = _laid_out(surface, once, part, coper)
    diagnostics += more
    cuts: list[CopeCut] = []
    if not errors_in(diagnostics):
        cuts, more = _cuts(part, region, ledger, row, coper, way, piece)
        diagnostics += more
    if errors_in(diagnostics):
        raise PlanError(errors_in(diagnostics))
    diagnostics += rounded_notes(region, part.source)
    diagnostics += slant_notes(part, slant)
    # What a square cut leaves before the farther surface of a bevelled edge.
    wedges = [
        (max(0.0, wall - b.land) * tan(radians(min(abs(b.angle), 89.0))), c.source)
        for c in part.contours for b in c.bevels if abs(b.angle) >= coper.min_bevel
    ]  # fmt: skip
    deepest, source = max(wedges, key=lambda one: one[0], default=(0.0, part.source))
    if deepest >= LEAST_SLANT:
        diagnostics.append(rules.WEDGE.at(source, found=f"{deepest:.2f}", wall=f"{wall:g}"))
    diagnostics += _slow_axes(part, machine, row, way)
    ledger = replace(
        ledger, notes=(*ledger.notes, *dict(idle_planes(part, outermost(part))).values())
    )

    def left(_: int, feature: Feature) -> str:
        """Why what is cut is manual work too: bevels, a skew outline, a plane."""
        is_left = has_bevels(feature, coper.min_bevel)
        if isinstance(feature, EndPlane):
            is_left = bool(slant)
        elif isinstance(feature, Contour) and feature.kind == "outer":
            is_left = is_left or feature.face in slant
        return BEVEL if is_left else ""

    return plan_of(part, part, machine, ledger, cuts, diagnostics, left)


def _slow_axes(part: Part, machine: Machine, row: TorchRow, way: Around) -> Iterator[Diagnostic]:
    """A warning where an axis does not go round the corners as fast as the row cuts."""
    (y, z), r = way.axis, part.profile.radius
    if part.profile.code != "M":
        return
    off, turn_s = hypot(y - r, z - r), row.feed_mm_min / 60.0 / r  # of the corner's middle, rad/s
    needs = {"A": degrees(turn_s), "Y": off * turn_s, "Z": off * turn_s}
    shares = {a.name: a.speed / needs[a.moves] for a in machine.axes if a.moves in needs}
    name, share = min(shares.items(), key=lambda one: one[1], default=("", 1.0))
    if share < 1.0:
        yield rules.SLOW.at(
            part.source, found=f"{share * row.feed_mm_min:.0f}", axis=name,
            expected=f"{row.feed_mm_min:g}",
        )  # fmt: skip


def _laid_out(
    surface: PlannedWall, once: Unrolled, part: Part, coper: Coper
) -> tuple[WallRegion, list[Diagnostic]]:
    """What stays of the surface, its corners rounded, three times above itself.

    They are rounded on the turn from u 0 on, with as much beside it as their radius looks at.
    """
    turn = surface.width
    beside = min(AROUND * coper.corner_radius, turn)
    low, _, high, _ = once.shape.bounds
    turns = several(once.shape, turn, range(-1, 3))
    near = turns.intersection(box(low, -beside, high, turn + beside))
    on_turn = [(x, u % turn) for x, u in once.corners]
    there = [
        (x, u + k * turn) for x, u in on_turn for k in (-1, 0, 1)
        if -beside < u + k * turn < turn + beside
    ]  # fmt: skip
    region, diagnostics = rounded(WallRegion(surface, near, {}), there, part, coper)
    whole = region.shape.intersection(box(low, 0.0, high, turn))
    # Without places of a straight line at u 0.
    shape = several(whole, turn, range(3)).simplify(LEAST)
    once_rounded = {at: r for at, r in region.rounded.items() if 0.0 <= at[1] < turn}
    return WallRegion(surface, shape, once_rounded), diagnostics


def _left_of_piece(
    part: Part, features: Sequence[int], way: Around
) -> tuple[Unrolled, TubePiece, list[Diagnostic]]:
    """What stays of a tube that comes cut, the piece that comes, and what is wrong.

    Raises PlanError where what is there of it is not known.
    """
    made = replace(part, features=ends_there(part))
    ends = range(len(made.features))
    bare, wrong = _once_round(made, ends, way)
    worn, more = _once_round(*holes_there(part), way)
    if ledger := errors_in((*wrong, *more)):
        raise PlanError([*dict.fromkeys(ledger)])
    slant = hypot(*(max(bare.slant.get(f, 0.0) for f in pair) for pair in ("vh", "ou")))
    alone = without_ends(part)
    if part.profile.code == "M":
        once, diagnostics = unrolled(alone, features, way, face_ends(made, ends, way))
    else:
        lines = [end_round(made, bare.shape, side, way) for side in (-1, 1)]
        once, diagnostics = once_round(alone, features, way, lines)
    stays = replace(once, shape=once.shape.intersection(bare.shape))
    low, _, high, _ = bare.shape.bounds
    three = box(low, 0.0, high, 3 * way.turn)
    steel = several(bare.shape, way.turn, range(-1, 4)).intersection(three)
    gone = several(bare.shape.difference(worn.shape), way.turn, range(-1, 4))
    return stays, TubePiece(steel, gone, slant), [*planes_refused(part), *diagnostics]


def _once_round(
    part: Part, features: Sequence[int], way: Around
) -> tuple[Unrolled, list[Diagnostic]]:
    """What stays of the surface on one turn by some of a part's features, and what is wrong."""
    of_section = unrolled if part.profile.code == "M" else once_round
    return of_section(part, features, way)


def _cuts(
    part: Part, region: WallRegion, ledger: FeatureLedger, row: TorchRow, coper: Coper,
    tube: Around, piece: TubePiece | None,
) -> tuple[list[CopeCut], list[Diagnostic]]:  # fmt: skip
    """The cuts in order: what lies in the surface, the near end, the far end.

    A place in a message is u round the tube, on the face that it lies on.
    """
    wall, half = region.wall, row.kerf / 2
    paths = paths_round(region.shape, half, piece) if piece else region.shape.buffer(half, ROUND)
    seam = wall.width + coper.seam * wall.width / 360.0
    cuts: list[CopeCut] = []
    faults: list[Diagnostic] = []
    features = tuple((0, f) for f in ledger.cut)
    source = part.features[ledger.cut[0]].source if ledger.cut else part.source
    inside = replace(region, wall=replace(wall, low=0.0, high=3 * wall.width))
    # The rings of cut-outs, each once: those that begin in the second turn.
    chains = [
        chain for chain in chains_of(paths, borders_of(wall, -CHORD, 3 * wall.width + CHORD, 0.0))
        if not chain.start and wall.width <= min(u for _, u in chain.points) < 2 * wall.width
    ]  # fmt: skip
    if piece is not None:
        ends, faults = open_paths(paths, region.shape, piece, row, wall.width, source)
        chains += ends
    else:  # the paths that go all round, from the seam of the second turn to that of the third
        whole = chains_of(paths, borders_of(wall, seam, seam + wall.width, 0.0))
        chains += [chain for chain in whole if {chain.start, chain.end} == {"low", "high"}]
    for chain in chains:
        kind: CopeKind = "inner"
        if chain.start:
            is_far = max(x for x, _ in chain.points) >= region.shape.bounds[2]
            kind = "far" if is_far else "near"
        if piece is not None and chain.start:
            path = path_from_air(chain, region.shape, piece, row, coper)
        else:
            path = Leads(inside, row, coper).path(chain)
        if path is None:
            x, u = chain.points[0]
            faults.append(no_room(source, tube.face_at(u), (x, u % wall.width), row))
            continue
        on_turn = tuple((x, u - wall.width) for x, u in path)
        face = tube.face_at(on_turn[1][1])
        faults += over_hole(wall, path[1:], row, face, source, wall.width)
        cuts.append(CopeCut(kind, face, on_turn, 1, wall.thickness, row, features, source))
    order = ("inner", "near", "far")
    cuts.sort(key=lambda cut: (order.index(cut.kind), cut.path[0]))
    kinds = [cut.kind for cut in cuts]
    if part.made is None and (kinds.count("near") != 1 or kinds[-1] != "far"):
        faults.append(rules.OFF.at(source, what="no end that goes all round the tube"))
    return cuts, faults
