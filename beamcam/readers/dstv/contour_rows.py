"""Rows of the contour blocks AK, IK, KO and PU."""

from itertools import pairwise
from math import hypot, inf
from typing import Literal, final

from msgspec import Struct, field

from beamcam.geometry.curves import Point
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.place import Place, rows_of
from beamcam.readers.dstv.tokens import EDGES, Block, Log, RowError, numbers

#: A notch corner this many radii from its arc comes of tangents that are (nearly) parallel.
_FARTHEST_CORNER = 1000.0

BevelPair = tuple[float, float]  #: angle in degrees, land
NotchRow = tuple[Literal["t", "w"], Point, float]


@final
class Rows(Struct):
    """One contour as its rows say it; item i of each list belongs to the edge from point i on."""

    code: str  #: A, I, K or P
    face: str
    edge: str
    line: int
    points: list[Point] = field(default_factory=list)
    radii: list[float] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    bevels: dict[int, tuple[BevelPair, ...]] = field(default_factory=dict)
    notches: dict[int, list[NotchRow]] = field(default_factory=dict)
    notch_lines: list[int] = field(default_factory=list)
    edges: str = ""  #: all reference letters met
    turned: bool = False  #: whether the contour runs against its rows
    area: float = 0.0  #: of the polygon of its corners, as the rows draw it


def read_contour_rows(block: Block, code: str, place: Place) -> list[Rows]:
    """The contours of one block; a row that changes the face, or follows a closed one, begins
    another. `code` is A, I, K or P."""
    found: list[Rows] = []
    rows: Rows | None = None
    for line, fields in rows_of(block, place, _fields, rules.CONTOUR_FIELDS):
        x, edge, y, notch, radius, pairs = fields
        if rows is None or rows.face != place.face:
            rows = Rows(code, place.face, edge, line)
            found.append(rows)
        if edge and edge not in rows.edges:
            rows.edge = rows.edge or edge
            rows.edges += edge
        if notch:
            _add_notch(rows, notch, (x, y), radius, line, place.log)
            continue
        if pairs:
            rows.bevels[len(rows.points)] = pairs
        rows.points.append((x, y))
        rows.radii.append(radius)
        rows.lines.append(line)
    if code in "AI":
        found = [part for rows in found for part in _split_closed(rows)]
    return found


def _fields(
    row: str, line: int, place: Place
) -> tuple[float, str, float, str, float, tuple[BevelPair, ...]]:
    """x, reference, y, notch letter, radius and bevels of a row.

    "  v   0.00u   20.00   0.00   0.00   0.00   0.00   0.00" is face, x and reference, y and notch
    letter, radius, angle of a bevel, its land, angle and land of a second one. Raises RowError if
    no rule explains the row.
    """
    x, edge, y, rest = place.corner(row, line)
    notch = ""
    if rest and rest[0] in ("t", "w"):
        notch, rest = rest[0], rest[1:]
    values = numbers(rest, line, place.log)
    if len(values) > 5:
        raise RowError(row)
    pairs = _bevel_pairs(values[1:], row, line, place.log)
    return x, edge if edge in EDGES else "", y, notch, values[0] if values else 0.0, pairs


def _bevel_pairs(values: list[float], row: str, line: int, log: Log) -> tuple[BevelPair, ...]:
    """Angle and land of up to two bevels. Raises RowError for an angle without its land."""
    pairs = []
    for i in range(0, len(values), 2):
        angle = values[i]
        if angle:
            if i + 1 == len(values):
                raise RowError(row)
            pairs.append((angle, values[i + 1]))
        elif values[i + 1 : i + 2] not in ([], [0.0]):
            log.add(rules.BEVEL_ANGLE, line, land=values[i + 1])
    return tuple(pairs)


def _add_notch(rows: Rows, letter: str, corner: Point, radius: float, line: int, log: Log) -> None:
    """Keep a notch row with the edge that it stands on, unless its corner lies far away."""
    kind: Literal["t", "w"] = "t" if letter == "t" else "w"
    near = rows.points[-1] if rows.points else corner
    far = hypot(corner[0] - near[0], corner[1] - near[1])
    if far > _FARTHEST_CORNER * (abs(radius) + 1):
        log.add(rules.NOTCH_CORNER, line, x=corner[0], y=corner[1])
        return
    rows.notches.setdefault(len(rows.points) - 1, []).append((kind, corner, radius))
    rows.notch_lines.append(line)


def _split_closed(rows: Rows) -> list[Rows]:
    """The contours of a block that holds several, one after the other.

    A contour ends where it comes back to its start, if another closed one follows; one that only
    touches its start goes on.
    """
    points = rows.points
    if not points or points.count(points[0]) == 1 + (len(points) > 1 and points[-1] == points[0]):
        return [rows]
    ends: list[int] = []
    last = {point: i for i, point in enumerate(points)}
    start = 0
    for i, point in enumerate(points):
        if point != points[start] or i - start < 2 or i + 1 == len(points):
            continue
        following = points[i + 1]
        if following != point and last[following] > i + 1:
            ends.append(i + 1)
            start = i + 1
    if not ends:
        return [rows]
    bounds = [0, *ends, len(points)]
    return [_part_of(rows, low, high) for low, high in pairwise(bounds)]


def _part_of(rows: Rows, low: int, high: int) -> Rows:
    """The contour of the points from `low` to before `high`."""
    first, behind = rows.lines[low], rows.lines[high] if high < len(rows.lines) else inf
    return Rows(
        rows.code,
        rows.face,
        rows.edge,
        first,
        rows.points[low:high],
        rows.radii[low:high],
        rows.lines[low:high],
        {i - low: bevel for i, bevel in rows.bevels.items() if low <= i < high},
        {i - low: notch for i, notch in rows.notches.items() if low <= max(i, 0) < high},
        [n for n in rows.notch_lines if (first <= n or low == 0) and n < behind],
        rows.edges,
    )
