"""Joints of a chain: ends of curves brought together where they nearly meet."""

from collections.abc import Sequence
from math import hypot

from msgspec.structs import replace

from beamcam.geometry.bezier import Bezier
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point, cross, distance

#: Ends nearer than this are one point; nothing has to be moved to join them.
SAME_POINT = 1e-9

#: An end is moved aside by no more than this, in mm, as the curve would lie elsewhere; an end of a
#: line no farther than a share of its length. Other gaps are bridged.
MOST_MOVED = 0.005
MOST_TURNED = 0.1

#: Lines whose directions differ by less, in radians, do not meet near their ends.
MIN_ANGLE = 0.1


def joined(
    parts: list[Curve], names: list[int], joints: Sequence[int]
) -> tuple[list[Curve], list[int]]:
    """The curves with their ends moved together, and lines where that cannot be.

    `joints` names the curves whose end has to be brought to the start of the following one.
    """
    count = len(parts)
    bridges: dict[int, Line] = {}
    for k in joints:
        following = (k + 1) % count
        a, b = parts[k].end, parts[following].start
        if distance(a, b) <= SAME_POINT:
            continue
        corner = _corner(parts[k], parts[following])
        if corner is not None and following != k:
            parts[k] = replace(parts[k], end=corner)
            parts[following] = replace(parts[following], start=corner)
            continue
        moved_start = _with_start(parts[following], a) if following != k else None
        moved_end = _with_end(parts[k], b)
        if moved_end is not None:
            parts[k] = moved_end
        elif moved_start is not None:
            parts[following] = moved_start
        else:
            bridges[k] = Line(a, b)
    curves: list[Curve] = []
    members: list[int] = []
    for k, (part, name) in enumerate(zip(parts, names, strict=True)):
        curves.append(part)
        members.append(name)
        if k in bridges:
            curves.append(bridges[k])
            members.append(-1)
    return curves, members


def _corner(a: Curve, b: Curve) -> Point | None:
    """Where two lines meet that end near one another; None if that is not near their ends."""
    if not (isinstance(a, Line) and isinstance(b, Line)):
        return None
    gap = distance(a.end, b.start)
    if min(a.length, b.length) * MOST_TURNED < gap:
        return None
    u, v = a.tangent(0.0), b.tangent(0.0)
    if abs(cross(u, v)) < MIN_ANGLE:
        return None
    reach = cross((b.start[0] - a.end[0], b.start[1] - a.end[1]), v) / cross(u, v)
    point = (a.end[0] + reach * u[0], a.end[1] + reach * u[1])
    return point if max(abs(reach), distance(point, b.start)) <= gap * (1 + SAME_POINT) else None


def _with_end(curve: Curve, point: Point) -> Curve | None:
    """The curve with its end at a point; None if it would lie elsewhere."""
    match curve:
        case Line():
            off = (point[0] - curve.end[0], point[1] - curve.end[1])
            if hypot(*off) > MOST_TURNED * curve.length:
                return None
            aside = abs(cross(off, curve.tangent(0.0)))
            return replace(curve, end=point) if aside <= MOST_MOVED else None
        case Bezier() if distance(curve.end, point) <= MOST_MOVED:
            return replace(curve, points=(*curve.points[:-1], point))
        case _:
            return None


def _with_start(curve: Curve, point: Point) -> Curve | None:
    """The curve with its start at a point; None if it would lie elsewhere."""
    moved = _with_end(curve.reversed(), point)
    return None if moved is None else moved.reversed()
