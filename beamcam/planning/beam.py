"""The plan of a bar on a saw and drilling line.

parts -> turned, in order -> what each needs (work) -> laid on the bar -> tools settled
      -> operations at machine X -> in order of work -> a ledger of every feature
"""

from collections.abc import Collection, Sequence
from itertools import chain, repeat
from operator import attrgetter
from typing import Literal

from beamcam.errors import Diagnostic, PlanError, Source, errors_in
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
    SpindleOp,
)
from beamcam.planning import rules
from beamcam.planning.bar import cuts_of, lay_on_bar
from beamcam.planning.cutting_data import cutting_remarks
from beamcam.planning.limits import refuse_bar
from beamcam.planning.magazine import reloads
from beamcam.planning.order import sort_along_x
from beamcam.planning.refuse import refuse_stock
from beamcam.planning.tool_choice import spindle_operations
from beamcam.planning.tools import rack_of
from beamcam.planning.work import Work, work_on


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
    saw, drill, layout = machine.saw, machine.drill, machine.layout
    if saw is None or drill is None or layout is None:
        raise TypeError(f"{machine.name} has no saw, drill and layout")
    if not parts:
        raise PlanError(rules.NO_PARTS.at(Source(machine.name)))
    refusals = [*refuse_stock(parts, machine, saw, drill, layout)]
    if refusals:
        raise PlanError(refusals)
    rack = rack_of(machine)
    known: dict[int, Work] = {}

    def work(part: Part) -> Work:
        """The work on a part, which is the same for every piece of it."""
        if id(part) not in known:
            known[id(part)] = work_on(part, machine, saw, rack, skips)
        return known[id(part)]

    remarks: list[Diagnostic] = []
    lying, turns = list(parts), [AS_GIVEN] * len(parts)
    if turn:
        from beamcam.planning.choose import choose_turns

        choices = choose_turns(parts, machine, skips)
        lying, turns = [c.part for c in choices], [c.turn for c in choices]
        remarks += dict.fromkeys(said for c in choices for said in c.remarks)
        refusals = [*refuse_stock(lying, machine, saw, drill, layout)]
        if refusals:
            raise PlanError(refusals)
    given = list(range(len(parts)))
    if order == "best" and len(parts) > 1:
        from beamcam.planning.choose import best_order

        ends = [work(part).ends for part in lying]
        given, said = best_order(lying, ends, saw)
        remarks += said
    laid = [lying[i] for i in given]
    works = [work(part) for part in laid]
    refusals = [said for part in dict.fromkeys(map(id, laid)) for said in known[part].refusals]
    if errors_in(refusals):
        if not turn:
            from beamcam.planning.choose import turn_that_helps

            refusals += turn_that_helps(parts, machine, skips)
        raise PlanError(refusals)
    for part in {id(p): p for p in laid}.values():
        remarks += work(part).remarks
        if part.quantity > 1:
            count = sum(p is part or p == part for p in laid)
            if part.quantity > count:
                remarks.append(rules.QUANTITY.at(part.source, found=part.quantity, made=count))
    ends = [w.ends for w in works]
    (starts, account), said = lay_on_bar(laid, ends, layout, saw, bar)
    remarks += said
    pieces = tuple(
        Piece(part, start, i, turns[i]) for part, start, i in zip(laid, starts, given, strict=True)
    )
    spindle_ops = list(spindle_operations(pieces, works, drill))
    operations: list[Operation] = [*cuts_of(pieces, ends, saw, account), *spindle_ops]
    refusals = [*refuse_bar(operations, pieces, machine)]
    if refusals:
        raise PlanError(refusals)
    ordered = sort_along_x(operations, machine.format.resolution, layout.order, machine.times)
    by_hand, said = reloads(ordered, machine, parts[0].source)
    if errors_in(said):
        raise PlanError(said)
    remarks += said
    remarks += cutting_remarks(pieces, spindle_ops, machine)
    plan = Plan(
        laid[0].profile,
        pieces,
        account,
        ordered,
        tuple(_outcomes(works, spindle_ops)),
        tuple(remarks),
        by_hand,
    )
    _balance(plan)
    return plan


_feature = attrgetter("feature")


def _outcomes(works: Sequence[Work], operations: Sequence[SpindleOp]) -> list[Outcome]:
    """What becomes of each feature, in the order of pieces and features."""
    made: dict[FeatureRef, Outcome] = {}
    for op in operations:
        how: Literal["made", "merged"] = "made"
        for ref in op.features:
            made[ref] = Outcome(ref, how, op.tool.kind)
            how = "merged"
    outcomes = list(made.values())
    for p, work in enumerate(works):
        outcomes += [Outcome((p, f), "skipped", said.code) for f, said in work.skipped.items()]
        outcomes += [Outcome((p, f), "duplicate", rules.DUPLICATE.code) for f in work.repeats]
        outcomes += [Outcome((p, f), "made", "saw") for f in work.sawn]
    outcomes.sort(key=_feature)
    return outcomes


def _balance(plan: Plan) -> None:
    """Raise AssertionError unless every feature has exactly one outcome and the bar adds up.

    That would be a fault of the planner and not of the part, and no program may come of it.
    """
    counts = enumerate(len(piece.part.features) for piece in plan.pieces)
    read = chain.from_iterable(zip(repeat(p), range(count)) for p, count in counts)
    if [*map(_feature, plan.outcomes)] != [*read]:
        raise AssertionError("the ledger of the plan does not balance")
    if abs(plan.bar.total - plan.bar.length) > LEDGER_TOLERANCE:
        raise AssertionError("the account of the bar does not balance")
    sawn = [op for op in plan.operations if isinstance(op, SawOp)]
    if {p for op in sawn for p in op.pieces} != set(range(len(plan.pieces))):
        raise AssertionError("a piece has no cut")


LEDGER_TOLERANCE = 0.001  #: mm
