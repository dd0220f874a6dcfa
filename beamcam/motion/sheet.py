"""The motion of a cutting table: each pass as moves in the numbers that will be written.

    pass -> free curves fitted with arcs -> arcs and ends rounded, centres solved again -> moves

Where the controller has words for parabolas and ellipses those are kept exact.
"""

from collections.abc import Iterator, Sequence
from itertools import chain as chained
from itertools import groupby
from typing import cast

from beamcam.geometry.curves import Arc, Curve, EllipseArc, Line, bezier_pieces
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.path_limits import path_limits
from beamcam.machine.words import Words
from beamcam.model.plan import ContourOp, SheetPlan
from beamcam.model.program import (
    Command,
    Comment,
    Compensate,
    Feed,
    Movement,
    Program,
    StartSheet,
    ToolOff,
    ToolOn,
    Traverse,
)
from beamcam.motion.arcs import (
    MAX_SWEEP_DEG,
    ROUND_RATIO,
    SWEEP_SLACK_DEG,
    Numbers,
    arc_feeds,
    ellipse_feeds,
    is_parabola,
    parabola_feed,
)
from beamcam.motion.feed_limits import paced
from beamcam.motion.sure import SureMoves, sure_moves

#: What the fitting of arcs may take of the machine's tolerance; rounding takes the rest.
FIT_SHARE = 0.5

#: The kinds of curves that every controller has words for.
_ALWAYS_WRITTEN = frozenset((Line, Arc))


def sheet_program(plan: SheetPlan, machine: Machine, job: str) -> Program:
    """The commands that carry out a plan, in its order."""
    pen = Pen(machine)
    passes = [one for op in plan.operations for one in op.passes]
    chains = pen.prepared([(*p.lead_in, *p.curves, *p.lead_out) for p in passes])
    ways = zip(chains, sure_moves(chains, pen.numbers), strict=True)
    commands: list[Command] = [StartSheet(plan.thickness), *map(Comment, plan.notes)]
    for op in plan.operations:
        for _ in op.passes:
            commands += _pass(op, *next(ways), pen)
    return Program(job, tuple(commands))


def _pass(op: ContourOp, curves: Sequence[Curve], sure: SureMoves, pen: "Pen") -> Iterator[Command]:
    start = pen.numbers.at(curves[0].start)
    row = op.row
    yield Traverse(*start)
    if op.side != "on":
        yield Compensate(op.side, op.kerf)
    yield ToolOn(row.process, row.feed_mm_min, row.power, row.pierce_s, op.source)
    moves = pen.along(start, curves, sure)
    if pen.limits is None:
        yield from moves
    else:
        yield from paced(start, moves, row.feed_mm_min, pen.limits)
    yield ToolOff(row.process)
    if op.side != "on":
        yield Compensate("on", 0.0)


class Pen:
    """Follows curves from one written place to the next."""

    def __init__(self, machine: Machine) -> None:
        if machine.torch is None:
            raise TypeError(f"{machine.name} has no torch")
        torch, form, words = machine.torch, machine.format, machine.words
        self._fit = torch.tolerance * FIT_SHARE
        self._arcs = bool(words.arc_cw)
        self._parabolas = bool(words.parabola)
        self._ellipses = bool(words.ellipse_cw)
        #: Where the controller is told accelerations, the feeds have to be what it can follow.
        self.limits = path_limits(machine) if _tells_acceleration(words) else None
        self.numbers = Numbers(
            form.length_decimals,
            form.angle_decimals,
            torch.tolerance * (1 - FIT_SHARE) / 2,
            torch.arc_limit,
            torch.min_radius,
            torch.max_radius if self._arcs else 0.0,
        )

    def prepared(self, chains: Sequence[Sequence[Curve]]) -> list[Sequence[Curve]]:
        """The chains with arcs for the free curves that the controller has no word for.

        All of them are fitted together, since a drawing has thousands.
        """
        runs: list[tuple[Curve, ...]] = []
        found: list[Sequence[Curve]] = list(chains)
        stretches: dict[int, list[tuple[Curve, ...] | int]] = {}  #: kept, or the number of a run
        for k, chain in enumerate(chains):
            if _ALWAYS_WRITTEN.issuperset(map(type, chain)):
                continue
            stretches[k] = []
            for has_word, group in groupby(chain, self._has_word):
                if has_word:
                    stretches[k].append(tuple(group))
                else:
                    stretches[k].append(len(runs))
                    runs.append(tuple(group))
        if runs:
            from beamcam.geometry.arc_fitting import fit_chains

            fits = fit_chains(runs, self._fit)
            for k, parts in stretches.items():
                found[k] = [
                    c for part in parts for c in (fits[part] if isinstance(part, int) else part)
                ]
        return [_halved(chain) for chain in found]

    def _has_word(self, curve: Curve) -> bool:
        """Whether the controller may be able to follow a curve as it is."""
        if isinstance(curve, Line | Arc):
            return True
        if isinstance(curve, EllipseArc):
            return self._ellipses and curve.ratio <= ROUND_RATIO
        return self._parabolas and all(map(is_parabola, bezier_pieces(curve)))

    def along(self, start: Point, curves: Sequence[Curve], sure: SureMoves) -> list[Movement]:
        """The moves along a chain that was prepared, from the written place `start`.

        Those that are sure are taken as they are, the others found one by one.
        """
        if None not in sure:  # as of most contours
            return list(cast("Sequence[Movement]", sure))
        moves: list[Movement] = []
        here = start
        for curve, move in zip(curves, sure, strict=True):
            if move is not None:
                moves.append(move)
                here = move.x, move.y
            elif isinstance(curve, Line):
                end = self.numbers.at(curve.end)
                if end != here:
                    moves.append(Feed(*end))
                    here = end
            elif isinstance(curve, Arc):
                here = _append(moves, here, arc_feeds(here, curve, self.numbers))
            else:
                here = _append(moves, here, self._by_word(here, curve))
        return moves

    def _by_word(self, here: Point, curve: Curve) -> list[Movement]:
        """The moves by the controller's own word for a curve, or by arcs where it has none."""
        if isinstance(curve, EllipseArc):
            moves = ellipse_feeds(here, curve, self.numbers) if self._ellipses else None
            if moves is not None:
                return moves
        elif self._has_word(curve) and not isinstance(curve, Line | Arc):
            moves = []
            for piece in bezier_pieces(curve):
                here = _append(moves, here, parabola_feed(here, piece, self.numbers))
            return moves
        from beamcam.geometry.arc_fitting import fit_chains

        fitted = fit_chains(((curve,),), self._fit)[0]
        return self.along(here, fitted, (None,) * len(fitted))


def _tells_acceleration(words: Words) -> bool:
    return any("{acceleration}" in word for word in words.modal)


def _halved(chain: Sequence[Curve]) -> Sequence[Curve]:
    """A chain whose arcs are half a circle at most, as they are written."""
    if Arc not in map(type, chain):
        return chain
    most = MAX_SWEEP_DEG + SWEEP_SLACK_DEG
    wide = [type(curve) is Arc and abs(curve.sweep_deg) > most for curve in chain]
    if not any(wide):
        return chain
    parts = (c.split(0.5) if is_wide else (c,) for c, is_wide in zip(chain, wide, strict=True))
    return list(chained.from_iterable(parts))


def _append(moves: list[Movement], here: Point, more: list[Movement]) -> Point:
    if not more:
        return here
    moves += more
    return more[-1].x, more[-1].y
