"""The plan of a bar on a saw and drilling line.

parts -> as they lie -> what each needs (work) -> in order, laid on the bar
      -> operations at machine X, with their tools -> in order of work -> a ledger of every feature
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import chain, repeat
from operator import attrgetter
from typing import Literal

from msgspec import Struct

from beamcam.errors import Diagnostic, PlanError, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.plan import (
    AS_GIVEN,
    FeatureRef,
    Operation,
    Order,
    Outcome,
    Piece,
    Plan,
    SawOp,
    WorkOp,
)
from beamcam.planning import rules
from beamcam.planning.axis_limits import refuse_bar
from beamcam.planning.cut_parts import lay_cut_part
from beamcam.planning.cutting_data import cutting_remarks
from beamcam.planning.magazine import reloads
from beamcam.planning.nesting import best_order, lay_on_bar
from beamcam.planning.operations.line import BarLine, line_of
from beamcam.planning.operations.saw_cut import cuts_of
from beamcam.planning.operations.work import PartWork, spindle_operations, work_on
from beamcam.planning.order import sort_along_x
from beamcam.planning.stock import refuse_stock

LEDGER_TOLERANCE = 0.001  #: mm


class OrientedPart(Struct, frozen=True):
    """A part in its orientation on the rollers, with its work there."""

    part: Part
    turn: str
    given: int  #: which of the parts that were handed in
    work: PartWork


def plan_bar(
    parts: Sequence[Part],
    machine: Machine,
    bar: float | None = None,
    skips: Collection[str] = (),
    order: Order = "given",
    turn: bool = False,
) -> Plan:
    """The work that makes `parts` from one bar of length `bar`, or of the length that they need.

    `skips` names what may be left out (`rules.SKIP_NAMES`), `order` whether the parts lie as they
    are given or as they nest best, `turn` whether a part may be turned on the rollers. Raises
    PlanError with everything that the machine cannot make; nothing is left out that is not in
    the plan's outcomes.
    """
    line = line_of(machine)
    told = _accepted(refuse_stock(parts, line))
    oriented = _lay_on_rollers(parts, line, skips, turn, told)
    told += _accepted(_refusals(oriented, line, skips, turn))
    oriented = _in_order(oriented, line, order, told)
    told += _part_remarks(oriented)
    works = [each.work for each in oriented]
    ends = [work.ends for work in works]
    in_order = [each.part for each in oriented]
    if machine.saw is None:
        (starts, account), said = lay_cut_part(in_order, line)
    else:
        (starts, account), said = lay_on_bar(in_order, ends, line.layout, line.saw, bar)
    told += said
    pieces = tuple(
        Piece(each.part, start, each.given, each.turn)
        for each, start in zip(oriented, starts, strict=True)
    )
    strokes = [*spindle_operations(pieces, works, line)]
    cuts = [] if machine.saw is None else [*cuts_of(pieces, ends, line.saw, account)]
    operations: list[Operation] = [*cuts, *strokes]
    if not operations:
        raise PlanError(rules.NO_WORK.at(parts[0].source, machine=machine.name))
    told += _accepted(refuse_bar(operations, pieces, machine))
    ordered = sort_along_x(
        cuts, strokes, machine.format.resolution, line.layout.order, machine.times
    )
    by_hand, said = reloads(ordered, machine, parts[0].source)
    told += _accepted(said)
    told += cutting_remarks(pieces, strokes, machine)
    outcomes = tuple(_outcomes(works, strokes))
    plan = Plan(pieces[0].part.profile, pieces, account, ordered, outcomes, tuple(told), by_hand)
    _balance(plan, machine)
    return plan


def _accepted(said: Iterable[Diagnostic]) -> list[Diagnostic]:
    """The remarks to print. Raises PlanError with all of them if one is an error."""
    told = [*said]
    if errors_in(told):
        raise PlanError(told)
    return told


def _lay_on_rollers(
    parts: Sequence[Part],
    line: BarLine,
    skips: Collection[str],
    turn: bool,
    told: list[Diagnostic],
) -> list[OrientedPart]:
    """The parts as they are given, or each turned as is best, with the work on each."""
    turned, turns = parts, [AS_GIVEN] * len(parts)
    if turn:
        from beamcam.planning.orientation import choose_turns

        choices = choose_turns(parts, line, skips)
        turned, turns = [c.part for c in choices], [c.turn for c in choices]
        told += dict.fromkeys(said for c in choices for said in c.remarks)
        told += _accepted(refuse_stock(turned, line))
    works = {id(part): part for part in turned}
    known = {key: work_on(part, line, skips) for key, part in works.items()}
    return [
        OrientedPart(part, how, i, known[id(part)])
        for i, (part, how) in enumerate(zip(turned, turns, strict=True))
    ]


def _refusals(
    oriented: Sequence[OrientedPart], line: BarLine, skips: Collection[str], turn: bool
) -> Iterator[Diagnostic]:
    """Features of the parts that cannot be made, and the turn that would help."""
    works = {id(each.part): each.work for each in oriented}
    refusals = [said for work in works.values() for said in work.refusals]
    yield from refusals
    if refusals and not turn:
        from beamcam.planning.orientation import turn_that_helps

        yield from turn_that_helps([each.part for each in oriented], line, skips)


def _in_order(
    oriented: list[OrientedPart], line: BarLine, order: Order, told: list[Diagnostic]
) -> list[OrientedPart]:
    """The parts in their order on the bar."""
    if order == "given" or len(oriented) == 1:
        return oriented
    ends = [each.work.ends for each in oriented]
    best, said = best_order([each.part for each in oriented], ends, line.saw)
    told += said
    return [oriented[i] for i in best]


def _part_remarks(oriented: Sequence[OrientedPart]) -> Iterator[Diagnostic]:
    """Remarks on each part, once."""
    for each in {id(one.part): one for one in oriented}.values():
        part = each.part
        yield from each.work.remarks
        if part.quantity > 1:
            count = sum(one.part is part or one.part == part for one in oriented)
            if part.quantity > count:
                yield rules.QUANTITY.at(part.source, found=part.quantity, made=count)


_feature = attrgetter("feature")


def _outcomes(works: Sequence[PartWork], operations: Sequence[WorkOp]) -> list[Outcome]:
    """The outcome of each feature, in the order of pieces and features."""
    made: dict[FeatureRef, Outcome] = {}
    for op in operations:
        how: Literal["made", "merged"] = "made"
        for ref in op.features:
            made[ref] = Outcome(ref, how, op.tool.kind)
            how = "merged"
    outcomes = list(made.values())
    for p, work in enumerate(works):
        outcomes += [Outcome((p, f), "skipped", said.code) for f, said in work.skipped.items()]
        outcomes += [Outcome((p, each.feature), each.how, each.by) for each in work.settled]
    outcomes.sort(key=_feature)
    return outcomes


def _balance(plan: Plan, machine: Machine) -> None:
    """Raise AssertionError unless every feature has exactly one outcome and the bar adds up.

    That would be a fault of the planner and not of the part, and no program may come of it.
    """
    counts = enumerate(len(piece.part.features) for piece in plan.pieces)
    read = chain.from_iterable(zip(repeat(p), range(count)) for p, count in counts)
    if [*map(_feature, plan.outcomes)] != [*read]:
        raise AssertionError("the ledger of the plan does not balance")
    if abs(plan.bar.total - plan.bar.length) > LEDGER_TOLERANCE:
        raise AssertionError("the account of the bar does not balance")
    if machine.saw is None:
        return
    sawn = {p for op in plan.operations if type(op) is SawOp for p in op.pieces}
    if sawn != set(range(len(plan.pieces))):
        raise AssertionError("a piece has no cut")
