"""Part lists, cutting lists and labels from Python, as the shop's commands write them."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Literal

from msgspec import Struct
from msgspec.structs import replace

from beamcam.asked import (
    AnyMachine,
    AskError,
    ask_type,
    check_asked,
    check_choice,
    machine_of,
    parts_asked,
)
from beamcam.budget import check_pieces
from beamcam.errors import Diagnostic, PlanError, Severity
from beamcam.machine.defaults import DEFAULT_MACHINE
from beamcam.machine.machine import Machine
from beamcam.machine_choice import first_that_makes
from beamcam.model.part import Part
from beamcam.model.plan import Plan, SheetPlan
from beamcam.model.request import Job, Quantity, Request
from beamcam.planning.jobs import number_of
from beamcam.planning.rules import named_skips
from beamcam.planning.stock_bars import first_fit
from beamcam.posts import post_of
from beamcam.report.hand_list import MARKS, hand_rows
from beamcam.report.part_list import (
    ByHand,
    CutBar,
    PartCount,
    bar_list,
    cutting_list,
    part_list,
)

if TYPE_CHECKING:
    from beamcam.report.tables import Table


class Lists(Struct, frozen=True):
    """The tables of a shop: each has a `head` and `rows`; what fits on no bar is said."""

    parts: "Table"
    bars: "Table"
    cuts: "Table"
    diagnostics: tuple[Diagnostic, ...]


def lists(
    parts: Part | Iterable[Part],
    machine: AnyMachine = DEFAULT_MACHINE,
    *,
    lengths: Collection[float] = (),
    quantity: Quantity = "file",
    skips: Collection[str] = (),
) -> Lists:
    """The part list of parts, and the bars of stock that they are cut from, first fit.

    `lengths` are those in store, in mm; `quantity` is "file", as each part says, or a number.
    Raises AskError, MachineError, and LimitError for more than `limits.pieces`.
    """
    check_asked(skips=skips)
    for length in lengths:
        check_asked(bar=length)
    _check_quantity(quantity)
    loaded = machine_of(machine)
    allowed = named_skips(skips)
    counts = tuple(
        PartCount(part, count, left_to_hand(part, (loaded,), allowed))
        for part, count in _counted(parts_asked(parts), quantity)
    )
    bars, refused = bars_of(counts, loaded, sorted(lengths))
    return Lists(part_list(counts), bar_list(bars), cutting_list(bars), refused)


def labels(
    parts: Part | Iterable[Part],
    *,
    to: Literal["pdf", "zpl"] = "pdf",
    size: tuple[float, float] = (100.0, 60.0),
    code: Literal["qr", "datamatrix"] = "qr",
    quantity: Quantity = "file",
    programs: Sequence[str] = (),
) -> str | bytes:
    """A label for each piece: the bytes of a PDF, or the text of a ZPL file.

    `size` is width and height in mm; `programs` are the names that stand in the codes, one for
    each part, by default their marks. Raises AskError, LimitError for more than `limits.pieces`,
    PlanError for a mark that no code can hold, and ImportError without beamcam[labels].
    """
    from beamcam.report.labels import CODES, Label, Size, as_pdf, as_zpl, code_fault

    check_choice("to", to, ("pdf", "zpl"))
    check_choice("code", code, CODES)
    _check_quantity(quantity)
    found = parts_asked(parts)
    names = tuple(programs) or tuple(part.mark for part in found)
    if len(names) != len(found):
        raise AskError(ask_type("programs", programs, f"{len(found)} names, one for each part"))
    counted = _counted(found, quantity)
    codes = zip(found, names, strict=True)
    faults = [code_fault(Label(p.mark, (), name), code, p.source) for p, name in codes]
    if too_long := [fault for fault in faults if fault is not None]:
        raise PlanError(too_long)
    each = [
        Label(part.mark, tuple(label_lines(part, piece, count)), name)
        for (part, count), name in zip(counted, names, strict=True)
        for piece in range(1, count + 1)
    ]
    return (as_pdf if to == "pdf" else as_zpl)(each, Size(*size), code)


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


def left_to_hand(part: Part, machines: Sequence[Machine], skips: tuple[str, ...]) -> ByHand | None:
    """What is left to the hand by the first machine that makes a part; None if none does."""

    def planned(request: Request) -> Plan | SheetPlan:
        return post_of(request.machine).plan(Job(request, (0,)))

    try:
        plan, _ = first_that_makes(Request((part,), machines[0], skips), machines, planned)
    except PlanError:
        return None
    kinds = [row["kind"] for row in hand_rows(plan)]
    return ByHand(sum(kind in MARKS for kind in kinds), kinds.count("bevel"))


def bars_of(
    counts: Sequence[PartCount], machine: Machine, lengths: Sequence[float]
) -> tuple[tuple[CutBar, ...], tuple[Diagnostic, ...]]:
    """The bars that the beams among the parts are cut from, and why some are on none."""
    beams = [one for one in counts if one.part.profile.code != "B"]
    if not beams or machine.saw is None or machine.layout is None:
        return (), ()
    parts = tuple(one.part for one in beams for _ in range(one.quantity))
    nesting = first_fit(parts, machine, lengths)
    # A part that fits on no bar is reported once, whatever its quantity.
    refused = dict.fromkeys(replace(said, severity=Severity.ERROR) for said in nesting.refusals)
    bars: list[CutBar] = []
    for bar in nesting.bars:
        placed: list[tuple[Part, float]] = [
            (parts[i], start) for i, start in zip(bar.pieces, bar.starts, strict=True)
        ]
        account = bar.account
        cuts = account.front_trim + account.kerfs + account.end_trim - account.nested
        bars.append(CutBar(tuple(placed), account.length, cuts, account.remnant))
    return tuple(bars), tuple(refused)


def _check_quantity(quantity: object) -> None:
    is_number = isinstance(quantity, int) and not isinstance(quantity, bool) and quantity > 0
    if quantity != "file" and not is_number:
        raise AskError(ask_type("quantity", quantity, "'file', or a number of pieces"))
