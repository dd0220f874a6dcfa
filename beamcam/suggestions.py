"""The ways out of a refusal: options with which it can be made, each tried before it is named."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any

from msgspec.structs import replace

from beamcam.errors import BeamcamError, Diagnostic, PlanError, Source, errors_in, note
from beamcam.machine.machine import Machine
from beamcam.machine.torch import OTHERS, Torch
from beamcam.model.part import Contour, TextMark
from beamcam.model.plan import SKIP_NAMES, AnyPlan
from beamcam.model.request import Job, Request
from beamcam.planning.beam import MOST_TRIED
from beamcam.planning.contours.rules import SHARED, UNMAPPED
from beamcam.posts import post_of
from beamcam.readers import Reading
from beamcam.rest_part import chain_of

LONG_BARS = (6000.0, 12000.0, 15000.0, 18000.0)  #: mm that mills roll and stockists keep
GAPS = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0)  #: mm between ends that may be meant to meet
MOST_CURVES = 2_000  #: of a drawing for which ways out are looked for
MOST_WORK = 9_000  #: curves and features that are planned together, in all tries
TEXT_WORK = 20  #: curves whose planning is as much work as that of a text
MANY_TRIES = 50  #: as a search has at most, about
ROTATED_DEG = 15  #: from one turn that is tried to the next
UNITS = ("mm", "in")  #: that drawings are made in

SUGGESTIONS = note("plan-ways-out",
    "with {found} it can be made",
    "Each option was tried before it was named. The machine may belong to another shop; what "
    "--allow-skips leaves out is missing from the part.")  # fmt: skip
NO_WAY_OUT = note("plan-no-way-out",
    "found no way out: no shipped machine makes it, not even with features left out",
    "The drawing or the part has to change, or a machine file of one's own says that a machine can "
    "do more.")  # fmt: skip
UNTRIED = note("plan-ways-untried",
    "found {found}, not every way out was looked for; expected at most {expected} for that",
    "Each option would be tried by planning all of it, some fifty times. `beamcam codes CODE` says "
    "what to do about the errors.")  # fmt: skip
WAYS_TO_READ = note("read-ways-out",
    "with {found} it can be read",
    "The option was tried before it was named. Look whether it says what the drawing means: the "
    "size of the work follows from it.")  # fmt: skip
NO_WAY_TO_READ = note("read-no-way-out",
    "found no way out: no option reads the file as it stands; expected it corrected where the "
    "messages say",
    "The file has to be exported again; a guess would make another part.")  # fmt: skip
#: Options of the readers, as on a command line and as they take them, by the file's format.
_READING: Mapping[str, Sequence[tuple[str, Mapping[str, object]]]] = {
    "dxf": (("--units mm", {"units": "mm"}), ("--units in", {"units": "in"})),
    "svg": (
        ("--units px96", {"units": "px96"}), ("--units mm", {"units": "mm"}),
        ("--width 100mm", {"width": "100mm"}),
    ),
    "dstv-cut-angle": (
        ("--ends contour", {"ends": "contour"}), ("--ends header", {"ends": "header"}),
    ),
}  # fmt: skip


def reading_suggestions(
    diagnostics: Iterable[Diagnostic], read: Callable[..., Reading], strict: bool
) -> Iterator[Diagnostic]:
    """A note behind the errors of a file that was not read: the option that helps, if there is one.

    `read` takes the file's path and options of its reader. Of a file with members that were read
    nothing is said.
    """
    wrong = errors_in(diagnostics)
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


#: What is refused for its size or place, which a turn may help.
_SKIPPED = frozenset(f"plan-{n}" for n in (*SKIP_NAMES, "round"))  #: what --allow-skips may help
_OFF_SHEET = frozenset({"plan-sheet-size", "plan-sheet-place", "plan-sheet-full"})


def suggestions(
    request: Request,
    tried: Sequence[Machine],
    others: Iterable[Machine],
    read: Callable[..., Reading] | None = None,
) -> Diagnostic:
    """A note with the options that make what was refused, as written on a command line.

    `tried` are the machines that refused it, `others` those that could be named. `read` reads a
    file with options of its reader, where a drawing may be read in another unit.
    """
    source = request.parts[0].source if request.parts else Source("beamcam")
    features = [f for part in request.parts for f in part.features]
    if len(features) > MOST_TRIED:
        return UNTRIED.at(source, found=f"{len(features)} features", expected=MOST_TRIED)
    curves = sum(len(f.curves) for f in features if isinstance(f, Contour))
    if curves > MOST_CURVES:
        return UNTRIED.at(source, found=f"{curves} curves", expected=MOST_CURVES)
    texts = sum(isinstance(f, TextMark) for f in features)
    search = _Search(curves + len(features) + TEXT_WORK * texts)
    ways = _options(search, request, tried, tuple(others), read)
    if ways:
        return SUGGESTIONS.at(source, found=" or ".join(ways))
    if search.is_spent:
        return UNTRIED.at(source, found=f"{curves + len(features)} curves and features",
                          expected=MOST_WORK // MANY_TRIES)  # fmt: skip
    return NO_WAY_OUT.at(source)


def _options(
    search: "_Search", request: Request, tried: Sequence[Machine], others: Sequence[Machine],
    read: Callable[..., Reading] | None,
) -> list[str]:  # fmt: skip
    """The options that help, those first that change least."""
    on = [replace(request, machine=machine) for machine in tried]
    # What is refused only for how many there are is helped by no other lay of one.
    refused = [
        (one, {fault.code for fault in why.diagnostics})
        for one in on
        if one.machine.torch is not None and isinstance(why := search.planned(one), BeamcamError)
    ]
    open_ones = [one for one, codes in refused if any(c.startswith("plan-open") for c in codes)]
    touching = [one for one, codes in refused if SHARED.code in codes]
    too_large = [one for one, codes in refused if not codes.isdisjoint(_OFF_SHEET)]
    fits = any(map(_keeps_size, tried))
    answers = [
        (one, search.planned(one))
        for one in (replace(request, machine=machine) for machine in others)
        if one.machine.torch is None or _keeps_size(one.machine) >= fits
    ]
    elsewhere = [
        f"--machine {one.machine.name}"
        for one, plan in answers if not isinstance(plan, BeamcamError)
    ] or [*search.by_splitting(request, (*tried, *others))]  # fmt: skip
    hopeless = [one for one, codes in refused if codes.isdisjoint(_SKIPPED)]
    may_leave = [one for one in on if one not in hopeless]
    may_leave_too = [
        one for one, why in answers
        if isinstance(why, BeamcamError) and any(d.code in _SKIPPED for d in why.diagnostics)
    ]  # fmt: skip
    unmapped = [one for one, codes in refused if UNMAPPED.code in codes]
    options = search.first(_thicknesses(on)) or [
        *search.first(
            ("--place corner", _set(one, place="corner"))
            for one, torch in _torches(on) if torch.place == "drawn"
        ),
        *elsewhere,
        *search.first(
            (f"--map '{OTHERS}=cut'", _set(one, colours={**torch.colours, OTHERS: "cut"}))
            for one, torch in _torches(unmapped)
        ),
        *search.by_gap(open_ones), *search.first(_switched(touching, "common_cuts")),
        *search.first(_rotated(too_large)),
        *search.first(_switched((one for one, _ in (*refused, *answers)), "unrolled")),
        *(() if elsewhere else search.by_leave(may_leave, may_leave_too)),
        *search.first(_longer_bars(on)),
        *search.first(
            ("--turn", replace(one, turn=True)) for one in on if one.machine.stock == "beam"
        ),
        *search.one_by_one(on),
    ]  # fmt: skip
    if not options:
        options = search.first(_switched(open_ones, "allow_open"))
    if not options and read is not None:
        options = search.first(_in_other_units(on, read))
    return options


def _keeps_size(machine: Machine) -> bool:
    """Whether a machine keeps half of its kerf off the parts, so that they fit."""
    torch = machine.torch
    return torch is not None and torch.kerf_by != "none" and any(row.kerf for row in torch.rows)


Tries = Iterator[tuple[str, Request]]  #: the words of an option, and the request with it


def _torches(on: Iterable[Request]) -> Iterator[tuple[Request, Torch]]:
    """The requests to machines with a torch, and it."""
    return ((one, one.machine.torch) for one in on if one.machine.torch is not None)


def _set(request: Request, **values: Any) -> Request:
    """A request whose machine has a torch with these values."""
    torch = replace(request.machine.needed(request.machine.torch, "torch"), **values)
    return replace(request, machine=replace(request.machine, torch=torch))


def _thicknesses(on: Iterable[Request]) -> Tries:
    """The thicknesses of each machine's cut chart, rising, where none is known."""
    for request, torch in _torches(on):
        if not (torch.thickness or any(part.profile.web_thickness for part in request.parts)):
            for thickness in sorted({row.up_to for row in torch.rows}):
                yield f"--thickness {thickness:g}", _set(request, thickness=thickness)


def _switched(on: Iterable[Request], key: str) -> Tries:
    """An option that is on or off, turned on."""
    for request, torch in _torches(on):
        if not getattr(torch, key):
            yield f"--{key.replace('_', '-')}", _set(request, **{key: True})


def _rotated(on: Iterable[Request]) -> Tries:
    """Turns by which the work may fit on the table, the least first."""
    for request, torch in _torches(on):
        for angle in () if torch.rotate else range(ROTATED_DEG, 180, ROTATED_DEG):
            yield f"--rotate {angle}", _set(request, rotate=float(angle))


def _longer_bars(on: Iterable[Request]) -> Tries:
    """Bars, the shortest first, where the parts are refused for theirs."""
    for request in on:
        for length in LONG_BARS if request.machine.stock == "beam" else ():
            if length != max(request.stock, default=None):
                yield f"--bar {length:g}", replace(request, stock=(length,))


def _in_other_units(on: Sequence[Request], read: Callable[..., Reading]) -> Tries:
    """Other units of the drawings, where what they are refused for is their size."""
    parts = on[0].parts
    if not parts or any(part.measures is None for part in parts):
        return
    for unit in UNITS:
        try:
            again = [read(part.source.file, units=unit) for part in parts]
        except BeamcamError:
            continue
        other = tuple(part for reading in again for part in reading.parts)
        for request in on if len(other) == len(parts) else ():
            yield f"--units {unit}", replace(request, parts=other)


class _Search:
    """Plans of a request with one option or another, as many as its size allows."""

    def __init__(self, size: int) -> None:
        self._tries = max(1, MOST_WORK // max(1, size))  #: plans that may be made yet

    @property
    def is_spent(self) -> bool:
        """Whether no more is tried."""
        return self._tries <= 0

    def made(self, request: Request) -> AnyPlan | None:
        """The plan of all parts on the longest bar; None where the machine refuses them."""
        plan = self.planned(request)
        return None if isinstance(plan, BeamcamError) else plan

    def planned(self, request: Request) -> AnyPlan | BeamcamError:
        """The plan of one of each part on the longest bar, or why the machine refuses them.

        Where no more is tried it is as if it were refused.
        """
        if self.is_spent:
            return PlanError(())
        self._tries -= 1
        pieces = tuple(range(len(request.parts)))
        try:
            job = Job(replace(request, quantity=None), pieces, max(request.stock, default=None))
            return post_of(request.machine).plan(job)
        except BeamcamError as error:
            return error

    def first(self, tries: Iterable[tuple[str, Request]]) -> list[str]:
        """The words of the first try by which the parts can be made, if there is one."""
        return [*islice((words for words, one in tries if self.made(one) is not None), 1)]

    def by_gap(self, on: Iterable[Request]) -> list[str]:
        """The least gap between ends that has to be closed, if the widest is enough."""
        for request, torch in _torches(on):
            tries = [(f"--gap {gap:g}", _set(request, gap=gap)) for gap in GAPS if gap > torch.gap]
            if widest := self.first(tries[-1:]):
                return self.first(tries) or widest
        return []

    def by_splitting(self, request: Request, machines: Iterable[Machine]) -> Iterator[str]:
        """The machines that make a part one after the other."""
        if len(request.parts) != 1:
            return
        bars = [machine for machine in machines if machine.stock in ("beam", "profile")]
        chain = chain_of(request, bars)
        if len(chain) > 1:
            names = ",".join(stage.machine.name for stage in chain)
            yield f"`beamcam split --machines {names}` (a program for each machine)"

    def by_leave(self, on: Sequence[Request], others: Sequence[Request]) -> Iterator[str]:
        """The fewest kinds of features to leave out, on another machine if those are fewer.

        A kind that one of them makes is not named.
        """
        ranked: list[tuple[int, int, str]] = []
        for k, request in enumerate((*on, *others)):
            plan = self.made(replace(request, skips=SKIP_NAMES))
            if plan is None:
                continue
            left = {o.by.removeprefix("plan-") for o in plan.outcomes if o.how == "skipped"}
            names = tuple(sorted({*request.skips, *(left & {*SKIP_NAMES})}))
            if names and self.made(replace(request, skips=names)) is not None:
                elsewhere = f" --machine {request.machine.name}" if k >= len(on) else ""
                ranked.append((len(names), k, f"--allow-skips {','.join(names)}{elsewhere}"))
        yield from (words for _, _, words in sorted(ranked)[:1])

    def one_by_one(self, on: Sequence[Request]) -> Iterator[str]:
        """What makes each of several parts by itself, as those of two sections."""
        parts = on[0].parts
        if len(parts) < 2 or not all(
            any(self.made(replace(request, parts=(part,))) is not None for request in on)
            for part in parts
        ):
            return
        yield "`beamcam batch` (a program for each part)"
        if parts[0].guid is not None:
            yield f"--mark {parts[0].mark} (that member alone)"
