"""The machine that makes parts, of those in a shop: the one that leaves out fewest features."""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import Generic, TypeVar, overload

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Source, error, errors_in, note
from beamcam.machine.machine import Machine
from beamcam.model.plan import clock
from beamcam.model.request import Request
from beamcam.planning.left_out import SKIP_NAMES
from beamcam.posts import Planned, plan_seconds

CHOSEN = note("plan-machine",
    "made on {found}; {others}",
    "Where no machine is named, those of the configuration, or else the shipped ones, are tried in "
    "their order. The first that makes all of a part takes it, under --by time the quickest of "
    "those that do; where none does, the one that leaves out fewest of the features that may be "
    "left out. A torch round the profile takes what no line makes that saws and drills. --machine "
    "names one.")  # fmt: skip
NONE_MAKES_IT = error("plan-no-machine",
    "found no machine that makes the whole part ({found}); expected one",
    "Each machine that was tried is listed with the codes of what it cannot make. The messages "
    "above are those of one that takes the section, and of these of one that refuses more than "
    "what it has no tool for, as that is what stands in the way of all. `beamcam codes CODE` "
    "explains a code and the ways out.")  # fmt: skip
#: What a machine says of a part that is not for it at all.
NOT_FOR_IT = ("plan-stock", "plan-section", "plan-section-shape", "plan-unrolled")
FOR_ANOTHER = frozenset(f"plan-{name}" for name in SKIP_NAMES)  #: what another machine may make


class InTurn(Sequence[Machine]):
    """Machines in the order they are tried, each loaded when its turn comes."""

    def __init__(self, names: Sequence[str], load: Callable[[str], Machine]) -> None:
        self._names, self._load = names, load
        self._loaded: dict[str, Machine] = {}

    def __len__(self) -> int:
        return len(self._names)

    @overload
    def __getitem__(self, index: int) -> Machine: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Machine]: ...
    def __getitem__(self, index: int | slice) -> Machine | Sequence[Machine]:
        if isinstance(index, slice):
            return InTurn(self._names[index], self._load)
        name = self._names[index]
        if name not in self._loaded:
            self._loaded[name] = self._load(name)
        return self._loaded[name]


Made = TypeVar("Made", bound=Planned)


class Able(Struct, Generic[Made]):
    """A machine that is not refused what is asked for, and the programs that it makes of it."""

    machine: Machine
    made: Sequence[Made]
    left_out: int  #: features, as is allowed
    seconds: float | None  #: of all programs; None where time does not count

    @property
    def rank(self) -> tuple[int, bool, float]:
        """The less, the better: what a line saws and drills is not burnt for being quicker."""
        return self.left_out, self.machine.stock == "profile", self.seconds or 0.0

    def __str__(self) -> str:
        """What it leaves out and how long it takes, as far as either counts."""
        words = [f"leaves out {self.left_out}"] if self.left_out else []
        words += [] if self.seconds is None else [clock(self.seconds)]
        return f"{self.machine.name} ({', '.join(words)})" if words else self.machine.name


def on_best_machine(
    request: Request, machines: Sequence[Machine], attempt: Callable[[Request], Sequence[Made]]
) -> tuple[Sequence[Made], tuple[Diagnostic, ...]]:
    """What `attempt` gives on the machine that leaves out fewest features; a note of the choice.

    Of equal ones that is the first in order, or the quickest where the request is `by` time, and a
    line that saws and drills goes before a torch round the profile. A machine that makes all of
    the parts goes before one that leaves out what is allowed. In order no machine behind the first
    that makes all is planned on, or loaded. Only what a machine cannot make (PlanError) has another
    one taken. Where none makes it the PlanError has what the one said that lacks least, and for
    each machine why.
    """
    if request.skips and len(machines) > 1:
        with suppress(PlanError):
            best, diagnostics = _best(replace(request, skips=()), machines, attempt)
            return attempt(replace(request, machine=best.machine)), diagnostics
    best, diagnostics = _best(request, machines, attempt)
    return best.made, diagnostics


def _best(
    request: Request, machines: Sequence[Machine], attempt: Callable[[Request], Sequence[Made]]
) -> tuple[Able[Made], tuple[Diagnostic, ...]]:
    source = request.parts[0].source if request.parts else Source("beamcam")
    by_time = request.by == "time" and len(machines) > 1
    able: list[Able[Made]] = []
    refused: list[tuple[Machine, tuple[Diagnostic, ...]]] = []
    for machine in machines:
        if machine.stock == "profile" and any(one.rank < (0, True) for one in able):
            continue
        try:
            made = attempt(replace(request, machine=machine))
            seconds = sum(plan_seconds(one.plan, one.job) for one in made) if by_time else None
        except PlanError as error:
            refused.append((machine, tuple(error.diagnostics)))
            continue
        if not (by_time or request.skips):
            able.append(Able(machine, made, 0, None))
            break
        left_out = sum(o.how == "skipped" for one in made for o in one.plan.outcomes)
        able.append(Able(machine, made, left_out, seconds))
    if not able:
        raise PlanError(none_makes_it(refused, source))
    best = min(able, key=lambda one: one.rank)  # the first of equal ones
    others = [str(one) for one in able if one is not best]
    others += [f"{machine.name} cannot: {_codes(diagnostics)}" for machine, diagnostics in refused]
    return best, (CHOSEN.at(source, found=best, others="; ".join(others)),) if others else ()


def none_makes_it(
    refused: Sequence[tuple[Machine, Sequence[Diagnostic]]], source: Source
) -> tuple[Diagnostic, ...]:
    """Messages where every machine refuses: those of a single machine, or a summary of several."""
    least = min(refused, key=lambda one: _distance(one[1]))[1]
    if len(refused) == 1:
        return tuple(least)
    found = "; ".join(f"{machine.name}: {_codes(diagnostics)}" for machine, diagnostics in refused)
    return (*least, NONE_MAKES_IT.at(source, found=found))


def _distance(diagnostics: Iterable[Diagnostic]) -> tuple[bool, bool, int]:
    """How little the messages of a machine say of why none makes a part."""
    codes = [one.code for one in errors_in(diagnostics)]
    not_for_it = any(code in NOT_FOR_IT for code in codes)
    return not_for_it, FOR_ANOTHER.issuperset(codes), len(codes)


def _codes(diagnostics: Iterable[Diagnostic]) -> str:
    return ", ".join(dict.fromkeys(one.code for one in errors_in(diagnostics)))
