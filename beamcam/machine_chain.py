"""Machines one after the other, where none makes all of a part: each gets what the others leave.

part -> the machine that leaves least -> rest -> the next one ... -> the one that makes the rest
"""

from collections.abc import Iterator, Sequence

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.plan import NOT_MADE, AnyPlan
from beamcam.model.request import Job, Request
from beamcam.planning.begun import begun_part
from beamcam.planning.rules import SKIP_NAMES
from beamcam.posts import plan_seconds, post_of

LONGEST = 3  #: machines of a chain


class Link(Struct, frozen=True):
    """A machine of a chain, and what it is asked for."""

    machine: Machine
    part: Part  #: as this machine gets it
    skips: tuple[str, ...]  #: kinds that it leaves to the next one; of the last, those asked for


def chain_of(request: Request, machines: Sequence[Machine]) -> tuple[Link, ...]:
    """The shortest chain that makes the only part of a request, of 3 machines at most, or none.

    The last one leaves out only what the request allows. Of machines that leave equally many
    features the first in order is taken, or the quickest where the request is `by` time, and none
    twice.
    """
    (part,) = request.parts
    for count in range(1, min(len(machines), LONGEST) + 1):
        found = next(_chains(request, part, machines, count), ())
        if found:
            return found
    return ()


def _chains(
    request: Request, part: Part, machines: Sequence[Machine], count: int
) -> Iterator[tuple[Link, ...]]:
    """The chains of so many machines.

    In order none is planned on behind the first that by itself leaves nothing.
    """
    plans: list[tuple[int, float, Machine, AnyPlan]] = []
    for machine in machines:
        skips = request.skips if count == 1 else SKIP_NAMES
        planned = _planned(request, part, machine, skips)
        if planned is not None:
            plan, seconds = planned
            left = sum(outcome.how in NOT_MADE for outcome in plan.outcomes)
            plans.append((left, seconds, machine, plan))
            if not left and count == 1 and request.by == "order":
                break
    plans.sort(key=lambda one: one[:2])
    for left, _, machine, plan in plans:
        if count == 1:
            yield (Link(machine, part, request.skips),)
            continue
        kinds = {o.by.removeprefix("plan-") for o in plan.outcomes if o.how == "skipped"}
        skips = tuple(sorted(kinds & {*SKIP_NAMES}))
        makes_nothing = part.made is not None and left == len(part.features)
        if makes_nothing or _planned(request, part, machine, skips) is None:
            continue
        others = [one for one in machines if one is not machine]
        for rest in _chains(request, begun_part(part, plan, machine), others, count - 1):
            yield (Link(machine, part, skips), *rest)


def _planned(
    request: Request, part: Part, machine: Machine, skips: Sequence[str]
) -> tuple[AnyPlan, float] | None:
    """The plan of one such part and its seconds, 0 where time does not count.

    None where the machine refuses it.
    """
    asked = replace(request, parts=(part,), machine=machine, skips=tuple(skips), quantity=None)
    job = Job(asked, (0,), max(request.stock, default=None))
    try:
        plan = post_of(machine).plan(job)
        return plan, plan_seconds(plan, job) if request.by == "time" else 0.0
    except PlanError:
        return None
