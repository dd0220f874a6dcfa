"""The plan of a bar on a saw and drilling line.

parts, as they lie -> what each needs (work) -> in order, laid on the bar
      -> operations at machine X, with their tools -> in order of work -> a ledger of every feature
"""

from collections.abc import Collection, Sequence
from itertools import chain, repeat
from operator import attrgetter
from typing import Literal

from beamcam.budget import check_features
from beamcam.errors import PlanError, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.plan import (
    FeatureRef,
    Order,
    Outcome,
    Plan,
    SawOp,
    WorkOp,
)
from beamcam.planning import rules
from beamcam.planning.axis_limits import refuse_bar
from beamcam.planning.bar_operations import bar_operations
from beamcam.planning.cutting_data import cutting_remarks
from beamcam.planning.magazine import reloads
from beamcam.planning.nesting import lay
from beamcam.planning.operations.line import line_of
from beamcam.planning.operations.work import PartWork, works_on
from beamcam.planning.order import sort_along_x
from beamcam.planning.stock import refuse_stock

LEDGER_TOLERANCE = 0.001  #: mm


def plan_bar(
    parts: Sequence[Part],
    machine: Machine,
    bar: float | None = None,
    skips: Collection[str] = (),
    order: Order = "given",
) -> Plan:
    """The work that makes `parts`, as they lie, from one bar of length `bar`, or as they need.

    `skips` names what may be left out (`rules.SKIP_NAMES`), `order` whether the parts lie as they
    are given or as they nest best. Raises PlanError with everything that the machine cannot make,
    and LimitError; nothing is left out that is not in the plan's outcomes.
    """
    line = line_of(machine)
    refusals = [*refuse_stock(parts, line)]
    if refusals:
        raise PlanError(refusals)
    check_features((part.source, len(part.features)) for part in parts)
    works, told = works_on(parts, line, skips)
    laid = lay(works, line, order, bar)
    told += laid.remarks
    pieces, source = laid.pieces, laid.pieces[0].part.source
    cuts, strokes = bar_operations(laid, line)
    if not (cuts or strokes):
        raise PlanError(rules.NO_WORK.at(source, machine=machine.name))
    refusals = [*refuse_bar([*cuts, *strokes], pieces, machine)]
    if refusals:
        raise PlanError(refusals)
    ordered = sort_along_x(cuts, strokes, machine)
    by_hand, said = reloads(ordered, machine, source)
    if errors_in(said):
        raise PlanError(said)
    told += said
    told += cutting_remarks(pieces, strokes, machine)
    outcomes = tuple(_outcomes(laid.works, strokes))
    plan = Plan(pieces[0].part.profile, pieces, laid.bar, ordered, outcomes, tuple(told), by_hand)
    _balance(plan, machine)
    return plan


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
