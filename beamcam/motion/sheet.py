"""The motion of a cutting table: each pass as moves in the numbers that will be written.

    pass -> free curves fitted with arcs -> arcs and ends rounded, centres solved again -> moves

Where the controller has words for parabolas and ellipses those are kept exact.
"""

from collections.abc import Iterator, Sequence
from itertools import groupby

from beamcam.geometry.curves import Arc, Curve, EllipseArc, Line, bezier_pieces
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.path_limits import path_limits
from beamcam.machine.words import PART_NAMES, WORK_WORDS, names_in
from beamcam.model.description import part_data
from beamcam.model.plan import ContourOp, SheetPlan
from beamcam.model.program import (
    Command,
    Comment,
    Compensate,
    Movement,
    OfPart,
    Program,
    StartSheet,
    ToolOff,
    ToolOn,
    Traverse,
)
from beamcam.motion.arcs import ChainMoves, paths_along
from beamcam.motion.curve_words import ROUND_RATIO, ellipse_feeds, is_parabola, parabola_feed
from beamcam.motion.feed_limits import paced
from beamcam.motion.numbers import Numbers

#: What the fitting of arcs may take of the machine's tolerance; rounding takes the rest.
FIT_SHARE = 0.5

#: The kinds of curves that every controller has words for.
_ALWAYS_WRITTEN = frozenset((Line, Arc))


def sheet_program(plan: SheetPlan, machine: Machine, job: str) -> Program:
    """The commands that carry out a plan, in its order."""
    pen = Pen(machine)
    passes = [one for op in plan.operations for one in op.passes]
    paths = pen.along([(*p.lead_in, *p.curves, *p.lead_out) for p in passes])
    commands: list[Command] = [StartSheet(plan.thickness), *map(Comment, plan.notes)]
    tells = len(plan.pieces) > 1 and names_in(machine.words, WORK_WORDS) & PART_NAMES
    for op in plan.operations:
        if tells:
            commands.append(OfPart(part_data([plan.pieces[op.features[0][0]].part])))
        for _ in op.passes:
            commands += _pass(op, next(paths), pen)
    return Program(job, tuple(commands), part_data([piece.part for piece in plan.pieces]))


def _pass(op: ContourOp, path: ChainMoves, pen: "Pen") -> Iterator[Command]:
    row = op.row
    yield Traverse(*path.start)
    if op.side != "on":
        yield Compensate(op.side, op.kerf)
    yield ToolOn(
        row.process, row.feed_mm_min, row.power, row.pierce_s, op.source, row.pierce_height,
        row.cut_height,
    )  # fmt: skip
    if pen.limits is None:
        yield from path.moves
    else:
        yield from paced(path.start, path.moves, row.feed_mm_min, pen.limits)
    yield ToolOff(row.process)
    if op.side != "on":
        yield Compensate("on", 0.0)


class Pen:
    """Follows curves from one written place to the next."""

    def __init__(self, machine: Machine) -> None:
        torch = machine.needed(machine.torch, "torch")
        form, words = machine.format, machine.words
        self._fit = torch.tolerance * FIT_SHARE
        self._arcs = bool(words.arc_cw)
        self._parabolas = bool(words.parabola)
        self._ellipses = bool(words.ellipse_cw)
        #: Where the controller is given accelerations, the feeds have to be what it can follow.
        tells = any("{acceleration}" in word for word in words.modal)
        self.limits = path_limits(machine) if tells else None
        self.numbers = Numbers(
            form.length_decimals,
            form.angle_decimals,
            torch.tolerance * (1 - FIT_SHARE) / 2,
            torch.arc_limit,
            torch.min_radius,
            torch.max_radius if self._arcs else 0.0,
        )

    def along(self, chains: Sequence[Sequence[Curve]]) -> Iterator[ChainMoves]:
        """The moves along each chain."""
        return paths_along(self._prepared(chains), self.numbers, self._by_word)

    def _prepared(self, chains: Sequence[Sequence[Curve]]) -> list[Sequence[Curve]]:
        """The chains with arcs for the free curves that the controller has no word for.

        All of them are fitted together, since a drawing has thousands.
        """
        each = [self._stretches(chain) for chain in chains]
        free = [curves for chain in each for has_word, curves in chain if not has_word]
        if not free:
            return list(chains)
        from beamcam.geometry.arc_fitting import fit_chains

        fits = iter(fit_chains(free, self._fit))
        return [
            [c for has_word, curves in chain for c in (curves if has_word else next(fits))]
            for chain in each
        ]

    def _stretches(self, chain: Sequence[Curve]) -> list[tuple[bool, Sequence[Curve]]]:
        """The stretches of a chain, each with whether the controller may have words for it."""
        if _ALWAYS_WRITTEN.issuperset(map(type, chain)):
            return [(True, chain)]
        return [(has_word, tuple(group)) for has_word, group in groupby(chain, self._has_word)]

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
            found = ellipse_feeds(here, curve, self.numbers)
            return self._by_arcs(here, curve) if found is None else found
        assert not isinstance(curve, Line | Arc)
        for piece in bezier_pieces(curve):
            more = parabola_feed(here, piece, self.numbers)
            moves += more
            here = (more[-1].x, more[-1].y) if more else here
        return moves

    def _by_arcs(self, here: Point, curve: EllipseArc) -> list[Movement]:
        from beamcam.geometry.arc_fitting import fit_chains

        (fitted,) = fit_chains(((curve,),), self._fit)
        chain = (Line(here, fitted[0].start), *fitted)
        (path,) = paths_along((chain,), self.numbers, self._by_word)
        return path.moves
