"""Programs read back: an interpreter for every controller family, and the part compared.

Written from the controllers' documentation and the machine file; it shares no code with
planning, motion or the emitters, so that a fault of theirs cannot hide in it.

    text -> blocks -> events (codesys) -> Made (cell) -> compared with the parts
        `------ passages, where all of it is known ------'
"""

from collections.abc import Callable, Collection, Sequence

from msgspec import Struct

from beamcam.errors import Diagnostic, VerifyError, errors_in
from beamcam.machine.known import Kept, OncePerMachine
from beamcam.machine.machine import Machine, NumberFormat
from beamcam.model.part import Part, Profile
from beamcam.verify import codesys
from beamcam.verify.blocks import Block, read_blocks
from beamcam.verify.cell import Cell
from beamcam.verify.compare import compare
from beamcam.verify.events import Event
from beamcam.verify.made import Bore, Cut, Made
from beamcam.verify.meaning import Meaning, meaning_of
from beamcam.verify.needs import FeatureRef
from beamcam.verify.passages import Passages
from beamcam.verify.rack import Rack
from beamcam.verify.skips import skippable
from beamcam.verify.stations import Choice, choices_of

__all__ = [
    "Bore", "Cut", "FeatureRef", "Made", "Run", "events_of", "interpret", "run", "skippable",
    "verify",
]  # fmt: skip

MOST_SECTIONS = 256  #: of which the places of the spindles are kept

#: Interpreter of each controller family.
INTERPRETERS: dict[
    str, Callable[[list[Block], str, NumberFormat], tuple[list[Event], list[Diagnostic]]]
] = {
    "codesys": codesys.run,
}


class Run(Struct, frozen=True):
    """A program that was interpreted."""

    made: Made
    events: tuple[Event, ...]
    diagnostics: tuple[Diagnostic, ...]  #: what is wrong with it by itself
    meaning: Meaning
    choices: dict[int, Choice]


class _Known:
    """What is worked out once for a machine and a section."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.meaning = meaning_of(machine)
        self.choices: Kept[Profile | None, dict[int, Choice]] = Kept(MOST_SECTIONS)
        self.passages = Passages(machine, self.meaning)
        self.rack = Rack(machine, machine.drill) if machine.drill else None

    def choices_for(self, profile: Profile | None) -> dict[int, Choice]:
        known = self.choices.get(profile)
        if known is not None:
            return known
        return self.choices.keep(profile, choices_of(self.machine, profile))


_known_of = OncePerMachine(_Known)


def events_of(
    text: str, machine: Machine, name: str = "program"
) -> tuple[list[Event], list[Diagnostic]]:
    """What a program does, event by event, and what is wrong with its blocks."""
    blocks, said = read_blocks(text, name, _known_of(machine).meaning.letters)
    events, more = INTERPRETERS[machine.controller](blocks, name, machine.format)
    return events, said + more


def run(text: str, machine: Machine, profile: Profile | None = None, name: str = "program") -> Run:
    """A program interpreted on a bar of `profile`; what material is in the way is known by it."""
    known = _known_of(machine)
    events, said = events_of(text, machine, name)
    choices = known.choices_for(profile)
    if profile is None:
        # A program says a part of its section, enough to tell where its holes lie.
        profile = _section_of(events, known.meaning)
        choices = choices_of(machine, profile)
        cell = Cell(machine, known.meaning, choices, None, name)
    else:
        cell = Cell(machine, known.meaning, choices, profile, name)
    made = cell.run(events, text.count("\n"))
    return Run(made, tuple(events), (*said, *cell.said), known.meaning, choices)


def _section_of(events: Sequence[Event], meaning: Meaning) -> Profile:
    """The section as far as a program says it."""
    from beamcam.verify.events import Switch

    said: dict[str, float] = {}
    for event in events:
        if type(event) is Switch:
            word = meaning.m_words.get(event.number)
            if word is not None and word.role == "section":
                said |= {f: event.words[at] for at, f in word.fields if at in event.words}
    return Profile("SO", "", said.get("height", 0.0), said.get("width", 0.0), 0.0, None)


def interpret(text: str, machine: Machine, name: str = "program") -> Made:
    """What a program makes. Raises VerifyError if something in it is wrong by itself."""
    done = run(text, machine, None, name)
    if errors_in(done.diagnostics):
        raise VerifyError(done.diagnostics)
    return done.made


def verify(
    text: str,
    parts: Sequence[Part],
    machine: Machine,
    skips: Collection[str] = (),
    name: str = "program",
    order: str = "given",
    turn: bool = False,
    bar: float | None = None,
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with a program, by itself and against the parts on its bar.

    The parts are those that were asked for, in the order asked; `order` and `turn` say whether
    they may lie in another one and turned, `skips` names the kinds of features that may be left
    out, `bar` is the bar's length. Nothing comes back for a program that makes exactly the parts.
    """
    if not parts:
        return run(text, machine, None, name).diagnostics
    known = _known_of(machine)
    if known.rack is None or machine.saw is None:
        raise TypeError(f"{machine.name} has no saw and drill")
    profile = parts[0].profile
    choices = known.choices_for(profile)
    said: tuple[Diagnostic, ...] = ()
    made = known.passages.made(text, profile, choices)
    if made is None:
        done = run(text, machine, profile, name)
        made, said = done.made, done.diagnostics
    free = order != "given"
    if turn or free:
        parts = _as_laid(made, parts, machine, free, turn, known.rack)
        choices = known.choices_for(parts[0].profile)
        if parts[0].profile != profile:
            done = run(text, machine, parts[0].profile, name)
            made, said = done.made, done.diagnostics
    skipped = skippable(parts, machine, skips) if skips else ()
    more = compare(made, parts, machine, known.rack, known.meaning, choices, skipped, name)
    return (*said, *more)


def _as_laid(
    made: Made, parts: Sequence[Part], machine: Machine, free: bool, turn: bool, rack: Rack
) -> Sequence[Part]:
    """The parts in their order on the bar and as they lie there; as given where that fails."""
    from beamcam.verify.bars.layout import lay_out
    from beamcam.verify.bars.pieces import pieces, planes

    assert machine.saw is not None

    def faults(part: Part, start: float) -> int:
        x = start + rack.drill.x
        return sum(
            not any(
                b.face == h.face and abs(b.x - x - h.x) <= 0.2 and abs(b.y - h.y) <= 0.2
                and abs(b.diameter - h.diameter) <= 1.0
                for b in made.bores
            )
            for h in part.holes
        )  # fmt: skip

    found = pieces(planes(made.cuts, machine.saw, parts[0].profile))
    laid = lay_out(found, parts, machine, machine.saw, free, turn, faults)
    return [one.part for one in laid] if len(laid) == len(parts) else parts
