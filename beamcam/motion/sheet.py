"""The motion of a cutting table: each pass as moves in the numbers that will be written.

    pass -> free curves fitted with arcs -> arcs and ends rounded, centres solved again -> moves

Where the controller has words for parabolas and ellipses those are kept exact.
"""

from collections.abc import Iterator, Sequence

from beamcam.geometry.curves import (
    Arc,
    Bezier,
    BSpline,
    Curve,
    EllipseArc,
    Line,
    NewtonCurve,
    bezier_pieces,
)
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.model.plan import ContourOp, Pass, SheetPlan
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
from beamcam.motion.arcs import Numbers, arc_feeds, ellipse_feeds, is_parabola, parabola_feed

#: What the fitting of arcs may take of the machine's tolerance; rounding takes the rest.
FIT_SHARE = 0.5


def sheet_program(plan: SheetPlan, machine: Machine, job: str) -> Program:
    """The commands that carry out a plan, in its order."""
    return Program(job, tuple(_commands(plan, machine)))


def _commands(plan: SheetPlan, machine: Machine) -> Iterator[Command]:
    pen = Pen(machine)
    yield StartSheet(plan.thickness)
    for note in plan.notes:
        yield Comment(note)
    for op in plan.operations:
        for k, one in enumerate(op.passes):
            yield from _pass(op, one, k, pen)


def _pass(op: ContourOp, one: Pass, number: int, pen: "Pen") -> Iterator[Command]:
    curves = (*one.lead_in, *one.curves, *one.lead_out)
    start = pen.numbers.at(curves[0].start)
    row = op.row
    yield Traverse(*start)
    if op.side != "on":
        yield Compensate(op.side, op.kerf)
    yield ToolOn(row.process, row.feed_mm_min, row.power, row.pierce_s, op.source)
    yield from pen.along(start, curves)
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
        self.numbers = Numbers(
            form.length_decimals,
            form.angle_decimals,
            torch.tolerance * (1 - FIT_SHARE) / 2,
            torch.arc_limit,
            torch.least_radius,
            torch.greatest_radius if self._arcs else 0.0,
        )

    def along(self, start: Point, curves: Sequence[Curve]) -> list[Movement]:
        """The moves along a chain, from the written place `start`."""
        moves: list[Movement] = []
        decimals = self.numbers.decimals
        here = start
        free: list[Curve] = []
        for curve in curves:
            if isinstance(curve, Line | Arc):
                if free:
                    here = self._fitted(here, free, moves)
                    free = []
                if isinstance(curve, Line):
                    x, y = curve.end
                    end = round(x, decimals) + 0.0, round(y, decimals) + 0.0
                    if end != here:
                        moves.append(Feed(*end))
                        here = end
                else:
                    here = _append(moves, here, arc_feeds(here, curve, self.numbers))
                continue
            exact = self._exact(here, curve) if not free else None
            if exact is not None:
                here = _append(moves, here, exact)
            else:
                free.append(curve)
        if free:
            self._fitted(here, free, moves)
        return moves

    def _exact(self, here: Point, curve: Curve) -> list[Movement] | None:
        """The moves by the controller's own word for the curve; None where it has none."""
        if isinstance(curve, EllipseArc):
            return ellipse_feeds(here, curve, self.numbers) if self._ellipses else None
        if not self._parabolas or not isinstance(curve, Bezier | BSpline | NewtonCurve):
            return None
        pieces = bezier_pieces(curve)
        if not all(is_parabola(piece) for piece in pieces):
            return None
        moves: list[Movement] = []
        for piece in pieces:
            here = _append(moves, here, parabola_feed(here, piece, self.numbers))
        return moves

    def _fitted(self, here: Point, free: Sequence[Curve], moves: list[Movement]) -> Point:
        """Appends the moves along free curves that were fitted with arcs; where they end."""
        from beamcam.geometry.fitting import fit_path

        for part in fit_path(free, self._fit).curves:
            if isinstance(part, Arc):
                here = _append(moves, here, arc_feeds(here, part, self.numbers))
            else:
                end = self.numbers.at(part.end)
                if end != here:
                    moves.append(Feed(*end))
                    here = end
        return here


def _append(moves: list[Movement], here: Point, more: list[Movement]) -> Point:
    if not more:
        return here
    moves += more
    return more[-1].x, more[-1].y
