"""The part list and the cutting list of a shop, as rows."""

from collections.abc import Iterable, Sequence

from msgspec import Struct

from beamcam.model.part import Part
from beamcam.model.weight import weight_of
from beamcam.report.tables import Cell, Table

PARTS = (
    "mark", "profile", "length", "quantity", "grade", "weight_kg", "total_kg", "holes", "slots",
    "contours", "marks", "marks_by_hand", "bevels_by_hand", "order", "drawing", "phase", "file",
)  # fmt: skip
BARS = ("bar", "profile", "grade", "stock", "pieces", "parts", "cuts", "remnant", "used_percent")
CUTS = ("bar", "piece", "mark", "profile", "grade", "length", "start", "file")


class PartCount(Struct, frozen=True):
    """A part and how often it is wanted."""

    part: Part
    quantity: int
    by_hand: "ByHand | None" = None  #: None where no machine takes the part


class ByHand(Struct, frozen=True):
    """The manual work on one piece that a machine's program leaves."""

    marks: int
    bevels: int


class CutBar(Struct, frozen=True):
    """A bar of stock: its parts with their places along it, and what is left."""

    parts: tuple[tuple[Part, float], ...]  #: and x of each on the bar, mm
    length: float
    cuts: float  #: mm of kerfs and trims
    remnant: float


def part_list(wanted: Iterable[PartCount]) -> Table:
    """A row for each part: weights are before holes and copes, empty where they are not known."""
    rows = tuple(_part_row(one) for one in wanted)
    decimals = (None, None, 3, None, None, 3, 3, *(None,) * 10)
    return Table("part list", PARTS, rows, decimals)


def _part_row(one: PartCount) -> tuple[Cell, ...]:
    part, quantity, by_hand = one.part, one.quantity, one.by_hand
    weight = weight_of(part)
    lines = [c for c in part.contours if c.process != "cut"]
    points = [hole for hole in part.holes if hole.kind == "mark"]
    return (
        part.mark, part.profile.name, part.length, quantity, part.grade, weight,
        None if weight is None else weight * quantity, len(list(part.holes)) - len(points),
        len(list(part.slots)), len(list(part.contours)) - len(lines),
        len(lines) + len(points) + len(list(part.texts)),
        *((None, None) if by_hand is None else (by_hand.marks, by_hand.bevels)), part.order,
        part.drawing, part.phase, part.source.file,
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
        (number, *_section(bar), bar.length, len(bar.parts), sum(p.length for p, _ in bar.parts),
         bar.cuts, bar.remnant, 100 * sum(p.length for p, _ in bar.parts) / bar.length)
        for number, bar in enumerate(bars, 1)
    )  # fmt: skip
    return Table("bars", BARS, rows, (None, None, None, 3, None, 3, 3, 3, 1))


def cutting_list(bars: Sequence[CutBar]) -> Table:
    """A row for each piece, bar by bar, with its place along the bar."""
    rows = tuple(
        (number, place, part.mark, part.profile.name, part.grade, part.length, start,
         part.source.file)
        for number, bar in enumerate(bars, 1)
        for place, (part, start) in enumerate(bar.parts, 1)
    )  # fmt: skip
    return Table("cutting list", CUTS, rows, (None, None, None, None, None, 3, 3, None))


def _section(bar: CutBar) -> tuple[str, str]:
    part = bar.parts[0][0]
    return part.profile.name, part.grade
