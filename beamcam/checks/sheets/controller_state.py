"""What holds in a table's controller while its tools are on: compensation, blending, ramps.

Compensation is switched on where a stroke begins and off where it ends: a controller refuses it
twice, and a traverse beside the path starts the next stroke elsewhere. How far corners may be
passed, and how the head runs up and brakes, is said before the first stroke.
"""

from collections.abc import Collection, Iterator, Sequence
from math import degrees, inf

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.beside import beside_faults
from beamcam.checks.sheets.chart_rows import thickness_of
from beamcam.checks.sheets.need import OUTLINE, Need, need_of
from beamcam.checks.sheets.required_layout import between, header_outline, kerf_on
from beamcam.checks.sheets.skew_edges import skew_ends
from beamcam.controllers.events import Acceleration, Blending, Compensation, Side
from beamcam.controllers.moves import Moves
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.geometry.array_types import Flags, Floats
from beamcam.geometry.curves import Bezier, EllipseArc, Line
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine, PathLimits, path_limits
from beamcam.machine.torch import Torch, TorchRow, material_said
from beamcam.model.part import Contour, Feature, Measures, Part, extent, moved_feature

# --- ability --------------------------------------------------------------------------------------

# Expected feed of a move in programs that set the controller's accelerations.
#
# The feed of the machine's row, or the greatest one that the axes can follow: on the smallest
# radius of the curve the acceleration across is v^2 / r and the jerk v^3 / r^2.


SECONDS_PER_MINUTE = 60.0
FLAT = 1e-12


def told_limits(machine: Machine) -> PathLimits | None:
    """The limits of a machine whose programs have to give accelerations; None of others."""
    told = any("{acceleration}" in word for word in machine.words.modal)
    return path_limits(machine) if told else None


def expected_feeds(moves: Moves, asked_mm_min: Floats, limits: PathLimits) -> Floats:
    """The feed in mm/min that each move should have, at most what is asked for it, (n,)."""
    feeds = asked_mm_min / SECONDS_PER_MINUTE
    radius = np.where(moves.is_arc, moves.arcs[:, 2], inf)
    for k, curve in moves.curves.items():
        radius[k] = _min_radius(curve)
    turning = np.minimum(
        np.sqrt(limits.across_mm_s2 * radius), np.cbrt(limits.jerk_mm_s3 * radius**2)
    )
    straight = ~moves.is_arc
    straight[list(moves.curves)] = False
    greatest = np.where(
        straight, _straight_mm_s(moves, limits), np.minimum(limits.speed_mm_s, turning)
    )
    greatest[straight & (feeds <= limits.speed_mm_s)] = inf
    return np.where(greatest < feeds, greatest * SECONDS_PER_MINUTE, asked_mm_min)


def _straight_mm_s(moves: Moves, limits: PathLimits) -> Floats:
    """The maximum speed of both axes along each chord; inf where it has no length."""
    ways = np.abs(moves.end - moves.start)
    length = np.hypot(ways[:, 0], ways[:, 1])
    speeds = np.array([limits.speed_x_mm_s, limits.speed_y_mm_s])
    reached = np.divide(
        length[:, None] * speeds, ways, out=np.full(ways.shape, inf), where=ways > 0.0
    )
    straight_mm_s: Floats = reached.min(axis=1, initial=inf)
    return straight_mm_s


def _min_radius(curve: Bezier | EllipseArc) -> float:
    """The minimum radius of a parabola; of an ellipse that at the ends of its main axis."""
    if isinstance(curve, EllipseArc):
        return curve.major * curve.ratio**2
    # The curvature |f' x f''| / |f'|^3 is greatest where f' = 2 (a + t b) is shortest: at the
    # vertex, or at the end that is nearer to it.
    (x0, y0), (x1, y1), (x2, y2) = curve.points
    ax, ay, bx, by = x1 - x0, y1 - y0, x2 - 2 * x1 + x0, y2 - 2 * y1 + y0
    if ax * by == ay * bx:
        return inf
    vertex = -(ax * bx + ay * by) / (bx * bx + by * by)
    bend = abs(curve.curvature(min(max(vertex, 0.0), 1.0)))
    return 1.0 / bend if bend > FLAT else inf


SLACK = 1e-3  #: share of an acceleration
BLENDED_SLACK = 1e-6  #: mm

Setting = Compensation | Blending | Acceleration


class ControllerState:
    """The settings of a controller while its program runs; moves are counted from the first."""

    def __init__(self, machine: Machine, torch: Torch, name: str) -> None:
        self.side: Side = "on"
        self.radius = 0.0
        self.limits = told_limits(machine)
        self._name = name
        self._kerf_by, self._corner = torch.kerf_by, torch.corner
        self._blends = machine.controller == "linuxcnc"
        self._blended: int | None = None  #: moves before it was first said
        self._ramps: set[bool] = set()
        self._ramped: int | None = None  #: moves before both ramps were given
        self._beside_since = -1  #: moves before compensation was switched on

    def _fault(self, rule: Rule, line: int, found: str, expected: str) -> Diagnostic:
        return rule.at(Source(self._name, line), found=found, expected=expected)

    def take(self, event: Setting, before: int, is_on: bool, ended: int) -> Iterator[Diagnostic]:
        """What is wrong with a setting; `before` moves of it, the last stroke ended at `ended`."""
        if isinstance(event, Blending):
            self._blended = before if self._blended is None else self._blended
            yield from self._blending(event.line, event.distance)
        elif isinstance(event, Acceleration):
            yield from self._ramp(event, before)
        else:
            yield from self._compensation(event, before, is_on, ended)

    def _compensation(
        self, event: Compensation, before: int, is_on: bool, ended: int
    ) -> Iterator[Diagnostic]:
        found = ""
        if is_on:
            found, expected = "compensation with the tool on", "it before"
        elif event.side != "on" and self._kerf_by != "machine":
            # The path keeps half a kerf off already, or none is asked for.
            found = f"compensation by {event.radius:g} mm to the {event.side}"
            expected = f"none, as torch.kerf_by is {self._kerf_by!r}"
        elif event.side != "on" and self.side != "on":
            found, expected = "compensation that is on already", "it off behind each stroke"
        elif event.side == "on" and self.side != "on" and before != ended:
            found, expected = "a traverse with compensation", "it off behind the stroke"
        self.side, self.radius, self._beside_since = event.side, event.radius, before
        if found:
            yield self._fault(rules.TOOL, event.line, found, expected)

    def starts(self, line: int, before: int) -> Iterator[Diagnostic]:
        """What is wrong when a tool starts behind so many moves."""
        if self.side != "on" and before != self._beside_since:
            expected = "it on where the stroke begins"
            yield self._fault(rules.TOOL, line, "a traverse with compensation", expected)

    def ends(self, line: int) -> Iterator[Diagnostic]:
        """What is wrong when the program ends."""
        if self.side != "on":
            expected = "it off behind the last stroke"
            yield self._fault(rules.TOOL, line, "the end with compensation", expected)

    def _blending(self, line: int, distance: float) -> Iterator[Diagnostic]:
        """Whether the controller passes corners as the machine's file says."""
        if abs(distance - self._corner) > BLENDED_SLACK:
            on, off = ("G64 P", "G61") if self._blends else ("G52 D", "G50")
            asked = f"{on}{self._corner:g}" if self._corner else off
            found = f"{distance:g} mm" if distance < inf else "any distance"
            expected = f"{asked}, as torch.corner is {self._corner:g}"
            yield self._fault(rules.CORNER, line, found, expected)

    def _ramp(self, event: Acceleration, before: int) -> Iterator[Diagnostic]:
        self._ramps.add(event.braking)
        if self._ramped is None and len(self._ramps) == 2:
            self._ramped = before
        allowed = self.limits.along_mm_s2 if self.limits is not None else 0.0
        if abs(event.mm_s2 - allowed) > SLACK * allowed:
            expected = f"{allowed:g} mm/s2" if allowed else "none, the machine has no limit"
            what = "to brake" if event.braking else "to run up"
            yield self._fault(rules.RAMP, event.line, f"{event.mm_s2:g} mm/s2 {what}", expected)

    def unsaid(self, line: int, before: int) -> Iterator[Diagnostic]:
        """What was not said before the first move with a tool on, which stands on a line."""
        if self._blends and (self._blended is None or self._blended > before):
            yield from self._blending(line, inf)
        if self.limits is not None and (self._ramped is None or self._ramped > before):
            expected = f"{self.limits.along_mm_s2:g} mm/s2 to run up and to brake"
            yield self._fault(rules.RAMP, line, "no E word before the first move", expected)


# --- shared ---------------------------------------------------------------------------------------

# Parts that share a sheet, each at the place where the machine lays it, as one part to compare.
#
# Where each lies follows from the parts in the order given and the machine's table alone: in rows
# from the lower left corner, `margin` to the edges and `spacing` from box to box.


SKELETON = "skeleton"  #: where the cuts through what is left of a sheet are said to be


class SharedSheet(Struct, frozen=True):
    """One part with all that has to be on a sheet, and the machine that leaves it there."""

    part: Part
    machine: Machine
    places: list[Point]  #: of the x 0, y 0 of each of several parts
    diagnostics: list[Diagnostic]


def as_one(parts: Sequence[Part], machine: Machine, skips: Collection[str]) -> SharedSheet:
    """The parts of a sheet as one, and what is wrong with their sharing it.

    A part that is alone stays as it is.
    """
    torch = machine.torch
    off = [*skew_ends(parts, machine), *beside_faults(parts)]
    if torch is None or len(parts) == 1:
        return SharedSheet(parts[0], machine, [], off)
    features: list[Feature] = []
    diagnostics = off + [
        rules.OTHER_SHEET.at(
            part.source, found=_shown(part, torch), expected=_shown(parts[0], torch)
        )
        for part in parts[1:] if _shown(part, torch) != _shown(parts[0], torch)
    ]  # fmt: skip
    tops: dict[float, float] = {}  #: upper edge of each row of parts, by its lower one
    lie = list(_places(parts, machine, torch, skips))
    for part, (here, need) in zip(parts, lie, strict=True):
        _, low, _, high = _box(need)
        row = round(here[1] + low, 6)
        tops[row] = max(tops.get(row, row), here[1] + high)
        features += [moved_feature(feature, here) for feature in part.features]
        if any(OUTLINE in some for some in need.features.values()):
            outline = Contour("v", "outer", tuple(header_outline(part)), part.source)
            features.append(moved_feature(outline, here))
    half = between(parts[0], torch) / 2
    if torch.skeleton_cuts and half > kerf_on(parts[0], torch):
        for y in (t + half for t in tops.values() if t + half < torch.width - torch.margin / 2):
            line = Line((torch.length, y), (0.0, y))
            source = replace(parts[0].source, where=SKELETON, line=None)
            features.append(Contour("v", "open", (line,), source, closed=False))
    whole = replace(parts[0], features=tuple(features), measures=Measures(), length=torch.length)
    machine = replace(machine, torch=replace(torch, place="drawn"))
    return SharedSheet(whole, machine, [place for place, _ in lie], diagnostics)


def _places(
    parts: Sequence[Part], machine: Machine, torch: Torch, skips: Collection[str]
) -> Iterator[tuple[Point, Need]]:
    """Where each of several parts lies on the table, its x 0, y 0; and what of it has to be cut."""
    left = bottom = torch.margin
    spacing = between(parts[0], torch)
    top = bottom
    needs: dict[int, Need] = {}  #: many are the same part
    for part in parts:
        if id(part) not in needs:
            needs[id(part)] = need_of(part, machine, torch, skips)
        need = needs[id(part)]
        x0, y0, x1, y1 = _box(need)
        if left + (x1 - x0) > torch.length - torch.margin and top > bottom:
            left, bottom = torch.margin, top + spacing
            top = bottom
        yield (left - x0, bottom - y0), need
        left, top = left + (x1 - x0) + spacing, max(top, bottom + (y1 - y0))


def _box(need: Need) -> tuple[float, float, float, float]:
    return extent(c for some in need.curves.values() for c in some) or (0.0, 0.0, 0.0, 0.0)


def _shown(part: Part, torch: Torch) -> str:
    return (
        f"{thickness_of(part, torch):.2f} mm {material_said(part.grade, torch.material)}".rstrip()
    )


# --- corner feeds ---------------------------------------------------------------------------------

# What of a path is near its corners, where the tool has to be slower.
#
# Corners are looked for in the path as it is written. A place where it turns by nearly the angle
# of the row, or beside moves so short that rounding turns them, may count as one or not; so may
# what is as far from a corner as the row's distance.


DOUBT_DEG = 1.0
LONG_MOVE = 0.1  #: mm: the direction of a shorter move is in doubt
EDGE_MM = 0.05  #: mm by which the stretch that is near a corner may be longer or shorter


class NearCorners(Struct, frozen=True):
    """Of each move, whether it has to be slow, and whether it must not be; neither: either way."""

    slow: Flags
    fast: Flags


def near_corners(moves: Moves, row: TorchRow, step: float) -> NearCorners:
    """What of the moves of one stroke is near a corner; `step` is that of its numbers, in mm."""
    lengths, enters, leaves = _measures(moves)
    real = np.flatnonzero(lengths > 0.0)
    behind = np.cumsum(lengths)
    sure: list[float] = []
    maybe: list[float] = []
    for a, b in zip(real[:-1].tolist(), real[1:].tolist(), strict=True):
        turn = turn_deg(leaves[a], enters[b])
        short = min(lengths[a], lengths[b])
        doubt = DOUBT_DEG + 2 * degrees(2 * step / short)
        if turn > row.corner_angle - doubt:
            maybe.append(float(behind[a]))
        if turn > row.corner_angle + doubt and short >= LONG_MOVE:
            sure.append(float(behind[a]))
    long = real[lengths[real] >= LONG_MOVE]
    for a, b in zip(long[:-1].tolist(), long[1:].tolist(), strict=True):
        if b > a + 1 and turn_deg(leaves[a], enters[b]) > row.corner_angle - 2 * DOUBT_DEG:
            maybe += behind[a:b].tolist()  # round a corner in moves that are too short
    reach = row.corner_distance
    begins = behind - lengths
    inside = _covered(begins, behind, sure, reach - EDGE_MM)
    outside = lengths - _covered(begins, behind, maybe, reach + EDGE_MM)
    return NearCorners(inside > EDGE_MM / 100, outside > EDGE_MM / 100)


def _measures(moves: Moves) -> tuple[Floats, Floats, Floats]:
    """The length of each move, and its directions where it begins and where it ends."""
    way = moves.end - moves.start
    lengths = np.hypot(way[:, 0], way[:, 1])
    size = np.where(lengths > 0.0, lengths, 1.0)[:, None]
    enters, leaves = way / size, way / size
    arcs = np.flatnonzero(moves.is_arc)
    if len(arcs):
        radius, first, sweep = moves.arcs[arcs, 2:5].T
        lengths[arcs] = radius * np.abs(np.radians(sweep))
        for angles, angle in ((enters, first), (leaves, first + sweep)):
            rad = np.radians(angle)
            angles[arcs] = np.sign(sweep)[:, None] * np.column_stack((-np.sin(rad), np.cos(rad)))
    for k, curve in moves.curves.items():
        lengths[k], enters[k], leaves[k] = curve.length, curve.tangent(0.0), curve.tangent(1.0)
    return lengths, enters, leaves


def turn_deg(one: Floats, other: Floats) -> float:
    """The angle between two directions."""
    return float(np.degrees(np.arccos(np.clip(np.dot(one, other), -1.0, 1.0))))


def _covered(begins: Floats, ends: Floats, corners: Sequence[float], reach: float) -> Floats:
    """How much of each move, from where it begins to where it ends, is so near to a corner."""
    covered = np.zeros(len(begins))
    last = -np.inf
    for place in sorted(corners):
        low, high = max(place - reach, last), place + reach
        covered += np.clip(np.minimum(ends, high) - np.maximum(begins, low), 0.0, None)
        last = max(last, high)
    return covered


# --- radii ----------------------------------------------------------------------------------------

# Arcs of a program that its controller does not take.


EPSILON = 1e-6
ROUNDED_STEPS = 4  #: of the program's numbers, by which three rounded places change a radius


def radius_faults(moves: Moves, machine: Machine, torch: Torch, name: str) -> Iterator[Diagnostic]:
    """Arcs below the least radius of the machine or above its greatest.

    The radius is that from the start to the centre. An arc of just the greatest comes out larger
    by what both ends and the centre are rounded to.
    """
    radius, slack = moves.arcs[:, 2], ROUNDED_STEPS * machine.format.resolution
    odd = (radius < torch.min_radius - EPSILON) | (radius > torch.max_radius + slack)
    for k in np.flatnonzero(moves.is_arc & odd).tolist():
        x, y = moves.end[k].tolist()
        yield rules.RADIUS.at(
            Source(name, int(moves.line[k])), found=f"{radius[k]:.6g}", x=f"{x:g}", y=f"{y:g}",
            least=f"{torch.min_radius:g}", greatest=f"{torch.max_radius:g}",
        )  # fmt: skip
