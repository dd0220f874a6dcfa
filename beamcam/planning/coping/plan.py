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
from beamcam.model.plan import CopeCut, CopeKind, CopePlan, Piece
from beamcam.planning import rules as bar_rules
from beamcam.planning.coping import rules
from beamcam.planning.coping.bevels import bevel_cuts, edges_of
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.cuts import CutChain, in_two, led
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
from beamcam.planning.coping.fillets import depth_beside, ways_beside
from beamcam.planning.coping.openings import without_openings
from beamcam.planning.coping.regions import (
    WallRegion,
    features_on,
    open_on,
    region_of,
    told_rounded,
)
from beamcam.planning.coping.roots import lip_faults, root_faults, with_ledges, with_steps
from beamcam.planning.coping.stock import (
    as_pipe,
    length_needed,
    stock_faults,
    told_of_stock,
    with_corners,
    with_lip,
)
from beamcam.planning.coping.tube import LEAST_SLANT, outcomes_of, plan_tube
from beamcam.planning.coping.views import chains_seen, kind_of, tilts_of
from beamcam.planning.coping.walls import (
    EDGE,
    PlannedWall,
    Sorted,
    laid,
    sorted_features,
    walls_of,
)
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
    diagnostics = tuple(said for _, said in (*pipes, *turned, *given) if said)
    if errors_in(diagnostics):
        raise PlanError(diagnostics)
    refusals = [*stock_faults(parts, machine, coper, bar)]
    if refusals:
        raise PlanError(refusals)
    (part,) = parts
    if coper.unrolls(part.profile.code):
        plan = plan_tube(part, machine, coper, skips)
    else:
        plan = _plan_profile(part, machine, coper, skips)
    off = [*_before_bar(plan), *_over_supports(plan, coper), *_over_chuck(plan, coper)]
    if off:
        raise PlanError(off)
    if any(said.code == rules.TABLE_RADIUS.code for said in diagnostics):
        plan = replace(plan, usual_corners=True)
    return replace(plan, remarks=(*diagnostics, *plan.remarks)) if diagnostics else plan


def _plan_profile(given: Part, machine: Machine, coper: Coper, skips: Collection[str]) -> CopePlan:
    """The work on an I, a U, an L, a T or a C. Raises PlanError as `plan_coping` does."""
    part = laid(given)
    diagnostics: list[Diagnostic] = []
    found = sorted_features(part, machine, coper, skips, dict(idle_planes(part, outermost(part))))
    if found.refusals:
        raise PlanError(found.refusals)
    chart = Chart(part, coper)
    walls = walls_of(part.profile, coper, chart.cut_height)
    if part.made is not None:
        walls = {
            f: replace(wall, ends=ends_on(f, part), open=open_on(f, part))
            for f, wall in walls.items()
        }
        regions, more = _regions(part, walls, found, coper)
        slant: dict[Face, float] = {}
        tilts = [False, False]
    else:
        part, denied = agreed_ends(part)
        regions, more, slant, tilts = _skew(part, walls, found, chart, coper)
        diagnostics += denied
    diagnostics += more
    at_root: set[Face] = set()
    if not errors_in(diagnostics):
        regions, more, at_root = _at_roots(part, regions, found, chart, coper)
        diagnostics += more
    if errors_in(diagnostics):
        raise PlanError(errors_in(diagnostics))
    square, more = _cuts(part, regions, found, chart, coper)
    diagnostics += more
    on = features_on(part, found.cut)
    bevels = bevel_cuts(part, regions, on, square, tilts, chart, machine)
    diagnostics += bevels.notes
    cuts = _in_order(bevels.cuts)
    slant = {face: off for face, off in slant.items() if off >= LEAST_SLANT}
    if slant:
        diagnostics.append(rules.SLANT.at(part.source, found=f"{max(slant.values()):.2f}",
                                   faces=", ".join(slant)))  # fmt: skip
    if errors_in(diagnostics):
        raise PlanError(errors_in(diagnostics))
    if not cuts:
        raise PlanError(bar_rules.NO_WORK.at(part.source, machine=machine.name))
    diagnostics += [*told_of_stock(part, given, coper), *found.told]
    outcomes = tuple(
        replace(o, left=o.left or _left(part.features[o.feature[1]], slant, at_root))
        if o.how == "made" else o
        for o in outcomes_of(part, found, coper.min_bevel, bevels.features)
    )  # fmt: skip
    plan = CopePlan(
        part.profile, (Piece(given, coper.trim),), length_needed(part, coper), tuple(cuts),
        outcomes, tuple(diagnostics), min_bevel=coper.min_bevel,
    )  # fmt: skip
    if [o.feature for o in plan.outcomes] != [(0, f) for f in range(len(part.features))]:
        raise AssertionError("the ledger of the plan does not balance")
    return plan


def _at_roots(
    part: Part, regions: dict[Face, WallRegion], found: Sorted, chart: Chart, coper: Coper
) -> tuple[dict[Face, WallRegion], list[Diagnostic], set[Face]]:
    """Regions with what stays at the roots, what is told and wrong of them, and the walls that have
    more than is drawn."""
    diagnostics: Sequence[Diagnostic] = ()
    more: set[Face] = set()
    web, flange = regions["v"].wall, regions["u"].wall
    depths = _depths(flange.root_depth, flange, chart)
    if part.made is None:
        over_web = chart.row(web.thickness + web.fillets)
        kerf = over_web.kerf if over_web else EDGE
        regions, diagnostics = with_ledges(regions, depths, kerf, coper, part.source)
        more = {"v"} if diagnostics else set()
    deeper = {
        face: max((chart.depth(depth_beside(region.wall, one)) for _, one in ways_beside(region)
                   if one.crosses), default=depths[None])
        for face, region in regions.items() if face != "v"
    }  # fmt: skip
    regions, steps, off = with_steps(regions, deeper, coper, part.source)
    more |= {face for face, mm in off.items() if mm >= LEAST_SLANT}
    on_web = features_on(part, found.cut).get("v", [])
    closed, holes = without_openings(regions["v"], part, on_web, chart, coper)
    faults = root_faults({**regions, "v": closed}, depths, deeper, coper, part.source)
    return regions, [*diagnostics, *steps, *holes, *faults, *lip_faults(regions, part.source)], more


def _before_bar(plan: CopePlan) -> Iterator[Diagnostic]:
    """An error where the steel of a part begins before the bar that it is cut from."""
    (piece,) = plan.pieces
    if piece.part.made is not None:
        return
    x, cut = min(((x, cut) for cut in plan.operations for x, _ in cut.path), key=itemgetter(0))
    if x < -piece.start:
        yield rules.ORIGIN.at(cut.source, x=f"{x:.1f}", face=cut.face, trim=f"{piece.start:g}")


def _over_supports(plan: CopePlan, coper: Coper) -> Iterator[Diagnostic]:
    """Errors for cuts along which the torch would come to a support of the bar."""
    half = coper.torch_width / 2
    for cut in plan.operations:
        xs = [x + plan.pieces[0].start for x, _ in cut.path]
        ways = [sorted(pair) for pair in pairwise(xs)]
        for zone in coper.supports:
            there = [low for low, high in ways if low < zone.max + half and high > zone.min - half]
            if there:
                yield rules.SUPPORT.at(
                    cut.source, x=f"{there[0]:.1f}", face=cut.face, least=f"{zone.min:g}",
                    most=f"{zone.max:g}",
                )  # fmt: skip


def _over_chuck(plan: CopePlan, coper: Coper) -> Iterator[Diagnostic]:
    """Errors for cuts along which the torch would come to the chuck that holds a piece by its end.

    It holds a bar behind the part and the scrap.
    """
    (piece,) = plan.pieces
    if coper.turns == "torch" or piece.part.made is None:
        return
    most = piece.part.length - coper.chuck - coper.torch_width / 2
    for cut in plan.operations:
        if (x := max(x for x, _ in cut.path)) > most:
            yield rules.CHUCK.at(
                cut.source, x=f"{x:.1f}", face=cut.face, expected=f"{most:g}",
                chuck=f"{coper.chuck:g}",
            )  # fmt: skip


def _skew(
    part: Part, walls: Mapping[Face, PlannedWall], found: Sorted, chart: Chart, coper: Coper
) -> tuple[dict[Face, WallRegion], list[Diagnostic], dict[Face, float], list[bool]]:
    """The regions of a bar with its ends, by wall how many mm a square cut leaves too much, and at
    which ends the torch is tilted."""
    planes = planes_of(part)
    tilts = [plane.is_skew and coper.tilt > 0.0 for plane in planes]
    for k in (*(k for k in (0, 1) if tilts[k]), None):
        skewed = {f: with_skew(wall, part, (tilts[0], tilts[1])) for f, wall in walls.items()}
        diagnostics = [
            rules.CROSSED.at(part.source, face=face) for face, wall in skewed.items()
            if crossed(wall, part.length)
        ]  # fmt: skip
        if diagnostics:
            return {}, diagnostics, {}, tilts
        regions, diagnostics = _regions(part, skewed, found, coper)
        if errors_in(diagnostics) or k is None:
            break
        tilts[k] = tilts_at(regions, part, k, coper)
    slant: dict[Face, float] = {}
    for k, plane in enumerate(planes):
        if plane.is_skew and not tilts[k] and not errors_in(diagnostics):
            regions, off = squared(regions, part, k, chart.depth(walls["u"].root_depth))
            slant |= {face: max(mm, slant.get(face, 0.0)) for face, mm in off.items()}
    return regions, diagnostics, slant, tilts


def _depths(root: float, flange: PlannedWall, chart: Chart) -> dict[int | None, float]:
    """How deep a pass through a root cuts square to the flange, and at each end it is tilted to."""
    depths: dict[int | None, float] = {None: chart.depth(root)}
    for k, line in enumerate(flange.skew):
        if line is not None and line.b_deg:
            share = cos(radians(line.b_deg))
            depths[k] = share * chart.depth(root / share)
    return depths


def _regions(
    part: Part, walls: Mapping[Face, PlannedWall], found: Sorted, coper: Coper
) -> tuple[dict[Face, WallRegion], list[Diagnostic]]:
    regions: dict[Face, WallRegion] = {}
    diagnostics: list[Diagnostic] = []
    on = features_on(part, found.cut)
    for face, wall in walls.items():
        regions[face], more = region_of(wall, part, on.get(face, []), coper)
        diagnostics += more
        if regions[face].shape.is_empty:
            diagnostics.append(rules.OFF.at(part.source, what=f"all of face {face} cut away"))
        else:
            diagnostics += told_rounded(regions[face], part.source)
    if not errors_in(diagnostics):
        diagnostics += _flanges_alone(part, regions)
    return regions, diagnostics


def _flanges_alone(part: Part, regions: Mapping[Face, WallRegion]) -> Iterator[Diagnostic]:
    """An error for each flange without an outline, that no steel of the web joins."""
    contours = [c for c in (*part.features, *(part.made or ())) if isinstance(c, Contour)]
    drawn = {c.face for c in contours if c.kind == "outer" and c.process == "cut"}
    for root in regions["v"].wall.roots if "v" in regions else ():
        low, high = regions["v"].shape.bounds[1::2]
        face: Face = "u" if root.low == 0.0 else "o"
        away = low > root.inner if face == "u" else high < root.inner
        if away and face in regions and face not in drawn:
            yield rules.FLANGE_ALONE.at(
                part.source, face=face, found=part.length, expected=root.inner
            )


def _cuts(
    part: Part, regions: Mapping[Face, WallRegion], found: Sorted, chart: Chart, coper: Coper
) -> tuple[dict[CopeCut, CutChain], list[Diagnostic]]:
    """The cuts of all walls, each with its path as the torch sees it, and those that cannot be
    made."""
    cuts: dict[CopeCut, CutChain] = {}
    diagnostics: list[Diagnostic] = []
    on = features_on(part, found.cut)
    for face, region in regions.items():
        features = tuple((0, f) for f in on.get(face, []))
        source = part.features[features[0][1]].source if features else part.source
        views = [
            one for b_deg in tilts_of(region.wall) for one in chains_seen(region, b_deg, chart)
        ]
        for chain, row, seen, thickness, root in views:
            if row is None:
                diagnostics.append(chart.too_thick(thickness, face, source))
                continue
            wall, shape = seen.region.wall, seen.region.shape
            way = led(chain, wall, shape, row, coper)
            ways = in_two(chain, wall, shape, row, coper) if way is None else [way]
            if not ways:
                x, y = chain.points[0]
                diagnostics.append(
                    rules.NARROW.at(
                        source, what="no room to pierce", x=f"{x / seen.share:g}", y=f"{y:g}",
                        face=face,
                        expected=f"scrap {2 * row.pierce_radius:g} mm wide beside the contour",
                    )
                )  # fmt: skip
            for way in ways:
                if (hole := region.wall.crossed(way.path[way.lead :], row.kerf)) is not None:
                    x, y = hole
                    diagnostics.append(rules.OPEN.at(source, x=f"{x:.1f}", y=f"{y:.1f}", face=face))
                path = tuple((x / seen.share, y) for x, y in way.path) if seen.b_deg else way.path
                cut = CopeCut(
                    kind_of(chain, seen.region, row.kerf), face, path, way.lead, thickness, row,
                    features, source, root, seen.b_deg,
                    lip=bool(region.wall.lip) and wall.high < inf,
                )  # fmt: skip
                cuts[cut] = chain
    return cuts, [*dict.fromkeys(diagnostics)]


def _in_order(cuts: Sequence[CopeCut]) -> list[CopeCut]:
    """Cuts in order of work; a bevel follows its wall, and not the one that parts the piece."""
    last = [*edges_of(cuts)]
    order = dict(ORDER)
    if last:
        order["far"] = (*last, *sorted({*ORDER["far"]} - {*last}, key=ORDER["far"].index))
    return sorted(cuts, key=lambda cut: (
        tuple(order).index(cut.kind), order[cut.kind].index(cut.face),
        cut.bevel - 2 * cut.lower, cut.path[0],
    ))  # fmt: skip


def _left(feature: Feature, slant: Mapping[Face, float], at_root: Collection[str]) -> str:
    """Why an outline is manual work though it is cut; "" if it is not."""
    if not isinstance(feature, Contour) or feature.kind != "outer":
        return ""
    face: Face = "v" if feature.face == "h" else feature.face
    if face in slant:
        return BEVEL
    return ROOT if face in at_root else ""
