"""Section of an outline, by its geometry alone."""

from collections.abc import Sequence
from math import hypot

from beamcam.geometry.curves import Point, signed_area
from beamcam.geometry.plane import Box, box_around
from beamcam.model.part import ProfileCode
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.outline import Corner, Round, corners_of, shape_of, with_arcs
from beamcam.readers.ifc.section import SQUARE, Section, placed, special


def classify(outer: Chain, inner: Sequence[Chain] = ()) -> Section | None:
    """The section of an outline by its geometry alone; a special one (SO) if its form is unknown.

    None where it has more than one hollow, or a hollow that is not a wall's.
    """
    area = abs(signed_area(outer)) - sum(abs(signed_area(c)) for c in inner)
    if len(inner) > 1:
        return None
    curves = with_arcs(outer)
    shape = shape_of(curves)
    if isinstance(shape, Round):
        return _round(shape, inner, area)
    corners = corners_of(curves)
    if inner:
        return _tube(corners, inner[0], area)
    found = _open(corners, area) if corners is not None else None
    return found or special(outer, area)


def _round(shape: Round, inner: Sequence[Chain], area: float) -> Section | None:
    d = shape.diameter
    if not inner:
        return placed("RU", (d, d, 0.0, d, 0.0), shape.centre, (0.0, 1.0), (1.0, 0.0), area)
    bore = shape_of(inner[0])
    if not isinstance(bore, Round):
        return None
    apart = hypot(bore.centre[0] - shape.centre[0], bore.centre[1] - shape.centre[1])
    wall = (d - bore.diameter) / 2
    if apart > 0.1 * wall or wall <= 0:
        return None
    return placed("RO", (d, d, wall, wall, 0.0), shape.centre, (0.0, 1.0), (1.0, 0.0), area)


def _tube(corners: tuple[Corner, ...] | None, inner: Chain, area: float) -> Section | None:
    bore = corners_of(with_arcs(inner))
    if corners is None or bore is None or len(corners) != 4 or len(bore) != 4:
        return None
    outside, inside = _box(corners), _box(bore)
    if outside is None or inside is None:
        return None
    (centre, y, z, h, b), (_, y2, _, h2, b2) = outside, inside
    if abs(y[0] * y2[1] - y[1] * y2[0]) > SQUARE:
        h2, b2 = b2, h2
    walls = (h - h2) / 2, (b - b2) / 2
    if min(walls) <= 0 or abs(walls[0] - walls[1]) > 0.3:
        return None
    radius = max(c.radius for c in corners)
    return placed("M", (h, b, walls[0], walls[1], radius), centre, y, z, area)


def _box(corners: tuple[Corner, ...]) -> tuple[Point, Point, Point, float, float] | None:
    """Centre, directions and sides of a rectangle, the longer side as Y; of equals, the upright."""
    p = [c.at for c in corners]
    first, second = _between(p[0], p[1]), _between(p[1], p[2])
    a, b = hypot(*first), hypot(*second)
    if abs(first[0] * second[0] + first[1] * second[1]) > SQUARE * a * b:
        return None
    third = _between(p[2], p[3])
    if abs(hypot(*third) - a) > 0.2:
        return None
    centre = (sum(q[0] for q in p) / 4, sum(q[1] for q in p) / 4)
    u, v = (first[0] / a, first[1] / a), (second[0] / b, second[1] / b)
    upright = abs(u[1]) >= abs(v[1])
    if a > b + 0.01 or (abs(a - b) <= 0.01 and upright):
        return centre, _upward(u), _rightward(v), a, b
    return centre, _upward(v), _rightward(u), b, a


def _between(a: Point, b: Point) -> Point:
    return b[0] - a[0], b[1] - a[1]


def _upward(v: Point) -> Point:
    return v if v[1] > 1e-9 or (abs(v[1]) <= 1e-9 and v[0] > 0) else (-v[0], -v[1])


def _rightward(v: Point) -> Point:
    return v if v[0] > 1e-9 or (abs(v[0]) <= 1e-9 and v[1] > 0) else (-v[0], -v[1])


def _open(corners: tuple[Corner, ...], area: float) -> Section | None:
    """I, U, C, T, L or a rectangle by the pattern of outer and inner corners."""
    reflex = [i for i, c in enumerate(corners) if c.reflex]
    n = len(corners)
    gaps = [(b - a) % n for a, b in zip(reflex, reflex[1:] + reflex[:1], strict=True)]
    if n == 4 and not reflex:
        box = _box(corners)
        if box is None:
            return None
        centre, y, z, h, b = box
        # Roundings that are not alike are bevels of single edges.
        radii = [c.radius for c in corners]
        radius = max(radii) if max(radii) - min(radii) <= 0.1 * max(radii) else 0.0
        return placed("B", (h, b, 0.0, b, radius), centre, y, z, area)
    if n == 6 and len(reflex) == 1:
        return _angle(corners, reflex[0], area)
    if n == 8 and sorted(gaps) == [1, 7]:
        return _channel(corners, reflex, gaps, area)
    if n == 8 and sorted(gaps) == [3, 5]:
        return _tee(corners, reflex, gaps, area)
    if n == 12 and sorted(gaps) == [1, 1, 5, 5]:
        return _double_tee(corners, reflex, gaps, area)
    if n == 12 and sorted(gaps) == [1, 1, 1, 9]:
        return _lipped(corners, reflex, gaps, area)
    return None


def _local(corners: Sequence[Corner], y: Point) -> tuple[list[Point], Point]:
    """The corners along (Z, Y) for a given Y, and the direction Z to its right."""
    z = (y[1], -y[0])
    return [(c.at[0] * z[0] + c.at[1] * z[1], c.at[0] * y[0] + c.at[1] * y[1]) for c in corners], z


def _direction(a: Corner, b: Corner) -> Point:
    x, y = _between(a.at, b.at)
    by = hypot(x, y)
    return x / by, y / by


def _centred(
    code: ProfileCode, box: Box, y: Point, z: Point, sizes: tuple[float, float, float], area: float
) -> Section:
    """A section that fills a box along Z and Y; flange, web and radius are `sizes`."""
    x0, y0, x1, y1 = box
    u, v = (x0 + x1) / 2, (y0 + y1) / 2
    centre = z[0] * u + y[0] * v, z[1] * u + y[1] * v
    return placed(code, (y1 - y0, x1 - x0, *sizes), centre, y, z, area)


def _double_tee(
    corners: tuple[Corner, ...], reflex: list[int], gaps: list[int], area: float
) -> Section | None:
    pairs = [(reflex[i], (reflex[i] + 1) % 12) for i, g in enumerate(gaps) if g == 1]
    y = _upward(_direction(corners[pairs[0][0]], corners[pairs[0][1]]))
    points, z = _local(corners, y)
    sides = sorted((points[a][0] + points[b][0]) / 2 for a, b in pairs)
    inner = [c.reflex for c in corners]
    tips = [i for i in range(12) if not inner[i] and (inner[i - 1] or inner[(i + 1) % 12])]
    x0, bottom, x1, top = box = box_around(points)
    middle = (top + bottom) / 2
    upper = [points[i][1] for i in (*reflex, *tips) if points[i][1] > middle]
    lower = [points[i][1] for i in (*reflex, *tips) if points[i][1] <= middle]
    if len(upper) != 4 or len(lower) != 4:
        return None
    flanges = top - sum(upper) / 4, sum(lower) / 4 - bottom
    widths = [high - low for low, high in _reaches(points, middle)]
    centre = sum(sides) / 2 - (x1 + x0) / 2
    if abs(flanges[0] - flanges[1]) > 0.2 or abs(widths[0] - widths[1]) > 0.2 or abs(centre) > 0.2:
        return None
    radius = max(corners[i].radius for i in reflex)
    return _centred("I", box, y, z, (sum(flanges) / 2, sides[1] - sides[0], radius), area)


def _reaches(points: Sequence[Point], middle: float) -> list[tuple[float, float]]:
    """Least and greatest Z of the points above the middle, and of those below it."""
    halves = [p[0] for p in points if p[1] > middle], [p[0] for p in points if p[1] <= middle]
    return [(min(half), max(half)) for half in halves]


def _channel(
    corners: tuple[Corner, ...], reflex: list[int], gaps: list[int], area: float
) -> Section | None:
    first = reflex[gaps.index(1)]
    second = (first + 1) % 8
    # Counter-clockwise round the outline the inside of the web runs upwards.
    y = _direction(corners[first], corners[second])
    points, z = _local(corners, y)
    x0, bottom, x1, top = box = box_around(points)
    web = (points[first][0] + points[second][0]) / 2 - x0
    tips = (points[(second + 1) % 8][1], points[first - 1][1])
    # Sloped flanges have their nominal thickness half way from the web's back to the tip.
    width = x1 - x0
    share = (width / 2 - web) / (width - web) if width > web else 0.5
    roots = points[second][1], points[first][1]
    inner_faces = [root + (tip - root) * share for root, tip in zip(roots, tips, strict=True)]
    flanges = top - inner_faces[0], inner_faces[1] - bottom
    if web <= 0 or min(flanges) <= 0 or abs(flanges[0] - flanges[1]) > 0.2:
        return None
    (_, upper), (_, lower) = _reaches(points, (top + bottom) / 2)
    if abs(upper - lower) > 0.2:
        return None
    return _centred("U", box, y, z, (sum(flanges) / 2, web, corners[first].radius), area)


def _lipped(
    corners: tuple[Corner, ...], reflex: list[int], gaps: list[int], area: float
) -> Section | None:
    start = reflex[(gaps.index(9) + 1) % 4]  # the inner corners follow one another from here
    first, second = (start + 1) % 12, (start + 2) % 12
    y = _direction(corners[first], corners[second])
    points, z = _local(corners, y)
    x0, bottom, *_ = box = box_around(points)
    web = (points[first][0] + points[second][0]) / 2 - x0
    flange = points[first][1] - bottom
    if web <= 0 or flange <= 0:
        return None
    return _centred("C", box, y, z, (flange, web, corners[first].radius), area)


def _tee(
    corners: tuple[Corner, ...], reflex: list[int], gaps: list[int], area: float
) -> Section | None:
    # Five steps round the flange and three round the stem, counter-clockwise.
    after_stem = reflex[gaps.index(5)]
    before_stem = (after_stem + 5) % 8
    tip = (before_stem + 1) % 8, (before_stem + 2) % 8
    z0 = _direction(corners[before_stem], corners[tip[0]])
    y = (-z0[1], z0[0])
    points, z = _local(corners, y)
    box = box_around(points)
    flange = (points[after_stem][0] + points[before_stem][0]) / 2 - box[0]
    stem = abs(points[tip[0]][1] - points[tip[1]][1])
    if flange <= 0 or stem <= 0:
        return None
    return _centred("T", box, y, z, (stem, flange, corners[before_stem].radius), area)


def _angle(corners: tuple[Corner, ...], inner: int, area: float) -> Section | None:
    heel = corners[(inner + 3) % 6]
    one, other = corners[(inner + 2) % 6], corners[(inner + 4) % 6]
    legs = sorted((one, other), key=lambda c: -hypot(*_between(heel.at, c.at)))
    y, z = (_direction(heel, leg) for leg in legs)
    if abs(y[0] * z[0] + y[1] * z[1]) > SQUARE:
        return None
    h, b = (hypot(*_between(heel.at, leg.at)) for leg in legs)
    corner = _between(heel.at, corners[inner].at)
    web = corner[0] * z[0] + corner[1] * z[1]
    flange = corner[0] * y[0] + corner[1] * y[1]
    if min(web, flange) <= 0 or web > b or flange > h:
        return None
    radius = corners[inner].radius
    found = Section("L", h, b, flange, web, radius, heel.at, y, z, area)
    return found.right_way()
