"""A part as a table for people."""

from collections.abc import Iterable, Iterator, Sequence

from beamcam.geometry.plane import join_boxes
from beamcam.model.lengths import total_length
from beamcam.model.part import Bend, Camber, Contour, EndPlane, Hole, Part, Slot, TextMark
from beamcam.plain_text import terminal_text

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
    if part.saw_length is not None:
        yield f"  saw       {part.saw_length:g} mm"
    c = part.cuts
    if any((c.web_start, c.web_end, c.flange_start, c.flange_end)):
        yield f"  cuts      web {c.web_start:g} / {c.web_end:g}, " + (
            f"flange {c.flange_start:g} / {c.flange_end:g} degrees (start / end)"
        )


def _features(part: Part) -> Iterator[str]:
    tables: list[tuple[str, Sequence[str], list[Row]]] = [
        ("holes", ("face", "x", "y", "diameter", "kind", "depth"), _holes(part.holes)),
        ("slots", ("face", "x", "y", "diameter", "length", "height", "angle"), _slots(part.slots)),
        (
            "contours",
            ("face", "kind", "process", "curves", "length", "box"),
            _contours(part.contours),
        ),
        ("texts", ("face", "x", "y", "height", "text"), _texts(part.texts)),
        ("others", ("what", "where"), list(_others(part))),
    ]
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


def _holes(holes: Iterable[Hole]) -> list[Row]:
    return [
        (h.face, f"{h.x:g}", f"{h.y:g}", f"{h.diameter:g}", h.kind,
         "" if h.depth is None else f"{h.depth:g}")
        for h in holes
    ]  # fmt: skip


def _slots(slots: Iterable[Slot]) -> list[Row]:
    return [
        (s.face, *(f"{v:g}" for v in (s.x, s.y, s.diameter, s.length, s.height, s.angle)))
        for s in slots
    ]


def _contours(contours: Iterable[Contour]) -> list[Row]:
    return [
        (c.face, c.kind, c.process, str(len(c.curves)), f"{total_length(c.curves):.2f}",
         " ".join(f"{v:g}" for v in join_boxes([curve.bbox for curve in c.curves]) or ()))
        for c in contours
    ]  # fmt: skip


def _texts(texts: Iterable[TextMark]) -> list[Row]:
    return [(t.face, f"{t.x:g}", f"{t.y:g}", f"{t.height:g}", t.text) for t in texts]


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
