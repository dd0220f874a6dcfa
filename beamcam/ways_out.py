"""The ways out of a refusal: options with which it can be made, each tried before it is named."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import chain, islice

from msgspec.structs import replace

from beamcam.errors import BeamcamError, Diagnostic, Rule, Severity, Source, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.plan import Plan, SheetPlan
from beamcam.planning.rules import SKIP_NAMES
from beamcam.posts import Job, post_of
from beamcam.readers.reading import Reading

LONG_BARS = (6000.0, 12000.0, 15000.0, 18000.0)  #: mm that mills roll and stockists keep

WAYS_OUT = Rule(
    "plan-ways-out",
    Severity.NOTE,
    "with {found} it can be made",
    "Each option was tried before it was named. The machine may belong to another shop; what "
    "--allow-skips leaves out is missing from the part.",
)
NO_WAY_OUT = Rule(
    "plan-no-way-out",
    Severity.NOTE,
    "found no way out: no shipped machine makes it, not even with features left out",
    "The drawing or the part has to change, or a machine file of one's own says that a machine can "
    "do more.",
)
WAYS_TO_READ = Rule(
    "read-ways-out",
    Severity.NOTE,
    "with {found} it can be read",
    "The option was tried before it was named. Look whether it says what the drawing means: the "
    "size of the work follows from it.",
)
NO_WAY_TO_READ = Rule(
    "read-no-way-out",
    Severity.NOTE,
    "found no way out: no option reads the file as it stands; expected it corrected where the "
    "messages say",
    "Whoever wrote the file has to export it again; a guess would make another part.",
)
RULES = (WAYS_OUT, NO_WAY_OUT, WAYS_TO_READ, NO_WAY_TO_READ)
#: Options of the readers, as on a command line and as they take them, by the file's format.
_READING: Mapping[str, Sequence[tuple[str, Mapping[str, object]]]] = {
    "dxf": (("--units mm", {"units": "mm"}), ("--units in", {"units": "in"})),
    "svg": (
        ("--units px96", {"units": "px96"}), ("--units mm", {"units": "mm"}),
        ("--width 100mm", {"width": "100mm"}),
    ),
}  # fmt: skip


def ways_to_read(
    said: Iterable[Diagnostic], read: Callable[..., Reading], strict: bool
) -> Iterator[Diagnostic]:
    """A note behind the errors of a file that was not read: the option that helps, if there is one.

    `read` takes the file's path and options of its reader. Of a file with members that were read
    nothing is said.
    """
    wrong = errors_in(said)
    if not wrong or strict or any(one.code.startswith(("plan-", "ifc-")) for one in wrong):
        return
    source = Source(wrong[0].source.file)
    form = next((name for name in _READING if wrong[0].code.startswith(name)), "")
    for words, options in _READING.get(form, ()):
        try:
            reading = read(source.file, **options)
        except BeamcamError:
            continue
        if reading.parts and not errors_in(reading.diagnostics):
            yield WAYS_TO_READ.at(source, found=words)
            return
    if wrong[0].code.startswith(("dstv-", "json-", "read-empty", "drawing-", *_READING)):
        yield NO_WAY_TO_READ.at(source)


def ways_out(
    parts: Sequence[Part], tried: Sequence[Machine], others: Iterable[Machine],
    lengths: Sequence[float] = (), skips: Collection[str] = (),
) -> Diagnostic:  # fmt: skip
    """A note with the options that make refused `parts`, as written on a command line.

    `tried` are the machines that refused them, on bars of the `lengths` in store; `others` are
    those that could be named.
    """
    source = parts[0].source if parts else Source("beamcam")
    bar = max(lengths, default=None)
    found = [*_first(_by_thickness(parts, machine, skips) for machine in tried)] or [
        *_first(_by_placing(parts, machine, skips) for machine in tried),
        *(f"--machine {machine.name}" for machine in others if _made(parts, machine, bar, skips)),
        *_first(_by_leave(parts, machine, bar, skips) for machine in tried),
        *_first(_by_bar(parts, machine, bar, skips) for machine in tried),
        *_first(_by_turning(parts, machine, bar, skips) for machine in tried),
    ]
    return WAYS_OUT.at(source, found=" or ".join(found)) if found else NO_WAY_OUT.at(source)


def _first(found: Iterable[Iterator[str]]) -> Iterator[str]:
    """The first option, of those that help on one machine or another."""
    return islice(chain.from_iterable(found), 1)


def _made(
    parts: Sequence[Part], machine: Machine, bar: float | None, skips: Collection[str],
    turn: bool = False,
) -> Plan | SheetPlan | None:  # fmt: skip
    """The plan of the parts; None where the machine refuses them."""
    try:
        job = Job(tuple(parts), machine, bar=bar, skips=tuple(skips), turn=turn)
        return post_of(machine).plan(job)
    except BeamcamError:
        return None


def _by_thickness(parts: Sequence[Part], machine: Machine, skips: Collection[str]) -> Iterator[str]:
    """The least thickness of the machine's cut chart that would do, where none is known."""
    torch = machine.torch
    if torch is None or torch.thickness or any(part.profile.web_thickness for part in parts):
        return
    for thickness in sorted({row.up_to for row in torch.rows}):
        known = replace(machine, torch=replace(torch, thickness=thickness))
        if _made(parts, known, None, skips) is not None:
            yield f"--thickness {thickness:g}"
            return


def _by_placing(parts: Sequence[Part], machine: Machine, skips: Collection[str]) -> Iterator[str]:
    """The corner of the table, where work that is left where it is drawn is refused."""
    torch = machine.torch
    if torch is not None and torch.place == "drawn":
        moved = replace(machine, torch=replace(torch, place="corner"))
        if _made(parts, moved, None, skips) is not None:
            yield "--place corner"


def _by_leave(
    parts: Sequence[Part], machine: Machine, bar: float | None, skips: Collection[str]
) -> Iterator[str]:
    """The fewest kinds of features that have to be left out."""
    plan = _made(parts, machine, bar, SKIP_NAMES)
    if plan is None:
        return
    left = {o.by.removeprefix("plan-") for o in plan.outcomes if o.how == "skipped"}
    names = ",".join(sorted({*skips, *(left & {*SKIP_NAMES})}))
    if names and _made(parts, machine, bar, names.split(",")) is not None:
        yield f"--allow-skips {names}"


def _by_bar(
    parts: Sequence[Part], machine: Machine, bar: float | None, skips: Collection[str]
) -> Iterator[str]:
    """The shortest bar that would do, where the parts are refused for their bar."""
    for length in LONG_BARS:
        if machine.stock == "beam" and length != bar and _made(parts, machine, length, skips):
            yield f"--bar {length:g}"
            return


def _by_turning(
    parts: Sequence[Part], machine: Machine, bar: float | None, skips: Collection[str]
) -> Iterator[str]:
    if machine.stock == "beam" and _made(parts, machine, bar, skips, turn=True) is not None:
        yield "--turn"
