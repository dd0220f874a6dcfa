"""Programs for bars read back: what they make, what would break, and the parts compared.

    text -> events (controllers) -> machined features (cell) -> pieces of bar (pieces) -> compared

Nothing of it comes from a plan: which piece of the bar is which part, how it lies, and what may be
missing, the read-back finds out from the program, the parts, the machine and the request.
"""

from collections.abc import Collection, Sequence
from functools import partial
from math import hypot
from operator import attrgetter

from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import PerObject, cached
from beamcam.checks import rules
from beamcam.checks.bars.cell import Cell
from beamcam.checks.bars.compare import Comparison, RequiredParts
from beamcam.checks.bars.machine_limits import bar_faults, bore_faults, reach_faults, size_faults
from beamcam.checks.bars.magazine import Changed, Chosen, comment_faults, stop_comments
from beamcam.checks.bars.orientations import orientations
from beamcam.checks.bars.stations import Choice, MachinedFeatures, choices_of, lip_length
from beamcam.checks.bars.tools import CuttingData, ToolCatalogue, place_faults
from beamcam.checks.job import Head, head_of, part_faults, stock_faults
from beamcam.controllers import cell_events
from beamcam.controllers.dialect import Dialect, dialect_of
from beamcam.controllers.events import BarEvent, Switch
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.machine.machine import Machine, drill_of
from beamcam.model.description import description
from beamcam.model.part import Hole, Part, Profile, Slot
from beamcam.model.request import rolled_on
from beamcam.model.rounds import unseen


class BarRun(Struct, frozen=True):
    """A program that was interpreted."""

    made: MachinedFeatures
    events: tuple[BarEvent, ...]
    diagnostics: tuple[Diagnostic, ...]  #: what is wrong with it by itself
    dialect: Dialect
    choices: dict[int, Choice]
    unseen: tuple[str, ...] = ()  #: faces that it works on without saying where they lie
    tools: tuple[Chosen | Changed, ...] = ()  #: that it chooses, and its stops for them


class _Known:
    """Values computed once for a machine and a section."""

    def __init__(self, machine: Machine) -> None:
        self.dialect = dialect_of(machine)
        self.tools = ToolCatalogue(machine, drill_of(machine))
        grades = {row.grade for row in self.tools.drill.cutting}
        self.depends_on_grade = self.dialect.feeds and len(grades) > 1
        self.choices = cached("verify.stations")(partial(choices_of, machine))
        self.data = cached("verify.grades")(partial(CuttingData, machine, self.tools.drill))


_known_of = PerObject("verify.machines", _Known)


def run(
    text: str, machine: Machine, profile: Profile | None = None, name: str = "program",
    grades: tuple[str, ...] | None = None, lip: float = 0.0,
) -> BarRun:  # fmt: skip
    """A program interpreted on a bar of `profile` with lips of a length, of steel of some grades.

    Where they are not given, the section is what the program says, and any grade may be meant.
    """
    known = _known_of(machine)
    events, diagnostics = cell_events(text, machine, name)
    if profile is None and known.dialect.section_fields:
        profile = section_stated(events, known.dialect, machine)
    done = run_of_events(events, machine, profile, name, grades, lip)
    diagnostics += done.diagnostics
    if "station" in text.lower():  # which the comments at stops name
        diagnostics += comment_faults(stop_comments(text), done.tools, machine, name)
    return replace(done, diagnostics=tuple(diagnostics))


def run_of_events(
    events: Sequence[BarEvent], machine: Machine, profile: Profile | None, name: str,
    grades: tuple[str, ...] | None = None, lip: float = 0.0,
) -> BarRun:  # fmt: skip
    """What a program does whose blocks were read."""
    known = _known_of(machine)
    choices = known.choices(profile, lip)
    cell = Cell(machine, known.dialect, choices, known.data(grades), name)
    made = cell.run(events)
    diagnostics = (*cell.diagnostics, *place_faults(made, machine, name))
    return BarRun(
        made, tuple(events), diagnostics, known.dialect, choices, tuple(sorted(cell.unseen)),
        tuple(cell.tools),
    )  # fmt: skip


def section_stated(events: Sequence[BarEvent], dialect: Dialect, machine: Machine) -> Profile:
    """The section as far as a program says it: what kind it is, and how high and wide.

    A number that may mean several kinds says none of them.
    """
    sizes: dict[str, float] = {}
    for event in events:
        if type(event) is Switch:
            word = dialect.m_words.get(event.number)
            if word is not None and word.role == "section":
                sizes |= {f: event.words[at] for at, f in word.fields if at in event.words}
    codes = machine.sections_of(sizes.get("section", -1))
    code = codes[0] if len(codes) == 1 else "SO"
    height, width = sizes.get("height", 0.0), sizes.get("width", 0.0)
    return Profile(code, "", height, width, 0.0, None)  # type: ignore[arg-type]


def verify(
    text: str, parts: Sequence[Part], machine: Machine, skips: Collection[str] = (),
    name: str = "program", order: str = "given", turn: bool = False, bar: float | None = None,
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """All faults of a program, by itself and against the parts on its bar.

    The parts are those of the request, in its order; `order` and `turn` say whether
    they may lie in another one and turned, `skips` names the kinds of features that may be left
    out, `bar` is the bar's length. Nothing comes back for a program that makes exactly the parts.
    """
    known = _known_of(machine)
    if not parts:
        alone = run(text, machine, None, name)
        # How large the section is, the program says itself.
        section = section_stated(alone.events, alone.dialect, machine)
        large = (
            *size_faults(section, machine, name),
            *reach_faults(alone.made.cuts, section, machine, name),
            *bore_faults(alone.made, section, machine, name),
        )
        unseen = (rules.UNSEEN.at(Source(name), found=face) for face in alone.unseen)
        grade = [rules.UNKNOWN_STEEL.at(Source(name))] if known.depends_on_grade else []
        return (*alone.diagnostics, *large, *unseen, *grade)
    grades = tuple(dict.fromkeys(part.grade for part in parts))
    profile, lip = parts[0].profile, max(map(lip_length, parts))
    done = run(text, machine, profile, name, grades, lip)
    if turn:
        other = lying_section(done.made, parts[0])
        if other != profile:
            profile = other
            done = run(text, machine, profile, name, grades, lip)
    more = compared(done, parts, machine, profile, skips, name, order, turn, bar, head_of(text))
    return (*done.diagnostics, *more)


def compared(
    done: BarRun, parts: Sequence[Part], machine: Machine, profile: Profile, skips: Collection[str],
    name: str, order: str, turn: bool, bar: float | None, head: Head | None = None,
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """What is made otherwise than the parts on the bar have it, and what no machine can hold.

    Where nothing is, also what a `head` says otherwise.
    """
    known = _known_of(machine)
    job = RequiredParts(parts, skips, order != "given", turn, bar)
    comparison = Comparison(done.made, job, known.tools, profile, known.choices(profile, 0.0), name)
    diagnostics = (
        *comparison.run(),
        *bar_faults(comparison.laid, machine, comparison.saw, bar, name),
    )
    if head is None or errors_in(diagnostics):
        return diagnostics
    laid = sorted(comparison.laid, key=attrgetter("start"))
    lie = [(one.part, (one.start,)) for one in laid]
    return (
        *diagnostics, *stock_faults(head, parts, None, machine, name),
        *part_faults(head, lie, machine.format.resolution, job.free, name),
    )  # fmt: skip


def unseen_faults(parts: Sequence[Part], machine: Machine) -> tuple[Diagnostic, ...]:
    """Faults of round parts, as they were read: what no spindle or saw of a bar line can make.

    A drill goes `drill.breakthrough` beyond the wall in the middle of its hole. At its side the
    inside of a tube lies deeper.
    """
    faults = []
    for given in parts:
        part = rolled_on(machine, given)
        if not part.profile.is_round:
            continue
        size, beyond = part.profile, drill_of(machine).breakthrough
        wall = size.flange_thickness or size.web_thickness or 0.0
        unmade = {id(feature): feature for feature in unseen(part)}
        for feature in part.features if size.code == "RO" and wall else ():
            if not isinstance(feature, Hole | Slot) or feature.depth is not None:
                continue
            least = size.height / 2 - wall - beyond  # where the drill's edge ends, from the axis
            edge = hypot(least, feature.diameter / 2)
            if least > 0 and feature.kind != "mark" and edge > size.height / 2 - wall:
                unmade[id(feature)] = feature
        faults += [
            rules.ROUND.at(feature.source, found=description(feature), mark=part.mark)
            for feature in unmade.values()
        ]
    return tuple(faults)


def lying_section(made: MachinedFeatures, part: Part) -> Profile:
    """The section of a part as it lies by what the program says of it."""
    sizes = dict(made.section)
    size = sizes.get("height"), sizes.get("width")
    fitting = (p.profile for p in orientations(part) if (p.profile.height, p.profile.width) == size)
    return next(fitting, part.profile)
