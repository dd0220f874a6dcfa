"""The part list and the cutting list of a shop, as rows."""

from collections.abc import Iterable, Sequence

from msgspec import Struct

from beamcam.errors import Diagnostic, errors_in
from beamcam.model.part import Part
from beamcam.report.tables import Cell, Table
from beamcam.report.weights import weights_of

PARTS = (
    "mark", "profile", "length", "quantity", "grade", "weight_kg", "total_kg", "gross_kg",
    "catalogue_kg", "header_kg", "holes", "slots", "contours", "marks", "marks_by_hand",
    "bevels_by_hand", "order", "drawing", "phase", "machine", "file", "not_made",
)  # fmt: skip
BARS = (
    "bar", "profile", "grade", "machine", "stock", "pieces", "parts", "cuts", "remnant",
    "used_percent",
)  # fmt: skip
CUTS = ("bar", "piece", "mark", "profile", "grade", "length", "start", "turn", "file")


class PartCount(Struct, frozen=True):
    """A part and how often it is wanted, and by what it is made."""

    part: Part
    quantity: int
    machine: str = ""  #: the first that makes it; "" for none
    by_hand: "ByHand | None" = None  #: None where no machine makes the part
    refused: tuple[Diagnostic, ...] = ()  #: why it is not made


class ByHand(Struct, frozen=True):
    """The manual work on one piece that a machine's program leaves."""

    marks: int
    bevels: int


class CutPiece(Struct, frozen=True):
    """A piece on a bar."""

    part: Part  #: as it was read
    start: float  #: x of its x 0 on the bar, mm
    turn: str  #: how it lies


class CutBar(Struct, frozen=True):
    """A bar of stock: its pieces with their places along it, and what is left."""

    pieces: tuple[CutPiece, ...]
    length: float
    cuts: float  #: mm of kerfs and trims
    remnant: float
    machine: str


def part_list(wanted: Iterable[PartCount]) -> Table:
    """A row for each part; what is not known is empty. Those that are not made are marked."""
    counts = tuple(wanted)
    rows = tuple(_part_row(one) for one in counts)
    decimals = (None, None, 3, None, None, 3, 3, 3, 3, 3, *(None,) * 12)
    marked = frozenset(k for k, one in enumerate(counts) if one.refused)
    return Table("part list", PARTS, rows, decimals, marked)


def _part_row(one: PartCount) -> tuple[Cell, ...]:
    part, quantity, by_hand = one.part, one.quantity, one.by_hand
    weights = weights_of(part)
    weight = weights.finished
    lines = [c for c in part.contours if c.process != "cut"]
    points = [hole for hole in part.holes if hole.kind == "mark"]
    why = next((f"{said.code}: {said.message}" for said in errors_in(one.refused)), None)
    return (
        part.mark, part.profile.name, part.length, quantity, part.grade, weight,
        None if weight is None else weight * quantity, weights.gross, weights.catalogue,
        weights.header, len(list(part.holes)) - len(points),
        len(list(part.slots)), len(list(part.contours)) - len(lines),
        len(lines) + len(points) + len(list(part.texts)),
        *((None, None) if by_hand is None else (by_hand.marks, by_hand.bevels)), part.order,
        part.drawing, part.phase, one.machine or None, part.source.file, why,
    )  # fmt: skip


def total_row(table: Table) -> tuple[Cell, ...]:
    """Pieces and kilograms of a part list, under its columns."""
    quantity, total = table.head.index("quantity"), table.head.index("total_kg")
    cells: list[Cell] = [None] * len(table.head)
    cells[0] = "total"
    cells[quantity] = sum(int(row[quantity] or 0) for row in table.rows)
    cells[total] = float(sum(row[total] or 0.0 for row in table.rows))  # type: ignore[misc]
    return tuple(cells)


def bar_list(bars: Sequence[CutBar]) -> Table:
    """A row for each bar, with its account: pieces, kerfs and trims, and remnant, all in mm."""
    rows = tuple(
        (number, *_section(bar), bar.machine, bar.length, len(bar.pieces), _steel(bar), bar.cuts,
         bar.remnant, 100 * _steel(bar) / bar.length)
        for number, bar in enumerate(bars, 1)
    )  # fmt: skip
    return Table("bars", BARS, rows, (None, None, None, None, 3, None, 3, 3, 3, 1))


def _steel(bar: CutBar) -> float:
    """mm of the bar that are parts."""
    return sum(piece.part.length for piece in bar.pieces)


def cutting_list(bars: Sequence[CutBar]) -> Table:
    """A row for each piece, bar by bar, with its place along the bar and how it lies."""
    rows = tuple(
        (number, place, piece.part.mark, piece.part.profile.name, piece.part.grade,
         piece.part.length, piece.start, piece.turn, piece.part.source.file)
        for number, bar in enumerate(bars, 1)
        for place, piece in enumerate(bar.pieces, 1)
    )  # fmt: skip
    return Table("cutting list", CUTS, rows, (None, None, None, None, None, 3, 3, None, None))


def _section(bar: CutBar) -> tuple[str, str]:
    part = bar.pieces[0].part
    return part.profile.name, part.grade
