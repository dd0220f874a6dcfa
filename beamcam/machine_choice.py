"""The machine that makes parts, of those in a shop: the first in order that makes all of them."""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import TypeVar, overload

from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Source, error, errors_in, note
from beamcam.machine.machine import Machine
from beamcam.model.request import Request

Made = TypeVar("Made")

CHOSEN = note("plan-machine",
    "made on {found}; {others}",
    "Where no machine is named, those of the configuration, or else the shipped ones, are tried in "
    "their order. The first that makes all of a part takes it. --machine names one.")  # fmt: skip
NONE_MAKES_IT = error("plan-no-machine",
    "found no machine that makes the whole part ({found}); expected one",
    "Each machine that was tried is listed with the codes of what it cannot make. The messages "
    "above are those of the machine that lacks least. `beamcam codes CODE` explains a code and the "
    "ways out.")  # fmt: skip
RULES = (CHOSEN, NONE_MAKES_IT)


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


def first_that_makes(
    request: Request, machines: Sequence[Machine], attempt: Callable[[Request], Made]
) -> tuple[Made, tuple[Diagnostic, ...]]:
    """What `attempt` gives for the first machine that it is not refused on; a note of the choice.

    A machine that makes all of the parts goes before one that leaves out what is allowed. Only what
    a machine cannot make (PlanError) has the next one tried. Where none makes it the PlanError has
    what the one said that lacks least, and for each machine why.
    """
    source = request.parts[0].source if request.parts else Source("beamcam")
    if request.skips and len(machines) > 1:
        with suppress(PlanError):
            machine, _, said = _first(replace(request, skips=()), machines, attempt, source)
            return attempt(replace(request, machine=machine)), said
    _, made, said = _first(request, machines, attempt, source)
    return made, said


def _first(
    request: Request, machines: Sequence[Machine], attempt: Callable[[Request], Made],
    source: Source,
) -> tuple[Machine, Made, tuple[Diagnostic, ...]]:  # fmt: skip
    refused: list[tuple[Machine, tuple[Diagnostic, ...]]] = []
    for machine in machines:
        try:
            made = attempt(replace(request, machine=machine))
        except PlanError as error:
            refused.append((machine, tuple(error.diagnostics)))
            continue
        said = (chosen(machine, refused, source),) if refused else ()
        return machine, made, said
    raise PlanError(none_makes_it(refused, source))


def chosen(
    machine: Machine, refused: Iterable[tuple[Machine, Sequence[Diagnostic]]], source: Source
) -> Diagnostic:
    """The note that a later machine in the order takes a part."""
    others = "; ".join(f"{m.name} cannot: {_codes(said)}" for m, said in refused)
    return CHOSEN.at(source, found=machine.name, others=others)


def none_makes_it(
    refused: Sequence[tuple[Machine, Sequence[Diagnostic]]], source: Source
) -> tuple[Diagnostic, ...]:
    """Messages where every machine refuses: those of a single machine, or a summary of several."""
    least = min(refused, key=lambda one: len(errors_in(one[1])))[1]
    if len(refused) == 1:
        return tuple(least)
    found = "; ".join(f"{machine.name}: {_codes(said)}" for machine, said in refused)
    return (*least, NONE_MAKES_IT.at(source, found=found))


def _codes(said: Iterable[Diagnostic]) -> str:
    return ", ".join(dict.fromkeys(one.code for one in errors_in(said)))
