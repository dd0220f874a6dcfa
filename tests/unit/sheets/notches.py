"""Plates with a notch beside a needle of the part, and what a program leaves of the waste in it.

                               The beam passes the tip of the needle on both sides. What it
_________      _               leaves in the notch is near the path behind the needle, which
         \\    | |    outside   does not cut it.
          \\   | |
           \\  | |_________
            \\ |
part         \\|       part
"""

import re
from math import atan, atan2, cos, degrees, hypot, pi, sin

import numpy as np
import shapely
from msgspec import Struct
from shapely.geometry.base import BaseGeometry

from beamcam.geometry.curves import Arc, Bezier, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.geometry.polylines import points_at
from beamcam.model.part import Part
from tests.unit.sheets.parts import box, contour, drawing, lines

MARGIN = 10.0  #: of plate-linuxcnc, to whose corner the drawing is moved
FINE = 0.02  #: what a path may be off
FRAME = shapely.box(-20, -20, 80, 90)


class Notch(Struct, frozen=True):
    """A notch, wide at its mouth and with walls of one kind that bow to the left."""

    mouth: float
    depth: float
    tip: float  #: width of the needle's tip
    walls: str = "lines"
    bow: float = 0.0  #: of the walls, by the depth
    is_hole: bool = False  #: drawn as a hole of a plate, the needle in it
    mirrored: bool = False

    def rings(self) -> list[tuple[Curve, ...]]:
        """The contours of the part, each closed."""
        m, t = self.mouth, self.tip
        left, apex, right = (25 - m, 40.0), (25 - m / 2, 40 - self.depth), (25.0, 40.0)
        top = [
            Line((0, 40), left), self._wall(left, apex), self._wall(apex, right),
            *lines(right, (25 + t, 40), (25 + t, 20), (50, 20), closed=False),
        ]  # fmt: skip
        far = 60.0 if self.is_hole else 0.0
        ring = (*top, *lines((50, 20), (50, far), (0, far), (0, 40), closed=False))
        rings = [ring, box(-10, -10, 70, 80)] if self.is_hole else [ring]
        return [tuple(map(_mirrored, one)) for one in rings] if self.mirrored else rings

    def _wall(self, a: Point, b: Point) -> Curve:
        bow = self.bow * self.depth
        if self.walls == "lines" or bow < 1e-3:
            return Line(a, b)
        if self.walls == "curves":
            (x0, y0), (x1, y1) = a, b
            y = (y1 - y0) / 3
            return Bezier((a, (x0 - bow, y0 + y), (x1 - bow, y1 - y), b))
        down = b[1] < a[1]
        return _arc(a, b, 0.75 * bow, 1.0 if down else -1.0)

    def part(self) -> Part:
        return drawing(*map(contour, self.rings()), thickness=8.0)

    def steel(self) -> BaseGeometry:
        """The part as a polygon."""
        rings = [
            shapely.Polygon(np.concatenate([points_at(c, np.linspace(0, 1, 65)[:-1]) for c in one]))
            for one in self.rings()
        ]
        return shapely.difference(rings[1], rings[0]) if self.is_hole else rings[0]


def _mirrored(curve: Curve) -> Curve:
    if isinstance(curve, Arc):
        (x, y), start = curve.centre, 180.0 - curve.start_deg
        return Arc((50 - x, y), curve.radius, start, -curve.sweep_deg)
    if isinstance(curve, Bezier):
        return Bezier(tuple((50 - x, y) for x, y in curve.points))
    assert isinstance(curve, Line)
    return Line((50 - curve.start[0], curve.start[1]), (50 - curve.end[0], curve.end[1]))


def _arc(a: Point, b: Point, rise: float, turn: float) -> Arc:
    """The arc from a to b whose middle lies `rise` beside the chord, counter-clockwise for 1."""
    half = hypot(b[0] - a[0], b[1] - a[1]) / 2
    radius = (half * half + rise * rise) / (2 * rise)
    along = atan2(b[1] - a[1], b[0] - a[0])
    aside = along + turn * pi / 2
    x = (a[0] + b[0]) / 2 + (radius - rise) * cos(aside)
    y = (a[1] + b[1]) / 2 + (radius - rise) * sin(aside)
    start = degrees(atan2(a[1] - y, a[0] - x))
    return Arc((x, y), radius, start, turn * degrees(4 * atan(rise / half)))


def strokes(text: str) -> list[shapely.LineString]:
    """What the torch follows in a program, in the coordinates of the drawing."""
    found: list[list[Point]] = []
    here, on = (0.0, 0.0), False
    for line in text.splitlines():
        words = {w[0]: float(w[1:]) for w in re.findall(r"[A-Z][-\d.]+", line)}
        if line.startswith(("M3", "M5")):
            on = line.startswith("M3")
            found += [[here]] if on else []
        elif "X" in words:
            way = [(words["X"], words["Y"])]
            if "I" in words:
                way = _turn(here, way[0], (words["I"], words["J"]), words["G"] == 3.0)
            here = way[-1]
            if on:
                found[-1] += way
    return [shapely.LineString(points) for points in found]


def _turn(a: Point, b: Point, to_centre: Point, ccw: bool) -> list[Point]:
    centre = np.array(a) + np.array(to_centre)
    first, last = (atan2(p[1] - centre[1], p[0] - centre[0]) for p in (a, b))
    sweep = (last - first) % (2 * pi) if ccw else -((first - last) % (2 * pi))
    radius = hypot(*to_centre)
    angles = first + sweep * np.linspace(0, 1, 65)[1:]
    way = centre + radius * np.column_stack((np.cos(angles), np.sin(angles)))
    return [(float(x), float(y)) for x, y in (*way[:-1], b)]


def left_by(steel: BaseGeometry, taken: BaseGeometry) -> float:
    """How deep at most the waste is that stays on the steel, measured to where it was cut."""
    rest = shapely.get_parts(shapely.difference(shapely.difference(FRAME, steel), taken))
    deepest = 0.0
    for piece in rest[shapely.area(rest) > 1e-2].tolist():
        if piece.distance(steel) > 1e-6 or piece.intersects(FRAME.exterior):
            continue  # it falls out, or is what is left of the sheet
        mouth = shapely.intersection(taken, piece.buffer(1e-3))
        places = shapely.points(shapely.get_coordinates(shapely.segmentize(piece, 0.1)))
        deepest = max(deepest, float(shapely.distance(places, mouth).max()))
    return deepest


def left_in_program(steel: BaseGeometry, text: str, kerf: float) -> float:
    """`left_by` of what a program's beam takes away."""
    low = steel.bounds[:2]
    ways = [shapely.transform(w, lambda p: p - MARGIN + np.array(low)) for w in strokes(text)]
    return left_by(steel, shapely.union_all(shapely.buffer(ways, kerf / 2 + FINE, quad_segs=64)))


def left_at_best(steel: BaseGeometry, kerf: float) -> float:
    """`left_by` of all that a disc of the kerf's width covers which stays in the waste."""
    waste = shapely.difference(FRAME.buffer(5), steel)
    middles = waste.buffer(-kerf / 2, quad_segs=64)
    return left_by(steel, middles.buffer(kerf / 2 + 1e-4, quad_segs=64))
