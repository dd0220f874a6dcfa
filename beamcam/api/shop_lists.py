"""Part lists, cutting lists and labels from Python, as the shop's commands write them."""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Literal, get_args

from msgspec import Struct
from msgspec.structs import replace

from beamcam.api.inputs import check_choice, checked_parts
from beamcam.arguments import (
    AnyMachine,
    AskError,
    InTurn,
    ask_type,
    check_arguments,
    machine_of,
    on_best_machine,
)
from beamcam.budget import check_pieces
from beamcam.errors import Diagnostic, PlanError
from beamcam.machine.machine import Machine, default_machines
from beamcam.model.part import Part
from beamcam.model.plan import named_skips, stock_used
from beamcam.model.request import (
    ChosenBy,
    LotKey,
    Quantity,
    Remnant,
    Request,
    Share,
    are_flats,
    number_of,
    remnant_of,
    stock_of,
)
from beamcam.pipeline import plan_share, plans_of, shares_of
from beamcam.reports.part_list import (
    CutBar,
    CutPiece,
    PartCount,
    bar_list,
    cutting_list,
    manual_work_of,
    part_list,
)

if TYPE_CHECKING:
    from beamcam.reports.tables import Table

MachinesFor = Callable[[Part], Sequence[Machine]]  #: that may make a part, in their order


class Lists(Struct, frozen=True):
    """The tables of a shop: each has a `head` and `rows`; why a part is not made is said."""

    parts: "Table"
    bars: "Table"
    cuts: "Table"
    diagnostics: tuple[Diagnostic, ...]


def lists(
    parts: Part | Iterable[Part], machine: AnyMachine | None = None, *,
    lengths: Collection[float] = (), remnants: Collection[str | float] = (),
    quantity: Quantity = "file", skips: Collection[str] = (), by: ChosenBy = "order",
) -> Lists:  # fmt: skip
    """The part list of parts, and the bars of stock that they are cut from, first fit.

    They are those of the plans by which `post` makes the parts: on `machine`, or on the first that
    is shipped for their stock and makes them, `by` "time" on the quickest. A part that none makes
    is in the list with its reason, and on no bar. `lengths` are those in store, in mm; `remnants`
    are there once each, as 4300 or "UPN200/S235JR=4300"; `quantity` is "file", as each part says,
    or a number. Raises AskError, MachineError, LimitError for more than `limits.pieces`, and
    PlanError for a remnant that may be of several sections.
    """
    check_arguments(skips=skips)
    check_choice("by", by, get_args(ChosenBy))
    for length in lengths:
        check_arguments(bar=length)
    _check_quantity(quantity)
    try:
        there = tuple(remnant_of(str(remnant)) for remnant in remnants)
    except ValueError:
        expected = "lengths above 0, such as 4300 or 'UPN200/S235JR=4300'"
        raise AskError(ask_type("remnants", remnants, expected)) from None
    named = None if machine is None else machine_of(machine)

    def machines_for(part: Part) -> Sequence[Machine]:
        if named is not None:
            return (named,)
        return InTurn(default_machines(stock_of((part,)), flats=are_flats((part,))), machine_of)

    counts = tuple(
        PartCount(part, count) for part, count in _counted(checked_parts(parts), quantity)
    )
    if not counts:
        return Lists(part_list(()), bar_list(()), cutting_list(()), ())
    first = machines_for(counts[0].part)[0]
    request = Request((), first, named_skips(skips), stock=tuple(sorted(lengths)), by=by)
    counts = planned_counts(counts, machines_for, request, there)
    counts, bars = bars_of(counts, machines_for, request, there)
    return Lists(part_list(counts), bar_list(bars), cutting_list(bars), not_made(counts))


def labels(
    parts: Part | Iterable[Part], *, to: Literal["pdf", "zpl"] = "pdf",
    size: tuple[float, float] = (100.0, 60.0), code: Literal["qr", "datamatrix"] = "qr",
    quantity: Quantity = "file", programs: Sequence[str] = (),
) -> str | bytes:  # fmt: skip
    """A label for each piece: the bytes of a PDF, or the text of a ZPL file.

    `size` is width and height in mm; `programs` are the names that stand in the codes, one for
    each part, by default their marks. Raises AskError, LimitError for more than `limits.pieces`,
    PlanError for a mark that no code can hold, and ImportError without beamcam[labels].
    """
    from beamcam.reports.labels import CODES, Label, LabelSize, as_pdf, as_zpl, code_fault

    check_choice("to", to, ("pdf", "zpl"))
    check_choice("code", code, CODES)
    _check_quantity(quantity)
    all_parts = checked_parts(parts)
    names = tuple(programs) or tuple(part.mark for part in all_parts)
    if len(names) != len(all_parts):
        raise AskError(ask_type("programs", programs, f"{len(all_parts)} names, one for each part"))
    counted = _counted(all_parts, quantity)
    codes = zip(all_parts, names, strict=True)
    faults = [code_fault(Label(p.mark, (), name), code, p.source) for p, name in codes]
    if too_long := [fault for fault in faults if fault is not None]:
        raise PlanError(too_long)
    each = [
        Label(part.mark, tuple(label_lines(part, piece, count)), name)
        for (part, count), name in zip(counted, names, strict=True)
        for piece in range(1, count + 1)
    ]
    return (as_pdf if to == "pdf" else as_zpl)(each, LabelSize(*size), code)


def _counted(parts: Sequence[Part], quantity: Quantity) -> list[tuple[Part, int]]:
    """The parts with their quantities. Raises LimitError for more than `limits.pieces`."""
    counts = [(part, number_of(part, quantity)) for part in parts]
    check_pieces((part.source, count) for part, count in counts)
    return counts


def label_lines(part: Part, piece: int, of: int) -> Iterator[str]:
    """The lines of a label below the mark."""
    yield f"{part.profile.name or part.profile.code}, {part.length:g} mm"
    yield ", ".join(text for text in (part.grade, f"piece {piece} of {of}") if text)
    where = {"order": part.order, "drawing": part.drawing, "phase": part.phase}
    if any(where.values()):
        yield ", ".join(f"{word} {text}" for word, text in where.items() if text)


def planned_counts(
    counts: Sequence[PartCount],
    machines_for: MachinesFor,
    request: Request,
    remnants: Sequence[Remnant] = (),
) -> tuple[PartCount, ...]:
    """The parts with the first machine that makes each, and what it leaves to the hand.

    `request` says what may be left out, the bars in store and whether parts may be turned. A part
    that no machine makes has the reasons.
    """
    if request.stock:
        lengths = {*request.stock, *(remnant.length for remnant in remnants)}
        request = replace(request, stock=tuple(sorted(lengths)))
    planned: list[PartCount] = []
    for one in counts:
        machines = machines_for(one.part)
        of_one = replace(request, parts=(one.part,), machine=machines[0], quantity=1)
        try:
            (first, *_), _ = on_best_machine(of_one, machines, plans_of)
        except PlanError as error:
            planned.append(replace(one, refused=tuple(error.diagnostics)))
            continue
        manual_work = manual_work_of(first.plan)
        planned.append(replace(one, machine=first.job.machine.name, manual_work=manual_work))
    return tuple(planned)


def bars_of(
    counts: Sequence[PartCount],
    machines_for: MachinesFor,
    request: Request,
    remnants: Sequence[Remnant] = (),
) -> tuple[tuple[PartCount, ...], tuple[CutBar, ...]]:
    """The bars of the plans by which `post` makes the parts: of one machine, section and grade.

    The counts come back, those of a bar that the machine cannot make with the reasons. Plates, and
    parts of a line without a saw, are on no bar. Raises PlanError for a remnant that may be of
    several sections.
    """
    from beamcam.planning.stock import remnants_of

    known = list(counts)
    lots: dict[LotKey, list[int]] = {}
    machine_of_lot: dict[LotKey, Machine] = {}
    for place, one in enumerate(known):
        part = one.part
        if not one.machine or part.profile.code == "B":
            continue
        machine = next(m for m in machines_for(part) if m.name == one.machine)
        if machine.coper is not None or (machine.saw is not None and machine.layout is not None):
            key: LotKey = (machine.name, part.profile, part.grade)
            lots.setdefault(key, []).append(place)
            machine_of_lot[key] = machine
    there = remnants_of(remnants, lots)
    bars: list[CutBar] = []
    for key, places in lots.items():
        parts = tuple(replace(known[k].part, quantity=known[k].quantity) for k in places)
        of_lot = replace(
            request, parts=parts, machine=machine_of_lot[key], quantity="file",
            remnants=there.get(key, ()),
        )  # fmt: skip
        planned: dict[Share, CutBar] = {}  # of bars with the same pieces, which are many
        for share in shares_of(of_lot):
            try:
                if share not in planned:
                    bar = plan_share(of_lot, share)
                    used = stock_used(bar.plan, bar.job.bar)
                    assert used is not None  # the machine is one for bars
                    planned[share] = CutBar(
                        tuple(
                            CutPiece(known[places[bar.job.pieces[p.given]]].part, p.start, p.turn)
                            for p in bar.plan.pieces
                        ),
                        used.length, used.cuts, used.remnant, key[0],
                    )  # fmt: skip
                bars.append(planned[share])
            except PlanError as error:
                for k in {places[piece] for piece in share.pieces}:
                    diagnostics = (*known[k].refused, *error.diagnostics)
                    known[k] = replace(known[k], machine="", refused=diagnostics)
    return tuple(known), tuple(bars)


def not_made(counts: Iterable[PartCount]) -> tuple[Diagnostic, ...]:
    """Why parts are not made: what is said of several once."""
    return tuple(dict.fromkeys(diagnostic for one in counts for diagnostic in one.refused))


def _check_quantity(quantity: object) -> None:
    is_number = isinstance(quantity, int) and not isinstance(quantity, bool) and quantity > 0
    if quantity != "file" and not is_number:
        raise AskError(ask_type("quantity", quantity, "'file', or a number of pieces"))
