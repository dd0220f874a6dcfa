"""What a drawing holds beside its contours, and the extent of curves.

Filled shapes and curves on hidden layers are no features, since nothing is cut along them; they
are kept so that their lengths can be told when somebody asks.
"""

from collections.abc import Iterable

from msgspec import Struct

from beamcam.geometry.curves import Arc, Bezier, BSpline, Curve, Line
from beamcam.geometry.plane import Box, Point, box_around
from beamcam.model.lengths import total_length


class Measures(Struct, frozen=True):
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

    An arc lies inside the box around its circle and a free curve inside the hull of its control
    points, so that their turning points are looked for only where these reach beyond the box that
    is known already.
    """
    points: list[Point] = []
    arcs: list[Arc] = []
    free: list[Bezier | BSpline] = []
    for curve in curves:
        if isinstance(curve, Line):
            points += (curve.start, curve.end)
        elif isinstance(curve, Arc):
            arcs.append(curve)
        elif isinstance(curve, Bezier | BSpline):
            free.append(curve)
            points += (curve.start, curve.end)
        else:
            x0, y0, x1, y1 = curve.bbox
            points += ((x0, y0), (x1, y1))
    box = box_around(points) if points else None
    for arc in arcs:
        (x, y), r = arc.centre, arc.radius
        if not _holds(box, (x - r, y - r, x + r, y + r)):
            box = _joined(box, arc.bbox)
    for curve in free:
        hull = box_around(curve.points if isinstance(curve, Bezier) else curve.control)
        if not _holds(box, hull):
            box = _joined(box, curve.bbox)
    return box


def _holds(box: Box | None, other: Box) -> bool:
    if box is None:
        return False
    low = box[0] <= other[0] and box[1] <= other[1]
    return low and other[2] <= box[2] and other[3] <= box[3]


def _joined(first: Box | None, second: Box) -> Box:
    if first is None:
        return second
    return (
        min(first[0], second[0]),
        min(first[1], second[1]),
        max(first[2], second[2]),
        max(first[3], second[3]),
    )
