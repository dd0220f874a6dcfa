"""Planning: parts and a machine in, a `Plan` out, or every reason why there is none.

`beam.plan_oriented` plans bars (`beam.plan_bar` as their parts lie) and `sheet.plan_sheet` sheets;
neither loads what the other needs. Here are the programs that a request comes to: a share of its
pieces for each bar, or for each sheet; and of the bars in store the first that will do.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from msgspec import Struct
from msgspec.structs import replace

from beamcam.budget import check_pieces
from beamcam.errors import Diagnostic, PlanError, Source, errors_in
from beamcam.model.part import Part
from beamcam.model.request import Quantity, Remnant, Request, taken_by
from beamcam.planning import rules

#: Of parts that share stock: machine, section (of plates the thickness), grade.
LotKey = tuple[str, object, str]


class Share(Struct, frozen=True):
    """The pieces of one program, and the bars that it may be cut from."""

    pieces: tuple[int, ...]  #: of each the place of its part in the request
    lengths: tuple[float, ...] = ()  #: mm, rising; none: as long as the pieces need


def number_of(part: Part, quantity: Quantity) -> int:
    """How often a part is made: as its file says, unless a number is given."""
    return quantity if isinstance(quantity, int) else part.quantity


def pieces_of(request: Request) -> tuple[int, ...]:
    """All pieces in the order given, each by the place of its part; without a quantity one each.

    A line without a saw is fed one cut piece at a time and runs its program so often; a coper has a
    program for each bar that it takes a piece off. Raises LimitError for more than `limits.pieces`.
    """
    places, machine = range(len(request.parts)), request.machine
    if request.quantity is None or (machine.stock == "beam" and machine.saw is None):
        return tuple(places)
    counts = [number_of(part, request.quantity) for part in request.parts]
    check_pieces((part.source, count) for part, count in zip(request.parts, counts, strict=True))
    return tuple(place for place, count in zip(places, counts, strict=True) for _ in range(count))


def shares_of(request: Request, together: bool = False) -> tuple[Share, ...]:
    """The share of each program, in the order given; `together` is one for all.

    Raises PlanError for a part that fits on no bar.
    """
    machine, pieces = request.machine, pieces_of(request)
    is_sheet = machine.torch is not None
    if together or (is_sheet and len(pieces) == 1) or (not is_sheet and request.quantity is None):
        return (Share(pieces, () if is_sheet else _in_store(request)),)
    if is_sheet:
        from beamcam.planning.sheet_rows import sheet_shares

        return tuple(map(Share, sheet_shares(request, pieces)))
    if machine.saw is None:
        bars = _in_store(request) if machine.stock == "profile" else ()
        return tuple(Share((place,), bars) for place in pieces)
    from beamcam.planning.stock import first_fit

    single = [taken_by(machine, replace(part, quantity=1)) for part in request.parts]
    nesting = first_fit(
        [single[place] for place in pieces], machine, request.stock, request.remnants
    )
    if nesting.refusals:
        raise PlanError(dict.fromkeys(nesting.refusals))
    return tuple(
        Share(
            tuple(pieces[i] for i in bar.pieces),
            (bar.account.length,) if request.stock or bar.is_remnant else (),
        )
        for bar in nesting.bars
    )


def _in_store(request: Request) -> tuple[float, ...]:
    """The lengths of all bars that there are, rising."""
    return tuple(sorted({*request.stock, *request.remnants}))


def remnants_of(
    remnants: Sequence[Remnant], lots: Iterable[LotKey]
) -> dict[LotKey, tuple[float, ...]]:
    """The lengths of the remnants of each lot of bars, rising.

    Raises PlanError for a remnant that may be of several lots.
    """
    found: dict[LotKey, list[float]] = {}
    known = tuple(lots)
    for remnant in remnants:
        fitting = [lot for lot in known if _is_of(remnant, lot)]
        if len(fitting) > 1:
            expected = " or ".join(f"{_shown(lot)}={remnant.length:g}" for lot in fitting)
            diagnostic = rules.REMNANT_OF.at(Source("--remnant"), found=remnant, expected=expected)
            raise PlanError(diagnostic)
        for lot in fitting:
            found.setdefault(lot, []).append(remnant.length)
    return {lot: tuple(sorted(lengths)) for lot, lengths in found.items()}


def _is_of(remnant: Remnant, lot: LotKey) -> bool:
    profile, grade = lot[1], lot[2]
    name = getattr(profile, "name", "") or getattr(profile, "code", "")
    of_section = not remnant.section or _plain(remnant.section) == _plain(name)
    return of_section and (not remnant.grade or _plain(remnant.grade) == _plain(grade))


def _shown(lot: LotKey) -> str:
    name = getattr(lot[1], "name", "") or getattr(lot[1], "code", "")
    return f"{name}/{lot[2]}" if lot[2] else name


def _plain(text: str) -> str:
    return text.replace(" ", "").casefold()


def numbered(name: str, count: int) -> tuple[str, ...]:
    """The names of `count` programs: job.gcode, or job-1.gcode, job-2.gcode, ..."""
    if count == 1:
        return (name,)
    stem, dot, suffix = name.rpartition(".")
    if not stem:
        stem, dot, suffix = name, "", ""
    return tuple(f"{stem}-{number}{dot}{suffix}" for number in range(1, count + 1))


Made = TypeVar("Made")


def from_store(
    make: Callable[[float | None], Made], lengths: Sequence[float], longest_part: float
) -> Made:
    """What `make` gives for the first of `lengths` (mm, rising) that is not too short.

    Without any it is asked for None, a bar as long as the parts need. Raises PlanError as `make`
    does; where all bars are too short, for the longest.
    """
    if not lengths:
        return make(None)
    *shorter, longest = lengths
    for length in shorter:
        if length < longest_part:
            continue
        try:
            return make(length)
        except PlanError as error:
            if not is_too_short(error.diagnostics):
                raise
    return make(longest)


def is_too_short(diagnostics: Iterable[Diagnostic]) -> bool:
    """Whether a longer bar is all that would help."""
    return {d.code for d in errors_in(diagnostics)} <= {
        rules.BAR_FULL.code,
        rules.BAR_SHORT.code,
        rules.BAR_LEFT.code,
    }
