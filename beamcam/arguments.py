"""What is asked for, checked before any work, for library and command line alike, and the machine
that makes it: the one that is named, or of several the one that leaves out fewest features.
"""

import os
from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from math import isfinite
from typing import TYPE_CHECKING, Generic, TypeVar

from msgspec import Struct
from msgspec.structs import replace

from beamcam.conversion import nearest, shown
from beamcam.errors import (
    BeamcamError,
    Diagnostic,
    MachineError,
    PlanError,
    Source,
    error,
    errors_in,
    note,
)
from beamcam.machine.load import files_of_machine, is_proved, load, source_in
from beamcam.machine.machine import Machine
from beamcam.machine.words import WORD
from beamcam.model.plan import ALL_SKIPS, SKIP_NAMES, clock
from beamcam.model.request import Request
from beamcam.plain_text import MAX_COMMENT, terminal_text
from beamcam.posts import Planned, plan_seconds

if TYPE_CHECKING:
    from beamcam.config.values import Config

ASK_TYPE = error("ask-type",
    "found {found} for {name}; expected {expected}",
    "A value of another type would be misread, or fail in the middle of the work.")  # fmt: skip
ASK_BAR = error("ask-bar",
    "found a bar of {found} mm; expected a finite length above 0, or none",
    "Without a length the bar is as long as the parts need.")  # fmt: skip
ASK_JOB = error("ask-job",
    "found the job name {found}; expected {expected}",
    "The name is written in the program's first line; a line end in it would turn the rest into "
    "blocks, and what a controller's line does not hold would be cut off.")  # fmt: skip
ASK_SKIP = error("ask-skip",
    "found {found!r} among the skips; expected {expected}",
    "A misspelt name would leave out nothing, or another kind than was meant.")  # fmt: skip


HERE = Source("beamcam")

AnyMachine = str | os.PathLike[str] | Machine  #: how a caller may say which machine is meant


class AskError(BeamcamError):
    """A request is invalid, whatever the parts are."""


def check_arguments(job: object = "JOB", bar: object = None, skips: object = ()) -> None:
    """Raise AskError for a job's name, a bar or names of skips that cannot be meant."""
    faults: list[Diagnostic] = []
    if not isinstance(job, str):
        faults.append(ask_type("job", job, "a text"))
    elif expected := expected_job(job):
        faults.append(ASK_JOB.at(HERE, found=shown(job), expected=expected))
    if bar is not None:
        if isinstance(bar, bool | str | bytes) or not hasattr(bar, "__float__"):
            faults.append(ask_type("bar", bar, "a number, or None"))
        elif not (isfinite(bar) and bar > 0):  # type: ignore[operator]
            faults.append(ASK_BAR.at(HERE, found=f"{bar}"))
    if isinstance(skips, str | bytes) or not isinstance(skips, Collection):
        faults.append(ask_type("skips", skips, "a list of names"))
    else:
        faults += (
            ASK_SKIP.at(HERE, found=name, expected=nearest(str(name), SKIP_NAMES))
            for name in skips
            if name not in SKIP_NAMES and name != ALL_SKIPS
        )
    if faults:
        raise AskError(faults)


def expected_job(job: str) -> str:
    """The expected form of a job's name that cannot be meant; "" of one that can."""
    if terminal_text(job) != job:
        return "one line of printable characters"
    return "" if len(job) <= MAX_COMMENT else f"{MAX_COMMENT} characters at most"


def machine_of(machine: AnyMachine) -> Machine:
    """The machine of that name or path; one that is a machine already is itself.

    Raises AskError for anything else, and MachineError.
    """
    if isinstance(machine, Machine):
        return machine
    if not isinstance(machine, str | os.PathLike):
        raise AskError(ask_type("machine", machine, "a name, the path of a file, or a Machine"))
    return load_tested(str(os.fspath(machine)))


def load_tested(name: str) -> Machine:
    """The machine called `name`, or the one in the file at that path, whose programs can be read.

    Raises MachineError.
    """
    if is_proved(files_of_machine(name)):
        return load(name)
    machine = load_machine(name)
    from beamcam.self_test import known_proof_faults

    _refuse_words(name, known_proof_faults(machine)[:1])
    return machine


def load_machine(name: str) -> Machine:
    """The machine called `name`, or the one in the file at that path, whose words can be read.

    Raises MachineError.
    """
    from beamcam.controllers.machine_words import known_faults

    machine = load(name)
    _refuse_words(name, known_faults(machine))
    return machine


def for_job(machine: Machine, config: "Config") -> Machine:
    """A machine with the tolerances, the map and the sheet of a job.

    Raises ConfigError and PlanError for what it cannot do.
    """
    from beamcam.machine.overlay import with_section, with_torch

    if config.tolerances.given():
        from beamcam.config.load import with_tolerances

        machine = with_tolerances(machine, config)
    machine = with_section(machine, config.corner, config.lip)
    try:
        return with_torch(
            machine, config.meanings, settings=config.layer_settings, **config.sheet.given()
        )
    except ValueError as error:
        from beamcam.config.values import COMMAND_LINE
        from beamcam.planning.contours.rules import OPTION

        sources = (config.sources.get(f"sheet.{name}") for name in config.sheet.given())
        places = (one for one in sources if one not in (None, COMMAND_LINE))
        place = next(places, None) or Source(machine.name)
        raise PlanError(OPTION.at(place, found=error)) from error


def _refuse_words(name: str, faults: Iterable[tuple[str, str, str]]) -> None:
    """Raises MachineError for words of a machine file: by key, text and fault of each."""
    if wrong := [WORD.at(source_in(name, k, text), key=k, said=said) for k, text, said in faults]:
        raise MachineError(wrong)


def ask_type(name: str, value: object, expected: str) -> Diagnostic:
    """What is said of a value of another type than the call takes."""
    found = f"{type(value).__name__} {value!r:.60}" if value is not None else "None"
    return ASK_TYPE.at(HERE, name=name, found=found, expected=expected)


# --- choice ---------------------------------------------------------------------------------------

# Of several machines the one that makes all of the parts, or leaves out fewest features.


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

    def __getitem__(self, index: int) -> Machine:  # type: ignore[override]  # no slices of it
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
    one taken. Where none makes it the PlanError has what the one said that refuses least, and for
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

    def distance(one: tuple[Machine, Sequence[Diagnostic]]) -> tuple[bool, bool, int]:
        codes = [diagnostic.code for diagnostic in errors_in(one[1])]
        return not {*codes}.isdisjoint(NOT_FOR_IT), FOR_ANOTHER.issuperset(codes), len(codes)

    least = min(refused, key=distance)[1]  # that says most of why none makes the part
    if len(refused) == 1:
        return tuple(least)
    found = "; ".join(f"{machine.name}: {_codes(diagnostics)}" for machine, diagnostics in refused)
    return (*least, NONE_MAKES_IT.at(source, found=found))


def _codes(diagnostics: Iterable[Diagnostic]) -> str:
    return ", ".join(dict.fromkeys(one.code for one in errors_in(diagnostics)))
