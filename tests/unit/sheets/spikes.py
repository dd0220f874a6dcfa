"""Closed chains with a spike at a joint: out along one curve, back along almost the same one."""

from math import atan, atan2, cos, degrees, hypot, radians, sin

import numpy as np
import shapely
from msgspec import Struct
from shapely.geometry.base import BaseGeometry

from beamcam.geometry.curves import Arc, Bezier, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.geometry.polylines import points_at
from beamcam.model.part import Part
from tests.swept_band import QUADRANT, Drawn, Measured
from tests.unit.sheets.notches import MARGIN, strokes
from tests.unit.sheets.parts import box, contour, drawing

CORNERS = ((0.0, 0.0), (40.0, 6.0), (47.0, 42.0), (-4.0, 35.0))
AT = 2  #: the corner with the spike
CHORDS = 129  #: places of a curve that stand for it


class Spike(Struct, frozen=True):
    """A four-sided contour, and what sticks out of its corner, or into it."""

    sides: tuple[str, ...]  #: kind of each side
    bows: tuple[float, ...]  #: how far each side bows out, by its length
    heading_deg: float
    length: float
    kinds: tuple[str, str]  #: of the way out and the way back
    bow: float = 0.0  #: of both ways, by their length
    apart: float = 0.0  #: mm between both ways in their middle
    gap: float = 0.0  #: mm between where the one begins and the other ends
    is_hole: bool = False
    reversed: bool = False

    def ring(self) -> tuple[Curve, ...]:
        """The curves, one behind the other."""
        u = np.array((cos(radians(self.heading_deg)), sin(radians(self.heading_deg))))
        p = np.array(CORNERS[AT])
        tip, back = p + self.length * u, p + self.gap * np.array((-u[1], u[0]))
        bow = self.bow * self.length
        found = []
        for k, kind in enumerate(self.sides):
            a, b = (np.array(CORNERS[n % 4]) for n in (k, k + 1))
            if k == AT:
                out, home = self.kinds
                found += [_curve(out, p, tip, bow), _curve(home, tip, back, self.apart - bow)]
                a = back
            found.append(_curve(kind, a, b, -self.bows[k] * float(np.hypot(*(b - a)))))
        return tuple(c.reversed() for c in found[::-1]) if self.reversed else tuple(found)

    def rings(self) -> list[tuple[Curve, ...]]:
        """It, with the plate around it if it is a hole."""
        return [self.ring(), box(-30, -30, 110, 110)] if self.is_hole else [self.ring()]

    def part(self) -> Part:
        return drawing(*map(contour, self.rings()), thickness=8.0)


def _curve(kind: str, a: np.ndarray, b: np.ndarray, bow: float) -> Curve:
    """From a to b, left of the straight way by `bow` in its middle."""
    start, end = (float(a[0]), float(a[1])), (float(b[0]), float(b[1]))
    if kind == "line" or (kind == "arc" and abs(bow) < 1e-9):
        return Line(start, end)
    if kind == "arc":
        return _arc(start, end, bow)
    aside = bow * np.array((a[1] - b[1], b[0] - a[0])) / np.hypot(*(b - a))
    if kind == "quadratic":
        return Bezier((start, _point((a + b) / 2 + 2 * aside), end))
    thirds = [_point(a + share * (b - a) + 4 / 3 * aside) for share in (1 / 3, 2 / 3)]
    return Bezier((start, *thirds, end))


def _arc(a: Point, b: Point, bow: float) -> Arc:
    half = hypot(b[0] - a[0], b[1] - a[1]) / 2
    to_centre = (half * half - bow * bow) / (2 * bow)
    x = (a[0] + b[0]) / 2 - to_centre * (a[1] - b[1]) / (2 * half)
    y = (a[1] + b[1]) / 2 - to_centre * (b[0] - a[0]) / (2 * half)
    start = degrees(atan2(a[1] - y, a[0] - x))
    return Arc((x, y), hypot(a[0] - x, a[1] - y), start, -degrees(4 * atan(bow / half)))


def _point(place: np.ndarray) -> Point:
    return float(place[0]), float(place[1])


class Spiked(Measured):
    """A cut sheet, of which spikes without area keep the beam off too."""

    def uncut(self, by: float) -> float:
        part, radius = self.drawn.part(), self.kerf / 2
        edges = shapely.buffer(
            shapely.get_exterior_ring(self.drawn.rings), radius, quad_segs=QUADRANT
        )
        middles = self._sheet().difference(part).difference(shapely.union_all(edges))
        left = part.boundary.difference(self.band(by))
        return float(left.intersection(middles.buffer(radius, quad_segs=QUADRANT)).length)


def cut(spike: Spike, text: str, kerf: float) -> Spiked:
    """What a program makes of a spiked contour."""
    rings: list[BaseGeometry] = [shapely.Polygon(_outline(ring)) for ring in spike.rings()]
    low = shapely.total_bounds(rings)[:2]
    placed = [shapely.transform(ring, lambda p: p - low + MARGIN) for ring in rings]
    return Spiked(strokes(text), Drawn(placed, []), kerf)


def _outline(ring: tuple[Curve, ...]) -> np.ndarray:
    counts = [2 if isinstance(curve, Line) else CHORDS for curve in ring]
    return np.concatenate(
        [points_at(c, np.linspace(0.0, 1.0, n)) for c, n in zip(ring, counts, strict=True)]
    )
