"""The motion of a cutting table: each pass as moves in the numbers that will be written.

    pass -> free curves fitted with arcs -> arcs and ends rounded, centres solved again -> moves

Where the controller has words for parabolas and ellipses those are kept exact.

Where a path is near a corner, so that the tool moves slower there.

    distance   corner   distance
-----|---------->*
                 |         A corner is a place where the path turns by more than the row's
                 |         `corner_angle`; what of the path is no farther from it than
                 v         `corner_distance`, before and behind it, is near it.
                 -
                 |
"""

from collections.abc import Iterator, Sequence
from itertools import accumulate, groupby, pairwise, repeat
from math import acos, degrees, dist, hypot
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from beamcam.geometry.curves import Arc, Curve, EllipseArc, Line, bezier_pieces, parameter_at
from beamcam.geometry.plane import Point, dot
from beamcam.machine.machine import Machine, PathLimits, names_in, path_limits
from beamcam.machine.torch import TorchProcess, TorchRow
from beamcam.machine.words import PART_NAMES, WORK_WORDS
from beamcam.model.part import part_data
from beamcam.model.plan import ContourOp, SheetPlan
from beamcam.model.program import (
    ArcFeed,
    ChooseMaterial,
    ChooseTool,
    CloseCut,
    Command,
    Comment,
    Compensate,
    Feed,
    Movement,
    OfPart,
    PassEnd,
    Power,
    Program,
    SetFeed,
    StartSheet,
    ToolOff,
    ToolOn,
    Traverse,
)
from beamcam.motion.arcs import (
    ROUND_RATIO,
    ChainMoves,
    Numbers,
    ellipse_feeds,
    is_parabola,
    parabola_feed,
    paths_along,
)
from beamcam.motion.speeds import calm_radius, min_radius, straight_mm_s, turning_mm_s

SHORT = 0.05  #: mm of a curve that is part of a corner
#: mm: no move is made shorter than this by where it begins to be near a corner.
SHORTEST = 0.02


def near_corners(curves: Sequence[Curve], row: TorchRow) -> tuple[list[Curve], list[bool]]:
    """A chain divided where it begins and ends to be near a corner, and which of it is near one."""
    chain = [curve for curve in curves if curve.length > 0.0] if row.slows_corners else []
    if not chain:
        return list(curves), [False] * len(curves)
    lengths = [curve.length for curve in chain]
    begins = [0.0, *accumulate(lengths)]
    # Where a chain turns by more than an angle, at once or over curves shorter than `SHORT`.
    angle = row.corner_angle
    corners: list[float] = []
    before = None
    for k, curve in enumerate(chain):
        if before is not None:
            turn = dot(chain[before].tangent(1.0), curve.tangent(0.0))
            if degrees(acos(max(-1.0, min(1.0, turn)))) > angle:
                corners.append(begins[before + 1])
        if before is None or lengths[k] >= SHORT:
            before = k
    reach = row.corner_distance
    cuts = sorted(place + side * reach for place in corners for side in (-1.0, 1.0))
    parts: list[Curve] = []
    near: list[bool] = []
    for curve, begin, length in zip(chain, begins, lengths, strict=False):
        last = 0.0
        for cut in (*(c - begin for c in cuts if c < begin + length), length):
            if cut < length and not last + SHORTEST < cut < length - SHORTEST:
                continue
            if cut > length:
                break
            middle = begin + (last + cut) / 2
            near.append(any(abs(middle - place) < reach for place in corners))
            part = curve if cut == length else curve.split(parameter_at(curve, cut))[0]
            parts.append(part if last == 0.0 else part.split(parameter_at(part, last))[1])
            last = cut
            if cut == length:
                break
    return parts, near


class WrittenPass(NamedTuple):
    """A pass as it is written."""

    moves: ChainMoves
    near: Sequence[bool]  #: of each of its curves, whether it is near a corner


#: What the fitting of arcs may take of the machine's tolerance; rounding takes the rest.
FIT_SHARE = 0.5

#: The kinds of curves that every controller has words for.
_ALWAYS_WRITTEN = frozenset((Line, Arc))


def sheet_program(plan: SheetPlan, machine: Machine, job: str) -> Program:
    """The commands that carry out a plan, in its order."""
    pen = Pen(machine)
    passes = [one for op in plan.operations for one in op.passes]
    rows = [op.row for op in plan.operations for _ in op.passes]
    paths = pen.along([(p.lead_in, p.curves, p.lead_out) for p in passes], rows)
    commands: list[Command] = [StartSheet(plan.thickness), *map(Comment, plan.notes)]
    tells = len(plan.pieces) > 1 and names_in(machine.words, WORK_WORDS) & PART_NAMES
    chooses, chosen = bool(machine.words.material), None
    cuts = next((op.row for op in plan.operations if op.row.process == "cut"), None)
    closes = bool(machine.words.close)
    tool: TorchProcess = "cut"
    goes_on = {id(one) for one, then in pairwise(plan.operations) if then.is_linked}
    for run in _runs(plan.operations, machine):
        row = run[0].row
        if row.process != tool:
            tool = row.process
            commands.append(ChooseTool(tool))
        if tells and run[0].features:
            commands.append(OfPart(part_data([plan.pieces[run[0].features[0][0]].part])))
        data = cuts if row.process == "spot" else row if row.process == "cut" else None
        if chooses and data is not None and data != chosen:
            chosen = data
            commands.append(ChooseMaterial(data, plan.thickness))
        if len(run) > 1 or (run[0].is_hatch and pen.overscan):
            commands += _hatch(run, paths, pen)
            continue
        op = run[0]
        for one in op.passes:
            whole = op.closed and op.row.process == "cut" and len(op.passes) == op.row.passes
            closing = one.curves[-1].end if closes and whole and one.again else None
            commands += _pass(op, next(paths), pen, closing, id(op) in goes_on)
    if tool != "cut":
        commands.append(ChooseTool("cut"))
    return Program(job, tuple(commands), part_data([piece.part for piece in plan.pieces]))


def _runs(operations: Sequence[ContourOp], machine: Machine) -> Iterator[list[ContourOp]]:
    """The operations, in laser mode neighbouring lines of a hatch with one row together."""
    laser = machine.torch is not None and machine.torch.laser_mode
    run: list[ContourOp] = []
    for op in operations:
        if run and not (laser and op.is_hatch and run[0].is_hatch and op.row == run[0].row):
            yield run
            run = []
        run.append(op)
    if run:
        yield run


def _hatch(run: Sequence[ContourOp], paths: Iterator[WrittenPass], pen: "Pen") -> Iterator[Command]:
    """Lines of a hatch with the tool on from the first to the last: dark but for the lines.

    traverse   run-up   line            run-out
    . . . . . > - - - > ==============> - - - >
    """
    row, over = run[0].row, pen.overscan
    passes = [next(paths).moves for op in run for _ in op.passes]
    for number, path in enumerate(passes):
        (x0, y0), end = path.start, path.moves[-1]
        length = hypot(end.x - x0, end.y - y0) or 1.0
        u, v = over * (end.x - x0) / length, over * (end.y - y0) / length
        yield Traverse(x0 - u, y0 - v)
        if number == 0:
            yield ToolOn(
                row.process, row.feed_mm_min, 0.0 if over else row.power, row.pierce_s,
                run[0].source, row.pierce_height, row.cut_height,
            )  # fmt: skip
        if over:
            yield Feed(x0, y0)
            yield Power(row.power)
        yield from path.moves
        if over:
            yield Power(0.0)
            yield Feed(end.x + u, end.y + v)
        yield ToolOff(row.process) if number == len(passes) - 1 else PassEnd()


def _pass(
    op: ContourOp, path: WrittenPass, pen: "Pen", closing: Point | None, goes_on: bool
) -> Iterator[Command]:
    """A pass, at whose closing point the arc goes out if there is one.

    One that is linked begins with the tool on, and one that `goes_on` leaves it so.
    """
    row = op.row
    if not op.is_linked:
        yield Traverse(*path.moves.start)
        if op.side != "on":
            yield Compensate(op.side, op.kerf)
        yield ToolOn(
            row.process, row.feed_mm_min, row.power, row.pierce_s, op.source, row.pierce_height,
            row.cut_height, row.preheat_s, row.amps, row.volts, row.number,
        )  # fmt: skip
    moves: list[Command] = [*path.moves.moves]
    if pen.limits is not None or op.feed_share != 1.0 or any(path.near):
        # Slower in a small hole and near corners.
        slow = min(op.feed_share, row.corner_share)
        shares = [slow if path.near[k] else op.feed_share for k in path.moves.curve]
        start = path.moves.start
        moves = [*paced(start, path.moves.moves, row.feed_mm_min, shares, pen.limits)]
    if closing is not None:
        # The last of those that end as near, to a tenth of a millimetre: a path begins there too.
        ends = [(k, one) for k, one in enumerate(moves) if isinstance(one, Movement)]
        last, _ = min(
            reversed(ends), key=lambda at: round(10.0 * dist((at[1].x, at[1].y), closing))
        )
        if last < ends[-1][0]:
            moves.insert(last + 1, CloseCut())
    yield from moves
    yield PassEnd() if goes_on else ToolOff(row.process)
    if op.side != "on":
        yield Compensate("on", 0.0)


SECONDS_PER_MINUTE = 60.0
WORTH_LOWERING = 1e-3  #: a feed is not lowered by less than this share: no machine shows it


def paced(
    start: Point, moves: Sequence[Movement], feed_mm_min: float, shares: Sequence[float],
    limits: PathLimits | None,
) -> Iterator[Movement | SetFeed]:  # fmt: skip
    """The moves from `start`, and before each whose feed differs from the last one its own.

    `shares` are those of the feed that are asked of each move; without `limits` that is its feed.
    """
    now = feed_mm_min / SECONDS_PER_MINUTE
    for share, group in groupby(zip(moves, shares, strict=True), key=itemgetter(1)):
        some = [move for move, _ in group]
        feed_mm_s = feed_mm_min * share / SECONDS_PER_MINUTE
        feeds = repeat(feed_mm_s) if limits is None else _feeds(start, some, feed_mm_s, limits)
        for move, feed in zip(some, feeds, strict=False):
            if feed != now:
                yield SetFeed(feed * SECONDS_PER_MINUTE)
                now = feed
            yield move
        start = some[-1].x, some[-1].y


def _feeds(
    start: Point, moves: Sequence[Movement], feed_mm_s: float, limits: PathLimits
) -> Iterator[float]:
    worth = feed_mm_s * (1.0 - WORTH_LOWERING)
    calm = calm_radius(feed_mm_s, limits)
    unbounded = feed_mm_s <= limits.speed_mm_s
    here = start
    for move in moves:
        if unbounded and (
            type(move) is Feed
            or (type(move) is ArcFeed and move.i * move.i + move.j * move.j >= calm * calm)
        ):
            feed = feed_mm_s
        else:
            if isinstance(move, Feed):
                ways = np.array([(move.x - here[0], move.y - here[1])])
                feasible = float(straight_mm_s(ways, limits)[0])
            else:
                feasible = float(turning_mm_s(np.array(min_radius(here, move)), limits))
            feed = min(feed_mm_s, feasible)
            feed = feed_mm_s if feed > worth else feed
        yield feed
        here = move.x, move.y


class Pen:
    """Follows curves from one written place to the next."""

    def __init__(self, machine: Machine) -> None:
        torch = machine.needed(machine.torch, "torch")
        form, words = machine.format, machine.words
        self._fit = torch.tolerance * FIT_SHARE
        self.overscan = torch.overscan
        self._arcs = bool(words.arc_cw)
        self._parabolas = bool(words.parabola)
        self._ellipses = bool(words.ellipse_cw)
        #: Where the controller is given accelerations, the feeds have to be what it can follow.
        tells = any("{acceleration}" in word for word in words.modal)
        self.limits = path_limits(machine) if tells else None
        self.numbers = Numbers(
            form.length_decimals, form.angle_decimals, torch.tolerance * (1 - FIT_SHARE) / 2,
            torch.arc_limit, torch.min_radius, torch.max_radius if self._arcs else 0.0,
        )  # fmt: skip

    def along(
        self, chains: Sequence[Sequence[Sequence[Curve]]], rows: Sequence[TorchRow]
    ) -> Iterator[WrittenPass]:
        """The moves along each chain of several parts, by the row that it is worked with.

        Where a part begins, a move begins.
        """
        each = [
            near_corners(chain, row)
            for chain, row in zip(self._prepared(chains), rows, strict=True)
        ]
        moves = paths_along([curves for curves, _ in each], self.numbers, self._by_word)
        return (WrittenPass(one, near) for one, (_, near) in zip(moves, each, strict=True))

    def _prepared(self, chains: Sequence[Sequence[Sequence[Curve]]]) -> list[Sequence[Curve]]:
        """The chains with arcs for the free curves that the controller has no word for.

        All of them are fitted together, since a drawing has thousands.
        """
        each: list[list[tuple[bool, Sequence[Curve]]]] = []
        for chain in chains:
            groups: list[tuple[bool, Sequence[Curve]]] = []
            for part in chain:
                if _ALWAYS_WRITTEN.issuperset(map(type, part)):
                    groups.append((True, part))
                else:
                    groups += ((word, [*some]) for word, some in groupby(part, self._has_word))
            each.append(groups)
        free = [curves for groups in each for has_word, curves in groups if not has_word]
        fits: Iterator[Sequence[Curve]] = iter(())
        if free:
            from beamcam.geometry.arc_fitting import fit_chains

            fits = iter(fit_chains(free, self._fit))
        return [
            [c for has_word, curves in groups for c in (curves if has_word else next(fits))]
            for groups in each
        ]

    def _has_word(self, curve: Curve) -> bool:
        """Whether the controller may be able to follow a curve as it is."""
        if isinstance(curve, Line | Arc):
            return True
        if isinstance(curve, EllipseArc):
            return self._ellipses and curve.ratio <= ROUND_RATIO
        return self._parabolas and all(map(is_parabola, bezier_pieces(curve)))

    def _by_word(self, here: Point, curve: Curve) -> list[Movement]:
        """The moves by the controller's own word for a curve, or by arcs where that does not do."""
        moves: list[Movement] = []
        if isinstance(curve, EllipseArc):
            feeds = ellipse_feeds(here, curve, self.numbers)
            if feeds is None:
                from beamcam.geometry.arc_fitting import fit_chains

                (fitted,) = fit_chains(((curve,),), self._fit)
                chain = (Line(here, fitted[0].start), *fitted)
                (path,) = paths_along((chain,), self.numbers, self._by_word)
                feeds = path.moves
            return feeds
        assert not isinstance(curve, Line | Arc)
        for piece in bezier_pieces(curve):
            more = parabola_feed(here, piece, self.numbers)
            moves += more
            here = (more[-1].x, more[-1].y) if more else here
        return moves
