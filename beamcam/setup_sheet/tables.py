"""The tables of a setup sheet as data, which a page and paper print alike."""

from collections.abc import Iterator, Sequence
from typing import Literal

from msgspec import Struct

from beamcam.model.plan import clock
from beamcam.setup_sheet.content import SheetContent

MAX_ROWS = 1000  #: operations that are listed
#: What the figures of a column are: lengths and rates in mm and mm/min, a step of the program.
Kind = Literal["text", "count", "step", "length", "rate", "seconds", "number"]
Cell = str | float | None


class Column(Struct, frozen=True):
    """A column of a table."""

    head: str
    kind: Kind = "text"
    wide: float = 60.0  #: points on paper
    unit: str = ""  #: of what is no length and no rate

    @property
    def is_number(self) -> bool:
        """Whether its figures stand at the right."""
        return self.kind != "text"


class SheetTable(Struct, frozen=True):
    """A table, without columns that are empty in all rows."""

    name: str
    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    lines: tuple[int, ...] = ()  #: of the program, one for each row
    more: int = 0  #: rows that are not listed
    noun: str = "rows"

    def listed(self) -> Iterator[tuple[tuple[Cell, ...], int | None]]:
        """Each row with its line of the program."""
        for k, row in enumerate(self.rows):
            yield row, self.lines[k] if self.lines else None


def _table(
    name: str, title: str, columns: Sequence[Column], rows: Sequence[Sequence[Cell]]
) -> SheetTable:
    used = [k for k in range(len(columns)) if any(row[k] not in (None, "") for row in rows)]
    return SheetTable(
        name, title, tuple(columns[k] for k in used), tuple(tuple(r[k] for k in used) for r in rows)
    )


def manual_work(content: SheetContent) -> SheetTable:
    """The marks that are made manually."""
    return _table(
        "hand", "Manual work",
        (Column("Part", wide=90.0), Column("Mark", wide=200.0), Column("Face", wide=40.0),
         Column("X", "length", 70.0), Column("Y", "length", 70.0), Column("Height", "length"),
         Column("Pieces", "count")),
        [(row["mark"], f"{row['kind']} {row['text']}".strip(), row["face"], row["x"], row["y"],
          row["height"] or None, row["pieces"]) for row in content.hand],
    )  # fmt: skip


def tables_of(content: SheetContent) -> Iterator[SheetTable]:
    """The tables below the pictures: bar, tools, times, operations; none that is empty."""
    if content.bar:
        yield _table(
            "bar", "Bar",
            (Column("What", wide=200.0), Column("From", "length", 100.0),
             Column("To", "length", 100.0), Column("Length", "length", 100.0)),
            [(one.what, one.start, one.end, one.end - one.start) for one in content.bar],
        )  # fmt: skip
    if content.tools:
        yield _table(
            "tools", "Tools to load",
            (Column("Where", wide=180.0), Column("Station", wide=180.0),
             Column("Tool", wide=170.0)),
            [(tool.where, tool.station, tool.tool) for tool in content.tools],
        )  # fmt: skip
    yield _table(
        "times", "Time by tool",
        (Column("What", wide=170.0), Column("Operations", "count", 80.0),
         Column("At work", "seconds", 80.0, "s"), Column("In all", "seconds", 80.0, "s"),
         Column("Length", "length", 100.0)),
        [(one.what, one.count, one.work_s or None, one.seconds, one.length)
         for one in content.totals],
    )  # fmt: skip
    yield _operations(content)


def _operations(content: SheetContent) -> SheetTable:
    listed = content.operations[:MAX_ROWS]
    table = _table(
        "operations", f"Operations ({len(content.operations)}, {clock(content.seconds)})",
        (Column("No.", "step", 28.0), Column("Operation", wide=110.0), Column("Face", wide=40.0),
         Column("X", "length", 62.0), Column("Y", "length", 58.0), Column("Depth", "length", 58.0),
         Column("Length", "length", 58.0), Column("Feed", "rate", 65.0),
         Column("Speed", "number", 60.0, "rpm"), Column("Time", "seconds", 50.0, "s")),
        [(op.number, op.what, ", ".join(op.faces), op.x, op.y,
          "through" if op.is_through else op.depth, op.length, op.feed_mm_min, op.speed_rpm,
          op.seconds) for op in listed],
    )  # fmt: skip
    more = len(content.operations) - len(listed)
    return SheetTable(
        table.name, table.title, table.columns, table.rows, tuple(op.line for op in listed), more,
        "operations",
    )  # fmt: skip
