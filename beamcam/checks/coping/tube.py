"""Programs of tubes that turn under a torch, read back on the unrolled surface.

The torch stands upright over the tube, whose axis is Y 0, Z 0, and square to the place below it. A
block of inverse time turns the tube and moves along it and across evenly, so that its way on the
surface is straight; of a round tube a place on top at A lies at u = R (90 - A) of arc.
"""

from collections.abc import Iterator, Sequence
from math import dist, hypot, pi, radians
from typing import Any

import numpy as np
from msgspec.structs import replace
from shapely import LineString, MultiPoint, box, prepare, union_all
from shapely import Point as PointShape
from shapely.affinity import translate

from beamcam.checks.coping import rules
from beamcam.checks.coping.box_tube import LEAST_OFF, RequiredTube, box_ends, required_box
from beamcam.checks.coping.chart import CoperJob
from beamcam.checks.coping.collisions import collision_faults, turned_unseen
from beamcam.checks.coping.left import hurt_fault, kept_faults, parted
from beamcam.checks.coping.required_wall import corners_of, with_corners_cut
from beamcam.checks.coping.section import TubeSection, areas_of, kerf_of, line_of
from beamcam.checks.coping.stock import FINE, inside_of, is_through, outline_ring, ring_of, taken
from beamcam.checks.coping.strokes import (
    HEIGHT_SLACK,
    MIDDLE_SLACK,
    TipMove,
    TorchFollower,
    TorchStroke,
    in_air,
)
from beamcam.checks.coping.tube_ends import (
    AIR,
    PieceAsked,
    TubeStock,
    bar_of,
    header_planes,
    is_end,
    kept,
    piece_of,
    planes_of,
    round_ends,
    short_by,
    with_air,
)
from beamcam.checks.coping.zones import chuck_faults, seam_faults, support_faults
from beamcam.checks.job import manual_work
from beamcam.controllers.events import BarEvent, Move, Place
from beamcam.errors import Diagnostic, errors_in
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, EndCuts, EndPlane, Hole, Part, Slot

Shape = Any  #: of shapely

SHARES = (0.25, 0.5, 0.75)  #: of a block, where the torch is looked at besides its ends
SPEED_SHARE = 0.01  #: of a block's way that its time may be off by, besides how it is written
HOLE_STEPS = 121
TWICE = 0.1  #: share of a stroke that is new at least, or it is cut twice


class TubeTorch(TorchFollower):
    """An upright torch over a tube."""

    turning = True

    def __init__(self, job: CoperJob, section: TubeSection) -> None:
        fits = job.row_for(section.wall)
        super().__init__(replace(job, rows=(fits, *job.rows)) if fits else job)
        self._section = section
        #: mm that a way may be off as its ends are written
        self._written = 2 * written_step(job.machine, section)

    @property
    def sizes(self) -> tuple[float, float]:
        return 2 * self._section.half_y, 2 * self._section.half_z

    def _as_written(self, a_deg: float) -> float:
        """A in the unit of the program: mm of the surface are those of a round tube."""
        if self._coper.a_unit == "mm":
            return self._section.radius * radians(90.0 - a_deg)
        return a_deg

    def _take(self, line: int, moves: Sequence[Move[Place]]) -> None:
        source, place = self._job.at(line), self._section.place
        first = (*moves[0].start, moves[0].a_deg[0])  # each other begins where the one before ends
        tips = np.array([first, *((*move.end, move.a_deg[1]) for move in moves)])
        starts, ends = tips[:-1], tips[1:]
        s, over, beside = place(*tips[:, 1:].T)
        on_ways = starts + np.array(SHARES)[:, None, None] * (ends - starts)  # all go evenly
        _, over_ways, beside_ways = place(*np.moveaxis(on_ways[:, :, 1:], 2, 0))
        worst = np.abs(beside).max(), np.abs(beside_ways).max()
        if worst[0] > HEIGHT_SLACK or worst[1] > MIDDLE_SLACK:
            found, expected = f"{max(worst):.2f}", f"{HEIGHT_SLACK:g}"
            self._say(rules.SQUARE.at(source, found=found, expected=expected))
            return
        xs = tips[:, 0] - self._coper.trim
        points: list[Point] = [*zip(xs.tolist(), s.tolist(), strict=True)]
        ways = np.linalg.norm(np.diff(np.column_stack((xs, s, over)), axis=0), axis=1)
        minutes, slack = np.array([m.minutes for m in moves]), SPEED_SHARE * ways + self._written
        row = next(
            (one for one in self._job.rows
             if (np.abs(ways - one.feed_mm_min * minutes) <= slack).all()),
            None,
        )  # fmt: skip
        if row is None:
            shown = min((w / m.minutes if m.minutes else m.feed_mm_min)
                        for w, m in zip(ways.tolist(), moves, strict=True))  # fmt: skip
            of_chart = ", ".join(f"{one.feed_mm_min:g}" for one in self._job.rows)
            self._say(
                rules.FEED.at(source, found=f"{shown:.0f}", thickness="steel", expected=of_chart)
            )
            return
        face = self._section.face_at(points[1][1])
        between = over_ways[:, 1:].ravel().tolist()
        self._heights(source, face, row, over.tolist(), between)
        if dist(points[0], points[1]) > HEIGHT_SLACK:
            self._wrong(line, "a slanting way down to the steel", "one straight along the torch")
        places = tuple((m.end[1], m.end[2]) for m in moves)
        self.strokes.append(TorchStroke(line, face, tuple(points[1:]), places, row))


def written_step(machine: Machine, section: TubeSection) -> float:
    """mm on the surface that figures are rounded to."""
    form, coper = machine.format, machine.coper
    step = 10.0**-form.angle_decimals
    if coper is not None and coper.a_unit == "mm":
        return form.resolution + step
    return form.resolution + section.reach * radians(step)


def tube_section(part: Part, coper: Coper) -> TubeSection:
    """The section of a tube; corners whose radius a part does not say are those of the machine.

    A part says none that is less than its wall; of the machine's table the thinnest row counts that
    the wall does not exceed.
    """
    profile, radius = part.profile, part.profile.radius
    wall = max(profile.flange_thickness, profile.web_thickness or 0.0)
    if radius < wall:
        thick = [(row.up_to, row.share * wall) for row in coper.corners if row.up_to >= wall]
        radius = coper.corner if coper.corner > 0.0 else min(thick, default=(0.0, radius))[1]
    return TubeSection(profile, radius)


def tube_faults(events: Sequence[BarEvent], job: CoperJob, left: set[int]) -> list[Diagnostic]:
    """All that a program makes otherwise than a tube, and what is wrong on its way.

    Outlines that a square cut leaves skew, and bevels, are on the list of manual work.
    """
    part, coper, name = job.part, job.coper, job.name
    section = tube_section(part, coper)
    torch = TubeTorch(job, section)
    torch.follow(events)
    ways: Sequence[TipMove] = torch.ways
    if part.profile.code == "RO":  # which looks alike from everywhere round it
        ways = [replace(way, a_deg=(0.0, 0.0)) for way in ways]
    else:
        torch.diagnostics += turned_unseen(events, section, coper, name)
    diagnostics = [*torch.diagnostics, *collision_faults(ways, section, coper, name)]
    if errors_in(diagnostics):
        return diagnostics
    slack = coper.tolerance + 2 * written_step(job.machine, section) + FINE
    stock = bar_of(coper.trim, part, section.turn)
    if part.made is None:
        whole = _required(part, coper, left, section)
    else:
        whole, stock = _required_of_piece(part, coper, left, section)
    if whole.lost:
        return [*diagnostics, rules.LOST.at(part.source, found=whole.lost)]
    if whole.short[1]:
        face, far = whole.short
        return [*diagnostics, rules.SHORT.at(job.at(), found=f"{far:.2f}", face=face)]
    diagnostics += _compared(torch.strokes, whole, stock, section, slack, job)
    diagnostics += seam_faults(torch.strokes, section, slack, job)
    diagnostics += support_faults(torch.strokes, job)
    diagnostics += chuck_faults(torch.ways, job)
    for k, feature in enumerate(part.features):
        is_square, is_skew = False, isinstance(feature, EndPlane) and bool(whole.off)
        if isinstance(feature, Contour):
            is_square = any(abs(bevel.angle) >= coper.min_bevel for bevel in feature.bevels)
            is_skew = feature.kind == "outer" and feature.face in whole.off
        if is_square or (is_skew and k not in left):
            diagnostics.append(manual_work(feature, part, job.machine))
    return diagnostics


def _compared(
    strokes: Sequence[TorchStroke], whole: RequiredTube, stock: TubeStock, section: TubeSection,
    slack: float, job: CoperJob,
) -> Iterator[Diagnostic]:  # fmt: skip
    """What is left of the unrolled surface, on three turns one above the other."""

    drawn, expected, coper = whole.drawn, whole.cut, job.coper
    turn, wall = section.turn, section.wall
    fits = job.row_for(wall)
    kept = expected.buffer(-slack, join_style="mitre")
    edges = {row.kerf: expected.boundary.buffer(row.kerf / 2 + slack)
             for row in {stroke.row for stroke in strokes}}  # fmt: skip
    prepare([kept, *edges.values()])
    gone: list[Shape] = []
    bar = stock.steel.intersection(box(-1e6, -turn / 2, 1e6, 1.5 * turn))
    parting = False
    for stroke in strokes:
        source, half = job.at(stroke.line), stroke.row.kerf / 2
        us = [u for _, u in stroke.points]
        back = -turn * ((min(us) + slack) // turn)  # of its start into the first turn
        points = [(x, u + back) for x, u in stroke.points]
        run, kerf = line_of(points), kerf_of(points, half)
        burnt = union_all([kerf, PointShape(points[0]).buffer(stroke.row.pierce_radius)])
        if kept.intersects(burnt) and (hurt := burnt.intersection(kept)).area > 0.0:
            yield hurt_fault(hurt, kept, slack, source, section)
            return
        lead = _lead_of(points, coper.lead + half + stock.apart, slack)
        cut, near = line_of(points[lead:]), edges[stroke.row.kerf]
        if stock.is_piece:  # beside a skew end the kerf is in the air before the middle of the cut
            cut = cut.intersection(stock.steel.buffer(-half))
        if not near.covers(cut) and (off := cut.difference(near)).length > slack:
            x, u = off.representative_point().coords[0]
            yield rules.EXTRA.at(source, x=f"{x:.1f}", y=f"{u:.1f}", face=stroke.face)
            return
        before = [one for one in gone if one.intersects(run)]
        if before and run.difference(union_all(before)).length < TWICE * run.length:
            x, u = points[0]
            yield rules.EXTRA.at(source, x=f"{x:.1f}", y=f"{u:.1f}", face=stroke.face)
        # No arc starts over a hole that is there, nor lives in the air beside an end that is there.
        lost = stock.is_piece and (
            line_of(points[: lead + 1]).difference(stock.steel.buffer(half)).length > 0.0
            or in_air(points[lead:], stock.steel, stroke.row, coper) is not None
        )
        if lost or stock.solid.distance(PointShape(points[0])) > slack:
            yield rules.AIR.at(source, x=f"{points[0][0]:.1f}", y=f"{us[0]:.1f}", face=stroke.face)
        if fits is None or stroke.row.feed_mm_min != fits.feed_mm_min:
            yield rules.FEED.at(
                source, found=f"{stroke.row.feed_mm_min:g}", thickness=f"{wall:g}",
                expected=f"{fits.feed_mm_min:g}" if fits else "none",
            )  # fmt: skip
        is_far = not stock.is_piece and max(x for x, _ in points) > drawn.bounds[2]
        if parting and not is_far:
            yield rules.ORDER.at(source, face=stroke.face)
        parting = parting or is_far
        gone += [translate(kerf, 0.0, k * turn) for k in range(-3, 3)]
    gone = [one for one in gone if one.intersects(bar)]
    pieces = parted(bar, gone, drawn, slack)
    yield from kept_faults("v", pieces, expected, slack, job.name, section)


def _lead_of(points: Sequence[Point], most: float, slack: float) -> int:
    """How many blocks the lead has: one, or over a corner those that go straight on, so far."""
    lead = 1
    while (
        lead + 1 < len(points) and dist(points[0], points[lead + 1]) <= most
        and LineString([points[0], points[lead + 1]]).hausdorff_distance(
            MultiPoint(points[: lead + 2])) <= slack
    ):  # fmt: skip
        lead += 1
    return lead


def _required_of_piece(
    part: Part, coper: Coper, left: set[int], section: TubeSection
) -> tuple[RequiredTube, TubeStock]:
    """What has to stay of a piece, by its header and what is made of it, and the piece."""
    made = replace(part, features=tuple(filter(is_end, part.made or ())))
    through = tuple(f for f in part.made or () if is_end(f) or is_through(f))
    there = replace(part, features=through)
    bare, worn = (_required(one, coper, set(), section) for one in (made, there))
    if worn.lost:
        return worn, bar_of(coper.trim, part, section.turn)
    if part.profile.code == "M":
        faces, apart = box_ends(made, section)
    else:
        faces, apart = round_ends(made, bare.drawn, section)
    alone = replace(part, cuts=EndCuts())
    whole = _required(alone, coper, left, section, PieceAsked(bare.drawn, faces))
    return whole, piece_of(bare.drawn, worn.drawn, apart)


def _required(
    part: Part, coper: Coper, left: set[int], section: TubeSection, piece: PieceAsked | None = None
) -> RequiredTube:
    """What has to stay of the surface on three turns, without and with its corners rounded.

    `piece` is one that comes cut, whose features are asked of it.
    """
    if part.profile.code == "M":
        return required_box(part, coper, left, section, piece)
    by_header, planes = [*header_planes(part, section)], [*planes_of(part, left, section)]
    deep = section.wall * max((hypot(*e[1:]) for _, e in (*by_header, *planes)), default=0.0)
    off, turn = {"v": deep} if deep >= LEAST_OFF else {}, section.turn
    # An outline says more of an end than the header.
    features = [f for k, f in enumerate(part.features) if k not in left]
    outlines = [f for f in features if isinstance(f, Contour) and f.kind == "outer"]
    planes += [] if outlines else by_header
    ends, short, air = piece.faces["v"] if piece else None, 0.0, AIR if piece else 0.0
    one: Shape = box(-air, 0.0, part.length + air, turn)
    if outlines:
        rings = [outline_ring(c.curves, (0.0, turn), (), part.length / 2) for c in outlines]
        short = max(short_by(ring, ends) for ring in rings)
        one = union_all([with_air(ring, ends) for ring in rings])
        one = areas_of(one.intersection(box(-1e6, 0.0, 1e6, turn)))
    drawn = union_all([translate(one, 0.0, k * turn) for k in (-1, 0, 1)])
    for side, end in planes:
        drawn = kept(drawn, side, end, section)
    drawn = areas_of(drawn.intersection(piece.steel)) if piece else drawn
    corners = [p for c in outlines for p in corners_of(c.curves, drawn)]
    for feature in features:
        if isinstance(feature, Hole):
            # A drill through the axis meets the outside r sin t across it, R asin of it along u.
            r, turns = (
                min(feature.diameter / 2, section.radius),
                np.linspace(0.0, 2 * pi, HOLE_STEPS),
            )
            us = feature.y + section.radius * np.arcsin(r * np.sin(turns) / section.radius)
            gone = inside_of([*zip(feature.x + r * np.cos(turns), us, strict=True)])
        elif isinstance(feature, Slot):
            gone = taken(feature)
        elif isinstance(feature, Contour) and feature.kind == "inner":
            gone = with_air(ring_of(feature.curves), ends)
            corners += corners_of(feature.curves, drawn.difference(taken(feature)))
        else:
            continue
        drawn = drawn.difference(
            union_all([translate(gone, 0.0, k * turn) for k in (-2, -1, 0, 1, 2)])
        )
    drawn = areas_of(drawn)
    inner = [one for one in corners if ends is None or not ends.is_mouth(one)]
    cut = with_corners_cut(drawn, inner, coper.corner_radius, turn)
    return RequiredTube(drawn, cut, off, short=("v", short))
