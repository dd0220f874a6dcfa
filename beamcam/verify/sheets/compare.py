"""Paths travelled with the tool on, compared with the contours of the part.

Both are sampled, whatever they are made of. With r half the kerf that the program keeps off:

    every sample of a contour    has the path r beside it, or no tool of that width can come there
    every sample of a path       has a contour r beside it, but for the leads, which lie in waste
    every stroke                 closes, or ends where a contour ends
    no stretch of a contour      has two paths
    no contour                   is cut after one around it, none marked after a cut
"""

from collections.abc import Sequence
from typing import cast

import numpy as np
import shapely
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Arc, BSpline, Curve, Line, bezier_pieces
from beamcam.machine.machine import Machine, Torch, TorchProcess
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.need import Need
from beamcam.verify.sheets.strokes import Stroke
from beamcam.verify.sheets.ways import Floats, Ways, samples

Flags = NDArray[np.bool_]
Counts = NDArray[np.int64]

SPACING = 4.0  #: mm between samples
MITRE = 2.5  #: how far from a corner a path may pass it, by half the kerf
#: Cubics that stand for circles miss them by 2.7e-4 of the radius; a path may be the true circle.
CIRCLE_SHARE = 3.5e-4
#: Contours that leave a place in directions as near as this lie on one another there.
SAME_DIRECTION_DEG = 2.0
SHOWN = 5  #: of one kind of fault


class _Traced(Struct):
    """A stroke whose leads are known."""

    stroke: Stroke
    first: int  #: of its legs along the contour, among all legs
    last: int
    half_kerf: float  #: that the path keeps off the contour
    closed: bool
    polygon: object  #: inside of the contour's legs; None if it is open
    group: int  #: line of the first stroke of its contour


def compare(
    strokes: Sequence[Stroke],
    need: Need,
    machine: Machine,
    torch: Torch,
    shift: tuple[float, float],
    name: str,
) -> list[Diagnostic]:
    """Everything in which the strokes differ from what the part needs."""
    said: list[Diagnostic] = []
    traced: list[_Traced] = []
    processes = dict.fromkeys([*need.curves, *(s.process for s in strokes)])
    for process in processes:
        one = _Process(process, strokes, need.curves.get(process, []), machine, torch, shift, name)
        said += one.compare()
        traced += one.traced
    said += _order(sorted(traced, key=lambda t: t.stroke.line), name)
    return said


class _Process:
    """The strokes of one process against the curves that it should follow."""

    def __init__(
        self,
        process: TorchProcess,
        strokes: Sequence[Stroke],
        curves: Sequence[Curve],
        machine: Machine,
        torch: Torch,
        shift: tuple[float, float],
        name: str,
    ) -> None:
        self.process: TorchProcess = process
        self.strokes = [s for s in strokes if s.process == process]
        self.curves = curves
        self.torch = torch
        self.shift = shift
        self.name = name
        self.step = machine.format.resolution
        self.traced: list[_Traced] = []
        self._fine = torch.tolerance / 8

    def compare(self) -> list[Diagnostic]:
        """What is missing, too much, twice, open, or on the wrong side."""
        if not self.curves:
            line, (x, y) = self.strokes[0].line, self.strokes[0].legs[0].start
            return [self._extra(line, x, y, "any distance", f"nothing to {self.process}")]
        self.need = Ways(self.curves, self._fine, self.shift)
        if not self.strokes:
            return [self._missing(self.need.starts[0])]
        legs = [leg for stroke in self.strokes for leg in stroke.legs]
        self.legs = legs
        self.path = Ways([leg.curve or Line(leg.start, leg.end) for leg in legs], self._fine)
        self.of_leg = np.repeat(np.arange(len(self.strokes)), [len(s.legs) for s in self.strokes])
        # What joining ends may move is allowed where there is something to join.
        self.tolerance = self.torch.tolerance + 2 * self.step + self._fine + self._loose()
        self.free = np.array(
            [0.0 if isinstance(c, Line | Arc) else _share(c) for c in self.curves]
        ) * np.minimum(self.need.lengths, 1e6)
        return [*self._paths(), *self._contours()]

    def _loose(self) -> float:
        """The widest gap between two ends that had to be joined."""
        apart = np.hypot(*(self.need.ends - self.need.starts).T)
        opened = apart > 1e-9
        ends = np.concatenate((self.need.starts[opened], self.need.ends[opened]))
        if len(ends) < 2:
            return 0.0
        tree = shapely.STRtree(shapely.points(ends))
        a, b = tree.query(shapely.points(ends), "dwithin", distance=self.torch.gap)
        real = a != b
        if not real.any():
            return 0.0
        return float(np.max(np.hypot(*(ends[a[real]] - ends[b[real]]).T)))

    # What the program follows.

    def _paths(self) -> list[Diagnostic]:
        points, _, leg, _ = samples(self.path, SPACING)
        away, who = self.need.nearest(points, self._most_half_kerf() + self.tolerance)
        stroke = self.of_leg[leg]
        radii = self._half_kerfs(away, stroke)
        mine = radii[stroke]
        slack = self.tolerance + self.free[who]
        good = np.abs(away - mine) <= slack
        corner = ~good & (mine > 0.0) & (away > mine) & (away <= MITRE * mine + slack)
        if corner.any():
            at = self.need.along(points[corner], who[corner])
            length = self.need.lengths[who[corner]]
            good[corner] = (at <= slack[corner]) | (length - at <= slack[corner])
        said: list[Diagnostic] = []
        bad_legs = np.zeros(self.path.count, dtype=bool)
        bad_legs[leg[~good]] = True
        begin = np.concatenate(([0], np.cumsum(np.bincount(self.of_leg))))
        for k, one in enumerate(self.strokes):
            first, last = int(begin[k]), int(begin[k + 1])
            first, last, wrong = self._without_leads(one, first, last, bad_legs, float(radii[k]))
            said += wrong
            self.traced.append(self._trace(one, first, last, float(radii[k])))
        self._join_bridged(begin)
        inside = np.zeros(self.path.count, dtype=bool)
        for t in self.traced:
            inside[t.first : t.last] = True
        self.on_contour = inside
        wrong_at = np.flatnonzero(~good & inside[leg])
        _, firsts = np.unique(stroke[wrong_at], return_index=True)
        for k in wrong_at[firsts][:SHOWN]:
            x, y = points[k]
            said.append(
                self._extra(
                    self.legs[leg[k]].line, x, y, f"{away[k]:.4f}",
                    f"{mine[k]:g} mm within {slack[k]:.4f}",
                )
            )  # fmt: skip
        said += self._ends()
        return said

    def _join_bridged(self, begin: Counts) -> None:
        """Strokes with bridges between them go round one contour: the first gets its inside.

        `begin` says where the legs of each stroke begin, those of leads included.
        """
        self.leader = np.arange(len(self.traced))
        if not (self.torch.tabs and self.process == "cut"):
            return
        first = 0
        while first < len(self.traced):
            last = first
            while last < len(self.traced) and not self.traced[last].closed:
                if last > first and self._close(begin, first, last):
                    break
                last = last + 1 if self._goes_on(last) else len(self.traced)
            if first < last < len(self.traced) and not self.traced[last].closed:
                mine = self.traced[first : last + 1]
                lines = [line for t in mine for line in self.path.lines[t.first : t.last]]
                ring = np.concatenate([shapely.get_coordinates(line) for line in lines])
                mine[0].polygon = shapely.make_valid(shapely.Polygon(ring))
                self.leader[first : last + 1] = first
                for t in mine:
                    t.group = mine[0].group
                first = last
            first += 1

    def _goes_on(self, k: int) -> bool:
        """Whether the next stroke begins a bridge's width behind the end of stroke `k`."""
        if k + 1 == len(self.traced):
            return False
        end = self.path.ends[self.traced[k].last - 1]
        following = self.path.starts[self.traced[k + 1].first]
        return bool(np.hypot(*(following - end)) <= self._tab_width(self.traced[k].half_kerf))

    def _close(self, begin: Counts, first: int, last: int) -> bool:
        """Whether stroke `last` ends where `first` begins; what is no part of the ring is lead."""
        starts, ends, lengths = self.path.starts, self.path.ends, self.path.lengths
        head, tail = int(begin[first]), int(begin[last + 1])
        for low in range(self.traced[first].last - 1, head - 1, -1):
            if lengths[head:low].sum() > self._most(self.torch.lead_in):
                continue
            for high in range(int(begin[last]) + 1, tail + 1):
                if lengths[high:tail].sum() > self._most(self.torch.lead_out):
                    continue
                if np.hypot(*(starts[low] - ends[high - 1])) <= 2 * self.step:
                    self.traced[first].first, self.traced[last].last = low, high
                    return True
        return False

    def _most_half_kerf(self) -> float:
        """The greatest that a stroke may keep off its contour."""
        if self.torch.kerf_by != "offset" or self.process != "cut":
            return 0.0
        return max(s.row.kerf / 2 for s in self.strokes)

    def _half_kerfs(self, away: Floats, stroke: Counts) -> Floats:
        """What each stroke keeps off its contours: half the kerf, or nothing."""
        offset = self.torch.kerf_by == "offset" and self.process == "cut"
        kerfs = np.array([s.row.kerf / 2 if offset else 0.0 for s in self.strokes])
        order = np.lexsort((away, stroke))
        counts = np.bincount(stroke, minlength=len(self.strokes))
        middle = away[order][np.cumsum(counts) - counts + counts // 2]
        return np.where(np.abs(middle) < np.abs(middle - kerfs), 0.0, kerfs)

    def _without_leads(
        self, stroke: Stroke, first: int, last: int, bad: Flags, half_kerf: float
    ) -> tuple[int, int, list[Diagnostic]]:
        """The range of a stroke's legs along the contour, and what is wrong with its leads."""
        torch = self.torch
        said: list[Diagnostic] = []
        if self.process != "cut" or torch.lead == "none":
            return first, last, said
        begin, end = self._ring(first, last, bad)
        for low, high in ((first, begin), (end, last)):
            said += self._lead(low, high, half_kerf)
        return begin, end, said

    def _ring(self, first: int, last: int, bad: Flags) -> tuple[int, int]:
        """The legs that are no leads: those that close, with the longest leads that may be.

        Where nothing closes, what lies off the contours is taken for the leads.
        """
        lengths, starts, ends = self.path.lengths, self.path.starts, self.path.ends
        most_in, most_out = self._most(self.torch.lead_in), self._most(self.torch.lead_out)
        begin, end = first, last
        while begin < last - 1 and lengths[first : begin + 1].sum() <= most_in:
            begin += 1
        while end > first + 1 and lengths[end - 1 : last].sum() <= most_out:
            end -= 1
        for low in range(begin, first - 1, -1):
            for high in range(end, last + 1):
                if low < high and np.hypot(*(starts[low] - ends[high - 1])) <= 2 * self.step:
                    return low, high
        while begin > first and not bad[begin - 1]:
            begin -= 1
        while end < last and not bad[end]:
            end += 1
        return (begin, end) if begin < end else (first, last)

    def _most(self, length: float) -> float:
        return length * 1.001 + 4 * self.step

    def _lead(self, low: int, high: int, half_kerf: float) -> list[Diagnostic]:
        """Whether a lead keeps off the part, its last tenth before the contour aside."""
        if low == high:
            return []
        points, _, leg, _ = samples(
            Ways([g.curve or Line(g.start, g.end) for g in self.legs[low:high]], self._fine), 0.2
        )
        away, _ = self.need.nearest(points)
        bites = np.flatnonzero(away < 0.85 * half_kerf - self.tolerance)
        if not len(bites):
            return []
        x, y = points[bites[0]]
        length = float(self.path.lengths[low:high].sum())
        return [
            rules.LEAD.at(
                Source(self.name, self.legs[low + int(leg[bites[0]])].line),
                found=f"{length:.3f}", x=f"{x:.3f}", y=f"{y:.3f}",
                expected=f"it at least {half_kerf:g} mm off the part",
            )
        ]  # fmt: skip

    def _trace(self, stroke: Stroke, first: int, last: int, half_kerf: float) -> _Traced:
        start, end = self.path.starts[first], self.path.ends[last - 1]
        closed = bool(np.hypot(*(end - start)) <= 2 * self.tolerance)
        polygon = None
        if closed:
            rings = [shapely.get_coordinates(line) for line in self.path.lines[first:last]]
            ring = np.concatenate(rings)
            if len(ring) > 3:
                polygon = shapely.make_valid(shapely.Polygon(ring))
        return _Traced(stroke, first, last, half_kerf, closed, polygon, stroke.line)

    def _ends(self) -> list[Diagnostic]:
        """Strokes that begin or end in the middle of a contour."""
        said: list[Diagnostic] = []
        opened = [t for t in self.traced if not t.closed]
        if not opened:
            return said
        branches = _Branches(self.need, self.tolerance)
        starts = np.array([self.path.starts[t.first] for t in opened])
        stops = np.array([self.path.ends[t.last - 1] for t in opened])
        for k, t in enumerate(opened):
            for what, place, others, line in (
                ("begins", starts[k], stops, t.first),
                ("ends", stops[k], starts, t.last - 1),
            ):
                if branches.at(place) != 2 or self._is_tab(place, others, t):
                    continue
                said.append(
                    rules.OPEN.at(
                        Source(self.name, self.legs[line].line), what=what,
                        x=f"{place[0]:.3f}", y=f"{place[1]:.3f}",
                    )
                )  # fmt: skip
        return said[:SHOWN]

    def _is_tab(self, place: Floats, others: Floats, t: _Traced) -> bool:
        """Whether a bridge begins here: another stroke goes on behind it."""
        if not (self.torch.tabs and self.process == "cut"):
            return False
        away = np.hypot(*(others - place).T)
        return bool(np.min(away) <= self._tab_width(t.half_kerf))

    def _tab_width(self, half_kerf: float) -> float:
        return self.torch.tab_width + 2 * half_kerf + 2 * self.tolerance

    # What the part needs.

    def _contours(self) -> list[Diagnostic]:
        points, normal, owner, _ = samples(self.need, SPACING)
        slack = self.tolerance + self.free[owner]
        chosen = points.copy()
        away, leg = self._near(chosen)
        done = away <= slack
        stroke_radius = np.array([t.half_kerf for t in self.traced])
        for radius in np.unique(stroke_radius[stroke_radius > 0.0]).tolist():
            best, place, who = np.full(len(points), np.inf), points.copy(), leg.copy()
            for sign in (1.0, -1.0):
                beside = points + sign * radius * normal
                d, near = self._near(beside)
                nearer = d < best
                best[nearer], place[nearer], who[nearer] = d[nearer], beside[nearer], near[nearer]
            new = ~done & (best <= slack)
            chosen[new], leg[new] = place[new], who[new]
            done |= new
            rest = np.flatnonzero(~done)
            if len(rest):
                room, _ = self.need.nearest(place[rest])
                blocked = (room < radius - slack[rest] / 2) & (away[rest] <= 4 * radius)
                done[rest[blocked]] = True
                leg[rest[blocked]] = -1
        said: list[Diagnostic] = []
        missing = np.flatnonzero(~done)
        missing = missing[~self._in_tabs(points[missing])] if len(missing) else missing
        _, firsts = np.unique(owner[missing], return_index=True)
        said += [self._missing(points[k]) for k in missing[firsts][:SHOWN]]
        covered = np.flatnonzero(done & (leg >= 0))
        said += self._sides(points[covered], leg[covered])
        said += self._twice(points, chosen, owner, slack, covered)
        return said

    def _near(self, points: Floats) -> tuple[Floats, Counts]:
        return self.path.nearest(points, self._most_half_kerf() + self.tolerance)

    def _in_tabs(self, points: Floats) -> Flags:
        """Which points lie in a bridge: between the end of a stroke and the start of another."""
        if not (self.torch.tabs and self.process == "cut"):
            return np.zeros(len(points), dtype=bool)
        opened = [t for t in self.traced if not t.closed]
        inside = np.zeros(len(points), dtype=bool)
        starts = np.array([self.path.starts[t.first] for t in opened])
        for t in opened:
            end = self.path.ends[t.last - 1]
            away = np.hypot(*(starts - end).T)
            k = int(np.argmin(away))
            width = self._tab_width(t.half_kerf)
            if away[k] <= width:
                middle = (starts[k] + end) / 2
                near = np.hypot(*(points - middle).T) <= width / 2 + t.half_kerf + self.tolerance
                inside |= near
        return inside

    def _sides(self, points: Floats, leg: Counts) -> list[Diagnostic]:
        """Contours that lie on the wrong side of the path beside them."""
        polygons = [t.polygon for t in self.traced]
        depths = _depths(polygons)
        said: list[Diagnostic] = []
        stroke = self.leader[self.of_leg[leg]]
        for k, t in enumerate(self.traced):
            if t.polygon is None:
                continue
            is_hole = depths[k] % 2 == 1
            if self.torch.kerf_by == "machine" and self.process == "cut":
                said += self._kept_side(t, is_hole)
            if t.half_kerf == 0.0:
                continue
            mine = points[stroke == k]
            if not len(mine):
                continue
            inside = shapely.contains_xy(t.polygon, mine)
            if np.any(inside == is_hole):
                x, y = mine[np.flatnonzero(inside == is_hole)[0]]
                source = Source(self.name, t.stroke.line)
                said.append(rules.SIDE.at(source, x=f"{x:.3f}", y=f"{y:.3f}"))
        return said[:SHOWN]

    def _kept_side(self, t: _Traced, is_hole: bool) -> list[Diagnostic]:
        """Whether the controller is told to keep on the side of the waste, by half the kerf."""
        ring = np.concatenate(
            [shapely.get_coordinates(line) for line in self.path.lines[t.first : t.last]]
        )
        left_turning = bool(shapely.is_ccw(shapely.LinearRing(ring)))
        expected = "left" if left_turning == is_hole else "right"
        half = t.stroke.row.kerf / 2
        if not half or (t.stroke.side == expected and abs(t.stroke.radius - half) <= 1e-4):
            return []
        return [
            rules.TOOL.at(
                Source(self.name, t.stroke.line),
                found=f"compensation {t.stroke.side} by {t.stroke.radius:g}",
                expected=f"{expected} by {half:g}",
            )
        ]

    def _twice(
        self, points: Floats, chosen: Floats, owner: Counts, slack: Floats, covered: Counts
    ) -> list[Diagnostic]:
        """Stretches of a contour that have more than one path."""
        long = covered[self.need.lengths[owner[covered]] > 8 * self.tolerance]
        if not len(long):
            return []
        reach = float(np.max(slack[long]))
        sample, leg = self.path.within(chosen[long], reach)
        kept = self.on_contour[leg]
        sample, leg = sample[kept], leg[kept]
        counts = np.bincount(sample, minlength=len(long))
        several = np.flatnonzero(counts > 1)
        if not len(several):
            return []
        picked = np.isin(sample, several)
        sample, leg = sample[picked], leg[picked]
        at = self.path.begins[leg] + self.path.along(chosen[long][sample], leg)
        passes = _passes(sample, at, self.of_leg[leg], 6 * reach, len(long))
        doubtful = np.flatnonzero(passes > 1)
        if not len(doubtful):
            return []
        # Contours that run beside one another have a path each.
        who, _ = self.need.within(points[long][doubtful], 2 * reach)
        allowed = np.bincount(who, minlength=len(doubtful))
        doubtful = doubtful[passes[doubtful] > allowed]
        ways = owner[long][doubtful]
        said: list[Diagnostic] = []
        for way in np.unique(ways)[:SHOWN]:
            mine = np.sort(long[doubtful[ways == way]])
            if len(mine) < 2 or np.min(np.diff(mine)) > 1:
                continue
            x, y = points[mine[0]] - np.array(self.shift)
            worst = int(np.max(passes[doubtful[ways == way]]))
            source = Source(self.name, None)
            said.append(rules.TWICE.at(source, x=f"{x:.3f}", y=f"{y:.3f}", found=worst))
        return said

    def _extra(self, line: int, x: float, y: float, away: str, expected: str) -> Diagnostic:
        return rules.EXTRA.at(
            Source(self.name, line), x=f"{x:.3f}", y=f"{y:.3f}", away=away,
            process=self.process, expected=expected,
        )  # fmt: skip

    def _missing(self, place: Floats) -> Diagnostic:
        x, y = place - np.array(self.shift)
        return rules.MISSING.at(
            Source(self.name), process=self.process, x=f"{x:.3f}", y=f"{y:.3f}",
            machine_x=f"{place[0]:.3f}", machine_y=f"{place[1]:.3f}",
        )  # fmt: skip


class _Branches:
    """Where contours end, and in how many directions they go on from there."""

    def __init__(self, need: Ways, reach: float) -> None:
        apart = np.hypot(*(need.ends - need.starts).T) > 1e-9
        lines, lengths = need.lines[apart], need.lengths[apart]
        near = np.minimum(lengths / 2, 20 * reach)
        places, inner = [], []
        for at, step in ((need.starts[apart], near), (need.ends[apart], lengths - near)):
            places.append(at)
            inner.append(shapely.get_coordinates(shapely.line_interpolate_point(lines, step)))
        self._places: Floats = np.concatenate(places)
        towards = np.concatenate(inner) - self._places
        self._angles = np.degrees(np.arctan2(towards[:, 1], towards[:, 0]))
        self._reach = reach
        self._tree = shapely.STRtree(shapely.points(self._places))

    def at(self, place: Floats) -> int:
        """Directions in which contours leave a place; 2 in the middle of one."""
        found = self._tree.query(shapely.Point(*place), "dwithin", distance=self._reach)
        if not len(found):
            return 2
        apart: list[float] = []
        for angle in self._angles[found].tolist():
            if all(abs((angle - a + 180.0) % 360.0 - 180.0) > SAME_DIRECTION_DEG for a in apart):
                apart.append(angle)
        return len(apart)


def _share(curve: Curve) -> float:
    """What of its length a free curve may be off, as the circle that it stands for."""
    pieces = len(bezier_pieces(curve)) if isinstance(curve, BSpline) else 1
    return CIRCLE_SHARE / pieces


def _passes(sample: Counts, at: Floats, stroke: Counts, apart: float, count: int) -> Counts:
    """How many separate ways of the path are near each sample.

    Places on the path that are farther apart along it than `apart` belong to different ways.
    """
    order = np.lexsort((at, stroke, sample))
    sample, at, stroke = sample[order], at[order], stroke[order]
    new = np.ones(len(sample), dtype=bool)
    new[1:] = (sample[1:] != sample[:-1]) | (stroke[1:] != stroke[:-1])
    new[1:] |= at[1:] - at[:-1] > apart
    found: Counts = np.bincount(sample[new], minlength=count)
    return found


def _depths(polygons: Sequence[object]) -> list[int]:
    """How many other polygons each lies in."""
    known = [k for k, p in enumerate(polygons) if p is not None]
    depths = [0] * len(polygons)
    if not known:
        return depths
    shapes = cast("NDArray[np.object_]", np.array([polygons[k] for k in known], dtype=object))
    areas = shapely.area(shapes)
    inner, outer = shapely.STRtree(shapes).query(shapely.point_on_surface(shapes), "within")
    for a, b in zip(inner.tolist(), outer.tolist(), strict=True):
        if a != b and areas[a] < areas[b]:
            depths[known[a]] += 1
    return depths


def _order(traced: Sequence[_Traced], name: str) -> list[Diagnostic]:
    """Marks behind cuts, and what lies in a contour that was cut before."""
    said: list[Diagnostic] = []
    first_cut = next((t for t in traced if t.stroke.process == "cut"), None)
    for t in traced:
        if first_cut and t.stroke.process != "cut" and t.stroke.line > first_cut.stroke.line:
            said.append(
                rules.ORDER.at(
                    Source(name, t.stroke.line), found=f"work to {t.stroke.process}",
                    before=f"the cut on line {first_cut.stroke.line}",
                )
            )  # fmt: skip
            break
    cuts = [t for t in traced if t.stroke.process == "cut"]
    rings = [k for k, t in enumerate(cuts) if t.polygon is not None]
    if not rings:
        return said
    polygons = np.array([cuts[k].polygon for k in rings], dtype=object)
    middles = [t.stroke.legs[len(t.stroke.legs) // 2].end for t in cuts]
    inner, outer = shapely.STRtree(polygons).query(shapely.points(np.array(middles)), "within")
    for a, b in zip(inner.tolist(), outer.tolist(), strict=True):
        if rings[b] < a and cuts[a].group != cuts[rings[b]].group:
            said.append(
                rules.ORDER.at(
                    Source(name, cuts[a].stroke.line), found="an inner contour",
                    before=f"the one around it on line {cuts[rings[b]].stroke.line}",
                )
            )  # fmt: skip
    return said[:SHOWN]
