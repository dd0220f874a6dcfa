"""Parts in their orientation on the rollers, with the work on each."""

from collections.abc import Collection, Iterator, Sequence

from msgspec import Struct

from beamcam.errors import Diagnostic, PlanError
from beamcam.model.part import Part
from beamcam.model.plan import AS_GIVEN
from beamcam.planning import rules
from beamcam.planning.operations.line import BarLine
from beamcam.planning.operations.work import PartWork, work_on
from beamcam.planning.stock import refuse_size, refuse_stock


class OrientedPart(Struct, frozen=True):
    """A part in its orientation on the rollers, with its work there."""

    work: PartWork
    turn: str
    given: int  #: which of the parts that were handed in


def orient(
    parts: Sequence[Part], line: BarLine, skips: Collection[str], turn: bool
) -> tuple[list[OrientedPart], list[Diagnostic]]:
    """The parts as they are given, or each turned as is best, with the work on each; and remarks.

    Raises PlanError with everything that the machine cannot make.
    """
    told: list[Diagnostic] = []
    refusals = [*refuse_stock(parts, line)]
    turned, turns = parts, [AS_GIVEN] * len(parts)
    if turn and not refusals:
        from beamcam.planning.turn_choice import choose_turns

        choices = choose_turns(parts, line, skips)
        turned, turns = [c.part for c in choices], [c.turn for c in choices]
        told += dict.fromkeys(said for c in choices for said in c.remarks)
    refusals += [said for part in turned for said in refuse_size(part, line)]
    if refusals:
        raise PlanError(refusals)
    works = {key: work_on(part, line, skips) for key, part in {id(p): p for p in turned}.items()}
    refusals = [said for work in works.values() for said in work.refusals]
    if refusals and not turn:
        from beamcam.planning.turn_choice import turn_that_helps

        refusals += turn_that_helps(parts, line, skips)
    if refusals:
        raise PlanError(refusals)
    told += _remarks(works.values(), turned)
    return [
        OrientedPart(works[id(part)], how, i)
        for i, (part, how) in enumerate(zip(turned, turns, strict=True))
    ], told


def _remarks(works: Collection[PartWork], parts: Sequence[Part]) -> Iterator[Diagnostic]:
    """Remarks on each part, once."""
    for work in works:
        part = work.part
        yield from work.remarks
        if part.quantity > 1:
            count = sum(one is part or one == part for one in parts)
            if part.quantity > count:
                yield rules.QUANTITY.at(part.source, found=part.quantity, made=count)
