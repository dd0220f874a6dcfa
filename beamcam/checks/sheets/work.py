"""The strokes of one process and the curves that they should follow."""

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from math import inf, pi

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.need import Need
from beamcam.checks.sheets.region import Region, Rings, small_ways
from beamcam.checks.sheets.strokes import HeadStroke, Strokes
from beamcam.checks.sheets.toolpaths import Toolpaths
from beamcam.controllers.moves import Moves
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.machine.torch import Torch, TorchProcess, TorchRow

SPACING = 4.0  #: mm between samples
MITRE = 2.5  #: how far from a corner a path may pass it, by half the kerf
SHOWN = 5  #: of one kind of fault
WINDING = 0.02  #: share by which stairs of steps are longer than their path, at most
LINE = 0
BESIDE_LINE = 2e-4  #: mm off a line, where it is asked on which side of it the part is


class Work(Struct, dict=True):
    """One process: what is needed, what is followed, and how near that has to be."""

    process: TorchProcess
    strokes: Sequence[HeadStroke]
    moves: Moves  #: those of the strokes, one after the other
    need: Toolpaths
    required: Need  #: the curves that `need` is made of, and where the input has them
    path: Toolpaths
    of_way: Counts  #: the stroke of each way of the path
    torch: Torch
    step: float  #: of the program's numbers
    fine: float  #: what chords may be off
    tolerance: float
    slack: Floats  #: what each needed curve may be off: the tolerance and what joining may move
    half_kerf: float  #: of the beam, that keeps off closed contours; 0 stays on them
    region: Region  #: what closed cuts enclose
    small: Flags  #: needed curves that are too small to be cut
    shift: tuple[float, float]
    name: str
    stepped: bool = False  #: whether paths are stairs of a table's steps

    @cached_property
    def beside(self) -> Flags:
        """The required curves with kerf compensation."""
        return self.region.closed & (self.half_kerf > 0.0)

    @cached_property
    def sides(self) -> Floats:
        """Of each required curve 1 if the waste lies left of it, -1 right of it, 0 of neither.

        Where the longest way of a ring has the part on both sides, it is another's too, and it is
        counted which rings are round it.
        """
        region, need, sides = self.region, self.need, np.zeros(self.need.count)
        if not region.rings:
            return sides
        rings = Rings.of(region.rings)
        longest = np.lexsort((need.lengths[rings.ways], rings.ring))[rings.begins[1:] - 1]
        middle = np.full(len(longest), 0.5)
        on_left, on_right = self.part_beside(need.first[rings.ways[longest]], middle)
        along = np.where(on_left != rings.turned[longest], -1.0, 1.0)
        if len(shared := np.flatnonzero(on_left == on_right)):
            points = shapely.point_on_surface(region.polygons[shared])
            own, around = shapely.STRtree(region.polygons).query(points, "within")
            areas = shapely.area(region.polygons)
            is_round = areas[around] > areas[shared[own]]
            is_hole = np.bincount(own[is_round], minlength=len(shared)) % 2 == 1
            along[shared] = np.where(is_hole == region.anticlockwise[shared], 1.0, -1.0)
        sides[rings.ways] = np.where(rings.turned, -along[rings.ring], along[rings.ring])
        return sides

    def part_beside(self, element: Counts, share: Floats) -> Flags:
        """Of places of the required curves whether the part lies left and right of them, (2, n)."""
        off = self.off_surely(self.need.owner[element])[:, None]
        places, aside = self.need.elements.places(element, share), self.left_of(element, share)
        beside = np.concatenate((places + off * aside, places - off * aside))
        return self.region.in_part(beside).reshape(2, -1)

    def off_surely(self, way: Counts) -> Floats:
        """How far off required curves it is sure what is part, which is known by chords."""
        return np.where(self.need.kinds[way] == LINE, BESIDE_LINE, 2 * self.fine)

    def left_of(self, element: Counts, share: Floats) -> Floats:
        """The directions square to elements of the required curves, to their left, (n, 2)."""
        ahead = self.need.elements.directions(element, share)
        return np.column_stack((-ahead[:, 1], ahead[:, 0]))

    @cached_property
    def holes(self) -> list[bool | None]:
        """Of each closed contour whether the waste lies inside of it.

        None of those that cross themselves or others.
        """
        region, polygons = self.region, self.region.polygons
        clear = shapely.is_valid(polygons)
        one, other = np.flatnonzero(clear)[shapely.STRtree(polygons[clear]).query(polygons[clear])]
        one, other = one[one < other], other[one < other]
        rings = (shapely.get_exterior_ring(polygons[k]) for k in (one, other))
        crossing = shapely.intersects(*rings)
        one, other = one[crossing], other[crossing]
        crossing = shapely.overlaps(polygons[one], polygons[other])
        clear[one[crossing]] = clear[other[crossing]] = False
        firsts = [ring[0] for ring in region.rings]
        rows = zip(firsts, region.anticlockwise.tolist(), clear.tolist(), strict=True)
        return [
            ((self.sides[way] > 0.0) != back) == turned if is_clear and self.sides[way] else None
            for (way, back), turned, is_clear in rows
        ]

    @cached_property
    def most_slack(self) -> float:
        """The greatest slack of a required curve."""
        return float(self.slack.max(initial=0.0))

    @cached_property
    def contours(self) -> NDArray[np.object_]:
        """The required curves as lines; chords are at most `fine` off."""
        return self.need.lines(self.fine)

    def on_kept_off(self, points: Floats) -> Flags:
        """Points that lie on a contour which the beam keeps off.

        What is open there is drawn twice, or ends on the contour.
        """
        on = np.zeros(len(points), dtype=bool)
        if self.half_kerf:
            pairs = self.need.near(points, self.torch.gap)
            on[pairs.point[self.beside[self.need.owner[pairs.element]]]] = True
        return on

    @property
    def bridged(self) -> bool:
        """Whether contours may have bridges."""
        return bool(self.torch.tabs) and self.process == "cut"

    @property
    def meeting(self) -> float:
        """How far apart two ends may be that meet."""
        return 2 * (self.tolerance if self.stepped else self.step)

    @property
    def most_in(self) -> float:
        """Maximum length of a lead-in; the controller takes up half a kerf along it."""
        return self._most(self.torch.lead_in) if self.torch.lead != "none" else 0.0

    @property
    def most_from_middle(self) -> float:
        """Maximum length of the half circle from the middle of a small hole, which is one move."""
        if self.torch.lead == "none" or self.torch.hole_lead != "middle":
            return 0.0
        widest = max((s.row.hole_diameter for s in self.strokes), default=0.0)
        return self._most(pi / 4 * widest)

    @property
    def most_out(self) -> float:
        """Maximum length of what follows a contour: an overcut, and a lead-out."""
        return self.most_lead + self.most_over

    @property
    def most_lead(self) -> float:
        """Maximum length of a lead-out."""
        return self._most(self.torch.lead_out) if self.torch.lead != "none" else 0.0

    @property
    def most_over(self) -> float:
        """The longest overcut that may be asked of a contour; 0 of a process without one."""
        if self.process != "cut":
            return 0.0
        overcuts = [own.overcut for own in self.torch.settings.values() if own.overcut is not None]
        most = max([self.torch.overcut, self.torch.hole_overcut or 0.0, *overcuts])
        return self._most(most) + 2 * self.tolerance if most else 0.0

    def _most(self, length: float) -> float:
        taken_up = 2 * self.half_kerf if self.torch.kerf_by == "machine" else 0.0
        if self.stepped:
            return length * (1.0 + WINDING) + 4 * self.tolerance
        return length * 1.001 + 8 * self.step + taken_up

    def contour(self, way: int) -> str:
        """Source of a required curve."""
        return str(self.required.source(self.process, way))

    def contour_at(self, place: Floats) -> str:
        """Source of the required curve nearest to a place."""
        return self.contour(self.need.nearest_to(place)[1])

    def fault(
        self, rule: Rule, line: int | None, place: Iterable[float] = (), /, **values: object
    ) -> Diagnostic:
        """A fault at a line of the program, and at a place of the machine if one is given."""
        at = {axis: f"{value:.3f}" for axis, value in zip("xy", place, strict=False)}
        return rule.at(Source(self.name, line), **at, **values)

    def missing(self, way: int, place: Floats) -> Diagnostic:
        """That nothing follows a contour."""
        return self.fault(
            rules.MISSING, None, place - np.array(self.shift), process=self.process,
            contour=self.contour(way), machine_x=f"{place[0]:.3f}", machine_y=f"{place[1]:.3f}",
        )  # fmt: skip


def work_of(
    process: TorchProcess, strokes: Strokes, need: Need, step: float, torch: Torch,
    shift: tuple[float, float], name: str, stepped: bool = False,
) -> Work:  # fmt: skip
    """The strokes of a process among all, and the curves that it needs."""
    mine = [s for s in strokes.each if s.process == process]
    counts = np.array([s.last - s.first for s in mine], dtype=np.int64)
    moves = strokes.moves
    if len(mine) < len(strokes.each):
        spans = [np.arange(s.first, s.last) for s in mine]
        moves = moves.take(np.concatenate([np.zeros(0, dtype=np.int64), *spans]))
    fine = torch.tolerance / 8
    curves = need.curves.get(process, [])
    toolpaths = need.toolpaths(process, fine).moved(shift)
    half_kerf = 0.0
    if process == "cut" and torch.kerf_by != "none":
        half_kerf = max((s.row.kerf / 2 for s in mine), default=0.0)
    region = Region.none(len(curves))
    if process == "cut" and len(curves):
        region = need.region(torch).moved(shift)
    tolerance = torch.tolerance + 2 * step + fine
    # What joining ends may move is allowed where there is something to join.
    joined = region.apart
    if not (half_kerf and len(curves)):
        tolerance += widest_joint(toolpaths, torch.gap)
        joined = np.zeros(len(curves))
    slack = tolerance + joined
    return Work(
        process, mine, moves, toolpaths, need, Toolpaths.of_moves(moves, fine),
        np.repeat(np.arange(len(mine)), counts), torch, step, fine, tolerance,
        slack, half_kerf, region, small_ways(toolpaths, torch.gap), shift, name, stepped,
    )  # fmt: skip


def widest_joint(need: Toolpaths, gap: float) -> float:
    """The widest gap between two ends that had to be joined."""
    opened = np.flatnonzero(np.hypot(*(need.ends - need.starts).T) > 1e-9)
    starts, ends = need.starts[opened], need.ends[opened]
    # Where one ends as the next begins, the place is known already.
    apart = np.any(ends != np.roll(starts, -1, axis=0), axis=1)
    return widest_gap(np.concatenate((starts, ends[apart])), gap)


def widest_gap(points: Floats, reach: float) -> float:
    """The greatest distance of two points (n, 2) that are no farther than `reach` from each other.

    0 if there are none.
    """
    once = np.unique(np.ascontiguousarray(points).view(np.complex128))
    places = shapely.points(once.real, once.imag)
    a, b = shapely.STRtree(places).query(places, "dwithin", distance=reach)
    return float(np.abs(once[a] - once[b]).max(initial=0.0))


# --- alike ----------------------------------------------------------------------------------------

# Strokes that two processes make by the same words: the row of each by the curves that it follows.


PLACES = 9  #: of a stroke that are looked at


def with_own_rows(
    strokes: Strokes, need: Need, torch: Torch, shift: tuple[float, float]
) -> Strokes:
    """The strokes with the rows of what they follow, where word and feed leave several.

    What follows no contour, as a text does, is taken for a mark: its place is not known yet.
    """
    if not any(stroke.alike for stroke in strokes.each):
        return strokes
    curves = {
        process: need.toolpaths(process, torch.tolerance / 8).moved(shift)
        for process in need.curves
    }
    each = [_settled(s, strokes, curves, torch) if s.alike else s for s in strokes.each]
    return Strokes(each, strokes.moves)


def _settled(
    stroke: HeadStroke, strokes: Strokes, curves: Mapping[TorchProcess, Toolpaths], torch: Torch
) -> HeadStroke:
    options: dict[TorchProcess, TorchRow] = {}
    for row in (stroke.row, *stroke.alike):
        options.setdefault(row.process, row)
    if len(options) == 1:
        return stroke
    ends = strokes.moves.end[stroke.first : stroke.last]
    places = ends[:: max(1, len(ends) // PLACES)]
    away = {
        process: float(np.median([curves[process].nearest_to(place)[0] for place in places]))
        for process in options
        if process in curves
    }
    nearest = min(away, key=lambda process: away[process], default=stroke.process)
    if away.get(nearest, inf) > stroke.row.kerf + 8 * torch.tolerance:
        nearest = next((process for process in options if process != "cut"), stroke.process)
    return replace(stroke, row=options[nearest])
