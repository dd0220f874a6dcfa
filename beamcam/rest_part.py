"""What a program leaves of its part, as the file that the next machine gets; and which machines
make a part one after the other.

    part  ->  program 1              what it leaves out, or leaves for manual work
          ->  rest of the part  ->  program 2

The rest is read again before it is written: program and rest together are the part.
"""

import os
from collections.abc import Iterable, Iterator, Sequence
from typing import TypeVar

from msgspec import Struct
from msgspec.structs import replace

from beamcam.arguments import none_makes_it
from beamcam.checks.rest import rest_faults
from beamcam.errors import Diagnostic, PlanError, ReadError, VerifyError, errors_in, note
from beamcam.machine.machine import Machine
from beamcam.model.part import Feature, Part, Plane
from beamcam.model.plan import NOT_MADE, SKIP_NAMES, AnyPlan, unfinished
from beamcam.model.request import Job, Request
from beamcam.pipeline import Posted, begin, finished
from beamcam.planning.begun import begun_part
from beamcam.planning.left_out import LEFT_OUT, MANUAL_WORK
from beamcam.posts import plan_seconds, post_of
from beamcam.readers import read
from beamcam.writers import Target

Sourced = TypeVar("Sourced", Part, Feature, Plane)  #: what says where it comes from

REST = note("plan-rest",
    "the rest of the part, {found} feature(s), is written; the piece that comes has finished ends",
    "The next machine gets what this program does not make. In its file what is there stands in "
    "comments, or under `made` in JSON.")  # fmt: skip
NO_REST = note("plan-no-rest",
    "found no rest of the part: the program makes all of it",
    "Nothing is left for another machine, so no file of it is written.")  # fmt: skip
SPLIT = note("plan-split",
    "made by {found} program(s), on {machines}",
    "Each machine gets what the one before leaves. The shortest chain is taken, in it first the "
    "machine that leaves least.")  # fmt: skip


def rest_of_part(posted: Posted, target: Target) -> tuple[Part, str] | None:
    """What a program leaves of its part, as it is read again, and its text; None if nothing.

    Its features have their places in the file of the part.

    The program has to be that of one part. Raises VerifyError where program and rest together are
    not that part, BeamcamError for what the format cannot hold.
    """
    job = posted.job
    (part,) = job.request.parts
    # The read-back of the program has found these missing, and no others.
    missing = {o.feature[1] for o in unfinished(posted.plan.outcomes) if o.how in NOT_MADE}
    if not missing:
        return None
    begun = begun_part(part, posted.plan, job.machine)
    file = os.path.basename(part.source.file)  # alone: the text is the same from any folder

    def named(things: Iterable[Sourced]) -> tuple[Sourced, ...]:
        return tuple(replace(one, source=replace(one.source, file=file)) for one in things)

    (whole,) = named((begun,))
    made = None if begun.made is None else named(begun.made)
    features, planes = named(begun.features), named(begun.planes)
    text = target.write(replace(whole, features=features, planes=planes, made=made))
    rest = _read(text, target)
    faults = tuple(rest_faults(_placed(_read(target.write(part), target), part), rest, missing))
    if faults:
        raise VerifyError(faults)
    return _placed(rest, begun), text


def _placed(again: Part, part: Part) -> Part:
    """A part that was read again, its features where they stood in the file before."""

    def placed(features: Sequence[Feature], of: Sequence[Feature]) -> tuple[Feature, ...]:
        return tuple(replace(f, source=o.source) for f, o in zip(features, of, strict=True))

    made = None if part.made is None else placed(again.made or (), part.made)
    features = placed(again.features, part.features)
    return replace(again, source=part.source, features=features, made=made)


# --- chains ---------------------------------------------------------------------------------------

# Machines one after the other, where none makes all of a part: each gets what the others leave.
#
# part -> the machine that leaves least -> rest -> the next one ... -> the one that makes the rest


LONGEST = 3  #: machines of a chain


class ChainLink(Struct, frozen=True):
    """A machine of a chain, and what it is asked for."""

    machine: Machine
    part: Part  #: as this machine gets it
    skips: tuple[str, ...]  #: kinds that it leaves to the next one; of the last, those asked for


def chain_of(request: Request, machines: Sequence[Machine]) -> tuple[ChainLink, ...]:
    """The shortest chain that makes the only part of a request, of 3 machines at most, or none.

    The last one leaves out only what the request allows. Of machines that leave equally many
    features the first in order is taken, or the quickest where the request is `by` time, and none
    twice.
    """
    (part,) = request.parts
    for count in range(1, min(len(machines), LONGEST) + 1):
        links = next(_chains(request, part, machines, count), ())
        if links:
            return links
    return ()


def _chains(
    request: Request, part: Part, machines: Sequence[Machine], count: int
) -> Iterator[tuple[ChainLink, ...]]:
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
            yield (ChainLink(machine, part, request.skips),)
            continue
        kinds = {o.by.removeprefix("plan-") for o in plan.outcomes if o.how == "skipped"}
        skips = tuple(sorted(kinds & {*SKIP_NAMES}))
        makes_nothing = part.made is not None and left == len(part.features)
        if makes_nothing or _planned(request, part, machine, skips) is None:
            continue
        others = [one for one in machines if one is not machine]
        for rest in _chains(request, begun_part(part, plan, machine), others, count - 1):
            yield (ChainLink(machine, part, skips), *rest)


def _planned(
    request: Request, part: Part, machine: Machine, skips: Sequence[str]
) -> tuple[AnyPlan, float] | None:
    """The plan of one such part and its seconds, 0 where time does not count.

    None where the machine refuses it.
    """
    trial = replace(request, parts=(part,), machine=machine, skips=tuple(skips), quantity=None)
    job = Job(trial, (0,), max(request.stock, default=None))
    try:
        plan = post_of(machine).plan(job)
        return plan, plan_seconds(plan, job) if request.by == "time" else 0.0
    except PlanError:
        return None


class Stage(Struct, frozen=True):
    """A program of a chain of machines, and what it leaves to the next one."""

    posted: Posted
    rest: str = ""  #: the text of the file; "" of the last
    passed_on: int = 0  #: features in it

    @property
    def plan(self) -> AnyPlan:
        """The plan with the outcomes of what the next machine does not get."""
        plan = self.posted.plan
        if not self.rest:
            return plan
        return replace(plan, outcomes=tuple(o for o in plan.outcomes if o.how not in NOT_MADE))

    @property
    def remarks(self) -> tuple[Diagnostic, ...]:
        """The remarks on the program, but on what the next machine gets."""
        left = (LEFT_OUT.code, MANUAL_WORK.code) if self.rest else ()
        return tuple(one for one in self.posted.remarks if one.code not in left)


def chain_for(
    request: Request, machines: Sequence[Machine]
) -> tuple[tuple[ChainLink, ...], tuple[Diagnostic, ...]]:
    """The chain that makes the only part of a request, and a note. Raises PlanError for none."""
    chain = chain_of(request, machines)
    if not chain:
        refused = []
        for machine in machines:
            why: tuple[Diagnostic, ...] = ()
            # It leaves to others what it has no tool for; of one that leaves it so, what it leaves.
            for skips in (request.skips, SKIP_NAMES):
                try:
                    begin(replace(request, machine=machine, skips=skips))
                except PlanError as error:
                    why = tuple(error.diagnostics)
            refused.append((machine, why))
        raise PlanError(none_makes_it(refused, request.parts[0].source))
    names = ", then ".join(link.machine.name for link in chain)
    return chain, (SPLIT.at(request.parts[0].source, found=len(chain), machines=names),)


def stages_of(request: Request, chain: Sequence[ChainLink], target: Target) -> Iterator[Stage]:
    """The programs of a chain for the only part of a request, in order.

    Each part but the first is the rest that the program before leaves, as it is read again. Raises
    as `begin`, `finished` and `rest_of_part` do.
    """
    (part,) = request.parts
    for k, link in enumerate(chain, 1):
        rest_request = replace(request, parts=(part,), machine=link.machine, skips=link.skips)
        (begun,) = begin(rest_request)
        posted = finished(begun)
        if k == len(chain):
            yield Stage(posted)
            return
        rest = rest_of_part(posted, target)
        if rest is None:
            raise AssertionError("a machine of a chain leaves nothing")
        part, text = rest
        yield Stage(posted, text, len(part.features))


def _read(text: str, target: Target) -> Part:
    """The part of a text that was written here. Raises ReadError."""
    reading = read(text.encode(), f"rest{target.suffixes[0]}")
    if errors_in(reading.diagnostics) or len(reading.parts) != 1:
        raise ReadError(reading.diagnostics)
    return reading.parts[0]
