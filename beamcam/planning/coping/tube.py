r"""The plan of a tube that turns under a torch: its surface unrolled, and wrapped again.

   x 0                   The surface lies flat, x along the tube and u round its outside, from
u  |   ( )     |  end    the middle of its lowest line towards v. What crosses u 0 is there again
   |           |         a turn on: the region is laid three times above itself, and each cut is
0  |___________|         taken once. The ends go all round, from the seam to the seam.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from math import asin, cos, degrees, hypot, inf, pi, radians, sin, tan
from typing import Literal

from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.geometry.curves import Line, Point
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow
from beamcam.model.part import Contour, EndPlane, Face, Feature, Hole, Part
from beamcam.model.plan import CopeCut, CopeKind, CopePlan, Outcome, Piece
from beamcam.model.surface import Around, around
from beamcam.planning import rules as bar_rules
from beamcam.planning.coping import rules
from beamcam.planning.coping.box_corners import MEET
from beamcam.planning.coping.box_tube import Unrolled, unrolled
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.cuts import ROUND, CutChain, borders_of, chains_of, led
from beamcam.planning.coping.regions import (
    AROUND,
    CHORD,
    OUTLINE_NOISE,
    Cut,
    Shape,
    WallRegion,
    curves_of,
    off_edge,
    outline_on,
    rounded,
    shape_of,
    sharp_corners,
    told_rounded,
)
from beamcam.planning.coping.stock import length_needed, told_of_stock
from beamcam.planning.coping.tube_ends import (
    Plane,
    ends_there,
    header_slopes,
    holes_there,
    line_of,
    over_ends,
    planes_of,
    within,
)
from beamcam.planning.coping.walls import PlannedWall, Sorted, sorted_features
from beamcam.planning.left_out import BEVEL


def header_planes(part: Part) -> Iterator[Plane]:
    """The skew ends of a round tube by its header: planes that touch x 0 or the length outside."""
    radius = part.profile.height / 2
    for side in (-1, 1):
        web, flange = header_slopes(part, side)
        if web or flange:
            x = 0.0 if side < 0 else part.length
            yield Plane(side, x + radius * (web + flange - side * hypot(web, flange)), web, flange)


def wedge_of(contour: Contour, wall: float, least_deg: float) -> float:
    """mm that a square cut leaves before the farther surface of its bevelled edges, at most."""
    return max(
        (
            max(0.0, wall - bevel.land) * tan(radians(min(abs(bevel.angle), 89.0)))
            for bevel in contour.bevels
            if abs(bevel.angle) >= least_deg
        ),
        default=0.0,
    )


def denied_ends(part: Part, outline: Shape, way: Around) -> Iterator[Diagnostic]:
    """Errors for ends that the header has otherwise than the outline, on one turn."""
    from shapely import LineString

    for plane in header_planes(part):
        side, seen = plane.side, list[Point]()
        for x, u in line_of(plane, way)[1:-1].tolist():
            across = outline.intersection(LineString([(-2 * part.length, u), (3 * part.length, u)]))
            if not across.is_empty:
                seen.append((across.bounds[0 if side < 0 else 2], x))
        off = max((abs(drawn - x) for drawn, x in seen), default=0.0)
        if off > MEET + way.legs[0].patch.thickness * hypot(plane.by_y, plane.by_z):
            at: Literal["start", "end"] = "start" if side < 0 else "end"
            kind: Literal["web", "flange"] = "web" if plane.by_y else "flange"
            angle = getattr(part.cuts, f"{kind}_{at}")
            yield bar_rules.CUT_DENIED.at(
                part.cut_source(kind, at), kind=kind, found=f"{angle:g}", end=at,
                expected="another line",
            )  # fmt: skip


STEPS = 96  #: places round a hole
LEAST = 1e-6  #: mm that a place may lie off a straight line and say nothing
LEAST_SLANT = 0.5  #: mm that a square cut is off inside of a wall, and that are manual work


def plan_tube(part: Part, machine: Machine, coper: Coper, skips: Collection[str]) -> CopePlan:
    """The work that cuts a tube from a bar. Raises PlanError as `plan_coping` does."""
    found = sorted_features(part, machine, coper, skips)
    if found.refusals:
        raise PlanError(found.refusals)
    chart, profile = Chart(part, coper), part.profile
    wall = max(profile.thickness("v"), profile.flange_thickness)
    row = chart.row(wall)
    if row is None:
        raise PlanError(chart.too_thick(wall, "v", part.source))
    way = around(profile)
    surface = PlannedWall("v", way.turn, wall, -inf, inf, ())
    # Of a piece that comes cut the ends are there, by what its file has of them as made.
    ended = replace(part, features=(*part.features, *ends_there(part)))
    ends = range(len(part.features), len(ended.features))
    once, diagnostics = _once_round(ended, (*found.cut, *ends), way)
    slant = {face: off for face, off in once.slant.items() if off >= LEAST_SLANT}
    if part.made is not None:
        bare, _ = _once_round(ended, ends, way)
        worn, wrong = _once_round(*holes_there(part), way)
        if errors_in(wrong):  # what the piece has is not known
            raise PlanError(errors_in(wrong))
        diagnostics += over_ends(part, once.shape, bare.shape, max(bare.slant.values()))
        there = bare.shape.difference(worn.shape)
        of_voids = tuple(place for place in once.corners if place not in bare.corners)
        once = replace(once, corners=of_voids)
        surface, slant = replace(surface, open=_several(there, way.turn, range(-1, 4))), {}
    region, diagnostics = _laid_out(surface, once, part, coper, diagnostics)
    cuts: list[CopeCut] = []
    if not errors_in(diagnostics):
        cuts, more = _cuts(part, region, found, row, coper, way)
        diagnostics += more
    if errors_in(diagnostics):
        raise PlanError(errors_in(diagnostics))
    if not cuts:
        raise PlanError(bar_rules.NO_WORK.at(part.source, machine=machine.name))
    diagnostics += told_rounded(region, part.source)
    if slant:
        diagnostics.append(rules.SLANT.at(part.source, found=f"{max(slant.values()):.2f}",
                                   faces=", ".join(slant)))  # fmt: skip
    wedges = [(wedge_of(c, wall, coper.min_bevel), c.source) for c in part.contours]
    deepest, source = max(wedges, key=lambda one: one[0], default=(0.0, part.source))
    if deepest >= LEAST_SLANT:
        diagnostics.append(rules.WEDGE.at(source, found=f"{deepest:.2f}", wall=f"{wall:g}"))
    diagnostics += _slow_axes(part, machine, row, way)
    diagnostics += told_of_stock(part, part, coper)
    outcomes = tuple(
        replace(o, left=BEVEL) if o.how == "made" and is_slanted(part.features[o.feature[1]], slant)
        else o
        for o in outcomes_of(part, found, coper.min_bevel)
    )  # fmt: skip
    piece = Piece(part, coper.trim)
    return CopePlan(
        part.profile, (piece,), length_needed(part, coper), tuple(cuts), outcomes,
        tuple(diagnostics), min_bevel=coper.min_bevel,
    )  # fmt: skip


def outcomes_of(
    part: Part, found: Sorted, least: float, made: Collection[int] = ()
) -> Iterator[Outcome]:
    """The outcome of each feature, in order; edges bevelled by `least` degrees are cut square, but
    those of the features `made`."""
    for index in range(len(part.features)):
        if index in found.listed:
            yield Outcome((0, index), "listed", found.listed[index])
        elif index in found.skipped:
            yield Outcome((0, index), "skipped", found.skipped[index].code)
        else:
            bevelled = index not in made and has_bevels(part.features[index], least)
            left = BEVEL if bevelled else ""
            yield Outcome((0, index), "made", "cut", left)


def has_bevels(feature: Feature, least: float) -> bool:
    """Whether edges of a contour are bevelled by so many degrees."""
    return isinstance(feature, Contour) and any(abs(b.angle) >= least for b in feature.bevels)


def is_slanted(feature: Feature, slant: Mapping[Face, float]) -> bool:
    """Whether a feature is an outline of a face that a square cut leaves skew, or a plane."""
    if isinstance(feature, EndPlane):
        return bool(slant)
    return isinstance(feature, Contour) and feature.kind == "outer" and feature.face in slant


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


def _several(once: Shape, turn: float, which: Iterable[int]) -> Shape:
    """What lies on one turn of the surface, on several."""
    from shapely import union_all
    from shapely.affinity import translate

    return union_all([translate(once, 0.0, k * turn) for k in which])


def _laid_out(
    surface: PlannedWall, once: Unrolled, part: Part, coper: Coper, diagnostics: list[Diagnostic]
) -> tuple[WallRegion, list[Diagnostic]]:
    """What stays of the surface, its corners rounded, three times above itself.

    They are rounded on the turn from u 0 on, with as much beside it as their radius looks at.
    """
    from shapely import box, make_valid

    turn = surface.width
    beside = min(AROUND * coper.corner_radius, turn)
    low, _, high, _ = once.shape.bounds
    several = _several(once.shape, turn, range(-1, 3))
    near = make_valid(several.intersection(box(low, -beside, high, turn + beside)))
    on_turn = [(x, u % turn) for x, u in once.corners]
    there = [
        (x, u + k * turn) for x, u in on_turn for k in (-1, 0, 1)
        if -beside < u + k * turn < turn + beside
    ]  # fmt: skip
    region, diagnostics = rounded(surface, near, there, part, coper, diagnostics)
    whole = region.shape.intersection(box(low, 0.0, high, turn))
    # Without places of a straight line at u 0.
    shape = make_valid(_several(whole, turn, range(3)).simplify(LEAST))
    once_rounded = {at: r for at, r in region.rounded.items() if 0.0 <= at[1] < turn}
    return WallRegion(surface, shape, once_rounded), diagnostics


def _once_round(
    part: Part, features: Sequence[int], way: Around
) -> tuple[Unrolled, list[Diagnostic]]:
    """What stays of the surface on one turn by some of a part's features, and what is wrong."""
    from shapely import box, union_all

    if part.profile.code == "M":
        return unrolled(part, features, way)
    round_it = way.turn
    wall = max(part.profile.thickness("v"), part.profile.flange_thickness)
    surface = PlannedWall("v", round_it, wall, -inf, inf, ())
    own = [f for f in map(part.features.__getitem__, features) if isinstance(f, Cut)]
    outer = [c for c in own if isinstance(c, Contour) and c.kind == "outer"]
    whole: Shape = box(0.0, 0.0, part.length, round_it)
    planes = planes_of(part, features)
    skew = [wall * hypot(plane.by_y, plane.by_z) for plane in (*header_planes(part), *planes)]
    diagnostics: list[Diagnostic] = []
    if outer:
        strip = box(-part.length, 0.0, 2 * part.length, round_it)
        drawn = [outline_on(surface, c.curves, part.length / 2) for c in outer]
        open_seams = [
            off
            for contour in outer for side in contour.curves for edge in (0.0, round_it)
            if isinstance(side, Line)
            and (off := off_edge(side, edge, part.length / 2)) is not None
            and off > OUTLINE_NOISE
        ]  # fmt: skip
        if open_seams:
            diagnostics.append(rules.SEAM.at(outer[0].source, found=f"{max(open_seams):.2f}"))
        whole = union_all(drawn).intersection(strip)
        diagnostics += denied_ends(part, whole, way)
    else:
        planes += header_planes(part)
    shape = whole = within(whole, planes, way)
    corners: list[Point] = []
    for feature in own:
        if isinstance(feature, Contour):
            corners += sharp_corners(feature)
            if feature.kind == "outer":
                continue
        gone = _several(_taken(feature, part), round_it, (-1, 0, 1))
        if not gone.intersects(whole):
            diagnostics.append(rules.OFF.at(feature.source, what="a hole or cut-out"))
        shape = shape.difference(gone)
    return Unrolled(shape, tuple(corners), {"v": max(skew, default=0.0)}), diagnostics


def _taken(feature: Cut, part: Part) -> Shape:
    """What a feature takes of the unrolled surface.

    A hole is drawn as a drill makes it, square to the axis of the tube: at y from its middle along
    the section it meets the outside at R asin(y / R) of arc.
    """
    from shapely import Polygon

    radius = part.profile.height / 2
    if not isinstance(feature, Hole):
        return shape_of(curves_of(feature))
    r = min(feature.diameter / 2, radius)
    turns = [2 * pi * k / STEPS for k in range(STEPS)]
    return Polygon(
        [(feature.x + r * cos(t), feature.y + radius * asin(r * sin(t) / radius)) for t in turns]
    )


def _cuts(
    part: Part, region: WallRegion, found: Sorted, row: TorchRow, coper: Coper, tube: Around
) -> tuple[list[CopeCut], list[Diagnostic]]:
    """The cuts in order: what lies in the surface, the near end, the far end.

    A place in a message is u round the tube, on the face that it lies on.
    """
    wall, half = region.wall, row.kerf / 2
    paths = region.shape.buffer(half, ROUND)
    seam = wall.width + coper.seam * wall.width / 360.0
    cuts: list[CopeCut] = []
    diagnostics: list[Diagnostic] = []
    features = tuple((0, f) for f in found.cut)
    source = part.features[found.cut[0]].source if found.cut else part.source
    end = region.shape.bounds[2]
    inside = replace(wall, low=0.0, high=3 * wall.width)
    ends = _ends(paths, seam, wall) if part.made is None else ()
    for chain in (*_whole(paths, wall), *ends):
        xs = [x for x, _ in chain.points]
        kind: CopeKind = "inner"
        if chain.start:
            kind = "far" if max(xs) >= end else "near"
        way = led(chain, inside, region.shape, row, coper)
        if way is None:
            x, u = chain.points[0]
            diagnostics.append(
                rules.NARROW.at(
                    source, what="no room to pierce", x=f"{x:g}", y=f"{u % wall.width:g}",
                    face=tube.face_at(u),
                    expected=f"scrap {2 * row.pierce_radius:g} mm wide beside the contour",
                )
            )  # fmt: skip
            continue
        path = tuple((x, u - wall.width) for x, u in way.path)
        face = tube.face_at(path[way.lead][1])
        if (hole := wall.crossed(way.path[way.lead :], row.kerf)) is not None:
            x, u = hole
            diagnostics.append(
                rules.OPEN.at(source, x=f"{x:.1f}", y=f"{u % wall.width:.1f}", face=face)
            )
        cuts.append(CopeCut(kind, face, path, way.lead, wall.thickness, row, features, source))
    order = ("inner", "near", "far")
    cuts.sort(key=lambda cut: (order.index(cut.kind), cut.path[0]))
    kinds = [cut.kind for cut in cuts]
    if part.made is None and (kinds.count("near") != 1 or kinds[-1] != "far"):
        diagnostics.append(rules.OFF.at(source, what="no end that goes all round the tube"))
    return cuts, diagnostics


def _whole(paths: Shape, wall: PlannedWall) -> Iterator[CutChain]:
    """The rings of cut-outs, each once: those that begin in the second turn."""
    for chain in chains_of(paths, borders_of(wall, -CHORD, 3 * wall.width + CHORD, 0.0)):
        low = min(u for _, u in chain.points)
        if not chain.start and wall.width <= low < 2 * wall.width:
            yield chain


def _ends(paths: Shape, seam: float, wall: PlannedWall) -> Iterator[CutChain]:
    """The paths that go all round, from the seam of the second turn to that of the third."""
    for chain in chains_of(paths, borders_of(wall, seam, seam + wall.width, 0.0)):
        if {chain.start, chain.end} == {"low", "high"}:
            yield chain
