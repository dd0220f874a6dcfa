"""Closed chains moved outwards or inwards by the half width of a cut.

Lines move beside themselves, arcs change their radius. At a corner that opens, the lines are
prolonged until they meet (a mitre) or an arc about the corner joins them; at one that closes,
both curves are cut where they meet. What comes out is checked; where it is not a simple ring
at the right distance, the chain is flattened, offset as a polygon and its arcs found again.
"""

from collections.abc import Sequence
from math import cos, degrees, hypot, radians, sqrt

import numpy as np
from msgspec import Struct

from beamcam.geometry.conics import arc_between, direction_deg
from beamcam.geometry.curves import Arc, Curve, Line, signed_area
from beamcam.geometry.nesting import polygon_of
from beamcam.geometry.plane import Point, cross, distance, dot
from beamcam.geometry.refit import refit_ring
from beamcam.geometry.sampling import points_at

#: Corners sharper than this are rounded; their mitre would stand out by more than 2.5 times
#: the offset.
MITRE_LIMIT = 2.5

#: Distance from the original at which the flattened form stands for the exact one.
DEFAULT_TOLERANCE = 0.005


class Offset(Struct, frozen=True):
    """The moved chain; more than one if a narrow place closed."""

    chains: tuple[tuple[Curve, ...], ...]
    exact: bool  #: False where arcs were found again in a flattened form


class Vanished(Struct, frozen=True):
    """Nothing is left of a chain: it is narrower than twice the offset."""

    area: float  #: of the chain that was
    amount: float

    def __str__(self) -> str:
        return f"a contour of {self.area:.3f} mm2 vanishes when moved in by {-self.amount:g}"


def offset_chain(
    chain: Sequence[Curve], amount: float, tolerance: float = DEFAULT_TOLERANCE
) -> Offset | Vanished:
    """A closed chain moved by `amount` mm, outwards if above 0; its direction stays.

    Outer contours take +kerf / 2, holes -kerf / 2, by their depth, not by how they are drawn.
    Lines and arcs stay what they are. Chains with other curves, and those whose parts run into
    each other, come back as lines and arcs within `tolerance`.

    Raises ValueError for a chain that is not closed or has no area.
    """
    curves = tuple(chain)
    if not curves or distance(curves[-1].end, curves[0].start) > tolerance:
        raise ValueError("only a closed chain can be moved outwards or inwards")
    area = signed_area(curves)
    if area == 0.0:
        raise ValueError("a chain without area has no outside")
    if amount == 0.0:
        return Offset((curves,), True)
    # On a ring that runs counter-clockwise the outside is on the right.
    right = amount if area > 0 else -amount
    exact = _exact_offset(curves, right)
    if exact is not None and _is_right(curves, exact, amount, tolerance):
        return Offset((exact,), True)
    return _flattened_offset(curves, amount, tolerance)


def _exact_offset(curves: tuple[Curve, ...], right: float) -> tuple[Curve, ...] | None:
    """The ring of moved lines and arcs, joined at the corners; None if that cannot be."""
    moved: list[Line | Arc] = []
    for curve in curves:
        part = _beside(curve, right)
        if part is None:
            return None
        moved.append(part)
    if len(moved) == 1:
        return (moved[0],) if _is_whole(moved[0]) else None
    count = len(moved)
    cut_end: list[Point] = [m.end for m in moved]
    cut_start: list[Point] = [m.start for m in moved]
    joints: list[Arc | None] = [None] * count
    for k in range(count):
        a, b = moved[k], moved[(k + 1) % count]
        if distance(a.end, b.start) <= 1e-9 * (1 + abs(right)):
            cut_start[(k + 1) % count] = a.end
            continue
        corner = curves[k].end
        turn = cross(a.tangent(1.0), b.tangent(0.0))
        opens = turn * right > 0 or (turn == 0 and dot(a.tangent(1.0), b.tangent(0.0)) < 0)
        if not opens or (isinstance(a, Line) and isinstance(b, Line) and _is_blunt(a, b)):
            meet = _meeting(a, b, corner, opens)
            if meet is None:
                return None
            cut_end[k] = cut_start[(k + 1) % count] = meet
        else:
            joints[k] = arc_between(a.end, b.start, corner, right)
    ring: list[Curve] = []
    for part, start, end, joint in zip(moved, cut_start, cut_end, joints, strict=True):
        trimmed = _between(part, start, end)
        if trimmed is None:
            return None
        ring.append(trimmed)
        if joint is not None:
            ring.append(joint)
    return tuple(ring)


def _is_whole(curve: Line | Arc) -> bool:
    return isinstance(curve, Arc) and abs(curve.sweep_deg) == 360.0


def _beside(curve: Curve, right: float) -> Line | Arc | None:
    """A line or arc moved to its right; None for other curves and arcs that would vanish."""
    if isinstance(curve, Line):
        if curve.length == 0.0:
            return None
        ux, uy = curve.tangent(0.0)
        dx, dy = right * uy, -right * ux
        (x0, y0), (x1, y1) = curve.start, curve.end
        return Line((x0 + dx, y0 + dy), (x1 + dx, y1 + dy))
    if isinstance(curve, Arc):
        radius = curve.radius + (right if curve.sweep_deg > 0 else -right)
        if radius > 1e-9 * curve.radius:
            return Arc(curve.centre, radius, curve.start_deg, curve.sweep_deg)
    return None


def _is_blunt(a: Line, b: Line) -> bool:
    """Whether the mitre of two lines stays within the limit: 1 / cos(turn / 2)."""
    cosine = dot(a.tangent(1.0), b.tangent(0.0))
    return cosine > -1.0 and sqrt(2 / (1 + cosine)) <= MITRE_LIMIT


def _meeting(a: Line | Arc, b: Line | Arc, corner: Point, opens: bool) -> Point | None:
    """Where two curves meet, nearest to the corner; prolonged ones if it opens."""
    points = intersections(a, b)
    if not opens:
        points = [p for p in points if _between(a, a.start, p) and _between(b, p, b.end)]
    return min(points, key=lambda p: distance(p, corner), default=None)


def intersections(a: Line | Arc, b: Line | Arc) -> list[Point]:
    """Points where the whole lines or circles of two curves meet."""
    if isinstance(a, Line) and isinstance(b, Line):
        (ux, uy), (vx, vy) = a.tangent(0.0), b.tangent(0.0)
        det = cross((ux, uy), (vx, vy))
        if abs(det) < 1e-12:
            return []
        s = cross((b.start[0] - a.start[0], b.start[1] - a.start[1]), (vx, vy)) / det
        return [(a.start[0] + s * ux, a.start[1] + s * uy)]
    if isinstance(a, Arc) and isinstance(b, Line):
        a, b = b, a
    if isinstance(a, Line) and isinstance(b, Arc):
        ux, uy = a.tangent(0.0)
        to = (b.centre[0] - a.start[0], b.centre[1] - a.start[1])
        foot, away = dot((ux, uy), to), cross((ux, uy), to)
        if abs(away) > b.radius:
            return []
        half = sqrt(b.radius**2 - away**2)
        return [(a.start[0] + s * ux, a.start[1] + s * uy) for s in (foot - half, foot + half)]
    assert isinstance(a, Arc)
    assert isinstance(b, Arc)
    d = (b.centre[0] - a.centre[0], b.centre[1] - a.centre[1])
    gap = hypot(*d)
    if gap < 1e-12 or gap > a.radius + b.radius or gap < abs(a.radius - b.radius):
        return []
    along = (gap * gap + a.radius**2 - b.radius**2) / (2 * gap)
    height = sqrt(max(0.0, a.radius**2 - along**2))
    ux, uy = d[0] / gap, d[1] / gap
    x, y = a.centre[0] + along * ux, a.centre[1] + along * uy
    return [(x - h * uy, y + h * ux) for h in (height, -height)]


def _between(part: Line | Arc, start: Point, end: Point) -> Line | Arc | None:
    """The stretch of a line or circle between two of its points; None if it would run back."""
    if part.start == start and part.end == end:
        return part
    if isinstance(part, Line):
        step = (end[0] - start[0], end[1] - start[1])
        return Line(start, end) if dot(step, part.tangent(0.0)) > 0.0 else None
    sign = 1.0 if part.sweep_deg > 0 else -1.0
    angles = [direction_deg((p[0] - part.centre[0], p[1] - part.centre[1])) for p in (start, end)]
    sweep = (angles[1] - angles[0]) * sign % 360.0
    # Cutting shortens an arc; what then sweeps further has turned inside out.
    if sweep > abs(part.sweep_deg) + 1e-6 or sweep == 0.0:
        return None
    return Arc(part.centre, part.radius, angles[0], sign * sweep)


def _is_right(
    before: tuple[Curve, ...], after: tuple[Curve, ...], amount: float, tolerance: float
) -> bool:
    """Whether a moved ring is simple, on its side, and nowhere nearer than `amount`."""
    import shapely

    if signed_area(after) * signed_area(before) <= 0.0:
        return False
    old, new = (shapely.Polygon(polygon_of(c, 64)) for c in (before, after))
    if not new.is_valid or (new.area > old.area) != (amount > 0):
        return False
    # Polygons inscribed in arcs lie beside them; the check allows for that.
    bend = max(
        (c.radius * (1 - cos(radians(c.sweep_deg) / 128)) for c in before if isinstance(c, Arc)),
        default=0.0,
    )
    share = np.linspace(0.0, 1.0, 33)
    points = np.concatenate([points_at(c, share) for c in after])
    away = shapely.distance(shapely.points(points), old.exterior)
    return bool(np.min(away) >= abs(amount) - tolerance / 10 - bend)


def _flattened_offset(
    curves: tuple[Curve, ...], amount: float, tolerance: float
) -> Offset | Vanished:
    import shapely

    ring = np.concatenate([_flat(curve, tolerance / 8) for curve in curves])
    polygon = shapely.Polygon(ring)
    if not polygon.is_valid:
        polygon = polygon.buffer(0)
    # Joints between chords are smooth: a round join there keeps arcs round.
    quarter = max(8, int(90 / max(1.0, degrees(2 * sqrt(tolerance / 4 / abs(amount))))))
    moved = polygon.buffer(amount, quad_segs=quarter, join_style="mitre", mitre_limit=MITRE_LIMIT)
    parts = [p for p in getattr(moved, "geoms", [moved]) if p.area > tolerance * tolerance]
    if not parts:
        return Vanished(abs(signed_area(curves)), amount)
    turned = signed_area(curves) < 0
    chains = []
    for part in parts:
        for place, loop in enumerate((part.exterior, *part.interiors)):
            points = [(float(x), float(y)) for x, y in loop.coords[:-1]]
            fitted = refit_ring(points, tolerance / 4)
            backwards = (signed_area(fitted) < 0) != (turned != (place > 0))
            chains.append(tuple(c.reversed() for c in reversed(fitted)) if backwards else fitted)
    return Offset(tuple(chains), False)


def _flat(curve: Curve, tolerance: float) -> "np.ndarray[tuple[int, int], np.dtype[np.float64]]":
    """Points of a curve without its end; chords within `tolerance`, measured by doubling."""
    count = 1
    if not isinstance(curve, Line):
        count = 8
        while count < 4096:
            fine = points_at(curve, np.linspace(0.0, 1.0, 2 * count + 1))
            sag = fine[1::2] - (fine[:-1:2] + fine[2::2]) / 2
            if np.max(np.hypot(sag[:, 0], sag[:, 1])) <= tolerance:
                break
            count *= 2
    return points_at(curve, np.linspace(0.0, 1.0, count + 1))[:-1]
