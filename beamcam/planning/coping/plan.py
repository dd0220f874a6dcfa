"""The plan of a part on a machine whose torch goes round it."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import pairwise
from math import cos, inf, radians
from operator import itemgetter

from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, Face, Feature, Part
from beamcam.model.plan import CopeCut, CopeKind, CopePlan
from beamcam.planning.coping import rules
from beamcam.planning.coping.bevels import bevel_cuts
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.cuts import CutChain, Leads, no_room, over_hole
from beamcam.planning.coping.ends import (
    agreed_ends,
    crossed,
    ends_on,
    outermost,
    planes_of,
    squared,
    tilts_at,
    with_skew,
)
from beamcam.planning.coping.features import (
    LEAST_SLANT,
    has_bevels,
    plan_of,
    slant_notes,
    sorted_features,
)
from beamcam.planning.coping.fillets import depth_beside, ways_beside, without_openings
from beamcam.planning.coping.regions import (
    WallRegion,
    features_on,
    open_on,
    region_of,
    rounded_notes,
)
from beamcam.planning.coping.roots import lip_faults, root_faults, with_ledges, with_steps
from beamcam.planning.coping.stock import as_pipe, stock_faults, with_corners, with_lip
from beamcam.planning.coping.tube import plan_tube
from beamcam.planning.coping.views import kind_of, paths_seen
from beamcam.planning.coping.walls import EDGE, PlannedWall, laid, walls_of
from beamcam.planning.left_out import BEVEL, ROOT
from beamcam.planning.within import idle_planes

#: The faces in which the cuts of a kind are made, so that the torch turns little. What parts the
#: piece from the bar begins where the near end was left.
ORDER: dict[CopeKind, tuple[Face, ...]] = {
    "inner": ("o", "v", "u"), "notch": ("u", "v", "o"), "near": ("o", "v", "u"),
    "far": ("u", "v", "o"),
}  # fmt: skip


def plan_coping(
    parts: Sequence[Part], machine: Machine, bar: float | None = None, skips: Collection[str] = ()
) -> CopePlan:
    """The work that copes one part from a bar of length `bar`, or as long as it needs.

    `skips` names what may be left out (`SKIP_NAMES`). Raises PlanError with everything
    that the machine cannot make; nothing is left out that is not in the plan's outcomes.
    """
    coper = machine.needed(machine.coper, "coper")
    pipes = [as_pipe(part) if coper.turns == "bar" else (part, None) for part in parts]
    turned = [with_corners(part, coper) for part, _ in pipes]
    given = [with_lip(part, coper) for part, _ in turned]
    parts = [part for part, _ in given]
    diagnostics = tuple(note for _, note in (*pipes, *turned, *given) if note)
    if errors_in(diagnostics):
        raise PlanError(diagnostics)
    refusals = [*stock_faults(parts, machine, coper, bar)]
    if refusals:
        raise PlanError(refusals)
    (part,) = parts
    if coper.unrolls(part.profile.code):
        plan = plan_tube(part, machine, coper, skips)
    else:
        plan = ProfilePlan(part, machine, coper, skips).planned()
    if off := [*_out_of_reach(plan, coper)]:
        raise PlanError(off)
    if any(note.code == rules.TABLE_RADIUS.code for note in diagnostics):
        plan = replace(plan, usual_corners=True)
    return replace(plan, remarks=(*diagnostics, *plan.remarks)) if diagnostics else plan


def _out_of_reach(plan: CopePlan, coper: Coper) -> Iterator[Diagnostic]:
    """Errors for steel of a part before the bar that it is cut from, and for cuts along which the
    torch would come to a support, or to the chuck that holds a piece by its end.

    A bar is held behind the part and the scrap.
    """
    (piece,), half = plan.pieces, coper.torch_width / 2
    x, cut = min(((x, cut) for cut in plan.operations for x, _ in cut.path), key=itemgetter(0))
    if piece.part.made is None and x < -piece.start:
        yield rules.ORIGIN.at(cut.source, x=f"{x:.1f}", face=cut.face, trim=f"{piece.start:g}")
    for cut in plan.operations:
        ways = [sorted(pair) for pair in pairwise(x + piece.start for x, _ in cut.path)]
        for zone in coper.supports:
            there = [low for low, high in ways if low < zone.max + half and high > zone.min - half]
            if there:
                yield rules.SUPPORT.at(
                    cut.source, x=f"{there[0]:.1f}", face=cut.face, least=f"{zone.min:g}",
                    most=f"{zone.max:g}",
                )  # fmt: skip
    if coper.turns == "torch" or piece.part.made is None:
        return
    most = piece.part.length - coper.chuck - half
    for cut in plan.operations:
        if (x := max(x for x, _ in cut.path)) > most:
            yield rules.CHUCK.at(
                cut.source, x=f"{x:.1f}", face=cut.face, expected=f"{most:g}",
                chuck=f"{coper.chuck:g}",
            )  # fmt: skip


class ProfilePlan:
    """The work on an I, a U, an L, a T or a C, worked out step by step."""

    def __init__(self, given: Part, machine: Machine, coper: Coper, skips: Collection[str]) -> None:
        self._given, self._machine, self._coper = given, machine, coper
        self._part = part = laid(given)
        idle = dict(idle_planes(part, outermost(part)))
        self._ledger = sorted_features(part, machine, coper, skips, idle)
        if self._ledger.refusals:
            raise PlanError(self._ledger.refusals)
        self._chart = Chart(part, coper)
        self._on = features_on(part, self._ledger.cut)
        self._diagnostics: list[Diagnostic] = []
        self._regions: dict[Face, WallRegion] = {}
        self._slant: dict[Face, float] = {}  #: mm that a square cut leaves too much, by wall
        self._at_root: set[Face] = set()  #: walls that have more than is drawn at their roots
        self._tilts = [False, False]  #: at which ends the torch is tilted

    def planned(self) -> CopePlan:
        """Raises PlanError as `plan_coping` does."""
        part, coper, chart = self._part, self._coper, self._chart
        walls = walls_of(part.profile, coper, chart.cut_height)
        if part.made is not None:
            self._cut_regions({
                f: replace(wall, ends=ends_on(f, part), open=open_on(f, part))
                for f, wall in walls.items()
            })  # fmt: skip
        else:
            self._part, denied = agreed_ends(part)
            self._skew(walls)
            self._diagnostics[:0] = denied
        self._stop()
        self._at_roots()
        self._stop()
        square = self._cuts()
        bevels = bevel_cuts(
            self._part, self._regions, self._on, square, self._tilts, chart, self._machine
        )
        self._diagnostics += bevels.notes
        slant = {face: mm for face, mm in self._slant.items() if mm >= LEAST_SLANT}
        self._diagnostics += slant_notes(self._part, slant)
        self._stop()
        # Cuts in order of work; a bevel follows its wall, and not the one that parts the piece.
        last = dict.fromkeys(c.face for c in bevels.cuts if c.bevel and c.kind == "far")
        order = dict(ORDER)
        order["far"] = (*last, *(face for face in ORDER["far"] if face not in last))
        cuts = sorted(bevels.cuts, key=lambda cut: (
            tuple(order).index(cut.kind), order[cut.kind].index(cut.face),
            cut.bevel - 2 * cut.lower, cut.path[0],
        ))  # fmt: skip

        def left(k: int, feature: Feature) -> str:
            """Why a contour is manual work though it is cut; "" if it is not."""
            if k not in bevels.features and has_bevels(feature, coper.min_bevel):
                return BEVEL
            if not isinstance(feature, Contour) or feature.kind != "outer":
                return ""
            face: Face = "v" if feature.face == "h" else feature.face
            return BEVEL if face in slant else ROOT if face in self._at_root else ""

        return plan_of(self._part, self._given, self._machine, self._ledger, cuts,
                       self._diagnostics, left)  # fmt: skip

    def _stop(self) -> None:
        """Raises PlanError where anything is wrong so far."""
        if errors := errors_in(self._diagnostics):
            raise PlanError(errors)

    def _at_roots(self) -> None:
        """Adds what stays at the roots, and what is told and wrong of them."""
        regions, chart, coper, source = (self._regions, self._chart, self._coper, self._part.source)
        web, flange = regions["v"].wall, regions["u"].wall
        # How deep a pass through a root cuts square to the flange, and at each end it is tilted to.
        depths: dict[int | None, float] = {None: chart.depth(flange.root_depth)}
        for k, line in enumerate(flange.skew):
            if line is not None and line.b_deg:
                share = cos(radians(line.b_deg))
                depths[k] = share * chart.depth(flange.root_depth / share)
        if self._part.made is None:
            over_web = chart.row(web.thickness + web.fillets)
            kerf = over_web.kerf if over_web else EDGE
            regions, ledges = with_ledges(regions, depths, kerf, coper, source)
            self._at_root = {"v"} if ledges else set()
            self._diagnostics += ledges
        deeper = {
            face: max((chart.depth(depth_beside(region.wall, one))
                       for _, one in ways_beside(region) if one.crosses), default=depths[None])
            for face, region in regions.items() if face != "v"
        }  # fmt: skip
        self._regions, steps, off = with_steps(regions, deeper, coper, source)
        self._at_root |= {face for face, mm in off.items() if mm >= LEAST_SLANT}
        on_web = [self._part.features[f] for f in self._on.get("v", [])]
        web_region, openings = without_openings(
            self._regions["v"], on_web, self._part.profile.radius, chart
        )
        self._diagnostics += [*steps, *openings]
        closed = {**self._regions, "v": web_region}
        self._diagnostics += root_faults(closed, depths, deeper, coper, source)
        self._diagnostics += lip_faults(self._regions, source)

    def _skew(self, walls: Mapping[Face, PlannedWall]) -> None:
        """The regions of a bar with its ends."""
        part, tilts, planes = self._part, self._tilts, planes_of(self._part)
        tilts[:] = [plane.is_skew and self._coper.tilt > 0.0 for plane in planes]
        for k in (*(k for k in (0, 1) if tilts[k]), None):
            skewed = {f: with_skew(wall, part, (tilts[0], tilts[1])) for f, wall in walls.items()}
            crossing = [
                rules.CROSSED.at(part.source, face=face) for face, wall in skewed.items()
                if crossed(wall, part.length)
            ]  # fmt: skip
            self._diagnostics.clear()
            if crossing:
                self._diagnostics += crossing
                return
            self._cut_regions(skewed)
            if errors_in(self._diagnostics):
                return
            if k is not None:
                tilts[k] = tilts_at(self._regions, part, k, self._coper)
        depth = self._chart.depth(walls["u"].root_depth)
        for k, plane in enumerate(planes):
            if plane.is_skew and not tilts[k]:
                self._regions, off = squared(self._regions, part, k, depth)
                for face, mm in off.items():
                    self._slant[face] = max(mm, self._slant.get(face, 0.0))

    def _cut_regions(self, walls: Mapping[Face, PlannedWall]) -> None:
        """What stays of each wall, and what is wrong with it."""
        part, regions = self._part, dict[Face, WallRegion]()
        for face, wall in walls.items():
            regions[face], more = region_of(wall, part, self._on.get(face, []), self._coper)
            self._diagnostics += more
            if regions[face].shape.is_empty:
                what = f"all of face {face} cut away"
                self._diagnostics.append(rules.OFF.at(part.source, what=what))
            else:
                self._diagnostics += rounded_notes(regions[face], part.source)
        self._regions = regions
        if errors_in(self._diagnostics):
            return
        # A flange without an outline that no steel of the web joins.
        contours = [c for c in (*part.features, *(part.made or ())) if isinstance(c, Contour)]
        drawn = {c.face for c in contours if c.kind == "outer" and c.process == "cut"}
        low, high = regions["v"].shape.bounds[1::2]
        for root in regions["v"].wall.roots:
            away = low > root.inner if root.face == "u" else high < root.inner
            if away and root.face in regions and root.face not in drawn:
                self._diagnostics.append(rules.FLANGE_ALONE.at(
                    part.source, face=root.face, found=part.length, expected=root.inner
                ))  # fmt: skip

    def _cuts(self) -> dict[CopeCut, CutChain]:
        """The cuts of all walls, each with its path as the torch sees it."""
        cuts: dict[CopeCut, CutChain] = {}
        faults: list[Diagnostic] = []
        for face, region in self._regions.items():
            features = tuple((0, f) for f in self._on.get(face, []))
            whole = self._part.features[features[0][1]] if features else self._part
            for seen in paths_seen(region, self._chart):
                chain, row, wall = seen.chain, seen.row, seen.region.wall
                if row is None:
                    faults.append(self._chart.too_thick(seen.thickness, face, whole.source))
                    continue
                leads = Leads(seen.region, row, self._coper)
                path = leads.path(chain)
                paths = leads.in_two(chain) if path is None else [path]
                if not paths:
                    x, y = chain.points[0]
                    faults.append(no_room(whole.source, face, (x / seen.share, y), row))
                for path in paths:
                    faults += over_hole(region.wall, path[1:], row, face, whole.source)
                    if seen.b_deg:
                        path = tuple((x / seen.share, y) for x, y in path)
                    cut = CopeCut(
                        kind_of(chain, seen.region, row.kerf), face, path, 1, seen.thickness, row,
                        features, whole.source, seen.has_root, seen.b_deg,
                        lip=bool(region.wall.lip) and wall.high < inf,
                    )  # fmt: skip
                    cuts[cut] = chain
        self._diagnostics += dict.fromkeys(faults)
        return cuts
