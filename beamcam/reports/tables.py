"""Tables for people and for spreadsheets: text, CSV, XLSX and JSON from one set of rows."""

import csv
import io
import json
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from msgspec import Struct

from beamcam.errors import Diagnostic, Severity
from beamcam.geometry.plane import join_boxes
from beamcam.model.lengths import total_length
from beamcam.model.part import Bend, Camber, EndPlane, Part
from beamcam.plain_text import harmless_cell, json_text, terminal_text

if TYPE_CHECKING:
    from openpyxl.worksheet.worksheet import Worksheet

Cell = str | int | float | None
#: Characters of a sheet's name, and of a cell, that Excel takes.
MAX_TITLE, MAX_CELL = 31, 32_767
#: The date of every file in the archive of an XLSX, so that the same rows give the same bytes.
EPOCH = (1980, 1, 1, 0, 0, 0)
RED = "FFC00000"  #: of the letters in a marked row, alpha first


class Table(Struct, frozen=True):
    """Rows under a head; numbers are rounded to the decimals of their column."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    decimals: tuple[int | None, ...]  #: of each column; None for text and whole numbers
    marked: frozenset[int] = frozenset()  #: rows that stand in red, counted from 0

    def cells(self) -> Iterator[tuple[Cell, ...]]:
        """The rows with their numbers rounded."""
        for row in self.rows:
            yield tuple(
                round(cell, places) if isinstance(cell, float) and places is not None else cell
                for cell, places in zip(row, self.decimals, strict=True)
            )


def as_lines(tables: Iterable[Table]) -> Iterator[tuple[str, bool]]:
    """Each table with its title, columns aligned, numbers to the right; whether a line is marked.

    Columns in which nothing stands are left out.
    """
    for number, table in enumerate(tables):
        if number:
            yield "", False
        yield table.title, False
        rows = [*table.cells()]
        # Of a table without rows the head is all there is to show.
        filled = [not rows or any(row[k] not in (None, "") for row in rows)
                  for k in range(len(table.head))]  # fmt: skip
        columns = [
            (head, [_shown(row[k]) for row in rows],
             bool(rows) and all(row[k] is None or isinstance(row[k], int | float) for row in rows))
            for k, head in enumerate(table.head)
            if filled[k]
        ]  # fmt: skip
        widths = [max(map(len, (head, *cells))) for head, cells, _ in columns]
        for at in range(-1, len(rows)):
            cells = (
                text.rjust(width) if numeric else text.ljust(width)
                for width, (head, shown, numeric) in zip(widths, columns, strict=True)
                for text in (head if at < 0 else shown[at],)
            )
            yield ("  " + "  ".join(cells)).rstrip(), at in table.marked


def _shown(cell: Cell) -> str:
    if cell is None:
        return ""
    return terminal_text(cell) if isinstance(cell, str) else f"{cell:.9g}"


def as_csv(table: Table) -> str:
    """One table with its head, by RFC 4180 but for its line ends."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(table.head)
    writer.writerows(map(harmless_cell, row) for row in table.cells())
    return out.getvalue()


def as_json(tables: Iterable[Table], schema: str) -> str:
    """Each table as a list of objects, by its title in one word."""
    record: dict[str, object] = {"schema": schema}
    for table in tables:
        rows = [dict(zip(table.head, row, strict=True)) for row in table.cells()]
        record[table.title.replace(" ", "_")] = rows
    return json_text(json.dumps(record, ensure_ascii=False, indent=1)) + "\n"


def as_xlsx(tables: Iterable[Table]) -> bytes:
    """A workbook with a sheet for each table. Raises ImportError without openpyxl."""
    import openpyxl

    book = openpyxl.Workbook()
    del book["Sheet"]
    for table in tables:
        _fill(book.create_sheet(table.title[:MAX_TITLE]), table)
    out = io.BytesIO()
    book.save(out)
    return _without_time(out.getvalue())


def _fill(sheet: "Worksheet", table: Table) -> None:
    from openpyxl.styles import Font
    from openpyxl.utils import get_column_letter

    sheet.append(table.head)
    for row in table.cells():
        sheet.append([terminal_text(c)[:MAX_CELL] if isinstance(c, str) else c for c in row])
    # A text is a text, also one that begins with "=".
    for cells in sheet.iter_rows(min_row=2):
        for cell in cells:
            if isinstance(cell.value, str):
                cell.data_type = "s"
    for number in table.marked:
        for cell in sheet[number + 2]:
            cell.font = Font(color=RED)
    for cell in sheet[1]:
        cell.font = Font(bold=True)
    sheet.freeze_panes = "A2"
    for number, column in enumerate(zip(table.head, *table.cells(), strict=True), 1):
        width = max(len(_shown(cell)) for cell in column)
        sheet.column_dimensions[get_column_letter(number)].width = min(width, 60) + 2


def _without_time(data: bytes) -> bytes:
    """A workbook without the time at which it was written."""
    import re
    import zipfile

    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(out, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "docProps/core.xml":
                content = re.sub(rb"<dcterms:(\w+)[^>]*>[^<]*</dcterms:\w+>", b"", content)
            new.writestr(zipfile.ZipInfo(name, EPOCH), content, zipfile.ZIP_DEFLATED)
    return out.getvalue()


# --- a part as a table for people -----------------------------------------------------------------

Row = tuple[str, ...]


def part_table(part: Part) -> Iterator[str]:
    """The lines of the part: stock first, then its features face by face in file order."""
    yield from map(terminal_text, _stock(part))
    yield from _features(part)


def _stock(part: Part) -> Iterator[str]:
    p = part.profile
    thickness = "?" if p.web_thickness is None else f"{p.web_thickness:g}"
    size = f"{p.height:g} x {p.width:g}, web {thickness}, flange {p.flange_thickness:g}"
    names = f"{part.mark or '(no mark)'}  {p.name or '(no profile name)'}"
    yield f"{names}  {part.length:g} mm"
    yield f"  profile   {p.code}  {size}, radius {p.radius:g}"
    yield f"  quantity  {part.quantity}"
    if part.grade:
        yield f"  grade     {part.grade}"
    if part.made is not None:
        yield f"  made      its ends and {len(part.made)} feature(s), by another machine"
    if part.saw_length is not None:
        yield f"  saw       {part.saw_length:g} mm"
    c = part.cuts
    if any((c.web_start, c.web_end, c.flange_start, c.flange_end)):
        yield f"  cuts      web {c.web_start:g} / {c.web_end:g}, " + (
            f"flange {c.flange_start:g} / {c.flange_end:g} degrees (start / end)"
        )


def _features(part: Part) -> Iterator[str]:
    tables: list[tuple[str, Sequence[str], list[Row]]] = [
        ("holes", ("face", "x", "y", "diameter", "kind", "depth"), [
            (h.face, f"{h.x:g}", f"{h.y:g}", f"{h.diameter:g}", h.kind,
             "" if h.depth is None else f"{h.depth:g}") for h in part.holes]),
        ("slots", ("face", "x", "y", "diameter", "length", "height", "angle"), [
            (s.face, *(f"{v:g}" for v in (s.x, s.y, s.diameter, s.length, s.height, s.angle)))
            for s in part.slots]),
        ("contours", ("face", "kind", "process", "curves", "length", "box"), [
            (c.face, c.kind, c.process, str(len(c.curves)), f"{total_length(c.curves):.2f}",
             " ".join(f"{v:g}" for v in join_boxes([curve.bbox for curve in c.curves]) or ()))
            for c in part.contours]),
        ("texts", ("face", "x", "y", "height", "text"), [
            (t.face, f"{t.x:g}", f"{t.y:g}", f"{t.height:g}", t.text) for t in part.texts]),
        ("others", ("what", "where"), list(_others(part))),
    ]  # fmt: skip
    for title, head, rows in tables:
        if rows:
            yield f"  {title} ({len(rows)})"
            yield from aligned([tuple(head), *rows])


def aligned(rows: Sequence[Row], indent: str = "    ") -> Iterator[str]:
    """The rows as lines, every column as wide as its widest cell."""
    rows = [tuple(map(terminal_text, row)) for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        yield indent + "  ".join(cells).rstrip()


def _others(part: Part) -> Iterator[Row]:
    for feature in part.features:
        match feature:
            case Bend():
                yield f"bend of {feature.angle:g} degrees", f"line {feature.start} to {feature.end}"
            case EndPlane():
                yield "end plane", f"point {feature.point} normal {feature.normal}"
            case Camber():
                yield "camber", f"{feature.face} x {feature.x:g} y {feature.y:g}"
    for plane in part.planes:
        yield f"plane {plane.name}", f"origin {plane.origin}"


# --- members of a building model, a line each -----------------------------------------------------

HEAD: Row = ("mark", "profile", "length", "holes", "slots", "guid", "verdict")


def member_table(parts: Iterable[Part], diagnostics: Iterable[Diagnostic]) -> Iterator[str]:
    """The members that were read, then those that were refused with the code of the reason."""
    warned = {d.source.where for d in diagnostics if d.severity is Severity.WARNING}
    rows = [
        (
            part.mark, part.profile.name, f"{part.length:.1f}", str(sum(1 for _ in part.holes)),
            str(sum(1 for _ in part.slots)), part.guid or "",
            "read, see warning" if part.guid in warned else "read",
        )
        for part in parts
    ]  # fmt: skip
    rows += [
        ("", "", "", "", "", d.source.where, f"refused: {d.code}")
        for d in diagnostics
        if d.severity is Severity.ERROR and d.source.where is not None
    ]
    yield from aligned([HEAD, *rows], "  ")
