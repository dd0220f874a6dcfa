"""The plan of a part on a machine whose torch goes round it."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import product
from typing import Literal

from beamcam.errors import Diagnostic, PlanError, Source, errors_in
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.machine.materials import is_row_for, material_said
from beamcam.machine.torch import TorchRow
from beamcam.model.part import Face, Part
from beamcam.model.plan import CopeCut, CopeKind, CopePlan, Outcome, Piece
from beamcam.model.section import section_fault
from beamcam.planning import rules as bar_rules
from beamcam.planning.coping import rules
from beamcam.planning.coping.cuts import SHARE_OVER, Chain, chains_of, led, paths_of
from beamcam.planning.coping.features import Sorted, sorted_features
from beamcam.planning.coping.regions import Region, features_on, region_of
from beamcam.planning.coping.roots import root_faults
from beamcam.planning.coping.walls import EDGE, Wall, walls_of

#: The faces in which the cuts of a kind are made, so that the torch turns little. What parts the
#: piece from the bar begins where the near end was left.
ORDER: dict[CopeKind, tuple[Face, ...]] = {
    "inner": ("o", "v", "u"), "notch": ("u", "v", "o"), "near": ("o", "v", "u"),
    "far": ("u", "v", "o"),
}  # fmt: skip
NOISE_DEG = 0.2  #: of an end cut in a header


def plan_coping(
    parts: Sequence[Part], machine: Machine, bar: float | None = None, skips: Collection[str] = ()
) -> CopePlan:
    """The work that copes one part from a bar of length `bar`, or as long as it needs.

    `skips` names what may be left out (`planning.SKIP_NAMES`). Raises PlanError with everything
    that the machine cannot make; nothing is left out that is not in the plan's outcomes.
    """
    coper = machine.needed(machine.coper, "coper")
    refusals = [*_stock_faults(parts, machine, coper, bar)]
    if refusals:
        raise PlanError(refusals)
    (part,) = parts
    found = sorted_features(part, machine, coper, skips)
    refusals = [*_end_faults(part), *found.refusals]
    if refusals:
        raise PlanError(refusals)
    chart = Chart(part, coper)
    walls = walls_of(part.profile, coper, chart.cut_height)
    regions, said = _regions(part, walls, found, coper)
    if not errors_in(said):
        said += root_faults(regions, chart.depth(walls["u"].root_depth), coper, part.source)
    if errors_in(said):
        raise PlanError(errors_in(said))
    cuts, more = _cuts(part, regions, found, chart, coper)
    said += more
    if errors_in(said):
        raise PlanError(errors_in(said))
    needed = part.length + 2 * coper.trim
    said.append(rules.BAR.at(part.source, found=f"{needed:g}", trim=f"{coper.trim:g}"))
    if part.quantity > 1:
        said.append(bar_rules.QUANTITY.at(part.source, found=part.quantity, made=1))
    plan = CopePlan(
        part.profile, (Piece(part, coper.trim),), needed, tuple(cuts),
        tuple(_outcomes(part, found)), tuple(said),
    )  # fmt: skip
    if [o.feature for o in plan.outcomes] != [(0, f) for f in range(len(part.features))]:
        raise AssertionError("the ledger of the plan does not balance")
    return plan


def _stock_faults(
    parts: Sequence[Part], machine: Machine, coper: Coper, bar: float | None
) -> Iterator[Diagnostic]:
    """Errors for parts, sections and bars that the machine does not take."""
    if not parts:
        yield bar_rules.NO_PARTS.at(Source(machine.name))
        return
    if len(parts) > 1:
        yield rules.ALONE.at(parts[0].source, found=len(parts), machine=machine.name)
        return
    (part,) = parts
    profile, source = part.profile, part.source
    if profile.code not in coper.profiles:
        yield bar_rules.STOCK.at(
            source, found=profile.code, machine=machine.name, expected=", ".join(coper.profiles)
        )
        return
    fault = section_fault(profile)
    if fault is not None:
        yield bar_rules.SECTION_SHAPE.at(source, found=fault, code=profile.code)
        return
    if profile.height > coper.max_height or profile.width > coper.max_width:
        yield bar_rules.SECTION_SIZE.at(
            source, found=f"{profile.height:g} x {profile.width:g}", station="torch",
            expected=f"{coper.max_height:g} x {coper.max_width:g}",
        )  # fmt: skip
    deep = profile.face_depth("v") + coper.clearance
    if deep > coper.torch_length:
        expected = f"{coper.torch_length - coper.clearance:g}"
        yield rules.DEEP.at(source, found=f"{profile.face_depth('v'):g}", expected=expected)
    needed = part.length + 2 * coper.trim
    if needed > coper.length:
        yield bar_rules.BAR_LONG.at(source, found=f"{needed:g}", expected=f"{coper.length:g}")
    if bar is not None and bar < needed:
        yield bar_rules.BAR_FULL.at(source, found=f"{needed:g}", expected=f"{bar:g}")


def _end_faults(part: Part) -> Iterator[Diagnostic]:
    kinds: tuple[Literal["web", "flange"], ...] = ("web", "flange")
    ends: tuple[Literal["start", "end"], ...] = ("start", "end")
    for kind, at in product(kinds, ends):
        angle = getattr(part.cuts, f"{kind}_{at}")
        if abs(angle) > NOISE_DEG:
            source = part.cut_source(kind, at)
            yield rules.END.at(source, kind=kind, found=f"{angle:g}", end=at)


class Chart:
    """The rows of a cut chart for the steel of a part."""

    def __init__(self, part: Part, coper: Coper) -> None:
        self.material = material_said(part.grade, coper.material)
        self._rows = sorted(
            (row for row in coper.rows if is_row_for(row.material, self.material)),
            key=lambda row: row.up_to,
        )
        self._fallback = coper.rows[0]

    @property
    def deepest(self) -> float:
        """The greatest thickness that is cut; 0 if the steel has no rows."""
        return self._rows[-1].up_to if self._rows else 0.0

    @property
    def cut_height(self) -> float:
        """The least height of the torch over the steel."""
        return min((row.cut_height for row in self._rows), default=self._fallback.cut_height)

    def row(self, thickness: float) -> TorchRow | None:
        """The first row that is deep enough."""
        return next((row for row in self._rows if thickness <= row.up_to + 1e-9), None)

    def depth(self, thickness: float) -> float:
        """How deep the row for a thickness cuts; the thickness itself where there is none."""
        row = self.row(thickness)
        return row.up_to if row else thickness


def _regions(
    part: Part, walls: Mapping[Face, Wall], found: Sorted, coper: Coper
) -> tuple[dict[Face, Region], list[Diagnostic]]:
    regions: dict[Face, Region] = {}
    said: list[Diagnostic] = []
    on = features_on(part, found.cut)
    for face, wall in walls.items():
        regions[face], more = region_of(wall, part, on.get(face, []), coper)
        said += more
        if regions[face].shape.is_empty:
            said.append(rules.OFF.at(part.source, what=f"all of face {face} cut away"))
        elif regions[face].rounded:
            said.append(
                rules.ROUNDED.at(
                    part.source, count=regions[face].rounded, face=face,
                    radius=f"{coper.corner_radius:g}",
                )
            )  # fmt: skip
    return regions, said


def _cuts(
    part: Part, regions: Mapping[Face, Region], found: Sorted, chart: Chart, coper: Coper
) -> tuple[list[CopeCut], list[Diagnostic]]:
    """The cuts of all walls in order of work, and those that cannot be made."""
    cuts: list[CopeCut] = []
    said: list[Diagnostic] = []
    on = features_on(part, found.cut)
    for face, region in regions.items():
        features = tuple((0, f) for f in on.get(face, []))
        source = part.features[features[0][1]].source if features else part.source
        for chain, row, thickness, root in _chains(region, chart):
            if row is None:
                said.append(_too_thick(thickness, face, chart, source))
                continue
            way = led(chain, region.wall, region.shape, row, coper)
            if way is None:
                x, y = chain.points[0]
                said.append(
                    rules.NARROW.at(
                        source, what="no room to pierce", x=f"{x:g}", y=f"{y:g}", face=face,
                        expected=f"scrap {2 * row.pierce_radius:g} mm wide beside the contour",
                    )
                )  # fmt: skip
                continue
            kind = _kind(chain, region)
            cuts.append(
                CopeCut(kind, face, way.path, way.lead, thickness, row, features, source, root)
            )
    cuts.sort(key=lambda cut: (
        tuple(ORDER).index(cut.kind), ORDER[cut.kind].index(cut.face), cut.path[0],
    ))  # fmt: skip
    return cuts, [*dict.fromkeys(said)]


def _too_thick(thickness: float, face: Face, chart: Chart, source: Source) -> Diagnostic:
    return rules.THICK.at(
        source, found=f"{thickness:.4g}", material=chart.material or "steel", face=face,
        expected=f"{chart.deepest:g}",
    )  # fmt: skip


def _chains(region: Region, chart: Chart) -> Iterator[tuple[Chain, TorchRow | None, float, bool]]:
    """The paths round a region, each with its row, what it cuts through, and whether with a root.

    A path through a root runs as far off the part as its own, wider kerf asks for.
    """
    wall = region.wall
    shallow = wall.thickness
    deep = wall.root_depth or wall.thickness + wall.fillets
    for thickness in dict.fromkeys((shallow, deep)):
        row = chart.row(thickness)
        half = row.kerf / 2 if row else EDGE
        over = SHARE_OVER * half
        low, high = max(wall.low, -over), min(wall.high, wall.width + over)
        for chain in chains_of(paths_of(region.shape, half, wall), low, high):
            rooted = _is_rooted(chain, wall)
            if rooted == (thickness == deep) or shallow == deep:
                yield chain, row, thickness, rooted and bool(wall.root_depth)


def _is_rooted(chain: Chain, wall: Wall) -> bool:
    """Whether a path crosses the root of a flange, or of a web goes as near as it can."""
    if wall.root_depth:
        (root,) = wall.roots
        low, high = max(root.low, EDGE), min(root.high, wall.width - EDGE)
        ys = [y for _, y in chain.points]
        return min(ys) <= low and max(ys) >= high
    edges = {"low": wall.low, "high": wall.high}
    return any(end and abs(edges[end]) < 1e9 for end in (chain.start, chain.end))


def _kind(chain: Chain, region: Region) -> CopeKind:
    """What a path makes: what is inside, or at which end of its wall it is."""
    if not chain.start:
        return "inner"
    low, _, high, _ = region.shape.bounds
    xs = [x for x, _ in chain.points]
    if max(xs) >= high:
        return "far"
    return "near" if min(xs) <= low else "notch"


def _outcomes(part: Part, found: Sorted) -> Iterator[Outcome]:
    for index in range(len(part.features)):
        if index in found.listed:
            yield Outcome((0, index), "listed", found.listed[index])
        elif index in found.skipped:
            yield Outcome((0, index), "skipped", found.skipped[index].code)
        else:
            yield Outcome((0, index), "made", "cut")
