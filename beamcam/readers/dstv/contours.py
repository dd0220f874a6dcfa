"""Contour blocks AK, IK, KO and PU: rows to chains of curves.

Rows are read first and turned into curves when the whole file is known, because the sign of a
radius means counter-clockwise as seen from outside: on o and h, which are drawn mirrored, that is
clockwise in the numbers, unless the program that wrote the file draws them unmirrored, which the
direction of the face's outer contour tells.
"""

from itertools import pairwise, zip_longest
from math import asin, hypot, inf, sin, sqrt
from typing import Literal, final

from msgspec import Struct, field

from beamcam.errors import Source
from beamcam.geometry.curves import Curve, Line, Point, arc_through
from beamcam.geometry.plane import distance
from beamcam.model.part import MIRRORED_FACES, Bevel, Contour, ContourKind, Notch, Process
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.blocks import EDGES, Block, Log, RowError, numbers
from beamcam.readers.dstv.rows import RowPlace, rows_of

#: A notch corner this many radii from its arc comes of tangents that are (nearly) parallel.
_FARTHEST_CORNER = 1000.0

BevelPair = tuple[float, float]  #: angle in degrees, land
NotchRow = tuple[Literal["t", "w"], Point, float]


@final
class ContourRows(Struct):
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


def read_contour_rows(block: Block, code: str, place: RowPlace) -> list[ContourRows]:
    """The contours of one block; a row that changes the face, or follows a closed one, begins
    another. `code` is A, I, K or P."""
    all_rows: list[ContourRows] = []
    rows: ContourRows | None = None
    for line, fields in rows_of(block, place, _fields, rules.CONTOUR_FIELDS):
        x, edge, y, notch, radius, pairs = fields
        if rows is None or rows.face != place.face:
            rows = ContourRows(code, place.face, edge, line)
            all_rows.append(rows)
        if edge and edge not in rows.edges:
            rows.edge = rows.edge or edge
            rows.edges += edge
        if notch:
            near = rows.points[-1] if rows.points else (x, y)
            if hypot(x - near[0], y - near[1]) > _FARTHEST_CORNER * (abs(radius) + 1):
                place.log.add(rules.NOTCH_CORNER, line, x=x, y=y)
            else:
                kind: Literal["t", "w"] = "t" if notch == "t" else "w"
                group = rows.notches.setdefault(len(rows.points) - 1, [])
                group.append((kind, (x, y), radius))
                rows.notch_lines.append(line)
            continue
        if pairs:
            rows.bevels[len(rows.points)] = pairs
        rows.points.append((x, y))
        rows.radii.append(radius)
        rows.lines.append(line)
    if code in "AI":
        all_rows = [part for rows in all_rows for part in _split_closed(rows)]
    return all_rows


def _fields(
    row: str, line: int, place: RowPlace
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
    radius, *values = numbers(rest, line, place.log) or [0.0]
    pairs = []
    for angle, land in zip_longest(values[::2], values[1::2]):
        if len(values) > 4 or (angle and land is None):
            raise RowError(row)
        if angle:
            pairs.append((angle, land))
        elif land:
            place.log.add(rules.BEVEL_ANGLE, line, land=land)
    return x, edge if edge in EDGES else "", y, notch, radius, tuple(pairs)


def _split_closed(rows: ContourRows) -> list[ContourRows]:
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
    contours = []
    for low, high in pairwise([0, *ends, len(points)]):
        first, behind = rows.lines[low], rows.lines[high] if high < len(rows.lines) else inf
        contours.append(ContourRows(
            rows.code, rows.face, rows.edge, first, points[low:high], rows.radii[low:high],
            rows.lines[low:high],
            {i - low: bevel for i, bevel in rows.bevels.items() if low <= i < high},
            {i - low: notch for i, notch in rows.notches.items() if low <= max(i, 0) < high},
            [n for n in rows.notch_lines if (first <= n or low == 0) and n < behind], rows.edges,
        ))  # fmt: skip
    return contours


_SNAP = 0.011  #: ends this close are one point that was rounded twice
_ARC_SLACK = 0.01  #: a radius too small by this part of itself is read as a half circle
#: mm by which twice a radius is more than the chord of a half circle: each has two decimals. An
#: arc so drawn would lack sqrt(radius * this / 2) of its height: 0.26 mm of a slot 14.29 wide.
_HALF_SLACK = 0.0201


def polygon_area(points: list[Point]) -> float:
    """Area of the polygon of `points`, positive counter-clockwise."""
    total = 0.0
    x0, y0 = points[-1]
    for x1, y1 in points:
        total += x0 * y1 - x1 * y0
        x0, y0 = x1, y1
    return total / 2


def segments_area(points: list[Point], radii: list[float]) -> float:
    """Area that the arcs add to the polygon, positive for counter-clockwise ones.

    Each circular segment is r2/2 (s - sin s), s the sweep.
    """
    total = 0.0
    for i, radius in enumerate(radii[:-1]):
        if radius:
            (x0, y0), (x1, y1) = points[i], points[i + 1]
            half = hypot(x1 - x0, y1 - y0) / 2
            size = max(abs(radius), half)
            sweep = 2 * asin(half / size) if size else 0.0
            area = size * size / 2 * (sweep - sin(sweep))
            total += area if radius > 0 else -area
    return total


def is_mirrored(rows: ContourRows) -> bool:
    """Whether the numbers of a contour on o or h are mirrored, as the standard draws them.

    Mirrored numbers turn the sign of each radius, and the contour must then run clockwise in
    them if it is an outer one. Where both readings hold together, or neither does, the polygon
    of the corners decides; without one, the standard.
    """
    area = polygon_area(rows.points)
    arcs = segments_area(rows.points, rows.radii)
    outward = 1.0 if rows.code == "A" else -1.0
    mirrored = outward * (area - arcs) < 0
    drawn = outward * (area + arcs) > 0
    if mirrored != drawn:
        return mirrored
    return mirrored or outward * area <= 0


def build_contour(rows: ContourRows, mirrored: bool, thickness: float, log: Log) -> Contour | None:
    """The contour of `rows`; None if it makes nothing.

    `mirrored`: a positive radius is clockwise in the numbers. Outer contours come out
    counter-clockwise seen from outside, closed inner ones clockwise.
    """
    if len(set(rows.points)) < 2:
        lines = rows.lines + rows.notch_lines
        if radius := next((r for r in rows.radii[:-1] if r), 0.0):  # an arc is asked for
            log.add(rules.CIRCLE_POINTS, rows.line, radius=radius, count=len(lines))
        else:
            log.add(rules.CONTOUR_EMPTY, rows.line, points=len(rows.points[:1]), count=len(lines))
        log.left_out.extend(lines)
        return None
    if len(rows.edges) > 1:
        log.add(rules.EDGE_MIXED, rows.line, found=" ".join(rows.edges), kept=rows.edge)
    _drop_repeated(rows, log)
    if mirrored:
        rows.radii = [-r for r in rows.radii]
    if rows.code in "AI" and rows.points[0] != rows.points[-1]:
        gap = distance(rows.points[-1], rows.points[0])
        log.add(rules.CONTOUR_OPEN, rows.lines[-1], gap=gap)
        if gap <= _SNAP and len(rows.points) > 2:
            rows.points[-1] = rows.points[0]
        else:
            rows.points.append(rows.points[0])
            rows.radii.append(0.0)
    closed = rows.points[0] == rows.points[-1]
    kind: ContourKind = "outer" if rows.code == "A" else "inner" if closed else "open"
    if closed:
        rows.area = polygon_area(rows.points)
        area = rows.area + segments_area(rows.points, rows.radii)
        if area == 0.0:
            log.add(rules.CONTOUR_AREA, rows.line)
        wants_positive = (kind == "outer") != (rows.face in MIRRORED_FACES)
        rows.turned = area < 0 if wants_positive else area > 0
    bevels = _place_bevels(rows, closed, thickness, log)
    last = len(rows.points) - 2
    notches = [
        Notch(i if 0 <= i <= last else last, at, corner, -radius if mirrored else radius)
        for i, group in sorted(rows.notches.items())
        for at, corner, radius in group
    ]
    curves = _curves(rows, log)
    if curves is None:
        log.left_out.extend(rows.lines + rows.notch_lines)
        return None
    log.taken.extend(rows.lines)
    log.taken.extend(rows.notch_lines)
    if rows.turned:
        bevels = [Bevel(last - b.curve, b.angle, b.land) for b in bevels]
        bevels.sort(key=lambda b: b.curve)
        notches = [Notch(last - n.curve, n.kind, n.corner, -n.radius) for n in reversed(notches)]
    process: Process = "punch" if rows.code == "K" else "powder" if rows.code == "P" else "cut"
    return Contour(
        rows.face, kind, curves, Source(log.file, rows.line), process, closed, tuple(bevels),
        tuple(notches), rows.edge,
    )  # fmt: skip


def _drop_repeated(rows: ContourRows, log: Log) -> None:
    """Leave out the rows that repeat the point before; what they say belongs to that point."""
    points, lines = rows.points, rows.lines
    kept: list[int] = []
    place: list[int] = []  # of each row, its point's place among those kept
    radii: list[float] = []
    for i, point in enumerate(points):
        if kept and points[kept[-1]] == point:
            log.add(rules.REPEATED_POINT, lines[i])
            radii[-1] = rows.radii[i]
        else:
            kept.append(i)
            radii.append(rows.radii[i])
        place.append(len(kept) - 1)
    notches: dict[int, list[NotchRow]] = {}
    for i, group in rows.notches.items():
        notches.setdefault(place[i] if i >= 0 else -1, []).extend(group)
    rows.points, rows.lines = [points[i] for i in kept], [lines[i] for i in kept]
    rows.radii, rows.notches = radii, notches
    rows.bevels = {place[i]: pairs for i, pairs in rows.bevels.items()}


def _place_bevels(rows: ContourRows, closed: bool, thickness: float, log: Log) -> list[Bevel]:
    """The bevels on the curves; the closing row speaks of the first edge again."""
    bevels: list[Bevel] = []
    for i, pairs in sorted(rows.bevels.items()):
        curve = i
        if i >= len(rows.points) - 1:
            if closed and rows.bevels.get(0) == pairs:
                continue
            if not closed or 0 in rows.bevels:
                log.add(rules.BEVEL_LOST, rows.lines[i], angle=pairs[0][0])
                continue
            curve = 0
        for angle, land in pairs:
            if angle < 0 and land == 0.0 and thickness:
                log.add(rules.BEVEL_LAND, rows.lines[i], angle=angle, land=thickness)
                land = thickness
            bevels.append(Bevel(curve, angle, land))
    return sorted(bevels, key=lambda bevel: bevel.curve)


def _curves(rows: ContourRows, log: Log) -> tuple[Curve, ...] | None:
    """Lines and arcs through the points, backwards where the contour runs against its rows; None,
    with an error, where an arc cannot be."""
    points, radii, lines = rows.points, rows.radii[: len(rows.points) - 1], rows.lines
    if rows.turned:
        points, lines = points[::-1], lines[: len(radii)][::-1]
        radii = [-r for r in reversed(radii)]
    radii = [_half_circle(points, radii, i) for i in range(len(radii))]
    edges = zip(points, points[1:], radii, lines, strict=False)
    curves = [_curve(a, b, radius, line, len(lines), log) for a, b, radius, line in edges]
    sound = tuple(curve for curve in curves if curve is not None)
    return sound if len(sound) == len(curves) else None


def _half_circle(points: list[Point], radii: list[float], i: int) -> float:
    """The radius of an arc, half its chord where rounding has made a half circle less than that.

    A lug with slanted sides has an arc of a little less than a half circle: where both lines
    beside an arc run on tangent to it as its numbers say, these count.
    """
    radius, size = radii[i], abs(radii[i])
    (x0, y0), (x1, y1) = points[i], points[i + 1]
    half = hypot(x1 - x0, y1 - y0) / 2
    if not size or not 0.0 < 2 * (size - half) <= _HALF_SLACK:
        return radius
    half_circle = half if radius > 0 else -half
    leans = sqrt(1.0 - (half / size) ** 2)  # of the arc as drawn, towards the chord at both ends
    beside = []
    closed = points[0] == points[-1]
    for k in (i - 1, i + 1):
        k = k % len(radii) if closed else k
        if not 0 <= k < len(radii) or radii[k]:
            return half_circle
        (xa, ya), (xb, yb) = points[k], points[k + 1]
        along = (xb - xa) * (x1 - x0) + (yb - ya) * (y1 - y0)
        beside.append(along / (2 * half * hypot(xb - xa, yb - ya)))
    return radius if all(leans / 2 < lean < 1.5 * leans for lean in beside) else half_circle


def _curve(
    start: Point, end: Point, radius: float, line: int, count: int, log: Log
) -> Curve | None:
    """The line or arc between two points; None, with an error, if no circle of `radius` fits."""
    if radius == 0.0:
        return Line(start, end)
    try:
        return arc_through(start, end, radius)
    except ValueError:
        chord = distance(start, end)
        half = chord / 2
        if half <= abs(radius) * (1 + _ARC_SLACK):
            log.add(rules.ARC_STRETCHED, line, radius=radius, chord=chord)
            return arc_through(start, end, half if radius > 0 else -half)
        log.add(rules.ARC_RADIUS, line, radius=radius, chord=chord, least=half, count=count)
        return None
