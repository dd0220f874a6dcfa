"""What a drawing holds beside its contours, and the extent of curves.

Filled shapes and curves on hidden layers are no features, since nothing is cut along them; they
are kept so that their lengths can be told when somebody asks.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from beamcam.geometry.curves import Bezier, BSpline, Curve, bezier_pieces
from beamcam.geometry.plane import Box, Point
from beamcam.model.lengths import total_length


@dataclass(frozen=True, slots=True)
class Measures:
    """What was seen in a drawing and becomes no feature of the part."""

    filled: tuple[Curve, ...] = ()  #: outlines of shapes with a fill and no stroke
    hidden: tuple[Curve, ...] = ()  #: curves on layers that are off, frozen or not plotting
    not_cut: tuple[tuple[str, int], ...] = ()  #: entities that are no curves, by name: how many
    grid: float | None = None  #: what coordinates are rounded to, if the file shows it

    @property
    def filled_length(self) -> float:
        """Length of `filled`."""
        return total_length(self.filled)

    @property
    def hidden_length(self) -> float:
        """Length of `hidden`."""
        return total_length(self.hidden)


def extent(curves: Iterable[Curve]) -> Box | None:
    """The least box around all curves; None if there are none.

    A free curve lies inside the hull of its control points, so that its turning points are
    looked for only where the hull reaches beyond the box that is known already.
    """
    free: list[Bezier] = []
    boxes: list[Box] = []
    for curve in curves:
        if isinstance(curve, Bezier | BSpline):
            free.extend(bezier_pieces(curve))
        else:
            boxes.append(curve.bbox)
    points: list[Point] = [point for box in boxes for point in (box[:2], box[2:])]
    for curve in free:
        points += (curve.start, curve.end)
    if not points:
        return None
    x0, x1 = min(p[0] for p in points), max(p[0] for p in points)
    y0, y1 = min(p[1] for p in points), max(p[1] for p in points)
    for curve in free:
        if all(x0 <= x <= x1 and y0 <= y <= y1 for x, y in curve.points):
            continue
        left, low, right, high = curve.bbox
        x0, y0, x1, y1 = min(x0, left), min(y0, low), max(x1, right), max(y1, high)
    return x0, y0, x1, y1
