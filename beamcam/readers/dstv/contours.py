"""Contour blocks AK, IK, KO and PU: rows to chains of curves.

Rows are read first and turned into curves when the whole file is known, because the sign of a
radius means counter-clockwise as seen from outside: on o and h, which are drawn mirrored, that is
clockwise in the numbers, unless the program that wrote the file draws them unmirrored, which the
direction of the face's outer contour tells.
"""

from math import asin, hypot, sin

from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Curve, Line, Point, arc_through
from beamcam.model.part import MIRRORED_FACES, Bevel, Contour, ContourKind, Notch, Process
from beamcam.readers.dstv import rules
from beamcam.readers.dstv.contour_rows import BevelPair, NotchRow, Rows
from beamcam.readers.dstv.tokens import Log

_SNAP = 0.011  #: ends this close are one point that was rounded twice
_ARC_SLACK = 0.01  #: a radius too small by this part of itself is read as a half circle


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


def is_mirrored(rows: Rows) -> bool:
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
    if mirrored:
        return True
    return outward * area <= 0


def build_contour(rows: Rows, mirrored: bool, thickness: float, log: Log) -> Contour | None:
    """The contour of `rows`; None if it makes nothing.

    `mirrored`: a positive radius is clockwise in the numbers. Outer contours come out
    counter-clockwise seen from outside, closed inner ones clockwise.
    """
    if len(set(rows.points)) < 2:
        _refuse_point(rows, log)
        return None
    if len(rows.edges) > 1:
        log.add(rules.EDGE_MIXED, rows.line, found=" ".join(rows.edges), kept=rows.edge)
    points, radii, lines, bevel_rows, notch_rows = _drop_repeated(rows, log)
    if mirrored:
        radii = [-r for r in radii]
    closed = points[0] == points[-1]
    if not closed and rows.code in "AI":
        points, radii = _close(points, radii, lines, log)
        closed = True
    kind: ContourKind = "outer" if rows.code == "A" else "inner" if closed else "open"
    if closed:
        rows.turned = _runs_the_other_way(rows, kind, points, radii, log)
    last = len(points) - 2  #: edge
    bevels = _place_bevels(rows, bevel_rows, last + 1, closed, thickness, lines, log)
    notches = _place_notches(notch_rows, last, mirrored)
    if rows.turned:
        lines = lines[: last + 1][::-1]  # of each edge, the row that it began on
        points = points[::-1]
        radii = [-r for r in radii[-2::-1]] + [0.0]
        bevels = [Bevel(last - b.curve, b.angle, b.land) for b in bevels]
        bevels.sort(key=lambda b: b.curve)
        notches = [Notch(last - n.curve, n.kind, n.corner, -n.radius) for n in reversed(notches)]
    curves = _curves(points, radii, lines, log)
    if curves is None:
        log.left_out.extend(rows.lines + rows.notch_lines)
        return None
    log.taken.extend(rows.lines)
    log.taken.extend(rows.notch_lines)
    process: Process = "punch" if rows.code == "K" else "powder" if rows.code == "P" else "cut"
    return Contour(
        rows.face,
        kind,
        curves,
        Source(log.file, rows.line),
        process,
        closed,
        tuple(bevels),
        tuple(notches),
        rows.edge,
    )


def _runs_the_other_way(
    rows: Rows, kind: ContourKind, points: list[Point], radii: list[float], log: Log
) -> bool:
    """Whether a closed contour runs against the sense in which ours run, seen from outside."""
    rows.area = polygon_area(points)
    area = rows.area + segments_area(points, radii)
    if area == 0.0:
        log.add(rules.CONTOUR_AREA, rows.line)
    wants_positive = (kind == "outer") != (rows.face in MIRRORED_FACES)
    return area < 0 if wants_positive else area > 0


def _place_notches(notches: dict[int, list[NotchRow]], last: int, mirrored: bool) -> list[Notch]:
    """The notches at the edges that they stand on, the last one at most."""
    return [
        Notch(i if 0 <= i <= last else last, kind, corner, -radius if mirrored else radius)
        for i, group in sorted(notches.items())
        for kind, corner, radius in group
    ]


def _refuse_point(rows: Rows, log: Log) -> None:
    """Say that a contour is one point only, which is an error where an arc is asked for."""
    lines = rows.lines + rows.notch_lines
    radius = next((r for r in rows.radii[:-1] if r), 0.0)
    if radius:
        log.add(rules.CIRCLE_POINTS, rows.line, radius=radius, count=len(lines))
    else:
        log.add(rules.CONTOUR_EMPTY, rows.line, points=len(rows.points[:1]), count=len(lines))
    log.left_out.extend(lines)


def _drop_repeated(
    rows: Rows, log: Log
) -> tuple[
    list[Point],
    list[float],
    list[int],
    dict[int, tuple[BevelPair, ...]],
    dict[int, list[NotchRow]],
]:
    """The rows without those that repeat the point before; what these say belongs to the point."""
    points, lines = rows.points, rows.lines
    kept: list[int] = []
    place: list[int] = []  # of each row, its point's place among those kept
    new_radii: list[float] = []
    for i, point in enumerate(points):
        if kept and points[kept[-1]] == point:
            log.add(rules.REPEATED_POINT, lines[i])
            rows.left_out.append(lines[i])
            new_radii[-1] = rows.radii[i]
        else:
            kept.append(i)
            new_radii.append(rows.radii[i])
        place.append(len(kept) - 1)
    new_bevels = {place[i]: pairs for i, pairs in rows.bevels.items()}
    new_notches: dict[int, list[NotchRow]] = {}
    for i, group in rows.notches.items():
        new_notches.setdefault(place[i] if i >= 0 else -1, []).extend(group)
    return (
        [points[i] for i in kept],
        new_radii,
        [lines[i] for i in kept],
        new_bevels,
        new_notches,
    )


def _close(
    points: list[Point], radii: list[float], lines: list[int], log: Log
) -> tuple[list[Point], list[float]]:
    """Points and radii of a contour that must be closed and is not."""
    gap = hypot(points[-1][0] - points[0][0], points[-1][1] - points[0][1])
    log.add(rules.CONTOUR_OPEN, lines[-1], gap=gap)
    if gap <= _SNAP and len(points) > 2:
        return [*points[:-1], points[0]], radii
    return [*points, points[0]], [*radii, 0.0]


def _place_bevels(
    rows: Rows,
    bevels: dict[int, tuple[BevelPair, ...]],
    count: int,
    closed: bool,
    thickness: float,
    lines: list[int],
    log: Log,
) -> list[Bevel]:
    """The bevels on `count` curves; the closing row speaks of the first edge again."""
    if not bevels:
        return []
    found: list[Bevel] = []
    for i, pairs in sorted(bevels.items()):
        curve = i
        if i >= count:
            if closed and bevels.get(0) == pairs:
                continue
            if not closed or 0 in bevels:
                log.add(rules.BEVEL_LOST, lines[min(i, len(lines) - 1)], angle=pairs[0][0])
                continue
            curve = 0
        for angle, land in pairs:
            if angle < 0 and land == 0.0 and thickness:
                log.add(
                    rules.BEVEL_LAND, lines[min(i, len(lines) - 1)], angle=angle, land=thickness
                )
                land = thickness
            found.append(Bevel(curve, angle, land))
    found.sort(key=lambda bevel: bevel.curve)
    return found


def _curves(
    points: list[Point], radii: list[float], lines: list[int], log: Log
) -> tuple[Curve, ...] | None:
    """Lines and arcs through `points`; None, with an error, where an arc cannot be."""
    if not any(radii):
        return tuple(map(Line, points, points[1:]))
    curves: list[Curve] = []
    failed = False
    for i in range(len(points) - 1):
        radius = radii[i]
        if radius == 0.0:
            curves.append(Line(points[i], points[i + 1]))
            continue
        arc = _arc(points[i], points[i + 1], radius, lines[min(i, len(lines) - 1)], len(lines), log)
        if arc is None:
            failed = True
        else:
            curves.append(arc)
    return None if failed else tuple(curves)


def _arc(start: Point, end: Point, radius: float, line: int, count: int, log: Log) -> Arc | None:
    """The arc between two points; None, with an error, if no circle of `radius` fits them."""
    try:
        return arc_through(start, end, radius)
    except ValueError:
        chord = hypot(end[0] - start[0], end[1] - start[1])
        half = chord / 2
        if half <= abs(radius) * (1 + _ARC_SLACK):
            log.add(rules.ARC_STRETCHED, line, radius=radius, chord=chord)
            return arc_through(start, end, half if radius > 0 else -half)
        log.add(rules.ARC_RADIUS, line, radius=radius, chord=chord, least=half, count=count)
        return None
